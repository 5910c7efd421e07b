//! The table for people: the equations with the numbers put in.

use std::fmt::Write;

use candela::internal::printable;
use candela::oracle::{
    AreaTerms, Explanation, HitTerms, LightTerms, LuminaireTerms, MaterialTerms, Outcome,
    SpotTerms, TransportUsed,
};

use super::ways::{equation, rows};
use super::{Report, SpectralRadiance};
use crate::cli::numbers::number;

/// Characters of the longest bar of a spectrum.
const BAR: f64 = 40.0;

/// A line of the table.
enum Line {
    /// Text as it is.
    Text(String),
    /// A name or an equation, three numbers and their unit or a remark.
    Row {
        label: String,
        cells: [String; 3],
        remark: String,
    },
}

/// Lines, of which the rows are aligned at their decimal points.
struct Table(Vec<Line>);

/// One explained point in a line: where, L_o, how far the renderer is from that, what is seen, and what becomes
/// of each light.
pub(super) fn line(report: &Report) -> String {
    let [x, y] = report.pixel;
    let explanation = &report.explanation;
    let [r, g, b] = explanation.radiance.map(number);
    let off = report.renderer.as_ref().map_or(0.0, |renderer| {
        let largest = |most: f64, difference: &f64| most.max(difference.abs());
        renderer.difference.iter().fold(0.0, largest)
    });
    let Some(hit) = &explanation.hit else {
        return format!(
            "{x},{y}  {r} {g} {b} cd/m², renderer ±{}: background",
            number(off)
        );
    };
    let mut line = format!(
        "{x},{y}  {r} {g} {b} cd/m², renderer ±{}: `{}`",
        number(off),
        printable(&hit.object)
    );
    if let Some(emission) = &hit.emission {
        line.push_str(if emission.shines {
            ", a light"
        } else {
            ", a light from behind"
        });
    }
    if equation(hit.reflectance.model).is_some() {
        let count = explanation.ways.len() + explanation.more_ways;
        let ways = if count == 1 { "way" } else { "ways" };
        let _ = write!(line, ", {}, {count} {ways}", hit.reflectance.model);
    }
    for light in &explanation.lights {
        let outcome = match light.outcome {
            Outcome::Lit => "lit by",
            Outcome::Through => "lit through a pane by",
            Outcome::Partial => "in the penumbra of",
            Outcome::Occluded => "in the shadow of",
            Outcome::Below => "turned away from",
            Outcome::Outside if light.area.is_some() => "behind",
            Outcome::Outside => "outside of the cone of",
            Outcome::AtPoint => "at",
        };
        let _ = write!(line, ", {outcome} `{}`", printable(&light.name));
    }
    line
}

/// One explained point as text.
pub(super) fn table(report: &Report, resolution: [u32; 2]) -> String {
    let mut table = Table(Vec::new());
    let [width, height] = resolution;
    let place_in_image = match &report.renderer {
        Some(_) => {
            let [x, y] = report.pixel;
            format!("Pixel ({x}, {y}) of {width} × {height}")
        }
        None => {
            let [x, y] = report.point;
            format!("Point ({x}, {y}) of {width} × {height} pixels")
        }
    };
    let explanation = &report.explanation;
    match &explanation.hit {
        None => {
            table.text(format!("{place_in_image}: nothing is there"));
            table.gap();
            table.header(["R", "G", "B"]);
            table.row("background", explanation.radiance, "cd/m²");
        }
        Some(hit) if let Some(emission) = &hit.emission => {
            table.text(format!("{place_in_image}: {}", place(hit)));
            table.text(if emission.shines {
                "L_o = L, which it emits; it reflects nothing"
            } else {
                "L_o = 0: it does not shine to this side, and reflects nothing"
            });
            table.hit(hit);
            table.gap();
            table.header(["R", "G", "B"]);
            table.row("L9  L_o", explanation.radiance, "cd/m²");
        }
        Some(hit) if let Some(equation) = equation(hit.reflectance.model) => {
            table.text(format!("{place_in_image}: {}", place(hit)));
            table.text(equation);
            table.transport(explanation.transport);
            table.hit(hit);
            table.ways(explanation);
        }
        Some(hit) => {
            table.text(format!("{place_in_image}: {}", place(hit)));
            if hit.reflectance.is_coated {
                table.text("L_o = R L(reflected) + (1 − R) Σ L_i (r_d + r_s) V    L_i = I/d²");
            } else {
                table.text("L_o = Σ L_i (r_d + r_s) V    L_i = I/d²");
            }
            table.text(model(&hit.reflectance));
            table.transport(explanation.transport);
            table.hit(hit);
            table.material(&hit.reflectance);
            for light in &explanation.lights {
                table.light(&hit.reflectance, light);
            }
            table.sum(explanation, hit.reflectance.is_coated);
            if hit.reflectance.is_coated {
                table.ways(explanation);
            }
        }
    }
    if let Some(renderer) = &report.renderer {
        table.gap();
        let rendered = renderer.radiance.map(f64::from);
        table.row("renderer, in f32", rendered, "cd/m²");
        table.row("renderer − equation", renderer.difference, "cd/m²");
    }
    if let Some(spectrum) = &report.spectrum {
        table.spectrum(spectrum);
    }
    table.written()
}

