//! Output files appear whole or not at all.
//!
//! A file is written beside its target under a temporary name, flushed to the disk, and renamed:
//! whoever looks sees the old file or the new one, never a part. On any error, and when the run is
//! [canceled](Unfinished::cancel), the temporary file is removed and the target stays as it was.

mod early;

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, Cursor, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use early::EarlySync;

/// What a file's content is written to, by any thread.
pub trait Sink: Write + Seek + Send {}

impl<T: Write + Seek + Send> Sink for T {}

/// A file could not be written; the target is as it was before.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {problem}", path.display())]
pub struct OutputError {
    /// The target as the user named it.
    pub path: PathBuf,
    /// What failed, and the way out.
    pub problem: OutputProblem,
}

/// Why a file could not be written. Each message says the way out, where there is one.
#[derive(Debug, thiserror::Error)]
pub enum OutputProblem {
    /// The target's folder is not there.
    #[error("the folder {} does not exist; create it, or choose another place", .0.display())]
    MissingFolder(PathBuf),
    /// What should be the target's folder is something else.
    #[error("{} is not a folder; choose another place", .0.display())]
    NotAFolder(PathBuf),
    /// The target names a folder.
    #[error("it is a folder; add a file name")]
    IsFolder,
    /// The target names nothing.
    #[error("the file name is empty; give one")]
    NoName,
    /// The folder cannot be written to.
    #[error("the folder {} cannot be written to ({error}); choose another place", folder.display())]
    ClosedFolder {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        error: io::Error,
    },
    /// The file is there and must not be overwritten.
    #[error("the file is there and is write-protected ({0}); remove it, or choose another name")]
    Protected(io::Error),
    /// No space left, or the user's quota is used up.
    #[error("the disk is full ({0}); free some space, or choose another place")]
    Full(io::Error),
    /// Symbolic links that lead to each other.
    #[error("its symbolic links lead in a circle; choose another name")]
    LinkLoop,
    /// The run was interrupted before the file was whole.
    #[error("interrupted; nothing was left behind")]
    Canceled,
    /// Anything else that the system reports.
    #[error("{0}")]
    Io(io::Error),
}

/// The temporary files that one run has under way.
///
/// Clones share one list, so that a signal handler can hold one of them. Creation, renaming and
/// cancellation exclude each other: after [`Unfinished::cancel`] no temporary file is left and no
/// target changes any more.
///
/// ```
/// use candela::output::{self, Unfinished};
///
/// let unfinished = Unfinished::new();
/// let at_interrupt = unfinished.clone();
/// // What a signal handler does before it ends the process:
/// at_interrupt.cancel();
/// let late = output::write("late.exr".as_ref(), &unfinished, |_| Ok(()));
/// assert!(late.is_err());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Unfinished {
    shared: Arc<Mutex<State>>,
}

#[derive(Debug, Default)]
struct State {
    canceled: bool,
    files: BTreeSet<PathBuf>,
}

impl Unfinished {
    /// Nothing under way.
    pub fn new() -> Self {
        Self::default()
    }

    /// Removes what is under way, and lets nothing appear from now on: to be called when the run
    /// is interrupted. A file that was renamed before stays, whole.
    pub fn cancel(&self) {
        let mut state = self.lock();
        state.canceled = true;
        for file in std::mem::take(&mut state.files) {
            // Nobody is left to tell; the file may have gone with its folder.
            let _ = fs::remove_file(file);
        }
    }

    /// Whether [`Unfinished::cancel`] has been called.
    pub fn is_canceled(&self) -> bool {
        self.lock().canceled
    }

