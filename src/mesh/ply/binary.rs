//! The body of a binary PLY file.

use super::super::decimal::whole;
use super::super::error::{Fault, MeshError, Position};
use super::super::source::Source;
use super::super::surface::{Surface, corner_count};
use super::{Body, Element, Endian, Kind, Property, Scalar, VertexLayout, VertexRecord, Vertices};
use super::{LEAST_CORNERS, Strip, UNUSED};
use super::{checked_index, end_strip, list_length, strip_corner};

const INDEX: &str = "the index of a vertex";

/// The bytes that are left.
pub(super) struct Bytes<'r> {
    source: Source<'r>,
    endian: Endian,
}

/// Some of them.
struct Window<'a> {
    bytes: &'a [u8],
    position: usize,
    endian: Endian,
}

/// Why reading elements stopped.
struct Stop {
    fault: Box<Fault>,
    /// How many elements were read before.
    after: usize,
}

impl From<Box<Fault>> for Stop {
    fn from(fault: Box<Fault>) -> Self {
        Self { fault, after: 0 }
    }
}

/// A list as its bytes.
struct List<'a> {
    length: i64,
    /// Where its length stands.
    start: usize,
    item: Scalar,
    /// Empty where the length is negative.
    items: &'a [u8],
}

impl<'a> Window<'a> {
    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.position..]
    }

    #[inline]
    fn take(&mut self, length: usize, expected: &'static str) -> Result<&'a [u8], Box<Fault>> {
        let Some(taken) = self.rest().get(..length) else {
            return Err(Box::new(Fault::FileEnds { expected }));
        };
        self.position += length;
        Ok(taken)
    }

    #[inline]
    fn list(&mut self, length: Scalar, item: Scalar) -> Result<List<'a>, Box<Fault>> {
        let start = self.position;
        let bytes = self.take(length.size(), "the length of a list")?;
        let length = length
            .integer(bytes, self.endian, "the length of a list")
            .inspect_err(|_| self.position = start)?;
        let bytes = usize::try_from(length)
            .unwrap_or(0)
            .saturating_mul(item.size());
        Ok(List {
            length,
            start,
            item,
            items: self.take(bytes, "the items of a list")?,
        })
    }

    fn skip_property(&mut self, kind: Kind) -> Result<(), Box<Fault>> {
        match kind {
            Kind::Scalar(scalar) => self.take(scalar.size(), "a value")?,
            Kind::List { length, item } => {
                let list = self.list(length, item)?;
                list_length(list.length).inspect_err(|_| self.position = list.start)?;
                list.items
            }
        };
        Ok(())
    }

    /// Vertices of a fixed size, `fields` being where their values are in it: as many as are here
    /// whole; how many.
    fn fixed_vertices(
        &mut self,
        stride: usize,
        left: usize,
        fields: &VertexFields,
        mesh: &mut Vertices,
    ) -> Result<usize, Stop> {
        let start = self.position;
        let (records, count) = self.records(stride, left)?;
        let endian = self.endian;
        let read = |place: usize| {
            let Field { offset, scalar } = fields.0[place];
            move |record: &[u8]| scalar.float(&record[offset..offset + scalar.size()], endian)
        };
        let single = |place: usize| {
            let offset = fields.0[place].offset;
            move |record: &[u8]| f64::from(f32::from_le_bytes(fixed(&record[offset..offset + 4])))
        };
        let all_single = (fields.0.iter()).all(|field| field.scalar == Scalar::F32);
        let pushed = match (all_single && endian == Endian::Little, fields.0.len()) {
            (true, 3) => push_all(records, stride, mesh, &[0, 1, 2].map(single)),
            (true, _) => push_all(records, stride, mesh, &[0, 1, 2, 3, 4, 5].map(single)),
            (false, 3) => push_all(records, stride, mesh, &[0, 1, 2].map(read)),
            (false, _) => push_all(records, stride, mesh, &[0, 1, 2, 3, 4, 5].map(read)),
        };
        if let Err(stop) = pushed {
            self.position = start + stop.after * stride;
            return Err(stop);
        }
        Ok(count)
    }

    /// The records of a fixed size that are here whole, at most `left`; how many. None is a fault.
    fn records(&mut self, stride: usize, left: usize) -> Result<(&'a [u8], usize), Stop> {
        let count = left.min(self.rest().len() / stride);
        if count == 0 {
            return Err(Stop::from(Box::new(Fault::FileEnds {
                expected: "the values of all elements that the header counts",
            })));
        }
        let records = &self.rest()[..count * stride];
        self.position += records.len();
        Ok((records, count))
    }

    /// Faces whose only property is a list of 32-bit indices with an 8-bit length, little
    /// endian, as nearly all files have them: reads triangles up to the first other face or the
    /// first fault; how many.
    fn usual_triangles(&mut self, count: usize, surface: &mut Surface) -> usize {
        /// The length and three indices.
        const TRIANGLE: usize = 13;
        let vertices = surface.positions.len();
        let room = surface.triangles.capacity() - surface.triangles.len();
        let mut read = 0;
        for record in self.rest().chunks_exact(TRIANGLE).take(count.min(room)) {
            let index = |i: usize| u32::from_le_bytes(fixed(&record[1 + 4 * i..5 + 4 * i]));
            let corners = [index(0), index(1), index(2)];
            if record[0] != 3 || corners.iter().any(|&corner| corner as usize >= vertices) {
                break;
            }
            surface.triangles.push(corners);
            read += 1;
        }
        self.position += read * TRIANGLE;
        read
    }
}

