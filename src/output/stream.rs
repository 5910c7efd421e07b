//! What is no file: devices, pipes, standard output. The content is assembled first, because it may go
//! back and forth in it, and because an error must not leave a part.

use std::fs::OpenOptions;
use std::io::{self, BufWriter, IsTerminal, Read, Seek, SeekFrom, Write};
use std::path::Path;

use tempfile::SpooledTempFile;

use super::Sink;
use super::error::{OutputProblem, classified, unassembled};

/// Up to so many bytes are assembled in memory; what is larger goes to a temporary file without a name.
const IN_MEMORY: usize = 16 << 20;

/// So many bytes at the start tell whether the content is text; all formats that are not have some
/// control character there.
const TELLING: u64 = 64;

/// Writes to the device or pipe at `path`.
pub(super) fn write<T>(
    path: &Path,
    content: impl FnOnce(&mut dyn Sink) -> io::Result<T>,
) -> Result<T, OutputProblem> {
    let (result, assembled) = assemble(content)?;
    // Appending, because it may be a file that others have written to before.
    let stream = OpenOptions::new().append(true).open(path);
    send(assembled, &mut stream.map_err(classified)?).map_err(classified)?;
    Ok(result)
}

/// Writes to standard output.
pub(super) fn write_standard<T>(
    content: impl FnOnce(&mut dyn Sink) -> io::Result<T>,
) -> Result<T, OutputProblem> {
    let (result, mut assembled) = assemble(content)?;
    if io::stdout().is_terminal() && !is_text(&mut assembled).map_err(unassembled)? {
        return Err(OutputProblem::Terminal);
    }
    send_standard(assembled).map_err(classified)?;
    Ok(result)
}

/// Past the standard library's buffer, which waits for ends of lines, and does not tell of an output
/// that cannot be written to.
#[cfg(unix)]
fn send_standard(assembled: SpooledTempFile) -> io::Result<()> {
    use std::os::fd::AsFd;
    let handle = io::stdout().as_fd().try_clone_to_owned()?;
    send(assembled, &mut std::fs::File::from(handle))
}

#[cfg(not(unix))]
fn send_standard(assembled: SpooledTempFile) -> io::Result<()> {
    send(assembled, &mut io::stdout().lock())
}

fn assemble<T>(
    content: impl FnOnce(&mut dyn Sink) -> io::Result<T>,
) -> Result<(T, SpooledTempFile), OutputProblem> {
    let mut sink = BufWriter::new(SpooledTempFile::new(IN_MEMORY));
    let result = content(&mut sink).map_err(unassembled)?;
    let assembled = sink
        .into_inner()
        .map_err(|error| unassembled(error.into_error()))?;
    Ok((result, assembled))
}

fn send(mut assembled: SpooledTempFile, stream: &mut impl Write) -> io::Result<()> {
    assembled.seek(SeekFrom::Start(0))?;
    io::copy(&mut assembled, stream)?;
    stream.flush()
}

fn is_text(assembled: &mut SpooledTempFile) -> io::Result<bool> {
    assembled.seek(SeekFrom::Start(0))?;
    let mut start = Vec::new();
    assembled.take(TELLING).read_to_end(&mut start)?;
    let is_binary = |&byte: &u8| byte.is_ascii_control() && !byte.is_ascii_whitespace();
    Ok(!start.iter().any(is_binary))
}
