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
        "visible fraction of the sensing surface: inside the image and not hidden, through the drawn bodies",
    ),
    metric(
        Group::Camera,
        "mm_per_px_min",
        "smallest size of a pixel on the surface: square root of the area that it covers",
    ),
    metric(
        Group::Camera,
        "mm_per_px_median",
        "median size of a pixel on the surface, over the visible area",
    ),
    metric(Group::Camera, "mm_per_px_max", "largest size of a pixel on the surface"),
    metric(
        Group::Camera,
        "range_mm_per_px_min",
        "smallest change of the distance to the surface over one pixel, which turns a pixel's error into a depth error",
    ),
    metric(
        Group::Camera,
        "range_mm_per_px_median",
        "median change of the distance to the surface over one pixel, over the visible area",
    ),
    metric(
        Group::Camera,
        "range_mm_per_px_max",
        "largest change of the distance to the surface over one pixel",
    ),
    metric(Group::Markers, "marker_count", "number of markers, dimples or dots"),
    metric(
        Group::Markers,
        "markers_seen",
        "number of visible markers, whose centre lies inside the image and is not hidden",
    ),
    metric(
        Group::Markers,
        "marker_px_min",
        "smallest width of a marker in the image: diameter of a disc of the same area",
    ),
    metric(Group::Markers, "marker_px_median", "median width of the visible markers in the image"),
    metric(Group::Markers, "marker_px_max", "largest width of a marker in the image"),
    metric(
        Group::Markers,
        "occlusion",
        "fraction of the surface in the image that is hidden behind markers",
    ),
    metric(Group::Masses, "parts_volume_mm3", "volume of all parts, counting their quantities"),
    metric(Group::Masses, "parts_mass_g", "mass of all parts, if solid"),
    metric(Group::Masses, "layers_volume_mm3", "volume of all cast layers"),
    metric(Group::Masses, "layers_mass_g", "mass of all cast layers, without waste"),
    metric(
        Group::Masses,
        "material_cost_usd",
        "approximate price of all materials, including the waste of pours",
    ),
    metric(Group::Masses, "print_time_h", "approximate printing time, if parts are solid"),
    per_material("volume_mm3", "volume of each material"),
    per_material("mass_g", "mass of each material"),
    metric(
        Group::Walls,
        "smallest_wall_mm",
        "thickness of the thinnest wall of a printed part, found by sampling lines, up to 5 mm",
    ),
    metric(
        Group::Calibration,
        "camera_position_sigma_mm",
        "standard deviation of the camera's position after calibration in the pin dome or pin plate",
    ),
    metric(
        Group::Calibration,
        "camera_rotation_sigma_deg",
        "standard deviation of the camera's orientation after that calibration",
    ),
    metric(
        Group::Calibration,
        "seating_offset_sigma_mm",
        "standard deviation of the pins' seating offset after that calibration",
    ),
    metric(
        Group::Press,
        "force_at_1mm_n",
        "force on a ball of 8 mm diameter at an indentation of 1 mm at the tip or the middle of the pad, simulated at small strain",
    ),
    metric(Group::Press, "stiffness_n_mm", "slope of that ball's force over its indentation"),
    metric(Group::Press, "bulge_mm", "height by which the surface bulges beside that ball"),
    metric(
        Group::Press,
        "bond_shear_strain",
        "shear strain at the bond between two layers that bears the largest stress, under that ball",
    ),
    metric(Group::Press, "bond_shear_kpa", "shear stress at that bond"),
    metric(
        Group::Checks,
        "check_errors",
        "number of errors of `check`, which keep the sensor from being built",
    ),
    metric(
        Group::Checks,
        "check_warnings",
        "number of warnings of `check`, which may keep it from being built",
    ),
    metric(Group::Checks, "check_notes", "number of notes of `check`, which are worth knowing"),
    metric(
        Group::Checks,
        "overlaps",
        "number of pairs of bodies that overlap without a declared press fit",
    ),
    metric(
        Group::Checks,
        "undercut_mm2",
        "largest undercut area of a rigid tool behind the cast part",
    ),
    metric(
        Group::Checks,
        "demolding_strain",
        "largest strain of a soft tool when it is peeled off",
    ),
    metric(
        Group::Meshes,
        "mesh_triangles",
        "number of triangles of all parts at a chord tolerance of 0.05 mm",
    ),
    metric(
        Group::Meshes,
        "mesh_volume_mm3",
        "volume of the meshes of all parts, counting their quantities",
    ),
    metric(
        Group::Meshes,
        "mesh_area_mm2",
        "area of the meshes of all parts, counting their quantities",
    ),
    metric(
        Group::Bench,
        "depth_mae_mm",
        "mean absolute error of the depth that a small model predicts from simulated images, over pixels that see the indenter: domes, flat gels, and pin tips, where it is the depth of a whole press",
    ),
    metric(
        Group::Bench,
        "depth_mae_all_mm",
        "mean absolute error of that depth over all pixels that see the surface",
    ),
    metric(
        Group::Bench,
        "saturated_share",
        "fraction of the pixels that see the indenter in which a dome's image no longer depends on depth: darker by more than the network's input range, or saturated white at rest",
    ),
    metric(
        Group::Bench,
        "localisation_mm",
        "median distance between the contact point of a ball and a small model's prediction, split by position: half ellipsoids",
    ),
    metric(
        Group::Bench,
        "force_mae_n",
        "mean absolute error of a small model for a force's three components, in ultraviolet light, for indenters not in its training set: half ellipsoids",
    ),
    metric(
        Group::Bench,
        "normal_r2",
        "linearity of the normal displacement of dimples over force: R2 of a straight line, dome caps",
    ),
    metric(
        Group::Bench,
        "lateral_r2",
        "linearity of the lateral displacement of dimples over force: R2 of a straight line, dome caps",
    ),
    metric(
        Group::Bench,
        "slip_margin_mae",
        "mean absolute error of a small model for the margin to slip, split by trial: dome caps",
    ),
    metric(
        Group::Bench,
        "quality_one_way_percent",
        "share of depth steps over which a surrogate of the chip's surface quality changes monotonically: pin tips",
    ),
    metric(
        Group::Bench,
        "edge_angle_deg",
        "mean absolute error of an edge's angle predicted from an image: pin tips",
    ),
    metric(
        Group::Bench,
        "edge_radius_mm",
        "mean absolute error of an edge's distance predicted from an image: pin tips",
    ),
    metric(
        Group::Bench,
        "markers_rms_px",
        "rms error of marker positions predicted from the liquid columns, split by position: sheet molds",
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