    /// A set of paths stays a set of paths, even if another thread panicked meanwhile.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Where the content goes.
enum Target {
    /// A file, new or to be replaced; symbolic links followed.
    File {
        path: PathBuf,
        existing: Option<Permissions>,
    },
    /// A device, a pipe or the like, which must not be replaced by a file.
    Stream,
}

/// Writes a file by `content`, whole or not at all.
///
/// A symbolic link is followed, what it points at is replaced. An existing file keeps its
/// permissions, a new one gets those that the umask leaves. Devices and pipes (`/dev/null`,
/// `/dev/stdout`) are written to as they are; since they cannot seek, the content is assembled in
/// memory first.
///
/// # Errors
/// Whatever the system or `content` reports; see [`OutputProblem`].
pub fn write<T>(
    path: &Path,
    unfinished: &Unfinished,
    content: impl FnOnce(&mut dyn Sink) -> io::Result<T>,
) -> Result<T, OutputError> {
    let written = match resolve(path) {
        Ok(Target::File {
            path: target,
            existing,
        }) => write_file(&target, existing, unfinished, content),
        Ok(Target::Stream) if unfinished.is_canceled() => Err(OutputProblem::Canceled),
        Ok(Target::Stream) => write_stream(path, content).map_err(classified),
        Err(problem) => Err(problem),
    };
    written.map_err(|problem| OutputError {
        path: path.to_path_buf(),
        problem,
    })
}

/// Finds out whether a file could be written, without leaving anything behind: for long work whose
/// result goes there.
///
/// # Errors
/// As [`write()`], as far as it can be known before.
pub fn check(path: &Path) -> Result<(), OutputError> {
    let checked = match resolve(path) {
        Ok(Target::File { path: target, .. }) => tempfile::tempfile_in(folder_of(&target))
            .map(drop)
            .map_err(|error| folder_problem(&target, error)),
        Ok(Target::Stream) => Ok(()),
        Err(problem) => Err(problem),
    };
    checked.map_err(|problem| OutputError {
        path: path.to_path_buf(),
        problem,
    })
}

/// As many symbolic links in a row as Linux follows.
const MAX_LINKS: usize = 40;

fn resolve(path: &Path) -> Result<Target, OutputProblem> {
    let text = path.as_os_str().as_encoded_bytes();
    let Some(&last) = text.last() else {
        return Err(OutputProblem::NoName);
    };
    if std::path::is_separator(char::from(last)) || path.file_name().is_none() {
        return Err(OutputProblem::IsFolder);
    }
    if let Ok(metadata) = fs::metadata(path) {
        if metadata.is_dir() {
            return Err(OutputProblem::IsFolder);
        }
        if !metadata.is_file() {
            return Ok(Target::Stream);
        }
    }

    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        match fs::symlink_metadata(&path) {
            // What /dev/stdout leads to is an open file, whatever the link's text says.
            Ok(metadata) if metadata.is_symlink() && path.starts_with("/proc") => {
                return Ok(Target::Stream);
            }
            Ok(metadata) if metadata.is_symlink() => {
                let link = fs::read_link(&path).map_err(OutputProblem::Io)?;
                path = folder_of(&path).join(link);
            }
            Ok(metadata) => {
                // A rename asks for the folder's permission alone; the file's own counts as well.
                OpenOptions::new()
                    .write(true)
                    .open(&path)
                    .map_err(OutputProblem::Protected)?;
                return Ok(Target::File {
                    path,
                    existing: Some(metadata.permissions()),
                });
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Ok(Target::File {
                    path,
                    existing: None,
                });
            }
            Err(error) => return Err(folder_problem(&path, error)),
        }
    }
    Err(OutputProblem::LinkLoop)
}

/// The folder that holds `path`.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn write_file<T>(
    target: &Path,
    existing: Option<Permissions>,
    unfinished: &Unfinished,
    content: impl FnOnce(&mut dyn Sink) -> io::Result<T>,
) -> Result<T, OutputProblem> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".candela-").suffix(".tmp");
    #[cfg(unix)]
    {
        // As for any new file: the umask takes away from these what it wants.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(Permissions::from_mode(0o666));
    }
    // Created and listed in one step, so that no interruption falls between.
    let temporary = {
        let mut state = unfinished.lock();
        if state.canceled {
            return Err(OutputProblem::Canceled);
        }
        let temporary = builder
            .tempfile_in(folder_of(target))
            .map_err(|error| folder_problem(target, error))?;
        state.files.insert(temporary.path().to_path_buf());
        temporary
    };
    let name = temporary.path().to_path_buf();

    let filled = fill(temporary.as_file(), existing, content);

    let mut state = unfinished.lock();
    state.files.remove(&name);
    if state.canceled {
        return Err(OutputProblem::Canceled);
    }
    // Dropping the temporary file on an error removes it.
    let result = filled.map_err(classified)?;
    temporary
        .persist(target)
        .map_err(|error| folder_problem(target, error.error))?;
    Ok(result)
}

/// Writes the content and waits until the disk has it: a full disk or a lost server must be known
/// before the old file goes.
fn fill<T>(
    file: &File,
    existing: Option<Permissions>,
    content: impl FnOnce(&mut dyn Sink) -> io::Result<T>,
) -> io::Result<T> {
    if let Some(permissions) = existing {
        file.set_permissions(permissions)?;
    }
    std::thread::scope(|scope| {
        let mut sink = EarlySync::new(file, scope);
        let result = content(&mut sink)?;
        sink.finish()?;
        Ok(result)
    })
}

fn write_stream<T>(
    path: &Path,
    content: impl FnOnce(&mut dyn Sink) -> io::Result<T>,
) -> io::Result<T> {
    let mut assembled = Cursor::new(Vec::new());
    let result = content(&mut assembled)?;
    // Appending, because /dev/stdout may be a file that others have written to before.
    let mut stream = OpenOptions::new().append(true).open(path)?;
    stream.write_all(assembled.get_ref())?;
    stream.flush()?;
    Ok(result)
}

/// What an error while a file is written means.
fn classified(error: io::Error) -> OutputProblem {
    match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => OutputProblem::Full(error),
        _ => OutputProblem::Io(error),
    }
}

