//! What moves: values at frames, and what is between them.

use crate::color::ColorSpace;

use super::value::{Mixture, Value};

/// How a value goes from one key to the next, `interpolation`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Interpolation {
    /// In a straight line.
    #[default]
    Linear,
    /// Without a bend: the cubic Hermite spline with the slopes of Catmull and Rom by distances in frames,
    /// m_k = (v_{k+1} − v_{k−1}) / (f_{k+1} − f_{k−1}), and 0 at the first and the last key.
    Smooth,
    /// It stays until the next key.
    Step,
}

impl Interpolation {
    /// Every choice, in the order of the documentation.
    pub const ALL: [Self; 3] = [Self::Linear, Self::Smooth, Self::Step];

    /// The name in a scene file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Smooth => "smooth",
            Self::Step => "step",
        }
    }
}

/// A value between keys, v = v_base + Σ c (v_to − v_from): exactly that of a key where all are the same.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Blend {
    base: usize,
    ways: Vec<Way>,
}

/// A part of the way from one key's value to another's.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Way {
    share: f64,
    from: usize,
    to: usize,
}

impl Blend {
    /// Of keys at these frames, which ascend, at a frame: before the first and after the last key the value stays.
    pub(super) fn at(frame: f64, frames: &[f64], interpolation: Interpolation) -> Self {
        let after = frames.partition_point(|&key| key <= frame);
        let base = after.saturating_sub(1);
        let is_between = after > 0 && after < frames.len();
        if !is_between || frames[base] == frame || interpolation == Interpolation::Step {
            return Self {
                base,
                ways: Vec::new(),
            };
        }
        let length = frames[base + 1] - frames[base];
        let t = (frame - frames[base]) / length;
        let way = |share, from, to| Way { share, from, to };
        let mut ways = Vec::new();
        if interpolation == Interpolation::Linear {
            ways.push(way(t, base, base + 1));
        } else {
            ways.push(way(t * t * (3.0 - 2.0 * t), base, base + 1));
            // The slope at a key, by which a share of the distance is gone; none at the ends.
            let mut slope = |key: usize, share: f64| {
                if key > 0 && key + 1 < frames.len() {
                    let distance = frames[key + 1] - frames[key - 1];
                    ways.push(way(share * (length / distance), key - 1, key + 1));
                }
            };
            slope(base, t * (1.0 - t) * (1.0 - t));
            slope(base + 1, -t * t * (1.0 - t));
        }
        Self { base, ways }
    }

    fn of_numbers(&self, value: impl Fn(usize) -> f64) -> f64 {
        let way = |Way { share, from, to }: &Way| share * (value(*to) - value(*from));
        value(self.base) + self.ways.iter().map(way).sum::<f64>()
    }

    /// How much of each key's value there is; they add up to 1.
    fn weights(&self, count: usize) -> Vec<f64> {
        let mut weights = vec![0.0; count];
        weights[self.base] += 1.0;
        for Way { share, from, to } in &self.ways {
            weights[*to] += share;
            weights[*from] -= share;
        }
        weights
    }
}

/// What can be between keys.
pub(super) trait Blendable: Sized {
    /// What is between `values`, of which there is at least one.
    fn blended(values: &[Self], blend: &Blend) -> Self;
}

impl Blendable for f64 {
    fn blended(values: &[Self], blend: &Blend) -> Self {
        blend.of_numbers(|key| values[key])
    }
}

impl<T: Blendable + Copy, const N: usize> Blendable for [T; N] {
    fn blended(values: &[Self], blend: &Blend) -> Self {
        std::array::from_fn(|i| {
            let values: Vec<T> = values.iter().map(|value| value[i]).collect();
            T::blended(&values, blend)
        })
    }
}

/// Light and reflectances mix as such: numbers and RGB as linear RGB, a light's size as a number where its color
/// stays, everything else wavelength by wavelength.
impl Blendable for Value {
    fn blended(values: &[Self], blend: &Blend) -> Self {
        if let Some(numbers) = all(values, Self::uniform) {
            return Self::Uniform(f64::blended(&numbers, blend));
        }
        for space in ColorSpace::ALL {
            if let Some(triples) = all(values, |value| rgb(value, space)) {
                let rgb = <[f64; 3]>::blended(&triples, blend);
                return Self::Rgb { rgb, space };
            }
        }
        if let Some(sizes) = all(values, Self::sized_parts)
            && let [(unit, _, color), others @ ..] = sizes.as_slice()
            && others
                .iter()
                .all(|(other, _, like)| other == unit && like == color)
        {
            let amounts: Vec<f64> = sizes.iter().map(|(_, amount, _)| *amount).collect();
            return Self::sized(*unit, f64::blended(&amounts, blend), (*color).clone());
        }
        // All of them at every frame, also where there is nothing of one: whether light is carried spectrally must not
        // depend on the frame.
        let weights = blend.weights(values.len());
        Self::mixed(Mixture(
            weights.into_iter().zip(values.iter().cloned()).collect(),
        ))
    }
}

