//! Drawings of the extrinsics report.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use fabkit_geometry::{Matrix3, Point3, Vector3};
use fabkit_report::{
    LOWER_BOUND_STYLE, Plot, RESIDUAL_STYLE, Svg, escape, heat_color, round_tick_step,
};
use nalgebra::Vector2;

use super::{ExtrinsicsReport, PinCrop, magnification};
use crate::model::{FitParameter, Observation};
use crate::uncertainty::{SurfaceSigma, surface_sigma};

/// Number of rings of the uncertainty maps.
const RINGS: usize = 14;
/// Number of places on a ring.
const PLACES: usize = 48;
/// Size of a crop's pixel in the drawing.
const CROP_SCALE: f64 = 6.0;

/// Observed pin: its pixel and its residual, px.
struct ObservedPin {
    pixel: Vector2<f64>,
    residual: Vector2<f64>,
}

/// Statistics of the pins in one hole.
pub(super) struct HoleRow {
    pub hole: u32,
    pub pins: usize,
    pub mean_residual_px: Vector2<f64>,
    /// Scatter about their mean, px; `None` for a single pin.
    pub scatter_px: Option<f64>,
}

impl HoleRow {
    /// Computes the statistics of the pins in one hole.
    fn new(hole: u32, pins: &[ObservedPin]) -> Self {
        let count = pins.len() as f64;
        let mean = pins.iter().map(|seen| seen.pixel).sum::<Vector2<f64>>() / count;
        let mean_residual_px = pins.iter().map(|seen| seen.residual).sum::<Vector2<f64>>() / count;
        let squares: f64 = pins.iter().map(|seen| (seen.pixel - mean).norm_squared()).sum();
        let scatter_px = (pins.len() > 1).then(|| (squares / (count - 1.0)).sqrt());
        Self { hole, pins: pins.len(), mean_residual_px, scatter_px }
    }
}

