//! One file per command.

mod probe;
