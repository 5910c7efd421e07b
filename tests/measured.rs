//! Tolerances as tight as what is measured.

/// The rounding to f32: 2⁻²⁴, relative.
pub(crate) const HALF_LAST_BIT: f64 = 6e-8;

/// An error that was measured once, and what is found of it now. Twice as much is allowed; and if it is no
/// longer half as much, the figure is to be changed: beside it, and wherever a page states it.
#[derive(Debug)]
pub(crate) struct Measured {
    what: String,
    /// What was measured.
    figure: f64,
    /// Whether less than half of it is an objection.
    is_least: bool,
    worst: f64,
    place: String,
}

impl Measured {
    /// Room on both sides of a figure: for other scenes, and other mathematical libraries.
    pub(crate) const ROOM: f64 = 2.0;

    pub(crate) fn new(what: impl Into<String>, figure: f64) -> Self {
        Self {
            what: what.into(),
            figure,
            is_least: true,
            worst: 0.0,
            place: String::new(),
        }
    }

    /// What differs by nothing, or by little more: it may be on the other side of a rounding to f32.
    pub(crate) fn rounding(what: impl Into<String>) -> Self {
        Self {
            is_least: false,
            ..Self::new(what, HALF_LAST_BIT)
        }
    }

    /// One error, and where it is. One that is not a number is the worst there can be.
    pub(crate) fn see(&mut self, error: f64, place: impl FnOnce() -> String) {
        let error = if error.is_nan() { f64::INFINITY } else { error };
        if error > self.worst {
            self.worst = error;
            self.place = place();
        }
    }

    /// Why the figure is not what is found.
    fn objection(&self) -> Option<String> {
        let Self {
            what,
            figure,
            is_least,
            worst,
            place,
        } = self;
        if *worst > Self::ROOM * figure {
            Some(format!(
                "{what}: {worst:e} at {place}, measured once: {figure:e}"
            ))
        } else if *is_least && Self::ROOM * worst < *figure {
            Some(format!(
                "{what}: {worst:e} at {place} is all that is found; {figure:e} can be less"
            ))
        } else {
            None
        }
    }

    #[track_caller]
    pub(crate) fn judge(&self) {
        println!("{}: {:e} at {}", self.what, self.worst, self.place);
        let objection = self.objection();
        assert!(objection.is_none(), "{}", objection.unwrap_or_default());
    }
}

#[test]
fn figures_are_held_on_both_sides() {
    for (errors, is_right) in [
        (&[1e-7, 0.9e-7, 1.9e-7][..], true),
        (&[0.6e-7], true),
        (&[0.9e-7, 2.1e-7], false),
        (&[0.4e-7], false),
        (&[1e-7, f64::NAN], false),
        (&[], false),
    ] {
        let mut measured = Measured::new("errors", 1e-7);
        for (index, &error) in errors.iter().enumerate() {
            measured.see(error, || index.to_string());
        }
        assert_eq!(measured.objection().is_none(), is_right, "{errors:?}");
    }
    for (error, is_right) in [(0.0, true), (HALF_LAST_BIT, true), (1.3e-7, false)] {
        let mut measured = Measured::rounding("rounding");
        measured.see(error, String::new);
        assert_eq!(measured.objection().is_none(), is_right, "{error:e}");
    }
}
