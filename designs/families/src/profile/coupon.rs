//! File of the printer coupon: designed sizes and calliper readings.

use std::fmt::Write as _;

use fabkit_geometry::Length;
use fabkit_text::{
    Dialect, FileSafeName, InvalidDesign, NodeReader, Position, Scalar, TextLayer, TextPlace,
    YamlContent, YamlEntry, YamlNode, read_mapping, suggestion, take_format, take_word,
    to_printable,
};

use super::{DiameterFit, LinearFit, PrintProcess, ProcessProfile, Shrinkage};

/// Group of sizes of one kind on a coupon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CouponGroup {
    /// Inside diameters.
    Holes,
    /// Outside diameters.
    Pins,
    /// Widths of slots.
    Slots,
    /// Thicknesses of walls.
    Walls,
    /// Diameters of hollows.
    Dimples,
    /// Lengths along the bed's x.
    LengthsX,
    /// Lengths along the bed's y.
    LengthsY,
    /// Heights above the bed.
    LengthsZ,
    /// Widths of the first layers along x.
    FootX,
    /// Widths of the first layers along y.
    FootY,
}

impl CouponGroup {
    /// All groups, in the order of the file.
    pub const ALL: [Self; 10] = [
        Self::LengthsX,
        Self::LengthsY,
        Self::LengthsZ,
        Self::Holes,
        Self::Pins,
        Self::FootX,
        Self::FootY,
        Self::Slots,
        Self::Walls,
        Self::Dimples,
    ];

    /// Returns the key in the file.
    pub fn key(self) -> &'static str {
        match self {
            Self::Holes => "holes",
            Self::Pins => "pins",
            Self::Slots => "slots",
            Self::Walls => "walls",
            Self::Dimples => "dimples",
            Self::LengthsX => "lengths_x",
            Self::LengthsY => "lengths_y",
            Self::LengthsZ => "lengths_z",
            Self::FootX => "foot_x",
            Self::FootY => "foot_y",
        }
    }

    /// Returns the comment above the group in the file.
    fn comment(self) -> &'static str {
        match self {
            Self::Holes => "inside diameters of the round holes; mean of two directions",
            Self::Pins => "outside diameters of the pins; mean of two directions",
            Self::Slots => "widths of the slots, with a feeler gauge; null where none opens",
            Self::Walls => "thicknesses of the walls; null where none stands",
            Self::Dimples => "diameters of the hollows; null where none shows",
            Self::LengthsX => "from the straight left edge to each step, above the first layers",
            Self::LengthsY => "from the straight front edge to each step, above the first layers",
            Self::LengthsZ => "from the bed's side to the top of each step of the tower",
            Self::FootX => "width of the lowest layers where they stick out left and right",
            Self::FootY => "width of the lowest layers where they stick out in front and behind",
        }
    }

    /// Returns the number of measured sizes that a profile needs.
    fn min_count(self) -> usize {
        match self {
            Self::Holes | Self::Pins | Self::LengthsX | Self::LengthsY | Self::LengthsZ => 3,
            Self::FootX | Self::FootY | Self::Slots | Self::Walls | Self::Dimples => 0,
        }
    }
}

/// Row of the file: one size on a coupon.
#[derive(Clone, Debug, PartialEq)]
pub struct CouponRow {
    /// Identifier, for example `H3`.
    pub id: String,
    /// Designed size, mm.
    pub nominal_mm: f64,
    /// Measured size, mm; `None` before the measurement.
    pub measured_mm: Option<f64>,
}

/// Sizes of a coupon.
///
/// ```
/// use fabkit_designs::profile::{Coupon, CouponGroup, CouponRow, PrintProcess};
/// let row = CouponRow { id: "H1".into(), nominal_mm: 4.0, measured_mm: None };
/// let coupon = Coupon {
///     process: PrintProcess::Fdm,
///     material: "PLA".into(),
///     groups: vec![(CouponGroup::Holes, vec![row])],
/// };
/// // The template that is filled in at the printer.
/// assert!(coupon.to_yaml().ends_with("\n  - {id: H1, nominal: 4 mm, measured: null}\n"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Coupon {
    /// Process that prints it.
    pub process: PrintProcess,
    /// Material that it is printed from.
    pub material: String,
    /// Rows of each group, in order.
    pub groups: Vec<(CouponGroup, Vec<CouponRow>)>,
}

