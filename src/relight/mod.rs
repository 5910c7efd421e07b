//! New light on a picture that was rendered: its layers of lights, multiplied and added up again.
//!
//! L9 is a sum over lights, L = Σ L_i, and each term is in proportion to its light's intensity. With factors f_i and
//! new colors
//!
//! L' = Σ f_i (I'_i / I_i) L_i
//!
//! in each of R, G and B, where light was carried as RGB. Where it was carried spectrally, the file has for each light
//! what 1 unit of light is reflected as: by reflectances that are the same at every wavelength (a_0), and by each
//! other reflectance ρ_j (a_j). Light of any spectrum s(λ) of 1 cd then has the share
//!
//! L_i = a_0 ∫ s(λ) m(λ) dλ + Σ_j a_j ∫ s(λ) ρ_j(λ) m(λ) dλ
//!
//! with m the color matching functions of the working space, K_m among them.

mod change;
mod color;
mod error;
mod lines;
mod plan;
mod record;
mod setting;
mod shares;

use std::io;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

pub use error::RelightError;
pub use setting::{Setting, SettingError};

use crate::exr::{
    self, COPIES_OF_BLOCK, ExrError, RewriteError, Rewritten, StoredExr, TILE_ATTRIBUTES,
};
use crate::memory;
use crate::output::{self, Unfinished};
use crate::turns::in_turn;
use change::changes;
use lines::{Counts, Lines, Residual, Room};
use plan::Plan;
use shares::{ChannelMap, Shares};

/// What was written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Width and height of the whole image.
    pub resolution: [u32; 2],
    /// Width and height of the part that the file has pixels of.
    pub size: [u32; 2],
    /// Values beyond the largest FLOAT, stored as that.
    pub clamped_to_float: u64,
    /// Values beyond ±65 504 in HALF, stored as that.
    pub clamped_to_half: u64,
    /// Values of layers in HALF that are not 0 but below the smallest normal one, 6.1e-5.
    pub small_in_half: u64,
    /// Values that change and were the largest of their type before: what they stand for is not known.
    pub were_clamped: u64,
    /// What was left out and why, a sentence each.
    pub notes: Vec<String>,
    /// The file's length in bytes.
    pub bytes: u64,
}

/// Makes a picture with other light of an EXR with layers `light_NAME`, whole or not at all. `-` is standard input and
/// standard output; both may be one file.
///
/// Types of channels, windows, compression and all other attributes stay as they are. `candela:lights` says what the
/// lights are now, `candela:relit` what was done.
///
/// ```no_run
/// use candela::output::Unfinished;
/// use candela::relight::{Setting, relight};
///
/// let settings = ["key=2,#ffd0a0", "fill=off"].map(str::parse::<Setting>);
/// let settings: Vec<Setting> = settings.into_iter().collect::<Result<_, _>>()?;
/// relight("a.exr".as_ref(), "b.exr".as_ref(), &settings, &Unfinished::new())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Where a file cannot be read or written, where there is no such light, and where what was asked for cannot be made
/// exactly of what is in the file; the output is then as it was.
pub fn relight(
    input: &Path,
    output: &Path,
    settings: &[Setting],
    unfinished: &Unfinished,
) -> Result<Report, RelightError> {
    let stored = StoredExr::open(input)?;
    let channels = ChannelMap::new(&stored);
    let mut shares = Shares::find(&stored, &channels)?;
    let changes = changes(&stored, &mut shares, settings)?;
    let plan = Plan::new(&stored, &channels, &shares, &changes);
    let lines = Lines::new(&stored, &plan);
    look_for_memory(&stored, &lines)?;
    if shares.record.is_none() {
        check_sum(&stored, &lines)?;
    }

    let asked = settings.iter().map(ToString::to_string).collect();
    let steps = record::steps(&stored, stored.hash()?.to_string(), asked)?;
    let lights = shares.record.iter();
    let lights = lights.map(|lights| (record::LIGHTS, record::text(lights)));
    let texts: Vec<(&str, String)> = lights.chain([(record::RELIT, steps)]).collect();
    // A tile in other light is none of the image that the others are of.
    let left_out = [&plan.left_out[..], &TILE_ATTRIBUTES].concat();
    let rewritten = Rewritten {
        kept: &plan.kept,
        texts: &texts,
        left_out: &left_out,
    };
    let mut unreadable = None;
    let written = output::write(output, unfinished, |sink| {
        let change = |room: &mut _, old: &[u8], new: &mut Vec<u8>| lines.change(room, old, new);
        let residual = |rooms: &[Room]| {
            let residuals = rooms.iter().map(|room| room.residual);
            Some(residuals.fold(0.0, f64::max))
        };
        let room = || lines.room();
        let written = exr::rewrite(&stored, &rewritten, sink, room, change, residual);
        written.map_err(|error| match error {
            RewriteError::Write(error) => error,
            RewriteError::Read(error) => {
                unreadable = Some(error);
                io::ErrorKind::InvalidData.into()
            }
        })
    });
    if let Some(error) = unreadable {
        return Err(error.into());
    }
    let (bytes, rooms) = written?;
    let mut counts = Counts::default();
    for room in rooms {
        counts.add(room.counts);
    }
    Ok(Report {
        resolution: stored.resolution(),
        size: stored.size(),
        clamped_to_float: counts.clamped_to_float,
        clamped_to_half: counts.clamped_to_half,
        small_in_half: counts.small_in_half,
        were_clamped: counts.were_clamped,
        notes: plan.notes,
        bytes,
    })
}

/// Whether there is memory for what threads have under way.
fn look_for_memory(stored: &StoredExr, lines: &Lines<'_>) -> Result<(), RelightError> {
    let block = stored.block_bytes().saturating_mul(COPIES_OF_BLOCK);
    let thread = block.saturating_add(lines.memory());
    let bytes = thread.saturating_mul(rayon::current_num_threads() as u64);
    memory::look_for(bytes)
        .map_err(|error| RelightError::Memory(error.for_what("the lines that are changed at once")))
}

/// Whether R, G and B are the sum of the layers of all lights but for rounding, where the file does not say what its
/// lights are.
fn check_sum(stored: &StoredExr, lines: &Lines<'_>) -> Result<(), RelightError> {
    let failed: Mutex<Option<ExrError>> = Mutex::new(None);
    let block = stored.lines_per_block() as usize;
    let found = in_turn(
        stored.blocks(),
        || (lines.room(), Residual::default()),
        |(room, worst), index| match stored.lines(index) {
            Ok(old) => {
                *worst = worst.larger(lines.residual(room, &old, index * block));
                ControlFlow::Continue(())
            }
            Err(error) => {
                let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                failed.get_or_insert(error);
                ControlFlow::Break(())
            }
        },
    );
    if let Some(error) = failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error.into());
    }
    let residuals = found.into_iter().map(|(_, worst)| worst);
    let worst = residuals.fold(Residual::default(), Residual::larger);
    if worst.size == 0.0 {
        return Ok(());
    }
    Err(RelightError::NoSum {
        channel: stored.names()[worst.channel].clone(),
        pixel: format!("{},{}", worst.column, worst.line),
        residual: worst.size,
    })
}
