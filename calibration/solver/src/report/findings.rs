//! Findings of an extrinsic calibration in plain words.

use fabkit_camera::{Camera, Interface};

use super::ExtrinsicsReport;
use crate::assignment::Discrepancy;
use crate::drawn_interface::{INDEX_SIGMA, PLACE_SIGMA_MM};
use crate::extrinsics::{Medium, ParameterSet, Trial};
use crate::model::FitParameter;

/// Ratio of the residuals to what pins and images explain above which the model is reported as incomplete.
const MISFIT: f64 = 1.3;
/// Ratio of the halves' difference to its expected value above which it is reported.
const MAX_HALVES_RATIO: f64 = 2.5;
/// Influence of a single capture on the surface, relative to an equal share, above which it is reported.
const INFLUENTIAL: f64 = 4.0;
/// Fraction of lit pixels that are saturated above which a warning is given, because marks are often cut. Of 32
/// simulated units the two with more than a fifth were calibrated wrongly, and one with a sixth was not.
const MAX_SATURATED_FRACTION: f64 = 0.1;
/// Number of outlying pins that warnings name, the farthest first; the report lists all.
const MAX_NAMED_OUTLIERS: usize = 5;
/// Smallest number of pins for a reliable choice of the model.
const FEW_PINS: usize = 25;
/// Number of standard deviations from the drawing at which a fit is reported to be at the end of its prior.
const MAX_DRAWN_SIGMAS: f64 = 2.5;
/// Decrease of Akaike's criterion that is strong evidence.
const STRONG_AICC_EVIDENCE: f64 = 10.0;
/// Number of prior standard deviations beyond which the light is reported as unlikely: the rendering does not cover
/// such light, and one in twenty units has it.
const MAX_LIGHT_SIGMAS: f64 = 2.0;

