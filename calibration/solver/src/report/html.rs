//! HTML report of an extrinsic calibration.

use std::fmt::Write;

use fabkit_report::{escape, page};

use super::maps::HoleRow;
use super::{ExtrinsicsReport, rms_px};
use crate::extrinsics::OUTLIER_SIGMAS;
use crate::model::FitParameter;

impl ExtrinsicsReport<'_> {
    /// Writes the report as one file without external resources.
    pub fn to_html(&self) -> String {
        let mut body = self.summary();
        let warnings = self.warnings();
        if !warnings.is_empty() {
            let _ = write!(
                body,
                "<h2>Warnings</h2>\n<div class=\"warnings\">{}</div>\n",
                Self::list(&warnings)
            );
        }
        // Writing to a string cannot fail, here and below.
        let _ = write!(
            body,
            "<h2>Fitted parameters and reasons</h2>\n{}",
            Self::list(&self.explanation())
        );
        body += &self.parameters_table();
        body += &self.trials_table();
        let _ = write!(
            body,
            "<h2>Residuals</h2>\n<figure>{}<figcaption>Red: observed minus projected.</figcaption>\
             </figure>\n<figure>{}</figure>\n<figure>{}<figcaption>Dashed: scatter of the same pin \
             pressed again, below which no model can go.</figcaption></figure>\n",
            self.residual_vectors(),
            self.residual_against_radius(),
            self.residual_against_hole()
        );
        body += &self.cross_checks();
        body += &self.captures_table();
        body += &self.repeatability_table();
        if let Some([pixel, depth]) = self.uncertainty_maps() {
            let _ = write!(
                body,
                "<h2>Uncertainty on the surface</h2>\n<div class=\"pair\"><figure>{pixel}</figure>\
                 <figure>{depth}</figure></div>\n<p>One standard deviation, on the sphere on which \
                 the pins touch, out to the outermost pins.</p>\n"
            );
        }
        page(&format!("Camera pose of {}", self.sensor), &body)
    }

    /// Writes the main figures and the pose.
    fn summary(&self) -> String {
        let chosen = self.chosen();
        let plain = self.calibration.plain_trial();
        let scatter = self.calibration.scatter;
        let rows = [
            (
                "captures, pins",
                format!("{}, {}", self.captures.len(), self.calibration.observations.len()),
            ),
            ("camera", self.camera_file.to_owned()),
            ("explanation chosen", chosen.candidate.to_string()),
            ("rms, fitted", px(chosen.rms_px)),
            ("rms, captures held out", px(chosen.held_out_rms_px)),
            (
                "rms, plain model, fitted and held out",
                plain.map_or("not fitted".into(), |plain| {
                    format!("{}, {}", px(plain.rms_px), px(plain.held_out_rms_px))
                }),
            ),
            ("scatter of the same pin", scatter.map_or("not known".into(), |s| px(s.rms_px))),
        ];
        let rows = rows
            .map(|(name, value)| format!("<tr><td>{name}</td><td>{}</td></tr>\n", escape(&value)));
        let matrix = self.matrix().map(|row| {
            let cells = row.map(|value| format!("<td>{value:.5}</td>")).concat();
            format!("<tr>{cells}</tr>\n")
        });
        format!(
            "<table>{}</table>\n<p><code>camera_from_sensor</code>, mm:</p>\n<table>{}</table>\n",
            rows.concat(),
            matrix.concat()
        )
    }

    /// Writes the fitted parameters.
    fn parameters_table(&self) -> String {
        let mut rows = String::new();
        for parameter in &self.chosen().fit.parameters {
            // Single values of dozens of seats say little.
            if matches!(parameter, FitParameter::Reseating(..)) {
                continue;
            }
            let (value, sigma) = self.value_and_sigma(*parameter).unwrap_or_default();
            let _ = writeln!(
                rows,
                "<tr><td>{parameter}</td><td>{value:.5}</td><td>{sigma:.5}</td></tr>"
            );
        }
        format!("<table><tr><th>fitted</th><th>value</th><th>sigma</th></tr>\n{rows}</table>\n")
    }

    /// Writes the explanations that were tried.
    fn trials_table(&self) -> String {
        let selection = &self.calibration.selection;
        let mut rows = String::new();
        for (i, trial) in selection.trials.iter().enumerate() {
            let class = if i == selection.chosen { " class=\"chosen\"" } else { "" };
            let away = trial.from_design_mm.map_or("".into(), |d| format!("{d:.1}"));
            let unknown = if trial.unobservable.is_empty() { "" } else { "not all" };
            let _ = writeln!(
                rows,
                "<tr{class}><td>{}</td><td>{}</td><td>{:.2}</td><td>{:.2}</td><td>{:.1}</td><td>{away}</td><td>{unknown}</td></tr>",
                trial.candidate,
                trial.fit.parameters.len(),
                trial.rms_px,
                trial.held_out_rms_px,
                trial.aicc
            );
        }
        for (candidate, error) in &selection.failed {
            let reason = escape(&error.to_string());
            let _ = writeln!(
                rows,
                "<tr><td>{candidate}</td><td colspan=\"6\">not fitted: {reason}</td></tr>"
            );
        }
        format!(
            "<table><tr><th>tried</th><th>parameters</th><th>rms, px</th><th>held out, px</th>\
             <th>AICc</th><th>from the design, mm</th><th>observable</th></tr>\n{rows}</table>\n"
        )
    }

    /// Writes the captures with their errors.
    fn captures_table(&self) -> String {
        let mut rows = String::new();
        for (i, record) in self.captures.iter().enumerate() {
            let used = self.observations_of_capture(i).count();
            let fitted = rms_px(self.observations_of_capture(i).map(|(_, r, _)| r));
            let held_out = rms_px(self.observations_of_capture(i).map(|(.., held)| held));
            let expected = record.pins_expected.map_or("no label".into(), |n| n.to_string());
            let show = |value: Option<f64>| value.map_or("".into(), |v| format!("{v:.2}"));
            let checks = &self.calibration.checks;
            let without = checks.without_mm.get(i).copied().flatten();
            let without = without.map_or("".into(), |mm| format!("{mm:.3}"));
            let times = checks.influence(i).map_or("".into(), |times| format!("{times:.1}"));
            let _ = writeln!(
                rows,
                "<tr><td>{}</td><td>{expected}</td><td>{}</td><td>{used}</td><td>{}</td><td>{}</td><td>{without}</td>\
                 <td>{times}</td></tr>",
                escape(&record.file),
                record.pins_found,
                show(fitted),
                show(held_out)
            );
        }
        format!(
            "<h2>Captures</h2>\n<table><tr><th>file</th><th>pins labelled</th><th>marks found</th>\
             <th>used</th><th>rms, px</th><th>held out, px</th><th>surface without it, mm</th><th>times its share\
             </th></tr>\n{rows}</table>\n"
        )
    }

    /// Writes the comparison with other captures, and the outlying pins.
    fn cross_checks(&self) -> String {
        let checks = &self.calibration.checks;
        let mut text = "<h2>Cross-checks</h2>\n".to_owned();
        if checks.sigma_mm > 0.0 {
            let halves = match checks.halves_mm {
                Some(mm) => format!(
                    "Every other capture and the rest put it {mm:.3} mm apart; {:.3} mm are to be expected.",
                    checks.halves_expected_mm()
                ),
                None => "There are too few captures to compare halves of them.".to_owned(),
            };
            let _ = writeln!(
                text,
                "<p>Points of the surface, where pins touch, are known to {:.3} mm (1 sigma, root mean square) as far as \
                 pins and captures err. {halves}</p>",
                checks.sigma_mm
            );
        }
        let count = checks.outliers.len();
        if count == 0 {
            let _ = writeln!(text, "<p>No pin is farther off than {OUTLIER_SIGMAS} sigma.</p>");
            return text;
        }
        let _ = writeln!(
            text,
            "<p>{count} pins are farther off than {OUTLIER_SIGMAS} sigma; one in 450 is by chance. They count by their length, not \
             by its square.</p>"
        );
        let mut rows = String::new();
        for (observation, sigmas) in &checks.outliers {
            let pin = &self.calibration.observations[*observation];
            let file = self.captures.get(pin.contact.capture).map_or("", |record| &record.file);
            let _ = writeln!(
                rows,
                "<tr><td>{}</td><td>{}</td><td>{:.1}, {:.1}</td><td>{sigmas:.1}</td></tr>",
                escape(file),
                pin.contact.hole,
                pin.pixel.x,
                pin.pixel.y
            );
        }
        let _ = writeln!(
            text,
            "<table><tr><th>file</th><th>hole</th><th>seen at, px</th><th>sigma</th></tr>\n{rows}</table>"
        );
        let crops: String = self.crops.iter().filter_map(|crop| self.crop(crop)).collect();
        if !crops.is_empty() {
            let _ = writeln!(
                text,
                "<div class=\"pair\">{crops}</div>\n<p>Red: from where the model expects the mark to where it was found.</p>"
            );
        }
        text
    }

    /// Writes the repeatability of each hole.
    fn repeatability_table(&self) -> String {
        let mut rows = String::new();
        for row in self.repeatability() {
            let HoleRow { hole, pins, mean_residual_px: residual, scatter_px: scatter } = row;
            let scatter = scatter.map_or("".into(), |s| format!("{s:.2}"));
            let _ = writeln!(
                rows,
                "<tr><td>{hole}</td><td>{pins}</td><td>{:+.2}, {:+.2}</td><td>{scatter}</td></tr>",
                residual.x, residual.y
            );
        }
        format!(
            "<h2>Holes</h2>\n<table><tr><th>hole</th><th>pins</th><th>mean residual, px</th>\
             <th>scatter, px</th></tr>\n{rows}</table>\n"
        )
    }
}

fn px(value: f64) -> String {
    format!("{value:.2} px")
}
