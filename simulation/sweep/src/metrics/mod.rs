//! Metrics of variants: one table, computed in groups.

mod calibration;
mod camera;
mod checks;
mod markers;
mod masses;
mod meshes;
mod press;
mod stock;
mod walls;

use std::collections::BTreeMap;

use fabkit_fixtures::Project;
use fabkit_geometry::InvalidSolid;

use self::camera::View;
pub use self::stock::{densities, stock_density_g_per_cm3};

/// Group of metrics that are computed together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// Camera's view of the surface, as designed.
    Camera,
    /// Markers, dimples or dots that the camera tracks.
    Markers,
    /// Volumes, masses, cost and time.
    Masses,
    /// Walls of printed parts.
    Walls,
    /// Expected accuracy of a calibration.
    Calibration,
    /// Deformation of the layers; takes tenths of a second.
    Press,
    /// Rules of `fabkit check`; takes seconds.
    Checks,
    /// Meshes of the parts; takes tenths of a second.
    Meshes,
    /// Accuracy of a small model on simulated images; takes seconds. The caller computes it
    /// ([`Plan::bench`](crate::Plan::bench)), because the learning code is Python.
    Bench,
}

/// All groups, in the order of tables.
pub const GROUPS: [Group; 9] = [
    Group::Camera,
    Group::Markers,
    Group::Masses,
    Group::Walls,
    Group::Calibration,
    Group::Press,
    Group::Checks,
    Group::Meshes,
    Group::Bench,
];

impl Group {
    /// Name of the group in plans.
    pub fn word(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Markers => "markers",
            Self::Masses => "masses",
            Self::Walls => "walls",
            Self::Calibration => "calibration",
            Self::Press => "press",
            Self::Checks => "checks",
            Self::Meshes => "meshes",
            Self::Bench => "bench",
        }
    }

    /// Returns whether a plan that names no metrics leaves the group out.
    pub fn is_slow(self) -> bool {
        matches!(self, Self::Press | Self::Checks | Self::Meshes | Self::Bench)
    }
}

/// Metric: a column of the table, or one for each material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Metric {
    /// Name of the column, with its unit.
    pub name: &'static str,
    /// Group with which it is computed.
    pub group: Group,
    /// Description for people.
    pub summary: &'static str,
    /// True if its columns are `name[material]`.
    pub per_material: bool,
}

impl Metric {
    /// Returns whether a column belongs to this metric.
    pub(crate) fn covers(&self, column: &str) -> bool {
        match self.per_material {
            false => self.name == column,
            true => column
                .strip_prefix(self.name)
                .is_some_and(|rest| rest.starts_with('[') && rest.ends_with(']')),
        }
    }
}

const fn metric(group: Group, name: &'static str, summary: &'static str) -> Metric {
    Metric { name, group, summary, per_material: false }
}

const fn per_material(name: &'static str, summary: &'static str) -> Metric {
    Metric { name, group: Group::Masses, summary, per_material: true }
}

