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
pub use self::stock::densities;

/// Group of metrics that are computed together.
///
/// ```
/// use fabkit_sweep::{METRICS, MetricGroup};
/// let group = |name| METRICS.iter().find(|metric| metric.name == name).map(|metric| metric.group);
/// assert_eq!(group("coverage"), Some(MetricGroup::Camera));
/// // A plan that names no metrics computes the fast groups.
/// assert_eq!(group("force_at_1mm_n"), Some(MetricGroup::Press));
/// assert!(MetricGroup::Press.is_slow() && !MetricGroup::Camera.is_slow());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MetricGroup {
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
    /// ([`Plan::bench`](crate::Plan::bench_metrics)), because the learning code is Python.
    Bench,
}

/// All groups, in the order of tables.
pub const GROUPS: [MetricGroup; 9] = [
    MetricGroup::Camera,
    MetricGroup::Markers,
    MetricGroup::Masses,
    MetricGroup::Walls,
    MetricGroup::Calibration,
    MetricGroup::Press,
    MetricGroup::Checks,
    MetricGroup::Meshes,
    MetricGroup::Bench,
];

impl MetricGroup {
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
    pub group: MetricGroup,
    /// Description for people.
    pub summary: &'static str,
    /// True if its columns are `name[material]`.
    pub per_material: bool,
}

impl Metric {
    /// Returns whether a column belongs to this metric.
    pub(crate) fn covers(&self, column: &str) -> bool {
        if self.per_material {
            column
                .strip_prefix(self.name)
                .is_some_and(|rest| rest.starts_with('[') && rest.ends_with(']'))
        } else {
            self.name == column
        }
    }
}

const fn metric(group: MetricGroup, name: &'static str, summary: &'static str) -> Metric {
    Metric { name, group, summary, per_material: false }
}

const fn per_material(name: &'static str, summary: &'static str) -> Metric {
    Metric { name, group: MetricGroup::Masses, summary, per_material: true }
}