impl Coupon {
    /// Formats the template file, which [`MeasuredProfile::read`] reads once it is filled in.
    pub fn to_yaml(&self) -> String {
        let mut yaml = String::from(
            "# Measure the printed coupon with a calliper and replace each null by the size with its\n\
             # unit, for example `measured: 3.87 mm`. What cannot be measured stays null.\n\
             # Then: fabkit profile coupon.yaml -o my-printer.yaml\n\
             format: 1\n",
        );
        let material = serde_json::Value::from(self.material.as_str());
        // Writing to a String cannot fail.
        let _ = writeln!(yaml, "process: {}\nmaterial: {material}", self.process.word());
        for (group, rows) in &self.groups {
            let _ = writeln!(yaml, "\n# {}\n{}:", group.comment(), group.key());
            for CouponRow { id, nominal_mm, measured_mm } in rows {
                let measured = measured_mm.map_or("null".to_owned(), |mm| format!("{mm} mm"));
                let _ = writeln!(
                    yaml,
                    "  - {{id: {id}, nominal: {nominal_mm} mm, measured: {measured}}}"
                );
            }
        }
        yaml
    }
}

/// Profile with the quality of its fits.
///
/// ```
/// use fabkit_designs::parameters::{FileSafeName, Scalar};
/// use fabkit_designs::profile::MeasuredProfile;
/// // Lengths come out 0.5 % too short, diameters as drawn.
/// let rows = |share: f64| {
///     let row = |mm: f64| format!("  - {{nominal: {mm} mm, measured: {} mm}}\n", share * mm);
///     [10.0, 20.0, 40.0].map(row).concat()
/// };
/// let lengths = ["x", "y", "z"].map(|axis| format!("lengths_{axis}:\n{}", rows(0.995))).concat();
/// let diameters = ["holes", "pins"].map(|kind| format!("{kind}:\n{}", rows(1.0))).concat();
/// let yaml = format!("format: 1\nprocess: fdm\nmaterial: PLA\n{lengths}{diameters}");
/// let name = FileSafeName::parse("my-printer").map_err(|refusal| refusal.says)?;
/// let profile = MeasuredProfile::read("coupon.yaml", &yaml, &name)?.profile;
/// assert!((profile.shrinkage_percent.x - 0.5).abs() < 1e-9);
/// assert!((profile.hole_mm(5.0) - 5.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredProfile {
    /// Resulting profile.
    pub profile: ProcessProfile,
    /// Fitted line of each group that has enough sizes.
    pub fits: Vec<(CouponGroup, LinearFit)>,
    /// Smallest nominal size of each group that could be measured, mm.
    pub smallest_mm: Vec<(CouponGroup, f64)>,
}

impl MeasuredProfile {
    /// Reads a filled-in coupon; `file` names the text in messages.
    ///
    /// # Errors
    /// Every problem: sizes without a unit or far from the designed ones, too few of them, one that lies off the line
    /// through the others.
    pub fn read(file: &str, yaml: &str, name: &FileSafeName) -> Result<Self, InvalidDesign> {
        let text = NodeReader::new(TextPlace::new(TextLayer::File, file, &COUPON));
        let mut sizes = Sizes { text, groups: Vec::new() };
        let measured = sizes.read(yaml, name);
        sizes.text.finish(measured)
    }
}

/// Largest plausible deviation of a measured size from the designed one, as a fraction plus an absolute part, mm.
/// Larger ones are taken for mistakes.
const PLAUSIBLE: (f64, f64) = (0.05, 1.0);
/// Largest distance of a size from the line through its group, mm.
const OFF_LINE_MM: f64 = 0.25;
/// Allowed range of a size, mm.
const SIZE_LIMITS_MM: std::ops::RangeInclusive<f64> = 0.05..=500.0;

/// Dialect of coupon files.
const COUPON: Dialect = Dialect::new("coupon", 1, " and `process: NAME`");

/// Measured row of a coupon.
struct Row {
    path: String,
    at: Position,
    nominal_mm: f64,
    measured_mm: f64,
}

/// Reader of measured sizes.
struct Sizes {
    text: NodeReader,
    groups: Vec<(CouponGroup, TextPlace, Vec<Row>)>,
}

impl Sizes {
    /// Reads the file and fits the profile.
    fn read(&mut self, yaml: &str, name: &FileSafeName) -> Option<MeasuredProfile> {
        let NodeReader { place, found } = &mut self.text;
        let mut entries = read_mapping(yaml, place, found)?;
        take_format(&mut entries, place, found);
        let process = self.word(&mut entries, "process", &PrintProcess::must_be(&()));
        let process = process
            .and_then(|(word, at)| self.text.read_value::<PrintProcess>(at, "process", &word, &()));
        let material = self.word(&mut entries, "material", "a name");
        for entry in entries {
            self.group(entry);
        }
        for group in CouponGroup::ALL {
            self.check_count(group);
        }
        // A line through wrong readings would blame the right ones.
        if !self.text.found.is_empty() {
            return None;
        }
        let measured = self.profile(name, process?, material?.0);
        let NodeReader { place, found } = &mut self.text;
        if measured.is_none() && found.is_empty() {
            found.push(place.problem("", "", "the sizes give no profile".into()));
        }
        measured
    }

