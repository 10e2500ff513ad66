//! Units of a design: random deviations of built specimens from the drawing.

use fabkit_designs::unit_dimensions::Dimension;
use fabkit_fixtures::{BuiltUnit, Project};
use fabkit_geometry::{Angle, NominalCamera, Pose, Projection, Rgb, Sensor, Vector3};
use fabkit_light::draw_normal;
use serde_json::{Value, json};

use super::{Constant, LightConstants};

/// Standard deviations from unit to unit. All are chosen, except the focal length, whose tolerance the design states
/// from the maker, and dimensions, whose tolerance the design or a standard states.
///
/// Camera seat: shift along each axis, mm, and rotation about each axis, rad. Causes are printing and screws.
const SEAT_SIGMA_MM: f64 = 0.1;
const SEAT_SIGMA_RAD: f64 = 0.3 * std::f64::consts::PI / 180.0;
/// Standard deviation of an LED's brightness, relative. Bins of usual LEDs are 10 to 20 % wide.
const LED_SIGMA: f64 = 0.1;
/// Standard deviation of the position of a mold's core along each axis, mm. Layers cast around a shifted core are
/// thicker on one side.
const CORE_SIGMA_MM: f64 = 0.05;
/// Standard deviation of the layers' scattering and of the reach of light in them, relative. Causes are mixing and
/// curing.
const LAYER_SIGMA: f64 = 0.1;
/// Standard deviation as a share of a tolerance: a tolerance is about two standard deviations.
const SIGMA_PER_TOLERANCE: f64 = 0.5;

/// A unit by its number. The same number always gives the same deviations.
///
/// ```
/// use fabkit_capture::Unit;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let drawn = project.design.sensor;
/// let mut built = drawn.clone();
/// Unit(7).apply_to_sensor(&mut built);
/// // The camera sits some tenths of a millimetre off its place, always the same for this unit.
/// let off = built.camera.sensor_from_camera.point(fabkit_geometry::Point3::origin())
///     - drawn.camera.sensor_from_camera.point(fabkit_geometry::Point3::origin());
/// assert!(off.norm() > 0.0 && off.norm() < 1.0);
/// // Dimensions stay within their tolerances.
/// assert!(Unit(7).dimension_deviation("tube.wall").abs() <= 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit(pub u64);

impl Unit {
    /// Draws the normally distributed deviation number `what` of this unit, with mean 0.
    fn draw_deviation(self, what: u64, sigma: f64) -> f64 {
        // The mask keeps these numbers apart from the seeds of noise, which use the same generator.
        sigma * draw_normal(self.0 ^ 0x756e_6974, what)
    }

    fn seat_mm(self) -> Vector3<f64> {
        Vector3::from([0, 1, 2].map(|axis| self.draw_deviation(axis, SEAT_SIGMA_MM)))
    }

    fn seat_rad(self) -> [f64; 3] {
        [3, 4, 5].map(|axis| self.draw_deviation(axis, SEAT_SIGMA_RAD))
    }

    fn focal_share(self, camera: &NominalCamera) -> f64 {
        self.draw_deviation(6, SIGMA_PER_TOLERANCE * camera.lens.tolerance.focal_share)
    }

    fn core_mm(self) -> Vector3<f64> {
        Vector3::from([7, 8, 9].map(|axis| self.draw_deviation(axis, CORE_SIGMA_MM)))
    }

    fn lamp(self, group: usize, placement: usize) -> f64 {
        // Numbers from 1,000 on are LEDs; smaller ones are assigned by hand below 100.
        let what = 1_000 + 1_000 * group as u64 + placement as u64;
        (1.0 + self.draw_deviation(what, LED_SIGMA)).max(0.1)
    }

    /// Returns the deviation of a dimension as a share of its tolerance, -1 to 1: parts beyond their tolerances are not
    /// used.
    pub fn dimension_deviation(self, path: &str) -> f64 {
        self.draw_deviation(hash_name(path), SIGMA_PER_TOLERANCE).clamp(-1.0, 1.0)
    }

    /// Applies the unit's deviations to camera and light sources of a sensor.
    pub fn apply_to_sensor(self, sensor: &mut Sensor) {
        let camera = &mut sensor.camera;
        let turns = self.seat_rad().map(Angle::from_rad);
        let [Some(x), Some(y), Some(z)] = turns else { return };
        let turned = Pose::rotation_x(x).then_in(Pose::rotation_y(y)).then_in(Pose::rotation_z(z));
        let moved = self.seat_mm();
        camera.sensor_from_camera = Pose::translation(moved.x, moved.y, moved.z)
            .then_in(camera.sensor_from_camera)
            .then_in(turned);
        // A longer focal length reduces the field of view.
        let law = camera.lens.projection;
        let radius =
            law.radius(camera.field_of_view.rad() / 2.0) / (1.0 + self.focal_share(camera));
        let half = projection_angle(law, radius, camera.field_of_view.rad() / 2.0);
        camera.field_of_view = Angle::from_rad(2.0 * half).unwrap_or(camera.field_of_view);
        let counts: Vec<(String, usize)> =
            sensor.bodies.iter().map(|body| (body.name.clone(), body.placements.len())).collect();
        for lighting in &mut sensor.lightings {
            for (number, group) in lighting.light_sources.iter_mut().enumerate() {
                let count =
                    counts.iter().find(|(name, _)| *name == group.body).map_or(0, |of| of.1);
                let color = |placement: usize| -> Rgb {
                    group.color(placement).map(|part| part * self.lamp(number, placement))
                };
                group.colors = (0..count).map(color).collect();
            }
        }
    }

