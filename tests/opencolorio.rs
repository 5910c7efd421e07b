//! OpenColorIO as the judge of views.

use crate::conformance::judge;

/// The script compares more than 100 000 colors in code value, and has a limit for each view.
#[test]
fn views_are_those_of_opencolorio() {
    judge("opencolorio", "reference/display/ocio.py");
}