/// What is hit: object `ball`, material `clay`, t = 5.8 m
fn place(hit: &HitTerms) -> String {
    let distance = number(hit.distance);
    if hit.emission.is_some() {
        return format!("light `{}`, t = {distance} m", printable(&hit.object));
    }
    let mut text = format!("object `{}`", printable(&hit.object));
    if let Some(group) = &hit.group {
        let _ = write!(text, ", group `{}`", printable(group));
    }
    if let Some(triangle) = hit.triangle {
        let _ = write!(text, ", triangle {triangle}");
    }
    let material = printable(&hit.material);
    let _ = write!(text, ", material `{material}`, t = {distance} m");
    text
}

/// The names of the material's constants k_d and k_s, by its model.
fn constants(material: &MaterialTerms) -> [&'static str; 2] {
    if is_normalized(material) {
        ["ρ_d", "ρ_s"]
    } else {
        ["k_d", "k_s"]
    }
}

fn is_normalized(material: &MaterialTerms) -> bool {
    material.model == "normalized_phong"
}

/// L5 and L7, as the material's model has them.
fn model(material: &MaterialTerms) -> &'static str {
    if is_normalized(material) {
        "r_d = ρ_d/π cos(n, ω_i)    r_s = ρ_s (n+2)/(2π) cosⁿ(ω_o, ω_r) cos(n, ω_i)"
    } else {
        "r_d = k_d cos(n, ω_i)    r_s = k_s cosⁿ(ω_o, ω_r)"
    }
}

/// Why a light adds nothing, if so.
fn obstacle(light: &LightTerms) -> Option<String> {
    match light.outcome {
        Outcome::Lit => None,
        Outcome::Through | Outcome::Partial | Outcome::Occluded => Some(stands_between(light)),
        Outcome::Below => Some("below the surface".to_owned()),
        Outcome::Outside if light.area.is_some() => Some("does not shine to p".to_owned()),
        Outcome::Outside => Some("outside of the cone".to_owned()),
        Outcome::AtPoint => Some("at p itself, d = 0".to_owned()),
    }
}

/// So many names of what hides parts of a light are listed.
const NAMED: usize = 3;

fn stands_between(light: &LightTerms) -> String {
    if let Some(AreaTerms { occluders, .. }) = &light.area {
        return between_of(occluders);
    }
    if let Some(panes) = &light.panes {
        return format!("through {}", listed(&panes.names));
    }
    match &light.occluder {
        Some(occluder) => format!("`{}` stands between", printable(occluder)),
        None => "nothing stands between".to_owned(),
    }
}

/// What hides parts of a light: `wall`, `ball` and 3 more stand between
fn between_of(occluders: &[String]) -> String {
    match occluders.len() {
        0 => "nothing stands between".to_owned(),
        1 => format!("{} stands between", listed(occluders)),
        _ => format!("{} stand between", listed(occluders)),
    }
}

/// The first names of some: `a`, `b` and 3 more
fn listed(names: &[String]) -> String {
    let named: Vec<String> = names
        .iter()
        .take(NAMED)
        .map(|name| format!("`{}`", printable(name)))
        .collect();
    match (&named[..], names.len() - named.len()) {
        ([others @ .., last], 0) if !others.is_empty() => {
            format!("{} and {last}", others.join(", "))
        }
        (named, 0) => named.join(", "),
        (named, more) => format!("{} and {more} more", named.join(", ")),
    }
}

