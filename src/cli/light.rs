//! `candela light`: what an IES file says, in numbers and as a polar diagram.

use std::io::Write;
use std::path::{Path, PathBuf};

use candela::ies::{IesFile, Symmetry, Widths};
use candela::internal::{printable, printable_path};
use candela::output::{self, Unfinished};

use super::drawing::{Anchor, Color, Drawing, Item, Xy, raster, svg, width};
use super::numbers::number;
use super::{Failure, refuse_same_files};

/// Show what an IES file says: flux, peak, beam and field angle, and its polar diagram
///
/// A scene takes the file as `[lights.NAME.ies]`. What was not read as written is named, and how it was read.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela light downlight.ies
      In numbers
  candela light downlight.ies -o polar.svg
      With the polar diagram, planes C0 to C180 and C90 to C270
  candela light downlight.ies -o polar.png
      The same as a PNG

Exit codes:
  0   done
  1   the file is not right, or the diagram cannot be written")]
pub(crate) struct Arguments {
    /// The IES file, LM-63 of 1986 to 2019
    #[arg(value_name = "FILE.ies")]
    file: PathBuf,

    /// Write the polar diagram, as SVG or PNG by its name
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Pixels of a PNG to a unit of the drawing.
const SCALE: f64 = 2.0;

pub(crate) fn run(
    arguments: &Arguments,
    unfinished: &Unfinished,
    output: &mut impl Write,
) -> Result<(), Failure> {
    let Arguments {
        file: path,
        output: diagram,
    } = arguments;
    if let Some(diagram) = diagram {
        refuse_same_files(&[path], &[diagram])?;
        kind_of(diagram)?;
    }
    let file = IesFile::load(path)
        .map_err(|error| format!("cannot use the IES file {}: {error}", printable_path(path)))?;
    write_text(&file, path, output)?;
    if let Some(diagram) = diagram {
        let title = path.file_name().unwrap_or_default().to_string_lossy();
        let drawing = polar(&file, &fitting(&printable(&title)));
        match kind_of(diagram)? {
            Format::Svg => {
                let text = svg(&drawing, &format!("Polar diagram: {}", printable(&title)));
                output::write(diagram, unfinished, |sink| sink.write_all(text.as_bytes()))?;
            }
            Format::Png => {
                let image = raster(&drawing, SCALE).ok_or("the diagram is too large")?;
                image.write_png(diagram, unfinished)?;
            }
        }
        writeln!(output, "{}: its polar diagram", printable_path(diagram))?;
    }
    Ok(())
}

/// What a diagram is written as.
enum Format {
    Svg,
    Png,
}

fn kind_of(path: &Path) -> Result<Format, Failure> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    match &*extension.to_lowercase() {
        "svg" => Ok(Format::Svg),
        "png" => Ok(Format::Png),
        _ => Err(format!(
            "{} is no name of a diagram; end it with `.svg` or `.png`",
            printable_path(path)
        )
        .into()),
    }
}

