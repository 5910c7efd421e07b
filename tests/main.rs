//! One binary for all integration tests.

mod bad_scenes;
mod display;
mod exr;
mod openimageio;
