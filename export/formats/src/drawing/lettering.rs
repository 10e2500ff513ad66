//! Single-stroke capitals, so that labels need no font on the marking machine.

/// Height of capitals, mm.
pub(crate) const HEIGHT_MM: f64 = 2.4;

const UNIT_MM: f64 = HEIGHT_MM / 6.0;
const ADVANCE_UNITS: f64 = 6.0;
const WIDTH_UNITS: f64 = 4.0;

/// Returns the polylines of a character: pairs of digits are points (x 0 to 4, y 0 to 6 from the baseline), spaces lift
/// the pen. Unlisted characters become a box.
fn glyph(character: char) -> &'static str {
    match character.to_ascii_uppercase() {
        'A' => "0004264440 0242",
        'B' => "00063645443303 3342413000",
        'C' => "4536160501103041",
        'D' => "00062644422000",
        'E' => "46060040 0333",
        'F' => "460600 0333",
        'G' => "45361605011030414323",
        'H' => "0006 4046 0343",
        'I' => "1030 1636 2026",
        'J' => "0110304146",
        'K' => "0006 460340",
        'L' => "060040",
        'M' => "0006234640",
        'N' => "00064046",
        'O' => "100105163645413010",
        'P' => "00063645443303",
        'Q' => "100105163645413010 2240",
        'R' => "00063645443303 2340",
        'S' => "453616050413334241301001",
        'T' => "0646 2026",
        'U' => "060110304146",
        'V' => "062046",
        'W' => "0610233046",
        'X' => "0046 0640",
        'Y' => "062346 2320",
        'Z' => "06460040",
        '0' => "100105163645413010 0145",
        '1' => "052620 1030",
        '2' => "05163645440040",
        '3' => "051636454433 133342413010 1001",
        '4' => "30360242",
        '5' => "460603334241301001",
        '6' => "4536160501103041423303",
        '7' => "064610",
        '8' => "13040516364544331302011030414233",
        '9' => "0110304145361605041343",
        '-' => "1333",
        '.' => "2021",
        ',' => "1021",
        '%' => "0046 0506161505 3031414030",
        '(' => "36252130",
        ')' => "16252110",
        ' ' => "",
        _ => "0006464000",
    }
}

/// Width of a text, mm.
pub(crate) fn width_mm(text: &str) -> f64 {
    let letters = text.chars().count() as f64;
    ((letters - 1.0) * ADVANCE_UNITS + WIDTH_UNITS).max(0.0) * UNIT_MM
}

/// Returns the strokes of a text with capitals of the given height, y up, with the baseline starting at the origin, in
/// the unit of `height`.
///
/// ```
/// let strokes = fabkit_export::lettering("seen 57 %", 12.0);
/// let highest = strokes.iter().flatten().fold(0.0f64, |most, [_, y]| most.max(*y));
/// assert_eq!(highest, 12.0);
/// ```
pub fn lettering(text: &str, height: f64) -> Vec<Vec<[f64; 2]>> {
    let scale = height / HEIGHT_MM;
    let mut strokes = strokes(text, [0.0; 2]);
    strokes.iter_mut().flatten().for_each(|point| *point = point.map(|value| scale * value));
    strokes
}

/// Returns the strokes of a text whose baseline starts at a point, mm.
pub(crate) fn strokes(text: &str, start_mm: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut strokes = Vec::new();
    for (i, character) in text.chars().enumerate() {
        let left = i as f64 * ADVANCE_UNITS;
        let point = |pair: &[u8]| {
            let [x, y] = [pair[0], pair[1]].map(|digit| f64::from(digit - b'0'));
            [start_mm[0] + (left + x) * UNIT_MM, start_mm[1] + y * UNIT_MM]
        };
        let lines = glyph(character).split_ascii_whitespace();
        strokes.extend(lines.map(|line| line.as_bytes().chunks_exact(2).map(point).collect()));
    }
    strokes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_character_of_a_name_has_its_own_shape_within_its_cell() {
        let characters = "abcdefghijklmnopqrstuvwxyz0123456789-.";
        let mut seen = std::collections::BTreeSet::new();
        for c in characters.chars() {
            assert!(seen.insert(glyph(c)) && glyph(c) != glyph('?'), "{c}");
            let all = strokes(&c.to_string(), [0.0, 0.0]);
            assert!(all.iter().all(|stroke| stroke.len() > 1), "{c}");
            for [x, y] in all.into_iter().flatten() {
                assert!((0.0..=width_mm("x") + 1e-12).contains(&x), "{c}");
                assert!((0.0..=HEIGHT_MM + 1e-12).contains(&y), "{c}");
            }
        }
    }

    #[test]
    fn a_text_ends_where_its_width_says() {
        let points = strokes("abx", [1.0, 2.0]).concat();
        let right = points.iter().map(|p| p[0]).fold(f64::MIN, f64::max);
        assert!((right - 1.0 - width_mm("abx")).abs() < 1e-12);
        assert_eq!(width_mm(""), 0.0);
    }
}
