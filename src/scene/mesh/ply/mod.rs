//! PLY (Turk, "The PLY polygon file format", 1994): ASCII, binary little and big endian.
//!
//! Read are `x`, `y`, `z` and, if all three are there, `nx`, `ny`, `nz` of `element vertex`, and
//! the list `vertex_indices` or `vertex_index` of `element face`; all other elements and
//! properties are skipped. In ASCII every element stands on a line of its own.

mod ascii;
mod binary;

use super::error::{ElementPlace, Fault, MeshError};
use super::memory::Memory;
use super::normals;
use super::source::Source;
use super::surface::Surface;
use super::text::{Dialect, Scanner};
use super::{MeshFile, MeshNormals, MeshRemarks};

/// Whether a file that starts like this is a PLY file.
pub(super) fn has_signature(bytes: &[u8]) -> bool {
    bytes
        .strip_prefix(b"ply")
        .is_some_and(|rest| rest.first().is_none_or(u8::is_ascii_whitespace))
}

/// What stands between `ply` and `end_header`.
#[derive(Debug)]
struct Header<'a> {
    format: Format,
    elements: Vec<Element<'a>>,
    /// The first byte after it.
    end: usize,
    /// The line of `end_header`.
    last_line: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Ascii,
    Binary(Endian),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Endian {
    Little,
    Big,
}

#[derive(Debug)]
struct Element<'a> {
    name: &'a [u8],
    count: u64,
    properties: Vec<Property<'a>>,
    /// Its line in the header.
    line: usize,
}

#[derive(Clone, Copy, Debug)]
struct Property<'a> {
    name: &'a [u8],
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Scalar(Scalar),
    List { length: Scalar, item: Scalar },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
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

/// What a body of either kind can do; it is read from the front.
trait Body {
    /// The byte of the file that is next.
    fn position(&self) -> usize;

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

    /// Skips an element.
    fn skip(&mut self, element: &Element<'_>) -> Result<(), MeshError>;

    /// Nothing may be left.
    fn finish(&mut self) -> Result<(), MeshError>;
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
        let start = source.lines(Dialect::Ply)?.to_vec();
        if let Some(header) = Header::parse(&start, source.has_ended())? {
            source.skip(header.end);
            return match header.format {
                Format::Ascii => read_body(ascii::Text::new(source), &header, size),
                Format::Binary(endian) => {
                    read_body(binary::Bytes::new(source, endian), &header, size)
                }
            };
        }
        source.read_on()?;
    }
}

fn read_body(mut body: impl Body, header: &Header<'_>, size: usize) -> Result<MeshFile, MeshError> {
    let [vertex, face] = [header.element(b"vertex")?, header.element(b"face")?];
    let missing =
        |what, expected| Box::new(Fault::Missing { what, expected }).at_line(header.last_line);
    let vertex = vertex.ok_or_else(|| missing("`element vertex`", "`element vertex COUNT`"))?;
    let layout = vertex.vertex_layout()?;
    let Some(face) = face.filter(|face| face.count > 0) else {
        return Err(match header.element(b"tristrips")? {
            Some(strips) => Box::new(Fault::Unsupported {
                what: "triangle strips",
                instead: "save the mesh with `element face`",
            })
            .at_line(strips.line),
            None => MeshError::NoFaces,
        });
    };
    let indices = face.corner_list()?;

    let mut mesh = Vertices {
        surface: Surface::for_file(size),
        normals: Vec::new(),
    };
    let mut faces_before_vertices = None;
    let mut vertices_read = false;
    for element in &header.elements {
        if std::ptr::eq(element, vertex) {
            body.vertices(element, &layout, &mut mesh)?;
            vertices_read = true;
        } else if std::ptr::eq(element, face) {
            if vertices_read {
                body.faces(element, indices, &mut mesh.surface)?;
            } else {
                faces_before_vertices = Some(body.position());
                body.skip(element)?;
            }
        } else {
            body.skip(element)?;
        }
    }
    body.finish()?;
    if let Some(position) = faces_before_vertices {
        body.return_to(position)?;
        body.faces(face, indices, &mut mesh.surface)?;
    }
    Ok(mesh.finish(layout.has_normals))
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

    fn finish(self, has_normals: bool) -> MeshFile {
        let Self {
            surface,
            mut normals,
        } = self;
        let mended_normals = normals::mend(&mut normals, &surface.positions, &surface.triangles);
        MeshFile {
            positions: surface.positions,
            triangles: surface.triangles,
            normals: has_normals.then_some(MeshNormals {
                vectors: normals,
                triangles: None,
            }),
            groups: Vec::new(),
            remarks: MeshRemarks {
                mended_normals,
                folded_polygons: surface.folded_polygons,
                skipped_statements: 0,
            },
        }
    }
}