/// What an error while a file is created or renamed means.
fn folder_problem(target: &Path, error: io::Error) -> OutputProblem {
    let folder = folder_of(target).to_path_buf();
    match error.kind() {
        io::ErrorKind::NotFound if !folder.exists() => OutputProblem::MissingFolder(folder),
        io::ErrorKind::NotADirectory => OutputProblem::NotAFolder(folder),
        io::ErrorKind::NotFound
        | io::ErrorKind::PermissionDenied
        | io::ErrorKind::ReadOnlyFilesystem => OutputProblem::ClosedFolder { folder, error },
        _ => classified(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn put(path: &Path, text: &str) -> Result<(), OutputError> {
        write(path, &Unfinished::new(), |sink| {
            sink.write_all(text.as_bytes())
        })
    }

    /// The names in a folder.
    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_appears_and_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        put(&path, "one").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "one");
        put(&path, "two").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "two");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn an_error_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        put(&path, "old").unwrap();
        let error = write(&path, &Unfinished::new(), |sink| -> io::Result<()> {
            sink.write_all(&[0; 100_000])?;
            assert_eq!(names(folder.path()).len(), 2);
            Err(io::ErrorKind::StorageFull.into())
        })
        .unwrap_err();
        assert!(matches!(error.problem, OutputProblem::Full(_)), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn an_interruption_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        put(&path, "old").unwrap();
        let unfinished = Unfinished::new();
        let handler = unfinished.clone();
        let error = write(&path, &unfinished, |sink| {
            sink.write_all(b"new")?;
            sink.flush()?;
            handler.cancel();
            assert_eq!(names(folder.path()), ["a.txt"]);
            Ok(())
        })
        .unwrap_err();
        assert!(matches!(error.problem, OutputProblem::Canceled), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["a.txt"]);

        let error = write(&path, &unfinished, |_| Ok(())).unwrap_err();
        assert!(matches!(error.problem, OutputProblem::Canceled), "{error}");
    }

    #[test]
    fn places_that_cannot_be_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        put(&file, "").unwrap();
        let problem = |path: &Path| put(path, "x").unwrap_err().problem;

        assert!(matches!(
            problem(&folder.path().join("none").join("a.txt")),
            OutputProblem::MissingFolder(missing) if missing.ends_with("none")
        ));
        assert!(matches!(
            problem(&file.join("a.txt")),
            OutputProblem::NotAFolder(not) if not.ends_with("file")
        ));
        assert!(matches!(problem(folder.path()), OutputProblem::IsFolder));
        assert!(matches!(
            problem(&folder.path().join("new/")),
            OutputProblem::IsFolder
        ));
        assert!(matches!(problem(Path::new("..")), OutputProblem::IsFolder));
        assert!(matches!(problem(Path::new("")), OutputProblem::NoName));
        assert_eq!(names(folder.path()), ["file"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_folder_that_nobody_can_write_to() {
        // /proc refuses new files to the superuser as well.
        let error = put(Path::new("/proc/a.txt"), "x").unwrap_err();
        assert!(
            matches!(&error.problem, OutputProblem::ClosedFolder { folder, .. } if folder == Path::new("/proc")),
            "{error}"
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_write_protected_file_stays() {
        // Kernel parameters such as this one are protected from the superuser as well.
        let error = put(Path::new("/proc/version"), "x").unwrap_err();
        assert!(
            matches!(
                error.problem,
                OutputProblem::Protected(_) | OutputProblem::ClosedFolder { .. }
            ),
            "{error}"
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn devices_are_written_to_and_stay_devices() {
        use std::os::unix::fs::FileTypeExt;
        put(Path::new("/dev/null"), "x").unwrap();
        let metadata = fs::symlink_metadata("/dev/null").unwrap();
        assert!(metadata.file_type().is_char_device());

        let error = put(Path::new("/dev/full"), "x").unwrap_err();
        assert!(matches!(error.problem, OutputProblem::Full(_)), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        symlink("sub/real.txt", at("second")).unwrap();
        symlink("second", at("first")).unwrap();
        // First where the last link dangles, then where its file is there.
        for text in ["one", "two"] {
            put(&at("first"), text).unwrap();
            assert_eq!(fs::read_to_string(at("sub/real.txt")).unwrap(), text);
            assert!(fs::symlink_metadata(at("first")).unwrap().is_symlink());
            assert!(fs::symlink_metadata(at("second")).unwrap().is_symlink());
        }

        symlink("circle", at("circle")).unwrap();
        let error = put(&at("circle"), "x").unwrap_err();
        assert!(matches!(error.problem, OutputProblem::LinkLoop), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_those_of_any_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o7777;
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        put(&ours, "x").unwrap();
        fs::write(&plain, "x").unwrap();
        assert_eq!(mode(&ours), mode(&plain));

        fs::set_permissions(&ours, Permissions::from_mode(0o640)).unwrap();
        put(&ours, "y").unwrap();
        assert_eq!(mode(&ours), 0o640);
    }
}
