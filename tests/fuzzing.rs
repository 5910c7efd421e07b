//! Mutation fuzzing: valid files, damaged at random, must be read or refused within limits.
//!
//! Each case is a function of its number, so that runs are the same everywhere. A case that
//! breaks a limit is written to a file, whose path the failure names. `CANDELA_FUZZ` says how many
//! cases to run instead of the default.

use std::fmt::Debug;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::time::Duration;

use crate::allocation;

/// The longest that reading may take, for each [`LARGEST`] bytes begun.
const TIME: Duration = Duration::from_secs(1);

/// The most memory that reading may take, the file's own bytes among it, as a multiple of its
/// size, and beside that multiple.
const MEMORY_PER_BYTE: usize = 10;
const MEMORY_BESIDE: usize = 64 << 20;

/// What a case may grow to, in bytes.
const LARGEST: usize = 300_000;

/// Runs `read` on mutations of the `corpus`, `default_cases` of them unless the environment says
/// otherwise; how many were accepted (`Ok`) and refused (`Err`).
///
/// # Panics
/// If a case panics, takes too long or too much memory, or if its error has no message.
pub(crate) fn run<T, E: Debug + ToString>(
    name: &str,
    corpus: &[&[u8]],
    default_cases: u64,
    read: impl Fn(&[u8]) -> Result<T, E>,
) -> Outcomes {
    let cases = match std::env::var("CANDELA_FUZZ") {
        Ok(cases) => cases.parse().expect("CANDELA_FUZZ is a number of cases"),
        Err(_) => default_cases,
    };
    let mut outcomes = Outcomes::default();
    for case in 0..cases {
        let bytes = Mutator::for_case(case).mutated(corpus);
        match check(&bytes, &read) {
            Ok(true) => outcomes.accepted += 1,
            Ok(false) => outcomes.refused += 1,
            Err(broken) => {
                let path =
                    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz-{name}-{case}"));
                std::fs::write(&path, &bytes).expect("the folder for tests can be written");
                panic!("{name} case {case} {broken}; see {}", path.display());
            }
        }
    }
    outcomes
}

/// How cases ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Outcomes {
    pub(crate) accepted: u64,
    pub(crate) refused: u64,
}

/// How long this thread has been at work: other work on the machine does not count.
#[cfg(unix)]
fn time_spent() -> Duration {
    use nix::time::{ClockId, clock_gettime};
    clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID)
        .unwrap()
        .into()
}

/// How long this process has been at work, where a thread's own time is not to be had.
#[cfg(not(unix))]
fn time_spent() -> Duration {
    use std::sync::OnceLock;
    static START: OnceLock<std::time::Instant> = OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed()
}

/// Reads one case; whether it was accepted, or which limit it breaks.
pub(crate) fn check<T, E: Debug + ToString>(
    bytes: &[u8],
    read: impl Fn(&[u8]) -> Result<T, E>,
) -> Result<bool, String> {
    let start = time_spent();
    let (result, memory) = allocation::peak(|| catch_unwind(AssertUnwindSafe(|| read(bytes))));
    let time = time_spent() - start;
    let Ok(result) = result else {
        return Err("panics".to_owned());
    };
    let longest = TIME * (1 + (bytes.len() / LARGEST) as u32);
    if time > longest {
        return Err(format!("takes {time:?}, expected at most {longest:?}"));
    }
    let memory = memory + bytes.len();
    let limit = bytes.len() * MEMORY_PER_BYTE + MEMORY_BESIDE;
    if memory > limit {
        return Err(format!("takes {memory} bytes, expected at most {limit}"));
    }
    match result {
        Ok(_) => Ok(true),
        Err(error) if error.to_string().trim().is_empty() => {
            Err(format!("is refused without a message: {error:?}"))
        }
        Err(_) => Ok(false),
    }
}

/// Damages files; what it does follows from its seed.
#[derive(Clone, Debug)]
pub(crate) struct Mutator {
    state: u64,
}

impl Mutator {
    /// The mutator of one case.
    pub(crate) fn for_case(case: u64) -> Self {
        let mut mutator = Self { state: case };
        mutator.next();
        mutator
    }

