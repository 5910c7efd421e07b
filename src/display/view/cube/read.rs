//! Reads `.cube` files, line by line.
//!
//! Adobe's specification has a table of one dimension or of three, and `DOMAIN_MIN`, `DOMAIN_MAX`; DaVinci Resolve
//! has both in one file, the entries of the one-dimensional one first, and `LUT_1D_INPUT_RANGE`, `LUT_3D_INPUT_RANGE`.
//! Spaces, tabs, line ends of any system and a byte order mark are passed over.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use super::format::{
    DOMAIN_LEAST, DOMAIN_MOST, KEYWORDS, LONGEST_FILE, LONGEST_LINE, RANGE_1D, RANGE_3D, SIZE_1D,
    SIZE_3D, TITLE,
};
use super::{Cube, CubeError, CubeFault, CubeProblem, Domain, Table, Tables};
use crate::input::{self, Foreign};
use crate::memory;
use crate::printable::shortened;

/// What Resolve says of tables whose codes are not those of the full range.
const VIDEO: [&str; 2] = ["LUT_IN_VIDEO_RANGE", "LUT_OUT_VIDEO_RANGE"];

/// The most entries along an axis, by Adobe's specification: of one dimension, and of three.
const MOST_1D: u64 = 65_536;
const MOST_3D: u64 = 256;

/// The shortest line of three numbers, `0 0 0`, with its end.
const SHORTEST_LINE: u64 = 6;

const THREE: &str = "three numbers, such as `0.25 0.5 1`";

impl Cube {
    /// Reads a `.cube` file.
    ///
    /// # Errors
    /// See [`CubeProblem`].
    pub fn read(path: &Path) -> Result<Self, CubeError> {
        let parsed = input::open(path).and_then(|(file, bytes)| {
            if bytes > LONGEST_FILE {
                return Err(CubeProblem::TooLarge { bytes });
            }
            let mut cube = parsed(&mut BufReader::with_capacity(1 << 16, file), bytes)?;
            let name = path.file_name().unwrap_or_default();
            cube.name = name.to_string_lossy().into_owned();
            Ok(cube)
        });
        parsed.map_err(|problem| CubeError {
            path: path.to_path_buf(),
            problem,
        })
    }
}

/// The tables of a text of so many bytes.
fn parsed(reader: &mut impl BufRead, bytes: u64) -> Result<Cube, CubeProblem> {
    if let Some(found) = Foreign::of(reader.fill_buf()?) {
        return Err(CubeProblem::Foreign { found });
    }
    let mut head = Head::new(bytes);
    let mut entries: Option<Entries> = None;
    let mut buffer = Vec::new();
    let mut number = 0;
    while next_line(reader, &mut buffer)? {
        number += 1;
        let in_line = |fault| CubeProblem::Line {
            line: number,
            fault,
        };
        let line = text(&buffer, number).map_err(in_line)?;
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let word = line.split_whitespace().next().unwrap_or_default();
        if is_number(word) {
            let entries = match &mut entries {
                Some(entries) => entries,
                None => entries.insert(head.entries().map_err(|stop| stop.in_line(number))?),
            };
            entries.add(line).map_err(in_line)?;
        } else {
            let keyword = keyword(word).map_err(in_line)?;
            if entries.is_some() {
                return Err(in_line(CubeFault::Late(keyword)));
            }
            head.set(keyword, line, number).map_err(in_line)?;
        }
    }
    match entries {
        Some(entries) => entries.finished(head),
        // Sizes alone, or nothing at all.
        None => match head.entries() {
            Ok(entries) => entries.finished(head),
            Err(Stop::Fault(CubeFault::BeforeSize)) => Err(CubeProblem::NoSize),
            Err(stop) => Err(stop.in_line(number)),
        },
    }
}

/// Reads a line into `buffer`, or as much of it as shows that it is too long; whether there was one.
fn next_line(reader: &mut impl BufRead, buffer: &mut Vec<u8>) -> Result<bool, CubeProblem> {
    buffer.clear();
    let mut limited = reader.take(LONGEST_LINE as u64 + 2);
    Ok(limited.read_until(b'\n', buffer)? > 0)
}

/// A line without what is around it.
fn text(line: &[u8], number: u64) -> Result<&str, CubeFault> {
    const MARK: &[u8] = "\u{feff}".as_bytes();
    let line = match number {
        1 => line.strip_prefix(MARK).unwrap_or(line),
        _ => line,
    };
    let text = str::from_utf8(line).map_err(|_| CubeFault::NotUtf8);
    if line.len() > LONGEST_LINE && !line.ends_with(b"\n") {
        // A character may be cut at the end.
        return Err(CubeFault::Long);
    }
    Ok(text?.trim())
}

/// Whether a word is a number, or meant to be one.
fn is_number(word: &str) -> bool {
    let begins = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.');
    word.starts_with(begins) || word.parse::<f64>().is_ok()
}

