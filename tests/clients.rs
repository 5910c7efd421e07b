//! OpenImageIO, the OpenEXR project's Python package and a reader of Cryptomattes as judges of layers.

use crate::conformance::judge;

/// The script prints a line for each fact, and fails where one does not hold.
#[test]
fn layers_are_read_by_other_programs() {
    judge("clients", "reference/clients/readable.py");
}
