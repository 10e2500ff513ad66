//! Gerber X2 (Ucamco's Gerber layer format specification) and XNC drill files.
//!
//! Attributes are written as the standard comments for readers that do not know attributes (5.1.1 of the
//! specification), because gerbv warns of each `%TF` otherwise.
//!
//! Coordinates are those of the sensor's x and y, in mm with six decimals, seen from above on all layers.

use std::fmt::Write;

use fabkit_geometry::{BoardSide, Path, Segment};

use crate::shapes::{Point, Shape};

/// Fixed creation date. Files do not contain the time at which they were made, so the same board gives the same
/// bytes.
pub(crate) const DATE: &str = "2000-01-01T00:00:00Z";

/// Identity of a project.
#[derive(Clone, Debug)]
pub(crate) struct Project<'a> {
    /// Name of the board.
    pub name: &'a str,
    /// GUID, derived from the design's hash.
    pub guid: String,
    /// First digits of the design's hash.
    pub revision: String,
}

impl<'a> Project<'a> {
    pub fn new(name: &'a str, design_hash: &str) -> Self {
        let digits: String = design_hash.chars().chain(std::iter::repeat('0')).take(32).collect();
        let [a, b, c, d] = [0..8, 8..12, 12..16, 16..20].map(|range| &digits[range]);
        let guid = format!("{a}-{b}-{c}-{d}-{}", &digits[20..]);
        Self { name, guid, revision: digits[..8].to_owned() }
    }
}

/// Converts a length to the format's integers: millionths of a millimetre.
fn units(mm: f64) -> i64 {
    (mm * 1e6).round() as i64
}

