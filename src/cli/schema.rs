//! `candela schema`: the JSON schema of scenes.

use std::io::Write;

use super::Failure;

/// Print the JSON schema of scene files, by which editors check and complete them
///
/// Editors that know Taplo or Even Better TOML use it for a scene whose first line is
/// `#:schema ./candela.schema.json`.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Example:
  candela schema > candela.schema.json")]
pub(crate) struct Arguments {}

pub(crate) fn run(output: &mut impl Write) -> Result<(), Failure> {
    output.write_all(candela::scene::schema().as_bytes())?;
    Ok(())
}
