//! Where an output goes: which file a name leads to, and whether two names lead to one place.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io;
use std::path::{Path, PathBuf};

use super::error::{OutputProblem, folder_problem, protection_problem};
use super::{STANDARD_STREAM, folder_of};

/// Other names of standard output.
const STANDARD_OUTPUT: [&str; 3] = ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];

/// As many symbolic links in a row as Linux follows.
const MAX_LINKS: usize = 40;

/// Where the content goes.
pub(super) enum Target {
    /// A file, new or to be replaced; symbolic links followed.
    File {
        path: PathBuf,
        existing: Option<Permissions>,
    },
    /// A device, a pipe or the like, which must not be replaced by a file.
    Stream,
    /// What the process was given as standard output.
    StandardOutput,
}

/// Finds what a name leads to, and whether it could be written there.
pub(super) fn resolve(path: &Path) -> Result<Target, OutputProblem> {
    if is_standard_output(path) {
        return Ok(Target::StandardOutput);
    }
    if path.as_os_str().is_empty() {
        return Err(OutputProblem::NoName);
    }
    if names_a_folder(path) {
        return Err(OutputProblem::IsFolder);
    }
    if let Ok(metadata) = fs::metadata(path) {
        if metadata.is_dir() {
            return Err(OutputProblem::IsFolder);
        }
        if !metadata.is_file() {
            return stream(path, &metadata);
        }
    }
    let Some(path) = follow(path)? else {
        return Ok(Target::Stream);
    };
    if names_a_folder(&path) {
        return Err(OutputProblem::IsFolder);
    }
    match fs::symlink_metadata(&path) {
        Ok(metadata) => {
            // A rename asks for the folder's permission alone; the file's own counts as well.
            OpenOptions::new()
                .write(true)
                .open(&path)
                .map_err(|error| protection_problem(&path, error))?;
            Ok(Target::File {
                path,
                existing: Some(metadata.permissions()),
            })
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Target::File {
            path,
            existing: None,
        }),
        Err(error) => Err(folder_problem(&path, error)),
    }
}

/// Whether a name is that of standard output.
pub(super) fn is_standard_output(path: &Path) -> bool {
    path.as_os_str() == STANDARD_STREAM
        || STANDARD_OUTPUT.iter().any(|name| path == Path::new(name))
}

/// Whether only a folder can have this name: `a/`, `a/.`, `..`
fn names_a_folder(path: &Path) -> bool {
    let is_separator = |&byte: &u8| std::path::is_separator(char::from(byte));
    let text = path.as_os_str().as_encoded_bytes();
    // The standard library takes the name of `a/.` for `a`.
    let last = text.rsplit(is_separator).next();
    matches!(last, Some(b"" | b"." | b"..")) || path.file_name().is_none()
}

/// What is neither a file nor a folder: a stream, if it can be one.
fn stream(path: &Path, metadata: &Metadata) -> Result<Target, OutputProblem> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;

        use super::error::classified;
        let kind = metadata.file_type();
        if kind.is_socket() {
            return Err(OutputProblem::NotAFile("a socket"));
        }
        if kind.is_block_device() {
            return Err(OutputProblem::NotAFile("a disk (a block device)"));
        }
        // To open it would wait for the reader of a pipe, or set a device going.
        rustix::fs::access(path, rustix::fs::Access::WRITE_OK)
            .map_err(|error| classified(error.into()))?;
    }
    #[cfg(not(unix))]
    let _ = (path, metadata);
    Ok(Target::Stream)
}

/// The path at the end of all symbolic links, whether something is there or not. `None` for a link of
/// `/proc`, whose text does not say where it leads: to an open file.
fn follow(path: &Path) -> Result<Option<PathBuf>, OutputProblem> {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        match fs::symlink_metadata(&path) {
            Ok(metadata) if metadata.is_symlink() => {
                let folder = folder_of(&path);
                let real = folder.canonicalize().map_err(OutputProblem::Io)?;
                if real.starts_with("/proc") {
                    return Ok(None);
                }
                let link = fs::read_link(&path).map_err(OutputProblem::Io)?;
                path = folder.join(link);
            }
            Ok(_) => return Ok(Some(path)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Some(path)),
            Err(error) => return Err(folder_problem(&path, error)),
        }
    }
    Err(OutputProblem::LinkLoop)
}

/// Where an input is, or where an output is or would be, whatever name and links lead there.
///
/// Two places are compared by what the file system makes of their names: `./a` and `a`, names through
/// links of files and folders, hard links, and names that differ by case where it does not tell them
/// apart, are the same place.
///
/// ```
/// use candela::output::Place;
///
/// let folder = tempfile::tempdir()?;
/// let place = |name: &str| Place::of_output(&folder.path().join(name));
/// assert!(place("a.exr").is(&place("./a.exr")));
/// assert!(!place("a.exr").is(&place("b.exr")));
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct Place {
    /// The standard output.
    is_standard_output: bool,
    /// What is there; `None` for nothing, and for what may be written to more than once.
    file: Option<Identity>,
    /// Where nothing is: its folder, with the folder's path, and its name there.
    vacant: Option<(Identity, PathBuf, OsString)>,
}

