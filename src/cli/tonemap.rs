//! `candela tonemap`: a PNG or TIFF of an EXR, or of a picture of another format.

mod many;
mod watch;

use std::io::Write;
use std::path::{Path, PathBuf};

use super::Failure;
use super::develop::DevelopArguments;
use super::display_server::DisplayServer;
use super::failure::Misuse;
use super::false_color::{FalseColorArguments, Shown};
use super::sequence::{Conversion, conversions, input_name};
use candela::Primaries;
use candela::display::{self, Alpha, Bits, Frame, Input, OutputFormat, Settings};
use candela::image::Window;
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
  candela tonemap shot.####.exr -o png/shot.####.png --view reinhard
      All frames of a sequence
  candela tonemap scene.exr --display rec2020-pq -o hdr.png
      For an HDR screen
  candela tonemap scene.exr -o scene.tif --bits 32
      A TIFF of floats: code values that neither clip nor are rounded
  candela tonemap studio.hdr --exposure 1 -o studio.png
      A picture of another format
  candela tonemap scene.exr --view false-color --unit lx --iso-lines auto
      Illuminance in lux, of a file with the layer irradiance
  candela tonemap scene.exr --watch
      Again whenever the file changes
  candela render scene.toml -o - | candela tonemap - -o scene.png
      Through a pipe")]
pub(crate) struct Arguments {
    /// The EXR file, or a PNG, JPEG, TIFF or Radiance HDR; - is standard input. Many files, f.####.exr or f.%04d.exr
    /// for the frames of a sequence, or a pattern such as '*.exr' become a picture each
    #[arg(value_name = "IN.exr", required = true)]
    inputs: Vec<PathBuf>,

    /// The PNG file, or a TIFF where the name ends in .tif or .tiff; - is a PNG to standard output; of many files a
    /// folder, or f.####.png [default: IN.png in the current folder]
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

    #[command(flatten)]
    false_color: FalseColorArguments,

    /// The linear color space of the file's numbers, whatever the file says [default: what the file says, else
    /// rec709]
    #[arg(
        long,
        value_name = "NAME",
        value_parser = PossibleValuesParser::new(Primaries::names())
            .map(|name| Primaries::named(&name).unwrap_or(Primaries::REC709))
    )]
    input_space: Option<Primaries>,

    /// Show pixels that have values that are not a number in magenta, and infinite ones in cyan
    #[arg(long)]
    show_invalid: bool,

    /// Make the PNG anew whenever the file changes, until interrupted
    #[arg(long)]
    watch: bool,

    /// Also show the file's numbers in tev, which listens at HOST:PORT, such as 127.0.0.1:14158
    #[arg(long, value_name = "HOST:PORT")]
    display_server: Option<String>,

    /// No progress bar
    #[arg(short, long)]
    quiet: bool,

    /// Bits of each sample; 32, of a TIFF alone, are floats that neither clip nor are rounded [default: 8, or 16 for HDR]
    #[arg(
        long,
        value_parser = PossibleValuesParser::new(["8", "16", "32"])
            .map(|bits| Bits::ALL.into_iter().find(|found| found.number().to_string() == bits).unwrap_or_default())
    )]
    bits: Option<Bits>,

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
    /// Whether the one input may be many files.
    fn stands_for_many(&self) -> bool {
        let is_pattern = |input: &PathBuf| {
            let text = input.to_string_lossy();
            text.contains(['*', '?', '[']) || super::advice::frame_number(input).is_some()
        };
        self.inputs.iter().any(is_pattern)
    }

    fn bits(&self) -> Bits {
        // In 8 bits HDR has steps that are seen.
        self.bits.unwrap_or(if self.development.display.is_hdr() {
            Bits::Sixteen
        } else {
            Bits::Eight
        })
    }

    /// What is wrong with the options as they stand together.
    pub(crate) fn misuse(&self) -> Option<String> {
        let output = self.output.as_deref().unwrap_or(Path::new("-"));
        if !OutputFormat::of(output).holds(self.bits()) {
            return Some(display::DisplayError::NoFloats.to_string());
        }
        let view = self.development.false_color();
        self.false_color
            .misuse(view, self.development.is_balanced())
    }
}

/// Makes the pictures; warnings, and exposures that were chosen, go to `messages`.
pub(crate) fn run(
    arguments: &Arguments,
    unfinished: &Unfinished,
    messages: &mut (impl Write + Send),
) -> Result<(), Failure> {
    let conversions = conversions(&arguments.inputs, arguments.output.as_deref(), "png")?;
    let [conversion] = &conversions[..] else {
        if arguments.watch || arguments.display_server.is_some() {
            let what = if arguments.watch {
                "--watch"
            } else {
                "--display-server"
            };
            let message = format!("{what} takes one file, not {}", conversions.len());
            return Err(Misuse(message).into());
        }
        return many::run(arguments, &conversions, unfinished, messages);
    };
    if arguments.watch {
        return watch::run(arguments, conversion, unfinished, messages);
    }
    let told = convert(arguments, conversion, unfinished)?;
    // Nowhere is left to report that the messages themselves cannot be written.
    let _ = messages.write_all(told.as_bytes());
    Ok(())
}