/// The keyword that a line begins with.
fn keyword(word: &str) -> Result<&'static str, CubeFault> {
    if let Some(video) = VIDEO.into_iter().find(|known| *known == word) {
        return Err(CubeFault::VideoLevels(video));
    }
    let known = KEYWORDS.into_iter().find(|known| *known == word);
    known.ok_or_else(|| CubeFault::Keyword {
        found: shortened(word),
    })
}

/// Numbers at the start of a line, as many as asked for and no more.
fn numbers<const N: usize>(text: &str, expected: &'static str) -> Result<[f64; N], CubeFault> {
    // What stands behind a # is a comment.
    let text = text.split('#').next().unwrap_or_default();
    let mut words = text.split_whitespace();
    let mut numbers = [0.0; N];
    let wrong = || CubeFault::Numbers {
        expected,
        found: shortened(text.trim()),
    };
    for number in &mut numbers {
        let word = words.next().ok_or_else(wrong)?;
        *number = word.parse().map_err(|_| wrong())?;
    }
    if words.next().is_some() {
        return Err(wrong());
    }
    if numbers.iter().any(|&number| !(number as f32).is_finite()) {
        return Err(CubeFault::NotFinite(shortened(text.trim())));
    }
    Ok(numbers)
}

/// What was said, and in which line.
type Said<T> = Option<(T, u64)>;

/// What keywords say.
struct Head {
    /// Of the file.
    bytes: u64,
    title: Option<String>,
    size_1d: Option<u64>,
    size_3d: Option<u64>,
    least: Said<[f64; 3]>,
    most: Said<[f64; 3]>,
    range_1d: Said<[f64; 2]>,
    range_3d: Said<[f64; 2]>,
}

/// Why entries do not begin.
enum Stop {
    Fault(CubeFault),
    /// In a line before.
    Problem(CubeProblem),
}

impl Stop {
    fn in_line(self, line: u64) -> CubeProblem {
        match self {
            Self::Fault(fault) => CubeProblem::Line { line, fault },
            Self::Problem(problem) => problem,
        }
    }
}

impl Head {
    const fn new(bytes: u64) -> Self {
        Self {
            bytes,
            title: None,
            size_1d: None,
            size_3d: None,
            least: None,
            most: None,
            range_1d: None,
            range_3d: None,
        }
    }

    /// Takes a line with a keyword.
    fn set(&mut self, keyword: &'static str, line: &str, number: u64) -> Result<(), CubeFault> {
        let rest = line[keyword.len()..].trim();
        let range = "two numbers, such as `0 1`";
        match keyword {
            TITLE => once(&mut self.title, keyword, || {
                Ok(rest.trim_matches('"').to_owned())
            }),
            SIZE_1D => {
                once(&mut self.size_1d, keyword, || size(keyword, rest, MOST_1D))?;
                self.check_length()
            }
            SIZE_3D => {
                once(&mut self.size_3d, keyword, || size(keyword, rest, MOST_3D))?;
                self.check_length()
            }
            DOMAIN_LEAST => once(&mut self.least, keyword, || {
                Ok((numbers(rest, THREE)?, number))
            }),
            DOMAIN_MOST => once(&mut self.most, keyword, || {
                Ok((numbers(rest, THREE)?, number))
            }),
            RANGE_1D => once(&mut self.range_1d, keyword, || {
                Ok((numbers(rest, range)?, number))
            }),
            RANGE_3D => once(&mut self.range_3d, keyword, || {
                Ok((numbers(rest, range)?, number))
            }),
            _ => unreachable!("the keywords are these"),
        }
    }

    /// Entries of both tables.
    fn count(&self) -> u64 {
        self.size_1d.unwrap_or(0) + self.size_3d.map_or(0, |size| size.pow(3))
    }

    /// Whether the file has room for its tables.
    fn check_length(&self) -> Result<(), CubeFault> {
        let entries = self.count();
        // The last line may have no end.
        let least = entries * SHORTEST_LINE - 1;
        if self.bytes < least {
            let bytes = self.bytes;
            return Err(CubeFault::Short {
                entries,
                least,
                bytes,
            });
        }
        Ok(())
    }

    /// Room for the tables that were announced.
    fn entries(&self) -> Result<Entries, Stop> {
        if self.size_1d.is_none() && self.size_3d.is_none() {
            return Err(Stop::Fault(CubeFault::BeforeSize));
        }
        let [of_1d, of_3d] = self.domains().map_err(Stop::Problem)?;
        let table = |size: Option<u64>, dimensions: u32, domain| {
            let Some(size) = size else { return Ok(None) };
            let count = size.pow(dimensions) as usize;
            let mut entries = Vec::new();
            memory::reserve(&mut entries, count).map_err(|error| {
                Stop::Problem(CubeProblem::NoMemory(error.for_what("the table")))
            })?;
            Ok(Some(Filling {
                table: Table {
                    domain,
                    size: size as usize,
                    entries,
                },
                count,
            }))
        };
        Ok(Entries {
            curves: table(self.size_1d, 1, of_1d)?,
            grid: table(self.size_3d, 3, of_3d)?,
            count: self.count(),
        })
    }

