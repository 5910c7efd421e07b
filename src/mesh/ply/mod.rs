//! PLY (Turk, "The PLY polygon file format", 1994): ASCII, binary little and big endian.
//!
//! Read are `x`, `y`, `z` and, if all three are there, `nx`, `ny`, `nz` of `element vertex`, and
//! the list `vertex_indices` or `vertex_index` of `element face` and `element tristrips`, where -1
//! begins a new strip; all other elements and properties are skipped. In ASCII every element stands on
//! a line of its own.

mod ascii;
mod binary;
mod header;

use super::error::{Fault, MeshError};
use super::limits::LONGEST_HEADER;
use super::memory::Memory;
use super::normals;
use super::source::Source;
use super::strip::Strip;
use super::surface::Surface;
use super::text::Dialect;
use super::{MeshFile, MeshNormals, MeshRemarks};
use header::{Element, Endian, Format, Header, Kind, Property, Scalar};

/// Whether a file that starts like this is a PLY file.
pub(super) fn has_signature(bytes: &[u8]) -> bool {
    bytes
        .strip_prefix(b"ply")
        .is_some_and(|rest| rest.first().is_none_or(u8::is_ascii_whitespace))
}

/// Where the values of a vertex go: for each property a place in a [`VertexRecord`].
#[derive(Debug)]
struct VertexLayout {
    /// For each property of the element; [`UNUSED`] for what is skipped.
    places: Vec<usize>,
    has_normals: bool,
}

/// x, y, z, nx, ny, nz, and a place for what is not used.
type VertexRecord = [f64; 7];

const VERTEX_PROPERTIES: [&[u8]; 6] = [b"x", b"y", b"z", b"nx", b"ny", b"nz"];
const UNUSED: usize = VERTEX_PROPERTIES.len();
/// Where a normal begins in a [`VertexRecord`].
const NORMAL: usize = 3;

/// What a body of either kind can do; it is read from the front.
trait Body {
    /// The byte of the file that is next.
    fn position(&self) -> usize;

    /// Goes back to a byte of the file, to read from there on regardless of lines; whether that
    /// makes a difference.
    fn ignore_lines(&mut self, position: usize) -> Result<bool, MeshError>;

    /// Goes back to a byte of the file.
    fn return_to(&mut self, position: usize) -> Result<(), MeshError>;

    /// Reads `element vertex`.
    fn vertices(
        &mut self,
        element: &Element<'_>,
        layout: &VertexLayout,
        mesh: &mut Vertices,
    ) -> Result<(), MeshError>;

    /// Reads `element face`, whose property `indices` is the list of corners.
    fn faces(
        &mut self,
        element: &Element<'_>,
        indices: usize,
        surface: &mut Surface,
    ) -> Result<(), MeshError>;

    /// Reads `element tristrips`, whose property `indices` is the list of corners.
    fn strips(
        &mut self,
        element: &Element<'_>,
        indices: usize,
        surface: &mut Surface,
    ) -> Result<(), MeshError>;

