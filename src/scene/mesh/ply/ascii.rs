//! The body of an ASCII PLY file: an element a line.

use super::super::error::{Fault, MeshError, Position};
use super::super::source::Source;
use super::super::surface::{Surface, corner_count};
use super::super::text::{Dialect, Scanner};
use super::{Body, Element, Kind, UNUSED, VertexLayout, VertexRecord, Vertices};
use super::{LEAST_CORNERS, checked_index, list_length};

const NUMBER: &str = "a number";
const LENGTH: &str = "the length of a list";
const INDEX: &str = "the index of a vertex";
const LINE_END: &str = "the end of the line, after all properties of the element";

/// The lines that are left.
pub(super) struct Text<'r> {
    source: Source<'r>,
}

impl<'r> Text<'r> {
    /// The lines from the start of the source's window on.
    pub(super) const fn new(source: Source<'r>) -> Self {
        Self { source }
    }

    /// Calls `one` at the line of each of the elements, one after the other.
    fn each(
        &mut self,
        element: &Element<'_>,
        mut one: impl FnMut(&mut Scanner<'_>) -> Result<(), Box<Fault>>,
    ) -> Result<(), MeshError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        let mut index = 0;
        loop {
            let mut scanner = Scanner::new(self.source.lines(Dialect::Ply)?, Dialect::Ply);
            let mut result = Ok(());
            while index < element.count && scanner.skip_empty_lines() {
                result = one(&mut scanner).and_then(|()| scanner.end_line(LINE_END));
                if result.is_err() {
                    break;
                }
                index += 1;
            }
            let position = scanner.position();
            if let Err(fault) = result {
                return Err(self.error(*fault, position, element, index));
            }
            self.source.skip(position);
            if index == element.count {
                return Ok(());
            }
            if !self.source.read_on()? {
                let fault = Fault::FileEnds { expected: NUMBER };
                return Err(self.error(fault, 0, element, index));
            }
        }
    }

    /// The error of a fault `ahead` of the window's start.
    #[cold]
    fn error(
        &mut self,
        fault: Fault,
        ahead: usize,
        element: &Element<'_>,
        index: u64,
    ) -> MeshError {
        match self.source.line(ahead) {
            Ok(line) => fault.at(Position::Line(line), element.place(index)),
            Err(error) => error.into(),
        }
    }

    /// How many of the elements can be there at most: each value takes a digit and a blank, but
    /// for the last.
    fn at_most(&self, element: &Element<'_>, least_values: usize) -> usize {
        element.at_most(self.source.remaining() + 1, 2 * least_values)
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
    fn position(&self) -> usize {
        self.source.position()
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
        loop {
            let mut scanner = Scanner::new(self.source.lines(Dialect::Ply)?, Dialect::Ply);
            if scanner.skip_empty_lines() {
                let fault = Fault::unexpected(
                    scanner.token(),
                    "the end of the file, after all elements that the header counts",
                );
                let position = scanner.position();
                return Err(fault.at_line(self.source.line(position)?));
            }
            let position = scanner.position();
            self.source.skip(position);
            if !self.source.read_on()? {
                return Ok(());
            }
        }
    }
}
