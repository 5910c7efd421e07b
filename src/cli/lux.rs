//! `candela lux`: point-by-point illuminance of a working plane.

use std::fmt::Write as _;
use std::io::Write;
use std::path::PathBuf;

use candela::illuminance;
use candela::internal::{counted, printable_path};
use candela::output::{self, Unfinished};
use candela::world::Loaded;

use super::numbers::number;
use super::source::{FrameArguments, SceneArguments};
use super::{Failure, refuse_same_files};

/// Compute the illuminance of a working plane in lux, point by point: minimum, mean, maximum and uniformity
///
/// The plane is a rectangle, or a parallelogram, from a corner along two edges; it is lit from the side to which u × v
/// points. It is parted evenly, and each part is measured in its middle, as EN 12464-1 has it. The plane itself is in nobody's way. It
/// is the direct component only: what comes from the lights, and nothing by way of other surfaces.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela lux office.toml --from -3,0.75,2 --u 6,0,0 --v 0,0,-4 --grid 0.5 -o desk.csv
      The working plane of a room of 6 m × 4 m, 0.75 m above the floor
  candela lux office.toml --from -3,0.75,2 --u 6,0,0 --v 0,0,-4
      Minimum, mean, maximum and uniformity alone

Exit codes:
  0   done
  1   the scene or the plane is not right, or the file cannot be written")]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,

    #[command(flatten)]
    frame: FrameArguments,

    /// A corner of the plane
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = vector)]
    from: Vector,

    /// The edge from there along which columns are counted
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = vector)]
    u: Vector,

    /// The edge from there along which rows are counted
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = vector)]
    v: Vector,

    /// How far points are apart, about, in m: as many fit each edge as come nearest
    #[arg(long, value_name = "M", default_value_t = 0.5, value_parser = spacing)]
    grid: f64,

    /// Write all points as CSV: x, y, z in m, and lux; `-` is standard output
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
}

type Vector = [f64; 3];

/// Points of a plane at most.
const MOST_POINTS: f64 = 1e7;

fn vector(text: &str) -> Result<Vector, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z])
            if [x, y, z]
                .iter()
                .all(|part| part.is_finite() && part.abs() <= 1e30) =>
        {
            Ok([x, y, z])
        }
        _ => Err("expected X,Y,Z, three numbers in m such as 0,0.75,0".to_owned()),
    }
}

fn spacing(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok();
    number
        .filter(|&m| m > 0.0 && m.is_finite())
        .ok_or_else(|| "expected a distance in m above 0, such as 0.5".to_owned())
}

/// The middles of the parts of the plane, column by column in each row, and how many columns and rows there are.
struct Grid {
    points: Vec<Vector>,
    columns: usize,
    rows: usize,
}

fn grid(arguments: &Arguments) -> Result<Grid, Failure> {
    let Arguments {
        from, u, v, grid, ..
    } = arguments;
    let length = |edge: &Vector| edge[0].hypot(edge[1]).hypot(edge[2]);
    let parts = |edge: &Vector| (length(edge) / grid).round().max(1.0);
    let (columns, rows) = (parts(u), parts(v));
    if columns * rows > MOST_POINTS {
        return Err(format!(
            "--grid {grid} makes {columns} × {rows} points of this plane, at most 10 million are measured; choose a \
             larger --grid"
        )
        .into());
    }
    let (columns, rows) = (columns as usize, rows as usize);
    let middles = |row: usize, column: usize| {
        let (s, t) = (
            (column as f64 + 0.5) / columns as f64,
            (row as f64 + 0.5) / rows as f64,
        );
        [0, 1, 2].map(|i| from[i] + s * u[i] + t * v[i])
    };
    let points = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    Ok(Grid {
        points: points.map(|(row, column)| middles(row, column)).collect(),
        columns,
        rows,
    })
}

pub(crate) fn run(
    arguments: &Arguments,
    unfinished: &Unfinished,
    output: &mut impl Write,
) -> Result<(), Failure> {
    let Arguments {
        u, v, output: csv, ..
    } = arguments;
    let normal = [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    let size = normal[0].hypot(normal[1]).hypot(normal[2]);
    if !(size > 0.0 && size.is_finite()) {
        return Err(
            "--u and --v span no plane; give two edges that are not along each other".into(),
        );
    }
    let grid = grid(arguments)?;
    if let Some(csv) = csv {
        refuse_same_files(&[arguments.scene.name()], &[csv])?;
    }
    let Loaded { world, .. } = arguments.scene.load(arguments.frame.number(), |_| {})?;
    let lux = illuminance(&world, &grid.points, normal)?;
    let to_standard_output = csv.as_ref().is_some_and(|csv| csv.as_os_str() == "-");
    if let Some(csv) = csv {
        let mut text = String::from("x,y,z,lux\n");
        for ([x, y, z], lux) in grid.points.iter().zip(&lux) {
            // A String takes any text.
            let _ = writeln!(text, "{},{},{},{lux}", plain(*x), plain(*y), plain(*z));
        }
        output::write(csv, unfinished, |sink| sink.write_all(text.as_bytes()))?;
    }
    if !to_standard_output {
        summary(&grid, &lux, csv.as_ref(), output)?;
    }
    Ok(())
}

/// Without the last digits that sums leave.
fn plain(coordinate: f64) -> f64 {
    format!("{coordinate:.12e}").parse().unwrap_or(coordinate)
}

fn summary(
    grid: &Grid,
    lux: &[f64],
    csv: Option<&PathBuf>,
    output: &mut impl Write,
) -> Result<(), Failure> {
    let least = lux.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = lux.iter().copied().fold(0.0, f64::max);
    let mean = lux.iter().sum::<f64>() / lux.len() as f64;
    let over = |a: f64, b: f64| {
        if b > 0.0 {
            format!("{:.3}", a / b)
        } else {
            "none: the plane is dark".to_owned()
        }
    };
    let points = counted(lux.len(), "point", "points");
    writeln!(
        output,
        "illuminance    {points}, {} × {}; direct component only",
        grid.columns, grid.rows
    )?;
    writeln!(output, "minimum        {} lx", number(least))?;
    writeln!(output, "mean           {} lx", number(mean))?;
    writeln!(output, "maximum        {} lx", number(largest))?;
    writeln!(
        output,
        "uniformity U0  {} (minimum over mean, EN 12464-1)",
        over(least, mean)
    )?;
    writeln!(
        output,
        "diversity Ud   {} (minimum over maximum)",
        over(least, largest)
    )?;
    if let Some(csv) = csv {
        writeln!(output, "{}: all points", printable_path(csv))?;
    }
    Ok(())
}
