//! Print settings of filament parts, with estimated time and mass.

use fabkit_checks::{PrintSettings, print_settings};
use fabkit_geometry::sequences::EvenPoints;
use fabkit_geometry::{Body, CompiledSolid, Point3, Ray, Scratch, Sensor, Vector3};
use serde::Serialize;

use crate::{Guide, GuideError};

/// Value of the field `from` of [`PrintPlan`] for figures of this model instead of a slicer.
const MODEL: &str = "model";

/// Mean speed of the nozzle over the whole print, travel and pauses included, mm/s. PrusaSlicer 2.5 with its default
/// speeds gives 29.4 for plain shells and 17 for small parts with many corners. Compared by `guide --slice` of rtac0,
/// 9dtact, tactip and shadowtac, 19 parts: at this speed, and before narrow places counted as filled, the model gave
/// 0.58 to 1.26 of the slicer's time, 0.94 in the median. Fast printers take a third.
const PACE_MM_S: f64 = 25.0;

/// Number of vertical rays by which a part's inside is sampled.
const COLUMNS: usize = 400;

/// Approximate number of sampled points of a part.
const POINTS: f64 = 1_500.0;

/// Positions of the rays in a unit square.
const PLACES: EvenPoints<2> = EvenPoints::square([0.5; 2]);

const MM3_PER_CM3: f64 = 1e3;

/// Print settings of a part, with estimates.
#[derive(Clone, Debug, Serialize)]
pub struct PrintPlan {
    /// Height of a layer, mm.
    pub layer_mm: f64,
    /// Number of perimeter lines along each outline.
    pub perimeters: u32,
    /// Infill, %.
    pub infill_percent: f64,
    /// True if supports are printed.
    pub supports: bool,
    /// Width of the brim, mm; 0 for none.
    pub brim_mm: f64,
    /// Reasons for layer height, perimeters, solid layers, infill, supports and brim, in this order.
    pub reasons: [String; 6],
    /// Print time of one piece, alone on its bed, minutes.
    pub minutes: f64,
    /// Filament of one piece, mm3.
    pub filament_mm3: f64,
    /// Filament of one piece, g; `null` if the material's density is not known.
    pub mass_g: Option<f64>,
    /// Source of time and mass: `model`, or the slicer with its version.
    pub from: String,
}

/// Figures of a slicer for one piece.
#[derive(Clone, Debug, PartialEq)]
pub struct SlicerEstimate {
    /// Estimated time, minutes.
    pub minutes: f64,
    /// Filament, mm3.
    pub filament_mm3: f64,
    /// Slicer with its version.
    pub slicer: String,
}

impl Guide {
    /// Replaces the model's figures for a part by those of a slicer.
    ///
    /// ```
    /// # use fabkit_guide::{Guide, NoShop, Request};
    /// use fabkit_geometry::{BodyKind, Process};
    /// use fabkit_guide::SlicerEstimate;
    /// # let mut sensor = fabkit_checks::example::puck();
    /// sensor.bodies[0].kind = BodyKind::Made(Process::Fdm);
    /// # let stages = fabkit_checks::stages(&sensor)?;
    /// # let (density, shop, calibration) = (&|_: &str| Some(1.24), &NoShop, None);
    /// # let request = Request { design_hash: "00", units: 1, density, shop, stages: &stages, calibration };
    /// let mut guide = Guide::new(&sensor, &request)?;
    /// let sliced =
    ///     SlicerEstimate { minutes: 12.0, filament_mm3: 1000.0, slicer: "a slicer".into() };
    /// guide.set_slicer_estimate("dish", sliced);
    /// let print = guide.made[0].print.as_ref().ok_or("not of filament")?;
    /// // 1 cm3 of filament of 1.24 g/cm3.
    /// assert!((print.mass_g.ok_or("no density")? - 1.24).abs() < 1e-9);
    /// assert_eq!(print.minutes, 12.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_slicer_estimate(&mut self, part: &str, sliced: SlicerEstimate) {
        let made = self.made.iter_mut().find(|made| made.name == part);
        let Some(printing) = made.and_then(|made| made.print.as_mut()) else { return };
        // The density is not stored, but follows from the model's figures.
        let density = printing.mass_g.map(|mass_g| mass_g / printing.filament_mm3);
        printing.mass_g = density.map(|density| density * sliced.filament_mm3);
        printing.minutes = sliced.minutes;
        printing.filament_mm3 = sliced.filament_mm3;
        printing.from = sliced.slicer;
    }
}