/// All built-in metrics, in the order of tables.
pub const METRICS: &[Metric] = &[
    metric(MetricGroup::Camera, "surface_area_mm2", "area of the sensing surface"),
    metric(
        MetricGroup::Camera,
        "coverage",
        "visible fraction of the sensing surface: inside the image and not hidden, through the drawn bodies",
    ),
    metric(
        MetricGroup::Camera,
        "mm_per_px_min",
        "smallest size of a pixel on the surface: square root of the area that it covers",
    ),
    metric(
        MetricGroup::Camera,
        "mm_per_px_median",
        "median size of a pixel on the surface, over the visible area",
    ),
    metric(MetricGroup::Camera, "mm_per_px_max", "largest size of a pixel on the surface"),
    metric(
        MetricGroup::Camera,
        "range_mm_per_px_min",
        "smallest change of the distance to the surface over one pixel, which turns a pixel's error into a depth error",
    ),
    metric(
        MetricGroup::Camera,
        "range_mm_per_px_median",
        "median change of the distance to the surface over one pixel, over the visible area",
    ),
    metric(
        MetricGroup::Camera,
        "range_mm_per_px_max",
        "largest change of the distance to the surface over one pixel",
    ),
    metric(MetricGroup::Markers, "marker_count", "number of markers, dimples or dots"),
    metric(
        MetricGroup::Markers,
        "markers_seen",
        "number of visible markers, whose centre lies inside the image and is not hidden",
    ),
    metric(
        MetricGroup::Markers,
        "marker_px_min",
        "smallest width of a marker in the image: diameter of a disc of the same area",
    ),
    metric(
        MetricGroup::Markers,
        "marker_px_median",
        "median width of the visible markers in the image",
    ),
    metric(MetricGroup::Markers, "marker_px_max", "largest width of a marker in the image"),
    metric(
        MetricGroup::Markers,
        "occlusion",
        "fraction of the surface in the image that is hidden behind markers",
    ),
    metric(
        MetricGroup::Masses,
        "parts_volume_mm3",
        "volume of all parts, counting their quantities",
    ),
    metric(MetricGroup::Masses, "parts_mass_g", "mass of all parts, if solid"),
    metric(MetricGroup::Masses, "layers_volume_mm3", "volume of all cast layers"),
    metric(MetricGroup::Masses, "layers_mass_g", "mass of all cast layers, without waste"),
    metric(
        MetricGroup::Masses,
        "material_cost_usd",
        "approximate price of all materials, including the waste of pours",
    ),
    metric(MetricGroup::Masses, "print_time_h", "approximate printing time, if parts are solid"),
    per_material("volume_mm3", "volume of each material"),
    per_material("mass_g", "mass of each material"),
    metric(
        MetricGroup::Walls,
        "smallest_wall_mm",
        "thickness of the thinnest wall of a printed part, found by sampling lines, up to 5 mm",
    ),
    metric(
        MetricGroup::Calibration,
        "camera_position_sigma_mm",
        "standard deviation of the camera's position after calibration in the pin dome or pin plate",
    ),
    metric(
        MetricGroup::Calibration,
        "camera_rotation_sigma_deg",
        "standard deviation of the camera's orientation after that calibration",
    ),
    metric(
        MetricGroup::Calibration,
        "seating_offset_sigma_mm",
        "standard deviation of the pins' seating offset after that calibration",
    ),
    metric(
        MetricGroup::Press,
        "force_at_1mm_n",
        "force on a ball of 8 mm diameter at an indentation of 1 mm at the tip or the middle of the pad, simulated at small strain",
    ),
    metric(MetricGroup::Press, "stiffness_n_mm", "slope of that ball's force over its indentation"),
    metric(MetricGroup::Press, "bulge_mm", "height by which the surface bulges beside that ball"),
    metric(
        MetricGroup::Press,
        "bond_shear_strain",
        "shear strain at the bond between two layers that bears the largest stress, under that ball",
    ),
    metric(MetricGroup::Press, "bond_shear_kpa", "shear stress at that bond"),
    metric(
        MetricGroup::Checks,
        "check_errors",
        "number of errors of `check`, which keep the sensor from being built",
    ),
    metric(
        MetricGroup::Checks,
        "check_warnings",
        "number of warnings of `check`, which may keep it from being built",
    ),
    metric(
        MetricGroup::Checks,
        "check_notes",
        "number of notes of `check`, which are worth knowing",
    ),
    metric(
        MetricGroup::Checks,
        "overlaps",
        "number of pairs of bodies that overlap without a declared press fit",
    ),
    metric(
        MetricGroup::Checks,
        "undercut_mm2",
        "largest undercut area of a rigid tool behind the cast part",
    ),
    metric(
        MetricGroup::Checks,
        "demolding_strain",
        "largest strain of a soft tool when it is peeled off",
    ),
    metric(
        MetricGroup::Meshes,
        "mesh_triangles",
        "number of triangles of all parts at a chord tolerance of 0.05 mm",
    ),
    metric(
        MetricGroup::Meshes,
        "mesh_volume_mm3",
        "volume of the meshes of all parts, counting their quantities",
    ),
    metric(
        MetricGroup::Meshes,
        "mesh_area_mm2",
        "area of the meshes of all parts, counting their quantities",
    ),
    metric(
        MetricGroup::Bench,
        "depth_mae_mm",
        "mean absolute error of the depth that a small model predicts from simulated images, over pixels that see the indenter: domes, flat gels, and pin tips, where it is the depth of a whole press",
    ),
    metric(
        MetricGroup::Bench,
        "depth_mae_all_mm",
        "mean absolute error of that depth over all pixels that see the surface",
    ),
    metric(
        MetricGroup::Bench,
        "saturated_share",
        "fraction of the pixels that see the indenter in which a dome's image no longer depends on depth: darker by more than the network's input range, or saturated white at rest",
    ),
    metric(
        MetricGroup::Bench,
        "localisation_mm",
        "median distance between the contact point of a ball and a small model's prediction, split by position: half ellipsoids",
    ),
    metric(
        MetricGroup::Bench,
        "force_mae_n",
        "mean absolute error of a small model for a force's three components, in ultraviolet light, for indenters not in its training set: half ellipsoids",
    ),
    metric(
        MetricGroup::Bench,
        "normal_r2",
        "linearity of the normal displacement of dimples over force: R2 of a straight line, dome caps",
    ),
    metric(
        MetricGroup::Bench,
        "lateral_r2",
        "linearity of the lateral displacement of dimples over force: R2 of a straight line, dome caps",
    ),
    metric(
        MetricGroup::Bench,
        "slip_margin_mae",
        "mean absolute error of a small model for the margin to slip, split by trial: dome caps",
    ),
    metric(
        MetricGroup::Bench,
        "quality_one_way_percent",
        "share of depth steps over which a surrogate of the chip's surface quality changes monotonically: pin tips",
    ),
    metric(
        MetricGroup::Bench,
        "edge_angle_deg",
        "mean absolute error of an edge's angle predicted from an image: pin tips",
    ),
    metric(
        MetricGroup::Bench,
        "edge_radius_mm",
        "mean absolute error of an edge's distance predicted from an image: pin tips",
    ),
    metric(
        MetricGroup::Bench,
        "markers_rms_px",
        "rms error of marker positions predicted from the liquid columns, split by position: sheet molds",
    ),
];

