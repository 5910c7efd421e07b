//! What `verify` has found, for people and for programs.

use std::io::{self, Write};
use std::path::Path;

use candela::internal::{counted, printable, printable_path};
use serde::ser::{Serialize, SerializeSeq, Serializer};

use super::edge::Edge;
use crate::cli::numbers::number;

/// The decades that errors are counted in: from 10^FIRST up to 10^LAST.
const FIRST: i32 = -9;
const LAST: i32 = 0;
const DECADES: usize = (LAST - FIRST) as usize;

/// At most so many pixels that are off are listed.
const LISTED: usize = 20;

/// Characters of the longest bar.
const BAR: f64 = 40.0;

/// All that was found.
pub(super) struct Report {
    pub(super) scene: String,
    /// How many were compared.
    pub(super) pixels: u64,
    /// How many the image has.
    pub(super) of: u64,
    pub(super) seed: u64,
    /// The relative error up to which a pixel agrees.
    pub(super) tolerance: f64,
    /// How many may be on the other side of an edge.
    pub(super) max_flips: u64,
    pub(super) histogram: Histogram,
    /// The largest error of those that agree.
    pub(super) largest: f64,
    pub(super) largest_at: Option<[u32; 2]>,
    /// The pixels that do not agree.
    pub(super) flips: Vec<Flip>,
}

/// A pixel that does not agree.
#[derive(serde::Serialize)]
pub(super) struct Flip {
    pub(super) pixel: [u32; 2],
    /// Relative; infinite, or null in JSON, where only one of both sees a surface.
    pub(super) error: f64,
    pub(super) renderer: [f32; 3],
    pub(super) oracle: [f64; 3],
    /// The edge that it lies on; `None` where there is none: it is wrong.
    pub(super) edge: Option<Edge>,
}

/// How many errors are in which decade.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Histogram {
    /// Errors of 0.
    zero: u64,
    /// Up to 10^FIRST.
    below: u64,
    decades: [u64; DECADES],
    /// From 10^LAST on.
    above: u64,
}

impl Histogram {
    pub(super) fn add(&mut self, error: f64) {
        let count = if error == 0.0 {
            &mut self.zero
        } else if error < 10.0_f64.powi(FIRST) {
            &mut self.below
        } else {
            let place = (FIRST + 1..=LAST).position(|power| error < 10.0_f64.powi(power));
            match place {
                Some(place) => &mut self.decades[place],
                None => &mut self.above,
            }
        };
        *count += 1;
    }

    /// From, to and how many, without empty ones at the ends.
    fn rows(&self) -> Vec<([f64; 2], u64)> {
        let power = |place: usize| 10.0_f64.powi(FIRST + place as i32);
        let decades = self.decades.iter().enumerate();
        let decades = decades.map(|(place, &count)| ([power(place), power(place + 1)], count));
        let below = ([0.0, power(0)], self.below);
        let above = ([power(DECADES), f64::INFINITY], self.above);
        let rows: Vec<_> = std::iter::once(below)
            .chain(decades)
            .chain([above])
            .collect();
        let is_there = |row: &([f64; 2], u64)| row.1 > 0;
        let first = rows.iter().position(is_there);
        let last = rows.iter().rposition(is_there);
        first
            .zip(last)
            .map_or_else(Vec::new, |(first, last)| rows[first..=last].to_vec())
    }
}

impl Serialize for Histogram {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(serde::Serialize)]
        struct Row {
            from: f64,
            below: f64,
            pixels: u64,
        }
        let rows = self.rows();
        let mut list = serializer.serialize_seq(Some(rows.len() + 1))?;
        list.serialize_element(&Row {
            from: 0.0,
            below: 0.0,
            pixels: self.zero,
        })?;
        for ([from, below], pixels) in rows {
            list.serialize_element(&Row {
                from,
                below,
                pixels,
            })?;
        }
        list.end()
    }
}

impl Edge {
    /// In words.
    fn told(&self) -> String {
        let name = |name: &Option<String>| match name {
            Some(name) => format!("`{}`", printable(name)),
            None => "the background".to_owned(),
        };
        match self {
            Self::Silhouette { between: [a, b] } => {
                format!("on the edge between {} and {}", name(a), name(b))
            }
            Self::Shadow { light, occluder } => {
                let by = match occluder {
                    Some(_) => format!(" that {} throws", name(occluder)),
                    None => String::new(),
                };
                format!(
                    "on the edge of the shadow of light `{}`{by}",
                    printable(light)
                )
            }
            Self::Terminator { light } => {
                format!(
                    "where the surface turns away from light `{}`",
                    printable(light)
                )
            }
            Self::Cone { light } => {
                format!("on the edge of the cone of light `{}`", printable(light))
            }
            Self::Triangles { object } => {
                format!("on an edge between triangles of `{}`", printable(object))
            }
            Self::BeyondSmooth { object } => {
                format!("on an edge seen over `{}`", printable(object))
            }
        }
    }
}

impl Report {
    /// How many are wrong: off, and on no edge.
    fn wrong(&self) -> u64 {
        self.flips.iter().filter(|flip| flip.edge.is_none()).count() as u64
    }