    /// Applies the unit's deviations to optical constants, and notes them in their sources.
    pub(super) fn apply_to_constants(self, constants: &mut LightConstants) {
        let all: [&mut Constant; 3] =
            [&mut constants.scatter_per_mm, &mut constants.spread_mm, &mut constants.uv_per_mm];
        for (number, constant) in (10..).zip(all) {
            let factor = (1.0 + self.draw_deviation(number, LAYER_SIGMA)).max(0.1);
            constant.value *= factor;
            constant.source += &format!("; times {factor:.3} for unit {}", self.0);
        }
        constants.core_off_mm = self.core_mm();
    }

    fn document(self, dimensions: &[Dimension], sensor: &Sensor) -> Value {
        let dimensions: Vec<Value> = dimensions.iter().map(dimension).collect();
        json!({
            "number": self.0,
            "is_simulated": true,
            "camera_moved_mm": <[f64; 3]>::from(self.seat_mm()),
            "camera_turned_deg": self.seat_rad().map(f64::to_degrees),
            "focal_length_times": 1.0 + self.focal_share(&sensor.camera),
            "core_off_mm": <[f64; 3]>::from(self.core_mm()),
            "dimensions": dimensions,
            "sigmas": {
                "camera_mm": SEAT_SIGMA_MM,
                "camera_deg": SEAT_SIGMA_RAD.to_degrees(),
                "focal_length": SIGMA_PER_TOLERANCE * sensor.camera.lens.tolerance.focal_share,
                "lamp": LED_SIGMA,
                "core_mm": CORE_SIGMA_MM,
                "layer": LAYER_SIGMA,
                "dimension": SIGMA_PER_TOLERANCE,
            },
        })
    }
}

fn dimension(of: &Dimension) -> Value {
    json!({
        "path": of.path,
        "unit": of.unit,
        "drawn": of.drawn,
        "built": of.built,
        "tolerance": of.tolerance,
        "source": if of.is_stated { "stated" } else { "ISO 2768-1 m" },
    })
}

/// Returns a unit's deviations from the drawing as JSON; null for the drawn sensor.
///
/// ```
/// use fabkit_capture::unit_document;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// assert!(unit_document(&project).is_null());
/// let built = project.design.sensor.clone();
/// let unit = project.into_unit(7, built, Vec::new());
/// assert_eq!(unit_document(&unit)["number"], 7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn unit_document(project: &Project) -> Value {
    let of = |BuiltUnit { number, dimensions, .. }: &BuiltUnit| {
        Unit(*number).document(dimensions, &project.design.sensor)
    };
    project.unit.as_ref().map(of).into()
}

/// Hashes a name to a number that does not collide with those assigned by hand.
fn hash_name(name: &str) -> u64 {
    // FNV-1a suffices for some hundred names.
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    // The top bit is set, and numbers assigned by hand are small.
    hash | 1 << 63
}

/// Returns the angle, rad, at which a projection has the given radius in focal lengths. The search starts at
/// `near_rad`.
fn projection_angle(law: Projection, radius: f64, near_rad: f64) -> f64 {
    // Newton's method; the projection laws are smooth and steep.
    (0..8).fold(near_rad, |rad, _| rad - (law.radius(rad) - radius) / law.slope(rad))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_differ_as_tolerances_say() {
        let of = |what: &dyn Fn(Unit) -> f64| -> f64 {
            let all: Vec<f64> = (0..4_000).map(|number| what(Unit(number))).collect();
            (all.iter().map(|value| value * value).sum::<f64>() / all.len() as f64).sqrt()
        };
        // Five standard errors of a standard deviation of 4,000.
        let near = |found: f64, sigma: f64| (found / sigma - 1.0).abs() < 5.0 / 8_000.0_f64.sqrt();
        assert!(near(of(&|unit| unit.seat_mm().x), SEAT_SIGMA_MM));
        assert!(near(of(&|unit| unit.core_mm().z), CORE_SIGMA_MM));
        assert!(near(of(&|unit| unit.lamp(0, 3) - 1.0), LED_SIGMA));
        // Cut off at two standard deviations: 0.959 of one is left.
        assert!(near(
            of(&|unit| unit.dimension_deviation("tube.wall")),
            0.959 * SIGMA_PER_TOLERANCE
        ));
        assert_eq!(Unit(5).seat_mm(), Unit(5).seat_mm());
        assert_ne!(Unit(5).seat_mm(), Unit(6).seat_mm());
    }

    #[test]
    fn longer_focal_length_reduces_field_of_view() {
        for law in [Projection::Equidistant, Projection::Equisolid, Projection::Stereographic] {
            let rad = projection_angle(law, law.radius(0.8) / 1.03, 0.8);
            assert!(rad < 0.8 && (law.radius(rad) * 1.03 - law.radius(0.8)).abs() < 1e-12);
        }
    }
}
