//! One binary for all integration tests.

mod bad_scenes;
