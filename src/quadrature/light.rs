//! L5 to L8 over a square of the image: what a light does where rays meet a surface, as models.

use super::area::{self, Past, Slopes};
use super::model::Model;
use super::surface::Surface;
use crate::math::DVec3;
use crate::world::light::Falloff;
use crate::world::material::Model as Reflection;
use crate::world::{Light, Lobes, Material, SpotLight};

/// The cosine terms of L5 and L7 over d² of the lobes, in m⁻², of a spot times f(θ), of a sun over 1 m²: where the
/// light, at `origin`, is above.
pub(super) fn geometry(
    surface: &Surface,
    light: &Light,
    origin: DVec3,
    material: &Material,
    slopes: Slopes,
    past: Option<Past<'_>>,
) -> Lobes<Model> {
    if let Light::Area(light) = light {
        return area::geometry(surface, light, material, slopes, past);
    }
    let to_light = -surface.position.minus(origin);
    let square = to_light.dot(to_light);
    let inverse = square.root().reciprocal();
    let inverse_square = square.reciprocal();
    let received = match light {
        Light::Point(_) => inverse_square,
        // A table is smooth only between its angles. What an area sends is told above.
        Light::Ies(_) | Light::Area(_) => Model::UNKNOWN,
        Light::Sun(_) => Model::constant(1.0),
        Light::Spot(spot) => {
            inverse_square * falloff(spot, to_light.along(spot.axis.get()), inverse)
        }
    };
    let height = surface.shading_height(origin);
    let cos_incident = height * inverse;
    let cos_incident = if surface.is_smooth() {
        // An interpolated normal may turn away from a light that is above.
        cos_incident.power(1.0)
    } else {
        cos_incident
    };
    let diffuse = cos_incident * received;
    if !material.is_specular() {
        return Lobes {
            diffuse,
            specular: Model::constant(0.0),
        };
    }
    // L6: ω_o·ω_r = 2 (n·ω_i) (n·ω_o) − ω_i·ω_o
    let along = (height * surface.cos_viewer).times(2.0) - to_light.dot(surface.to_viewer);
    let lobe = (along * inverse).power(material.shininess());
    let lobe = match material.model() {
        Reflection::Phong => lobe,
        Reflection::NormalizedPhong => lobe * cos_incident,
    };
    Lobes {
        diffuse,
        specular: lobe * received,
    }
}

/// f(θ), from the way to the light along the axis and one over its length. In the penumbra of a curve whose slope
/// jumps nothing is known.
fn falloff(spot: &SpotLight, along: Model, inverse: Model) -> Model {
    let cone = &spot.cone;
    let cos = -(along * inverse);
    // x from 1 at the inner to 0 at the outer angle, linear in cos θ.
    let x = cos.plus(cone.versine_outer - 1.0).times(cone.inverse_span);
    if !x.is_known() {
        return Model::UNKNOWN;
    }
    if x.most() <= 0.0 {
        return Model::constant(0.0);
    }
    if x.least() >= 1.0 {
        return Model::constant(1.0);
    }
    match cone.falloff() {
        // x²(3 − 2x), constant beyond both ends: |f′| ≤ 3/2, |f″| ≤ 6.
        Falloff::Smooth => x.bounded(
            |x| {
                let x = x.clamp(0.0, 1.0);
                [x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x)]
            },
            1.5,
            6.0,
        ),
        // x², constant below 0; at 1 its slope jumps.
        Falloff::Gltf if x.most() <= 1.0 => x.power(2.0),
        Falloff::Gltf | Falloff::LinearAngle => Model::UNKNOWN,
    }
}
