//! One binary for all integration tests.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod accuracy;
mod allocation;
mod bad_scenes;
mod blessed;
mod cameras;
mod cli;
mod clients;
mod closed_form;
mod colorimetry;
mod conformance;
mod display;
mod energy;
mod examples;
mod exr;
mod extremes;
mod frames;
mod fuzz_mesh;
mod fuzz_scene;
mod fuzzing;
mod generate;
mod hard_cases;
mod honesty;
mod images;
mod invariance;
mod layering;
mod layers;
mod limits;
mod measured;
mod memory;
mod meshes;
mod opencolorio;
mod openimageio;
mod oracle;
mod package;
mod properties;
mod reading;
mod scenes_in_code;
mod schema;
mod spectral_image;
mod stated;
mod streaming;
mod terminator;
mod truths;
mod usage;
