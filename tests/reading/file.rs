//! OpenEXR files made byte by byte, as other programs have them.

use std::fs;
use std::path::{Path, PathBuf};

/// A channel in FLOAT.
pub(super) struct Channel {
    pub(super) name: Vec<u8>,
    pub(super) sampling: i32,
    /// A sample by its column and row in the file's coordinates.
    pub(super) value: Box<dyn Fn(i32, i32) -> f32>,
}

/// A part of lines, each a block.
pub(super) struct Part {
    pub(super) channels: Vec<Channel>,
    /// Left, top, right, bottom.
    pub(super) data: [i32; 4],
    pub(super) display: [i32; 4],
    /// Name, type and value of further attributes.
    pub(super) attributes: Vec<(&'static str, &'static str, Vec<u8>)>,
    pub(super) compression: u8,
    /// What becomes of a line's bytes.
    pub(super) pack: fn(&[u8]) -> Vec<u8>,
}

/// A channel with a sample for each pixel.
pub(super) fn channel(name: &str, value: impl Fn(i32, i32) -> f32 + 'static) -> Channel {
    Channel {
        name: name.as_bytes().to_vec(),
        sampling: 1,
        value: Box::new(value),
    }
}

/// Channels R, G, B with these colors, one a column.
pub(super) fn rgb(layer: &str, colors: &'static [[f32; 3]]) -> Vec<Channel> {
    let places = [("B", 2), ("G", 1), ("R", 0)];
    let names = places.map(|(name, place)| {
        let name = format!("{layer}{name}");
        channel(&name, move |x, _| colors[x as usize][place])
    });
    names.into()
}

/// A part of one row, `width` columns wide, uncompressed.
pub(super) fn row(width: i32, mut channels: Vec<Channel>) -> Part {
    channels.sort_by(|a, b| a.name.cmp(&b.name));
    let window = [0, 0, width - 1, 0];
    Part {
        channels,
        data: window,
        display: window,
        attributes: Vec::new(),
        compression: 0,
        pack: <[u8]>::to_vec,
    }
}

impl Part {
    pub(super) fn with(
        mut self,
        name: &'static str,
        kind: &'static str,
        value: impl Into<Vec<u8>>,
    ) -> Self {
        self.attributes.push((name, kind, value.into()));
        self
    }

    pub(super) fn chromaticities(self, numbers: [f32; 8]) -> Self {
        let bytes: Vec<u8> = numbers.into_iter().flat_map(f32::to_le_bytes).collect();
        self.with("chromaticities", "chromaticities", bytes)
    }

    fn header(&self, is_multi_part: bool) -> Vec<u8> {
        let mut list = Vec::new();
        for channel in &self.channels {
            list.extend_from_slice(&channel.name);
            list.extend_from_slice(&[0, 2, 0, 0, 0, 0, 0, 0, 0]);
            list.extend([channel.sampling; 2].into_iter().flat_map(i32::to_le_bytes));
        }
        list.push(0);
        let window = |sides: [i32; 4]| sides.into_iter().flat_map(i32::to_le_bytes).collect();
        let float = |value: f32| value.to_le_bytes().to_vec();
        let mut attributes: Vec<(&str, &str, Vec<u8>)> = vec![
            ("channels", "chlist", list),
            ("compression", "compression", vec![self.compression]),
            ("dataWindow", "box2i", window(self.data)),
            ("displayWindow", "box2i", window(self.display)),
            ("lineOrder", "lineOrder", vec![0]),
            ("pixelAspectRatio", "float", float(1.0)),
            ("screenWindowCenter", "v2f", vec![0; 8]),
            ("screenWindowWidth", "float", float(1.0)),
        ];
        if is_multi_part {
            let count = self.data[3] - self.data[1] + 1;
            attributes.push(("type", "string", b"scanlineimage".to_vec()));
            attributes.push(("chunkCount", "int", count.to_le_bytes().to_vec()));
        }
        for own in &self.attributes {
            attributes.retain(|(name, _, _)| *name != own.0);
            attributes.push(own.clone());
        }
        let mut header = Vec::new();
        for (name, kind, value) in attributes {
            header.extend_from_slice(name.as_bytes());
            header.push(0);
            header.extend_from_slice(kind.as_bytes());
            header.push(0);
            header.extend_from_slice(&(value.len() as i32).to_le_bytes());
            header.extend_from_slice(&value);
        }
        header.push(0);
        header
    }

    /// The blocks, with their coordinates and lengths.
    fn blocks(&self) -> Vec<Vec<u8>> {
        let [left, top, right, bottom] = self.data;
        let line = |y: i32| {
            let mut line = Vec::new();
            for channel in &self.channels {
                let step = channel.sampling;
                if y % step == 0 {
                    let columns = (left..=right).filter(|x| x % step == 0);
                    line.extend(columns.flat_map(|x| (channel.value)(x, y).to_le_bytes()));
                }
            }
            let packed = (self.pack)(&line);
            let mut block = y.to_le_bytes().to_vec();
            block.extend_from_slice(&(packed.len() as i32).to_le_bytes());
            block.extend_from_slice(&packed);
            block
        };
        (top..=bottom).map(line).collect()
    }
}

/// A file of one part, or of many.
pub(super) fn bytes(parts: &[Part]) -> Vec<u8> {
    let is_multi_part = parts.len() > 1;
    let mut file = vec![0x76, 0x2f, 0x31, 0x01, 2];
    file.extend_from_slice(if is_multi_part {
        &[0x10, 0, 0]
    } else {
        &[0; 3]
    });
    for part in parts {
        file.extend(part.header(is_multi_part));
    }
    if is_multi_part {
        file.push(0);
    }
    let blocks: Vec<Vec<Vec<u8>>> = parts.iter().map(Part::blocks).collect();
    let number = if is_multi_part { 4 } else { 0 };
    let mut place = file.len() + 8 * blocks.iter().map(Vec::len).sum::<usize>();
    for block in blocks.iter().flatten() {
        file.extend_from_slice(&(place as u64).to_le_bytes());
        place += number + block.len();
    }
    for (part, blocks) in blocks.iter().enumerate() {
        for block in blocks {
            if is_multi_part {
                file.extend_from_slice(&(part as i32).to_le_bytes());
            }
            file.extend_from_slice(block);
        }
    }
    file
}

/// Writes a file of these parts.
pub(super) fn write(folder: &Path, parts: &[Part]) -> PathBuf {
    let path = folder.join("a.exr");
    fs::write(&path, bytes(parts)).unwrap();
    path
}