    /// How many are on the other side of an edge.
    fn on_edges(&self) -> u64 {
        self.flips.len() as u64 - self.wrong()
    }

    /// What is beyond a limit, if anything.
    pub(super) fn objection(&self) -> Option<String> {
        let (wrong, on_edges) = (self.wrong(), self.on_edges());
        let tolerance = number(self.tolerance);
        if wrong > 0 {
            let pixels = counted(wrong as usize, "pixel differs", "pixels differ");
            return Some(format!(
                "{pixels} from the equations by more than {tolerance}, and on no edge"
            ));
        }
        (on_edges > self.max_flips).then(|| {
            let pixels = counted(on_edges as usize, "pixel is", "pixels are");
            format!(
                "{pixels} on the other side of an edge, and {} may be",
                self.max_flips
            )
        })
    }

    pub(super) fn write_json(&self, output: &mut impl Write) -> io::Result<()> {
        #[derive(serde::Serialize)]
        struct Json<'r> {
            scene: &'r str,
            pixels: u64,
            of: u64,
            seed: u64,
            tolerance: f64,
            max_flips: u64,
            histogram: &'r Histogram,
            largest: f64,
            largest_at: Option<[u32; 2]>,
            flips: u64,
            wrong: u64,
            off: &'r [Flip],
            agrees: bool,
        }
        let json = Json {
            scene: &self.scene,
            pixels: self.pixels,
            of: self.of,
            seed: self.seed,
            tolerance: self.tolerance,
            max_flips: self.max_flips,
            histogram: &self.histogram,
            largest: self.largest,
            largest_at: self.largest_at,
            flips: self.on_edges(),
            wrong: self.wrong(),
            off: &self.flips,
            agrees: self.objection().is_none(),
        };
        serde_json::to_writer_pretty(&mut *output, &json).map_err(io::Error::from)?;
        writeln!(output)
    }

    pub(super) fn write_text(
        &self,
        oracle: Option<&Path>,
        output: &mut impl Write,
    ) -> io::Result<()> {
        let which = if self.pixels == self.of {
            format!("all {} pixels", self.of)
        } else {
            format!("{} of {} pixels", self.pixels, self.of)
        };
        writeln!(
            output,
            "{}: {which}, renderer against oracle\n",
            printable(&self.scene)
        )?;
        writeln!(output, "relative error      pixels")?;
        let rows = self.histogram.rows();
        let most = rows
            .iter()
            .map(|row| row.1)
            .max()
            .unwrap_or(0)
            .max(self.histogram.zero);
        let mut row = |label: String, count: u64| {
            let bar = "▇".repeat((BAR * count as f64 / most.max(1) as f64).round() as usize);
            writeln!(
                output,
                "{}",
                format!("{label:17} {count:>8}  {bar}").trim_end()
            )
        };
        if self.histogram.zero > 0 {
            row("0".to_owned(), self.histogram.zero)?;
        }
        for ([from, below], count) in rows {
            let label = if from == 0.0 {
                format!("below {below:e}")
            } else if below.is_infinite() {
                format!("{from:e} and more")
            } else {
                format!("{from:e} to {below:e}")
            };
            row(label, count)?;
        }
        writeln!(output)?;
        for flip in self.flips.iter().take(LISTED) {
            let [x, y] = flip.pixel;
            let edge = match &flip.edge {
                Some(edge) => edge.told(),
                None => "wrong: there is no edge".to_owned(),
            };
            writeln!(
                output,
                "pixel {x},{y}, off by {}: {edge}",
                number(flip.error)
            )?;
        }
        if self.flips.len() > LISTED {
            writeln!(output, "and {} more", self.flips.len() - LISTED)?;
        }
        let tolerance = number(self.tolerance);
        let agreeing = self.pixels - self.flips.len() as u64;
        let largest = match self.largest_at {
            Some([x, y]) => format!("the largest error {} at {x},{y}", number(self.largest)),
            None => "without any error".to_owned(),
        };
        writeln!(output, "{agreeing} agree to {tolerance}, {largest}")?;
        if let Some(path) = oracle {
            writeln!(output, "wrote {}", printable_path(path))?;
        }
        let verdict = if self.objection().is_some() {
            "the renderer does not agree with the equations here"
        } else if self.flips.is_empty() {
            "the renderer agrees with the equations"
        } else {
            "the renderer agrees with the equations, but for sides of edges that rounding decides"
        };
        writeln!(output, "verdict: {verdict}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_counted_by_decades() {
        let mut histogram = Histogram::default();
        for error in [0.0, 1e-12, 5e-8, 6e-8, 2e-6, f64::INFINITY] {
            histogram.add(error);
        }
        let counts: Vec<u64> = histogram.rows().iter().map(|row| row.1).collect();
        assert_eq!(counts, [1, 0, 2, 0, 1, 0, 0, 0, 0, 0, 1]);
        assert_eq!(histogram.zero, 1);
        let mut few = Histogram::default();
        few.add(5e-8);
        let [([from, below], 1)] = few.rows()[..] else {
            panic!("{few:?}");
        };
        assert!((from / 1e-8 - 1.0).abs() < 1e-12 && (below / 1e-7 - 1.0).abs() < 1e-12);
    }
}