/// Formats a decimal number without superfluous digits.
fn number(mm: f64) -> String {
    let text = format!("{:.6}", mm);
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Gerber layer that is being written.
pub(crate) struct GerberLayer {
    text: String,
    /// Apertures that are already defined, by template and function.
    apertures: Vec<(String, String)>,
    attributes: Vec<String>,
    current: Option<usize>,
}

impl GerberLayer {
    pub fn new(project: &Project<'_>, function: &str, polarity: &str) -> Self {
        let mut text = String::new();
        let Project { name, guid, revision } = project;
        for attribute in [
            format!("GenerationSoftware,fabkit,fabkit,{}", env!("CARGO_PKG_VERSION")),
            format!("CreationDate,{DATE}"),
            format!("ProjectId,{name},{guid},{revision}"),
            "SameCoordinates,sensor".to_owned(),
            format!("FileFunction,{function}"),
            format!("FilePolarity,{polarity}"),
        ] {
            _ = writeln!(text, "G04 #@! TF.{attribute}*");
        }
        // 4.6 format in mm, dark polarity, linear and multi-quadrant interpolation.
        text += "%FSLAX46Y46*%\n%MOMM*%\n%LPD*%\nG01*\nG75*\n";
        Self { text, apertures: Vec::new(), attributes: Vec::new(), current: None }
    }

    /// Selects an aperture with this function, and defines it first if it is new.
    fn select_aperture(&mut self, template: &str, function: &str) {
        let key = (template.to_owned(), function.to_owned());
        // The function is an attribute of the aperture, so equal templates with other functions are other apertures.
        let index = self.apertures.iter().position(|known| *known == key).unwrap_or_else(|| {
            // Aperture numbers start at 10 in the format.
            let number = self.apertures.len() + 10;
            _ = writeln!(self.text, "G04 #@! TA.AperFunction,{function}*");
            if let Some(corners) = template.strip_prefix("outline ") {
                _ = writeln!(
                    self.text,
                    "%AMOUTLINE{number}*{corners}*%\n%ADD{number}OUTLINE{number}*%"
                );
            } else {
                _ = writeln!(self.text, "%ADD{number}{template}*%");
            }
            self.text += "G04 #@! TD*\n";
            // `TD` has deleted the attributes of objects, too.
            self.attributes.clear();
            self.apertures.push(key);
            self.apertures.len() - 1
        });
        if self.current != Some(index) {
            self.current = Some(index);
            _ = writeln!(self.text, "D{}*", index + 10);
        }
    }

    /// Sets the attributes of the objects that follow.
    pub fn set_attributes(&mut self, attributes: &[String]) {
        if self.attributes == attributes {
            return;
        }
        if !self.attributes.is_empty() {
            self.text += "G04 #@! TD*\n";
        }
        for attribute in attributes {
            _ = writeln!(self.text, "G04 #@! TO.{attribute}*");
        }
        self.attributes = attributes.to_vec();
    }

    fn at(&mut self, [x, y]: Point, code: &str) {
        _ = writeln!(self.text, "X{}Y{}{code}*", units(x), units(y));
    }

    /// Draws a shape in one flash.
    pub fn flash(&mut self, shape: &Shape, function: &str, attributes: &[String]) {
        let middle = shape.centre();
        let template = match shape.corners() {
            [_] => format!("C,{}", number(2.0 * shape.radius_mm())),
            corners => {
                let mut text = format!("outline 4,1,{}", corners.len());
                for corner in corners.iter().chain(corners.first()) {
                    let [x, y] = [0, 1].map(|axis| number(corner[axis] - middle[axis]));
                    _ = write!(text, ",{x},{y}");
                }
                text + ",0"
            }
        };
        self.select_aperture(&template, function);
        self.set_attributes(attributes);
        self.at(middle, "D03");
    }

    /// Draws a straight line with round ends.
    pub fn line(&mut self, ends: [Point; 2], width_mm: f64, function: &str, attributes: &[String]) {
        self.select_aperture(&format!("C,{}", number(width_mm)), function);
        self.set_attributes(attributes);
        self.at(ends[0], "D02");
        self.at(ends[1], "D01");
    }

    /// Draws a closed path of lines and arcs, exactly.
    pub fn outline(&mut self, path: &Path) {
        self.select_aperture("C,0.05", "Profile");
        self.at(path.start, "D02");
        let mut from = path.start;
        for segment in &path.segments {
            if let Segment::Arc { to, centre, ccw } = segment {
                let [i, j] = [0, 1].map(|axis| units(centre[axis] - from[axis]));
                let code = format!("I{i}J{j}D01");
                self.text += if *ccw { "G03*\n" } else { "G02*\n" };
                self.at(*to, &code);
                self.text += "G01*\n";
            } else {
                self.at(segment.to(), "D01");
            }
            from = segment.to();
        }
    }

    pub fn finish(mut self) -> Vec<u8> {
        self.set_attributes(&[]);
        if self.apertures.is_empty() {
            // Without an aperture and a move (which draws nothing), readers doubt that this is a Gerber file.
            self.select_aperture("C,0.1", "Other,none");
            self.at([0.0; 2], "D02");
        }
        self.text += "M02*\n";
        self.text.into_bytes()
    }
}

/// Writes a drill file: tools by diameter, each with its holes in their order.
pub(crate) fn drill_file(project: &Project<'_>, function: &str, holes: &[(Point, f64)]) -> Vec<u8> {
    let mut tools: Vec<f64> = holes.iter().map(|(_, diameter)| *diameter).collect();
    tools.sort_by(f64::total_cmp);
    tools.dedup_by(|a, b| number(*a) == number(*b));
    let mut text = String::from("M48\n");
    let Project { name, guid, revision } = project;
    for attribute in [
        format!("GenerationSoftware,fabkit,fabkit,{}", env!("CARGO_PKG_VERSION")),
        format!("CreationDate,{DATE}"),
        format!("ProjectId,{name},{guid},{revision}"),
        format!("FileFunction,{function}"),
    ] {
        _ = writeln!(text, "; #@! TF.{attribute}");
    }
    text += "METRIC\n";
    for (index, tool) in tools.iter().enumerate() {
        _ = writeln!(text, "T{:02}C{:.3}", index + 1, tool);
    }
    text += "%\nG90\nG05\n";
    for (index, tool) in tools.iter().enumerate() {
        _ = writeln!(text, "T{:02}", index + 1);
        // Diameters are compared as they are written, so that rounding does not split a tool.
        for ([x, y], _) in holes.iter().filter(|(_, diameter)| number(*diameter) == number(*tool)) {
            _ = writeln!(text, "X{x:.4}Y{y:.4}");
        }
    }
    text += "M30\n";
    text.into_bytes()
}

/// Returns `Top` or `Bot`, as the format spells it.
pub(crate) fn side_word(side: BoardSide) -> &'static str {
    if side == BoardSide::Top { "Top" } else { "Bot" }
}

/// Replaces characters that may not stand in an attribute.
pub(crate) fn attribute_text(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_ascii_alphanumeric() || "+-_./ ".contains(c) { c } else { '_' })
        .collect()
}