/// Returns the print settings of a part with estimates; `None` unless it is printed from filament. `on_bed` is the part
/// as it lies on the bed.
pub(crate) fn printing(
    sensor: &Sensor,
    part: &Body,
    on_bed: &CompiledSolid,
    volume_mm3: f64,
    density_g_per_cm3: Option<f64>,
) -> Result<Option<PrintPlan>, GuideError> {
    let settings = print_settings(sensor, part)
        .map_err(|error| GuideError::PrintSettings(error.to_string()))?;
    Ok(settings.map(|settings| {
        let [x_mm, y_mm, _] = on_bed.bounds().size_mm();
        let brim_mm3 = settings.brim_mm.value * 2.0 * (x_mm + y_mm) * settings.layer_mm.value;
        let filament_mm3 = volume_mm3 * solid_share(on_bed, &settings) + brim_mm3;
        let flow_mm3_s = PACE_MM_S * settings.line_mm * settings.layer_mm.value;
        PrintPlan {
            layer_mm: settings.layer_mm.value,
            perimeters: settings.perimeters.value,
            infill_percent: settings.infill_percent.value,
            supports: settings.supports.value,
            brim_mm: settings.brim_mm.value,
            minutes: filament_mm3 / flow_mm3_s / 60.0,
            filament_mm3,
            mass_g: density_g_per_cm3.map(|density| density * filament_mm3 / MM3_PER_CM3),
            from: MODEL.to_owned(),
            reasons: [
                settings.layer_mm.reason,
                settings.perimeters.reason,
                settings.solid_layers.reason,
                settings.infill_percent.reason,
                settings.supports.reason,
                settings.brim_mm.reason,
            ],
        }
    }))
}

/// Returns four horizontal directions: the true distance to a wall is at most a twelfth less than along one of these.
fn headings() -> impl Iterator<Item = Vector3<f64>> {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    [[1.0, 0.0], [0.0, 1.0], [half, half], [half, -half]]
        .into_iter()
        .map(|[x, y]| Vector3::new(x, y, 0.0))
}

/// Returns the fraction of a part's volume that is plastic: everything within its walls, floors and ceilings, and the
/// infill elsewhere. Supports are not counted.
fn solid_share(body: &CompiledSolid, settings: &PrintSettings) -> f64 {
    let wall_mm = f64::from(settings.perimeters.value) * settings.line_mm;
    let skin_mm = f64::from(settings.solid_layers.value) * settings.layer_mm.value;
    // Where walls leave a gap too narrow for infill, slicers fill it.
    let reach_mm = 2.0 * wall_mm + 2.0 * settings.line_mm;
    let infill = settings.infill_percent.value / 100.0;
    let bounds = body.bounds();
    let size = bounds.max - bounds.min;
    let mut scratch = Scratch::default();
    let mut stretches = Vec::new();
    let mut columns = Vec::with_capacity(COLUMNS);
    for index in 0..COLUMNS {
        let [u, v] = PLACES.at(index + 1);
        let origin =
            Point3::new(bounds.min.x + u * size.x, bounds.min.y + v * size.y, bounds.min.z - 1.0);
        body.stretches_into(&Ray { origin, direction: Vector3::z() }, &mut scratch, &mut stretches);
        columns.extend(stretches.iter().map(|ends| (origin, *ends)));
    }
    let all_mm: f64 = columns.iter().map(|(_, [from, to])| to - from).sum();
    let step_mm = all_mm / POINTS;
    let (mut walls, mut points) = (0.0, 0.0);
    for (origin, [from, to]) in columns {
        // Floors and ceilings are thinner than the distance of the points, so their share is computed exactly.
        let [bottom, top] = [from + skin_mm, to - skin_mm];
        points += to - from;
        walls += (to - from).min(2.0 * skin_mm);
        if bottom >= top {
            continue;
        }
        let count = ((top - bottom) / step_mm).ceil();
        let weight = (top - bottom) / count;
        for i in 0..count as usize {
            let point = origin + Vector3::z() * (bottom + (i as f64 + 0.5) * weight);
            let is_wall = headings().any(|direction| {
                let origin = point - direction * reach_mm;
                body.stretches_into(&Ray { origin, direction }, &mut scratch, &mut stretches);
                // The stretch of material that contains the point.
                let here =
                    stretches.iter().find(|[low, high]| *low <= reach_mm && reach_mm <= *high);
                here.is_none_or(|[low, high]| {
                    let [back, ahead] = [reach_mm - low.max(0.0), high - reach_mm];
                    back < wall_mm || ahead < wall_mm || back + ahead < reach_mm
                })
            });
            walls += if is_wall { weight } else { 0.0 };
        }
    }
    if points > 0.0 { (walls + infill * (points - walls)) / points } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::{Process, Solid};

    use super::*;

    #[test]
    fn solid_share_counts_walls_skins_and_infill() {
        let cube = |side: f64| {
            let sensor = fabkit_checks::example::puck();
            let cube = Body::made("cube", "", Process::Fdm, Solid::cuboid(side, side, side));
            let solid = CompiledSolid::new(&cube.solid).unwrap();
            printing(&sensor, &cube, &solid, side.powi(3), Some(1.24)).unwrap().unwrap()
        };
        // 3 lines of 0.45 mm, 4 layers of 0.2 mm, 15 % inside.
        let told = cube(30.0);
        let inside = (30.0f64 - 2.7).powi(2) * (30.0 - 1.6);
        let wanted = 27_000.0 - 0.85 * inside;
        // 400 columns tell the share of the inside, 0.83 of the area, to 0.019: 4.5 % of the filament.
        assert!((told.filament_mm3 / wanted - 1.0).abs() < 0.045, "{told:?}");
        assert!((told.mass_g.unwrap() - 1.24e-3 * told.filament_mm3).abs() < 1e-9);
        // A thin one is solid.
        assert!((cube(1.5).filament_mm3 - 1.5f64.powi(3)).abs() < 1e-9);
    }
}