impl ExtrinsicsReport<'_> {
    /// Lists the differences between captures and their labels, one sentence each.
    pub fn discrepancy_sentences(&self) -> Vec<String> {
        self.discrepancies.iter().map(|doubt| self.discrepancy_sentence(doubt)).collect()
    }

    /// Lists what the person who took the images should know before using the result.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.discrepancy_sentences();
        warnings.extend(self.drawing_unused_reason.map(str::to_owned));
        warnings.extend(
            self.mark_offsets_unknown_reason.map(|why| {
                format!("The distance of marks from the pins' tips is not known: {why}.")
            }),
        );
        if self.saturated_fraction > MAX_SATURATED_FRACTION {
            warnings.push(format!(
                "Up to {:.0} % of the lit pixels are saturated, so marks there are cut and misplaced. Take the captures darker.",
                100.0 * self.saturated_fraction
            ));
        }
        for record in self.captures {
            let missing = record.pins_expected.unwrap_or(0).saturating_sub(record.pins_found);
            if missing > 0 && record.left_out.count > 0 {
                warnings.push(format!(
                    "{}: {} of {} pins are found, and {}. Press the others as deep, or take the image with less noise.",
                    record.file,
                    record.pins_found,
                    record.pins_found + missing,
                    record.left_out
                ));
            }
        }
        let calibration = self.calibration;
        let chosen = self.chosen();
        let differs: Vec<String> = chosen
            .differences_beyond_tolerance()
            .map(|d| format!("{} by {:+.3} ({:.1} sigma)", d.name, d.deviation, d.sigmas()))
            .collect();
        if !differs.is_empty() {
            warnings.push(format!(
                "The unit differs from the drawing in {}. Either its parts or landmarks differ, or the fit explains something else by this.",
                differs.join(", ")
            ));
        }
        if !calibration.selection.is_seating_observable {
            warnings.push(
                "The seating offset is not observable with these pins: with pins of one length it looks like another distance of the camera, which is only as accurate as the pins' lengths. Add pins of a second length."
                    .into(),
            );
        }
        if calibration.given.covariance().is_none() {
            warnings.push(format!(
                "{} states no covariance: the lens counts as exact, and the pose as more certain than it is. `fabkit calibrate intrinsics` writes cameras with one.",
                self.camera_file
            ));
        }
        for unknown in chosen.unobservable.iter().filter(|u| {
            // That the seats of all captures together act like the pose is expected, and so is that the drawing
            // determines the drawn parameters.
            let is_reseating = |p: &FitParameter| matches!(p, FitParameter::Reseating(..));
            !u.terms.iter().all(|(p, _)| is_reseating(p) || chosen.fit.model.has_drawing_prior(*p))
        }) {
            let names: Vec<String> = unknown.terms.iter().map(|(p, _)| p.description()).collect();
            warnings.push(format!(
                "The pins hardly tell {} apart: prior assumptions make up {:.0} % of the remaining uncertainty.",
                names.join(" and "),
                100.0 * unknown.remaining
            ));
        }
        if let Some(distance_mm) = chosen.from_design_mm.filter(|_| !chosen.is_position_plausible())
        {
            warnings.push(format!(
                "The fitted camera is {distance_mm:.1} mm from its place in the design. Assembly does not explain this; the fit explains something else by it."
            ));
        }
        let model = &chosen.fit.model;
        let drawn = chosen.fit.parameters.iter().filter(|p| model.has_drawing_prior(**p));
        for (parameter, (away, known)) in drawn.filter_map(|p| Some((p, model.prior(*p)?))) {
            if away.abs() > MAX_DRAWN_SIGMAS * known {
                warnings.push(format!(
                    "The fit contradicts the drawing: {} differs by {away:+.3}, {:.1} times the tolerance of molds, prints and data sheets. The unit differs, or the fit explains something else by it.",
                    parameter.description(),
                    away.abs() / known
                ));
            }
        }
        let checks = &calibration.checks;
        if let Some(halves_mm) =
            checks.halves_mm.filter(|mm| *mm > MAX_HALVES_RATIO * checks.halves_expected_mm())
            && checks.sigma_mm > 0.0
        {
            warnings.push(format!(
                "Fits to every other capture and to the rest differ by {halves_mm:.3} mm on the surface; {:.3} mm are expected: something changes between captures.",
                checks.halves_expected_mm()
            ));
        }
        let residuals = chosen.fit.residuals_px(&calibration.observations);
        for (observation, sigmas) in checks.outliers.iter().take(MAX_NAMED_OUTLIERS) {
            let pin = &calibration.observations[*observation];
            let file = self.captures.get(pin.contact.capture).map_or("?", |record| &record.file);
            let off_px = residuals[*observation].map_or(f64::NAN, |residual| residual.norm());
            warnings.push(format!(
                "{file}: the mark of the pin in hole {} is {off_px:.1} px ({sigmas:.1} sigma) from its expected place: look at it.",
                pin.contact.hole
            ));
        }
        for (capture, record) in self.captures.iter().enumerate() {
            let moved_mm = checks.without_mm.get(capture).copied().flatten();
            if let Some((moved_mm, times)) = moved_mm.zip(checks.influence(capture))
                && times > INFLUENTIAL
            {
                warnings.push(format!(
                    "{} alone moves the surface by {moved_mm:.3} mm, {times:.1} times as much as one capture of {} should: \
                     look at it.",
                    record.file,
                    self.captures.len()
                ));
            }
        }
        if calibration.misfit > MISFIT {
            warnings.push(format!(
                "Residuals are {:.1} times those by the pins' play and the images' noise: the model lacks something. The covariance is enlarged accordingly.",
                calibration.misfit
            ));
        }
        let pins = calibration.observations.len();
        if pins < FEW_PINS {
            warnings.push(format!(
                "Only {pins} pins: press more holes, and some of them again, before believing the \
                 choice of model."
            ));
        }
        if calibration.scatter.is_none() {
            warnings.push(
                "No hole has a pin in two captures: the repeatability of pins is not known, and standard deviations rest on noise and residuals alone."
                    .into(),
            );
        }
        if self.captures.len() < 3 {
            warnings.push("With fewer than three captures, held-out errors mean little.".into());
        }
        warnings
    }

    /// Explains the choice, and what the other explanations say about causes.
    pub fn explanation(&self) -> Vec<String> {
        let chosen = self.chosen();
        let plain = match self.calibration.plain_trial() {
            Some(plain) => format!("has {:.2} px ({:.2} px).", plain.held_out_rms_px, plain.rms_px),
            None => "could not be fitted.".into(),
        };
        let mut text = vec![format!(
            "Chosen: {}, with {:.2} px rms on captures that were left out ({:.2} px on its own). \
             The plain model, pose alone with the camera as calibrated in air, {plain}",
            chosen.candidate, chosen.held_out_rms_px, chosen.rms_px,
        )];
        let failed = &self.calibration.selection.failed;
        if !failed.is_empty() {
            let each = failed.iter().map(|(candidate, error)| format!("{candidate}: {error}"));
            text.push(format!(
                "Could not be fitted, and took no part in the choice: {}.",
                each.collect::<Vec<_>>().join("; ")
            ));
        }
        if let Some(scatter) = self.calibration.scatter {
            text.push(format!(
                "Repeated presses of a pin scatter by {:.2} px rms around their mean ({} degrees of \
                 freedom). No model can do better on new captures; the chosen one is at {:.2} \
                 times that.",
                scatter.rms_px,
                scatter.degrees_of_freedom,
                chosen.held_out_rms_px / scatter.rms_px
            ));
        }
        text.extend(self.about_optics());
        text.extend(self.about_light());
        if let Some(lean) = self.value_and_sigma(FitParameter::Lean) {
            text.push(format!(
                "All pins lean the same way round the sensor's axis, by {:.2} ± {:.2} mm at the tip. No lens does that; a dome turned a little while its pins stick to the surface does.",
                lean.0, lean.1
            ));
        }
        if let Some(offset) = self.value_and_sigma(FitParameter::SeatingOffset) {
            text.push(format!(
                "All pins go in {:.2} ± {:.2} mm farther than designed.",
                offset.0, offset.1
            ));
        }
        text
    }

    /// Describes what the explanations with and without refraction and radial terms say about the cause.
    fn about_optics(&self) -> Vec<String> {
        let mut text = self.about_drawing();
        let given = self.trial_with_optics(Medium::Given, 0);
        let gel = self.trial_with_optics(Medium::Gel(0.0), 0);
        if let (Some(given), Some(gel)) = (given, gel) {
            let distance = gel_distance(gel);
            let verdict = if gel.aicc < given.aicc - STRONG_AICC_EVIDENCE {
                "support"
            } else {
                "do not need"
            };
            text.push(format!(
                "The data {verdict} refraction: a flat surface of gel {distance} before the lens takes the held-out error from {:.2} px to {:.2} px and puts the camera {} from the design.",
                given.held_out_rms_px,
                gel.held_out_rms_px,
                distance_from_design(gel)
            ));
        }
        if let Some(radial) = self.best_radial(Medium::Given) {
            text.push(format!(
                "Radial terms of the lens alone ({}) reach {:.2} px, with the camera {} from the \
                 design.",
                radial.candidate,
                radial.held_out_rms_px,
                distance_from_design(radial)
            ));
            if let Some(both) = self.best_radial(Medium::Gel(0.0)) {
                let gain = radial.aicc - both.aicc;
                let verdict = if gain > STRONG_AICC_EVIDENCE { "strong" } else { "no strong" };
                text.push(format!(
                    "Gel and radial terms together ({}) reach {:.2} px: {verdict} evidence for \
                     refraction beside them (Akaike's criterion differs by {gain:.0}).",
                    both.candidate, both.held_out_rms_px
                ));
            }
        }
        text
    }

    /// Describes what the drawn bodies explain, alone and compared with the choice.
    fn about_drawing(&self) -> Vec<String> {
        let Some(drawn) = self.trial_with_optics(Medium::Drawn, 0) else { return Vec::new() };
        let radial = self.best_radial(Medium::Drawn);
        let with_terms = radial.map_or_else(String::new, |radial| {
            format!("; with radial terms ({}) {:.2} px", radial.candidate, radial.held_out_rms_px)
        });
        let mut text = vec![format!(
            "The bodies as drawn reach {:.2} px on captures that were left out{with_terms}, with the camera {} \
             from the design.",
            drawn.held_out_rms_px,
            distance_from_design(drawn)
        )];
        let chosen = self.chosen();
        if chosen.candidate.optics.medium != Medium::Drawn {
            text.push(format!(
                "This unit differs from the drawing between lens and pins: {} predicts better by {:.0} %, more than chance and lens terms explain.",
                chosen.candidate,
                100.0 * (1.0 - chosen.held_out_rms_px / drawn.held_out_rms_px.min(
                    radial.map_or(f64::INFINITY, |radial| radial.held_out_rms_px)
                ))
            ));
        }
        let shift = self.value_and_sigma(FitParameter::InterfaceShift);
        let index = self.value_and_sigma(FitParameter::Camera("interface_index_outside"));
        if let (Some((shift_mm, sigma_mm)), Some((index, of_index))) = (shift, index) {
            text.push(format!(
                "The first face lies {shift_mm:+.3} ± {sigma_mm:.3} mm farther from the lens than drawn (prior ± {PLACE_SIGMA_MM}); the index behind it is {index:.4} ± {of_index:.4} (prior ± {INDEX_SIGMA})."
            ));
        }
        text
    }

    /// Describes what the marks say about the light.
    fn about_light(&self) -> Option<String> {
        let [scatter, spread] = FitParameter::LIGHT;
        let (scatter_log, of_scatter) = self.value_and_sigma(scatter)?;
        let (wider_mm, of_spread) = self.value_and_sigma(spread)?;
        let known = [scatter, spread].map(FitParameter::prior_sigma);
        let mut text = format!(
            "Marks look as if the layer scattered {:.2} times as much as assumed (within a factor of {:.2}, prior {:.2}) and spread light {wider_mm:+.3} ± {of_spread:.3} mm farther (prior ± {}).",
            scatter_log.exp(),
            of_scatter.exp(),
            known[0].exp(),
            known[1]
        );
        let far = (scatter_log / known[0]).abs().max((wider_mm / known[1]).abs());
        if far > MAX_LIGHT_SIGMAS {
            text += " Light alone is not likely to do that: something else moves marks as well.";
        }
        Some(text)
    }

    /// Finds the trial that differs from the chosen one only by medium and radial terms.
    fn trial_with_optics(&self, medium: Medium, radial_terms: usize) -> Option<&Trial> {
        let chosen = self.chosen().candidate;
        self.calibration.selection.trials.iter().find(|trial| {
            let optics = trial.candidate.optics;
            trial.candidate == ParameterSet { optics, ..chosen }
                // The index of [`Medium::Gel`] does not matter here, only its kind.
                && std::mem::discriminant(&optics.medium) == std::mem::discriminant(&medium)
                && optics.radial_terms == radial_terms
        })
    }

    /// Finds the best trial with radial terms, by Akaike's criterion.
    fn best_radial(&self, medium: Medium) -> Option<&Trial> {
        let radial = (1..=3).filter_map(|terms| self.trial_with_optics(medium, terms));
        radial.min_by(|a, b| a.aicc.total_cmp(&b.aicc))
    }

    /// Returns the value of a parameter in the chosen fit and its standard deviation.
    pub(super) fn value_and_sigma(&self, parameter: FitParameter) -> Option<(f64, f64)> {
        let fit = &self.chosen().fit;
        let at = fit.parameters.iter().position(|found| *found == parameter)?;
        let sigma = self.calibration.covariance[(at, at)].max(0.0).sqrt();
        if parameter == FitParameter::FocalScale {
            let fx_px = |camera: &Camera| camera.lens().intrinsics().fx_px;
            let ratio = fx_px(&fit.model.camera) / fx_px(self.calibration.given.camera());
            // The fit's parameter is a step relative to the fitted focal length; reported is the ratio to the given
            // one.
            return Some((ratio - 1.0, ratio * sigma));
        }
        Some((fit.model.value(parameter)?, sigma))
    }

    /// Describes a difference between a capture and its label in one sentence.
    fn discrepancy_sentence(&self, doubt: &Discrepancy) -> String {
        let file =
            |capture: usize| self.captures.get(capture).map_or("?", |record| record.file.as_str());
        match doubt {
            Discrepancy::Missing { capture, hole } => {
                format!("{}: no mark of the pin in hole {hole}.", file(*capture))
            }
            Discrepancy::Spurious { capture, pixel } => format!(
                "{}: the mark at ({:.0}, {:.0}) px belongs to no hole of the label and was left out.",
                file(*capture),
                pixel.x,
                pixel.y
            ),
            Discrepancy::Mislabelled { capture, labelled, found } => format!(
                "{}: the label says hole {labelled}, but the mark is at hole {found}; it was left \
                 out.",
                file(*capture)
            ),
        }
    }
}

/// Describes the distance of the gel's surface, and whether it was fixed.
fn gel_distance(trial: &Trial) -> String {
    let Interface::Flat(flat) = trial.fit.model.camera.interface() else { return String::new() };
    let distance = format!("{:.1} mm", flat.distance_mm);
    if trial.fit.parameters.contains(&FitParameter::Camera("interface_distance_mm")) {
        return distance;
    }
    format!(
        "{distance} (held there: farther would fit better still, but the pins are in the way; what \
         bends the light is not quite a flat surface)"
    )
}

fn distance_from_design(trial: &Trial) -> String {
    trial.from_design_mm.map_or("an unknown way".into(), |distance| format!("{distance:.1} mm"))
}
