//! From TOML to a [`Scene`](super::Scene).
