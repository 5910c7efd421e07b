//! The ways of light over smooth surfaces, vertex by vertex, for the table.

use candela::internal::printable;
use candela::oracle::{Event, VertexTerms, WayTerms};

use crate::cli::numbers::number;

/// A line of the table: a label, three numbers and a remark.
pub(super) type Row = (String, [f64; 3], String);

/// What a way adds, and its vertices.
pub(super) fn rows(number_of_way: usize, way: &WayTerms) -> Vec<Row> {
    let wavelengths = match way.wavelengths {
        None => String::new(),
        Some(1) => ", 1 wavelength".to_owned(),
        Some(count) => format!(", {count} wavelengths"),
    };
    let heading = format!("Way {number_of_way}{wavelengths}");
    let mut rows = vec![(heading, way.radiance, "cd/m²".to_owned())];
    rows.extend(way.vertices.iter().map(vertex));
    rows
}

/// Of a smooth material: how it makes L_o.
pub(super) fn equation(model: &str) -> Option<&'static str> {
    Some(match model {
        "mirror" => "L_o = R L(reflected)",
        "metal" => "L_o = R L(reflected)    R = (|r∥|² + |r⊥|²)/2 of n + ik",
        "glass" => "L_o = F L(reflected) + (1 − F)(n_i/n_t)² L(refracted)    F = (r∥² + r⊥²)/2",
        "pane" => "L_o = R L(reflected) + T L(straight on)    R = 2F/(1+F)    T = (1−F)/(1+F)",
        _ => return None,
    })
}

/// What is hit and what becomes of the ray, the product so far, the factor.
fn vertex(vertex: &VertexTerms) -> Row {
    let event = match vertex.event {
        Event::Reflected => "reflected",
        Event::TotallyReflected => "totally reflected",
        Event::Refracted => "refracted",
        Event::Passed => "passed",
        Event::Unchanged => "within other glass",
        Event::Lit => "lit",
        Event::Emitted => "a light",
        Event::Background => "background",
        Event::TooDeep => "max_depth: not followed",
        Event::Lost => "to the wrong side: lost",
    };
    let label = match (&vertex.object, vertex.distance, vertex.angle) {
        (Some(object), Some(distance), Some(angle)) => format!(
            "    `{}`, {} m, θ = {}°: {event}",
            printable(object),
            number(distance),
            number(angle)
        ),
        _ => format!("    {event}"),
    };
    let factor = match vertex.factor {
        [1.0, 1.0, 1.0] => String::new(),
        [r, g, b] if r == g && g == b => format!("× {}", number(r)),
        factor => {
            let [r, g, b] = factor.map(number);
            format!("× ({r}, {g}, {b})")
        }
    };
    (label, vertex.product, factor)
}
