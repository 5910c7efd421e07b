//! Whether a scene that moves is legal at further frames.

use candela::internal::counted;
use candela::scene::{Change, Motion, Scene};
use candela::world::World;

use super::Failure;

/// What becomes of frames in which triangles move: to place them takes its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Triangles {
    Placed,
    /// These frames are not looked at.
    Left,
}

/// Whether all these frames are legal; the errors of the first that is not, and how many are not. `world` is `scene`.
pub(super) fn check_frames(
    frames: &[f64],
    motion: &Motion,
    scene: &Scene,
    world: &World,
    triangles: Triangles,
) -> Result<(), Failure> {
    if motion.key_frames().is_empty() {
        return Ok(());
    }
    let scene = &mut scene.clone();
    let resolution = scene.image.resolution.value;
    let (mut first, mut count) = (None, 0);
    // Of a triangle: once it has moved, the world has it somewhere else.
    let mut has_moved = false;
    for &frame in frames {
        let change = motion.set(scene, frame)?;
        has_moved |= change.triangles;
        let change = Change {
            triangles: has_moved,
        };
        if has_moved && triangles == Triangles::Left {
            continue;
        }
        let made = if motion.moved().world {
            world.again(scene, change).map(|_| ())
        } else {
            let camera = world.place(&scene.camera.value, resolution);
            camera.map(|_| ())
        };
        if let Err(errors) = made {
            count += 1;
            first.get_or_insert(errors.at_frame(frame));
        }
    }
    let Some(errors) = first else {
        return Ok(());
    };
    if count == 1 {
        return Err(errors.into());
    }
    let errors = errors.to_string();
    let errors = errors.strip_prefix("error: ").unwrap_or(&errors);
    let all = counted(frames.len(), "frame", "frames");
    Err(format!("{errors}\n\n{count} of {all} are in error; this is the first").into())
}
