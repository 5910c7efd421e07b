//! The first difference between the headers of two tiles that should be of one image.

use super::totals::is_total;
use crate::exr::read::Attribute;
use crate::exr::tile::{TILE, TILE_HASH, TILE_WINDOW};
use crate::printable::{printable_bytes, shortened};

/// What tells most comes first: where the scene has changed, so may have much else.
const TELLING: [&str; 15] = [
    "software",
    "candela:inputs_sha256",
    "candela:scene_sha256",
    "candela:frame",
    "candela:set",
    "candela:samples",
    "candela:max_error",
    "candela:max_samples",
    "candela:error_floor",
    "candela:layers",
    "candela:transport",
    "displayWindow",
    TILE_WINDOW,
    "compression",
    "channels",
];

/// As many characters before the first that differ are shown.
const BEFORE: usize = 16;

/// An attribute that is not the same in both.
#[derive(Clone, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub struct Difference {
    attribute: String,
    pub(super) values: [String; 2],
}

impl Difference {
    /// How a message names it.
    pub(super) fn name(&self) -> String {
        format!("`{}`", shortened(&self.attribute))
    }

    /// What helps.
    pub(super) fn way_out(&self) -> &'static str {
        match self.attribute.as_str() {
            "software" => "render all tiles with one version",
            "candela:inputs_sha256" | "candela:scene_sha256" => {
                "the scene or a file that it names has changed, so render all tiles of the new one"
            }
            "candela:frame" => "an image is merged from tiles of one frame",
            _ => "render all tiles with the same options",
        }
    }
}

/// The first difference, if there is one, beside those that tiles of one image have.
pub(super) fn difference(
    versions: [u32; 2],
    [first, second]: [&[Attribute]; 2],
) -> Option<Difference> {
    let named = |list: &'_ [Attribute], name: &[u8]| {
        let mut all = list.iter();
        all.position(|attribute| attribute.name == name)
    };
    let names = TELLING.iter().map(|name| name.as_bytes());
    let names = names.chain([first, second].into_iter().flatten().map(|it| &it.name[..]));
    for name in names {
        if is_own(name) {
            continue;
        }
        let one = named(first, name).map(|place| &first[place]);
        let other = named(second, name).map(|place| &second[place]);
        let is_same = match (one, other) {
            (Some(one), Some(other)) if is_total(name) => one.kind == other.kind,
            (one, other) => one == other,
        };
        if !is_same {
            return Some(Difference {
                attribute: String::from_utf8_lossy(name).into_owned(),
                values: shown([one, other]),
            });
        }
    }
    (versions[0] != versions[1]).then(|| Difference {
        attribute: "version".to_owned(),
        values: versions.map(|version| format!("{version:#x}")),
    })
}

/// Whether each tile has its own.
fn is_own(name: &[u8]) -> bool {
    [TILE, TILE_HASH, "dataWindow", "chunkCount"]
        .iter()
        .any(|own| own.as_bytes() == name)
}

/// Two values for a message, from about where they part on.
fn shown(pair: [Option<&Attribute>; 2]) -> [String; 2] {
    let texts = pair.map(|attribute| attribute.map(value));
    let [Some(Shown::Text(one)), Some(Shown::Text(other))] = &texts else {
        return texts.map(|text| match text {
            None => "not there".to_owned(),
            Some(Shown::Text(text)) => format!("`{}`", shortened(&text)),
            Some(Shown::Numbers(numbers)) => numbers,
        });
    };
    let same = one.chars().zip(other.chars()).take_while(|(a, b)| a == b);
    let skipped = same.count().saturating_sub(BEFORE);
    [one, other].map(|text| {
        let rest: String = text.chars().skip(skipped).collect();
        let dots = if skipped > 0 { "…" } else { "" };
        format!("`{dots}{}`", shortened(&rest))
    })
}

/// A value for a message.
enum Shown {
    Text(String),
    Numbers(String),
}

/// The names of the compressions by their numbers in the format.
const COMPRESSIONS: [&str; 10] = [
    "none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab",
];

fn value(attribute: &Attribute) -> Shown {
    let Attribute { kind, value, .. } = attribute;
    let (numbers, rest) = value.as_chunks::<4>();
    let numbers_of = |text: &dyn Fn([u8; 4]) -> String| {
        let list: Vec<String> = numbers.iter().map(|&bytes| text(bytes)).collect();
        list.join(" ")
    };
    match (kind.as_slice(), value.as_slice()) {
        (b"string", _) => Shown::Text(String::from_utf8_lossy(value).into_owned()),
        (b"chlist", _) => Shown::Text(channels(value)),
        (b"compression", &[number]) => {
            let name = COMPRESSIONS.get(usize::from(number)).copied();
            Shown::Numbers(name.unwrap_or("unknown").to_owned())
        }
        (b"int" | b"box2i", _) if rest.is_empty() && numbers.len() <= 4 => {
            Shown::Numbers(numbers_of(&|bytes| i32::from_le_bytes(bytes).to_string()))
        }
        (b"float" | b"v2f" | b"m44f" | b"chromaticities", _)
            if rest.is_empty() && numbers.len() <= 16 =>
        {
            Shown::Numbers(numbers_of(&|bytes| f32::from_le_bytes(bytes).to_string()))
        }
        _ => Shown::Numbers(format!(
            "{} bytes of type {}",
            value.len(),
            printable_bytes(kind)
        )),
    }
}

/// Names and types of channels. The list was found to be sound.
fn channels(mut list: &[u8]) -> String {
    let mut texts = Vec::new();
    while let Some(end) = list
        .iter()
        .position(|&byte| byte == 0)
        .filter(|&end| end > 0)
    {
        let kind = match list.get(end + 1) {
            Some(0) => "UINT",
            Some(1) => "HALF",
            Some(_) | None => "FLOAT",
        };
        texts.push(format!("{} {kind}", String::from_utf8_lossy(&list[..end])));
        // Type, whether linear, sampling.
        list = list.get(end + 17..).unwrap_or_default();
    }
    texts.join(", ")
}
