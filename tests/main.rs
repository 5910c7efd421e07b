//! One binary for all integration tests.

mod display;
mod exr;
mod openimageio;