    /// Skips an element.
    fn skip(&mut self, element: &Element<'_>) -> Result<(), MeshError>;

    /// Reads to the end of the file; how many bytes are left but for blanks at the end.
    fn finish(&mut self) -> Result<u64, MeshError>;
}

/// Which elements of a file make the mesh.
struct Plan<'h, 'a> {
    vertex: &'h Element<'a>,
    layout: VertexLayout,
    /// `face` and `tristrips`, each if it is there, with the property that is the list of corners.
    surfaces: Vec<(&'h Element<'a>, usize)>,
}

/// The surface with its vertices' normals.
#[derive(Debug)]
struct Vertices {
    surface: Surface,
    /// As many as there are positions, or none.
    normals: Vec<[f64; 3]>,
}

/// Reads a PLY file.
pub(super) fn read(mut source: Source<'_>) -> Result<MeshFile, MeshError> {
    let size = source.size();
    loop {
        // A copy, which stays while the source goes on.
        let lines = source.lines(Dialect::Ply)?;
        let is_cut = lines.len() > LONGEST_HEADER;
        let start = lines[..lines.len().min(LONGEST_HEADER)].to_vec();
        if let Some(header) = Header::parse(&start, source.has_ended() && !is_cut)? {
            source.skip(header.end);
            return match header.format {
                Format::Ascii => read_body(ascii::Text::new(source), &header, size),
                Format::Binary(endian) => {
                    read_body(binary::Bytes::new(source, endian), &header, size)
                }
            };
        }
        if is_cut {
            return Err(Fault::LongHeader.at_line(1));
        }
        source.read_on()?;
    }
}

fn read_body(mut body: impl Body, header: &Header<'_>, size: usize) -> Result<MeshFile, MeshError> {
    let plan = header.plan()?;
    let start = body.position();
    let mut read = plan.read(&mut body, header, size);
    if let Err(error @ MeshError::Invalid { .. }) = read {
        // Unless every number fits, it is the lines that are right.
        let unlined = if body.ignore_lines(start)? {
            plan.read(&mut body, header, size).ok()
        } else {
            None
        };
        read = match unlined {
            Some(mut mesh) if mesh.surface.remarks.trailing_bytes == 0 => {
                mesh.surface.remarks.unlined = true;
                Ok(mesh)
            }
            Some(_) | None => Err(error),
        };
    }
    let mut mesh = read?;
    if mesh.surface.triangles.is_empty() {
        let remarks = Box::new(mesh.surface.remarks);
        return Err(MeshError::NoFaces { remarks });
    }
    if let Some(vertex) = mesh.surface.broken_vertex() {
        // What is wrong with it, and where, is seen when it is read again.
        mesh.surface = Surface::to_find(vertex, size);
        mesh.normals = Vec::new();
        body.return_to(start)?;
        for element in &header.elements {
            if std::ptr::eq(element, plan.vertex) {
                body.vertices(element, &plan.layout, &mut mesh)?;
                break;
            }
            body.skip(element)?;
        }
        return Err(MeshError::Changed);
    }
    mesh.finish(plan.layout.has_normals)
}

impl Plan<'_, '_> {
    /// Reads all elements from the start of the body on.
    fn read(
        &self,
        body: &mut impl Body,
        header: &Header<'_>,
        size: usize,
    ) -> Result<Vertices, MeshError> {
        let mut mesh = Vertices {
            surface: Surface::for_file(size),
            normals: Vec::new(),
        };
        mesh.surface.remarks = header.remarks.clone();
        let mut before_vertices = Vec::new();
        let mut vertices_read = false;
        for element in &header.elements {
            let corners =
                (self.surfaces.iter()).find(|(surface, _)| std::ptr::eq(element, *surface));
            if std::ptr::eq(element, self.vertex) {
                body.vertices(element, &self.layout, &mut mesh)?;
                vertices_read = true;
            } else if let Some(&(_, indices)) = corners
                && vertices_read
            {
                element.surface(indices, body, &mut mesh.surface)?;
            } else {
                before_vertices.extend(corners.map(|corners| (body.position(), corners)));
                body.skip(element)?;
            }
        }
        mesh.surface.remarks.trailing_bytes = body.finish()?;
        for (position, &(element, indices)) in before_vertices {
            body.return_to(position)?;
            element.surface(indices, body, &mut mesh.surface)?;
        }
        Ok(mesh)
    }
}

impl<'a> Header<'a> {
    /// Which elements make the mesh.
    fn plan(&self) -> Result<Plan<'_, 'a>, MeshError> {
        let missing =
            |what, expected| Box::new(Fault::Missing { what, expected }).at_line(self.last_line);
        let vertex = self
            .element(b"vertex")?
            .ok_or_else(|| missing("`element vertex`", "`element vertex COUNT`"))?;
        let layout = vertex.vertex_layout()?;
        let mut surfaces = Vec::new();
        for name in [&b"face"[..], b"tristrips"] {
            if let Some(element) = self.element(name)?.filter(|element| element.count > 0) {
                surfaces.push((element, element.corner_list()?));
            }
        }
        if surfaces.is_empty() {
            if let Some(grid) = self.element(b"range_grid")? {
                return Err(Fault::Unsupported {
                    what: "range grids",
                    instead: "save the mesh with `element face`",
                }
                .at_line(grid.line));
            }
            let remarks = Box::new(self.remarks.clone());
            return Err(MeshError::NoFaces { remarks });
        }
        Ok(Plan {
            vertex,
            layout,
            surfaces,
        })
    }
}

impl Vertices {
    /// Room for as many vertices as the file really holds.
    fn make_room(&mut self, count: usize, normals: bool) -> Result<(), Box<Fault>> {
        let memory: &mut Memory = &mut self.surface.memory;
        memory.make_room(&mut self.surface.positions, count, "vertices")?;
        if normals {
            memory.make_room(&mut self.normals, count, "normals")?;
        }
        Ok(())
    }

    #[inline]
    fn push(&mut self, record: &VertexRecord, normals: bool) -> Result<(), Box<Fault>> {
        let &[x, y, z, nx, ny, nz, _] = record;
        self.surface.vertex([x, y, z])?;
        if normals {
            let memory = &mut self.surface.memory;
            memory.make_room(&mut self.normals, 1, "normals")?;
            self.normals.push([nx, ny, nz]);
        }
        Ok(())
    }