/// All built-in metrics, in the order of tables.
pub const METRICS: &[Metric] = &[
    metric(Group::Camera, "surface_area_mm2", "area of the sensing surface"),
    metric(
        Group::Camera,
        "coverage",
        "share of that area that is seen: in the picture, through the drawn bodies, with nothing in the way",
    ),
    metric(
        Group::Camera,
        "mm_per_px_min",
        "root of the area on the surface that one pixel sees, where that is least",
    ),
    metric(Group::Camera, "mm_per_px_median", "the same, for half of the area seen"),
    metric(Group::Camera, "mm_per_px_max", "the same, where that is most"),
    metric(
        Group::Camera,
        "range_mm_per_px_min",
        "how much the distance to the surface changes over one pixel, where that is least: what a pixel's error makes of depth",
    ),
    metric(Group::Camera, "range_mm_per_px_median", "the same, for half of the area seen"),
    metric(Group::Camera, "range_mm_per_px_max", "the same, where that is most"),
    metric(Group::Markers, "marker_count", "number of markers, dimples or dots"),
    metric(
        Group::Markers,
        "markers_seen",
        "how many of them are seen: their centre in the picture, with nothing in the way",
    ),
    metric(
        Group::Markers,
        "marker_px_min",
        "width of a marker in the picture: diameter of the disc of its area, of the least one",
    ),
    metric(Group::Markers, "marker_px_median", "the same, for half of the markers seen"),
    metric(Group::Markers, "marker_px_max", "the same, of the largest one"),
    metric(Group::Markers, "occlusion", "share of the surface seen that lies behind a marker"),
    metric(Group::Masses, "parts_volume_mm3", "volume of all parts, by their quantities"),
    metric(Group::Masses, "parts_mass_g", "mass of all parts, solid"),
    metric(Group::Masses, "layers_volume_mm3", "volume of all that is cast"),
    metric(Group::Masses, "layers_mass_g", "mass of all that is cast, without waste"),
    metric(
        Group::Masses,
        "material_cost_usd",
        "rough price of all materials, waste of pours included",
    ),
    metric(Group::Masses, "print_time_h", "rough time on printers, as if solid"),
    per_material("volume_mm3", "volume of each material"),
    per_material("mass_g", "mass of each material"),
    metric(
        Group::Walls,
        "smallest_wall_mm",
        "thinnest wall of a printed part that lines meet, up to 5 mm",
    ),
    metric(
        Group::Calibration,
        "camera_position_sigma_mm",
        "standard deviation of the camera's place after calibration in the pin dome or pin plate",
    ),
    metric(Group::Calibration, "camera_rotation_sigma_deg", "the same of its direction"),
    metric(Group::Calibration, "seating_offset_sigma_mm", "the same of the pins' seating offset"),
    metric(
        Group::Press,
        "force_at_1mm_n",
        "force of a ball of 8 mm that stands 1 mm deep on the tip or the pad's middle, simulated at small strain",
    ),
    metric(Group::Press, "stiffness_n_mm", "how its force grows with depth there"),
    metric(Group::Press, "bulge_mm", "how far the surface comes out beside it"),
    metric(
        Group::Press,
        "bond_shear_strain",
        "shear strain where a layer is bonded to what lies below, at the bond that bears most stress",
    ),
    metric(Group::Press, "bond_shear_kpa", "the stress along that bond"),
    metric(Group::Checks, "check_errors", "findings that keep the sensor from being built"),
    metric(Group::Checks, "check_warnings", "findings that may"),
    metric(Group::Checks, "check_notes", "findings worth knowing"),
    metric(
        Group::Checks,
        "overlaps",
        "pairs of bodies that overlap where no press fit is declared",
    ),
    metric(
        Group::Checks,
        "undercut_mm2",
        "largest area of a rigid tool that lies behind what was cast",
    ),
    metric(Group::Checks, "demolding_strain", "largest strain of a soft tool that is peeled off"),
    metric(
        Group::Meshes,
        "mesh_triangles",
        "triangles of all parts at a chord tolerance of 0.05 mm",
    ),
    metric(Group::Meshes, "mesh_volume_mm3", "volume of their meshes, by quantities"),
    metric(Group::Meshes, "mesh_area_mm2", "area of their meshes, by quantities"),
    metric(
        Group::Bench,
        "depth_mae_mm",
        "mean error of depth that a small model tells from simulated pictures, over pixels that see what presses: domes, flat gels, and pin tips, where it is the depth of a whole press",
    ),
    metric(Group::Bench, "depth_mae_all_mm", "the same over all pixels that see the surface"),
    metric(
        Group::Bench,
        "saturated_share",
        "share of the pixels that see what presses where a dome's picture tells no more depth: darker by more than what its network takes in, or as white at rest as the chip can say",
    ),
    metric(
        Group::Bench,
        "localisation_mm",
        "median distance between where a ball touches a half ellipsoid and where a small model puts it, split by place",
    ),
    metric(
        Group::Bench,
        "force_mae_n",
        "mean error of a force's three components by a small model, in ultraviolet light, for indenters that it has not seen: half ellipsoids",
    ),
    metric(
        Group::Bench,
        "normal_r2",
        "how straight a normal displacement of dimples grows with force: R2 of a line, dome caps",
    ),
    metric(Group::Bench, "lateral_r2", "the same of a lateral displacement"),
    metric(
        Group::Bench,
        "slip_margin_mae",
        "mean error of the margin to slip by a small model, split by trial: dome caps",
    ),
    metric(
        Group::Bench,
        "quality_one_way_percent",
        "steps of depth over which a surrogate of the chip's surface quality goes one way: pin tips",
    ),
    metric(Group::Bench, "edge_angle_deg", "mean error of an edge's angle by its place: pin tips"),
    metric(Group::Bench, "edge_radius_mm", "the same of its distance"),
    metric(
        Group::Bench,
        "markers_rms_px",
        "rms error of where columns of liquid put markers, split by place: sheet molds",
    ),
];