/// Where a value is in a record of fixed size.
#[derive(Clone, Copy, Debug)]
struct Field {
    offset: usize,
    scalar: Scalar,
}

/// Where x, y, z and, if the vertices have normals, nx, ny, nz are.
#[derive(Debug)]
struct VertexFields(Vec<Field>);

impl VertexFields {
    fn new(element: &Element<'_>, layout: &VertexLayout) -> Self {
        let count = if layout.has_normals { 6 } else { 3 };
        let mut fields = vec![
            Field {
                offset: 0,
                scalar: Scalar::F32
            };
            count
        ];
        let mut offset = 0;
        for (property, &place) in element.properties.iter().zip(&layout.places) {
            if let (Kind::Scalar(scalar), Some(field)) = (property.kind, fields.get_mut(place)) {
                *field = Field { offset, scalar };
            }
            offset += property.least_size();
        }
        Self(fields)
    }
}

/// Reads vertices of three or six `fields`; up to the first fault.
fn push_all<const N: usize>(
    records: &[u8],
    stride: usize,
    mesh: &mut Vertices,
    fields: &[impl Fn(&[u8]) -> f64; N],
) -> Result<(), Stop> {
    let mut vertex: VertexRecord = [0.0; UNUSED + 1];
    for (index, record) in records.chunks_exact(stride).enumerate() {
        for (value, field) in vertex.iter_mut().zip(fields) {
            *value = field(record);
        }
        mesh.push(&vertex, N > 3).map_err(|fault| Stop {
            fault,
            after: index,
        })?;
    }
    Ok(())
}

impl<'r> Bytes<'r> {
    /// The bytes from the start of the source's window on.
    pub(super) const fn new(source: Source<'r>, endian: Endian) -> Self {
        Self { source, endian }
    }

    /// Calls `some` until it has read all of the elements; it is told how many are left, and says how
    /// many it has read. What does not fit in the window is read again with more of the file.
    fn each(
        &mut self,
        element: &Element<'_>,
        mut some: impl FnMut(&mut Window<'_>, usize) -> Result<usize, Stop>,
    ) -> Result<(), MeshError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        let mut index = 0;
        loop {
            let mut window = Window {
                bytes: self.source.window(),
                position: 0,
                endian: self.endian,
            };
            let mut done = 0;
            let mut stop = None;
            while stop.is_none() && index < element.count {
                let left = usize::try_from(element.count - index).unwrap_or(usize::MAX);
                match some(&mut window, left) {
                    Ok(count) => {
                        index += count as u64;
                        done = window.position;
                    }
                    Err(at) => stop = Some(at),
                }
            }
            let position = window.position;
            let Some(Stop { fault, after }) = stop else {
                self.source.skip(done);
                return Ok(());
            };
            let is_cut_off = matches!(*fault, Fault::FileEnds { .. });
            if !is_cut_off || self.source.has_ended() {
                let position = Position::Byte(self.source.position() + position);
                return Err(fault.at(position, element.place(index + after as u64)));
            }
            self.source.skip(done);
            self.source.read_on()?;
        }
    }

    /// How many of the elements can be there at most.
    fn at_most(&self, element: &Element<'_>) -> usize {
        element.at_most(self.source.remaining(), element.least_size())
    }
}