    /// SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators",
    /// 2014).
    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.state ^ (self.state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`, or 0.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    fn choice<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    /// A range of bytes: short as a rule, at times long.
    fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let longest = self.choice(&[1, 4, 16, 64, length]);
        let start = self.below(length + 1);
        let end = start + self.below(longest + 1);
        start..end.min(length)
    }

    /// A file of the corpus with one to eight mutations.
    pub(crate) fn mutated(&mut self, corpus: &[&[u8]]) -> Vec<u8> {
        let mut bytes = self.choice(corpus).to_vec();
        for _ in 0..=self.below(8) {
            self.mutate(&mut bytes, corpus);
            bytes.truncate(LARGEST);
        }
        bytes
    }

    fn mutate(&mut self, bytes: &mut Vec<u8>, corpus: &[&[u8]]) {
        let place = self.below(bytes.len());
        match self.below(9) {
            // A bit turned over.
            0 => {
                if let Some(byte) = bytes.get_mut(place) {
                    *byte ^= 1 << self.below(8);
                }
            }
            // A byte of consequence.
            1 => {
                let special = *b"\0\n\r\t -+.eE/\\#\"'=,[]{}09\x7f\x80\xff";
                if let Some(byte) = bytes.get_mut(place) {
                    *byte = self.choice(&special);
                }
            }
            // A stretch removed.
            2 => {
                let range = self.range(bytes.len());
                bytes.drain(range);
            }
            // A stretch repeated, at times over and over.
            3 => {
                let range = self.range(bytes.len());
                let times = self.choice(&[1, 1, 1, 2, 10, 1000]);
                let chunk = bytes[range.clone()].repeat(times);
                let chunk = &chunk[..chunk.len().min(LARGEST)];
                bytes.splice(range.end..range.end, chunk.iter().copied());
            }
            // Random bytes inserted.
            4 => {
                let noise: Vec<u8> = (0..self.below(16)).map(|_| self.next() as u8).collect();
                bytes.splice(place..place, noise);
            }
            // The end cut off.
            5 => bytes.truncate(place),
            // The end of another file.
            6 => {
                let other = self.choice(corpus);
                let from = self.below(other.len());
                bytes.truncate(place);
                bytes.extend_from_slice(&other[from..]);
            }
            // A number in text.
            7 => self.replace_number(bytes),
            // A number in binary data.
            _ => {
                let value = self.choice(&[
                    [0; 8],
                    [0xff; 8],
                    [0, 0, 0, 0x80, 0, 0, 0, 0x80],
                    f64::NAN.to_le_bytes(),
                    [0, 0, 0x80, 0x7f, 0, 0, 0x80, 0x7f],
                    (1_u64 << 31).to_le_bytes(),
                ]);
                let length = self.choice(&[1, 2, 4, 8]);
                for (byte, value) in bytes.iter_mut().skip(place).take(length).zip(value) {
                    *byte = value;
                }
            }
        }
    }

    /// Puts a number of consequence in the place of one in the text.
    fn replace_number(&mut self, bytes: &mut Vec<u8>) {
        const NUMBERS: [&str; 24] = [
            "0",
            "1",
            "-1",
            "2",
            "3",
            "4",
            "255",
            "256",
            "65535",
            "65537",
            "2147483647",
            "2147483648",
            "4294967295",
            "4294967296",
            "-9223372036854775808",
            "9223372036854775807",
            "99999999999999999999999999",
            "nan",
            "inf",
            "1e308",
            "-1e-320",
            "1e999",
            "0.1",
            "-0",
        ];
        let numeric = |byte: &u8| byte.is_ascii_digit() || b"+-.".contains(byte);
        let from = self.below(bytes.len());
        let Some(start) = bytes[from..].iter().position(numeric) else {
            return;
        };
        let start = from + start;
        let length = bytes[start..]
            .iter()
            .take_while(|byte| numeric(byte))
            .count();
        bytes.splice(start..start + length, self.choice(&NUMBERS).bytes());
    }
}

#[test]
fn limits_are_checked() {
    let broken = |read: fn(&[u8]) -> Result<(), String>| check(b"x", read).unwrap_err();
    assert_eq!(check(b"", |_| Ok::<_, String>(())), Ok(true));
    assert_eq!(check(b"", |_| Err::<(), _>("no")), Ok(false));
    assert!(broken(|_| Err(" ".to_owned())).contains("without a message"));
    assert!(
        broken(|_| {
            drop(std::hint::black_box(vec![0_u8; MEMORY_BESIDE + 10]));
            Ok(())
        })
        .contains("bytes")
    );
    assert!(
        broken(|_| {
            let start = time_spent();
            while time_spent() - start <= TIME {}
            Ok(())
        })
        .contains("at most 1s")
    );
}

#[test]
fn cases_are_reproducible_and_differ() {
    let corpus: [&[u8]; 2] = [b"v 1 2 3\nf 1 1 1\n", b"ply 4 5 6"];
    let case = |case| Mutator::for_case(case).mutated(&corpus);
    let cases: std::collections::HashSet<Vec<u8>> = (0..1000).map(case).collect();
    assert!(cases.len() > 500, "{}", cases.len());
    assert_eq!(case(7), case(7));
}