/// What tells one file from all others.
#[cfg(unix)]
type Identity = (u64, u64);
#[cfg(not(unix))]
type Identity = PathBuf;

impl Place {
    /// Of a file that is read; `-` is standard input. Only a regular file can be lost by writing to
    /// the same place.
    pub fn of_input(path: &Path) -> Self {
        let (metadata, path) = if path.as_os_str() == STANDARD_STREAM {
            (standard_input(), None)
        } else {
            (fs::metadata(path).ok(), Some(path))
        };
        let metadata = metadata.filter(Metadata::is_file);
        Self {
            is_standard_output: false,
            file: metadata.and_then(|metadata| identity(&metadata, path)),
            vacant: None,
        }
    }

    /// Of a file that is to be written; `-` is standard output.
    pub fn of_output(path: &Path) -> Self {
        let is_standard_output = is_standard_output(path);
        let (metadata, path) = if is_standard_output {
            (standard_output(), None)
        } else {
            (fs::metadata(path).ok(), Some(path))
        };
        let is_vacant = metadata.is_none();
        let metadata = metadata.filter(|metadata| !may_be_shared(metadata));
        Self {
            is_standard_output,
            file: metadata.and_then(|metadata| identity(&metadata, path)),
            vacant: path.filter(|_| is_vacant).and_then(vacant),
        }
    }

    /// Whether it is standard output, by whatever name.
    pub fn is_standard_output(&self) -> bool {
        self.is_standard_output
    }

    /// Whether what is written to one of two places would be in the place of the other.
    pub fn is(&self, other: &Self) -> bool {
        if self.is_standard_output && other.is_standard_output {
            return true;
        }
        if let (Some(file), Some(other)) = (&self.file, &other.file) {
            return file == other;
        }
        let (Some((folder, path, name)), Some((other_folder, _, other_name))) =
            (&self.vacant, &other.vacant)
        else {
            return false;
        };
        folder == other_folder && (name == other_name || is_one_name(path, name, other_name))
    }
}

/// The place of a file that is not there.
fn vacant(path: &Path) -> Option<(Identity, PathBuf, OsString)> {
    let path = follow(path).ok()??;
    let folder = folder_of(&path).to_path_buf();
    let metadata = fs::metadata(&folder).ok()?;
    let name = path.file_name()?.to_owned();
    Some((identity(&metadata, Some(&folder))?, folder, name))
}

/// Whether two outputs may go there, as to `/dev/null`.
fn may_be_shared(metadata: &Metadata) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        metadata.file_type().is_char_device()
    }
    #[cfg(not(unix))]
    {
        !metadata.is_file()
    }
}

#[cfg(unix)]
fn identity(metadata: &Metadata, _: Option<&Path>) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    Some((metadata.dev(), metadata.ino()))
}

#[cfg(not(unix))]
fn identity(_: &Metadata, path: Option<&Path>) -> Option<Identity> {
    path?.canonicalize().ok()
}

/// What standard input is.
fn standard_input() -> Option<Metadata> {
    #[cfg(unix)]
    {
        use std::os::fd::AsFd;
        let handle = io::stdin().as_fd().try_clone_to_owned().ok()?;
        File::from(handle).metadata().ok()
    }
    #[cfg(not(unix))]
    None
}

/// What standard output is.
fn standard_output() -> Option<Metadata> {
    #[cfg(unix)]
    {
        use std::os::fd::AsFd;
        let handle = io::stdout().as_fd().try_clone_to_owned().ok()?;
        File::from(handle).metadata().ok()
    }
    #[cfg(not(unix))]
    None
}

/// Whether a folder takes two different names for one, as file systems do that do not tell case or
/// forms of accents apart. Only the file system knows: it is asked, where names are alike enough.
fn is_one_name(folder: &Path, one: &OsStr, other: &OsStr) -> bool {
    let folded = |name: &OsStr| {
        let name = name.to_string_lossy().to_lowercase();
        let plain = name.chars().filter(char::is_ascii);
        plain
            .collect::<String>()
            .trim_end_matches(['.', ' '])
            .to_owned()
    };
    if folded(one) != folded(other) {
        return false;
    }
    let trial = tempfile::Builder::new()
        .prefix(".candela-")
        .suffix(".tmp")
        .tempdir_in(folder);
    trial.is_ok_and(|trial| {
        File::create(trial.path().join(one)).is_ok()
            && fs::symlink_metadata(trial.path().join(other)).is_ok()
    })
}
