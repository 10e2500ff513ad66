//! Mutations of valid inputs: bits flipped; pieces removed, repeated or inserted from another file; extreme numbers;
//! text that is unusually deep, long or strange.

use std::ops::Range;

use fabkit_application::geometry::sequences::SplitMix64;

/// Largest input, bytes. Most limits lie below; inputs beyond them result from repetition.
const MOST_BYTES: usize = 1 << 18;

/// Boundary values of number types and ranges.
const NUMBERS: [&str; 24] = [
    "0",
    "-0",
    "-0.0",
    "1",
    "-1",
    "1e308",
    "-1e308",
    "1e309",
    "1e-320",
    "nan",
    ".nan",
    "inf",
    "-.inf",
    "2147483647",
    "2147483648",
    "4294967296",
    "4611686018427387904",
    "9223372036854775808",
    "18446744073709551615",
    "18446744073709551616",
    "1e6",
    "0.1",
    "255",
    "65537",
];
/// Unusual pieces of text.
const WORDS: [&str; 22] = [
    "\u{feff}",
    "\u{202e}",
    "\u{0}",
    "\u{2028}",
    "\u{1f600}",
    "e\u{301}",
    "\u{b5}m",
    "\r\n",
    "\r",
    "\t",
    "null",
    "true",
    "~",
    "[]",
    "{}",
    "\"",
    "'",
    "mm",
    "deg",
    "@",
    "&a *a",
    "!!binary |",
];
/// Opening and closing brackets.
const BRACKETS: [(&str, &str); 4] = [("[", "]"), ("{\"a\":", "}"), ("- ", ""), ("(", ")")];

/// Mutates an input up to four times; `other` provides pieces.
pub fn mutate(input: &[u8], other: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..=random.below(4) {
        mutate_once(&mut bytes, other, random);
        bytes.truncate(MOST_BYTES);
    }
    bytes
}

fn mutate_once(bytes: &mut Vec<u8>, other: &[u8], random: &mut SplitMix64) {
    match random.below(12) {
        0 => {
            let at = random.below(bytes.len());
            if let Some(byte) = bytes.get_mut(at) {
                *byte ^= 1 << random.below(8);
            }
        }
        1 => {
            let at = random.below(bytes.len());
            if let Some(byte) = bytes.get_mut(at) {
                *byte = *random.choose(&[0, 0x7f, 0x80, 0xff, b'\n', b' ', b',']);
            }
        }
        2 => drop(bytes.drain(random_range(bytes, random))),
        3 => {
            let copy = bytes[random_range(bytes, random)].to_vec();
            insert(bytes, &copy, random);
        }
        4 => {
            let copy = bytes[random_range(bytes, random)].to_vec();
            let times = 1 << random.below(12);
            insert(bytes, &copy.repeat(times.min(MOST_BYTES / copy.len().max(1))), random);
        }
        5 => insert(bytes, &other[random_range(other, random)], random),
        6 => bytes.truncate(random.below(bytes.len())),
        7 | 8 => {
            let number = random.choose(&NUMBERS).as_bytes();
            let found = find_numbers(bytes);
            if found.is_empty() {
                insert(bytes, number, random)
            } else {
                drop(bytes.splice(random.choose(&found).clone(), number.iter().copied()))
            }
        }
        9 => insert(bytes, random.choose(&WORDS).as_bytes(), random),
        10 => {
            let (open, close) = random.choose(&BRACKETS);
            let times = 1 << random.below(16);
            let bomb = format!("{}{}", open.repeat(times), close.repeat(random.below(2) * times));
            insert(bytes, bomb.as_bytes(), random);
        }
        _ => {
            // Swaps two lines, and may change the line endings.
            let mut lines: Vec<&[u8]> = bytes.split(|byte| *byte == b'\n').collect();
            let (a, b) = (random.below(lines.len()), random.below(lines.len()));
            lines.swap(a, b);
            *bytes = lines.join(*random.choose(&[&b"\n"[..], b"\n", b"\r\n", b"\n\n"]));
        }
    }
}

/// Chooses a random range, usually a short one.
fn random_range(bytes: &[u8], random: &mut SplitMix64) -> Range<usize> {
    let start = random.below(bytes.len());
    let most = bytes.len() - start;
    let most = if random.below(3) == 0 { most } else { most.min(16) };
    start..start + random.below(most + 1)
}

fn insert(bytes: &mut Vec<u8>, what: &[u8], random: &mut SplitMix64) {
    let at = random.below(bytes.len() + 1);
    bytes.splice(at..at, what.iter().copied());
}

/// Finds the ranges of digits.
fn find_numbers(bytes: &[u8]) -> Vec<Range<usize>> {
    let is_part = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
    let (mut found, mut at) = (Vec::new(), 0);
    while let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|i| at + i) {
        let length = bytes[start..].iter().position(|byte| !is_part(byte));
        at = length.map_or(bytes.len(), |length| start + length);
        found.push(start..at);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_decides_and_every_change_is_made() {
        let input = b"format: 1\nradius: 12.5 mm\nholes: [1, 2, 3]\n";
        let of = |seed| mutate(input, b"other: 7\n", &mut SplitMix64::new(seed));
        assert_eq!(of(7), of(7));
        let all: std::collections::BTreeSet<Vec<u8>> = (0..1000).map(of).collect();
        assert!(all.len() > 900, "{}", all.len());
        let has =
            |word: &str| all.iter().any(|bytes| String::from_utf8_lossy(bytes).contains(word));
        assert!(has("1e308") && has("\r\n") && has("[[[[[[[[") && has("18446744073709551616"));
        assert!(
            (0..1000).all(|seed| mutate(b"", b"", &mut SplitMix64::new(seed)).len() <= MOST_BYTES)
        );
    }

    #[test]
    fn numbers_are_found() {
        assert_eq!(find_numbers(b"a 12.5, 3"), [2..6, 8..9]);
        assert!(find_numbers(b"none").is_empty());
    }
}