/// Returns the metrics of a plan that names none.
pub(crate) fn default_metrics() -> Vec<&'static Metric> {
    METRICS.iter().filter(|metric| !metric.group.is_slow()).collect()
}

/// Former names that plans may still use, with the present ones, which hold for domes and plates.
const FORMER_NAMES: [(&str, &str); 3] = [
    ("dome_position_sigma_mm", "camera_position_sigma_mm"),
    ("dome_rotation_sigma_deg", "camera_rotation_sigma_deg"),
    ("dome_seating_sigma_mm", "seating_offset_sigma_mm"),
];

/// Returns a metric's present name.
pub(crate) fn current_name(name: &str) -> &str {
    FORMER_NAMES.iter().find(|(former, _)| *former == name).map_or(name, |(_, current)| current)
}

/// Returns the metrics that a word names: one, or those of a group.
pub(crate) fn metrics_by_word(word: &str) -> Vec<&'static Metric> {
    let word = current_name(word);
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
pub(crate) struct ComputedMetrics {
    pub values: BTreeMap<String, f64>,
    pub notes: Vec<String>,
}

impl ComputedMetrics {
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
pub(crate) struct MetricsCache {
    checks: fabkit_checks::Memo,
    meshes: meshes::MeshCache,
}

/// Computes metrics, each group once.
pub(crate) fn compute(
    project: &Project,
    wanted: &[&'static Metric],
    shared: &MetricsCache,
    computed: &mut ComputedMetrics,
) -> Result<(), InvalidSolid> {
    let sensor = &project.design.sensor;
    let looks =
        |metric: &&Metric| matches!(metric.group, MetricGroup::Camera | MetricGroup::Markers);
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
            MetricGroup::Camera | MetricGroup::Markers => {
                let Some(view) = &view else { continue };
                match group {
                    MetricGroup::Camera => camera::compute(view, computed),
                    _ => markers::compute(view, computed)?,
                }
            }
            MetricGroup::Masses => masses::compute(sensor, computed)?,
            MetricGroup::Walls => walls::compute(sensor, computed)?,
            MetricGroup::Calibration => calibration::compute(project, computed),
            MetricGroup::Press => press::compute(sensor, computed),
            MetricGroup::Checks => checks::compute(sensor, &shared.checks, computed),
            MetricGroup::Meshes => meshes::compute(sensor, &shared.meshes, computed),
            // The caller computes these.
            MetricGroup::Bench => {}
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
        assert_eq!(metrics_by_word("calibration").len(), 3);
        for (former, current) in FORMER_NAMES {
            assert!(!is_metric(former) && metrics_by_word(former)[0].name == current, "{former}");
        }
        assert!(default_metrics().iter().all(|metric| !metric.group.is_slow()));
    }
}
