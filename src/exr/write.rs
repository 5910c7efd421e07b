//! Writes a film as OpenEXR: one part, scan lines, channels R, G, B, A and those of its layers.
//!
//! The `exr` crate validates the header and serializes attributes. The file is put together here,
//! because the crate's own writer puts custom attributes in the order of a hash map, which differs from
//! run to run, and starts a thread pool of its own: here attributes are sorted by name, blocks are
//! compressed on the current `rayon` pool and written in order ([`ExrFile`]), so that one film makes
//! one file to the byte, and the film is never copied as a whole.

use std::io::{self, Seek, Write};
use std::ops::ControlFlow;
use std::path::Path;

use super::file::ExrFile;
use super::{ExrImage, ExrOptions, ExrReport, Preserve};
use crate::image::Film;
use crate::output::{self, OutputError, Unfinished};
use crate::turns::in_turn;

impl Film {
    /// Writes the film as an OpenEXR file with the default options, whole or not at all.
    ///
    /// # Errors
    /// As [`Film::write_exr`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<ExrReport, OutputError> {
        self.write_exr(path.as_ref(), &ExrOptions::default(), &Unfinished::new())
    }

    /// Writes the film as an OpenEXR file, whole or not at all.
    ///
    /// One film and one set of options make one file, to the byte, for any number of threads.
    ///
    /// # Errors
    /// If the file cannot be written, or the run is canceled; the target is then as it was.
    pub fn write_exr(
        &self,
        path: &Path,
        options: &ExrOptions,
        unfinished: &Unfinished,
    ) -> Result<ExrReport, OutputError> {
        output::write(path, unfinished, |mut sink| {
            self.write_exr_to(&mut sink, options)
        })
    }

    /// Writes the film as OpenEXR into `sink`, from the sink's start.
    ///
    /// # Errors
    /// What the sink reports; `InvalidInput` if the format cannot hold the film: where a
    /// provenance key is longer than 247 bytes or holds a zero, where two channels have one name,
    /// and where [`ExrOptions::check`] fails.
    pub fn write_exr_to(
        &self,
        sink: &mut (impl Write + Seek + Send),
        options: &ExrOptions,
    ) -> io::Result<ExrReport> {
        let (report, _) = self.write_exr_and_keep(sink, options, Preserve::Nothing)?;
        Ok(report)
    }

    /// The same, and what the file shows, as if it were read back, where that is asked for.
    pub(crate) fn write_exr_and_keep(
        &self,
        sink: &mut (impl Write + Seek + Send),
        options: &ExrOptions,
        preserve: Preserve,
    ) -> io::Result<(ExrReport, Option<ExrImage>)> {
        let file = ExrFile::begin(self.spec(), options, preserve, sink)?;
        let (blocks, lines) = (file.blocks(), file.lines_per_block());
        let height = self.window().height as usize;
        in_turn(
            blocks,
            || file.packer(),
            |packer, index| {
                let top = index * lines;
                let rows = self.rows(top..height.min(top + lines));
                file.add(index, rows, packer);
                if file.has_failed() {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            },
        );
        file.finish()
    }
}
