//! What of a scene moves, and the scene at any frame.

use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

use toml::de::DeTable;

use super::super::diagnostic::{Diagnostic, Diagnostics, Spanned};
use super::super::{Anchor, Camera, Entry, Image, Light, Material, Object, Scene, Source};
use super::change::Changes;
use super::entries::Entries;
use super::fields::Reader;
pub use super::moving_entries::Moved;
use super::moving_entries::Moving;
use super::place::shift;
use super::sections;
use super::syntax::{self, Damage};

/// The frame of a scene that is looked at without saying which.
pub const FIRST_FRAME: f64 = 1.0;

/// What of a scene moves.
///
/// ```
/// use candela::World;
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("scene.toml");
/// # std::fs::write(&path, "\
/// # [image]\nresolution = [16, 9]\n\
/// # [camera.orthographic]\neye = [0, 0, 5]\nlook_at = [0, 0, 0]\nheight = 2\n\
/// # [materials.clay.phong]\ndiffuse = 0.5\n\
/// # [lights.key.point]\nposition = [0, 0, 5]\nintensity = { keys = [[1, 10], [11, 20]] }\n\
/// # [objects.ball.sphere]\nmaterial = \"clay\"\ncenter = [0, 0, 0]\nradius = 0.5\n")?;
/// // … with `intensity = { keys = [[1, 10], [11, 20]] }` for its light.
/// let mut loaded = World::load(&path)?;
/// assert_eq!(loaded.motion.frames(), Some([1.0, 11.0]));
/// loaded.motion.set(&mut loaded.scene, 6.5)?;
/// let (world, _) = World::new(&loaded.scene)?;
/// assert!((world.candelas(0) - 15.5).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Motion {
    source: Arc<Source>,
    moving: Moving,
}

/// What has changed from one frame of a scene to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// Triangles, of meshes and by themselves.
    pub triangles: bool,
}

impl Motion {
    pub(super) fn new(source: &Arc<Source>, moving: Moving) -> Self {
        Self {
            source: Arc::clone(source),
            moving,
        }
    }

    /// The first and the last frame that has a key; `None` where nothing moves.
    pub fn frames(&self) -> Option<[f64; 2]> {
        let frames = self.key_frames();
        Some([*frames.first()?, *frames.last()?])
    }

    /// The frames that have keys, each once, ascending.
    pub fn key_frames(&self) -> &[f64] {
        &self.moving.key_frames
    }

    /// What moves at all.
    pub fn moved(&self) -> Moved {
        self.moving.moved
    }

    /// The entries that move, as people name them: "the camera", "light `key`".
    pub fn names(&self) -> &[String] {
        &self.moving.names
    }

    /// Sets all that moves in the scene to what it is at a frame, which may have a fraction.
    ///
    /// # Errors
    /// If keys cannot be read; those of a scene that was read can.
    pub fn set(&self, scene: &mut Scene, frame: f64) -> Result<Change, Diagnostics> {
        if self.key_frames().is_empty() {
            return Ok(Change::default());
        }
        let at_frame = self.moving.at(frame, &self.source.text);
        let at_frame = match Diagnostics::new(Arc::clone(&self.source), at_frame.diagnostics) {
            Some(diagnostics) => return Err(diagnostics.at_frame(frame)),
            None => at_frame.entries,
        };
        if let Some(image) = at_frame.image {
            scene.image.background = image.background;
        }
        if let Some(camera) = at_frame.camera {
            scene.camera = camera;
        }
        replace(&mut scene.materials, at_frame.materials, |_, _| {});
        let mut change = Change::default();
        replace(&mut scene.lights, at_frame.lights, |before, now| {
            change.triangles |= !before.has_triangles_of(now);
        });
        replace(&mut scene.objects, at_frame.objects, |before, now| {
            change.triangles |= !before.has_triangles_of(now);
        });
        Ok(change)
    }
}

/// Puts entries in the place of those of their names.
fn replace<T>(entries: &mut [Entry<T>], moved: Vec<Entry<T>>, mut look: impl FnMut(&T, &T)) {
    let mut moved: HashMap<String, T> = moved
        .into_iter()
        .map(|entry| (entry.name, entry.value))
        .collect();
    for entry in entries {
        if moved.is_empty() {
            break;
        }
        if let Some(value) = moved.remove(&entry.name) {
            look(&entry.value, &value);
            entry.value = value;
        }
    }
}

/// What moves, at a frame.
struct AtFrame {
    entries: MovingEntries,
    diagnostics: Vec<Diagnostic>,
}

/// Of a scene, the entries that move.
struct MovingEntries {
    image: Option<Image>,
    camera: Option<Spanned<Camera>>,
    materials: Vec<Entry<Material>>,
    lights: Vec<Entry<Light>>,
    objects: Vec<Entry<Object>>,
}

impl Moving {
    /// All that moves at a frame; `source` is the scene's text.
    fn at(&self, frame: f64, source: &str) -> AtFrame {
        let (mut root, _, diagnostics) = syntax::parse(&self.text, 0);
        shift(&mut root, &|place| {
            self.places.get(&place).copied().unwrap_or(0)
        });
        let mut reader = Reader {
            text: source,
            damage: Damage::none(),
            diagnostics,
            files: self.files.clone(),
            changes: Rc::new(Changes::default()),
            frame,
            is_within_keys: false,
            key_frames: Vec::new(),
            moving: Self::nothing(),
        };
        let entries = reader.moving_entries(&root);
        AtFrame {
            entries,
            diagnostics: reader.diagnostics,
        }
    }

    /// Where a camera that moves is at first.
    pub(super) fn anchor(&self, source: &str) -> Option<Anchor> {
        if !self.moved.camera {
            return None;
        }
        let camera = self.at(f64::NEG_INFINITY, source).entries.camera?;
        let view = camera.value.view();
        Some(Anchor {
            eye: view.eye.value,
            look_at: view.look_at.value,
        })
    }
}

impl Reader<'_> {
    fn moving_entries(&mut self, root: &DeTable<'_>) -> MovingEntries {
        let mut image = None;
        if root.contains_key("image") {
            image = sections::image(self, root, &[]);
        }
        let mut camera = None;
        if root.contains_key("camera") {
            camera = sections::camera(self, root, &[]);
        }
        let (mut materials, mut lights, mut objects) =
            (Entries::default(), Entries::default(), Entries::default());
        let read = sections::MATERIALS
            .read(self, root, &mut materials)
            .and_then(|()| sections::LIGHTS.read(self, root, &mut lights))
            .and_then(|()| sections::OBJECTS.read(self, root, &mut objects));
        if let Err(error) = read {
            self.diagnostics.push(super::out_of_memory(error));
        }
        MovingEntries {
            image,
            camera,
            materials: materials.sound,
            lights: lights.sound,
            objects: objects.sound,
        }
    }
}
