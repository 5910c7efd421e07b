//! OBJ (Wavefront, "Object files", appendix B of the Advanced Visualizer manual): polygons with
//! vertex normals, and the groups that they are in.
//!
//! Read are `v` (a weight or a color after the position is ignored), `vn`, `f`, `g` and `o`.
//! Texture coordinates, materials, smoothing groups and display attributes are ignored; lines,
//! points, curves, curved surfaces and statements that nobody knows are counted. A face may stand
//! above its vertices: the file is then read again, vertices first.

use super::error::{Fault, MeshError};
use super::limits::MAX_CORNERS;
use super::normals::{self, UNSEEN, has_direction};
use super::source::Source;
use super::surface::Surface;
use super::text::{Dialect, Index, Scanner};
use super::{MeshFile, MeshGroup, MeshNormals, MeshRemarks};
use std::ops::Range;

/// Statements that are read.
const READ: [&[u8]; 6] = [b"v", b"vn", b"f", b"fo", b"g", b"o"];

/// Statements that name materials and files.
const NAMES: [&[u8]; 4] = [b"usemtl", b"mtllib", b"usemap", b"maplib"];

/// Statements about what has no effect on the picture.
const WITHOUT_EFFECT: [&[u8]; 23] = [
    b"vt",
    b"s",
    b"vp",
    b"mg",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"deg",
    b"bmat",
    b"step",
    b"cstype",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
];

/// Statements of lines, points, curves and curved surfaces, and those that end or join them.
const NOT_RENDERED: [&[u8]; 10] = [
    b"l", b"p", b"curv", b"curv2", b"surf", b"bsp", b"bzp", b"cdc", b"cdp", b"res",
];

/// Reads an OBJ file.
pub(super) fn read(mut source: Source<'_>) -> Result<MeshFile, MeshError> {
    let start = source.position();
    let size = source.size();
    let mut reader = Reader::new(Surface::for_file(size), Part::Whole);
    let mut result = reader.read(&mut source);
    if reader.points_ahead {
        reader = Reader::new(Surface::for_file(size), Part::Vertices);
        source.go_to(start)?;
        reader.read(&mut source)?;
        (reader.part, reader.above) = (Part::Faces, Above::default());
        source.go_to(start)?;
        result = reader.read(&mut source);
    }
    result?;
    if reader.surface.triangles.is_empty() {
        let remarks = Box::new(reader.surface.remarks);
        return Err(MeshError::NoFaces { remarks });
    }
    if let Some(vertex) = reader.surface.broken_vertex() {
        // What is wrong with it, and where, is seen when it is read again.
        source.go_to(start)?;
        Reader::new(Surface::to_find(vertex, size), Part::Vertices).read(&mut source)?;
        return Err(MeshError::Changed);
    }
    match reader.finish() {
        Ok(mesh) => Ok(mesh),
        Err(fault) => Err(fault.at_line(source.line(0)?)),
    }
}

/// What of a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    /// Everything at once.
    Whole,
    /// `v` and `vn` alone.
    Vertices,
    /// Everything else, `v` and `vn` being known.
    Faces,
}

/// What stands above a line: to there negative indices count back.
#[derive(Clone, Copy, Debug, Default)]
struct Above {
    positions: usize,
    normals: usize,
}

/// What the statements so far have made.
#[derive(Debug)]
struct Reader {
    part: Part,
    above: Above,
    /// Whether a face names what is not above it.
    points_ahead: bool,
    surface: Surface,
    normals: Vec<[f64; 3]>,
    /// For each triangle the normals of its corners, or anything where it is among `flat`.
    normal_triangles: Vec<[u32; 3]>,
    /// The triangles that take their geometric normal, in ascending order, none adjoining.
    flat: Vec<Range<u32>>,
    /// Whether a normal so far has no direction.
    without_direction: bool,
    /// Where each begins; the last one is still open.
    groups: Vec<MeshGroup>,
    /// The corners of the face that is read.
    corners: Vec<u32>,
    /// The normals of those that have one.
    corner_normals: Vec<u32>,
}

impl Reader {
    fn new(surface: Surface, part: Part) -> Self {
        Self {
            part,
            above: Above::default(),
            points_ahead: false,
            surface,
            normals: Vec::new(),
            normal_triangles: Vec::new(),
            flat: Vec::new(),
            without_direction: false,
            groups: Vec::new(),
            corners: Vec::new(),
            corner_normals: Vec::new(),
        }
    }

