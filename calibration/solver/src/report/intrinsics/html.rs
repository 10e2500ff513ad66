//! HTML report of an intrinsic calibration: one file that needs no network and can be printed.

use std::fmt::Write;

use fabkit_report::{
    NO_DATA_STYLE, Plot, RESIDUAL_STYLE, Svg, escape, heat_color, page, round_tick_step,
};
use nalgebra::Vector2;

use super::super::magnification;
use super::IntrinsicsReport;
use crate::intrinsics::{COVERAGE, CornerObservation, GRID};

/// Largest number of dots in a plot: more make it slow without showing more.
const MAX_DOTS: usize = 4000;

impl IntrinsicsReport<'_> {
    /// Writes the report as one file without external resources.
    pub fn to_html(&self) -> String {
        let mut body = self.summary();
        let warnings = self.warnings();
        if !warnings.is_empty() {
            let items = warnings.iter().map(|w| format!("<li>{}</li>\n", escape(w)));
            let items: String = items.collect();
            let _ = write!(
                body,
                "<h2>Warnings</h2>\n<div class=\"warnings\"><ul>\n{items}</ul></div>\n"
            );
        }
        body += &self.parameters_table();
        body += &self.models_table();
        let _ = write!(
            body,
            "<h2>Coverage and residuals</h2>\n<figure>{}<figcaption>Red: observed minus projected. \
             Orange cells hold no corner.</figcaption></figure>\n<figure>{}</figure>\n",
            self.image_map(),
            self.residual_against_angle()
        );
        if let Some(map) = self.uncertainty_map() {
            let _ = write!(
                body,
                "<h2>Uncertainty of rays</h2>\n<figure>{map}</figure>\n<p>One standard deviation of a point's pixel, from the corners' noise alone, extrapolated by the chosen lens model; white where that lens has no image.</p>\n"
            );
        }
        body += &self.views_table();
        page(&format!("Camera of {}", self.sensor), &body)
    }

    /// Writes the main figures.
    fn summary(&self) -> String {
        let calibration = self.calibration;
        let corners: usize = calibration.views.iter().map(|view| view.corners.len()).sum();
        let [focal_px, sigma_px] = calibration.focal_px;
        let coverage = &calibration.advice.coverage;
        let rows = [
            ("board", self.board.to_owned()),
            (
                "images, used, corners",
                format!("{}, {}, {corners}", self.images.len(), calibration.views.len()),
            ),
            ("lens model chosen", calibration.model.name().to_owned()),
            ("rms", format!("{:.3} px", calibration.rms_px)),
            (
                "residuals, in those the detector expects",
                format!("{:.2}", calibration.residual_scale),
            ),
            ("scale on the axis", format!("{focal_px:.3} ± {sigma_px:.3} px per radian")),
            (
                "farthest corner off the axis, of the image",
                format!(
                    "{:.1}° of {:.1}°",
                    coverage.observed_max_angle_deg, coverage.image_max_angle_deg
                ),
            ),
        ];
        let rows: String = rows
            .into_iter()
            .chain(self.rays().into_iter().map(|(name, value)| (name, format!("± {value}"))))
            .map(|(name, value)| format!("<tr><td>{name}</td><td>{}</td></tr>\n", escape(&value)))
            .collect();
        format!("<table>{rows}</table>\n")
    }

    /// Writes the camera's parameters.
    fn parameters_table(&self) -> String {
        let estimate = &self.calibration.estimate;
        let sigmas = estimate.sigmas().unwrap_or_default();
        let rows = estimate.camera().parameters().into_iter().zip(sigmas);
        let rows: String = rows
            .map(|((name, value), sigma)| {
                format!("<tr><td>{name}</td><td>{value:.6}</td><td>{sigma:.6}</td></tr>\n")
            })
            .collect();
        format!(
            "<h2>Parameters</h2>\n<table><tr><th>parameter</th><th>value</th><th>sigma</th></tr>\n\
             {rows}</table>\n<p>Parameters trade against each other; judge the uncertainty of rays instead.</p>\n"
        )
    }

    /// Writes the lens models that were tried.
    fn models_table(&self) -> String {
        let mut rows = String::new();
        for candidate in &self.calibration.candidates {
            let chosen = candidate.model == self.calibration.model;
            let class = if chosen { " class=\"chosen\"" } else { "" };
            let figures = candidate.fit.map_or(
                "<td colspan=\"3\">cannot see that far off its axis</td>".to_owned(),
                |fit| {
                    let held_out = if fit.held_out_rms_px.is_finite() {
                        format!("{:.4}", fit.held_out_rms_px)
                    } else {
                        "not determined".into()
                    };
                    let (rms, criterion) = (fit.rms_px, fit.criterion);
                    format!("<td>{rms:.4}</td><td>{held_out}</td><td>{criterion:.1}</td>")
                },
            );
            let _ = writeln!(
                rows,
                "<tr{class}><td>{}</td><td>{}</td>{figures}</tr>",
                candidate.model.name(),
                candidate.parameters
            );
        }
        format!(
            "<h2>Lens models</h2>\n<table><tr><th>tried</th><th>parameters</th><th>rms, px</th>\
             <th>held out, px</th><th>BIC</th></tr>\n{rows}</table>\n<p>The simplest is taken \
             unless the Bayesian information criterion of another is lower by more than 10, and its \
             error on views held out is clearly lower.</p>\n"
        )
    }

    /// Lists residuals with view and corner, thinned out to at most [`MAX_DOTS`].
    fn residuals(&self) -> Vec<(&str, &CornerObservation, Vector2<f64>)> {
        let all = self.calibration.views.iter().flat_map(|view| {
            let pairs = view.corners.iter().zip(&view.residuals_px);
            pairs.map(|(corner, residual)| (view.name.as_str(), corner, *residual))
        });
        let all: Vec<_> = all.collect();
        // Evenly spaced residuals are enough for a plot.
        let every = all.len().div_ceil(MAX_DOTS).max(1);
        all.into_iter().step_by(every).collect()
    }

    /// Draws coverage and residuals on the image.
    fn image_map(&self) -> String {
        let camera = self.calibration.estimate.camera();
        let (width, height) = (f64::from(camera.width_px()), f64::from(camera.height_px()));
        let mut svg = Svg::over_image([camera.width_px(), camera.height_px()]);
        for (i, corners) in self.calibration.advice.coverage.corners.iter().enumerate() {
            if *corners == 0 {
                let (corner, size) = svg.grid_cell(i, COVERAGE);
                svg.rect(corner, size, NO_DATA_STYLE);
            }
        }
        let residuals = self.residuals();
        let magnified = magnification(residuals.iter().map(|(.., r)| *r), width);
        for (view, corner, residual) in &residuals {
            let at = corner.pixel;
            let end = at + residual * magnified;
            svg.line([at.x, at.y], [end.x, end.y], RESIDUAL_STYLE);
            let title = format!("{view}, corner {}: {:.3} px", corner.id, residual.norm());
            svg.dot([at.x, at.y], 1.6, "#1f4e79", &title);
        }
        let caption = format!("residuals, {magnified} times their length");
        svg.text([8.0, height - 8.0], "start", &caption);
        svg.finish("corners and residual vectors on the image")
    }

    /// Draws the projection uncertainty over the image, as mrcal does. Colours are logarithmic, because the uncertainty
    /// at the rim is often a hundred times that in the middle.
    fn uncertainty_map(&self) -> Option<String> {
        let camera = self.calibration.estimate.camera();
        let cells = &self.calibration.rays.cells;
        let known = || cells.iter().flatten().map(|sigma| sigma.px);
        let (least, most) = (known().fold(f64::INFINITY, f64::min), known().fold(0.0, f64::max));
        // A logarithmic scale needs positive and finite values.
        if !(least > 0.0 && most.is_finite()) {
            return None;
        }
        let mut svg = Svg::over_image([camera.width_px(), camera.height_px()]);
        for (i, sigma) in cells.iter().enumerate() {
            let Some(sigma) = sigma else { continue };
            let (corner, size) = svg.grid_cell(i, GRID.map(|count| count as usize));
            let part = (sigma.px / least).ln() / (most / least).ln().max(1e-9);
            let title = format!("{:.3} px, {:.3} mrad", sigma.px, 1e3 * sigma.angle_rad);
            svg.cell(corner, size, &heat_color(part), &title);
        }
        let caption = format!("{least:.3} px (pale) to {most:.3} px (dark), in logarithmic steps");
        let map = svg.finish("projection uncertainty over the image");
        Some(format!("{map}<figcaption>{caption}</figcaption>"))
    }

    /// Plots residuals against the angle off the axis.
    fn residual_against_angle(&self) -> String {
        let camera = self.calibration.estimate.camera();
        let residuals = self.residuals();
        let angle_deg = |corner: &CornerObservation| {
            let ray = camera.unproject(&corner.pixel).ok()?;
            Some(ray.direction.z.clamp(-1.0, 1.0).acos().to_degrees())
        };
        let tallest = residuals.iter().map(|(.., r)| r.norm()).fold(1e-3, f64::max);
        let limits = [
            1.05 * self.calibration.advice.coverage.observed_max_angle_deg.max(1.0),
            1.1 * tallest,
        ];
        let ticks = limits.map(|limit| round_tick_step(limit, 8.0));
        let mut plot = Plot::new(limits, ticks, ["angle off the axis, degrees", "residual, px"]);
        for (view, corner, residual) in &residuals {
            if let Some(angle_deg) = angle_deg(corner) {
                let title = format!("{view}, corner {}", corner.id);
                plot.dot([angle_deg, residual.norm()], "#1f4e79", &title);
            }
        }
        plot.finish("residual against the angle off the axis")
    }

    /// Writes the views.
    fn views_table(&self) -> String {
        let mut rows = String::new();
        for (view, growth, tilt_deg, adds_nothing) in self.views() {
            let growth = if growth.is_finite() {
                format!("{:.1} %", 100.0 * growth)
            } else {
                "indispensable".into()
            };
            let remark = if adds_nothing { "adds nothing" } else { "" };
            let _ = writeln!(
                rows,
                "<tr><td>{}</td><td>{}</td><td>{:.3}</td><td>{tilt_deg:.0}°</td><td>{growth}</td><td>{remark}</td></tr>",
                escape(&view.name),
                view.corners.len(),
                view.rms_px
            );
        }
        format!(
            "<h2>Views</h2>\n<table><tr><th>file</th><th>corners</th><th>rms, px</th><th>tilt</th>\
             <th>sigma grows without it</th><th></th></tr>\n{rows}</table>\n"
        )
    }
}
