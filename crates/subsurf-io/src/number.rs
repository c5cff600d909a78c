//! Numbers in text. Decimal fractions are read correctly rounded: where the digits fit 53 bits and the power of ten is
//! at most 22, both are exact in `f64` and one multiplication or division rounds once (Clinger 1990, "How to read
//! floating point numbers accurately", section 4); the rest goes to the standard library.

/// Whether `byte` separates words.
pub fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | 0x0b | 0x0c)
}

/// The powers of ten that are exact in `f64`.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// Most decimal digits that always fit a `u64`.
const MAX_DIGITS: usize = 19;

/// Appends the decimal digits at `at` to `value` (wrapping) and returns where they end.
#[inline]
fn digits(text: &[u8], mut at: usize, value: &mut u64) -> usize {
    while let Some(digit) = text.get(at).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
        *value = value.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    at
}

/// Whether a `-` stands at the start of `text`, and the length of the sign.
#[inline]
fn sign(text: &[u8]) -> (bool, usize) {
    match text.first() {
        Some(b'-') => (true, 1),
        Some(b'+') => (false, 1),
        _ => (false, 0),
    }
}

/// The decimal number at the start of `text` and its length, if it is easy: see the head of this file.
#[inline]
fn easy_float(text: &[u8]) -> Option<(f64, usize)> {
    let (negative, start) = sign(text);
    let mut mantissa = 0u64;
    let mut at = digits(text, start, &mut mantissa);
    let mut count = at - start;
    let mut fraction = 0;
    if text.get(at) == Some(&b'.') {
        let end = digits(text, at + 1, &mut mantissa);
        fraction = end - at - 1;
        count += fraction;
        at = end;
    }
    if count == 0 || count > MAX_DIGITS || mantissa > 1 << 53 {
        return None;
    }
    let mut exponent = -(fraction as i64);
    if matches!(text.get(at), Some(b'e' | b'E')) {
        let (down, length) = sign(&text[at + 1..]);
        let start = at + 1 + length;
        let mut power = 0;
        at = digits(text, start, &mut power);
        if at == start || at > start + 3 {
            return None;
        }
        exponent += if down { -(power as i64) } else { power as i64 };
    }
    if text.get(at).is_some_and(|&b| !is_blank(b)) {
        return None;
    }
    let power = *POWERS.get(exponent.unsigned_abs() as usize)?;
    let magnitude = if exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
    Some((if negative { -magnitude } else { magnitude }, at))
}

/// The length of the word at the start of `text`.
pub fn word_length(text: &[u8]) -> usize {
    text.iter().position(|&b| is_blank(b)).unwrap_or(text.len())
}

/// The number that is the first word of `text`, and the length of the word. Not-a-number and infinity are recognised
/// in the spellings of the usual C libraries; `None` is no number at all.
pub fn float(text: &[u8]) -> Option<(f64, usize)> {
    if let Some(easy) = easy_float(text) {
        return Some(easy);
    }
    let word = &text[..word_length(text)];
    let (_, start) = sign(word);
    let unsigned = word[start..].to_ascii_lowercase();
    let value = if unsigned.starts_with(b"nan") || unsigned.starts_with(b"1.#") {
        f64::NAN
    } else {
        std::str::from_utf8(word).ok()?.parse().ok()?
    };
    Some((value, word.len()))
}

/// The integer at the start of `text` and its length; beyond 18 digits it saturates.
#[inline]
pub fn integer(text: &[u8]) -> Option<(i64, usize)> {
    let (negative, start) = sign(text);
    let mut value = 0;
    let end = digits(text, start, &mut value);
    let magnitude = match end - start {
        0 => return None,
        1..MAX_DIGITS => value as i64,
        _ => i64::MAX,
    };
    Some((if negative { -magnitude } else { magnitude }, end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_number_ends_where_its_word_ends() {
        assert_eq!(float(b"1.25 3"), Some((1.25, 4)));
        assert_eq!(float(b"-.5\t"), Some((-0.5, 3)));
        assert_eq!(float(b"+7."), Some((7.0, 3)));
        assert_eq!(float(b"1e-3\r"), Some((0.001, 4)));
        for bad in ["", ".", "-", "1.2.3", "1e", "1e+", "0x10", "1,5", "abc", "--1", "1-", "\u{e9}"] {
            assert_eq!(float(bad.as_bytes()), None, "{bad}");
        }
    }

    #[test]
    fn the_sign_of_zero_is_kept() {
        assert!(float(b"-0").unwrap().0.is_sign_negative());
        assert!(float(b"-0.000").unwrap().0.is_sign_negative());
    }

    #[test]
    fn what_c_libraries_print_for_not_a_number_is_not_finite() {
        for word in ["nan", "-NaN", "nan(ind)", "inf", "-Infinity", "1.#QNAN", "-1.#IND", "1e999"] {
            assert!(!float(word.as_bytes()).unwrap().0.is_finite(), "{word}");
        }
    }

    #[test]
    fn integers_saturate_and_end_at_the_first_other_byte() {
        assert_eq!(integer(b"12/3"), Some((12, 2)));
        assert_eq!(integer(b"-4 "), Some((-4, 2)));
        assert_eq!(integer(b"99999999999999999999999999"), Some((i64::MAX, 26)));
        assert_eq!(integer(b"/1"), None);
        assert_eq!(integer(b"-"), None);
    }

    proptest! {
        #[test]
        fn decimals_are_read_as_the_standard_library_reads_them(text in "[-+]?[0-9]{0,20}\\.?[0-9]{0,20}(e[-+]?[0-9]{1,3})?") {
            let expected = text.parse::<f64>().ok().map(f64::to_bits);
            prop_assert_eq!(float(text.as_bytes()).map(|n| n.0.to_bits()), expected);
        }

        #[test]
        fn every_float_is_read_back_from_its_shortest_text(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            let read = float(value.to_string().as_bytes()).unwrap().0;
            prop_assert_eq!(read.to_bits(), value.to_bits());
        }
    }
}