impl<'a> Header<'a> {
    /// Reads the header of a file that starts like this; `None` where it goes on beyond, unless
    /// that is all of the file.
    fn parse(bytes: &'a [u8], is_all: bool) -> Result<Option<Self>, MeshError> {
        let mut scanner = Scanner::new(bytes, Dialect::Ply);
        scanner.word();
        scanner
            .end_line("nothing but `ply` on the first line")
            .map_err(|fault| fault.at_line(1))?;
        let mut format = None;
        let mut elements = Vec::new();
        let mut line = 1;
        loop {
            line += 1;
            let at_line = |fault: Box<Fault>| fault.at_line(line);
            if scanner.rest().is_empty() {
                if !is_all {
                    return Ok(None);
                }
                return Err(at_line(Box::new(Fault::FileEnds {
                    expected: "`end_header`",
                })));
            }
            // Statements are short; binary data without line ends is found out early.
            match scanner.word() {
                b"comment" | b"obj_info" => {
                    scanner.skip_line();
                    continue;
                }
                b"end_header" => {
                    scanner
                        .end_line("nothing more on the line")
                        .map_err(at_line)?;
                    break;
                }
                b"format" => format = Some(parse_format(&mut scanner).map_err(at_line)?),
                b"element" => {
                    let element = parse_element(&mut scanner, line).map_err(at_line)?;
                    elements.push(element);
                }
                b"property" => {
                    let property = parse_property(&mut scanner).map_err(at_line)?;
                    let Some(element) = elements.last_mut() else {
                        return Err(at_line(Fault::unexpected(
                            b"property",
                            "an `element` before it",
                        )));
                    };
                    element.properties.push(property);
                }
                b"" => {}
                other => {
                    return Err(at_line(Fault::unexpected(
                        other,
                        "`format`, `element`, `property`, `comment`, `obj_info` or `end_header`",
                    )));
                }
            }
            scanner
                .end_line("nothing more on the line")
                .map_err(at_line)?;
        }
        let format = format.ok_or_else(|| {
            Box::new(Fault::Missing {
                what: "format",
                expected: "`format ascii 1.0`, `format binary_little_endian 1.0` or \
                    `format binary_big_endian 1.0`",
            })
            .at_line(line)
        })?;
        Ok(Some(Self {
            format,
            elements,
            end: scanner.position(),
            last_line: line,
        }))
    }

    /// The element of that name, if there is one.
    fn element(&self, name: &[u8]) -> Result<Option<&Element<'a>>, MeshError> {
        let mut named = self.elements.iter().filter(|element| element.name == name);
        let first = named.next();
        match named.next() {
            Some(second) => Err(Fault::duplicate("element", name).at_line(second.line)),
            None => Ok(first),
        }
    }
}

fn parse_format(scanner: &mut Scanner<'_>) -> Result<Format, Box<Fault>> {
    let format = match scanner.word() {
        b"ascii" => Format::Ascii,
        b"binary_little_endian" => Format::Binary(Endian::Little),
        b"binary_big_endian" => Format::Binary(Endian::Big),
        other => {
            return Err(Fault::unexpected(
                other,
                "`ascii`, `binary_little_endian` or `binary_big_endian`",
            ));
        }
    };
    match scanner.word() {
        b"1.0" => Ok(format),
        other => Err(Fault::unexpected(other, "version `1.0`")),
    }
}