/// Linear RGB of a space, for what is written as such.
fn rgb(value: &Value, space: ColorSpace) -> Option<[f64; 3]> {
    let (rgb, own) = value.linear()?;
    // A gray is one in all spaces.
    (own == space || value.uniform().is_some()).then_some(rgb)
}

/// Of all values something, if each has it.
fn all<'v, T>(values: &'v [Value], of: impl Fn(&'v Value) -> Option<T>) -> Option<Vec<T>> {
    values.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAMES: [f64; 4] = [1.0, 5.0, 9.0, 21.0];
    const VALUES: [f64; 4] = [2.0, 4.0, 4.0, -8.0];

    fn at(frame: f64, interpolation: Interpolation) -> f64 {
        f64::blended(&VALUES, &Blend::at(frame, &FRAMES, interpolation))
    }

    #[test]
    fn keys_are_met_and_ends_stay() {
        for interpolation in Interpolation::ALL {
            for (frame, value) in FRAMES.into_iter().zip(VALUES) {
                assert_eq!(at(frame, interpolation), value);
            }
            assert_eq!(at(-100.0, interpolation), 2.0);
            assert_eq!(at(0.999, interpolation), 2.0);
            assert_eq!(at(21.5, interpolation), -8.0);
            let one = Blend::at(7.0, &[3.0], interpolation);
            assert_eq!(f64::blended(&[6.0], &one), 6.0);
        }
    }

    #[test]
    fn lines_and_steps() {
        assert_eq!(at(2.0, Interpolation::Linear), 2.5);
        assert_eq!(at(7.25, Interpolation::Linear), 4.0);
        assert_eq!(at(15.0, Interpolation::Linear), -2.0);
        assert_eq!(at(4.999, Interpolation::Step), 2.0);
        assert_eq!(at(20.999, Interpolation::Step), 4.0);
    }

    /// Against the Hermite basis as textbooks have it.
    #[test]
    fn smooth_is_hermite_with_slopes_of_catmull_and_rom() {
        let slopes = [0.0, (4.0 - 2.0) / 8.0, (-8.0 - 4.0) / 16.0, 0.0];
        for (k, frame) in [(0, 2.0), (0, 4.5), (1, 6.0), (1, 8.9), (2, 10.0), (2, 20.0)] {
            let h = FRAMES[k + 1] - FRAMES[k];
            let t: f64 = (frame - FRAMES[k]) / h;
            let (t2, t3) = (t * t, t * t * t);
            let expected = (2.0 * t3 - 3.0 * t2 + 1.0) * VALUES[k]
                + (t3 - 2.0 * t2 + t) * h * slopes[k]
                + (3.0 * t2 - 2.0 * t3) * VALUES[k + 1]
                + (t3 - t2) * h * slopes[k + 1];
            let actual = at(frame, Interpolation::Smooth);
            assert!(
                (actual - expected).abs() < 1e-14,
                "{frame}: {actual}, {expected}"
            );
        }
        // A slope of one key is that of both sides of it.
        let near = 1e-6;
        let before =
            (at(9.0, Interpolation::Smooth) - at(9.0 - near, Interpolation::Smooth)) / near;
        let after = (at(9.0 + near, Interpolation::Smooth) - at(9.0, Interpolation::Smooth)) / near;
        assert!((before - slopes[2]).abs() < 1e-5 && (after - slopes[2]).abs() < 1e-5);
    }

    #[test]
    fn what_is_the_same_at_all_keys_is_the_same_between() {
        for interpolation in Interpolation::ALL {
            for tenth in 0..230 {
                let blend = Blend::at(f64::from(tenth) / 10.0, &FRAMES, interpolation);
                assert_eq!(f64::blended(&[0.1; 4], &blend), 0.1);
            }
        }
    }

    #[test]
    fn colors_mix_as_linear_light() {
        let blend = Blend::at(2.0, &[1.0, 3.0], Interpolation::Linear);
        let mix = |a: Value, b: Value| Value::blended(&[a, b], &blend);
        assert_eq!(mix(2.0.into(), 4.0.into()), Value::Uniform(3.0));
        assert_eq!(
            mix([1.0, 0.0, 0.0].into(), 2.0.into()),
            [1.5, 1.0, 1.0].into()
        );
        // The codes 0 and 255 are 0 and 1 in linear light, and between them is half of it.
        assert_eq!(
            mix(Value::Srgb([0; 3]), Value::Srgb([255; 3])),
            [0.5; 3].into()
        );
        assert_eq!(
            mix(Value::lumens(100.0, 1.0), Value::lumens(300.0, 1.0)),
            Value::lumens(200.0, 1.0)
        );
        let (warm, cold) = (
            Value::candela(10.0, Value::Blackbody(2000.0)),
            Value::candela(10.0, Value::Blackbody(8000.0)),
        );
        let mixed = mix(warm.clone(), cold.clone());
        assert_eq!(mixed, Value::mixed(Mixture(vec![(0.5, warm), (0.5, cold)])));
    }
}
