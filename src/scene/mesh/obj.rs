//! OBJ (Wavefront, "Object files", appendix B of the Advanced Visualizer manual): polygons with
//! vertex normals, and the groups that they are in.
//!
//! Read are `v` (a weight or a color after the position is ignored), `vn`, `f`, `g` and `o`.
//! Texture coordinates, materials, smoothing groups and display attributes are ignored; lines,
//! points, curves and curved surfaces are counted. Indices name vertices that stand above them.

use super::error::{Fault, MeshError};
use super::normals::{self, UNSEEN, has_direction};
use super::polygon::MAX_CORNERS;
use super::source::Source;
use super::surface::Surface;
use super::text::{Dialect, Scanner};
use super::{MeshFile, MeshGroup, MeshNormals, MeshRemarks};
use std::ops::Range;

/// Reads an OBJ file.
pub(super) fn read(mut source: Source<'_>) -> Result<MeshFile, MeshError> {
    const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();
    if source.window().starts_with(BYTE_ORDER_MARK) {
        source.skip(BYTE_ORDER_MARK.len());
    }
    let mut reader = Reader {
        surface: Surface::for_file(source.size()),
        normals: Vec::new(),
        normal_triangles: Vec::new(),
        flat: Vec::new(),
        without_direction: false,
        groups: Vec::new(),
        corners: Vec::new(),
        corner_normals: Vec::new(),
        remarks: MeshRemarks::default(),
    };
    loop {
        let mut scanner = Scanner::new(source.lines(Dialect::Obj)?, Dialect::Obj);
        let mut result = Ok(());
        while result.is_ok() && scanner.skip_empty_lines() {
            result = reader.statement(&mut scanner);
        }
        let position = scanner.position();
        if let Err(fault) = result {
            return Err(fault.at_line(source.line(position)?));
        }
        source.skip(position);
        if !source.read_on()? {
            break;
        }
    }
    if reader.surface.triangles.is_empty() {
        return Err(MeshError::NoFaces);
    }
    match reader.finish() {
        Ok(mesh) => Ok(mesh),
        Err(fault) => Err(fault.at_line(source.line(0)?)),
    }
}

/// What the statements so far have made.
#[derive(Debug)]
struct Reader {
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
    /// Their normals; empty where it has none.
    corner_normals: Vec<u32>,
    remarks: MeshRemarks,
}

impl Reader {
    fn statement(&mut self, scanner: &mut Scanner<'_>) -> Result<(), Box<Fault>> {
        const LINE_END: &str = "the end of the line";
        let start = scanner.clone();
        match scanner.word() {
            b"v" => {
                let position = vector(scanner)?;
                self.surface.vertex(position)?;
                // A weight, a color, or both.
                let mut beside = 0;
                while beside < 4 && !scanner.at_line_end() {
                    scanner.float("a weight or a color")?;
                    beside += 1;
                }
                scanner.end_line(LINE_END)
            }
            b"vn" => {
                let normal = vector(scanner)?;
                self.without_direction |= !has_direction(normal);
                let memory = &mut self.surface.memory;
                memory.make_room(&mut self.normals, 1, "normals")?;
                self.normals.push(normal);
                scanner.end_line(LINE_END)
            }
            // `fo` is what `f` was called before version 3.0.
            b"f" | b"fo" => {
                self.face(scanner)?;
                scanner.end_line(LINE_END)
            }
            b"g" | b"o" => self.group(scanner.skip_line()),
            word if word.starts_with(b"#") => {
                *scanner = start;
                scanner.skip_line();
                Ok(())
            }
            b"vt" | b"vp" | b"s" | b"mg" | b"usemtl" | b"mtllib" | b"usemap" | b"maplib"
            | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"shadow_obj" | b"trace_obj"
            | b"ctech" | b"stech" | b"deg" | b"bmat" | b"step" | b"cstype" | b"parm" | b"trim"
            | b"hole" | b"scrv" | b"sp" | b"end" | b"con" => {
                scanner.skip_joined_lines();
                Ok(())
            }
            b"l" | b"p" | b"curv" | b"curv2" | b"surf" | b"bsp" | b"bzp" | b"cdc" | b"cdp"
            | b"res" => {
                let skipped = &mut self.remarks.skipped_statements;
                *skipped = skipped.saturating_add(1);
                scanner.skip_joined_lines();
                Ok(())
            }
            b"call" | b"csh" => Err(Box::new(Fault::Unsupported {
                what: "`call` and `csh` statements",
                instead: "put everything in one file",
            })),
            other => {
                *scanner = start;
                Err(Fault::unexpected(
                    other,
                    "an OBJ statement such as `v`, `vn`, `f`, `g`, `o`, `usemtl` or `#`",
                ))
            }
        }
    }

    /// The corners of a face: `v`, `v/vt`, `v//vn` or `v/vt/vn` each, all with a normal or none.
    fn face(&mut self, scanner: &mut Scanner<'_>) -> Result<(), Box<Fault>> {
        const VERTEX: &str = "a corner: v, v/vt, v//vn or v/vt/vn";
        self.corners.clear();
        self.corner_normals.clear();
        while !scanner.at_line_end() {
            if self.corners.len() == MAX_CORNERS {
                return Err(Box::new(Fault::TooManyCorners {
                    corners: MAX_CORNERS as i64 + 1,
                }));
            }
            let vertex = scanner.integer_prefix(VERTEX)?;
            let vertex = resolved(vertex, self.surface.positions.len(), "vertex")?;
            let mut normal = None;
            if scanner.accept(b'/') {
                let texture = !scanner.accept(b'/');
                if texture {
                    scanner.directly_integer("the index of a texture coordinate")?;
                }
                if !texture || scanner.accept(b'/') {
                    let index = scanner.directly_integer("the index of a normal")?;
                    normal = Some(resolved(index, self.normals.len(), "normal")?);
                }
            }
            scanner.end_word(VERTEX)?;
            if normal.is_some() != (self.corner_normals.len() == self.corners.len())
                && !self.corners.is_empty()
            {
                return Err(Box::new(Fault::MixedCorners));
            }
            self.corners.push(vertex);
            self.corner_normals.extend(normal);
        }
        if self.corners.len() < 3 {
            return Err(Box::new(Fault::TooFewCorners {
                corners: self.corners.len() as i64,
            }));
        }
        self.add_face()
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
            let mended = &mut self.remarks.mended_normals;
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
            remarks: MeshRemarks {
                folded_polygons: self.surface.folded_polygons,
                ..self.remarks
            },
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

/// The position in a list that an index stands for: 1 is the first, −1 the last so far.
#[inline]
fn resolved(index: i64, count: usize, what: &'static str) -> Result<u32, Box<Fault>> {
    let position = if index < 0 {
        count as i64 + index
    } else {
        index - 1
    };
    if (0..count as i64).contains(&position) {
        // There are never more than u32::MAX.
        Ok(position as u32)
    } else {
        Err(Box::new(Fault::NoSuchIndex {
            what,
            index,
            first: 1,
            count,
        }))
    }
}

#[cfg(test)]
mod tests;
