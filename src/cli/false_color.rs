//! False colors of `tonemap`: their unit, range, legend and lines.

mod scale;

use std::path::Path;

use candela::Primaries;
use candela::display::{DisplayError, Drawn, FalseColor, Field, Input, Measure, Overlay};
use candela::exr::{ExrError, ExrProblem};
use candela::internal::printable_path;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::Failure;
use super::isolines::{isolines, line_color};
use super::legend::{Mark, beside, legend};
use super::numbers::number;

/// The layer that is in lux.
const ILLUMINANCE: &str = "irradiance";

/// The most lines that are asked for.
const MOST_VALUES: usize = 100;

/// What false colors show, and what is drawn with them.
#[derive(Debug, clap::Args)]
pub(super) struct FalseColorArguments {
    /// What false colors are of [default: stops, or nits where the view has a range]
    ///
    /// stops: from middle gray; nits, cd/m2: the picture's luminance; lx: illuminance, the layer irradiance of candela
    /// render --layers irradiance, or what --layer names. nits and lx have the range of --view false-color=MIN:MAX, or
    /// one that is chosen from the picture.
    #[arg(
        long,
        value_name = "UNIT",
        value_parser = PossibleValuesParser::new([
            PossibleValue::new("stops"),
            PossibleValue::new("nits").aliases(["cd/m2", "cd/m²"]),
            PossibleValue::new("lx").alias("lux"),
        ])
        .map(|unit| match unit.as_str() {
            "stops" => Measure::Stops,
            "lx" | "lux" => Measure::Illuminance,
            _ => Measure::Luminance,
        })
    )]
    unit: Option<Measure>,

    /// Draw lines of equal light in false colors: at values such as 100,300,500, in the unit, or auto
    ///
    /// auto: the steps of EN 12464-1 within the range. Where light jumps, as at the edges of objects and of hard shadows,
    /// lines end.
    #[arg(long, value_name = "LIST", value_parser = values)]
    iso_lines: Option<IsoLines>,

    /// Where the legend of false colors is [default: over, or beside where there is a unit or lines]
    ///
    /// beside: at the right of the picture, which becomes wider; over: in the picture, at its right edge, if there is
    /// room; none: nowhere.
    #[arg(
        long,
        value_name = "PLACE",
        value_parser = PossibleValuesParser::new(Place::ALL.map(Place::name))
            .map(|name| Place::ALL.into_iter().find(|place| place.name() == name).unwrap_or(Place::Beside))
    )]
    legend: Option<Place>,
}

/// Where a legend is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Beside,
    Over,
    Nowhere,
}

impl Place {
    const ALL: [Self; 3] = [Self::Beside, Self::Over, Self::Nowhere];

    const fn name(self) -> &'static str {
        match self {
            Self::Beside => "beside",
            Self::Over => "over",
            Self::Nowhere => "none",
        }
    }
}

/// The values of lines.
#[derive(Clone, Debug, PartialEq)]
enum IsoLines {
    Auto,
    /// In order, each once.
    Values(Vec<f64>),
}

/// Numbers above 0, parted by commas, or auto.
fn values(text: &str) -> Result<IsoLines, String> {
    if text == "auto" {
        return Ok(IsoLines::Auto);
    }
    let mut values = Vec::new();
    for word in text.split(',') {
        let word = word.trim();
        let value = word.parse::<f64>().ok().filter(|value| value.is_finite());
        let value = value.ok_or_else(|| {
            format!("`{word}` is not a number; expected values such as 100,300,500, or auto")
        })?;
        if value <= 0.0 {
            return Err(format!(
                "the scale is logarithmic and has no {word}; expected values above 0"
            ));
        }
        values.push(value);
    }
    values.sort_by(f64::total_cmp);
    values.dedup();
    if values.len() > MOST_VALUES {
        return Err(format!("more than {MOST_VALUES} lines are not drawn"));
    }
    Ok(IsoLines::Values(values))
}

/// What false colors show of a picture.
pub(super) struct Shown {
    pub(super) colors: FalseColor,
    overlays: Vec<Overlay>,
    columns: u32,
    options: String,
    /// Whether the range was chosen.
    is_chosen: bool,
}

impl Shown {
    /// What is drawn over and beside the picture.
    pub(super) fn drawn(&self) -> Drawn<'_> {
        Drawn {
            overlays: &self.overlays,
            columns: self.columns,
            options: &self.options,
        }
    }

    /// The range, where it was chosen from the picture.
    pub(super) fn chosen(&self) -> Option<String> {
        let [least, most] = self.colors.range().map(rounded);
        let unit = unit(self.colors.measure());
        self.is_chosen
            .then(|| format!("range: {} to {} {unit}", number(least), number(most)))
    }
}

