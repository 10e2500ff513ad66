//! Single-stroke letters for silk. Points lie on a grid of 5 by 7 and are written as two digits each.

use crate::shapes::Point;

/// Strokes of each letter, separated by `|`.
const STROKES: [(char, &str); 40] = [
    (' ', ""),
    ('+', "03 43|21 25"),
    ('-', "03 43"),
    ('.', "20 21"),
    ('0', "10 30 41 45 36 16 05 01 10"),
    ('1', "14 26 20|10 30"),
    ('2', "05 16 36 45 44 00 40"),
    ('3', "06 46 24 34 43 41 30 10 01"),
    ('4', "30 36 02 42"),
    ('5', "46 06 03 33 42 41 30 10 01"),
    ('6', "36 16 05 01 10 30 41 42 33 03"),
    ('7', "06 46 20"),
    ('8', "13 04 05 16 36 45 44 33 13 02 01 10 30 41 42 33"),
    ('9', "43 13 04 05 16 36 45 41 30 10"),
    ('A', "00 03 26 43 40|02 42"),
    ('B', "00 06 36 45 44 33 03|33 42 41 30 00"),
    ('C', "45 36 16 05 01 10 30 41"),
    ('D', "00 06 26 44 42 20 00"),
    ('E', "40 00 06 46|03 33"),
    ('F', "00 06 46|03 33"),
    ('G', "45 36 16 05 01 10 40 43 23"),
    ('H', "00 06|40 46|03 43"),
    ('I', "10 30|20 26|16 36"),
    ('J', "01 10 30 41 46"),
    ('K', "00 06|46 03 40"),
    ('L', "06 00 40"),
    ('M', "00 06 23 46 40"),
    ('N', "00 06 40 46"),
    ('O', "10 30 41 45 36 16 05 01 10"),
    ('P', "00 06 36 45 44 33 03"),
    ('Q', "10 30 41 45 36 16 05 01 10|22 40"),
    ('R', "00 06 36 45 44 33 03|23 40"),
    ('S', "45 36 16 05 04 13 33 42 41 30 10 01"),
    ('T', "06 46|26 20"),
    ('U', "06 01 10 30 41 46"),
    ('V', "06 20 46"),
    ('W', "06 10 24 30 46"),
    ('X', "00 46|06 40"),
    ('Y', "06 23 46|23 20"),
    ('Z', "06 46 00 40"),
];

/// Grid steps between the beginnings of two letters.
const ADVANCE: f64 = 5.6;
/// Height of a letter in steps of the grid.
const HEIGHT: f64 = 6.0;

/// Width of a text, mm.
pub(crate) fn width_mm(text: &str, height_mm: f64) -> f64 {
    let steps = (text.chars().count() as f64 * ADVANCE - (ADVANCE - 4.0)).max(0.0);
    steps * height_mm / HEIGHT
}

/// Returns the lines of a text, centred at the origin, mm. Letters that the font lacks are skipped.
pub(crate) fn lines(text: &str, height_mm: f64) -> Vec<[Point; 2]> {
    let scale = height_mm / HEIGHT;
    let start = -width_mm(text, height_mm) / 2.0;
    let mut lines = Vec::new();
    for (index, letter) in text.chars().enumerate() {
        let Some((_, strokes)) =
            STROKES.iter().find(|(known, _)| *known == letter.to_ascii_uppercase())
        else {
            continue;
        };
        for stroke in strokes.split('|') {
            let points: Vec<Point> = stroke
                .split_whitespace()
                .map(|pair| {
                    let digit = |i: usize| f64::from(pair.as_bytes()[i] - b'0');
                    let x = start + scale * (digit(0) + ADVANCE * index as f64);
                    [x, scale * (digit(1) - HEIGHT / 2.0)]
                })
                .collect();
            lines.extend(points.windows(2).map(|pair| [pair[0], pair[1]]));
        }
    }
    lines
}
