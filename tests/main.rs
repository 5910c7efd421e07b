//! One binary for all integration tests.

mod allocation;
mod fuzz_mesh;
mod fuzzing;