impl Table {
    fn text(&mut self, text: impl Into<String>) {
        self.0.push(Line::Text(text.into()));
    }

    fn gap(&mut self) {
        self.text("");
    }

    fn header(&mut self, names: [&str; 3]) {
        self.0.push(Line::Row {
            label: String::new(),
            cells: names.map(str::to_owned),
            remark: String::new(),
        });
    }

    fn row(&mut self, label: impl Into<String>, values: [f64; 3], remark: impl Into<String>) {
        self.0.push(Line::Row {
            label: label.into(),
            cells: values.map(number),
            remark: remark.into(),
        });
    }

    /// L1 and L2: where the ray ends.
    fn hit(&mut self, hit: &HitTerms) {
        self.gap();
        self.header(["x", "y", "z"]);
        self.row("L2  p", hit.position, "m");
        if hit.normal == hit.geometric_normal {
            self.row("    n", hit.normal, "");
        } else {
            self.row("    n, interpolated", hit.normal, "");
            self.row("    n of the triangle", hit.geometric_normal, "");
        }
        self.row("    ω_o, to the viewer", hit.to_viewer, "");
        if let Some(lift) = hit.lift {
            let length = lift.iter().map(|x| x * x).sum::<f64>().sqrt();
            let remark = match length {
                0.0 => "m: shadow rays start at p".to_owned(),
                _ => format!("m: shadow rays start at p′, {} m off", number(length)),
            };
            self.row("L4  p′ − p, lift", lift, remark);
        }
    }

    fn material(&mut self, material: &MaterialTerms) {
        let [diffuse, specular] = constants(material);
        self.gap();
        self.header(["R", "G", "B"]);
        self.row(format!("    {diffuse}"), material.diffuse, "");
        let shininess = match material.shininess {
            Some(n) => format!("n = {}", number(n)),
            None => String::new(),
        };
        self.row(format!("    {specular}"), material.specular, shininess);
    }

    /// L3 to L8 and the light's term of L9.
    fn light(&mut self, material: &MaterialTerms, light: &LightTerms) {
        self.gap();
        let distance = number(light.distance);
        // A sun has no place.
        let is_sun = light.distance.is_infinite();
        let place = if is_sun {
            "of parallel rays".to_owned()
        } else {
            format!("d = {distance} m")
        };
        match light.outcome {
            Outcome::AtPoint => {
                self.text(format!(
                    "Light `{}` is at p itself, d = 0: it adds nothing",
                    printable(&light.name)
                ));
                return;
            }
            Outcome::Below => {
                self.text(format!(
                    "Light `{}`, {place}, is below the surface: it adds nothing",
                    printable(&light.name)
                ));
            }
            Outcome::Outside => {
                self.text(format!(
                    "Light `{}`, {place}, {}: it adds nothing",
                    printable(&light.name),
                    if light.area.is_some() {
                        "does not shine to p"
                    } else if light.luminaire.is_some() {
                        "sends nothing to p"
                    } else {
                        "has p outside of its cone"
                    }
                ));
            }
            Outcome::Lit | Outcome::Through | Outcome::Partial | Outcome::Occluded => {
                self.text(format!("Light `{}`, {place}", printable(&light.name)));
            }
        }
        if let Some(area) = &light.area {
            self.area(material, light, area);
            return;
        }
        let (to_light, reflected) = (vector(light.to_light), vector(light.reflected));
        let width = to_light.chars().count().max(reflected.chars().count());
        let (cos_incident, cos_lobe) = (number(light.cos_incident), number(light.cos_lobe));
        self.text(format!(
            "    ω_i = {to_light:width$}    cos(n, ω_i)   = {cos_incident}"
        ));
        if light.outcome == Outcome::Below {
            return;
        }
        if let Some(SpotTerms { angle, falloff }) = light.spot {
            let (angle, falloff) = (number(angle), number(falloff));
            self.text(format!(
                "    θ = {angle}° from the axis    f(θ) = {falloff}"
            ));
        }
        if let Some(LuminaireTerms { angles, factor }) = light.luminaire {
            let [vertical, horizontal] = angles.map(number);
            let factor = number(factor);
            self.text(format!(
                "    V = {vertical}°, H = {horizontal}°    f(V, H) = {factor} of the largest intensity"
            ));
        }
        if light.outcome == Outcome::Outside {
            return;
        }
        self.text(format!(
            "L6  ω_r = {reflected:width$}    cos(ω_o, ω_r) = {cos_lobe}"
        ));

        let [diffuse, specular] = constants(material);
        let shininess = material.shininess.map_or_else(|| "n".to_owned(), number);
        let (diffuse, specular) = if is_normalized(material) {
            (
                format!("L5  r_d = {diffuse}/π · {cos_incident}"),
                format!(
                    "L7  r_s = {specular} · {} · {cos_lobe}^{shininess} · {cos_incident}",
                    material.shininess.map_or_else(
                        || "(n+2)/(2π)".to_owned(),
                        |n| number((n + 2.0) / std::f64::consts::TAU)
                    )
                ),
            )
        } else {
            (
                format!("L5  r_d = {diffuse} · {cos_incident}"),
                format!("L7  r_s = {specular} · {cos_lobe}^{shininess}"),
            )
        };
        let of_luminaire = light.luminaire.map(|luminaire| number(luminaire.factor));
        let (intensity, incident) = match light.spot {
            None if let Some(factor) = of_luminaire => (
                "    I, the largest",
                format!("L3  L_i = I · {factor} / {distance}²"),
            ),
            None if is_sun => ("    E", "L3  L_i = E".to_owned()),
            None => ("    I", format!("L3  L_i = I / {distance}²")),
            Some(SpotTerms { falloff, .. }) => {
                let falloff = number(falloff);
                (
                    "    I, on the axis",
                    format!("L3  L_i = I · {falloff} / {distance}²"),
                )
            }
        };
        self.row(intensity, light.intensity, if is_sun { "lx" } else { "cd" });
        self.row(incident, light.incident, "lx");
        self.row(diffuse, light.diffuse, "1/sr");
        self.row(specular, light.specular, "1/sr");
        let reflectance = std::array::from_fn(|i| light.diffuse[i] + light.specular[i]);
        self.row("L8  r   = r_d + r_s", reflectance, "1/sr");
        let visibility = match &light.panes {
            Some(panes) => panes.transmittance,
            None if light.visible => 1.0,
            None => 0.0,
        };
        self.row("L4  V", [visibility; 3], stands_between(light));
        self.row("    L_i · r · V", light.radiance, "cd/m²");
    }