/// Returns the metrics of a plan that names none.
pub(crate) fn default_metrics() -> Vec<&'static Metric> {
    METRICS.iter().filter(|metric| !metric.group.is_slow()).collect()
}

/// Former names that plans may still use, with the present ones, which hold for domes and plates.
const FORMER: [(&str, &str); 3] = [
    ("dome_position_sigma_mm", "camera_position_sigma_mm"),
    ("dome_rotation_sigma_deg", "camera_rotation_sigma_deg"),
    ("dome_seating_sigma_mm", "seating_offset_sigma_mm"),
];

/// Returns a metric's present name.
pub(crate) fn current(name: &str) -> &str {
    FORMER.iter().find(|(former, _)| *former == name).map_or(name, |(_, current)| current)
}

/// Returns the metrics that a word names: one, or those of a group.
pub(crate) fn named(word: &str) -> Vec<&'static Metric> {
    let word = current(word);
    METRICS.iter().filter(|metric| metric.name == word || metric.group.word() == word).collect()
}

/// Lists all words that [`named`] accepts.
pub(crate) fn words() -> Vec<&'static str> {
    let groups = GROUPS.iter().map(|group| group.word());
    groups.chain(METRICS.iter().map(|metric| metric.name)).collect()
}

/// Returns whether a column belongs to a built-in metric.
pub(crate) fn is_metric(column: &str) -> bool {
    METRICS.iter().any(|metric| metric.covers(column))
}

/// Values by column, and reasons why others are missing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Computed {
    pub values: BTreeMap<String, f64>,
    pub notes: Vec<String>,
}

impl Computed {
    fn put(&mut self, name: &str, value: f64) {
        // Adding 0 turns `-0` into `0`, which reads better.
        self.values.insert(name.to_owned(), value + 0.0);
    }

    /// Stores minimum, median and maximum as `name_min`, `name_median` and `name_max`; nothing for no values.
    fn put_spread(&mut self, name: &str, mut values: Vec<f64>) {
        values.sort_by(f64::total_cmp);
        if let (Some(first), Some(last)) = (values.first(), values.last()) {
            self.put(&format!("{name}_min"), *first);
            self.put(&format!("{name}_median"), values[values.len() / 2]);
            self.put(&format!("{name}_max"), *last);
        }
    }
}

/// Cache of results for bodies that several variants share.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    checks: fabkit_checks::Memo,
    meshes: meshes::Memo,
}

/// Computes metrics, each group once.
pub(crate) fn compute(
    project: &Project,
    wanted: &[&'static Metric],
    shared: &Shared,
    computed: &mut Computed,
) -> Result<(), InvalidSolid> {
    let sensor = &project.design.sensor;
    let looks = |metric: &&Metric| matches!(metric.group, Group::Camera | Group::Markers);
    let view = if wanted.iter().any(looks) { View::new(sensor) } else { Ok(None) };
    let view = view.unwrap_or_else(|error| {
        computed.notes.push(format!("nothing is known of what the camera sees: {error}"));
        None
    });
    for group in GROUPS {
        if !wanted.iter().any(|metric| metric.group == group) {
            continue;
        }
        match group {
            Group::Camera | Group::Markers => {
                let Some(view) = &view else { continue };
                match group {
                    Group::Camera => camera::compute(view, computed),
                    _ => markers::compute(view, computed)?,
                }
            }
            Group::Masses => masses::compute(sensor, computed)?,
            Group::Walls => walls::compute(sensor, computed)?,
            Group::Calibration => calibration::compute(project, computed),
            Group::Press => press::compute(sensor, computed),
            Group::Checks => checks::compute(sensor, &shared.checks, computed),
            Group::Meshes => meshes::compute(sensor, &shared.meshes, computed),
            // The caller computes these.
            Group::Bench => {}
        }
    }
    computed.values.retain(|name, _| wanted.iter().any(|metric| metric.covers(name)));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_name_their_columns() {
        for (i, a) in METRICS.iter().enumerate() {
            assert!(METRICS[..i].iter().all(|b| b.name != a.name), "{}", a.name);
            assert!(GROUPS.iter().all(|group| group.word() != a.name));
        }
        assert!(is_metric("mass_g[black PLA]") && !is_metric("mass_g") && is_metric("coverage"));
        assert_eq!(named("calibration").len(), 3);
        for (former, current) in FORMER {
            assert!(!is_metric(former) && named(former)[0].name == current, "{former}");
        }
        assert!(default_metrics().iter().all(|metric| !metric.group.is_slow()));
    }
}
