//! Numbers of text: the f64 nearest to decimal digits, fast where one exact operation gives it.

use super::separators::is_separator;

/// 10⁰ to 10²²: the powers of ten that f64 holds exactly.
const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// The largest integer up to which f64 holds every integer.
const EXACT_INTEGER: u64 = 1 << f64::MANTISSA_DIGITS;

/// The most decimal digits that always fit in u64.
const U64_DIGITS: usize = 19;

/// The integer that a number is, where it is one and f64 tells it from its neighbors.
#[inline]
pub(super) fn whole(value: f64) -> Option<i64> {
    (value.fract() == 0.0 && value.abs() <= EXACT_INTEGER as f64).then_some(value as i64)
}

/// A number of any length and form, or one of the words by which programs print what is none.
pub(super) fn parse_float(token: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(token).ok()?;
    text.parse().ok().or_else(|| parse_not_finite(text))
}

/// Infinity and NaN, as the C libraries, Java, Fortran and others print them beside the forms that Rust
/// reads (`inf`, `infinity`, `nan` in any case, with a sign): `nan(ind)`, `nan(snan)`,
/// `nan(0x8000000000000)`, `NaN0x7ff8000000000000`, `NaNQ`, `1.#INF`, `1.#IND00`, `1.#QNAN`, and what
/// these become when they are rounded to fewer places, `1.#J`.
#[cold]
fn parse_not_finite(text: &str) -> Option<f64> {
    let unsigned = text.strip_prefix(['-', '+']).unwrap_or(text);
    let sign = if text.starts_with('-') { -1.0 } else { 1.0 };
    let lower = unsigned.to_ascii_lowercase();
    let is_payload = |rest: &str| {
        let is_part = |byte: u8| byte.is_ascii_alphanumeric() || b"()_+-".contains(&byte);
        rest.bytes().all(is_part)
    };
    if let Some(kind) = lower.strip_prefix("1.#").filter(|kind| is_payload(kind)) {
        let is_infinite = kind.starts_with("inf");
        return Some(sign * if is_infinite { f64::INFINITY } else { f64::NAN });
    }
    let quiet = lower.strip_prefix(['q', 's']).unwrap_or(&lower);
    if quiet.strip_prefix("nan").is_some_and(is_payload) {
        return Some(f64::NAN);
    }
    (unsigned == "∞").then_some(sign * f64::INFINITY)
}

#[inline]
pub(super) const fn decimal_digit(byte: u8) -> Option<u8> {
    let digit = byte.wrapping_sub(b'0');
    if digit < 10 { Some(digit) } else { None }
}

/// The number that `bytes` starts with and its length, where it takes one exactly rounded
/// operation: a mantissa up to 2⁵³ times or over a power of ten up to 10²² (Clinger, "How to
/// read floating point numbers accurately", 1990). `None` for all others, and where something
/// else than a blank, a line end or `\` follows.
#[inline]
pub(super) fn scan_float(bytes: &[u8]) -> Option<(f64, usize)> {
    let negative = bytes.first() == Some(&b'-');
    let mut length = usize::from(negative || bytes.first() == Some(&b'+'));
    let mut mantissa = 0_u64;
    let mut digits = 0;
    // Wraps only past U64_DIGITS, where the result is not used.
    while let Some(digit) = bytes.get(length).and_then(|&byte| decimal_digit(byte)) {
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        digits += 1;
        length += 1;
    }
    let mut exponent = 0_i32;
    if bytes.get(length) == Some(&b'.') {
        length += 1;
        let integer_digits = digits;
        while let Some(digit) = bytes.get(length).and_then(|&byte| decimal_digit(byte)) {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            digits += 1;
            length += 1;
        }
        if digits > U64_DIGITS {
            return None;
        }
        exponent = integer_digits as i32 - digits as i32;
    }
    if digits == 0 || digits > U64_DIGITS || mantissa > EXACT_INTEGER {
        return None;
    }
    if let Some(b'e' | b'E') = bytes.get(length) {
        let (written, after) = scan_exponent(bytes, length + 1)?;
        exponent += written;
        length = after;
    }
    match bytes.get(length) {
        None | Some(b' ' | b'\n' | b'\\') => {}
        Some(&byte) if is_separator(byte) => {}
        Some(_) => return None,
    }
    let power = *POWERS_OF_TEN.get(exponent.unsigned_abs() as usize)?;
    let magnitude = if exponent < 0 {
        mantissa as f64 / power
    } else {
        mantissa as f64 * power
    };
    Some((if negative { -magnitude } else { magnitude }, length))
}

/// The exponent of at most three digits that starts at `bytes[length]`, and the end of it.
#[inline]
fn scan_exponent(bytes: &[u8], mut length: usize) -> Option<(i32, usize)> {
    const MOST_DIGITS: usize = 3;
    let negative = bytes.get(length) == Some(&b'-');
    length += usize::from(negative || bytes.get(length) == Some(&b'+'));
    let start = length;
    let mut value = 0;
    while let Some(digit) = bytes.get(length).and_then(|&byte| decimal_digit(byte)) {
        if length - start == MOST_DIGITS {
            return None;
        }
        value = value * 10 + i32::from(digit);
        length += 1;
    }
    (length > start).then_some((if negative { -value } else { value }, length))
}
