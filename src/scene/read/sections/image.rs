//! `[image]`

use toml::de::{DeTable, DeValue};

use super::super::super::diagnostic::{Problem, Span, Spanned};
use super::super::super::value::{Transport, Value};
use super::super::super::{DEFAULT_DEPTH, Image, LARGEST_DEPTH, MAX_RESOLUTION};
use super::super::Node;
use super::super::fields::{Fields, Reader, spanned};
use super::super::key::{BRIGHTEST, Elsewhere, Form, Key, Kind, Purpose, key};
use super::super::notation::space_names;
use super::super::syntax::header;
use crate::spectrum::Observer;

const RESOLUTION: Key = key!("resolution", "width and height in pixels", "[1280, 720]")
    .of(Kind::Pixels)
    .about("Width and height in pixels, 1 to 65536 each.")
    .also(&["size", "res", "dimensions", "image_size"]);
const COLOR_SPACE: Key = key!("color_space", "the name of a color space", "\"rec709\"")
    .of(Kind::Name(space_names))
    .or("\"rec709\"")
    .about("The space in which light is computed and the EXR is written.")
    .also(&["colour_space", "colorspace", "colourspace", "working_space"]);
const BACKGROUND: Key = key!(
    "background",
    "a radiance in cd/m² (a number, `[r, g, b]` or `\"#rrggbb\"`) or a curve",
    "[0, 0, 0]"
)
.of(Kind::Value(Purpose::Background, BRIGHTEST))
.or("0")
.about("Radiance in cd/m² where a ray hits nothing; alpha is 0 there.")
.also(&["background_color", "bg", "sky"]);
const TRANSPORT: Key = key!("transport", "how light is carried", "\"auto\"")
    .of(Kind::Name(transport_names))
    .or("\"auto\"")
    .about(
        "How light is carried: \"auto\" is spectral if anything in the scene is a spectrum or in watts.",
    );
const OBSERVER: Key = key!("observer", "the year of a CIE observer", "\"1931\"")
    .of(Kind::Name(observer_names))
    .or("\"1931\"")
    .about("Whose eye sees spectra: the CIE's 2° observer of 1931 or its 10° observer of 1964.");

const MAX_DEPTH: Key = key!("max_depth", "a whole number from 0 to 1000", "8")
    .of(Kind::Count(LARGEST_DEPTH))
    .or("8")
    .about(
        "How often light may be reflected by mirrors and refracted by glass on its way to the viewer: 0 to 1000. What \
         is left out has a bound, which the image's metadata say.",
    )
    .also(&[
        "depth",
        "bounces",
        "maxdepth",
        "max_bounces",
        "max_trace_level",
        "ray_depth",
        "specular_depth",
    ]);

/// The default of `max_depth` as text.
const _: () = assert!(DEFAULT_DEPTH == 8);

/// `[image]`
pub(in crate::scene::read) const IMAGE: Form<'_> = Form::new(&[
    &RESOLUTION,
    &COLOR_SPACE,
    &BACKGROUND,
    &TRANSPORT,
    &OBSERVER,
    &MAX_DEPTH,
])
.elsewhere(&[
    Elsewhere {
        words: &["width", "height", "x_resolution", "y_resolution", "xresolution", "yresolution"],
        key: Some("resolution"),
        advice: "write `resolution = [width, height]`, such as `resolution = [1280, 720]`",
    },
    Elsewhere {
        words: &["samples", "spp", "samples_per_pixel", "pixel_samples", "sample_count"],
        key: None,
        advice: "samples are chosen for each run: `candela render --samples N`",
    },
    Elsewhere {
        words: &["exposure", "ev", "gamma", "view", "tonemap", "tone_mapping"],
        key: None,
        advice: "an EXR holds radiance as it is; `candela tonemap --exposure EV --view NAME` makes a \
                 picture of it",
    },
    Elsewhere {
        words: &["output", "file", "filename", "path"],
        key: None,
        advice: "the file is named for each run: `candela render -o FILE.exr`",
    },
    Elsewhere {
        words: &["threads", "crop", "region", "layers", "aovs", "compression"],
        key: None,
        advice: "that is chosen for each run; see `candela render --help`",
    },
    Elsewhere {
        words: &["integrator", "max_diffuse_bounces", "diffuse_depth"],
        key: None,
        advice: "surfaces are lit by lamps alone; `max_depth` is how often mirrors and glass are followed",
    },
    Elsewhere {
        words: &["ambient"],
        key: None,
        advice: "there is no ambient light; `background` is what is seen where nothing is",
    },
]);

