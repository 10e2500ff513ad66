//! File of the gel coupon: a ball on a cup of gel, the loads that rest on it, and the depths to which it sinks.

use std::fmt::Write as _;
use std::ops::RangeInclusive;

use fabkit_geometry::Length;
use fabkit_text::{
    Dialect, InvalidDesign, NodeReader, Position, TextLayer, TextPlace, YamlContent, YamlEntry,
    YamlNode, read_mapping, suggestion, take_format, take_word, to_printable,
};

use crate::materials::Mass;

/// Key that distinguishes the file of a gel from that of a printer.
const KEY: &str = "gel";
/// Number of empty rows in the template file.
const ROWS: usize = 8;
/// Minimum number of readings for a modulus.
const NEEDED: usize = 3;

/// Dialect of gel coupon files.
const GEL: Dialect = Dialect::new("gel coupon", 1, " and `gel: NAME`");

/// Allowed range of each size, mm.
const SIZES_MM: [(&str, RangeInclusive<f64>); 3] =
    [("ball", 3.0..=60.0), ("thickness", 3.0..=60.0), ("diameter", 10.0..=200.0)];
/// Allowed range of a load, g.
const LOADS_G: RangeInclusive<f64> = 0.1..=20_000.0;
/// Allowed range of a gap, mm.
const GAPS_MM: RangeInclusive<f64> = 0.0..=500.0;
/// Keys of a reading: a mass and a length.
const ROW: [&str; 2] = ["load", "gap"];

/// Cup filled with a batch of gel, and the ball that is pressed into it.
///
/// ```
/// use fabkit_designs::profile::GelCoupon;
/// let yaml = "
/// format: 1
/// gel: Smooth-On Ecoflex 00-30
/// ball: 20 mm
/// thickness: 20 mm
/// diameter: 60 mm
/// readings:
///   - {load: 50 g, gap: 21.0 mm}
///   - {load: 100 g, gap: 20.3 mm}
///   - {load: 0.2 kg, gap: 19.2 mm}
/// ";
/// let coupon = GelCoupon::read("gel.yaml", yaml)?;
/// assert_eq!((coupon.ball_mm, coupon.readings[2].load_g), (20.0, 200.0));
/// assert_eq!(coupon.file_name(), "gel-smooth-on-ecoflex-00-30.yaml");
/// # Ok::<(), fabkit_designs::parameters::InvalidDesign>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct GelCoupon {
    /// Cast material, by its name in `materials`.
    pub material: String,
    /// Diameter of the ball, mm.
    pub ball_mm: f64,
    /// Thickness of the gel, mm.
    pub thickness_mm: f64,
    /// Diameter of the gel, mm.
    pub diameter_mm: f64,
    /// Measured readings; empty in the file that comes with the coupon.
    pub readings: Vec<GelReading>,
}

/// Reading at one load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GelReading {
    /// Total mass that rests on the gel, g.
    pub load_g: f64,
    /// Gap between guide and tray, mm.
    pub gap_mm: f64,
}

impl GelCoupon {
    /// Formats the template file, which [`GelCoupon::read`] reads once it is filled in.
    pub fn to_yaml(&self) -> String {
        let material = serde_json::Value::from(self.material.as_str());
        let mut yaml = format!(
            "# A ball sinks into a cup of gel: how stiff a batch came out. Replace each null by what you read, with\n\
             # its unit, for example `{{load: 86.5 g, gap: 18.42 mm}}`. Rows that you do not need stay null.\n\
             #\n\
             # 1. Pour the cup full to the brim with the batch that the sensor is cast from, and let it cure beside it.\n\
             # 2. Weigh tray, rod, holder and ball together on a kitchen scale, then every weight that you put on.\n\
             # 3. Powder or wet the gel, so that the ball slides on it. Let the ball down, and wait 30 seconds.\n\
             # 4. `load` is all that rests on the gel. `gap` is from the guide's top to the tray's underside, with the\n\
             #    inside jaws of a calliper. Take 3 loads or more, the heaviest at least twice the lightest; the ball\n\
             #    should sink in by up to {:.1} mm.\n\
             # Then: fabkit profile {} -o my-batch.yaml\n\
             format: 1\n\
             {KEY}: {material}\n\
             ball: {} mm\n\
             thickness: {} mm\n\
             diameter: {} mm\n\
             readings:\n",
            (0.25 * self.thickness_mm).min(0.25 * self.ball_mm),
            self.file_name(),
            self.ball_mm,
            self.thickness_mm,
            self.diameter_mm
        );
        // Writing to a String cannot fail.
        for GelReading { load_g, gap_mm } in &self.readings {
            let _ = writeln!(yaml, "  - {{load: {load_g} g, gap: {gap_mm} mm}}");
        }
        for _ in self.readings.len()..ROWS {
            let _ = writeln!(yaml, "  - {{load: null, gap: null}}");
        }
        yaml
    }

