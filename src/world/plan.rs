//! "Model only what a scene needs": what will be computed, what is left out, and why.

use serde::Serialize;

use super::{Light, Mesh, World};
use crate::printable::counted;
use crate::scene;

/// Up to this many triangles are gone through one by one: a tree over fewer costs more than it saves.
pub const LONGEST_LIST: usize = 16;

/// So many spheres are: four blocks, of which most are soon told to be beside the rays.
const LONGEST_LIST_OF_SPHERES: usize = 64;

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

/// How light is carried along its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Transport {
    /// As one value per primary of the working space.
    Rgb,
    /// Wavelength by wavelength: products of lights and reflectances are integrated over 1 nm when they are
    /// first needed.
    Spectral,
}

/// What a render computes: just what the scene uses.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Plan {
    transport: Transport,
    lights: usize,
    /// How many of the lights are spots.
    #[serde(skip_serializing_if = "is_none")]
    spots: usize,
    /// How many are suns.
    #[serde(skip_serializing_if = "is_none")]
    suns: usize,
    /// How many have an area.
    #[serde(skip_serializing_if = "is_none")]
    areas: usize,
    planes: usize,
    #[serde(skip_serializing_if = "is_none")]
    disks: usize,
    spheres: Acceleration,
    triangles: Acceleration,
    specular: bool,
    interpolated_normals: bool,
    lifted_shadow_rays: bool,
}

/// Scenes without spots, suns or disks have the plan that they had before there were any.
fn is_none(count: &usize) -> bool {
    *count == 0
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
        let acceleration = |count: usize, longest_list: usize| match count {
            0 => Acceleration::None,
            _ if count <= longest_list => Acceleration::List,
            _ => Acceleration::Tree,
        };
        let meshes = world.triangles().meshes();
        let count = |is_one: fn(&Light) -> bool| {
            let lights = world.lights().iter();
            lights.filter(|light| is_one(&light.value)).count()
        };
        Self {
            transport: if world.spectra().is_some() {
                Transport::Spectral
            } else {
                Transport::Rgb
            },
            lights: world.lights().len(),
            spots: count(|light| matches!(light, Light::Spot(_))),
            suns: count(|light| matches!(light, Light::Sun(_))),
            areas: count(|light| matches!(light, Light::Area(_))),
            planes: world.planes().len(),
            disks: world.disks().len(),
            spheres: acceleration(world.spheres().len(), LONGEST_LIST_OF_SPHERES),
            triangles: acceleration(world.triangles().len(), LONGEST_LIST),
            specular: world
                .objects()
                .iter()
                .any(|object| world.materials()[object.material].value.is_specular()),
            interpolated_normals: meshes.iter().any(|mesh| mesh.normals.is_some()),
            lifted_shadow_rays: meshes.iter().any(Mesh::lifts_shadow_rays),
        }
    }

    /// How light is carried.
    pub fn transport(&self) -> Transport {
        self.transport
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

    /// Why RGB is or is not, and why spectra are or are not, what carries light.
    fn transport_reasons(&self, world: &World) -> [String; 2] {
        use scene::Transport::{Auto, Rgb, Spectral};
        let values = match world.spectral_values() {
            [] => "no value of the scene is a spectrum".to_owned(),
            [one] => format!("spectral: {one}"),
            [first, others @ ..] => format!("spectral: {first} and {} more", others.len()),
        };
        let says = |name| format!("asked for, `transport = \"{name}\"`");
        match (self.transport, world.transport_asked()) {
            (Transport::Rgb, Auto | Spectral) => {
                ["every value of the scene is RGB".to_owned(), values]
            }
            (Transport::Rgb, Rgb) => [says("rgb"), format!("left aside though {values}")]
                .map(|reason| reason.replace("left aside though no", "no")),
            (Transport::Spectral, Auto | Rgb) => [
                "products of three numbers: what they miss is said below".to_owned(),
                format!("{values}; integrated once, over 1 nm"),
            ],
            (Transport::Spectral, Spectral) => [
                "products of three numbers: what they miss is said below".to_owned(),
                format!("{}; integrated once, over 1 nm", says("spectral")),
            ],
        }
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
        let [rgb, spectral] = self.transport_reasons(world);
        let mut decisions = vec![
            decision("RGB transport", self.transport == Transport::Rgb, rgb),
            decision(
                "spectral transport",
                self.transport == Transport::Spectral,
                spectral,
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
                    lights => {
                        let mut reason = format!("{lights}, in the order of the file");
                        if self.spots > 0 {
                            let spots = counted(self.spots, "spot", "spots");
                            reason +=
                                &format!("; {spots}, asked of points inside of their cones alone");
                        }
                        if self.suns > 0 {
                            let suns = counted(self.suns, "sun", "suns");
                            reason += &format!("; {suns}, whose shadow rays are parallel");
                        }
                        if self.areas > 0 {
                            let areas = counted(self.areas, "light", "lights");
                            reason += &format!("; {areas} with an area, integrated over");
                        }
                        reason
                    }
                },
            ),
            yes_or_no(
                "shadows (L4)",
                self.lights > 0,
                if self.areas > 0 {
                    "one ray to every light above the surface; of lights with an area what hides them is cut away"
                } else {
                    "one ray to every light above the surface"
                },
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
            yes_or_no(
                "lifted shadow rays (L4)",
                self.lifted_shadow_rays,
                "a smooth mesh says `shadow_terminator = \"hanika\"`",
                "no smooth mesh says `shadow_terminator = \"hanika\"`",
            ),
        ];
        if self.disks > 0 {
            let reason = format!("{}, one by one", self.disks);
            decisions.push(decision("disks", true, reason));
        }
        decisions
    }
}
