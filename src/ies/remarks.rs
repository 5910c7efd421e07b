//! What of a luminaire file was not taken as written.

/// What was repaired or skipped, counted so that it can be said; all zero for a file without flaws.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IesRemarks {
    /// Whether a UTF-8 byte order mark stood before the file.
    pub byte_order_mark: bool,
    /// Whether lines end in CR alone.
    pub carriage_returns: bool,
    /// Whether there are `[KEYWORD]` lines, but no first line that names an edition of LM-63.
    pub no_edition: bool,
    /// A first line that names an edition which is not known. The file was read as of LM-63-2002.
    pub unknown_edition: bool,
    /// Lines before `TILT=` that are no keyword, in a file of 1991 or later.
    pub plain_lines: u32,
    /// Keywords in lower-case letters.
    pub small_keywords: u32,
    /// Lines before `TILT=` that are not UTF-8; they were read as Latin-1.
    pub latin1_lines: u32,
    /// Lines of more than 256 bytes, the longest that LM-63-2002 allows.
    pub long_lines: u32,
    /// Whether `TILT=` has blanks about it, lower-case letters or no value (which is `NONE`).
    pub loose_tilt: bool,
    /// Whether the file of `TILT=<name>` was not asked for: nothing of it is applied.
    pub unread_tilt: bool,
    /// Whether lumens per lamp are negative, but not −1: taken as absolute photometry.
    pub odd_lumens: bool,
    /// Whether a ballast-lamp factor ("future use") of 0 was taken as 1.
    pub no_ballast_lamp_factor: bool,
    /// Whether the unit of the opening is neither feet nor meters: its size is left out.
    pub unknown_unit: bool,
    /// Commas that were read as decimal points.
    pub decimal_commas: u32,
    /// Exponents behind a D, as Fortran writes them.
    pub fortran_exponents: u32,
    /// Lists of angles that do not ascend: they were sorted, with their values.
    pub unsorted_lists: u32,
    /// Angles that are there twice with the same values: one of each was left out.
    pub repeated_angles: u32,
    /// Angles that were rounded to the end of their range.
    pub rounded_angles: u32,
    /// Whether the plane at 360° was missing: it is that at 0°.
    pub added_plane: bool,
    /// Values of the plane at 360° that differ from those at 0°, which replaced them.
    pub open_seam: u32,
    /// Whether horizontal angles were turned, or mirrored by their symmetry, into the standard's range.
    pub turned_planes: bool,
    /// Whether the angles do not reach the limits of the standard: beyond them it is dark.
    pub partial_range: bool,
    /// Small negative intensities, which became 0.
    pub negative_values: u32,
    /// Numbers behind the last one that the file counts, which were skipped.
    pub extra_numbers: u64,
    /// Bytes of something else behind the last number, which were skipped.
    pub trailing_bytes: u64,
}

impl IesRemarks {
    /// Whether everything was taken as written.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Each as text: what the file has, and what became of it.
    pub fn list(&self) -> Vec<String> {
        self.counted().into_iter().chain(self.plain()).collect()
    }

    fn counted(&self) -> Vec<String> {
        let counts = [
            (
                u64::from(self.plain_lines),
                "line before TILT that is no keyword, which was skipped",
                "lines before TILT that are no keywords, which were skipped",
            ),
            (
                u64::from(self.small_keywords),
                "keyword in lower case",
                "keywords in lower case",
            ),
            (
                u64::from(self.latin1_lines),
                "line that is not UTF-8, read as Latin-1",
                "lines that are not UTF-8, read as Latin-1",
            ),
            (
                u64::from(self.long_lines),
                "line of more than 256 bytes",
                "lines of more than 256 bytes",
            ),
            (
                u64::from(self.decimal_commas),
                "comma read as a decimal point",
                "commas read as decimal points",
            ),
            (
                u64::from(self.fortran_exponents),
                "number with D before its exponent, read as E",
                "numbers with D before their exponents, read as E",
            ),
            (
                u64::from(self.unsorted_lists),
                "list of angles that does not ascend, which was sorted with its values",
                "lists of angles that do not ascend, which were sorted with their values",
            ),
            (
                u64::from(self.repeated_angles),
                "angle that is there twice with the same values, left out once",
                "angles that are there twice with the same values, left out once",
            ),
            (
                u64::from(self.rounded_angles),
                "angle rounded to the end of its range",
                "angles rounded to the end of their range",
            ),
            (
                u64::from(self.open_seam),
                "value at 360° that is not that at 0°, which replaced it",
                "values at 360° that are not those at 0°, which replaced them",
            ),
            (
                u64::from(self.negative_values),
                "small negative intensity, which became 0",
                "small negative intensities, which became 0",
            ),
            (
                self.extra_numbers,
                "number behind all that the file counts, which was skipped",
                "numbers behind all that the file counts, which were skipped",
            ),
            (
                self.trailing_bytes,
                "byte behind the last number, which was skipped",
                "bytes behind the last number, which were skipped",
            ),
        ];
        let counts = counts.into_iter().filter(|&(count, ..)| count > 0);
        counts
            .map(|(count, one, many)| format!("{count} {}", if count == 1 { one } else { many }))
            .collect()
    }

    fn plain(&self) -> impl Iterator<Item = String> {
        let facts = [
            (self.byte_order_mark, "a byte order mark, which was skipped"),
            (self.carriage_returns, "lines that end in CR alone"),
            (
                self.no_edition,
                "no first line that names the edition of LM-63, read as of 1986",
            ),
            (
                self.unknown_edition,
                "an edition of LM-63 that is not known, read as of 2002",
            ),
            (
                self.loose_tilt,
                "a TILT line with blanks, in lower case or without a value, read as if written well",
            ),
            (
                self.unread_tilt,
                "a file of tilt factors, which is not applied",
            ),
            (
                self.odd_lumens,
                "negative lumens per lamp other than -1, read as absolute photometry",
            ),
            (
                self.no_ballast_lamp_factor,
                "a ballast-lamp factor of 0, read as 1",
            ),
            (
                self.unknown_unit,
                "a unit that is neither 1 (feet) nor 2 (meters), so that the size of its opening is left out",
            ),
            (
                self.added_plane,
                "no plane at 360°, which became that at 0°",
            ),
            (
                self.turned_planes,
                "horizontal angles outside of the standard's range, which were turned into it",
            ),
            (
                self.partial_range,
                "angles that do not reach the limits of the standard, beyond which it is dark",
            ),
        ];
        let facts = facts.into_iter().filter(|&(is_so, _)| is_so);
        facts.map(|(_, text)| text.to_owned())
    }

    /// One more of `count`.
    pub(super) fn add(count: &mut u32) {
        *count = count.saturating_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_and_many() {
        assert!(IesRemarks::default().is_empty());
        assert!(IesRemarks::default().list().is_empty());
        let mut remarks = IesRemarks {
            negative_values: 1,
            extra_numbers: 2,
            added_plane: true,
            ..IesRemarks::default()
        };
        IesRemarks::add(&mut remarks.long_lines);
        assert!(!remarks.is_empty());
        assert_eq!(
            remarks.list(),
            [
                "1 line of more than 256 bytes",
                "1 small negative intensity, which became 0",
                "2 numbers behind all that the file counts, which were skipped",
                "no plane at 360°, which became that at 0°",
            ]
        );
    }
}