impl Body for Bytes<'_> {
    fn position(&self) -> usize {
        self.source.position()
    }

    fn ignore_lines(&mut self, _: usize) -> Result<bool, MeshError> {
        Ok(false)
    }

    fn return_to(&mut self, position: usize) -> Result<(), MeshError> {
        Ok(self.source.go_to(position)?)
    }

    fn vertices(
        &mut self,
        element: &Element<'_>,
        layout: &VertexLayout,
        mesh: &mut Vertices,
    ) -> Result<(), MeshError> {
        mesh.make_room(self.at_most(element), layout.has_normals)
            .map_err(|fault| fault.at_line(element.line))?;
        if let Some(stride) = element.stride() {
            let fields = VertexFields::new(element, layout);
            return self.each(element, |window, left| {
                window.fixed_vertices(stride, left, &fields, mesh)
            });
        }
        let mut vertex: VertexRecord = [0.0; UNUSED + 1];
        self.each(element, |window, _| {
            let start = window.position;
            for (property, &place) in element.properties.iter().zip(&layout.places) {
                match property.kind {
                    Kind::Scalar(scalar) => {
                        let value = window.take(scalar.size(), "a value")?;
                        vertex[place] = scalar.float(value, window.endian);
                    }
                    list @ Kind::List { .. } => window.skip_property(list)?,
                }
            }
            mesh.push(&vertex, layout.has_normals)
                .inspect_err(|_| window.position = start)?;
            Ok(1)
        })
    }

    fn faces(
        &mut self,
        element: &Element<'_>,
        indices: usize,
        surface: &mut Surface,
    ) -> Result<(), MeshError> {
        let least = element.least_size()
            + match element.properties[indices].kind {
                Kind::List { item, .. } => LEAST_CORNERS * item.size(),
                Kind::Scalar(_) => 0,
            };
        surface
            .room_for_triangles(element.at_most(self.source.remaining(), least))
            .map_err(|fault| fault.at_line(element.line))?;
        let vertices = surface.positions.len();
        let usual = self.endian == Endian::Little
            // Past 2³¹, a negative index could pass for a large one.
            && vertices <= i32::MAX as usize
            && matches!(
                element.properties[..],
                [Property {
                    kind: Kind::List {
                        length: Scalar::U8 | Scalar::I8,
                        item: Scalar::I32 | Scalar::U32,
                    },
                    ..
                }]
            );
        let mut corners = Vec::new();
        self.each(element, |window, left| {
            if usual {
                let count = window.usual_triangles(left, surface);
                if count > 0 {
                    return Ok(count);
                }
            }
            let start = window.face(element, indices, vertices, &mut corners)?;
            surface
                .face(&corners, |_, _| Ok(()))
                .inspect_err(|_| window.position = start)?;
            Ok(1)
        })
    }

    fn strips(
        &mut self,
        element: &Element<'_>,
        indices: usize,
        surface: &mut Surface,
    ) -> Result<(), MeshError> {
        self.each(element, |window, _| {
            window.strips(element, indices, surface)?;
            Ok(1)
        })
    }

    fn skip(&mut self, element: &Element<'_>) -> Result<(), MeshError> {
        match element.stride() {
            Some(0) => Ok(()),
            Some(stride) => self.each(element, |window, left| Ok(window.records(stride, left)?.1)),
            None => self.each(element, |window, _| {
                for property in &element.properties {
                    window.skip_property(property.kind)?;
                }
                Ok(1)
            }),
        }
    }

    fn finish(&mut self) -> Result<u64, MeshError> {
        Ok(self.source.count_rest()?)
    }
}

impl Window<'_> {
    /// Reads a face's corners; where it starts.
    fn face(
        &mut self,
        element: &Element<'_>,
        indices: usize,
        vertices: usize,
        corners: &mut Vec<u32>,
    ) -> Result<usize, Box<Fault>> {
        let start = self.position;
        for (number, property) in element.properties.iter().enumerate() {
            let (Kind::List { length, item }, true) = (property.kind, number == indices) else {
                self.skip_property(property.kind)?;
                continue;
            };
            let list = self.list(length, item)?;
            corner_count(list.length).inspect_err(|_| self.position = list.start)?;
            corners.clear();
            for (i, index) in list.items.chunks_exact(list.item.size()).enumerate() {
                let vertex = (list.item.integer(index, self.endian, INDEX))
                    .and_then(|index| checked_index(index, vertices))
                    .inspect_err(|_| {
                        self.position = list.start + length.size() + i * item.size();
                    })?;
                corners.push(vertex);
            }
        }
        Ok(start)
    }

    /// Reads an element of strips.
    fn strips(
        &mut self,
        element: &Element<'_>,
        indices: usize,
        surface: &mut Surface,
    ) -> Result<(), Box<Fault>> {
        // The whole element must be there before its triangles are made.
        let mut corners = None;
        for (number, property) in element.properties.iter().enumerate() {
            match property.kind {
                Kind::List { length, item } if number == indices => {
                    let list = self.list(length, item)?;
                    list_length(list.length).inspect_err(|_| self.position = list.start)?;
                    corners = Some((list.start + length.size(), list));
                }
                kind => self.skip_property(kind)?,
            }
        }
        let mark = element.unsigned_mark(indices);
        let mut strip = Strip::default();
        if let Some((start, list)) = corners {
            let size = list.item.size();
            for (i, index) in list.items.chunks_exact(size).enumerate() {
                (list.item.integer(index, self.endian, INDEX))
                    .and_then(|index| strip_corner(index, mark, &mut strip, surface))
                    .inspect_err(|_| self.position = start + i * size)?;
            }
        }
        end_strip(&mut strip, surface);
        Ok(())
    }
}

