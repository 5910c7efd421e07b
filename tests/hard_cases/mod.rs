//! Hard cases, scored: scenes at the limits of numbers and of geometry, each against the oracle, in a table that
//! `docs/hard-cases.md` has. `BLESS=1 cargo test hard_cases` writes it anew; with `CANDELA_SCENES` of 1000 or more a
//! large picture is compared as well.

mod scenes;

use std::fmt::Write;

use candela::oracle::Oracle;
use candela::render::{Options, render};
use candela::world::World;
use rayon::prelude::*;

use crate::generate;
use crate::measured::{HALF_LAST_BIT, Measured};
use scenes::Case;

const PAGE: &str = "docs/hard-cases.md";

/// Before and after the table.
const BEGIN: &str = "| case | pixels |";
const END: &str = "\n\n";

/// So many generated scenes are asked for in a long sweep.
const LONG: u64 = 1000;

/// An edge is where the oracle decides otherwise so many pixels away.
const NEARBY: f64 = 1e-6;

/// Below this part of the median, errors are relative to that: as in the comparison of generated scenes.
const FLOOR: f64 = 1e-6;

/// What is found of a case.
#[derive(Clone, Debug, PartialEq)]
enum Verdict {
    Rendered(Score),
    /// The error.
    Refused(String),
}

#[derive(Clone, Debug, Default, PartialEq)]
struct Score {
    pixels: usize,
    /// The largest relative error of those that are not flips.
    worst: f64,
    /// Pixels beyond the bar at an edge, and off one.
    on_edges: usize,
    off_edges: usize,
    not_finite: usize,
}

fn brightest(radiance: [f64; 3]) -> f64 {
    radiance.into_iter().map(f64::abs).fold(0.0, f64::max)
}

fn is_edge(oracle: &Oracle, [x, y]: [f64; 2]) -> bool {
    let center = oracle.decisions(x, y);
    let steps = [-NEARBY, 0.0, NEARBY];
    steps
        .into_iter()
        .flat_map(|dx| steps.map(|dy| [x + dx, y + dy]))
        .any(|[x, y]| oracle.decisions(x, y) != center)
}

fn judge(case: &Case) -> Verdict {
    let (world, camera) = match World::new(&case.scene) {
        Ok(made) => made,
        Err(error) => return Verdict::Refused(error.to_string()),
    };
    let options = Options {
        samples: 1,
        ..Options::default()
    };
    let film = render(&world, &camera, &options).unwrap();
    let oracle = Oracle::new(&case.scene);
    let width = oracle.resolution()[0] as usize;
    let centers = |index: usize| [index % width, index / width].map(|x| x as f64 + 0.5);
    let expected: Vec<_> = (0..film.pixels().len())
        .into_par_iter()
        .map(|index| {
            let [x, y] = centers(index);
            oracle.radiance(x, y)
        })
        .collect();
    let mut lit: Vec<f64> = expected
        .iter()
        .map(|sample| brightest(sample.radiance))
        .filter(|&radiance| radiance > 0.0)
        .collect();
    lit.sort_by(f64::total_cmp);
    let median = lit.get(lit.len() / 2).copied().unwrap_or(1.0);
    // Below the least normal f32 there are no relative errors.
    let floor = (FLOOR * median).max(f32::MIN_POSITIVE.into());
    let mut score = Score {
        pixels: expected.len(),
        ..Score::default()
    };
    for (index, (actual, expected)) in film.pixels().iter().zip(&expected).enumerate() {
        if !actual.iter().all(|channel| channel.is_finite()) {
            score.not_finite += 1;
            continue;
        }
        let largest = f64::from(f32::MAX);
        let scale = brightest(expected.radiance).clamp(floor, largest);
        let error = (0..3)
            .map(|i| {
                let expected = expected.radiance[i].clamp(-largest, largest);
                (f64::from(actual[i]) - expected).abs() / scale
            })
            .fold(0.0, f64::max);
        let is_seen = f64::from(actual[3]) == expected.coverage;
        if is_seen && error <= case.bar {
            score.worst = score.worst.max(error);
        } else if is_edge(&oracle, centers(index)) {
            score.on_edges += 1;
        } else {
            score.off_edges += 1;
            println!(
                "{}: pixel {:?}: {actual:?}, expected {expected:?}",
                case.name,
                [index % width, index / width]
            );
        }
    }
    Verdict::Rendered(score)
}

