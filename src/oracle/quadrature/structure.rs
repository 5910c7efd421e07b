//! What bounds the hidden pieces of a line: while these are the same curves in the same order, what is seen changes
//! smoothly from line to line.

use super::shadow::Hidden;
use super::view::Line;

/// Which curves these are, as a number.
pub(super) type Structure = u64;

/// Joins what overlaps, or is not farther apart than `room`, in order. Of curves that are not farther apart it takes
/// the one with the lowest number.
pub(super) fn join(hidden: &mut Vec<Hidden>, room: f64) {
    hidden.sort_by(|a, b| a.ends[0].total_cmp(&b.ends[0]));
    let mut count = 0;
    for index in 0..hidden.len() {
        let next = hidden[index];
        if count == 0 || next.ends[0] > hidden[count - 1].ends[1] + room {
            hidden[count] = next;
            count += 1;
            continue;
        }
        let last = &mut hidden[count - 1];
        if next.ends[0] <= last.ends[0] + room {
            last.curves[0] = last.curves[0].min(next.curves[0]);
        }
        if next.ends[1] > last.ends[1] + room {
            last.curves[1] = next.curves[1];
        } else if next.ends[1] >= last.ends[1] - room {
            last.curves[1] = last.curves[1].min(next.curves[1]);
        }
        last.ends[1] = last.ends[1].max(next.ends[1]);
    }
    hidden.truncate(count);
    hidden.retain(|piece| piece.ends[1] - piece.ends[0] > room);
}

/// Of a line, what is hidden of it, joined, and what is behind panes.
pub(super) fn structure(
    line: &Line,
    hidden: &[Hidden],
    covered: impl Iterator<Item = Hidden>,
) -> Structure {
    let clipped = [line.ends[0] > -line.semi, line.ends[1] < line.semi];
    let ends = clipped.map(u32::from).into_iter();
    let pieces = hidden.iter().copied().chain(covered);
    let curves = pieces.flat_map(|piece| piece.curves);
    // FNV-1a, by words.
    ends.chain(curves)
        .fold(0xcbf2_9ce4_8422_2325, |hash, number| {
            (hash ^ u64::from(number)).wrapping_mul(0x0100_0000_01b3)
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_in_order() {
        let piece = |from: f64, to: f64, curves: [u32; 2]| Hidden {
            ends: [from, to],
            curves,
        };
        let mut hidden = vec![
            piece(0.5, 0.6, [7, 8]),
            piece(-0.2, 0.1, [3, 4]),
            piece(0.0, 0.3, [5, 6]),
            piece(-0.2, 0.3, [2, 9]),
        ];
        join(&mut hidden, 0.0);
        let found: Vec<_> = hidden
            .iter()
            .map(|piece| (piece.ends, piece.curves))
            .collect();
        assert_eq!(found, [([-0.2, 0.3], [2, 6]), ([0.5, 0.6], [7, 8])]);
        join(&mut hidden, 0.25);
        assert_eq!(hidden.len(), 1);
        assert_eq!(hidden[0].curves, [2, 8]);
    }
}
