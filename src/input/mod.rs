//! Files that a scene names, as they are read: opened only where they are files, hashed on the way, and
//! told where they hold the right text in a form that is not read.

mod encoding;
mod hash;
mod opening;

pub use encoding::Foreign;
pub use hash::Hash;
pub(crate) use hash::Hashed;
pub use opening::NotAFile;
pub(crate) use opening::{is_transient, open};