/// Makes one PNG; what there is to say of it, a line each.
fn convert(
    arguments: &Arguments,
    Conversion { input, output }: &Conversion,
    unfinished: &Unfinished,
) -> Result<String, Failure> {
    super::refuse_terminal(output)?;
    // What is no picture is told first: another name would not help there.
    let reader = arguments
        .false_color
        .open(input, arguments.layer.as_deref())?;
    super::refuse_same_files(&[input], &[output])?;
    let mut lines = Vec::new();
    if let Some(address) = &arguments.display_server {
        lines.extend(show(address, &reader, input)?);
    }
    let look = arguments.development.look(reader.resolution())?;
    let shown = match arguments.development.false_color() {
        Some(view) => Some(
            arguments
                .false_color
                .of(view, &reader, arguments.input_space)?,
        ),
        None => None,
    };
    let developed = arguments.development.settings(&look);
    let settings = Settings {
        bits: arguments.bits(),
        alpha: arguments.alpha,
        frame: Frame::Display,
        input: arguments.input_space,
        shows_invalid: arguments.show_invalid,
        false_color: shown
            .as_ref()
            .map_or(developed.false_color, |shown| shown.colors),
        drawn: shown.as_ref().map_or(developed.drawn, Shown::drawn),
        ..developed
    };
    let report = display::convert_input(&reader, output, &settings, unfinished)?;

    let remarks = if reader.window().is_some() {
        report.remarks()
    } else {
        // That nothing is shown has been said.
        Vec::new()
    };
    let name = input_name(input);
    let warnings = report.warnings.iter().chain(&remarks);
    lines.extend(warnings.map(|warning| format!("warning: {name}: {warning}\n")));
    let notes = report.notes.iter();
    lines.extend(notes.map(|note| format!("note: {name}: {note}\n")));
    let of = if arguments.inputs.len() == 1 && !arguments.stands_for_many() {
        String::new()
    } else {
        format!("{name}: ")
    };
    if settings.exposure.is_auto() {
        lines.push(format!("{of}exposure: {}\n", report.exposure()));
    }
    if let Some(range) = shown.as_ref().and_then(Shown::chosen) {
        lines.push(format!("{of}{range}\n"));
    }
    Ok(lines.concat())
}

/// Shows what a file has in a viewer; what there is to say of it.
fn show(address: &str, input: &Input, path: &Path) -> Result<Option<String>, Failure> {
    let channels = ["R", "G", "B", "A"].map(str::to_owned).to_vec();
    let name = input_name(path);
    let server = DisplayServer::connect(address, &name, input.resolution(), channels)?;
    if let Some(window) = input.window() {
        for band in input.bands() {
            let pixels = input.rows(band.clone())?;
            let rows = Window {
                y: window.y + band.start,
                height: band.end - band.start,
                ..window
            };
            server.update(rows, pixels.iter().flatten().copied());
        }
    }
    Ok(server
        .warning()
        .map(|warning| format!("warning: {warning}\n")))
}

/// A path whose name does not promise another format, such as the input's.
fn picture_path() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(|path| {
        let path = PathBuf::from(path);
        match path.extension() {
            Some(extension)
                if !["png", "tif", "tiff"].iter().any(|known| extension.eq_ignore_ascii_case(known))
                    && !path.is_dir() =>
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
    use crate::cli::develop::Look;
    use candela::display::{Dither, Exposure, View};
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
            (
                arguments.development.settings(&Look::default()).view,
                arguments.bits(),
                arguments.alpha
            ),
            (View::Srgb, Bits::Eight, Alpha::Auto)
        );
        assert_eq!(arguments.inputs, [PathBuf::from("a/b.c.exr")]);
    }

    #[test]
    fn everything_said() {
        let arguments =
            parse("a.exr -o x.PNG --exposure -1.5 --view reinhard --bits 16 --alpha opaque")
                .unwrap();
        assert_eq!(arguments.output.as_deref(), Some(Path::new("x.PNG")));
        assert_eq!(arguments.development.exposure(), Exposure::Ev(-1.5));
        assert_eq!(
            (
                arguments.development.settings(&Look::default()).view,
                arguments.bits(),
                arguments.alpha
            ),
            (View::Reinhard, Bits::Sixteen, Alpha::Opaque)
        );
        let piped = parse("- -o - --layer light_key --dither none").unwrap();
        assert_eq!(piped.output.as_deref(), Some(Path::new("-")));
        assert_eq!(piped.layer.as_deref(), Some("light_key"));
        assert_eq!(
            piped.development.settings(&Look::default()).dither,
            Dither::None
        );
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