/// A figure with one digit, rounded up.
fn one_digit(figure: f64) -> String {
    // What is that small is far below the last bit, or of a value below the least normal f32.
    if figure < 1e-12 {
        return "0".to_owned();
    }
    let power = figure.log10().floor();
    let digit = (figure / 10.0_f64.powf(power)).ceil();
    format!("{:e}", digit * 10.0_f64.powf(power))
        .parse::<f64>()
        .map_or_else(|_| "?".to_owned(), |value| format!("{value:.0e}"))
}

fn row(case: &Case, verdict: &Verdict) -> String {
    match verdict {
        Verdict::Rendered(score) => format!(
            "| {} | {} | {} | {} | {} | {} |",
            case.name,
            score.pixels,
            one_digit(score.worst),
            score.on_edges,
            score.off_edges,
            score.not_finite
        ),
        Verdict::Refused(why) => {
            let why = case.refusal.unwrap_or(why);
            format!("| {} | refused: {why} | | | | |", case.name)
        }
    }
}

/// What is wrong with a verdict, if anything.
fn objection(case: &Case, verdict: &Verdict) -> Option<String> {
    match (verdict, case.refusal) {
        (Verdict::Refused(why), Some(expected)) => {
            (!why.contains(expected)).then(|| format!("{}: {why}", case.name))
        }
        (Verdict::Refused(why), None) => Some(format!("{} is refused: {why}", case.name)),
        (Verdict::Rendered(_), Some(_)) => Some(format!("{} is not refused", case.name)),
        (Verdict::Rendered(score), None) => (score.off_edges > 0 || score.not_finite > 0)
            .then(|| format!("{}: {score:?}", case.name)),
    }
}

/// The relative error that a row of the page states.
fn stated(row: &str) -> Option<f64> {
    row.split(" | ").nth(2)?.trim().parse().ok()
}

/// Whether a row says what is found: the same, but for an error that is as small or up to twice as large.
fn is_said(stated_row: &str, row: &str, score: &Score) -> bool {
    let without_error = |row: &str| -> Vec<String> {
        let cells = row.split(" | ").enumerate();
        cells
            .filter(|(column, _)| *column != 2)
            .map(|(_, cell)| cell.to_owned())
            .collect()
    };
    without_error(stated_row) == without_error(row)
        && stated(stated_row)
            .is_some_and(|figure| score.worst <= Measured::ROOM * figure.max(HALF_LAST_BIT))
}

#[test]
fn hard_cases() {
    let folder = tempfile::tempdir().unwrap();
    let cases = scenes::all(folder.path());
    let verdicts: Vec<Verdict> = cases.par_iter().map(judge).collect();
    let mut table = "| case | pixels | largest relative error | flips on an edge | off an edge | not finite |\n\
                     | --- | --- | --- | --- | --- | --- |\n"
        .to_owned();
    for (case, verdict) in cases.iter().zip(&verdicts) {
        writeln!(table, "{}", row(case, verdict)).unwrap();
    }
    println!("{table}");
    let objections: Vec<String> = cases
        .iter()
        .zip(&verdicts)
        .filter_map(|(case, verdict)| objection(case, verdict))
        .collect();
    let page = std::fs::read_to_string(PAGE).unwrap();
    let begin = page.find(BEGIN).expect("the page has the table");
    let end = begin
        + page[begin..]
            .find(END)
            .map_or(page.len() - begin, |end| end + 1);
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(PAGE, format!("{}{table}{}", &page[..begin], &page[end..])).unwrap();
    }
    assert!(objections.is_empty(), "{}", objections.join("\n"));
    if std::env::var_os("BLESS").is_none() {
        let stated_rows: Vec<&str> = page[begin..end].lines().skip(2).collect();
        assert_eq!(
            stated_rows.len(),
            cases.len(),
            "BLESS=1 writes the table anew"
        );
        for ((case, verdict), stated_row) in cases.iter().zip(&verdicts).zip(stated_rows) {
            let found = row(case, verdict);
            let is_right = match verdict {
                Verdict::Rendered(score) => is_said(stated_row, &found, score),
                Verdict::Refused(_) => stated_row == found,
            };
            assert!(is_right, "{PAGE} says\n{stated_row}\nfound is\n{found}");
        }
    }
}

/// The ranges that errors name are those that the pages state.
#[test]
fn ranges_are_stated() {
    let limits = std::fs::read_to_string("docs/limits.md").unwrap();
    assert!(limits.contains("at most 1e10 times as much as the `eye` is away"));
    assert!(limits.contains("at least 1e-11 of its distance from the plane's `point`"));
}

/// In the long sweep.
#[test]
fn sixteen_million_pixels() {
    if generate::count() < LONG {
        return;
    }
    let case = scenes::large();
    let verdict = judge(&case);
    println!("{}", row(&case, &verdict));
    assert_eq!(objection(&case, &verdict), None);
}