    /// Reads the statements from the source's window on.
    fn read(&mut self, source: &mut Source<'_>) -> Result<(), MeshError> {
        loop {
            let mut scanner = Scanner::new(source.lines(Dialect::Obj)?, Dialect::Obj);
            let mut result = Ok(());
            while result.is_ok() && scanner.skip_empty_lines() {
                result = self.statement(&mut scanner);
            }
            let position = scanner.position();
            if let Err(fault) = result {
                return Err(fault.at_line(source.line(position)?));
            }
            source.skip(position);
            if !source.read_on()? {
                return Ok(());
            }
        }
    }

    fn statement(&mut self, scanner: &mut Scanner<'_>) -> Result<(), Box<Fault>> {
        let start = scanner.clone();
        match scanner.word() {
            b"v" => self.vertex(scanner),
            b"vn" => self.normal(scanner),
            // `fo` is what `f` was called before version 3.0.
            b"f" | b"fo" => {
                if self.part == Part::Vertices {
                    scanner.skip_joined_lines();
                    return Ok(());
                }
                self.face(scanner)?;
                scanner.end_line("the end of the line")
            }
            b"g" | b"o" => self.group(scanner.skip_line()),
            word if NAMES.contains(&word) => {
                skip_names(scanner);
                Ok(())
            }
            word if word.starts_with(b"#") => {
                *scanner = start;
                scanner.skip_line();
                Ok(())
            }
            word if WITHOUT_EFFECT.contains(&word) => {
                scanner.skip_joined_lines();
                Ok(())
            }
            word if NOT_RENDERED.contains(&word) => {
                if self.part != Part::Vertices {
                    MeshRemarks::add(&mut self.surface.remarks.skipped_statements);
                }
                scanner.skip_joined_lines();
                Ok(())
            }
            b"call" | b"csh" => Err(Box::new(Fault::Unsupported {
                what: "`call` and `csh` statements",
                instead: "put everything in one file",
            })),
            other => {
                if self.part != Part::Vertices {
                    self.surface.remarks.unknown(other);
                }
                scanner.skip_joined_lines();
                Ok(())
            }
        }
    }

    /// A position, and after it a weight, a color, or both.
    fn vertex(&mut self, scanner: &mut Scanner<'_>) -> Result<(), Box<Fault>> {
        self.above.positions += 1;
        if self.part == Part::Faces {
            scanner.skip_joined_lines();
            return Ok(());
        }
        let position = match vector(scanner) {
            Ok(position) => position,
            Err(fault) if self.surface.is_wanted() => return Err(fault),
            // Nothing is wrong with the picture as long as no face uses it.
            Err(_) => {
                self.surface.vertex([f64::NAN; 3])?;
                scanner.skip_joined_lines();
                return Ok(());
            }
        };
        self.surface.vertex(position)?;
        let mut beside = 0;
        while beside < 4 && !scanner.at_line_end() && scanner.float("a weight or a color").is_ok() {
            beside += 1;
        }
        self.end_values(scanner);
        Ok(())
    }

    fn normal(&mut self, scanner: &mut Scanner<'_>) -> Result<(), Box<Fault>> {
        self.above.normals += 1;
        if self.part == Part::Faces {
            scanner.skip_joined_lines();
            return Ok(());
        }
        let read = vector(scanner);
        let normal = read.as_ref().copied().unwrap_or([f64::NAN; 3]);
        self.without_direction |= !has_direction(normal);
        let memory = &mut self.surface.memory;
        memory.make_room(&mut self.normals, 1, "normals")?;
        self.normals.push(normal);
        if read.is_ok() {
            self.end_values(scanner);
        } else {
            scanner.skip_joined_lines();
        }
        Ok(())
    }

    /// Goes to the next line; values that are left on this one are ignored and counted.
    fn end_values(&mut self, scanner: &mut Scanner<'_>) {
        if scanner.end_line("").is_err() {
            MeshRemarks::add(&mut self.surface.remarks.uneven_lines);
            scanner.skip_joined_lines();
        }
    }

