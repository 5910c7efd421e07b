//! Files as a whole: what of them stays, and what of them is damaged.

use std::fs;
use std::path::Path;

use candela::exr::{Compression, ExrOptions, Precision};
use candela::output::Unfinished;
use candela::relight::relight;
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue;
use exr::prelude::{LayerAttributes, SmallVec, Text, Vec2, WritableImage};
use half::f16;

use super::{FILL, KEY, RIM, change, in_rgb, lit, planes, settings, write};
use crate::fuzzing;
use crate::openimageio::{idiff_agrees_within, oiiotool};

/// The text of an attribute of a file.
pub(super) fn find_text(path: &Path, name: &str) -> Option<String> {
    let meta = MetaData::read_from_file(path, false).unwrap();
    let other = &meta.headers[0].own_attributes.other;
    match other.get(name.as_bytes())? {
        AttributeValue::Text(text) => Some(text.to_string()),
        other => panic!("{other:?}"),
    }
}

pub(super) fn text(path: &Path, name: &str) -> String {
    find_text(path, name).unwrap()
}

/// Compression, types, windows and all that is not about light stay, and files of candela stay such to the byte.
#[test]
fn a_file_stays_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a.exr", "b.exr"].map(|name| folder.path().join(name));
    let film = lit(&in_rgb([KEY, FILL, RIM]), [30.0, 12.0, 20.0]);
    for compression in Compression::ALL {
        for precision in [Precision::Float, Precision::Half] {
            let options = ExrOptions {
                precision,
                compression,
                chromaticities: true,
                full_window: false,
                tile: None,
            };
            write(&film, &a, &options);
            relight(&a, &b, &settings(&["key=1"]), &Unfinished::new()).unwrap();
            let [was, is] = [&a, &b].map(|path| MetaData::read_from_file(path, false).unwrap());
            let [mut was, mut is] = [was, is].map(|meta| meta.headers[0].clone());
            let other = &mut is.own_attributes.other;
            assert!(other.remove("candela:relit".as_bytes()).is_some());
            // Numbers of the record have been read and written.
            let record = other.get("candela:lights".as_bytes());
            assert!(record.is_some());
            let record = was.own_attributes.other[&Text::from("candela:lights")].clone();
            other.insert(Text::from("candela:lights"), record);
            // The new picture is the sum of layers that are rounded already.
            let residual = Text::from("candela:residual");
            assert!(other.remove(&residual).is_some());
            was.own_attributes.other.remove(&residual);
            assert_eq!(was, is, "{compression} {precision:?}");
            if compression.is_lossless(precision) {
                assert_eq!(planes(&a), planes(&b), "{compression} {precision:?}");
            }
            change(&b, &["key=2", "fill=off"]).unwrap();
        }
    }
}

/// Halves, floats and integers of another program's file, in lines from the bottom, at a place outside of the picture.
#[test]
fn types_and_places_of_others_stay() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let half = |values: [f32; 6]| FlatSamples::F16(values.map(f16::from_f32).to_vec());
    let light = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let mut list: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    for name in ["R", "G", "B", "light_key.R", "light_key.G", "light_key.B"] {
        list.push(AnyChannel::new(name, half(light)));
    }
    let ids = vec![0, 1, 0x0100_0001, u32::MAX, 77, 1 << 30];
    list.push(AnyChannel::new("id", FlatSamples::U32(ids.clone())));
    let nan = f32::from_bits(0xffc0_0007);
    list.push(AnyChannel::new("shadow_a", FlatSamples::F32(vec![nan; 6])));
    let mut layer = Layer::new(
        (3, 2),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(list),
    );
    layer.attributes.layer_position = Vec2(-7, 5);
    layer.encoding.line_order = exr::meta::attribute::LineOrder::Decreasing;
    layer.encoding.blocks = exr::image::Blocks::ScanLines;
    let long = "an_attribute_whose_name_is_longer_than_31_bytes";
    let other = &mut layer.attributes.other;
    other.insert(Text::from(long), AttributeValue::F32(0.1));
    Image::from_layer(layer).write().to_file(&path).unwrap();
    change(&path, &["key=0.5"]).unwrap();

    let image = exr::prelude::read_all_flat_layers_from_file(&path).unwrap();
    let layer = &image.layer_data[0];
    assert_eq!(layer.attributes.layer_position, Vec2(-7, 5));
    assert_eq!(
        layer.attributes.other[&Text::from(long)],
        AttributeValue::F32(0.1)
    );
    for channel in &layer.channel_data.list {
        let name = channel.name.to_string();
        match (&channel.sample_data, name.as_str()) {
            (FlatSamples::U32(values), "id") => assert_eq!(values, &ids),
            (FlatSamples::F32(values), "shadow_a") => {
                assert!(values.iter().all(|value| value.to_bits() == nan.to_bits()));
            }
            (FlatSamples::F16(values), _) => {
                let expected = light.map(|value| f16::from_f32(value / 2.0));
                assert_eq!(values, &expected, "{name}");
            }
            (other, name) => panic!("{name}: {other:?}"),
        }
    }
    assert_eq!(layer.channel_data.list.len(), 8);
}