impl ExtrinsicsReport<'_> {
    fn residuals(&self) -> Vec<(&Observation, Vector2<f64>)> {
        let observations = &self.calibration.observations;
        let residuals = self.chosen().fit.residuals_px(observations);
        observations.iter().zip(residuals).filter_map(|(o, r)| Some((o, r?))).collect()
    }

    fn tooltip(&self, o: &Observation, residual: Vector2<f64>) -> String {
        let record = self.captures.get(o.contact.capture);
        let file = record.map_or("?", |record| record.file.as_str());
        format!("hole {}, {file}: {:.2} px", o.contact.hole, residual.norm())
    }

    /// Draws the observed pins with their residuals.
    pub(super) fn residual_vectors(&self) -> String {
        let camera = &self.calibration.model().camera;
        let (width, height) = (f64::from(camera.width_px()), f64::from(camera.height_px()));
        let mut svg = Svg::over_image([camera.width_px(), camera.height_px()]);
        let residuals = self.residuals();
        let magnified = magnification(residuals.iter().map(|(_, residual)| *residual), width);
        for (o, residual) in residuals {
            let at = [o.pixel.x, o.pixel.y];
            let end = o.pixel + residual * magnified;
            svg.line(at, [end.x, end.y], RESIDUAL_STYLE);
            svg.dot(at, 2.5, "#1f4e79", &self.tooltip(o, residual));
        }
        let caption = format!("residuals, {magnified} times their length");
        svg.text([8.0, height - 8.0], "start", &caption);
        svg.finish("residual vectors on the image")
    }

    /// Plots residuals against the distance from the principal point.
    pub(super) fn residual_against_radius(&self) -> String {
        let model = self.calibration.model();
        let intrinsics = model.camera.lens().intrinsics();
        let centre = Vector2::new(intrinsics.cx_px, intrinsics.cy_px);
        let residuals = self.residuals();
        let radius = |o: &Observation| (o.pixel.coords - centre).norm();
        let far = residuals.iter().map(|(o, _)| radius(o)).fold(1.0, f64::max);
        let limits = [far * 1.05, self.tallest_px(&residuals)];
        let ticks = [round_tick_step(limits[0], 8.0), round_tick_step(limits[1], 5.0)];
        let mut plot =
            Plot::new(limits, ticks, ["distance from the principal point, px", "residual, px"]);
        for (o, residual) in &residuals {
            let title = self.tooltip(o, *residual);
            plot.dot([radius(o), residual.norm()], "#1f4e79", &title);
        }
        self.scatter_level(&mut plot);
        plot.finish("residual against radius")
    }

    /// Plots residuals against the hole's number.
    pub(super) fn residual_against_hole(&self) -> String {
        let residuals = self.residuals();
        let last = residuals.iter().map(|(o, _)| o.contact.hole).max().unwrap_or(1);
        let limits = [f64::from(last) + 1.0, self.tallest_px(&residuals)];
        let ticks = [round_tick_step(limits[0], 15.0).max(1.0), round_tick_step(limits[1], 5.0)];
        let mut plot = Plot::new(limits, ticks, ["hole", "residual, px"]);
        for (o, residual) in &residuals {
            let title = self.tooltip(o, *residual);
            plot.dot([f64::from(o.contact.hole), residual.norm()], "#1f4e79", &title);
        }
        self.scatter_level(&mut plot);
        plot.finish("residual against hole")
    }

    /// Draws an outlying pin in its image.
    pub(super) fn crop(&self, crop: &PinCrop) -> Option<String> {
        let pin = self.calibration.observations.get(crop.observation)?;
        let residuals = self.chosen().fit.residuals_px(std::slice::from_ref(pin));
        let residual = (*residuals.first()?)?;
        let [width, height] = crop.size_px.map(|px| CROP_SCALE * f64::from(px));
        // A pixel's centre has integer coordinates, its corner lies half a pixel before.
        let at = |pixel: Vector2<f64>| {
            [0, 1].map(|axis| CROP_SCALE * (pixel[axis] - f64::from(crop.first_px[axis]) + 0.5))
        };
        let mut svg = Svg::new(width, height);
        svg.image([0.0; 2], [width, height], &crop.png);
        svg.line(at(pin.pixel.coords - residual), at(pin.pixel.coords), RESIDUAL_STYLE);
        let title = self.tooltip(pin, residual);
        svg.dot(at(pin.pixel.coords), 0.5 * CROP_SCALE, "#c0392b", &title);
        Some(format!(
            "<figure class=\"crop\">{}<figcaption>{}</figcaption></figure>",
            svg.finish(&title),
            escape(&title)
        ))
    }

    fn tallest_px(&self, residuals: &[(&Observation, Vector2<f64>)]) -> f64 {
        1.1 * residuals.iter().map(|(_, r)| r.norm()).fold(0.1, f64::max)
    }

    fn scatter_level(&self, plot: &mut Plot) {
        if let Some(scatter) = self.calibration.scatter {
            plot.horizontal_line(scatter.rms_px, LOWER_BOUND_STYLE);
        }
    }

    /// Lists each hole with the number of its presses and their repeatability.
    pub(super) fn repeatability(&self) -> Vec<HoleRow> {
        let mut by_hole: BTreeMap<u32, Vec<ObservedPin>> = BTreeMap::new();
        for (o, residual) in self.residuals() {
            let seen = ObservedPin { pixel: o.pixel.coords, residual };
            by_hole.entry(o.contact.hole).or_default().push(seen);
        }
        by_hole.into_iter().map(|(hole, pins)| HoleRow::new(hole, &pins)).collect()
    }

    /// Draws two maps: standard deviation of the surface's pixel, and of its depth.
    ///
    /// The surface is the sphere on which the pins of this calibration touch, as far out as pins touched.
    pub(super) fn uncertainty_maps(&self) -> Option<[String; 2]> {
        let places = self.places_on_dome()?;
        let draw = |name: &str, unit: &str, value: &dyn Fn(&SurfaceSigma) -> f64| {
            let camera = &self.calibration.model().camera;
            let values = || places.iter().map(|(_, sigma)| value(sigma));
            let largest = values().fold(0.0, f64::max);
            let smallest = values().fold(f64::INFINITY, f64::min);
            let mut svg = Svg::over_image([camera.width_px(), camera.height_px()]);
            for (pixel, sigma) in &places {
                let part = (value(sigma) - smallest) / (largest - smallest).max(1e-12);
                let title = format!("{:.3} {unit}", value(sigma));
                svg.dot(*pixel, 7.0, &heat_color(part), &title);
            }
            let caption = format!("{name}: {smallest:.3} (pale) to {largest:.3} {unit} (dark)");
            format!("{}<figcaption>{}</figcaption>", svg.finish(name), escape(&caption))
        };
        Some([
            draw("sigma of the pixel", "px", &|sigma| sigma.pixel_px),
            draw("sigma of the depth along z", "mm", &|sigma| sigma.depth_z_mm),
        ])
    }

    /// Computes the surface's uncertainty at places on a dome, with their pixels; `None` if pins' axes are unknown or
    /// parallel.
    fn places_on_dome(&self) -> Option<Vec<([f64; 2], SurfaceSigma)>> {
        let calibration = self.calibration;
        let contacts: Vec<(Point3<f64>, Vector3<f64>)> = calibration
            .observations
            .iter()
            .map(|o| Some((o.contact.contact_in_sensor_mm, o.contact.axis_in_sensor?)))
            .collect::<Option<_>>()?;
        let centre = nearest_point_to_lines(&contacts)?;
        // The pins' axes meet near the dome's centre.
        let count = contacts.len() as f64;
        let radius_mm = contacts.iter().map(|(p, _)| (p - centre).norm()).sum::<f64>() / count;
        let polar = |p: &Point3<f64>| (p - centre).angle(&Vector3::z());
        let rim = contacts.iter().map(|(p, _)| polar(p)).fold(0.0, f64::max);
        let joint = &calibration.joint;
        let of_camera = joint.camera().parameters().into_iter();
        let of_camera = of_camera.map(|(name, _)| FitParameter::Camera(name));
        let parameters: Vec<FitParameter> =
            FitParameter::POSE.into_iter().chain(of_camera).collect();
        let mut places = Vec::new();
        for ring in 0..RINGS {
            let (s, c) = (rim * ring as f64 / (RINGS - 1) as f64).sin_cos();
            for place in 0..if ring == 0 { 1 } else { PLACES } {
                let (sa, ca) = (TAU * place as f64 / PLACES as f64).sin_cos();
                let outward = Vector3::new(s * ca, s * sa, c);
                let model = calibration.model();
                let point = centre + outward * radius_mm;
                let sigma = surface_sigma(model, &parameters, joint.covariance(), point, outward);
                let pixel = model.camera.project(&model.camera_from_sensor.point(point)).ok();
                if let (Some(sigma), Some(pixel)) = (sigma, pixel) {
                    places.push(([pixel.x, pixel.y], sigma));
                }
            }
        }
        (!places.is_empty()).then_some(places)
    }

    /// Formats an HTML list with an item for each text.
    pub(super) fn list(items: &[String]) -> String {
        let items: String = items.iter().map(|i| format!("<li>{}</li>\n", escape(i))).collect();
        format!("<ul>\n{items}</ul>\n")
    }
}

/// Finds the point with the smallest sum of squared distances from lines; `None` if they are parallel.
fn nearest_point_to_lines(lines: &[(Point3<f64>, Vector3<f64>)]) -> Option<Point3<f64>> {
    let (mut system, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (point, axis) in lines {
        let across = Matrix3::identity() - axis * axis.transpose();
        system += across;
        right += across * point.coords;
    }
    // Parallel lines leave one direction undetermined: the system is singular up to rounding.
    let parallel = system.symmetric_eigenvalues().min() < 1e-6 * lines.len() as f64;
    system.try_inverse().filter(|_| !parallel).map(|inverse| Point3::from(inverse * right))
}
