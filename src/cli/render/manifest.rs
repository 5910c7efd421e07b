//! `--manifest`: what a run has read and written, for whoever keeps count of files.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};

use candela::render::Counts;
use candela::scene::Scene;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::Arguments;
use super::outputs::Outputs;
use super::statistics::Seconds;
use crate::cli::Failure;
use crate::cli::frames::Frame;

/// So many bytes are read at a time.
const PIECE: usize = 1 << 20;

/// What a run has read and written so far.
pub(super) struct Manifest {
    inputs: Vec<Value>,
    set: Vec<String>,
    frames: Vec<FrameFiles>,
    primary_rays: u64,
    shadow_rays: u64,
}

/// The files of a frame.
struct FrameFiles {
    frame: Option<Frame>,
    /// Each with whether it was written, rather than there already.
    files: Vec<(PathBuf, bool)>,
    /// None of a frame that was there already.
    seconds: Option<f64>,
}

impl Manifest {
    /// Where one is asked for.
    pub(super) fn new(arguments: &Arguments, scene: &Scene) -> Option<Self> {
        arguments.manifest.as_ref()?;
        let file =
            |path: &Path, hash: String| json!({"path": path.to_string_lossy(), "sha256": hash});
        let own = arguments
            .scene
            .iter()
            .map(|path| file(path, scene.hash().to_string()));
        let further = scene
            .inputs
            .iter()
            .map(|input| file(&input.path, input.hash.to_string()));
        Some(Self {
            inputs: own.chain(further).collect(),
            set: scene.source.set().map(str::to_owned).collect(),
            frames: Vec::new(),
            primary_rays: 0,
            shadow_rays: 0,
        })
    }

    /// Adds a frame, with what rendering it took; nothing where it was there already, but for its preview.
    pub(super) fn add(
        &mut self,
        frame: Option<Frame>,
        outputs: &Outputs,
        counts: Option<&Counts>,
        seconds: f64,
    ) {
        let is_rendered = counts.is_some();
        let files = [
            (Some(&outputs.exr), is_rendered),
            (outputs.bands.as_ref(), is_rendered),
            (outputs.preview.as_ref(), true),
        ];
        let there =
            |(path, is_written): (Option<&PathBuf>, bool)| Some((path?.clone(), is_written));
        self.frames.push(FrameFiles {
            frame,
            files: files.into_iter().filter_map(there).collect(),
            seconds: counts.map(|_| seconds),
        });
        if let Some(counts) = counts {
            self.primary_rays += counts.primary_rays;
            self.shadow_rays += counts.shadow_rays;
        }
    }

    /// After the last file has its name.
    pub(super) fn json(&self, seconds: &Seconds) -> Result<String, Failure> {
        let mut outputs = Vec::new();
        for FrameFiles {
            frame,
            files,
            seconds,
        } in &self.frames
        {
            let named = files.iter().filter(|(path, _)| path.as_os_str() != "-");
            for (path, is_written) in named {
                let (bytes, hash) = hashed(path)
                    .map_err(|error| format!("cannot read {} again: {error}", path.display()))?;
                outputs.push(json!({
                    "path": path.to_string_lossy(),
                    "bytes": bytes,
                    "sha256": hash,
                    "frame": frame.map(Frame::number),
                    "rendered": is_written,
                    "seconds": seconds,
                }));
            }
        }
        // The words of the call say all options.
        let arguments: Vec<String> = std::env::args_os()
            .skip(1)
            .map(|word| word.to_string_lossy().into_owned())
            .collect();
        Ok(serde_json::to_string_pretty(&json!({
            "software": concat!("candela ", env!("CARGO_PKG_VERSION")),
            "arguments": arguments,
            "set": self.set,
            "inputs": self.inputs,
            "outputs": outputs,
            "seconds": seconds,
            "primary_rays": self.primary_rays,
            "shadow_rays": self.shadow_rays,
        }))?)
    }
}

/// The length of a file, and its SHA-256 as `sha256sum` prints it.
fn hashed(path: &Path) -> io::Result<(u64, String)> {
    let (mut hash, mut bytes) = (Sha256::new(), 0);
    let mut file = BufReader::with_capacity(PIECE, File::open(path)?);
    loop {
        let piece = file.fill_buf()?;
        if piece.is_empty() {
            break;
        }
        hash.update(piece);
        let count = piece.len();
        bytes += count as u64;
        file.consume(count);
    }
    let digits = hash
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    Ok((bytes, digits))
}