    fn finish(self, has_normals: bool) -> Result<MeshFile, MeshError> {
        let Self {
            surface,
            mut normals,
        } = self;
        let mended_normals = normals::mend(&mut normals, &surface.positions, &surface.triangles)?;
        Ok(MeshFile {
            positions: surface.positions,
            triangles: surface.triangles,
            normals: has_normals.then_some(MeshNormals {
                vectors: normals,
                triangles: None,
            }),
            groups: Vec::new(),
            remarks: MeshRemarks {
                mended_normals,
                ..surface.remarks
            },
        })
    }
}

impl Element<'_> {
    fn vertex_layout(&self) -> Result<VertexLayout, MeshError> {
        let mut places = vec![UNUSED; self.properties.len()];
        let mut found = [false; UNUSED];
        for (place, name) in VERTEX_PROPERTIES.into_iter().enumerate() {
            if let Some(property) = self.property(name)?
                && let Kind::Scalar(_) = self.properties[property].kind
            {
                places[property] = place;
                found[place] = true;
            }
        }
        if found[..NORMAL] != [true; 3] {
            return Err(Box::new(Fault::Missing {
                what: "position in `element vertex`",
                expected: "`property float x`, `property float y` and `property float z` after it",
            })
            .at_line(self.line));
        }
        Ok(VertexLayout {
            places,
            has_normals: found[NORMAL..] == [true; 3],
        })
    }

    /// The list of corners: by its usual names, or else the only list of integers.
    fn corner_list(&self) -> Result<usize, MeshError> {
        let is_list = |&property: &usize| match self.properties[property].kind {
            Kind::List { .. } => true,
            Kind::Scalar(_) => false,
        };
        for name in [&b"vertex_indices"[..], b"vertex_index"] {
            if let Some(property) = self.property(name)?.filter(is_list) {
                return Ok(property);
            }
        }
        let is_integer_list = |&property: &usize| match self.properties[property].kind {
            Kind::List { item, .. } => item.is_integer(),
            Kind::Scalar(_) => false,
        };
        let mut lists = (0..self.properties.len()).filter(is_integer_list);
        match (lists.next(), lists.next()) {
            (Some(only), None) => Ok(only),
            _ => Err(Box::new(Fault::Missing {
                what: "corners in its `element face` or `element tristrips`",
                expected: "`property list uchar int vertex_indices` after it",
            })
            .at_line(self.line)),
        }
    }

    /// -1 as an unsigned integer of the type of the items of `property`, a list.
    fn unsigned_mark(&self, property: usize) -> i64 {
        match self.properties[property].kind {
            Kind::List {
                item: Scalar::U8, ..
            } => i64::from(u8::MAX),
            Kind::List {
                item: Scalar::U16, ..
            } => i64::from(u16::MAX),
            Kind::List { .. } | Kind::Scalar(_) => i64::from(u32::MAX),
        }
    }

    /// Reads this element, faces or strips.
    fn surface(
        &self,
        indices: usize,
        body: &mut impl Body,
        surface: &mut Surface,
    ) -> Result<(), MeshError> {
        if self.name == b"tristrips" {
            body.strips(self, indices, surface)
        } else {
            body.faces(self, indices, surface)
        }
    }

    /// How many of these `bytes` can hold at most, where one takes at least `least` of them.
    fn at_most(&self, bytes: usize, least: usize) -> usize {
        let count = usize::try_from(self.count).unwrap_or(usize::MAX);
        count.min(bytes / least.max(1))
    }
}

/// The corners that every face has, at least, that becomes a triangle.
const LEAST_CORNERS: usize = 3;

/// The next corner of a triangle strip, or the mark of its end: -1, or what that is as an unsigned
/// integer of the list's type, where it is no vertex.
#[inline]
fn strip_corner(
    index: i64,
    unsigned_mark: i64,
    strip: &mut Strip,
    surface: &mut Surface,
) -> Result<(), Box<Fault>> {
    let vertices = surface.positions.len();
    if index == -1 || (index == unsigned_mark && index >= vertices as i64) {
        end_strip(strip, surface);
        return Ok(());
    }
    let vertex = checked_index(index, vertices)?;
    if let Some(triangle) = strip.corner(vertex) {
        surface.room_for_triangles(1)?;
        surface.triangles.push(triangle);
    }
    Ok(())
}

fn end_strip(strip: &mut Strip, surface: &mut Surface) {
    if strip.end() {
        MeshRemarks::add(&mut surface.remarks.small_faces);
    }
}

/// The index of a vertex that is among the first `count`.
#[inline]
fn checked_index(index: i64, count: usize) -> Result<u32, Box<Fault>> {
    match u32::try_from(index) {
        Ok(vertex) if (vertex as usize) < count => Ok(vertex),
        _ => Err(Box::new(Fault::NoSuchIndex {
            what: "vertex",
            index,
            first: 0,
            count,
        })),
    }
}

/// A length written in a list that is skipped.
fn list_length(length: i64) -> Result<usize, Box<Fault>> {
    usize::try_from(length).map_err(|_| {
        Fault::unexpected(
            length.to_string().as_bytes(),
            "the length of a list, 0 or more",
        )
    })
}

#[cfg(test)]
mod tests;
