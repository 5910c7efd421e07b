//! Unfinished files: where they are, and what becomes of those whose run was killed.
//!
//! An unfinished file lies beside its target as `.candela-TARGET-HOST-PID-RANDOM.tmp`. The run that
//! writes it holds a lock on it, which the system releases however the run ends. The next run on the
//! same host to the same target removes what it can lock: nobody is left to finish it.

use std::fs::Permissions;
use std::io;
use std::path::Path;

use tempfile::{Builder, NamedTempFile};

use super::target::folder_of;

/// How every unfinished file starts.
const PREFIX: &str = ".candela-";

/// And how it ends.
const SUFFIX: &str = ".tmp";

/// Where files cannot be locked, and nobody else can know whether the run is alive.
const UNLOCKED_SUFFIX: &str = ".unlocked.tmp";

/// Bytes of a target's or a host's name that the name of an unfinished file repeats: all together stay
/// below the 143 bytes that the narrowest file systems allow.
const REPEATED: usize = 32;

/// How often a new name is tried where another run just looks at the file.
const TRIES: usize = 16;

/// Creates the unfinished file of a target, and removes those of dead runs.
pub(super) fn create(target: &Path) -> io::Result<NamedTempFile> {
    let folder = folder_of(target);
    let name = target.file_name().unwrap_or_default();
    let start = format!(
        "{PREFIX}{}-{}-",
        label(name.as_encoded_bytes()),
        label(&host())
    );
    #[cfg(unix)]
    locks::remove_dead(folder, &start);
    let prefix = format!("{start}{}-", std::process::id());
    for _ in 0..TRIES {
        let temporary = builder(&prefix, SUFFIX).tempfile_in(folder)?;
        match lock(&temporary) {
            Lock::Held => return Ok(temporary),
            Lock::Lost => {}
            Lock::Impossible => break,
        }
    }
    builder(&prefix, UNLOCKED_SUFFIX).tempfile_in(folder)
}

fn builder<'a>(prefix: &'a str, suffix: &'a str) -> Builder<'a, 'a> {
    let mut builder = Builder::new();
    builder.prefix(prefix).suffix(suffix);
    #[cfg(unix)]
    {
        // As for any new file: the umask takes away from these what it wants.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(Permissions::from_mode(0o666));
    }
    builder
}

/// What came of the wish to lock a new file.
enum Lock {
    /// It is ours.
    Held,
    /// Another run was faster, and takes it for dead.
    Lost,
    /// This file system, or this system, has no locks.
    Impossible,
}

#[cfg(unix)]
fn lock(temporary: &NamedTempFile) -> Lock {
    use std::fs::TryLockError;
    match temporary.as_file().try_lock() {
        Ok(()) if locks::is_at(temporary.as_file(), temporary.path()) => Lock::Held,
        Ok(()) | Err(TryLockError::WouldBlock) => Lock::Lost,
        Err(TryLockError::Error(_)) => Lock::Impossible,
    }
}

/// Where a lock would keep others from reading the file as well.
#[cfg(not(unix))]
fn lock(_: &NamedTempFile) -> Lock {
    Lock::Impossible
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

#[cfg(unix)]
mod locks {
    use std::fs::{self, File, OpenOptions};
    use std::os::unix::fs::MetadataExt;
    use std::path::Path;

    use super::SUFFIX;

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
    pub(super) fn is_at(file: &File, path: &Path) -> bool {
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
