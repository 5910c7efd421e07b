//! "Model only what a scene needs": what will be computed, what is left out, and why.

use serde::Serialize;

use super::World;

/// Up to this many shapes of one kind are gone through one by one: a tree over fewer costs more
/// than it saves (measured on spheres: see the notes on speed in ARCHITECTURE.md).
pub const LONGEST_LIST: usize = 16;

/// How the shapes of one kind are searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Acceleration {
    /// There are none.
    None,
    /// One by one.
    List,
    /// Through a bounding volume hierarchy.
    Tree,
}

/// How light is represented along its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Transport {
    /// As one value per primary of the working space.
    Rgb,
}

/// What a render computes: just what the scene uses.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Plan {
    transport: Transport,
    lights: usize,
    planes: usize,
    spheres: Acceleration,
    triangles: Acceleration,
    specular: bool,
    interpolated_normals: bool,
}

/// One line of the plan as people read it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decision {
    /// What it is about.
    pub subject: &'static str,
    /// Whether it is computed.
    pub included: bool,
    /// How, or why not.
    pub reason: String,
}

impl Plan {
    /// The plan for a world.
    pub fn new(world: &World) -> Self {
        let acceleration = |count: usize| match count {
            0 => Acceleration::None,
            1..=LONGEST_LIST => Acceleration::List,
            _ => Acceleration::Tree,
        };
        let meshes = world.triangles().meshes();
        Self {
            transport: Transport::Rgb,
            lights: world.lights().len(),
            planes: world.planes().len(),
            spheres: acceleration(world.spheres().len()),
            triangles: acceleration(world.triangles().len()),
            specular: world
                .objects()
                .iter()
                .any(|object| world.materials()[object.material].value.is_specular()),
            interpolated_normals: meshes.iter().any(|mesh| mesh.normals.is_some()),
        }
    }

    /// How spheres are searched.
    pub fn spheres(&self) -> Acceleration {
        self.spheres
    }

    /// How triangles are searched.
    pub fn triangles(&self) -> Acceleration {
        self.triangles
    }

    /// Whether any object has a specular lobe; without one, L6 and L7 are not computed.
    pub fn specular(&self) -> bool {
        self.specular
    }

    /// The plan line by line, with reasons.
    pub fn decisions(&self, world: &World) -> Vec<Decision> {
        let decision = |subject, included, reason: String| Decision {
            subject,
            included,
            reason,
        };
        let search = |subject, acceleration, count: usize| match acceleration {
            Acceleration::None => decision(subject, false, "the scene has none".to_owned()),
            Acceleration::List => {
                let reason = format!("{count}, one by one: too few for a tree");
                decision(subject, true, reason)
            }
            Acceleration::Tree => {
                let reason = format!("{count}, through a tree of boxes, 8 to a node");
                decision(subject, true, reason)
            }
        };
        let yes_or_no = |subject, included, yes: &str, no: &str| {
            decision(
                subject,
                included,
                if included { yes } else { no }.to_owned(),
            )
        };
        vec![
            match self.transport {
                Transport::Rgb => decision(
                    "RGB transport",
                    true,
                    "every value of the scene is RGB".to_owned(),
                ),
            },
            decision(
                "spectral transport",
                false,
                "no value of the scene is a spectrum".to_owned(),
            ),
            yes_or_no("diffuse lobe (L5)", true, "always part of the sum", ""),
            yes_or_no(
                "specular lobe (L6, L7)",
                self.specular,
                "some material has specular > 0",
                "every material that is used has specular = 0",
            ),
            decision(
                "lights (L3)",
                self.lights > 0,
                match self.lights {
                    0 => "the scene has none: every surface is black".to_owned(),
                    count => format!("{count}, in the order of the file"),
                },
            ),
            yes_or_no(
                "shadows (L4)",
                self.lights > 0,
                "one ray to every light above the surface",
                "nothing casts light",
            ),
            search("spheres", self.spheres, world.spheres().len()),
            search("triangles", self.triangles, world.triangles().len()),
            decision(
                "planes",
                self.planes > 0,
                match self.planes {
                    0 => "the scene has none".to_owned(),
                    count => format!("{count}, one by one: a plane fits in no box"),
                },
            ),
            yes_or_no(
                "interpolated normals",
                self.interpolated_normals,
                "a smooth mesh has vertex normals",
                "no smooth mesh has vertex normals",
            ),
        ]
    }
}
