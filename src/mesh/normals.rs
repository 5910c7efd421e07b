//! Vertex normals that a file leaves without a direction.

use std::collections::TryReserveError;

use super::{cross, difference};

/// The normal of a vertex or triangle that is never seen, since it has no area or nothing uses
/// it: any direction would do.
pub(super) const UNSEEN: [f64; 3] = [0.0, 0.0, 1.0];

/// Whether `vector` has a direction: it is finite and not zero.
#[inline]
pub(super) fn has_direction(vector: [f64; 3]) -> bool {
    vector.iter().all(|x| x.is_finite()) && vector != [0.0; 3]
}

/// The geometric normal of a triangle, counter-clockwise seen from its tip, of unit length;
/// `None` for a triangle without area.
pub(super) fn of_triangle(corners: [[f64; 3]; 3]) -> Option<[f64; 3]> {
    // Quartered, no difference overflows; scaled by the largest, no product does.
    let [a, b, c] = corners.map(|corner| corner.map(|x| x * 0.25));
    let [u, v] = [unit(difference(b, a))?, unit(difference(c, a))?];
    unit(cross(u, v))
}

/// `vector` at unit length, or `None` where it has no direction.
fn unit(vector: [f64; 3]) -> Option<[f64; 3]> {
    has_direction(vector).then(|| {
        let largest = vector.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let scaled = vector.map(|x| x / largest);
        let length = scaled.iter().map(|x| x * x).sum::<f64>().sqrt();
        scaled.map(|x| x / length)
    })
}

/// Replaces normals without a direction by the mean of the geometric normals of the triangles
/// around their vertices; how many of these are seen.
///
/// Exporters write zero or NaN where they could not normalize, at vertices whose faces have no
/// area or cancel out. Where the mean of opposite faces is zero, the first of them counts.
pub(super) fn mend(
    normals: &mut [[f64; 3]],
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
) -> Result<u32, TryReserveError> {
    if normals.iter().all(|&normal| has_direction(normal)) {
        return Ok(0);
    }
    let mut without = Vec::new();
    without.try_reserve_exact(normals.len())?;
    without.extend(normals.iter().map(|&normal| !has_direction(normal)));
    for (normal, _) in normals
        .iter_mut()
        .zip(&without)
        .filter(|(_, without)| **without)
    {
        *normal = [0.0; 3];
    }
    for &triangle in triangles {
        let [a, b, c] = triangle.map(|i| i as usize);
        if !(without[a] || without[b] || without[c]) {
            continue;
        }
        let Some(face) = of_triangle([positions[a], positions[b], positions[c]]) else {
            continue;
        };
        for corner in [a, b, c].into_iter().filter(|&corner| without[corner]) {
            let sum = [0, 1, 2].map(|i| normals[corner][i] + face[i]);
            if has_direction(sum) {
                normals[corner] = sum;
            }
        }
    }
    let mut seen = 0;
    for (normal, _) in normals
        .iter_mut()
        .zip(&without)
        .filter(|(_, without)| **without)
    {
        match unit(*normal) {
            Some(mean) => {
                *normal = mean;
                seen += 1;
            }
            None => *normal = UNSEEN,
        }
    }
    Ok(seen)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

    #[test]
    fn normals_with_a_direction_stay_as_written() {
        let written = [[0.0, 3.0, 4.0], [1e-200, 0.0, 0.0], [0.0, 0.0, -1.0]];
        let mut normals = written;
        assert_eq!(mend(&mut normals, &SQUARE[..3], &[[0, 1, 2]]), Ok(0));
        assert_eq!(normals, written);
    }

    #[test]
    fn zero_and_nan_become_the_mean_of_the_faces() {
        // Two faces that meet at a right angle along x, with the common edge's normals missing.
        let positions = [
            [0., 0., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [0., 0., 1.],
            [5., 5., 5.],
        ];
        let mut normals = [
            [0.0; 3],
            [f64::NAN, 0.0, 0.0],
            [0., 0., 1.],
            [0., -1., 0.],
            [0.0; 3],
        ];
        let seen = mend(&mut normals, &positions, &[[0, 1, 2], [0, 3, 1]]);
        assert_eq!(seen, Ok(2));
        let half = 0.5_f64.sqrt();
        for normal in &normals[..2] {
            let mean = [0.0, half, half];
            assert!(
                (0..3).all(|i| (normal[i] - mean[i]).abs() < 1e-15),
                "{normal:?}"
            );
        }
        assert_eq!(normals[4], UNSEEN);
    }

    #[test]
    fn opposite_faces_do_not_cancel_out() {
        let mut normals = [[0.0; 3]; 3];
        let seen = mend(&mut normals, &SQUARE[..3], &[[0, 1, 2], [0, 2, 1]]);
        assert_eq!(seen, Ok(3));
        assert_eq!(normals, [[0., 0., 1.]; 3]);
    }

    #[test]
    fn faces_of_any_size_have_a_normal() {
        for size in [1e-300, 1e-100, 1.0, 1e100, 1e308] {
            let corners = [SQUARE[0], SQUARE[1], SQUARE[3]].map(|p| p.map(|x| x * size));
            assert_eq!(of_triangle(corners), Some([0., 0., 1.]), "{size}");
        }
        assert_eq!(of_triangle([SQUARE[0], SQUARE[1], SQUARE[1]]), None);
        assert_eq!(of_triangle([[0.0; 3], [1.0; 3], [2.0; 3]]), None);
    }
}