    /// Takes a required word from the top level of the file.
    fn word(
        &mut self,
        entries: &mut Vec<YamlEntry>,
        key: &str,
        must_be: &str,
    ) -> Option<(String, Position)> {
        let NodeReader { place, found } = &mut self.text;
        let before = found.len();
        let word = take_word(entries, key, place, found);
        if word.is_none() && found.len() == before {
            let missing = place.problem(key, "", format!("the {key} is missing"));
            found.push(missing.hint(format!("write `{key}:` and {must_be}")));
        }
        word.and_then(|(word, at)| Some((word, at.position?)))
    }

    /// Reads the rows of a group.
    fn group(&mut self, entry: YamlEntry) {
        let YamlEntry { key, key_position, value } = entry;
        let Some(group) = CouponGroup::ALL.into_iter().find(|group| group.key() == key) else {
            let keys = CouponGroup::ALL.map(CouponGroup::key);
            let message = format!("`{}` is not a key of a coupon", to_printable(&key));
            let hint = suggestion(&key, keys, "the keys are");
            self.text.report_problem(key_position, &key, "", message, hint);
            return;
        };
        let items = match value.content {
            YamlContent::List(items) => items,
            YamlContent::Nothing => Vec::new(),
            _ => {
                let message = format!("{key} is not a list");
                let hint =
                    "write one line `- {id: ..., nominal: ..., measured: ...}` for each size";
                self.text.report_problem(key_position, &key, "", message, hint);
                return;
            }
        };
        let rows: Vec<Row> = items
            .into_iter()
            .enumerate()
            .filter_map(|(i, item)| self.row(&format!("{key}[{i}]"), item))
            .collect();
        self.groups.push((group, self.text.place.at(key_position), rows));
    }

    /// Reads a measured row; `None` for an empty row and after reporting a problem.
    fn row(&mut self, path: &str, item: YamlNode) -> Option<Row> {
        let YamlContent::Map(entries) = item.content else {
            let hint = "write `{id: ..., nominal: ..., measured: ...}`";
            self.text.report_problem(
                item.position,
                path,
                "",
                format!("{path} is not a size"),
                hint,
            );
            return None;
        };
        let (mut nominal, mut measured) = (None, None);
        let mut is_broken = false;
        for YamlEntry { key, key_position, value } in entries {
            let at = value.position;
            let path = format!("{path}.{}", to_printable(&key));
            match (key.as_str(), value.content) {
                // `id` is for people; null means not measured.
                ("id", _) | ("measured", YamlContent::Nothing) => {}
                ("nominal" | "measured", YamlContent::Scalar(text)) => {
                    match self.text.read_value::<Length>(at, &path, &text, &SIZE_LIMITS_MM) {
                        Some(size) if key == "nominal" => nominal = Some(size.mm()),
                        Some(size) => measured = Some((size.mm(), at, path)),
                        None => is_broken = true,
                    }
                }
                ("nominal" | "measured", _) => {
                    is_broken = true;
                    let message = format!("{path} is not a single value");
                    self.text.report_problem(at, &path, "", message, "write a size with its unit");
                }
                _ => {
                    let hint = suggestion(&key, ["id", "nominal", "measured"], "a size has");
                    let message = format!("`{}` is not known", to_printable(&key));
                    self.text.report_problem(key_position, &path, "", message, hint);
                }
            }
        }
        let Some(nominal_mm) = nominal else {
            if !is_broken {
                let message = format!("{path} has no nominal size");
                let hint = "write `nominal:` as in the file that came with the coupon";
                self.text.report_problem(item.position, path, "", message, hint);
            }
            return None;
        };
        // Rows that were not measured are skipped.
        let (measured_mm, at, path) = measured?;
        let (share, slack_mm) = PLAUSIBLE;
        let low_mm = ((1.0 - share) * nominal_mm - slack_mm).max(0.0);
        let high_mm = (1.0 + share) * nominal_mm + slack_mm;
        if !(low_mm..=high_mm).contains(&measured_mm) {
            let message = format!(
                "{path} is {measured_mm} mm; for {nominal_mm} mm it must be between {:.2} mm and \
                 {:.2} mm",
                low_mm, high_mm
            );
            let hint = "measure again, or write null if it did not come out";
            self.text.report_problem(at, &path, &format!("{measured_mm} mm"), message, hint);
            return None;
        }
        Some(Row { path, at, nominal_mm, measured_mm })
    }

