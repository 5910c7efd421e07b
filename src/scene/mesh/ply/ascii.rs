//! The body of an ASCII PLY file: an element a line.

use super::super::error::{Fault, MeshError, Position};
use super::super::surface::{Surface, corner_count};
use super::super::text::{Dialect, Scanner};
use super::{Body, Element, Kind, UNUSED, VertexLayout, VertexRecord, Vertices};
use super::{LEAST_CORNERS, checked_index, list_length};

const NUMBER: &str = "a number";
const LENGTH: &str = "the length of a list";
const INDEX: &str = "the index of a vertex";
const LINE_END: &str = "the end of the line, after all properties of the element";

/// The lines that are left.
#[derive(Clone, Debug)]
pub(super) struct Text<'a> {
    scanner: Scanner<'a>,
}

impl<'a> Text<'a> {
    /// The lines from byte `start` on.
    pub(super) const fn new(bytes: &'a [u8], start: usize) -> Self {
        Self {
            scanner: Scanner::new(bytes, start, Dialect::Ply),
        }
    }

    /// Calls `one` at the line of each of the elements, one after the other.
    fn each(
        &mut self,
        element: &Element<'_>,
        mut one: impl FnMut(&mut Scanner<'a>) -> Result<(), Box<Fault>>,
    ) -> Result<(), MeshError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        for index in 0..element.count {
            let read = if self.scanner.skip_empty_lines() {
                one(&mut self.scanner).and_then(|()| self.scanner.end_line(LINE_END))
            } else {
                Err(Box::new(Fault::FileEnds { expected: NUMBER }))
            };
            if let Err(fault) = read {
                let line = Position::Line(self.scanner.line());
                return Err(fault.at(line, element.place(index)));
            }
        }
        Ok(())
    }

    /// How many of the elements can be there at most: each value takes a digit and a blank, but
    /// for the last.
    fn at_most(&self, element: &Element<'_>, least_values: usize) -> usize {
        element.at_most(self.scanner.rest().len() + 1, 2 * least_values)
    }
}

/// Skips a property.
fn skip(scanner: &mut Scanner<'_>, kind: Kind) -> Result<(), Box<Fault>> {
    match kind {
        Kind::Scalar(_) => {
            scanner.float(NUMBER)?;
        }
        Kind::List { .. } => {
            for _ in 0..list_length(scanner.integer(LENGTH)?)? {
                scanner.float(NUMBER)?;
            }
        }
    }
    Ok(())
}

impl Body for Text<'_> {
    fn vertices(
        &mut self,
        element: &Element<'_>,
        layout: &VertexLayout,
        mesh: &mut Vertices,
    ) -> Result<(), MeshError> {
        mesh.make_room(
            self.at_most(element, element.properties.len()),
            layout.has_normals,
        )
        .map_err(|fault| fault.at_line(element.line))?;
        let mut record: VertexRecord = [0.0; UNUSED + 1];
        self.each(element, |scanner| {
            for (property, &place) in element.properties.iter().zip(&layout.places) {
                match property.kind {
                    Kind::Scalar(_) => record[place] = scanner.float(NUMBER)?,
                    list @ Kind::List { .. } => skip(scanner, list)?,
                }
            }
            mesh.push(&record, layout.has_normals)
        })
    }

    fn faces(
        &mut self,
        element: &Element<'_>,
        indices: usize,
        surface: &mut Surface,
    ) -> Result<(), MeshError> {
        surface
            .room_for_triangles(self.at_most(element, element.properties.len() + LEAST_CORNERS))
            .map_err(|fault| fault.at_line(element.line))?;
        let vertices = surface.positions.len();
        let mut corners = Vec::new();
        self.each(element, |scanner| {
            for (number, property) in element.properties.iter().enumerate() {
                if number != indices {
                    skip(scanner, property.kind)?;
                    continue;
                }
                corners.clear();
                for _ in 0..corner_count(scanner.integer(LENGTH)?)? {
                    corners.push(checked_index(scanner.integer(INDEX)?, vertices)?);
                }
            }
            surface.face(&corners, |_, _| Ok(()))
        })
    }

    fn skip(&mut self, element: &Element<'_>) -> Result<(), MeshError> {
        self.each(element, |scanner| {
            (element.properties.iter()).try_for_each(|property| skip(scanner, property.kind))
        })
    }

    fn finish(&mut self) -> Result<(), MeshError> {
        if !self.scanner.skip_empty_lines() {
            return Ok(());
        }
        let fault = Fault::unexpected(
            self.scanner.token(),
            "the end of the file, after all elements that the header counts",
        );
        Err(fault.at_line(self.scanner.line()))
    }
}