fn parse_element<'a>(scanner: &mut Scanner<'a>, line: usize) -> Result<Element<'a>, Box<Fault>> {
    const COUNT: &str = "the number of elements";
    let name = scanner.word();
    if name.is_empty() {
        return Err(Box::new(Fault::LineEnds {
            expected: "the element's name",
        }));
    }
    let count = scanner.integer(COUNT)?;
    let count =
        u64::try_from(count).map_err(|_| Fault::unexpected(count.to_string().as_bytes(), COUNT))?;
    let what = match name {
        b"vertex" => "vertices",
        b"face" => "faces",
        _ => "",
    };
    if !what.is_empty() && count > u64::from(u32::MAX) {
        return Err(Box::new(Fault::TooMany { what }));
    }
    Ok(Element {
        name,
        count,
        properties: Vec::new(),
        line,
    })
}

fn parse_property<'a>(scanner: &mut Scanner<'a>) -> Result<Property<'a>, Box<Fault>> {
    let kind = match scanner.word() {
        b"list" => {
            let length = scanner.word();
            let length = Scalar::named(length)
                .filter(|scalar| scalar.is_integer())
                .ok_or_else(|| {
                    Fault::unexpected(length, "an integer type for the length of the list")
                })?;
            let item = parse_scalar(scanner.word())?;
            Kind::List { length, item }
        }
        scalar => Kind::Scalar(parse_scalar(scalar)?),
    };
    match scanner.word() {
        b"" => Err(Box::new(Fault::LineEnds {
            expected: "the property's name",
        })),
        name => Ok(Property { name, kind }),
    }
}

fn parse_scalar(name: &[u8]) -> Result<Scalar, Box<Fault>> {
    Scalar::named(name).ok_or_else(|| {
        Fault::unexpected(
            name,
            "a type: char, uchar, short, ushort, int, uint, float, double, int8, uint8, int16, \
            uint16, int32, uint32, float32 or float64",
        )
    })
}

impl Scalar {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    const fn is_integer(self) -> bool {
        match self {
            Self::I8 | Self::U8 | Self::I16 | Self::U16 | Self::I32 | Self::U32 => true,
            Self::F32 | Self::F64 => false,
        }
    }

    /// Its size in binary files, in bytes.
    const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

impl Element<'_> {
    /// The place of this element's number `index`.
    fn place(&self, index: u64) -> Option<ElementPlace> {
        const READABLE: usize = 40;
        let name = &self.name[..self.name.len().min(READABLE)];
        Some(ElementPlace {
            name: name.escape_ascii().to_string(),
            index,
            count: self.count,
        })
    }

    /// The number of the property of that name, if there is one.
    fn property(&self, name: &[u8]) -> Result<Option<usize>, MeshError> {
        let mut named = (0..self.properties.len()).filter(|&i| self.properties[i].name == name);
        let first = named.next();
        match named.next() {
            Some(_) => Err(Fault::duplicate("property", name).at_line(self.line)),
            None => Ok(first),
        }
    }

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
        if found[..3] != [true; 3] {
            return Err(Box::new(Fault::Missing {
                what: "position in `element vertex`",
                expected: "`property float x`, `property float y` and `property float z` after it",
            })
            .at_line(self.line));
        }
        Ok(VertexLayout {
            places,
            has_normals: found[3..] == [true; 3],
        })
    }

    fn corner_list(&self) -> Result<usize, MeshError> {
        let property = match self.property(b"vertex_indices")? {
            Some(property) => Some(property),
            None => self.property(b"vertex_index")?,
        };
        property
            .filter(|&property| match self.properties[property].kind {
                Kind::List { item, .. } => item.is_integer(),
                Kind::Scalar(_) => false,
            })
            .ok_or_else(|| {
                Box::new(Fault::Missing {
                    what: "corners in `element face`",
                    expected: "`property list uchar int vertex_indices` after it",
                })
                .at_line(self.line)
            })
    }

    /// How many of these `bytes` can hold at most, where one takes at least `least` of them.
    fn at_most(&self, bytes: usize, least: usize) -> usize {
        let count = usize::try_from(self.count).unwrap_or(usize::MAX);
        count.min(bytes / least.max(1))
    }
}

impl Fault {
    fn duplicate(what: &'static str, name: &[u8]) -> Box<Self> {
        let name = name.escape_ascii().to_string();
        Box::new(Self::Duplicate { what, name })
    }
}

/// The corners that every face has, at least.
const LEAST_CORNERS: usize = 3;

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
