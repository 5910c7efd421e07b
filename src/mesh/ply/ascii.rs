//! The body of an ASCII PLY file: an element a line, as nearly all have it, or else one number after
//! the other.

use super::super::MeshRemarks;
use super::super::error::{Fault, MeshError, Position};
use super::super::source::Source;
use super::super::surface::{Surface, corner_count};
use super::super::text::{Dialect, Scanner};
use super::{Body, Element, Kind, NORMAL, Property, UNUSED, VertexLayout, VertexRecord, Vertices};
use super::{LEAST_CORNERS, Strip, checked_index, end_strip, list_length, strip_corner};

const NUMBER: &str = "a number";
const LENGTH: &str = "the length of a list";
const INDEX: &str = "the index of a vertex";

/// The lines that are left.
pub(super) struct Text<'r> {
    source: Source<'r>,
    dialect: Dialect,
}

impl<'r> Text<'r> {
    /// The lines from the start of the source's window on.
    pub(super) const fn new(source: Source<'r>) -> Self {
        Self {
            source,
            dialect: Dialect::Ply,
        }
    }

    /// Calls `one` at the line of each of the elements, one after the other; it goes to the next.
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
            let mut scanner = Scanner::new(self.source.lines(self.dialect)?, self.dialect);
            let mut result = Ok(());
            while index < element.count && scanner.skip_empty_lines() {
                result = one(&mut scanner);
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

/// Skips a property that is not used, whatever it is.
fn skip(scanner: &mut Scanner<'_>, kind: Kind) -> Result<(), Box<Fault>> {
    let count = match kind {
        Kind::Scalar(_) => 1,
        Kind::List { .. } => list_length(scanner.integer(LENGTH)?)?,
    };
    if scanner.skip_words(count) {
        Ok(())
    } else {
        Err(Box::new(Fault::LineEnds { expected: NUMBER }))
    }
}

/// Goes past the `others`, the properties after those that are used, to the next line. If this one
/// has not just them, it is counted: some programs write more, or something else, than their header
/// says.
#[inline]
fn end_element(
    scanner: &mut Scanner<'_>,
    others: &[Property<'_>],
    surface: &mut Surface,
) -> Result<(), Box<Fault>> {
    let skipped = (others.iter()).try_for_each(|property| skip(scanner, property.kind));
    if scanner.dialect() == Dialect::UnlinedPly {
        return skipped;
    }
    if skipped.is_err() || !scanner.at_line_end() {
        MeshRemarks::add(&mut surface.remarks.uneven_lines);
    }
    scanner.skip_line();
    Ok(())
}

impl Body for Text<'_> {
    fn position(&self) -> usize {
        self.source.position()
    }

    fn ignore_lines(&mut self, position: usize) -> Result<bool, MeshError> {
        self.dialect = Dialect::UnlinedPly;
        self.return_to(position)?;
        Ok(true)
    }

    fn return_to(&mut self, position: usize) -> Result<(), MeshError> {
        self.source.go_to(position)?;
        if self.dialect == Dialect::UnlinedPly {
            // An element may begin on one line and end on any other.
            self.source.read_all()?;
        }
        Ok(())
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
        let used = (layout.places.iter()).rposition(|&place| place != UNUSED);
        let (used, others) = element.properties.split_at(used.map_or(0, |last| last + 1));
        self.each(element, |scanner| {
            for (property, &place) in used.iter().zip(&layout.places) {
                match place {
                    UNUSED => skip(scanner, property.kind)?,
                    place => {
                        record[place] = match scanner.float(NUMBER) {
                            Ok(value) => value,
                            // Of a normal, whatever is no number has no direction.
                            Err(_) if place >= NORMAL => {
                                scanner.skip_words(1);
                                f64::NAN
                            }
                            Err(fault) => return Err(fault),
                        }
                    }
                }
            }
            mesh.push(&record, layout.has_normals)?;
            end_element(scanner, others, &mut mesh.surface)
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
        let (before, others) = element.properties.split_at(indices);
        let mut corners = Vec::new();
        self.each(element, |scanner| {
            (before.iter()).try_for_each(|property| skip(scanner, property.kind))?;
            corners.clear();
            for _ in 0..corner_count(scanner.integer(LENGTH)?)? {
                corners.push(checked_index(scanner.integer(INDEX)?, vertices)?);
            }
            surface.face(&corners, |_, _| Ok(()))?;
            end_element(scanner, &others[1..], surface)
        })
    }

    fn strips(
        &mut self,
        element: &Element<'_>,
        indices: usize,
        surface: &mut Surface,
    ) -> Result<(), MeshError> {
        let (before, others) = element.properties.split_at(indices);
        let mark = element.unsigned_mark(indices);
        self.each(element, |scanner| {
            (before.iter()).try_for_each(|property| skip(scanner, property.kind))?;
            let mut strip = Strip::default();
            for _ in 0..list_length(scanner.integer(LENGTH)?)? {
                strip_corner(scanner.integer(INDEX)?, mark, &mut strip, surface)?;
            }
            end_strip(&mut strip, surface);
            end_element(scanner, &others[1..], surface)
        })
    }

    fn skip(&mut self, element: &Element<'_>) -> Result<(), MeshError> {
        let unlined = self.dialect == Dialect::UnlinedPly;
        self.each(element, |scanner| {
            if unlined {
                return (element.properties.iter())
                    .try_for_each(|property| skip(scanner, property.kind));
            }
            scanner.skip_line();
            Ok(())
        })
    }

    fn finish(&mut self) -> Result<u64, MeshError> {
        Ok(self.source.count_rest()?)
    }
}