    /// Returns the file name, made from the material in lower case.
    pub fn file_name(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { ' ' };
        let name: String = self.material.chars().map(plain).collect();
        let words: Vec<&str> = std::iter::once(KEY).chain(name.split_whitespace()).collect();
        words.join("-") + ".yaml"
    }

    /// Returns whether a text is the file of a gel rather than of a printer: `gel:` stands at its top level.
    pub fn is_gel_file(yaml: &str) -> bool {
        yaml.lines().any(|line| line.strip_prefix(KEY).is_some_and(|rest| rest.starts_with(':')))
    }

    /// Reads a filled-in file; `file` names the text in messages.
    ///
    /// # Errors
    /// Every problem: sizes and loads without a unit, incomplete rows, too few of them.
    pub fn read(file: &str, yaml: &str) -> Result<Self, InvalidDesign> {
        let mut text = NodeReader::new(TextPlace::new(TextLayer::File, file, &GEL));
        let coupon = read(&mut text, yaml);
        text.finish(coupon)
    }
}

fn read(text: &mut NodeReader, yaml: &str) -> Option<GelCoupon> {
    let mut entries = read_mapping(yaml, &text.place, &mut text.found)?;
    take_format(&mut entries, &text.place, &mut text.found);
    let material = required(text, &mut entries, KEY, "NAME");
    let sizes = SIZES_MM.map(|(key, limits)| size(text, &mut entries, key, &limits));
    let mut readings = None;
    for YamlEntry { key, key_position, value } in entries {
        match (key.as_str(), value.content) {
            ("readings", YamlContent::List(items)) => {
                let rows = items.into_iter().enumerate();
                let rows = rows.filter_map(|(i, item)| row(text, &format!("readings[{i}]"), item));
                readings = Some((key_position, rows.collect::<Vec<_>>()));
            }
            ("readings", _) => {
                let hint = "write one line `- {load: 86.5 g, gap: 18.42 mm}` for each load";
                text.report_problem(key_position, &key, "", "readings is not a list", hint);
            }
            _ => {
                let keys = SIZES_MM.iter().map(|(key, _)| *key).chain(["format", KEY, "readings"]);
                let hint = suggestion(&key, keys, "the keys are");
                let message = format!("`{}` is not a key of a gel coupon", to_printable(&key));
                text.report_problem(key_position, &key, "", message, hint);
            }
        }
    }
    let count = readings.as_ref().map_or(0, |(_, rows)| rows.len());
    // Wrong rows are reported already, and would be missing in the count.
    if count < NEEDED && text.found.is_empty() {
        let place = readings.as_ref().map_or(text.place.clone(), |(at, _)| text.place.at(*at));
        let message = format!("{count} readings are filled in; a modulus needs at least {NEEDED}");
        let found = place.problem("readings", &count.to_string(), message);
        text.found
            .push(found.hint("replace null by what was read, as `{load: 86.5 g, gap: 18.42 mm}`"));
    }
    let [ball_mm, thickness_mm, diameter_mm] = sizes;
    Some(GelCoupon {
        material: material?.0,
        ball_mm: ball_mm?,
        thickness_mm: thickness_mm?,
        diameter_mm: diameter_mm?,
        readings: readings?.1,
    })
}

/// Takes a required word from the top level of the file.
fn required(
    text: &mut NodeReader,
    entries: &mut Vec<YamlEntry>,
    key: &str,
    example: &str,
) -> Option<(String, TextPlace)> {
    let before = text.found.len();
    let word = take_word(entries, key, &text.place, &mut text.found);
    if word.is_none() && text.found.len() == before {
        let missing = text.place.problem(key, "", format!("the {key} is missing"));
        let hint = format!("write `{key}: {example}`, as in the file that came with the coupon");
        text.found.push(missing.hint(hint));
    }
    word
}