    /// The ranges of the table of one dimension and of that of three.
    fn domains(&self) -> Result<[Domain; 2], CubeProblem> {
        let in_line = |line, fault| CubeProblem::Line { line, fault };
        let said = [(DOMAIN_LEAST, self.least), (DOMAIN_MOST, self.most)];
        let said = said
            .into_iter()
            .find_map(|(name, said)| Some((name, said?.1)));
        let ranges = [
            (RANGE_1D, self.range_1d, self.size_1d),
            (RANGE_3D, self.range_3d, self.size_3d),
        ];
        for (name, range, size) in ranges {
            let Some((_, line)) = range else { continue };
            if size.is_none() {
                return Err(in_line(line, CubeFault::NoTable(name)));
            }
            if let Some((domain, _)) = said {
                return Err(in_line(line, CubeFault::Beside(name, domain)));
            }
        }
        if let Some((name, line)) = said
            && self.size_1d.is_some()
            && self.size_3d.is_some()
        {
            return Err(in_line(line, CubeFault::Ambiguous(name)));
        }
        let mut domains = [Domain::default(); 2];
        for (domain, (_, range, _)) in domains.iter_mut().zip(ranges) {
            if let Some(([least, most], line)) = range {
                *domain =
                    Domain::new([least; 3], [most; 3]).map_err(|fault| in_line(line, fault))?;
            } else if let Some((_, line)) = self.most.or(self.least) {
                let Domain { least, most } = Domain::default();
                let least = self.least.map_or(least, |(least, _)| least);
                let most = self.most.map_or(most, |(most, _)| most);
                *domain = Domain::new(least, most).map_err(|fault| in_line(line, fault))?;
            }
        }
        Ok(domains)
    }
}

impl Domain {
    fn new(least: [f64; 3], most: [f64; 3]) -> Result<Self, CubeFault> {
        match least
            .into_iter()
            .zip(most)
            .find(|(least, most)| least >= most)
        {
            Some((least, most)) => Err(CubeFault::Domain { least, most }),
            None => Ok(Self { least, most }),
        }
    }
}

/// Takes what may be said once.
fn once<T>(
    said: &mut Option<T>,
    keyword: &'static str,
    value: impl FnOnce() -> Result<T, CubeFault>,
) -> Result<(), CubeFault> {
    if said.is_some() {
        return Err(CubeFault::Twice(keyword));
    }
    *said = Some(value()?);
    Ok(())
}

fn size(keyword: &'static str, text: &str, most: u64) -> Result<u64, CubeFault> {
    let text = text.split('#').next().unwrap_or_default().trim();
    let size = text.parse().ok().filter(|size| (2..=most).contains(size));
    size.ok_or_else(|| CubeFault::Size {
        keyword,
        most,
        found: shortened(text),
    })
}

/// Tables that are being filled.
struct Entries {
    curves: Option<Filling>,
    grid: Option<Filling>,
    /// Of both.
    count: u64,
}

struct Filling {
    table: Table,
    /// Entries when it is full, for which there is room.
    count: usize,
}

impl Entries {
    /// Takes a line of numbers.
    fn add(&mut self, line: &str) -> Result<(), CubeFault> {
        let entry = numbers(line, THREE)?.map(|number: f64| number as f32);
        let tables = [&mut self.curves, &mut self.grid].into_iter().flatten();
        let mut open = tables.filter(|filling| filling.table.entries.len() < filling.count);
        let filling = open.next().ok_or(CubeFault::Surplus(self.count))?;
        filling.table.entries.push(entry);
        Ok(())
    }

    /// The tables, if they are full.
    fn finished(self, head: Head) -> Result<Cube, CubeProblem> {
        let found = |filling: &Option<Filling>| {
            let entries = filling.as_ref().map(|filling| filling.table.entries.len());
            entries.unwrap_or(0) as u64
        };
        let found = found(&self.curves) + found(&self.grid);
        if found < self.count {
            return Err(CubeProblem::Missing {
                expected: self.count,
                found,
            });
        }
        let table = |filling: Filling| filling.table;
        let tables = match (self.curves.map(table), self.grid.map(table)) {
            (Some(curves), Some(grid)) => Tables::Both(curves, grid),
            (Some(curves), None) => Tables::Curves(curves),
            (None, Some(grid)) => Tables::Grid(grid),
            (None, None) => return Err(CubeProblem::NoSize),
        };
        Ok(Cube {
            title: head.title,
            name: String::new(),
            tables,
        })
    }
}

#[cfg(test)]
mod tests;