fn transport_names() -> Vec<&'static str> {
    Transport::ALL.map(Transport::name).to_vec()
}

fn observer_names() -> Vec<&'static str> {
    Observer::ALL.map(Observer::name).to_vec()
}

/// `[image]`; `misspelt` are the sections that are there under another name.
pub(in crate::scene::read) fn image(
    reader: &mut Reader<'_>,
    root: &DeTable<'_>,
    misspelt: &[String],
) -> Option<Image> {
    let Some((key, node)) = root.get_key_value("image") else {
        let problem = Problem::Missing {
            what: "section",
            name: "[image]".to_owned(),
            expected: "`[image]` with its `resolution`, such as `resolution = [1280, 720]`",
        };
        if !misspelt.iter().any(|section| section == "image") {
            reader.report(Span::default(), problem);
        }
        return None;
    };
    let DeValue::Table(table) = node.get_ref() else {
        reader.wrong_type("image", node, "a section with the header `[image]`");
        return None;
    };
    let header = header(reader.text, key.span().into(), node);
    let sound = !reader.damage.reaches(header.start);
    let mut fields = Fields::new(reader, IMAGE, table, header);
    let resolution = resolution(&mut fields);
    let color_space = fields.color_space(&COLOR_SPACE);
    let background = fields.value_or(&BACKGROUND, Purpose::Background, Value::ZERO);
    let transport = fields.choice(&TRANSPORT, "transport", &Transport::ALL, Transport::name);
    let observer = fields.choice(&OBSERVER, "observer", &Observer::ALL, Observer::name);
    let max_depth = match fields.get(&MAX_DEPTH) {
        Some(node) => spanned(fields.reader.number(&MAX_DEPTH, MAX_DEPTH.name, node), node),
        None => Some(Spanned::new(f64::from(DEFAULT_DEPTH), fields.header)),
    };
    fields.finish()?;
    sound.then_some(Image {
        resolution: resolution?,
        color_space: color_space?,
        background: background?,
        transport: transport?,
        observer: observer?,
        max_depth: max_depth?,
    })
}

fn resolution(fields: &mut Fields<'_, '_, '_>) -> Option<Spanned<[u32; 2]>> {
    let node = fields.require(&RESOLUTION)?;
    let [width, height] = fields
        .reader
        .items::<2>(&RESOLUTION, RESOLUTION.name, node)?;
    let width = pixels(fields.reader, "resolution[0]", width);
    let height = pixels(fields.reader, "resolution[1]", height);
    spanned(
        width.zip(height).map(|(width, height)| [width, height]),
        node,
    )
}

/// A number of pixels, as far as u32 holds it; the range is checked with all other ranges.
fn pixels(reader: &mut Reader<'_>, name: &str, node: &Node<'_>) -> Option<u32> {
    let DeValue::Integer(integer) = node.get_ref() else {
        reader.wrong_type(name, node, "a whole number of pixels, such as `1280`");
        return None;
    };
    let pixels = i128::from_str_radix(integer.as_str(), integer.radix())
        .ok()
        .and_then(|pixels| u32::try_from(pixels).ok());
    if pixels.is_none() {
        let problem = Problem::OutOfRange {
            key: RESOLUTION.name,
            value: integer.to_string(),
            expected: format!("1 to {MAX_RESOLUTION} pixels"),
        };
        reader.report(node.span().into(), problem);
    }
    pixels
}
