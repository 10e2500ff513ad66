//! Dimensions of one built unit of a design, which deviate from the drawing within tolerances.

use std::collections::BTreeMap;

use fabkit_geometry::Marker;
use fabkit_text::{InvalidDesign, NumericParameter, ValueKind};

use crate::fixing::is_bought;
use crate::registry::Trial;
use crate::{Design, REGISTRY, SensorText};

/// Permissible deviations of lengths without a stated tolerance, ISO 2768-1 class m (medium): (largest size, deviation
/// either way), mm.
const LENGTHS_MM: [(f64, f64); 6] =
    [(6.0, 0.1), (30.0, 0.2), (120.0, 0.3), (400.0, 0.5), (1000.0, 0.8), (2000.0, 1.2)];
/// Smallest size that ISO 2768-1 covers, mm. Thinner sizes, such as coats, deviate by at most [`THIN_TOLERANCE_FRACTION`] of
/// themselves.
const THIN_MM: f64 = 0.5;
// A fraction chosen here: the standard has no value below 0.5 mm.
const THIN_TOLERANCE_FRACTION: f64 = 0.2;
/// Permissible deviation of angles in ISO 2768-1 class m, deg, for sides of 10 to 50 mm, which most angles have.
const ANGLE_DEG: f64 = 0.5;

/// Length or angle of one unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Dimension {
    /// Dotted path of the parameter.
    pub path: String,
    /// Unit of the values: `mm` or `deg`.
    pub unit: &'static str,
    /// Value in the design, in `unit`.
    pub drawn: f64,
    /// Value in this unit, in `unit`. Equals `drawn` where the random deviation would break a rule of the design, or
    /// move a marker closer to the place where another one is drawn.
    pub built: f64,
    /// Permissible deviation either way, in `unit`.
    pub tolerance: f64,
    /// True if the sensor's file states the tolerance; otherwise it comes from ISO 2768-1.
    pub is_stated: bool,
}

/// Returns the default tolerance of a length, mm, or of an angle, deg; `None` for other kinds.
///
/// ```
/// use fabkit_designs::{unit_dimensions::usual_tolerance, parameters::ValueKind};
/// assert_eq!(usual_tolerance(ValueKind::Length, 1.5), Some(0.1));
/// assert_eq!(usual_tolerance(ValueKind::Length, 15.0), Some(0.2));
/// assert_eq!(usual_tolerance(ValueKind::Count, 8.0), None);
/// ```
pub fn usual_tolerance(kind: ValueKind, value: f64) -> Option<f64> {
    let size = value.abs();
    match kind {
        ValueKind::Length if size < THIN_MM => Some(THIN_TOLERANCE_FRACTION * size),
        ValueKind::Length => {
            // Sizes beyond the table take its last tolerance.
            let of_size = LENGTHS_MM.iter().find(|(up_to, _)| size <= *up_to);
            Some(of_size.unwrap_or(&LENGTHS_MM[LENGTHS_MM.len() - 1]).1)
        }
        ValueKind::Angle => Some(ANGLE_DEG),
        ValueKind::Count
        | ValueKind::Number
        | ValueKind::Switch
        | ValueKind::Text
        | ValueKind::List => None,
    }
}