    /// The corners of a face: `v`, `v/vt`, `v//vn` or `v/vt/vn` each; nothing need stand behind a
    /// slash.
    fn face(&mut self, scanner: &mut Scanner<'_>) -> Result<(), Box<Fault>> {
        const VERTEX: &str = "a corner: v, v/vt, v//vn or v/vt/vn";
        self.corners.clear();
        self.corner_normals.clear();
        let mut absent = 0;
        while !scanner.at_line_end() {
            if self.corners.len() == MAX_CORNERS {
                return Err(Box::new(Fault::TooManyCorners {
                    corners: MAX_CORNERS as i64 + 1,
                }));
            }
            let vertex = scanner.integer_prefix(VERTEX)?;
            let vertex = self.position_at(vertex)?;
            if scanner.accept(b'/') {
                // The texture coordinate.
                scanner.index();
                if scanner.accept(b'/')
                    && let Some(index) = scanner.index()
                {
                    match self.normal_at(index) {
                        Some(normal) => self.corner_normals.push(normal),
                        None if self.points_ahead => return Err(no_such_vertex(0, 0)),
                        None => absent += 1,
                    }
                }
                scanner.skip_empty_places();
            }
            scanner.end_word(VERTEX)?;
            self.corners.push(vertex);
        }
        if self.corners.len() < 3 {
            return self.surface.face(&self.corners, |_, _| Ok(()));
        }
        let remarks = &mut self.surface.remarks;
        remarks.absent_normals = remarks.absent_normals.saturating_add(absent);
        let with_normal = self.corner_normals.len();
        if absent == 0 && with_normal != 0 && with_normal != self.corners.len() {
            MeshRemarks::add(&mut remarks.partial_normals);
        }
        if with_normal != self.corners.len() {
            self.corner_normals.clear();
        }
        self.add_face()
    }

    /// The position that an index stands for: 1 is the first, −1 the last above.
    #[inline]
    fn position_at(&mut self, index: i64) -> Result<u32, Box<Fault>> {
        let count = self.surface.positions.len();
        match place_of(index, self.above.positions, count) {
            // There are never more than u32::MAX.
            Some(place) => Ok(place as u32),
            None => {
                self.points_ahead |= index > 0 && self.part == Part::Whole;
                let counted = if index < 0 {
                    self.above.positions
                } else {
                    count
                };
                Err(no_such_vertex(index, counted))
            }
        }
    }

    /// The normal that an index stands for, if there is one.
    #[inline]
    fn normal_at(&mut self, index: Index) -> Option<u32> {
        let Index::Number(index) = index else {
            return None;
        };
        let place = place_of(index, self.above.normals, self.normals.len());
        self.points_ahead |= place.is_none() && index > 0 && self.part == Part::Whole;
        place.map(|place| place as u32)
    }

    fn add_face(&mut self) -> Result<(), Box<Fault>> {
        let first = self.surface.triangles.len() as u32;
        let Self {
            normal_triangles,
            corner_normals,
            ..
        } = self;
        let named = !corner_normals.is_empty();
        let smooth = named
            && !(self.without_direction
                && (corner_normals.iter()).any(|&i| !has_direction(self.normals[i as usize])));
        // A file without normals needs no indices of normals: they begin with the first face
        // that has some.
        let begun = smooth || !normal_triangles.is_empty();
        if begun && normal_triangles.len() < first as usize {
            let missing = first as usize - normal_triangles.len();
            let memory = &mut self.surface.memory;
            memory.make_room(normal_triangles, missing, "triangles")?;
            normal_triangles.resize(first as usize, [0; 3]);
        }
        self.surface.face(&self.corners, |memory, numbers| {
            if begun {
                memory.make_room(normal_triangles, 1, "triangles")?;
                normal_triangles.push(if smooth {
                    numbers.map(|i| corner_normals[i as usize])
                } else {
                    [0; 3]
                });
            }
            Ok(())
        })?;
        let end = self.surface.triangles.len() as u32;
        if !smooth {
            match self.flat.last_mut() {
                Some(last) if last.end == first => last.end = end,
                _ => {
                    let memory = &mut self.surface.memory;
                    memory.make_room(&mut self.flat, 1, "faces")?;
                    self.flat.push(first..end);
                }
            }
        }
        if named && !smooth {
            let area = (first..end)
                .filter(|&t| self.geometric_normal(t).is_some())
                .count();
            let mended = &mut self.surface.remarks.mended_normals;
            *mended = mended.saturating_add(area as u32);
        }
        Ok(())
    }

