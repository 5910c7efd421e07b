//! `candela tonemap`: a PNG or TIFF of an EXR, or of a picture of another format.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::Failure;
use super::develop::DevelopArguments;
use candela::display::{self, Alpha, Bits, Exposure, Frame, Input, OutputFormat, Settings};
use candela::internal::printable_path;
use candela::output::Unfinished;
use clap::builder::{OsStringValueParser, PossibleValuesParser, TypedValueParser};

/// Make a PNG or TIFF of an EXR: expose, map to the screen's range, encode as sRGB
///
/// Reads any OpenEXR file, from candela or elsewhere: R, G, B, A, or luminance Y with or without
/// chroma, or a layer of it, in the linear color space that it names (Rec.709 where it names none), and
/// shows its display window. 1.0 in the file becomes the screen's white, unless an exposure is given.
/// Deep pixels and HTJ2K compression are not read; the message says how to convert such a file.
///
/// Reads PNG, JPEG, TIFF and Radiance HDR as well, whatever they are called: codes become linear light,
/// white is 1.0; floats of a TIFF and the numbers of an HDR are light as they are.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela tonemap scene.exr
      Make scene.png here, as it is
  candela tonemap scene.exr -o bright.png --exposure 2
      Four times as bright
  candela tonemap scene.exr --auto-exposure --view reinhard
      Bring any scene into view, without clipping
  candela tonemap scene.exr --layer light_key -o key.png
      What one light adds, of an EXR with a layer for each light
  candela tonemap scene.exr --bits 16 --alpha opaque
      16 bits, over black, without alpha
  candela tonemap scene.exr -o scene.tif --bits 32
      A TIFF of floats: code values that neither clip nor are rounded
  candela tonemap studio.hdr --exposure 1 -o studio.png
      A picture of another format
  candela render scene.toml -o - | candela tonemap - -o scene.png
      Through a pipe")]
pub(crate) struct Arguments {
    /// The EXR file, or a PNG, JPEG, TIFF or Radiance HDR; - is standard input
    #[arg(value_name = "IN.exr")]
    input: PathBuf,

    /// The PNG file, or a TIFF where the name ends in .tif or .tiff; - is a PNG to standard output
    /// [default: IN.png in the current folder]
    #[arg(short, long, value_name = "OUT.png", value_parser = picture_path())]
    output: Option<PathBuf>,

    /// The layer, channel or part to show [default: the channels R, G, B, A outside of layers]
    ///
    /// light_key shows light_key.R, .G and .B; N shows the vector N.X, .Y, .Z as R, G, B; Z, or any
    /// other whole name of a channel, is shown as a gray. A part of a file of many parts goes by its
    /// name. A name that is not there makes an error that lists those that are.
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,

    #[command(flatten)]
    development: DevelopArguments,

    /// Bits of each sample; 32, of a TIFF alone, are floats that neither clip nor are rounded
    #[arg(
        long,
        default_value = "8",
        value_parser = PossibleValuesParser::new(["8", "16", "32"])
            .map(|bits| Bits::ALL.into_iter().find(|found| found.number().to_string() == bits).unwrap_or_default())
    )]
    bits: Bits,

    /// What becomes of coverage
    ///
    /// keep: the picture has an alpha channel where the EXR has one, RGB divided by it; opaque: no
    /// alpha, the premultiplied light as it is, over black; auto: keep, but opaque where there is
    /// light without coverage (a background), which a PNG with alpha cannot hold.
    #[arg(
        long,
        default_value = Alpha::default().name(),
        value_parser = PossibleValuesParser::new(Alpha::ALL.map(Alpha::name))
            .map(|name| Alpha::ALL.into_iter().find(|alpha| alpha.name() == name).unwrap_or_default())
    )]
    alpha: Alpha,
}

impl Arguments {
    /// What is wrong with the options as they stand together.
    pub(crate) fn misuse(&self) -> Option<String> {
        let output = self.output.as_deref().unwrap_or(Path::new("-"));
        let holds = OutputFormat::of(output).holds(self.bits);
        (!holds).then(|| display::DisplayError::NoFloats.to_string())
    }
}