/// Ends of a range are off by a rounding.
fn rounded(value: f64) -> f64 {
    format!("{value:.9e}").parse().unwrap_or(value)
}

/// A unit as it is written.
const fn unit(measure: Measure) -> &'static str {
    match measure {
        Measure::Stops => "EV",
        Measure::Luminance => "cd/m²",
        Measure::Illuminance => "lx",
    }
}

impl FalseColorArguments {
    /// What is wrong with the options beside a view, of which these are the false colors, if it has them.
    pub(super) fn misuse(&self, view: Option<&FalseColor>, is_balanced: bool) -> Option<String> {
        let given = [
            (self.unit.is_some(), "--unit"),
            (self.iso_lines.is_some(), "--iso-lines"),
            (self.legend.is_some(), "--legend"),
        ];
        let given = given
            .into_iter()
            .find_map(|(is_given, name)| is_given.then_some(name))?;
        let Some(view) = view else {
            return Some(format!(
                "{given} is of false colors: add --view false-color"
            ));
        };
        let has_range = view.measure() == Measure::Luminance;
        if self.unit == Some(Measure::Stops) && has_range {
            return Some(
                "the range of the view is in cd/m² or lx: --unit nits or --unit lx; stops have --view false-color"
                    .to_owned(),
            );
        }
        if self.iso_lines.is_some() && self.measure(view) == Measure::Stops {
            return Some(
                "lines have values in cd/m² or lx: add --unit nits or --unit lx".to_owned(),
            );
        }
        let is_of_light = self.is_of_a_layer() || self.iso_lines.is_some();
        (is_of_light && is_balanced).then(|| {
            "--white-balance changes luminances, and illuminances have no color: leave it away"
                .to_owned()
        })
    }

    fn measure(&self, view: &FalseColor) -> Measure {
        self.unit.unwrap_or(view.measure())
    }

    fn is_of_a_layer(&self) -> bool {
        self.unit == Some(Measure::Illuminance)
    }

    /// Whether each picture has a range of its own.
    pub(super) fn chooses(&self, view: Option<&FalseColor>) -> bool {
        view.is_some_and(|view| {
            view.measure() == Measure::Stops && self.measure(view) != Measure::Stops
        })
    }

    /// Opens a picture; in lux, the layer that is.
    pub(super) fn open(&self, input: &Path, layer: Option<&str>) -> Result<Input, Failure> {
        if !self.is_of_a_layer() {
            return Ok(Input::open(input, layer)?);
        }
        let opened = Input::open_covered(input, layer.unwrap_or(ILLUMINANCE));
        match opened {
            Err(DisplayError::Read(ExrError {
                path,
                problem: ExrProblem::NoLayer { .. },
            })) if layer.is_none() => Err(format!(
                "{} has no layer `{ILLUMINANCE}`, which --unit lx shows: render it with --layers {ILLUMINANCE}, or name a \
                 layer that is in lux by --layer",
                printable_path(&path)
            )
            .into()),
            opened => Ok(opened?),
        }
    }

    /// What is shown of a picture, in its colors or those of an input space.
    pub(super) fn of(
        &self,
        view: &FalseColor,
        input: &Input,
        space: Option<Primaries>,
    ) -> Result<Shown, Failure> {
        let measure = self.measure(view);
        let is_chosen = self.chooses(Some(view));
        let field = if is_chosen || self.iso_lines.is_some() {
            Field::read(input, space)?
        } else {
            None
        };
        let range = if is_chosen {
            scale::range(field.as_ref())
        } else {
            view.range()
        };
        let [least, most] = range;
        let colors = match measure {
            Measure::Stops => *view,
            Measure::Luminance => FalseColor::luminance(least, most)?,
            Measure::Illuminance => FalseColor::illuminance(least, most)?,
        };
        let lines = match &self.iso_lines {
            None => Vec::new(),
            Some(IsoLines::Auto) => scale::values(range),
            Some(IsoLines::Values(values)) => values.clone(),
        };
        let resolution = input.resolution();
        let mut overlays = Vec::new();
        if let Some(field) = field.filter(|_| !lines.is_empty()) {
            overlays.push(isolines(&field, resolution, &lines, &colors)?);
        }
        let marks: Vec<Mark> = lines
            .iter()
            .map(|&value| Mark {
                value,
                color: line_color(&colors, value),
            })
            .collect();
        let mut columns = 0;
        let place = self.place();
        match place {
            Place::Nowhere => {}
            Place::Over => overlays.extend(legend(resolution, &colors, &marks)),
            Place::Beside => {
                if let Some(panel) = beside(resolution, &colors, &marks) {
                    columns = panel.width;
                    overlays.push(panel);
                }
            }
        }
        Ok(Shown {
            colors,
            overlays,
            columns,
            options: self.options(&lines),
            is_chosen,
        })
    }

