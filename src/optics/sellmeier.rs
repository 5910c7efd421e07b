//! Refractive indices over the wavelength.

/// Coefficients of n² = 1 + Σ B λ²/(λ² − C), λ in µm, C in µm² (Sellmeier 1871).
///
/// Makers of glass publish three terms; the fourth is for what takes more, and zero else, which adds exactly nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sellmeier {
    /// B₁ to B₄.
    pub(crate) b: [f64; 4],
    /// C₁ to C₄, in µm².
    pub(crate) c: [f64; 4],
}

impl Sellmeier {
    /// Three terms.
    pub(crate) const fn three(b: [f64; 3], c: [f64; 3]) -> Self {
        Self {
            b: [b[0], b[1], b[2], 0.0],
            c: [c[0], c[1], c[2], 0.0],
        }
    }

    /// n at a wavelength above zero.
    ///
    /// It is a number, and at least 1, where a test says so of the visible range.
    pub(crate) fn index(&self, nm: f64) -> f64 {
        let square = wavelength_squared(nm);
        let mut sum = 1.0;
        for (b, c) in self.b.into_iter().zip(self.c) {
            sum += term(b, c, square);
        }
        sum.sqrt()
    }

    /// Whether n is a finite number, and at least 1, at every wavelength of a range: no resonance √C within, and
    /// 1 + Σ min(term at `from_nm`, term at `to_nm`) ≥ 1.
    ///
    /// Between resonances each term only grows, or only falls, so the sum is a bound; with B and C of the same sign, as
    /// makers publish them, all fall, and it is n² at `to_nm` itself. Anything but numbers holds nowhere.
    #[cfg(test)]
    pub(crate) fn holds(&self, from_nm: f64, to_nm: f64) -> bool {
        let [from, to] = [from_nm, to_nm].map(wavelength_squared);
        let in_order = 0.0 < from_nm && from_nm <= to_nm && to_nm.is_finite();
        let mut least = 0.0;
        for (b, c) in self.b.into_iter().zip(self.c) {
            let [at_from, at_to] = [from, to].map(|square| term(b, c, square));
            if !(c < from || c > to) || ![c, at_from, at_to].into_iter().all(f64::is_finite) {
                return false;
            }
            least += at_from.min(at_to);
        }
        in_order && least >= 0.0
    }
}

/// λ² in µm².
fn wavelength_squared(nm: f64) -> f64 {
    let micrometers = nm / 1000.0;
    micrometers * micrometers
}

/// B λ²/(λ² − C).
fn term(b: f64, c: f64, square: f64) -> f64 {
    b * square / (square - c)
}