    /// The same for a light with an area, L3 to L8 over all of it that is above the surface.
    fn area(&mut self, material: &MaterialTerms, light: &LightTerms, area: &AreaTerms) {
        self.text(format!(
            "    ω_i = {}, to its middle",
            vector(light.to_light)
        ));
        if matches!(light.outcome, Outcome::Below | Outcome::Outside) {
            return;
        }
        self.text(format!(
            "    Ω = {} sr above the surface    form factor = {}",
            number(area.solid_angle),
            number(area.form_factor)
        ));
        let [diffuse, specular] = constants(material);
        let cos_incident = number(light.cos_incident);
        let over_pi = if is_normalized(material) { "/π" } else { "" };
        let diffuse = format!("L5  r_d = {diffuse}{over_pi} · {cos_incident}");
        let specular = format!("L7  r_s, of {specular}");
        self.row("    L", light.intensity, "cd/m²");
        self.row("L3  L_i = L Ω", light.incident, "lx");
        self.row(diffuse, light.diffuse, "1/sr, the mean");
        self.row(specular, light.specular, "1/sr, the mean");
        let reflectance = std::array::from_fn(|i| light.diffuse[i] + light.specular[i]);
        self.row("L8  r   = r_d + r_s", reflectance, "1/sr");
        self.row("    ∫ L r dω", light.unoccluded, "cd/m²");
        self.row(
            "L4  V, the part seen",
            [area.seen; 3],
            between_of(&area.occluders),
        );
        if let Some(panes) = &light.panes {
            self.text(format!("    a part of it through {}", listed(&panes.names)));
        }
        self.row("    ∫ L r V dω", light.radiance, "cd/m²");
        self.row("    which may be off by", area.error, "cd/m²");
    }

    /// What R, G, B are, where light has more components.
    fn transport(&mut self, transport: TransportUsed) {
        match transport {
            TransportUsed::Rgb => {}
            TransportUsed::Spectral => {
                self.text("Products are taken wavelength by wavelength, not of these R, G, B:");
                self.text("light is as seen, reflectances (the constants, r) are as under D65");
            }
        }
    }