fn write_text(file: &IesFile, path: &Path, output: &mut impl Write) -> Result<(), Failure> {
    let photometry = &file.photometry;
    let (vertical, horizontal) = photometry.angles();
    let ends = |angles: &[f64]| {
        let [first, last] = [angles.first(), angles.last()].map(|end| end.map_or(0.0, |end| *end));
        if angles.len() == 1 {
            format!("1 angle, {first}°")
        } else {
            format!("{} angles, {first}° to {last}°", angles.len())
        }
    };
    let symmetry = match photometry.symmetry() {
        Symmetry::Axial => "the same all around the axis",
        Symmetry::Quadrants => "the same in all quadrants",
        Symmetry::Mirrored => "mirrored by the plane C0 to C180",
        Symmetry::MirroredAcross => "mirrored by the plane C90 to C270",
        Symmetry::None => "of no symmetry",
    };
    let mut row = |name: &str, value: String| writeln!(output, "{name:<14} {value}");
    row("file", printable_path(path))?;
    row(
        "format",
        format!("{}, {}", file.edition.name(), photometry.coordinates()),
    )?;
    for keyword in ["MANUFAC", "LUMCAT", "LUMINAIRE", "LAMP"] {
        if let Some(text) = file.keyword(keyword) {
            let words: Vec<&str> = text.split_whitespace().collect();
            if !words.is_empty() {
                row(
                    &keyword.to_lowercase(),
                    printable(&words.join(" ")).to_string(),
                )?;
            }
        }
    }
    row("vertical", ends(vertical))?;
    row("horizontal", format!("{}; {symmetry}", ends(horizontal)))?;
    let peak = photometry.peak();
    let at = photometry.coordinates().angles(peak.direction);
    row(
        "peak",
        format!(
            "{} cd at V {}°, H {}°",
            number(peak.candela),
            number(at.vertical),
            number(at.horizontal)
        ),
    )?;
    row(
        "beam",
        format!(
            "{} (half of the largest in the plane)",
            in_planes(photometry.beam_angle())
        ),
    )?;
    row(
        "field",
        format!("{} (a tenth)", in_planes(photometry.field_angle())),
    )?;
    let zonal = photometry.zonal_lumens();
    row("flux", format!("{} lm, zonal sum", number(zonal)))?;
    row(
        "",
        format!(
            "{} lm, of the bilinear table, which is what is rendered",
            number(photometry.lumens())
        ),
    )?;
    match file.rated_lumens() {
        Some(rated) if rated > 0.0 => row(
            "lamps",
            format!(
                "{} lm as the file states; {} % of that leave the luminaire",
                number(rated),
                number(zonal / rated * 100.0)
            ),
        )?,
        Some(_) => {}
        None => row(
            "lamps",
            "absolute photometry: no flux of lamps is stated".to_owned(),
        )?,
    }
    if file.watts > 0.0 {
        row(
            "power",
            format!(
                "{} W, {} lm/W",
                number(file.watts),
                number(zonal / file.watts)
            ),
        )?;
    }
    for remark in file.remarks.list() {
        writeln!(output, "not as written: {remark}")?;
    }
    Ok(())
}

/// The angles of two planes, C0 and C90.
pub(super) fn in_planes(widths: Widths) -> String {
    let of =
        |width: Option<f64>| width.map_or_else(|| "none".to_owned(), |w| format!("{}°", number(w)));
    let (along, across) = (of(widths.plane_0), of(widths.plane_90));
    if along == across {
        along
    } else {
        format!("{along} × {across}")
    }
}

const INK: Color = [30, 30, 34];
const GRAY: Color = [120, 120, 128];
const GRID: Color = [212, 212, 218];
const PLANE_0: Color = [196, 60, 30];
const PLANE_90: Color = [30, 90, 180];

/// The diagram: its size, where the luminaire is, and how long the largest intensity is.
const SIZE: Xy = [520.0, 600.0];
const CENTER: Xy = [260.0, 300.0];
const RADIUS: f64 = 210.0;

/// Points of a curve: one for each half degree.
const POINTS: usize = 721;

/// Rings of the diagram, at most.
const RINGS: f64 = 5.0;

/// The polar diagram: intensity over the angle from the axis, which points down.
fn polar(file: &IesFile, title: &str) -> Drawing {
    let photometry = &file.photometry;
    let step = ring_step(photometry.peak().candela);
    let rings = (photometry.peak().candela / step).ceil().max(1.0);
    let largest = rings * step;
    let place = |angle: f64, part: f64| {
        let (sin, cos) = angle.to_radians().sin_cos();
        // C0 is on the right.
        [
            CENTER[0] + RADIUS * part * sin,
            CENTER[1] + RADIUS * part * cos,
        ]
    };
    let mut items = vec![
        Item::text([28.0, 36.0], title, 16.0, INK, Anchor::Start),
        Item::text(
            [28.0, 56.0],
            "Luminous intensity in cd",
            12.0,
            GRAY,
            Anchor::Start,
        ),
    ];
    for ring in 1..=rings as u32 {
        let part = f64::from(ring) / rings;
        let points = (0..=180).map(|i| place(f64::from(i) * 2.0, part)).collect();
        items.push(line(points, GRID, 1.0, false));
        let [x, y] = place(180.0, part);
        let label = number(f64::from(ring) * step);
        items.push(Item::text(
            [x + 4.0, y - 3.0],
            &label,
            11.0,
            GRAY,
            Anchor::Start,
        ));
    }
    for angle in (-150..=180).step_by(30) {
        let angle = f64::from(angle);
        items.push(line(vec![CENTER, place(angle, 1.0)], GRID, 1.0, false));
        let [x, y] = place(angle, 1.07);
        if angle != 180.0 {
            let label = format!("{}°", angle.abs());
            items.push(Item::text([x, y + 4.0], &label, 11.0, GRAY, Anchor::Middle));
        }
    }
    for (plane, color, is_dashed) in [(90.0, PLANE_90, true), (0.0, PLANE_0, false)] {
        let curve = photometry.polar_curve(plane, POINTS);
        let points = curve
            .iter()
            .map(|&(angle, candela)| place(angle, candela / largest));
        items.push(line(points.collect(), color, 2.0, is_dashed));
    }
    let y = SIZE[1] - 34.0;
    for (x, name, color, is_dashed) in [
        (28.0, "C180 to C0", PLANE_0, false),
        (170.0, "C270 to C90", PLANE_90, true),
    ] {
        items.push(line(
            vec![[x, y - 4.0], [x + 26.0, y - 4.0]],
            color,
            2.0,
            is_dashed,
        ));
        items.push(Item::text([x + 32.0, y], name, 12.0, INK, Anchor::Start));
    }
    let flux = format!("{} lm", number(photometry.zonal_lumens()));
    items.push(Item::text(
        [SIZE[0] - 28.0, y],
        &flux,
        12.0,
        INK,
        Anchor::End,
    ));
    Drawing { size: SIZE, items }
}