/// Reads a required size from the top level of the file, mm.
fn size(
    text: &mut NodeReader,
    entries: &mut Vec<YamlEntry>,
    key: &str,
    limits: &RangeInclusive<f64>,
) -> Option<f64> {
    let (word, at) = required(text, entries, key, "12 mm")?;
    text.read_value::<Length>(at.position?, key, &word, limits).map(Length::mm)
}

/// Reads a filled-in row; `None` for an empty row and after reporting a problem.
fn row(text: &mut NodeReader, path: &str, item: YamlNode) -> Option<GelReading> {
    let YamlContent::Map(entries) = item.content else {
        let message = format!("{path} is not a reading");
        text.report_problem(
            item.position,
            path,
            "",
            message,
            "write `{load: 86.5 g, gap: 18.42 mm}`",
        );
        return None;
    };
    let (mut read, mut nulls) = ([None; 2], 0);
    for YamlEntry { key, key_position, value } in entries {
        let path = format!("{path}.{}", to_printable(&key));
        let at: Position = value.position;
        match (key.as_str(), value.content) {
            ("load" | "gap", YamlContent::Nothing) => nulls += 1,
            ("load", YamlContent::Scalar(word)) => {
                read[0] = Some(text.read_value::<Mass>(at, &path, &word, &LOADS_G)?.0);
            }
            ("gap", YamlContent::Scalar(word)) => {
                read[1] = Some(text.read_value::<Length>(at, &path, &word, &GAPS_MM)?.mm());
            }
            ("load" | "gap", _) => {
                let message = format!("{path} is not a single value");
                text.report_problem(at, &path, "", message, "write it with its unit");
                return None;
            }
            _ => {
                let hint = suggestion(&key, ROW, "a reading has");
                let message = format!("`{}` is not known", to_printable(&key));
                text.report_problem(key_position, &path, "", message, hint);
                return None;
            }
        }
    }
    match read {
        [Some(load_g), Some(gap_mm)] => Some(GelReading { load_g, gap_mm }),
        // An empty row of the template.
        [None, None] if nulls == 2 => None,
        _ => {
            let message = format!("{path} needs both a load and a gap");
            let hint = "write both, or null for both";
            text.report_problem(item.position, path, "", message, hint);
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coupon(readings: &[(f64, f64)]) -> GelCoupon {
        let reading = |&(load_g, gap_mm): &(f64, f64)| GelReading { load_g, gap_mm };
        GelCoupon {
            material: "Smooth-On Ecoflex 00-30".into(),
            ball_mm: 12.0,
            thickness_mm: 12.0,
            diameter_mm: 50.0,
            readings: readings.iter().map(reading).collect(),
        }
    }

    #[test]
    fn gel_coupon_file_round_trips() {
        let written = coupon(&[(40.0, 19.0), (80.0, 18.4), (120.5, 18.0)]);
        assert_eq!(written.file_name(), "gel-smooth-on-ecoflex-00-30.yaml");
        let yaml = written.to_yaml();
        assert!(
            GelCoupon::is_gel_file(&yaml) && !GelCoupon::is_gel_file("process: fdm\n# gel: x\n")
        );
        assert_eq!(GelCoupon::read("a.yaml", &yaml).unwrap(), written);
    }

    #[test]
    fn all_problems_are_reported_together() {
        let yaml = coupon(&[(40.0, 19.0)]).to_yaml();
        let refused = |yaml: &str| {
            let problems = GelCoupon::read("a.yaml", yaml).unwrap_err().problems;
            problems.iter().map(|problem| problem.message.clone()).collect::<Vec<_>>().join("\n")
        };
        assert!(refused(&yaml).contains("1 readings are filled in; a modulus needs at least 3"));
        let wrong = yaml.replace("40 g", "40").replace("ball: 12 mm", "ball: 900 mm");
        let says = refused(&wrong.replace("diameter", "diametre"));
        for part in ["readings[0].load", "ball", "the diameter is missing", "`diametre`"] {
            assert!(says.contains(part), "{part}: {says}");
        }
        assert!(refused("format: 1\nball: 12 mm\n").contains("the gel is missing"));
        assert!(refused(&yaml.replace("40 g", "null")).contains("needs both a load and a gap"));
        assert!(refused(&yaml.replace("40 g", "-3 g")).contains("between"));
    }
}