    /// Reports a group with too few different sizes.
    fn check_count(&mut self, group: CouponGroup) {
        let (key, needed) = (group.key(), group.min_count());
        let rows = self.groups.iter().find(|(found, ..)| *found == group);
        let mut sizes: Vec<f64> =
            rows.iter().flat_map(|(_, _, rows)| rows).map(|row| row.nominal_mm).collect();
        sizes.sort_by(f64::total_cmp);
        // Repeated readings of one size do not define a line.
        sizes.dedup();
        if sizes.len() < needed {
            let place = rows.map_or(&self.text.place, |(_, place, _)| place);
            let message = format!(
                "{key} has {} measured sizes; a profile needs at least {needed}",
                sizes.len()
            );
            let found = place.problem(key, &sizes.len().to_string(), message);
            self.text
                .found
                .push(found.hint("replace null by what was measured, for example `3.87 mm`"));
        }
    }

    /// Returns the (nominal, measured) sizes of a group, mm.
    fn points(&self, group: CouponGroup) -> Vec<(f64, f64)> {
        let rows = self.groups.iter().filter(|(found, ..)| *found == group);
        rows.flat_map(|(_, _, rows)| rows).map(|row| (row.nominal_mm, row.measured_mm)).collect()
    }

    /// Fits the line of a group and reports the worst outlier.
    fn fit(&mut self, group: CouponGroup) -> Option<LinearFit> {
        let fit = LinearFit::fit(&self.points(group))?;
        let rows = self.groups.iter().filter(|(found, ..)| *found == group);
        let off = |row: &&Row| fit.residual_mm((row.nominal_mm, row.measured_mm)).abs();
        // A single wrong reading pulls the line away from all others, so only the worst one is named.
        let worst = rows.flat_map(|(_, _, rows)| rows).max_by(|a, b| off(a).total_cmp(&off(b)))?;
        let off_mm = off(&worst);
        if off_mm > OFF_LINE_MM {
            let message = format!(
                "{} is {} mm, which lies {off_mm:.2} mm off the line through all {}; it must be \
                 within {OFF_LINE_MM} mm",
                worst.path,
                worst.measured_mm,
                group.key()
            );
            let value = format!("{} mm", worst.measured_mm);
            let hint = "measure again, or write null to leave it out";
            let (at, path) = (worst.at, worst.path.clone());
            self.text.report_problem(at, &path, &value, message, hint);
        }
        Some(fit)
    }

    /// Computes the profile from all groups.
    fn profile(
        &mut self,
        name: &FileSafeName,
        process: PrintProcess,
        material: String,
    ) -> Option<MeasuredProfile> {
        use CouponGroup::*;
        let fits: Vec<(CouponGroup, LinearFit)> =
            [LengthsX, LengthsY, LengthsZ, Holes, Pins, Slots, Walls]
                .into_iter()
                .filter_map(|group| Some((group, self.fit(group)?)))
                .collect();
        let fit = |group| fits.iter().find(|(found, _)| *found == group).map(|(_, fit)| *fit);
        // The gain of lengths is 1 minus their shrinkage.
        let shrinkage = |group| Some(100.0 * (1.0 - fit(group)?.gain));
        let diameters = |group: CouponGroup| {
            let nominal: Vec<f64> = self.points(group).iter().map(|point| point.0).collect();
            let fit = fit(group)?;
            Some(DiameterFit {
                offset: Length::from_mm(fit.offset_mm)?,
                gain: fit.gain,
                smallest: Length::from_mm(nominal.iter().copied().fold(f64::INFINITY, f64::min))?,
                largest: Length::from_mm(nominal.iter().copied().fold(0.0, f64::max))?,
            })
        };
        // Excess of the lowest layers over the line of the lengths, halved for each of two sides.
        let feet: Vec<f64> = [(FootX, LengthsX), (FootY, LengthsY)]
            .into_iter()
            .filter_map(|(foot, lengths)| Some((self.points(foot), fit(lengths)?)))
            .flat_map(|(points, fit)| {
                points.into_iter().map(move |point| fit.residual_mm(point) / 2.0)
            })
            .collect();
        let foot_mm = feet.iter().sum::<f64>() / (feet.len() as f64).max(1.0);
        let smallest = |group| {
            let sizes = self.points(group).into_iter().map(|point| point.0);
            sizes.min_by(f64::total_cmp).map(|mm| (group, mm))
        };
        let profile = ProcessProfile {
            name: name.clone(),
            process,
            material,
            shrinkage_percent: Shrinkage {
                x: shrinkage(LengthsX)?,
                y: shrinkage(LengthsY)?,
                z: shrinkage(LengthsZ)?,
            },
            holes: diameters(Holes)?,
            pins: diameters(Pins)?,
            elephant_foot: Length::from_mm(foot_mm.max(0.0))?,
        };
        let smallest_mm = [Slots, Walls, Dimples].into_iter().filter_map(smallest).collect();
        Some(MeasuredProfile { profile, fits, smallest_mm })
    }
}