/// The bytes of a value of fixed size.
#[inline]
fn fixed<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.try_into().expect("a value has the size of its type")
}

impl Scalar {
    /// The value, if it is an integer.
    #[inline]
    fn integer(
        self,
        bytes: &[u8],
        endian: Endian,
        expected: &'static str,
    ) -> Result<i64, Box<Fault>> {
        Ok(match (self, endian) {
            (Self::I8, _) => i64::from(i8::from_le_bytes(fixed(bytes))),
            (Self::U8, _) => i64::from(u8::from_le_bytes(fixed(bytes))),
            (Self::I16, Endian::Little) => i64::from(i16::from_le_bytes(fixed(bytes))),
            (Self::I16, Endian::Big) => i64::from(i16::from_be_bytes(fixed(bytes))),
            (Self::U16, Endian::Little) => i64::from(u16::from_le_bytes(fixed(bytes))),
            (Self::U16, Endian::Big) => i64::from(u16::from_be_bytes(fixed(bytes))),
            (Self::I32, Endian::Little) => i64::from(i32::from_le_bytes(fixed(bytes))),
            (Self::I32, Endian::Big) => i64::from(i32::from_be_bytes(fixed(bytes))),
            (Self::U32, Endian::Little) => i64::from(u32::from_le_bytes(fixed(bytes))),
            (Self::U32, Endian::Big) => i64::from(u32::from_be_bytes(fixed(bytes))),
            (Self::F32 | Self::F64, _) => {
                let value = self.float(bytes, endian);
                return whole(value)
                    .ok_or_else(|| Fault::unexpected(value.to_string().as_bytes(), expected));
            }
        })
    }

    /// The value, exactly.
    #[inline]
    fn float(self, bytes: &[u8], endian: Endian) -> f64 {
        match (self, endian) {
            (Self::F32, Endian::Little) => f64::from(f32::from_le_bytes(fixed(bytes))),
            (Self::F32, Endian::Big) => f64::from(f32::from_be_bytes(fixed(bytes))),
            (Self::F64, Endian::Little) => f64::from_le_bytes(fixed(bytes)),
            (Self::F64, Endian::Big) => f64::from_be_bytes(fixed(bytes)),
            (Self::I8, _) => f64::from(i8::from_le_bytes(fixed(bytes))),
            (Self::U8, _) => f64::from(u8::from_le_bytes(fixed(bytes))),
            (Self::I16, Endian::Little) => f64::from(i16::from_le_bytes(fixed(bytes))),
            (Self::I16, Endian::Big) => f64::from(i16::from_be_bytes(fixed(bytes))),
            (Self::U16, Endian::Little) => f64::from(u16::from_le_bytes(fixed(bytes))),
            (Self::U16, Endian::Big) => f64::from(u16::from_be_bytes(fixed(bytes))),
            (Self::I32, Endian::Little) => f64::from(i32::from_le_bytes(fixed(bytes))),
            (Self::I32, Endian::Big) => f64::from(i32::from_be_bytes(fixed(bytes))),
            (Self::U32, Endian::Little) => f64::from(u32::from_le_bytes(fixed(bytes))),
            (Self::U32, Endian::Big) => f64::from(u32::from_be_bytes(fixed(bytes))),
        }
    }
}

impl Property<'_> {
    /// The fewest bytes that it takes: of a list, its length.
    fn least_size(&self) -> usize {
        match self.kind {
            Kind::Scalar(scalar) => scalar.size(),
            Kind::List { length, .. } => length.size(),
        }
    }
}

impl Element<'_> {
    /// The fewest bytes that one of these takes.
    fn least_size(&self) -> usize {
        self.properties.iter().map(Property::least_size).sum()
    }

    /// The size of one of these in bytes, where all have the same.
    fn stride(&self) -> Option<usize> {
        (self.properties.iter())
            .map(|property| match property.kind {
                Kind::Scalar(scalar) => Some(scalar.size()),
                Kind::List { .. } => None,
            })
            .sum()
    }
}