    fn geometric_normal(&self, triangle: u32) -> Option<[f64; 3]> {
        let corners = self.surface.triangles[triangle as usize];
        normals::of_triangle(corners.map(|i| self.surface.positions[i as usize]))
    }

    /// Begins a group; without a name, what follows belongs to none.
    fn group(&mut self, name: &[u8]) -> Result<(), Box<Fault>> {
        /// What a byte becomes at most when it is no UTF-8: U+FFFD.
        const REPLACEMENT: usize = 3;
        if self.part == Part::Vertices {
            return Ok(());
        }
        let name = name.trim_ascii();
        let start = self.surface.triangles.len() as u32;
        self.close_group();
        let memory = &mut self.surface.memory;
        memory.take(name.len() * REPLACEMENT)?;
        memory.make_room(&mut self.groups, 1, "groups")?;
        self.groups.push(MeshGroup {
            name: String::from_utf8_lossy(name).into_owned(),
            triangles: start..start,
        });
        Ok(())
    }

    /// Ends the group that is open; it goes where it has no name or no triangles.
    fn close_group(&mut self) {
        let end = self.surface.triangles.len() as u32;
        if let Some(open) = self.groups.last_mut() {
            open.triangles.end = end;
            if open.triangles.is_empty() || open.name.is_empty() {
                self.groups.pop();
            }
        }
    }

    fn finish(mut self) -> Result<MeshFile, Box<Fault>> {
        self.close_group();
        let normals = if self.normal_triangles.is_empty() {
            None
        } else {
            self.append_geometric_normals()?;
            Some(MeshNormals {
                triangles: (self.normals.len() != self.surface.positions.len()
                    || self.normal_triangles != self.surface.triangles)
                    .then_some(self.normal_triangles),
                vectors: self.normals,
            })
        };
        Ok(MeshFile {
            positions: self.surface.positions,
            triangles: self.surface.triangles,
            normals,
            groups: self.groups,
            remarks: self.surface.remarks,
        })
    }

    /// Gives the triangles without normals their geometric ones.
    fn append_geometric_normals(&mut self) -> Result<(), Box<Fault>> {
        for normal in self.normals.iter_mut().filter(|&&mut n| !has_direction(n)) {
            // No triangle uses it: those that name it are flat.
            *normal = UNSEEN;
        }
        for range in std::mem::take(&mut self.flat) {
            for triangle in range {
                let normal = self.geometric_normal(triangle).unwrap_or(UNSEEN);
                let memory = &mut self.surface.memory;
                memory.make_room(&mut self.normals, 1, "normals")?;
                let index = self.normals.len() as u32;
                self.normals.push(normal);
                self.normal_triangles[triangle as usize] = [index; 3];
            }
        }
        Ok(())
    }
}

fn vector(scanner: &mut Scanner<'_>) -> Result<[f64; 3], Box<Fault>> {
    Ok([
        scanner.float("a number for x")?,
        scanner.float("a number for y")?,
        scanner.float("a number for z")?,
    ])
}

/// Goes to the next statement after names. A name may end in `\`, as a folder of Windows does: what
/// follows goes with it only if it is no statement.
fn skip_names(scanner: &mut Scanner<'_>) {
    let is_statement = |word: &[u8]| {
        let mut lists = [&READ[..], &NAMES, &WITHOUT_EFFECT, &NOT_RENDERED].into_iter();
        word.starts_with(b"#") || lists.any(|list| list.contains(&word))
    };
    while scanner.skip_line().trim_ascii_end().ends_with(b"\\") {
        if is_statement(scanner.clone().word()) {
            return;
        }
    }
}

/// The place in a list of `count` that an index stands for: 1 is the first, −1 the last of those
/// `above`. `None` where there is none.
#[inline]
fn place_of(index: i64, above: usize, count: usize) -> Option<usize> {
    let place = if index < 0 {
        above as i64 + index
    } else {
        index - 1
    };
    (0..count as i64).contains(&place).then_some(place as usize)
}

fn no_such_vertex(index: i64, count: usize) -> Box<Fault> {
    Box::new(Fault::NoSuchIndex {
        what: "vertex",
        index,
        first: 1,
        count,
    })
}

#[cfg(test)]
mod tests;