/// OpenImageIO adds the layers up to the same picture.
#[test]
fn oiiotool_adds_up_to_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let [path, relit] = ["a.exr", "relit.exr"].map(|name| folder.path().join(name));
    let film = lit(&in_rgb([KEY, FILL, RIM]), [30.0, 12.0, 20.0]);
    write(&film, &path, &ExrOptions::default());
    relight(
        &path,
        &relit,
        &settings(&["key=2.5", "fill=off"]),
        &Unfinished::new(),
    )
    .unwrap();
    let layer = |name: &str, factor: &str| {
        let channels = ["R", "G", "B"]
            .map(|c| format!("{c}=light_{name}.{c}"))
            .join(",");
        format!("a.exr --ch {channels} --mulc {factor}")
    };
    let [key, rim, sky] = [
        layer("key", "2.5"),
        layer("rim", "1"),
        layer("background", "1"),
    ];
    oiiotool(
        folder.path(),
        &format!("{key} {rim} --add {sky} --add -d float -o sum.exr"),
    );
    oiiotool(folder.path(), "relit.exr --ch R,G,B -o beauty.exr");
    let [sum, beauty] = ["sum.exr", "beauty.exr"].map(|name| folder.path().join(name));
    // Its sums are in f32: three roundings and a product's.
    assert!(idiff_agrees_within(
        &sum,
        &beauty,
        4.0 * 0.5_f64.powi(24),
        0
    ));
    oiiotool(folder.path(), "a.exr --ch R,G,B -o beauty.exr");
    assert!(!idiff_agrees_within(
        &sum,
        &beauty,
        4.0 * 0.5_f64.powi(24),
        0
    ));
}

#[test]
fn what_is_not_rewritten_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tiles.exr");
    oiiotool(
        folder.path(),
        "--pattern constant:color=.1,.2,.3 64x64 3 --tile 32 32 -d half -o tiles.exr",
    );
    let message = change(&path, &["key=2"]).unwrap_err().to_string();
    assert!(
        message.contains("it has tiles; save it in scan lines"),
        "{message}"
    );
    oiiotool(
        folder.path(),
        "--pattern constant:color=.1,.2,.3 8x8 3 --dup --siappend -d half -o parts.exr",
    );
    let path = folder.path().join("parts.exr");
    let message = change(&path, &["key=2"]).unwrap_err().to_string();
    assert!(message.contains("it has parts"), "{message}");
}

/// Wherever a file ends too early, it is an error, and no file is made or changed.
#[test]
fn truncated_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, cut, out] = ["a.exr", "cut.exr", "out.exr"].map(|name| folder.path().join(name));
    let film = lit(&in_rgb([KEY, FILL, RIM]), [30.0, 12.0, 20.0]);
    write(&film, &whole, &ExrOptions::default());
    let bytes = fs::read(&whole).unwrap();
    fs::write(&out, "old").unwrap();
    for parts in 0..40 {
        let length = bytes.len() * parts / 40;
        fs::write(&cut, &bytes[..length]).unwrap();
        let error = relight(&cut, &out, &settings(&["key=2"]), &Unfinished::new());
        let message = error.unwrap_err().to_string();
        assert!(message.contains("cut.exr"), "{message}");
        change(&cut, &["key=2,#ff8040"]).unwrap_err();
        assert!(fs::read(&cut).unwrap() == bytes[..length]);
    }
    assert_eq!(fs::read(&out).unwrap(), b"old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3);
}

/// Damaged files are read or refused, in bounded time and memory.
#[test]
fn damaged_files_are_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["a.exr", "b.exr"].map(|name| folder.path().join(name));
    let film = lit(&in_rgb([KEY, FILL, RIM]), [30.0, 12.0, 20.0]);
    let file = |precision, compression| {
        let options = ExrOptions {
            precision,
            compression,
            ..ExrOptions::default()
        };
        write(&film, &input, &options);
        fs::read(&input).unwrap()
    };
    let corpus = [
        file(Precision::Half, Compression::Zip),
        file(Precision::Float, Compression::None),
    ];
    let corpus: Vec<&[u8]> = corpus.iter().map(Vec::as_slice).collect();
    let settings = settings(&["key=2,#ff8040", "fill=off"]);
    let outcomes = fuzzing::run("relight", &corpus, 300, |bytes| {
        fs::write(&input, bytes).unwrap();
        relight(&input, &output, &settings, &Unfinished::new())
    });
    assert!(
        outcomes.accepted > 0 && outcomes.refused > 0,
        "{outcomes:?}"
    );
}
