//! What the options of `render` are given: names of files, counts.

use std::path::PathBuf;

use candela::internal::printable_path;
use clap::builder::{OsStringValueParser, TypedValueParser};

/// A path whose extension is `extension`, so that a file never belies its name.
pub(crate) fn named(extension: &'static str) -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(move |path| {
        let path = PathBuf::from(path);
        match path.extension() {
            Some(found) if !found.eq_ignore_ascii_case(extension) => Err(format!(
                "this option writes {}; name the file {}",
                extension.to_uppercase(),
                printable_path(&path.with_extension(extension)),
            )),
            Some(_) | None => Ok(path),
        }
    })
}

/// A whole number from 1 to `most`.
pub(crate) fn count(text: &str, most: u32) -> Result<u32, String> {
    let number = text
        .parse()
        .ok()
        .filter(|number| (1..=most).contains(number));
    number.ok_or_else(|| format!("expected a whole number from 1 to {most}"))
}
