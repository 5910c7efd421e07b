//! Which equation of the lecture a layer of `candela render --layers` shows.

/// Its number, and the term; `None` for layers of other programs.
pub(super) fn equation(layer: &str) -> Option<&'static str> {
    if layer.starts_with("shadow_") {
        return Some("L4: V");
    }
    if let Some(light) = layer.strip_prefix("light_") {
        return Some(if light == "background" {
            "background"
        } else if light.ends_with("_diffuse") {
            "L5: Lᵢ r_d V"
        } else if light.ends_with("_specular") {
            "L7: Lᵢ r_s V"
        } else {
            "L8: Lᵢ r V"
        });
    }
    match layer {
        "" => Some("L9"),
        "diffuse" => Some("L5: Σ Lᵢ r_d V"),
        "specular" => Some("L7: Σ Lᵢ r_s V"),
        "albedo" => Some("L5: k_d"),
        "irradiance" => Some("Σ Lᵢ cos V"),
        "N" => Some("n"),
        "P" => Some("L1: p"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_of_candela_have_an_equation() {
        for (layer, expected) in [
            ("shadow_key", Some("L4: V")),
            ("light_key", Some("L8: Lᵢ r V")),
            ("light_key_diffuse", Some("L5: Lᵢ r_d V")),
            ("specular", Some("L7: Σ Lᵢ r_s V")),
            ("ViewLayer.Combined", None),
        ] {
            assert_eq!(equation(layer), expected);
        }
    }
}