    fn place(&self) -> Place {
        let is_plain = self.unit.is_none() && self.iso_lines.is_none();
        self.legend
            .unwrap_or(if is_plain { Place::Over } else { Place::Beside })
    }

    /// The options that draw the same again, for these lines.
    fn options(&self, lines: &[f64]) -> String {
        let mut words = Vec::new();
        if !lines.is_empty() {
            let values: Vec<String> = lines.iter().map(f64::to_string).collect();
            words.push(format!("--iso-lines {}", values.join(",")));
        }
        // Over the picture is where it is if nothing is said.
        if self.place() != Place::Over || !lines.is_empty() || self.unit.is_some() {
            words.push(format!("--legend {}", self.place().name()));
        }
        words.join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use candela::image::Window;
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct Command {
        #[command(flatten)]
        arguments: FalseColorArguments,
    }

    fn parse(line: &str) -> FalseColorArguments {
        Command::try_parse_from(["tonemap"].into_iter().chain(line.split_whitespace()))
            .unwrap()
            .arguments
    }

    #[test]
    fn values_of_lines() {
        assert_eq!(values("auto"), Ok(IsoLines::Auto));
        assert_eq!(
            values("500, 100,300,100"),
            Ok(IsoLines::Values(vec![100.0, 300.0, 500.0]))
        );
        for (bad, said) in [
            ("bright", "`bright` is not a number"),
            ("100,", "`` is not a number"),
            ("100,inf", "`inf` is not a number"),
            ("0,100", "logarithmic and has no 0"),
            ("-5", "logarithmic and has no -5"),
        ] {
            let error = values(bad).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
        assert!(values(&vec!["1"; 101].join(",")).is_ok());
        let many: Vec<String> = (1..=101).map(|value| value.to_string()).collect();
        assert!(values(&many.join(",")).is_err());
    }

    #[test]
    fn options_that_do_not_go_together() {
        let stops = FalseColor::STOPS;
        let range = FalseColor::luminance(1.0, 100.0).unwrap();
        let said = |line: &str, view: Option<&FalseColor>| parse(line).misuse(view, false);
        for line in ["--unit lx", "--iso-lines auto", "--legend none"] {
            assert!(
                said(line, None)
                    .unwrap()
                    .ends_with("add --view false-color")
            );
        }
        assert!(said("--unit stops", Some(&range)).is_some());
        assert!(said("--iso-lines 100", Some(&stops)).is_some());
        for line in [
            "--unit lx --iso-lines 100",
            "--unit nits",
            "--unit cd/m²",
            "--legend over",
        ] {
            assert_eq!(said(line, Some(&stops)), None, "{line}");
        }
        for line in ["--iso-lines 10,20", "--unit lux", "--unit cd/m2"] {
            assert_eq!(said(line, Some(&range)), None, "{line}");
        }
        assert!(parse("--unit lx").misuse(Some(&stops), true).is_some());
        assert_eq!(parse("--legend none").misuse(Some(&stops), true), None);
        assert_eq!(parse("").misuse(None, true), None);
    }

    #[test]
    fn what_draws_it_again() {
        assert_eq!(parse("").options(&[]), "");
        assert_eq!(parse("--legend none").options(&[]), "--legend none");
        let lines = parse("--unit lx --iso-lines auto").options(&[7.5, 300.0]);
        assert_eq!(lines, "--iso-lines 7.5,300 --legend beside");
    }

    #[test]
    fn a_range_is_chosen_unless_it_is_given() {
        let [stops, range] = [FalseColor::STOPS, FalseColor::luminance(1.0, 9.0).unwrap()];
        assert!(parse("--unit lx").chooses(Some(&stops)));
        assert!(!parse("--unit lx").chooses(Some(&range)));
        assert!(!parse("").chooses(Some(&stops)));
        let field = Field::new(Window::whole([2, 1]), vec![30.0, 400.0]);
        assert_eq!(scale::range(Some(&field)), [20.0, 500.0]);
    }
}