/// Builds a unit of a design in which every length and angle of a made part deviates by `off(path)` tolerances.
///
/// Sizes of bought pieces and of the camera stay as their makers state them. A size of zero means that the feature is
/// absent, and stays zero. Values that are derived from others deviate on their own, as the feature made from them
/// does. `overrides` and `others` are as for [`load`](crate::load).
///
/// # Errors
/// Every problem of the design as drawn.
///
/// ```
/// use fabkit_designs::{SensorText, builtin_yaml, unit_dimensions::build_unit};
/// let text = SensorText::without_bases("rtac0.yaml", builtin_yaml("rtac0").ok_or("none")?);
/// // Every size comes out half a tolerance too large.
/// let (_, dimensions) = build_unit(text, &[], &["fixtures"], &|_| 0.5)?;
/// let wall = dimensions.iter().find(|one| one.path == "shell.wall").ok_or("no wall")?;
/// assert_eq!((wall.drawn, wall.tolerance, wall.built), (1.5, 0.1, 1.55));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn build_unit(
    text: SensorText,
    overrides: &[String],
    others: &[&str],
    off: &dyn Fn(&str) -> f64,
) -> Result<(Design, Vec<Dimension>), InvalidDesign> {
    let mine: Vec<String> = crate::fixing::sensor_overrides(overrides, others);
    let drawn = REGISTRY.load_text(text, &mine, others)?;
    let trial = REGISTRY.trial(text, &mine, others)?;
    let numbers: Vec<NumericParameter> = trial.numbers().into_iter().filter(is_made).collect();
    let mut dimensions: Vec<Dimension> =
        numbers.iter().filter_map(|number| dimension(number, off(&number.path))).collect();
    let lot = DeviationTrial { trial: &trial, text, set: &mine, others, drawn: &drawn };
    let kept = lot.add_buildable(ValueTexts::new(), &dimensions);
    // Sizes whose deviation had to be dropped stay as drawn.
    for dimension in dimensions.iter_mut().filter(|one| !kept.contains_key(&one.path)) {
        dimension.built = dimension.drawn;
    }
    let built = if kept.is_empty() { drawn } else { lot.built(&kept)? };
    Ok((built, dimensions))
}

/// Values by path, as text with unit, as a file would hold them.
type ValueTexts = BTreeMap<String, String>;

/// Returns whether a number is the size of a made feature that is present.
fn is_made(number: &NumericParameter) -> bool {
    let is_size = matches!(number.kind, ValueKind::Length | ValueKind::Angle);
    let is_there = number.value.is_some_and(|value| value != 0.0);
    is_size && is_there && !is_bought(&number.path) && !number.path.starts_with("camera.")
}

/// Returns the deviating dimension of a number, `off` tolerances from its value.
fn dimension(number: &NumericParameter, off: f64) -> Option<Dimension> {
    let drawn = number.value?;
    let tolerance = number.tolerance.or(usual_tolerance(number.kind, drawn))?;
    // Rounded to a tenth of a micrometre, finer than anybody measures.
    let built = (1e4 * (drawn + off * tolerance)).round() / 1e4;
    let [least, most] = number.range;
    Some(Dimension {
        path: number.path.clone(),
        unit: if number.kind == ValueKind::Angle { "deg" } else { "mm" },
        drawn,
        built: built.clamp(least, most),
        tolerance,
        is_stated: number.tolerance.is_some(),
    })
}

/// Design that random deviations of sizes have to be compatible with.
struct DeviationTrial<'a> {
    trial: &'a Trial,
    text: SensorText<'a>,
    set: &'a [String],
    others: &'a [&'a str],
    drawn: &'a Design,
}

impl DeviationTrial<'_> {
    /// Adds as many of the dimensions to `kept` as the design allows: all of them, or else as many as possible of each
    /// half, down to single ones.
    fn add_buildable(&self, kept: ValueTexts, dimensions: &[Dimension]) -> ValueTexts {
        let sizes =
            dimensions.iter().map(|one| (one.path.clone(), format!("{} {}", one.built, one.unit)));
        let with: ValueTexts = kept.clone().into_iter().chain(sizes).collect();
        if self.is_buildable(&with) {
            return with;
        }
        match dimensions {
            [] | [_] => kept,
            all => {
                // One bad deviation should not discard the others: bisect down to single sizes.
                let (first, rest) = all.split_at(all.len() / 2);
                self.add_buildable(self.add_buildable(kept, first), rest)
            }
        }
    }

    /// Returns whether the sizes break no rule and keep every piece of the drawing. A pattern that fills the available
    /// space could otherwise have another number of pins in a ring from unit to unit.
    fn is_buildable(&self, sizes: &ValueTexts) -> bool {
        self.trial.evaluate(sizes, &[]).0.is_clean()
            && self.built(sizes).is_ok_and(|built| has_same_pieces(self.drawn, &built))
    }

    /// Builds the design with deviating sizes.
    fn built(&self, sizes: &ValueTexts) -> Result<Design, InvalidDesign> {
        // The deviating value replaces an override of the same path: no path may be set twice.
        let path = |set: &str| set.split_once('=').map_or("", |(path, _)| path.trim()).to_owned();
        let set = self.set.iter().filter(|set| !sizes.contains_key(&path(set))).cloned();
        let built = sizes.iter().map(|(path, text)| format!("{path}={text}"));
        REGISTRY.load_text(self.text, &set.chain(built).collect::<Vec<_>>(), self.others)
    }
}

