//! Every channel of a file by itself, as numbers: for whoever compares files.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::blocks::Blocks;
use super::color::ColorTag;
use super::header::Headers;
use super::layers::{Shape, Shown};
use super::source::Source;
use super::{ExrError, ExrProblem};

/// An OpenEXR file that is open, with all its channels.
#[derive(Debug)]
pub struct ExrChannels {
    path: PathBuf,
    parts: Vec<OpenPart>,
    names: Vec<ChannelName>,
}

#[derive(Debug)]
struct OpenPart {
    blocks: Blocks,
    window: DataWindow,
    color: ColorTag,
}

/// A channel's name, and where it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelName {
    /// The whole name, `layer.channel`; with that of its part before it where an earlier part has a channel of
    /// the same name.
    pub name: String,
    part: usize,
    place: usize,
}

/// Where a channel has pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataWindow {
    /// Width and height of the display window.
    pub resolution: [u32; 2],
    /// The data window's left column and top row, from the display window's top left.
    pub corner: [i64; 2],
    /// Width and height of the data window.
    pub size: [u32; 2],
}

impl DataWindow {
    /// How many pixels it has.
    pub const fn count(self) -> u64 {
        self.size[0] as u64 * self.size[1] as u64
    }
}

impl ExrChannels {
    /// Opens a file, or a pipe or device, which is read into memory. `-` is standard input.
    ///
    /// # Errors
    /// See [`ExrProblem`].
    pub fn open(path: &Path) -> Result<Self, ExrError> {
        let opened = Source::open(path).and_then(|source| Self::new(path, source));
        opened.map_err(|problem| ExrError {
            path: path.to_path_buf(),
            problem,
        })
    }

    fn new(path: &Path, source: Source) -> Result<Self, ExrProblem> {
        let headers = Headers::read(&source)?;
        let source = Arc::new(source);
        let (mut parts, mut names) = (Vec::new(), Vec::new());
        let mut seen = BTreeSet::new();
        for (number, part) in headers.parts.iter().enumerate() {
            if part.is_deep {
                return Err(super::deep());
            }
            for (place, channel) in part.channels.iter().enumerate() {
                let mut name = String::from_utf8_lossy(&channel.name).into_owned();
                if !seen.insert(name.clone()) {
                    let part = String::from_utf8_lossy(&part.name);
                    name = format!("{part}.{name}");
                    if !seen.insert(name.clone()) {
                        return Err(super::damaged("two of its channels have one name"));
                    }
                }
                names.push(ChannelName {
                    name,
                    part: number,
                    place,
                });
            }
            let shown = Shown {
                part: number,
                channels: Shape::Single(0),
                alpha: None,
            };
            let blocks = Blocks::new(Arc::clone(&source), &headers, shown, [0.0; 3])?;
            let corner = [0, 1].map(|side| {
                i64::from(part.data_window[side]) - i64::from(part.display_window[side])
            });
            parts.push(OpenPart {
                window: DataWindow {
                    resolution: blocks.geometry.resolution,
                    corner,
                    size: blocks.geometry.size,
                },
                blocks,
                color: part.color.clone(),
            });
        }
        Ok(Self {
            path: path.to_path_buf(),
            parts,
            names,
        })
    }

    /// All channels, part by part, in the file's order.
    pub fn names(&self) -> &[ChannelName] {
        &self.names
    }

    /// Where a channel has pixels.
    pub fn window(&self, channel: &ChannelName) -> DataWindow {
        self.parts[channel.part].window
    }

    /// What the file says about the color space of the part that a channel is in.
    pub fn color(&self, channel: &ChannelName) -> &ColorTag {
        &self.parts[channel.part].color
    }

    /// All samples of these channels, row by row of the data window, in new memory: half and unsigned int as
    /// the numbers that they are; a channel of fewer samples than pixels is repeated.
    ///
    /// # Errors
    /// See [`ExrProblem`].
    pub fn read(&self, channels: &[&ChannelName]) -> Result<Vec<Vec<f32>>, ExrError> {
        let mut planes: Vec<Vec<f32>> = channels.iter().map(|_| Vec::new()).collect();
        for (number, part) in self.parts.iter().enumerate() {
            let wanted = channels.iter().enumerate();
            let wanted: Vec<(usize, usize)> = wanted
                .filter_map(|(index, channel)| {
                    (channel.part == number).then_some((index, channel.place))
                })
                .collect();
            if wanted.is_empty() {
                continue;
            }
            let places: Vec<usize> = wanted.iter().map(|&(_, place)| place).collect();
            let read = part.blocks.planes(&places).map_err(|problem| ExrError {
                path: self.path.clone(),
                problem,
            })?;
            for ((index, _), plane) in wanted.into_iter().zip(read) {
                planes[index] = plane;
            }
        }
        Ok(planes)
    }
}
