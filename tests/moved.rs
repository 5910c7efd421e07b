//! Scenes elsewhere: moved, turned and scaled, and light that is stronger.

use std::sync::Arc;

use candela::scene::{Aim, AreaShape, Camera, Light, Mixture, Object, Scene, Spanned, Value};
use candela::spectrum::{Curve, Lines};

type Vector = [f64; 3];

/// The `up` of a light: what is not written is y, or −z along that, and turns with the rest.
fn written_up(position: Vector, aim: &Aim, up: Option<&Spanned<Vector>>) -> Vector {
    let way = match aim {
        Aim::LookAt(look_at) => [0, 1, 2].map(|i| look_at.value[i] - position[i]),
        Aim::Direction(direction) => direction.value,
    };
    let is_upright = way[0].hypot(way[2]) <= 1e-6 * way[1].abs();
    let default = if is_upright {
        [0.0, 0.0, -1.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    up.map_or(default, |up| up.value)
}

/// Changes the place of everything: positions by `place`, directions by `turn`, lengths by
/// `scale`. Meshes can be scaled and moved alone.
pub(crate) fn moved(
    scene: &Scene,
    scale: f64,
    place: impl Fn(Vector) -> Vector,
    turn: impl Fn(Vector) -> Vector,
) -> Scene {
    let mut scene = scene.clone();
    let put = |position: &mut Spanned<Vector>| position.value = place(position.value);
    let (Camera::Perspective { view, .. } | Camera::Orthographic { view, .. }) =
        &mut scene.camera.value;
    put(&mut view.eye);
    put(&mut view.look_at);
    view.up.value = turn(view.up.value);
    if let Camera::Orthographic { height, .. } = &mut scene.camera.value {
        height.value *= scale;
    }
    for light in &mut scene.lights {
        match &mut light.value {
            Light::Point { position, .. } => put(position),
            Light::Spot { position, aim, .. } => {
                put(position);
                match aim {
                    Aim::LookAt(look_at) => put(look_at),
                    Aim::Direction(direction) => direction.value = turn(direction.value),
                }
            }
            Light::Ies {
                position, aim, up, ..
            } => {
                *up = Some(Spanned {
                    value: turn(written_up(position.value, aim, up.as_ref())),
                    span: position.span,
                });
                put(position);
                match aim {
                    Aim::LookAt(look_at) => put(look_at),
                    Aim::Direction(direction) => direction.value = turn(direction.value),
                }
            }
            Light::Area { shape, .. } => {
                match shape {
                    AreaShape::Rectangle {
                        center,
                        aim,
                        up,
                        size,
                        ..
                    } => {
                        *up = Some(Spanned {
                            value: turn(written_up(center.value, aim, up.as_ref())),
                            span: center.span,
                        });
                        put(center);
                        size.value = size.value.map(|side| side * scale);
                        match aim {
                            Aim::LookAt(look_at) => put(look_at),
                            Aim::Direction(direction) => direction.value = turn(direction.value),
                        }
                    }
                    AreaShape::Disk {
                        center,
                        aim,
                        radius,
                        ..
                    } => {
                        put(center);
                        radius.value *= scale;
                        match aim {
                            Aim::LookAt(look_at) => put(look_at),
                            Aim::Direction(direction) => direction.value = turn(direction.value),
                        }
                    }
                    AreaShape::Sphere { center, radius } => {
                        put(center);
                        radius.value *= scale;
                    }
                }
                // Its luminance is the same at any scale.
                continue;
            }
            Light::Sun { direction, .. } => {
                direction.value = turn(direction.value);
                // It is as strong at any distance.
                continue;
            }
        }
        let intensity = light.value.size_mut();
        intensity.value = times(&intensity.value, scale * scale);
    }
    for object in &mut scene.objects {
        match &mut object.value {
            Object::Sphere { center, radius, .. } => {
                put(center);
                radius.value *= scale;
            }
            Object::Plane { point, normal, .. } => {
                put(point);
                normal.value = turn(normal.value);
            }
            Object::Triangle { vertices, .. } => {
                vertices.value = vertices.value.map(&place);
            }
            Object::Mesh {
                scale: factors,
                translate,
                ..
            } => {
                factors.value = factors.value.map(|factor| factor * scale);
                put(translate);
            }
        }
    }
    scene
}

/// A value times a factor; codes of sRGB become what they stand for.
pub(crate) fn times(value: &Value, factor: f64) -> Value {
    match value {
        Value::Uniform(value) => Value::Uniform(value * factor),
        Value::Rgb { rgb, space } => Value::Rgb {
            rgb: rgb.map(|channel| channel * factor),
            space: *space,
        },
        Value::Srgb(codes) => Value::Rgb {
            rgb: codes.map(|code| candela::internal::srgb_decode(f64::from(code) / 255.0) * factor),
            space: candela::scene::ColorSpace::Rec709,
        },
        Value::Curve(curve) => {
            let values = curve.values().iter().map(|value| value * factor).collect();
            let curve = Curve::new(curve.wavelengths().to_vec(), values);
            Value::Curve(Arc::new(curve.unwrap()))
        }
        Value::Lines(lines) => {
            let lines = lines
                .lines()
                .iter()
                .map(|[nm, power]| [*nm, power * factor]);
            Value::Lines(Arc::new(Lines::new(lines.collect()).unwrap()))
        }
        Value::Sized {
            unit,
            amount,
            color,
        } => Value::Sized {
            unit: *unit,
            amount: amount * factor,
            color: color.clone(),
        },
        Value::Mixed(mixture) => {
            let parts = mixture.0.iter();
            let parts = parts.map(|(weight, part)| (*weight, times(part, factor)));
            Value::mixed(Mixture(parts.collect()))
        }
        Value::Illuminant(_) | Value::Daylight(_) | Value::Blackbody(_) => {
            panic!("a color without a size is no light")
        }
    }
}