/// Returns whether both designs have the same bodies in the same numbers, and each marker is closer to its own place in
/// the drawing than to that of any other marker.
fn has_same_pieces(drawn: &Design, built: &Design) -> bool {
    let bodies = |design: &Design| -> Vec<(String, usize)> {
        let bodies = design.sensor.bodies.iter();
        bodies.map(|body| (body.name.clone(), body.placements.len())).collect()
    };
    let (was, is) = (&drawn.sensor.marks, &built.sensor.marks);
    let is_at_its_own = |(own, mark): (&Marker, &Marker)| {
        let away = |other: &Marker| (other.point - mark.point).norm_squared();
        own.name == mark.name && was.iter().all(|other| away(own) <= away(other))
    };
    bodies(drawn) == bodies(built) && was.len() == is.len() && was.iter().zip(is).all(is_at_its_own)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From -1 to 1, evenly, by a path and a number.
    fn lot(path: &str, seed: u64) -> f64 {
        let hash = path
            .bytes()
            .fold(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0xcbf2_9ce4, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            });
        2.0 * (hash >> 11) as f64 / (1_u64 << 53) as f64 - 1.0
    }

    #[test]
    fn units_of_all_sensors_build_with_deviations() {
        for name in crate::builtin_names() {
            let yaml = crate::builtin_yaml(name).unwrap();
            let text = SensorText::without_bases(name, yaml);
            let (mut sizes, mut off) = (0, 0);
            let drawn = REGISTRY.load_text(text, &[], &["fixtures"]).unwrap();
            for seed in 0..3 {
                let built = build_unit(text, &[], &["fixtures"], &|path| lot(path, seed));
                let (design, dimensions) =
                    built.unwrap_or_else(|error| panic!("{name}: {error:?}"));
                assert!(has_same_pieces(&drawn, &design) && dimensions.len() > 20, "{name}");
                for one in &dimensions {
                    assert!((one.built - one.drawn).abs() <= one.tolerance + 1e-4, "{one:?}");
                    sizes += 1;
                    off += usize::from(one.built != one.drawn);
                }
            }
            assert!(4 * off > 3 * sizes, "{name}: {off} of {sizes}");
        }
    }

    #[test]
    fn stated_tolerance_overrides_default() {
        let yaml =
            "format: 1\nextends: rtac0\nsurface:\n  radius: {value: 15 mm, tolerance: 0.01 mm}\n";
        let of = |off: f64| {
            let text = SensorText::without_bases("mine.yaml", yaml);
            let (design, dimensions) =
                build_unit(text, &["shell.wall=1.6 mm".into()], &["fixtures"], &|_| off).unwrap();
            let size = |path: &str| dimensions.iter().find(|one| one.path == path).unwrap().clone();
            (design, size("surface.radius"), size("translucent_gel.thickness"), size("shell.wall"))
        };
        let (design, radius, thickness, wall) = of(0.5);
        assert_eq!((radius.built, radius.tolerance, radius.is_stated), (15.005, 0.01, true));
        assert_eq!((thickness.built, thickness.tolerance, thickness.is_stated), (1.55, 0.1, false));
        assert_eq!((wall.drawn, wall.built), (1.6, 1.65));
        let touch = design.sensor.touch.unwrap();
        let drawn = of(0.0).0.sensor.touch.unwrap();
        assert!(touch != drawn);
    }
}