    /// What comes over smooth surfaces: of each way what it adds, and the products of its factors.
    fn ways(&mut self, explanation: &Explanation) {
        self.gap();
        self.text(
            "Ways over smooth surfaces, the strongest first, and the products of their factors",
        );
        self.header(["R", "G", "B"]);
        for (number, way) in (1..).zip(&explanation.ways) {
            for (label, values, remark) in rows(number, way) {
                self.row(label, values, remark);
            }
        }
        match explanation.more_ways {
            0 => {}
            1 => self.text("and 1 more way"),
            more => self.text(format!("and {more} more ways")),
        }
        self.row("    L_o", explanation.radiance, "cd/m²");
    }

    /// L9: what the lights add up to; under a coat without it.
    fn sum(&mut self, explanation: &Explanation, is_coated: bool) {
        self.gap();
        self.text("Sum over the lights");
        for light in &explanation.lights {
            let remark = obstacle(light).unwrap_or_default();
            self.row(
                format!("    {}", printable(&light.name)),
                light.radiance,
                remark,
            );
        }
        if is_coated {
            let lights = explanation.lights.iter();
            let sum = lights.fold([0.0; 3], |sum, light| {
                std::array::from_fn(|i| sum[i] + light.radiance[i])
            });
            self.row("L9  Σ L_i r V", sum, "cd/m², without the coat");
        } else {
            self.row("L9  L_o = Σ L_i r V", explanation.radiance, "cd/m²");
        }
    }

    /// L9 wavelength by wavelength, with a bar for each.
    fn spectrum(&mut self, spectrum: &SpectralRadiance) {
        self.gap();
        self.text("L_o(λ) in W/(m² sr nm)");
        let peak = spectrum.radiance.iter().copied().fold(0.0, f64::max);
        let numbers: Vec<String> = spectrum
            .radiance
            .iter()
            .map(|&value| number(value))
            .collect();
        let parts = numbers.iter().map(|number| at_point(number));
        let width = |text: &str| text.chars().count();
        let whole_width = parts
            .clone()
            .map(|(whole, _)| width(whole))
            .max()
            .unwrap_or(0);
        let fraction_width = parts
            .clone()
            .map(|(_, rest)| width(rest))
            .max()
            .unwrap_or(0);
        let values = spectrum.wavelengths.iter().zip(&spectrum.radiance);
        for ((nm, &value), (whole, fraction)) in values.zip(parts) {
            let length = if peak > 0.0 { BAR * value / peak } else { 0.0 };
            let bar = "▇".repeat(length.round() as usize);
            self.text(format!(
                "    {nm} nm  {whole:>whole_width$}{fraction:fraction_width$}  {bar}"
            ));
        }
    }

    /// The lines, with labels, decimal points and remarks below each other.
    fn written(self) -> String {
        let (mut label_width, mut whole_width, mut fraction_width) = (0, 0, 0);
        for line in &self.0 {
            if let Line::Row { label, cells, .. } = line {
                label_width = label_width.max(label.chars().count());
                for (whole, fraction) in cells.iter().map(|cell| at_point(cell)) {
                    whole_width = whole_width.max(whole.chars().count());
                    fraction_width = fraction_width.max(fraction.chars().count());
                }
            }
        }
        let mut text = String::new();
        for line in &self.0 {
            let mut written = String::new();
            match line {
                Line::Text(text) => written.push_str(text),
                Line::Row {
                    label,
                    cells,
                    remark,
                } => {
                    let _ = write!(written, "{label:label_width$}");
                    for (whole, fraction) in cells.iter().map(|cell| at_point(cell)) {
                        let _ =
                            write!(written, "  {whole:>whole_width$}{fraction:fraction_width$}");
                    }
                    let _ = write!(written, "  {remark}");
                }
            }
            text.push_str(written.trim_end());
            text.push('\n');
        }
        text
    }
}

/// A number before its decimal point, and from there on.
fn at_point(number: &str) -> (&str, &str) {
    let point = number.find(['.', 'e']).unwrap_or(number.len());
    number.split_at(point)
}

/// (x, y, z)
fn vector(v: [f64; 3]) -> String {
    let [x, y, z] = v.map(number);
    format!("({x}, {y}, {z})")
}
