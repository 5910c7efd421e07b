//! The header of a PLY file: which elements follow, and what each is made of.

use super::super::MeshRemarks;
use super::super::error::{ElementPlace, Fault, MeshError};
use super::super::text::{Dialect, Scanner};

/// What stands between `ply` and `end_header`.
#[derive(Debug)]
pub(super) struct Header<'a> {
    pub(super) format: Format,
    pub(super) elements: Vec<Element<'a>>,
    /// Lines before the first element that are none of the format, as some programs write comments.
    pub(super) remarks: MeshRemarks,
    /// The first byte after it.
    pub(super) end: usize,
    /// The line of `end_header`.
    pub(super) last_line: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Ascii,
    Binary(Endian),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Endian {
    Little,
    Big,
}

#[derive(Debug)]
pub(super) struct Element<'a> {
    pub(super) name: &'a [u8],
    pub(super) count: u64,
    pub(super) properties: Vec<Property<'a>>,
    /// Its line in the header.
    pub(super) line: usize,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Property<'a> {
    pub(super) name: &'a [u8],
    pub(super) kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { length: Scalar, item: Scalar },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl<'a> Header<'a> {
    /// Reads the header of a file that starts like this; `None` where it goes on beyond, unless
    /// that is all of the file.
    pub(super) fn parse(bytes: &'a [u8], is_all: bool) -> Result<Option<Self>, MeshError> {
        let mut scanner = Scanner::new(bytes, Dialect::Ply);
        scanner.word();
        scanner.skip_blanks();
        let ends_in_cr = scanner.rest().starts_with(b"\r") && !scanner.rest().starts_with(b"\r\n");
        scanner
            .end_line("nothing but `ply` on the first line")
            .map_err(|fault| fault.at_line(1))?;
        let mut format = None;
        let mut elements = Vec::new();
        let mut remarks = MeshRemarks::default();
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
                    scanner.skip_blanks();
                    if ends_in_cr && scanner.accept(b'\r') {
                        // A line feed is the first byte of what follows.
                        break;
                    }
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
                other if elements.is_empty() && format.is_some() => {
                    remarks.unknown(other);
                    scanner.skip_line();
                    continue;
                }
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
            remarks,
            end: scanner.position(),
            last_line: line,
        }))
    }

    /// The element of that name, if there is one.
    pub(super) fn element(&self, name: &[u8]) -> Result<Option<&Element<'a>>, MeshError> {
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
            let length = parse_scalar(length)?;
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

    pub(super) const fn is_integer(self) -> bool {
        match self {
            Self::I8 | Self::U8 | Self::I16 | Self::U16 | Self::I32 | Self::U32 => true,
            Self::F32 | Self::F64 => false,
        }
    }

    /// Its size in binary files, in bytes.
    pub(super) const fn size(self) -> usize {
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
    pub(super) fn place(&self, index: u64) -> Option<ElementPlace> {
        const READABLE: usize = 40;
        let name = &self.name[..self.name.len().min(READABLE)];
        Some(ElementPlace {
            name: name.escape_ascii().to_string(),
            index,
            count: self.count,
        })
    }

    /// The number of the property of that name, if there is one.
    pub(super) fn property(&self, name: &[u8]) -> Result<Option<usize>, MeshError> {
        let mut named = (0..self.properties.len()).filter(|&i| self.properties[i].name == name);
        let first = named.next();
        match named.next() {
            Some(_) => Err(Fault::duplicate("property", name).at_line(self.line)),
            None => Ok(first),
        }
    }
}

impl Fault {
    fn duplicate(what: &'static str, name: &[u8]) -> Box<Self> {
        let name = name.escape_ascii().to_string();
        Box::new(Self::Duplicate { what, name })
    }
}
