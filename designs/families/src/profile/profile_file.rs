//! Reading and writing of profile files.

use std::fmt::Write as _;

use fabkit_text::{Dialect, InvalidDesign, TextLayer, TextPlace, read_section};

use super::{DiameterFit, ProcessProfile};

/// Dialect of profile files.
const PROFILE: Dialect = Dialect::new("profile", 1, " and `name: NAME`");

impl ProcessProfile {
    /// Reads a profile; `file` names the text in messages.
    ///
    /// # Errors
    /// Every problem, each with place, value, limit and a hint.
    pub fn read(file: &str, yaml: &str) -> Result<Self, InvalidDesign> {
        read_section(yaml, &TextPlace::new(TextLayer::File, file, &PROFILE))
    }

    /// Formats a file that [`ProcessProfile::read`] reads; the comment lines precede the values.
    pub fn to_yaml(&self, comments: &[String]) -> String {
        let mut yaml = String::new();
        for comment in comments {
            let _ = writeln!(yaml, "# {comment}");
        }
        let [x, y, z] =
            [self.shrinkage_percent.x, self.shrinkage_percent.y, self.shrinkage_percent.z]
                .map(|percent| rounded(percent, 4));
        let fit = |fit: &DiameterFit| {
            format!(
                "{{offset: {} mm, gain: {}, smallest: {}, largest: {}}}",
                rounded(fit.offset.mm(), 4),
                rounded(fit.gain, 6),
                fit.smallest,
                fit.largest
            )
        };
        // A string in double quotes, as in JSON, is valid YAML.
        let material = serde_json::Value::from(self.material.as_str());
        let _ = write!(
            yaml,
            "format: 1\nname: {}\nprocess: {}\nmaterial: {material}\n\
             shrinkage_percent: {{x: {x}, y: {y}, z: {z}}}\nholes: {}\npins: {}\n\
             elephant_foot: {} mm\n",
            self.name.as_str(),
            self.process.word(),
            fit(&self.holes),
            fit(&self.pins),
            rounded(self.elephant_foot.mm(), 4),
        );
        yaml
    }
}

/// Rounds to digits that a measurement supports; adding zero avoids `-0`.
fn rounded(value: f64, digits: i32) -> f64 {
    let unit = 10f64.powi(digits);
    (value * unit).round() / unit + 0.0
}
