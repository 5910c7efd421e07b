//! Unfinished files: where they are, and what becomes of those whose run was killed.
//!
//! An unfinished file lies beside its target as `.candela-TARGET-HOST-PID-RANDOM.tmp`. The run that
//! writes it holds a lock on it, which the system releases however the run ends. The next run on the
//! same host to the same target removes what it can lock: nobody is left to finish it.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;

use tempfile::{Builder, NamedTempFile};

use super::folder_of;

/// How every unfinished file starts.
const PREFIX: &str = ".candela-";

/// How one ends that nobody can lock, so that nobody else can know whether its run is alive.
const UNLOCKED_SUFFIX: &str = ".unlocked.tmp";

/// Bytes of a target's or a host's name that the name of an unfinished file repeats: all together stay
/// below the 143 bytes that the narrowest file systems allow.
const REPEATED: usize = 32;

/// Creates the unfinished file of a target, and removes those of dead runs.
pub(super) fn create(target: &Path) -> io::Result<NamedTempFile> {
    let folder = folder_of(target);
    let name = label(target.file_name().unwrap_or_default().as_encoded_bytes());
    let start = format!("{PREFIX}{name}-{}-", label(&host()));
    let prefix = format!("{start}{}-", std::process::id());
    #[cfg(unix)]
    {
        locks::remove_dead(folder, &start);
        if let Some(locked) = locks::create(folder, &prefix)? {
            return Ok(locked);
        }
    }
    create_named(folder, &prefix, UNLOCKED_SUFFIX)
}

/// Creates a file as any other new one: the umask takes away from its permissions what it wants.
fn create_named(folder: &Path, prefix: &str, suffix: &str) -> io::Result<NamedTempFile<File>> {
    let mut new = OpenOptions::new();
    new.read(true).write(true).create_new(true);
    Builder::new()
        .prefix(prefix)
        .suffix(suffix)
        .make_in(folder, |path| new.open(path))
}

/// A name within the name of an unfinished file: itself where it is short and plain, else its start and
/// a few digits of its hash.
fn label(name: &[u8]) -> String {
    let plain = |&byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'_' | b'-');
    let is_whole = name.len() <= REPEATED && name.iter().all(plain);
    let shown = name.iter().take(REPEATED);
    let mut label: String = shown
        .map(|byte| if plain(byte) { char::from(*byte) } else { '_' })
        .collect();
    if !is_whole {
        use sha2::{Digest, Sha256};
        for byte in &Sha256::digest(name)[..4] {
            label.push_str(&format!("{byte:02x}"));
        }
    }
    label
}

/// The name of this machine, or of this container.
fn host() -> Vec<u8> {
    #[cfg(unix)]
    {
        rustix::system::uname().nodename().to_bytes().to_vec()
    }
    #[cfg(not(unix))]
    {
        Vec::new()
    }
}

/// Files that are locked while their run lives. Not on Windows, where a lock would keep others from reading
/// the file as well.
#[cfg(unix)]
mod locks {
    use std::fs::{self, File, OpenOptions, TryLockError};
    use std::io;
    use std::os::unix::fs::MetadataExt;
    use std::path::Path;

    use tempfile::NamedTempFile;

    use super::create_named;

    /// How an unfinished file ends.
    const SUFFIX: &str = ".tmp";

    /// How often a new name is tried where another run just looks at the file.
    const TRIES: usize = 16;

    /// Creates an unfinished file and locks it; `None` where the file system has no locks.
    pub(super) fn create(folder: &Path, prefix: &str) -> io::Result<Option<NamedTempFile>> {
        for _ in 0..TRIES {
            let temporary = create_named(folder, prefix, SUFFIX)?;
            match temporary.as_file().try_lock() {
                Ok(()) if is_at(temporary.as_file(), temporary.path()) => {
                    return Ok(Some(temporary));
                }
                // Another run was faster, and takes it for dead.
                Ok(()) | Err(TryLockError::WouldBlock) => {}
                Err(TryLockError::Error(_)) => break,
            }
        }
        Ok(None)
    }

    /// Removes the unfinished files whose names start so and whose run has ended. What cannot be
    /// looked at, locked or removed stays.
    pub(super) fn remove_dead(folder: &Path, start: &str) {
        let Ok(entries) = fs::read_dir(folder) else {
            return;
        };
        for entry in entries.flatten() {
            let name = entry.file_name();
            if name.to_str().is_some_and(|name| is_unfinished(name, start)) {
                remove_if_dead(&entry.path());
            }
        }
    }

    /// Whether a name goes on after `start` as `PID-RANDOM.tmp`.
    fn is_unfinished(name: &str, start: &str) -> bool {
        name.strip_prefix(start)
            .and_then(|rest| rest.strip_suffix(SUFFIX)?.split_once('-'))
            .is_some_and(|(pid, random)| {
                let is_number = !pid.is_empty() && pid.bytes().all(|byte| byte.is_ascii_digit());
                is_number && random.bytes().all(|byte| byte.is_ascii_alphanumeric())
            })
    }

    fn remove_if_dead(path: &Path) {
        let is_file = fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_file());
        if !is_file {
            return;
        }
        // A lock on a network file system needs a file that is open for writing.
        let Ok(file) = OpenOptions::new().read(true).write(true).open(path) else {
            return;
        };
        // A run that has just created the file, but not locked it, gives way to this lock.
        if file.try_lock().is_ok() && is_at(&file, path) {
            // Another run may have been faster.
            let _ = fs::remove_file(path);
        }
    }

    /// Whether an open file is what its name leads to: nobody has renamed or removed it.
    fn is_at(file: &File, path: &Path) -> bool {
        let (Ok(open), Ok(named)) = (file.metadata(), fs::symlink_metadata(path)) else {
            return false;
        };
        (open.dev(), open.ino()) == (named.dev(), named.ino())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_short_plain_and_of_one_name_each() {
        assert_eq!(label(b"a-b_c.exr"), "a-b_c.exr");
        let dash = label("Füll.exr".as_bytes());
        assert!(
            dash.starts_with("F__ll.exr") && dash.len() == 9 + 8,
            "{dash}"
        );
        assert_ne!(label(b"a b"), label(b"a_b"));
        let long = [b'a'; 255];
        assert_eq!(label(&long).len(), REPEATED + 8);
        assert_ne!(label(&long), label(&long[1..]));
    }
}