/// A title that fits the diagram, without its middle if it is long.
fn fitting(title: &str) -> String {
    const SIZE_OF_TITLE: f64 = 16.0;
    let room = SIZE[0] - 56.0;
    let letters: Vec<char> = title.chars().collect();
    let mut kept = letters.len();
    let mut fitting = title.to_owned();
    while width(&fitting, SIZE_OF_TITLE) > room && kept > 2 {
        kept -= 2;
        let (start, end) = (&letters[..kept / 2], &letters[letters.len() - kept / 2..]);
        fitting = start.iter().chain(&['…']).chain(end).collect();
    }
    fitting
}

/// The distance of rings: 1, 2 or 5 times a power of ten, so that there are at most [`RINGS`] of them.
fn ring_step(largest: f64) -> f64 {
    let least = largest / RINGS;
    let power = 10_f64.powf(least.log10().floor());
    let times = [1.0, 2.0, 5.0, 10.0].into_iter();
    let mut enough = times.map(|times| times * power);
    enough.find(|step| *step >= least).unwrap_or(10.0 * power)
}

fn line(points: Vec<Xy>, color: Color, width: f64, is_dashed: bool) -> Item {
    Item::Line {
        points,
        color,
        width,
        is_dashed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_are_round_and_few() {
        for (largest, step) in [
            (100.0, 20.0),
            (101.0, 50.0),
            (269.0, 100.0),
            (5.0, 1.0),
            (1e-3, 2e-4),
            (7e6, 2e6),
        ] {
            let found = ring_step(largest);
            assert!((found / step - 1.0).abs() < 1e-12, "{largest}: {found}");
        }
    }

    /// A cosine is a circle below the luminaire.
    #[test]
    fn a_cosine_is_a_circle() {
        let angles: Vec<String> = (0..=90).map(|angle| angle.to_string()).collect();
        let candela =
            (0..=90).map(|angle| (100.0 * f64::from(angle).to_radians().cos()).to_string());
        let candela: Vec<String> = candela.collect();
        let text = format!(
            "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 91 1 1 2 0 0 0\n1 1 10\n{}\n0\n{}\n",
            angles.join(" "),
            candela.join(" ")
        );
        let file = IesFile::parse(text.as_bytes()).unwrap();
        let drawing = polar(&file, "cosine");
        let curves = drawing.items.iter().filter_map(|item| match item {
            Item::Line {
                points,
                color: PLANE_0,
                ..
            } if points.len() == POINTS => Some(points),
            _ => None,
        });
        let mut count = 0;
        for points in curves {
            for &[x, y] in points {
                let from_middle = (x - CENTER[0]).hypot(y - CENTER[1] - RADIUS / 2.0);
                let is_dark = (x - CENTER[0]).hypot(y - CENTER[1]) < 1e-9;
                assert!(is_dark || (from_middle / (RADIUS / 2.0) - 1.0).abs() < 1e-3);
                count += usize::from(!is_dark);
            }
        }
        assert!(count > 300);
    }
}
