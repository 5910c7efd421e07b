//! What a file says of the light in it: `candela:lights`, `candela:reflectances` and `candela:relit`, JSON in texts of
//! its header.

use std::collections::BTreeSet;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::error::RelightError;
use crate::exr::StoredExr;
use crate::memory;
use crate::scene::Transport;
use crate::spectrum::{FIRST, Observer, SAMPLES, Spectrum};

/// The attributes.
pub(super) const LIGHTS: &str = "candela:lights";
pub(super) const RELIT: &str = "candela:relit";
const REFLECTANCES: &str = "candela:reflectances";
const TRANSPORT: &str = "candela:transport";
const OBSERVER: &str = "candela:observer";

/// What JSON takes in memory for each byte of its text, at most: a number of two characters is a value of 32 bytes, in
/// a list that is as long again.
const JSON_MEMORY: u64 = 64;

/// A light of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LightRecord {
    pub(super) name: String,
    pub(super) kind: String,
    /// The group whose lights have one layer together.
    pub(super) group: Option<String>,
    /// Its luminous intensity in cd, of a spot on its axis.
    pub(super) candela: f64,
    /// I in cd for each primary of the file's color space.
    pub(super) rgb: [f64; 3],
    /// Whether a light with an area is seen itself; `None` of others, and where the file does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) visible: Option<bool>,
    /// What else there is to say of it.
    #[serde(flatten)]
    further: Map<String, Value>,
}

impl LightRecord {
    /// The name of its layer: that of its group, or its own.
    pub(super) fn share(&self) -> &str {
        self.group.as_deref().unwrap_or(&self.name)
    }
}

/// All lights, in the order of the scene; `None` where the file does not say.
pub(super) fn lights(stored: &StoredExr) -> Result<Option<Vec<LightRecord>>, RelightError> {
    let Some(lights) = json::<Vec<LightRecord>>(stored, LIGHTS)? else {
        return Ok(None);
    };
    let mut names = BTreeSet::new();
    for light in &lights {
        let is_sound = light.candela.is_finite()
            && light.candela >= 0.0
            && light.rgb.iter().all(|channel| channel.is_finite());
        if !is_sound {
            return Err(unlike(LIGHTS, "an intensity is out of range"));
        }
        if !names.insert(light.name.as_str()) {
            return Err(unlike(LIGHTS, "two lights have one name"));
        }
    }
    let mut groups = lights.iter().filter_map(|light| light.group.as_deref());
    if groups.any(|group| names.contains(group)) {
        return Err(unlike(LIGHTS, "a light and a group have one name"));
    }
    Ok(Some(lights))
}

/// How light was carried.
pub(super) fn transport(stored: &StoredExr) -> Result<Transport, RelightError> {
    let text = stored.text(TRANSPORT);
    match text.as_deref() {
        Some("rgb") => Ok(Transport::Rgb),
        Some("spectral") => Ok(Transport::Spectral),
        Some(_) => Err(unlike(TRANSPORT, "expected `rgb` or `spectral`")),
        None => Err(unlike(TRANSPORT, "it is not there")),
    }
}

/// Reflectances that light meets, and who sees it.
#[derive(Debug, Deserialize)]
struct Written {
    observer: String,
    curves: Vec<Vec<f64>>,
}

/// Reflectances that light meets: ρ_i(λ).
pub(super) fn reflectances(stored: &StoredExr) -> Result<Vec<Spectrum>, RelightError> {
    let Some(Written {
        observer: _,
        curves,
    }) = json(stored, REFLECTANCES)?
    else {
        return Ok(Vec::new());
    };
    let curves = curves.into_iter().map(|curve| {
        let is_sound = curve.len() == SAMPLES && curve.iter().all(|value| value.is_finite());
        // One after the other, from the shortest wavelength on.
        is_sound.then(|| Spectrum::from_fn(|nm| curve[(nm - f64::from(FIRST)) as usize]))
    });
    let curves: Option<Vec<Spectrum>> = curves.collect();
    curves.ok_or_else(|| {
        unlike(
            REFLECTANCES,
            "a curve has not 471 numbers, from 360 to 830 nm",
        )
    })
}

/// Whose eye saw the spectra of the scene.
pub(super) fn observer(stored: &StoredExr) -> Result<Observer, RelightError> {
    let known = |attribute, name: &str| {
        let known = Observer::ALL.into_iter().find(|known| known.name() == name);
        known.ok_or_else(|| unlike(attribute, "expected the observer `1931` or `1964`"))
    };
    if let Some(name) = stored.text(OBSERVER) {
        return known(OBSERVER, &name);
    }
    match json::<Written>(stored, REFLECTANCES)? {
        Some(written) => known(REFLECTANCES, &written.observer),
        None => Ok(Observer::default()),
    }
}

/// One change of light: the file that it was made of, and what was asked for.
#[derive(Debug, Serialize, Deserialize)]
struct Step {
    source_sha256: String,
    lights: Vec<String>,
    software: String,
}

/// The steps by which the file came about, and one more.
pub(super) fn steps(
    stored: &StoredExr,
    source_sha256: String,
    lights: Vec<String>,
) -> Result<String, RelightError> {
    let mut steps: Vec<Step> = json(stored, RELIT)?.unwrap_or_default();
    steps.push(Step {
        source_sha256,
        lights,
        software: concat!("candela ", env!("CARGO_PKG_VERSION")).to_owned(),
    });
    Ok(text(&steps))
}

/// Plain data as JSON.
pub(super) fn text(data: &impl Serialize) -> String {
    serde_json::to_string(data).expect("it is plain data, and its numbers are finite")
}

fn json<T: DeserializeOwned>(
    stored: &StoredExr,
    attribute: &'static str,
) -> Result<Option<T>, RelightError> {
    let Some(text) = stored.text(attribute) else {
        return Ok(None);
    };
    let bytes = (text.len() as u64).saturating_mul(JSON_MEMORY);
    memory::look_for(bytes).map_err(|error| {
        RelightError::Memory(error.for_what("what the header says of lights and reflectances"))
    })?;
    let read = serde_json::from_str(&text);
    read.map(Some)
        .map_err(|error| unlike(attribute, &error.to_string()))
}

fn unlike(attribute: &'static str, reason: &str) -> RelightError {
    RelightError::Header {
        attribute,
        reason: reason.to_owned(),
    }
}