/// Makes the picture; warnings, and the exposure if it was chosen, go to `messages`.
pub(crate) fn run(
    arguments: &Arguments,
    unfinished: &Unfinished,
    messages: &mut impl Write,
) -> Result<(), Failure> {
    let settings = Settings {
        exposure: arguments.development.exposure(),
        view: arguments.development.view,
        bits: arguments.bits,
        alpha: arguments.alpha,
        dither: arguments.development.dither,
        frame: Frame::Display,
    };
    let default;
    let output = match &arguments.output {
        Some(output) => output.as_path(),
        None => {
            default = default_output(&arguments.input)?;
            &default
        }
    };
    super::refuse_terminal(output)?;
    // What is no picture is told first: another name would not help there.
    let input = Input::open(&arguments.input, arguments.layer.as_deref())?;
    super::refuse_same_files(&[&arguments.input], &[output])?;
    let report = display::convert_input(&input, output, &settings, unfinished)?;

    // Nowhere is left to report that the messages themselves cannot be written.
    let remarks = if input.window().is_some() {
        report.remarks()
    } else {
        // That nothing is shown has been said.
        Vec::new()
    };
    for warning in report.warnings.iter().chain(&remarks) {
        let _ = writeln!(messages, "warning: {}: {warning}", named(&arguments.input));
    }
    if matches!(settings.exposure, Exposure::Auto) {
        let _ = writeln!(messages, "exposure: {}", report.exposure());
    }
    Ok(())
}

/// How a message names an input.
fn named(input: &Path) -> String {
    if input == Path::new("-") {
        "standard input".to_owned()
    } else {
        printable_path(input)
    }
}

/// IN.png in the current folder. An input without a name cannot be read, which is found later.
fn default_output(input: &Path) -> Result<PathBuf, Failure> {
    if input == Path::new("-") || input.starts_with("/dev") || input.starts_with("/proc") {
        let input = named(input);
        return Err(format!("{input} gives the PNG no name; give it one with -o OUT.png").into());
    }
    Ok(Path::new(input.file_name().unwrap_or_default()).with_extension("png"))
}

/// A path whose name does not promise another format, such as the input's.
fn picture_path() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(|path| {
        let path = PathBuf::from(path);
        super::advice::no_frames(&path)?;
        match path.extension() {
            Some(extension)
                if !["png", "tif", "tiff"].iter().any(|known| extension.eq_ignore_ascii_case(known)) =>
            {
                Err(format!(
                    "candela tonemap writes PNG and TIFF, names in .png, .tif and .tiff; name the file {}",
                    printable_path(&path.with_extension("png"))
                ))
            }
            Some(_) | None => Ok(path),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use candela::display::{Dither, View};
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct Command {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn parse(line: &str) -> Result<Arguments, clap::Error> {
        Command::try_parse_from(["tonemap"].into_iter().chain(line.split_whitespace()))
            .map(|command| command.arguments)
    }

    #[test]
    fn defaults() {
        let arguments = parse("a/b.c.exr").unwrap();
        assert_eq!(arguments.development.exposure(), Exposure::Ev(0.0));
        assert_eq!(
            (arguments.development.view, arguments.bits, arguments.alpha),
            (View::Srgb, Bits::Eight, Alpha::Auto)
        );
        let default = |input| default_output(Path::new(input)).ok();
        assert_eq!(default("a/b.c.exr"), Some(PathBuf::from("b.c.png")));
        assert_eq!(default("-"), None);
        assert_eq!(default("/dev/stdin"), None);
    }

    #[test]
    fn everything_said() {
        let arguments =
            parse("a.exr -o x.PNG --exposure -1.5 --view reinhard --bits 16 --alpha opaque")
                .unwrap();
        assert_eq!(arguments.output.as_deref(), Some(Path::new("x.PNG")));
        assert_eq!(arguments.development.exposure(), Exposure::Ev(-1.5));
        assert_eq!(
            (arguments.development.view, arguments.bits, arguments.alpha),
            (View::Reinhard, Bits::Sixteen, Alpha::Opaque)
        );
        let piped = parse("- -o - --layer light_key --dither none").unwrap();
        assert_eq!(piped.output.as_deref(), Some(Path::new("-")));
        assert_eq!(piped.layer.as_deref(), Some("light_key"));
        assert_eq!(piped.development.dither, Dither::None);
        for (line, is_misuse) in [
            ("a.exr --bits 32", true),
            ("a.exr -o - --bits 32", true),
            ("a.exr -o a.png --bits 32", true),
            ("a.exr -o a.TIF --bits 32", false),
            ("a.exr -o a.tiff --bits 16", false),
        ] {
            assert_eq!(parse(line).unwrap().misuse().is_some(), is_misuse, "{line}");
        }
        let chosen = parse("a.exr --auto-exposure").unwrap();
        assert_eq!(chosen.development.exposure(), Exposure::Auto);
    }

    #[test]
    fn wrong_usage() {
        for line in [
            "",
            "a.exr --exposure inf",
            "a.exr --exposure nan",
            "a.exr --exposure bright",
            "a.exr --exposure 1 --auto-exposure",
            "a.exr --view film",
            "a.exr --bits 12",
            "a.exr -o a.jpg",
            "a.exr --alpha drop",
            "a.exr --dither noise",
            "a.exr -o a.exr",
        ] {
            assert_eq!(parse(line).unwrap_err().exit_code(), 2, "{line}");
        }
    }
}
