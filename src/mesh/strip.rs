//! Triangle strips: every corner from the third on makes a triangle with the two before it.

/// A strip as it is read.
#[derive(Debug, Default)]
pub(super) struct Strip {
    corners: u64,
    /// The last two corners, the last one second.
    last: [u32; 2],
}

impl Strip {
    /// The triangle that the next corner makes, counter-clockwise as the first of the strip is:
    /// every second one is turned. `None` at the first two corners, and where two of the three are the
    /// same vertex, by which strips are joined.
    #[inline]
    pub(super) fn corner(&mut self, vertex: u32) -> Option<[u32; 3]> {
        let [a, b] = self.last;
        let before = self.corners;
        self.last = [b, vertex];
        self.corners += 1;
        let has_area = before >= 2 && a != b && b != vertex && vertex != a;
        let triangle = if before.is_multiple_of(2) {
            [a, b, vertex]
        } else {
            [b, a, vertex]
        };
        has_area.then_some(triangle)
    }

    /// Ends the strip, and begins another; whether it had corners, but too few for a triangle.
    pub(super) fn end(&mut self) -> bool {
        matches!(std::mem::take(self).corners, 1..=2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_second_triangle_is_turned() {
        let mut strip = Strip::default();
        let triangles = |strip: &mut Strip, corners: &[u32]| -> Vec<[u32; 3]> {
            corners
                .iter()
                .filter_map(|&vertex| strip.corner(vertex))
                .collect()
        };
        assert_eq!(
            triangles(&mut strip, &[0, 1, 2, 3, 4]),
            [[0, 1, 2], [2, 1, 3], [2, 3, 4]]
        );
        assert!(!strip.end());
        // Joined by repeated corners, which keep the turns.
        assert_eq!(
            triangles(&mut strip, &[0, 1, 2, 2, 5, 5, 6, 7]),
            [[0, 1, 2], [6, 5, 7]]
        );
        strip.end();
        assert_eq!(triangles(&mut strip, &[8, 9]), [[0; 3]; 0]);
        assert!(strip.end());
        assert!(!strip.end());
    }
}
