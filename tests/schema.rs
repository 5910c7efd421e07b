//! The JSON schema of scenes: as it is checked in, and as Taplo judges scenes by it.

use std::fs;

use candela::scene::schema;

/// What `candela schema` prints, for whoever wants it without candela.
const FILE: &str = "schema/candela-scene.schema.json";

#[test]
fn the_file_is_what_the_reader_knows() {
    if std::env::var_os("BLESS").is_some() {
        fs::write(FILE, schema()).unwrap();
    }
    let is_same = fs::read_to_string(FILE).unwrap() == schema();
    assert!(is_same, "{FILE} is out of date (BLESS=1 writes it anew)");
}
