//! Checks whether the holes, heads, nuts and cables of an adapter fit beside each other.

use fabkit_geometry::{Angle, Path};

use super::pattern::{CIRCLE_MM, FLANGE_MM, TONGUE_MM};
use super::{AdapterPattern, AdapterPlan, BESIDE_MM, WALL_MM};
use crate::blocks::Rect;
use crate::blocks::mounting::outside;
use crate::parameters::RuleReport;

/// Plastic between a slot and the sink of a head, mm: one line of a nozzle.
const LINE_MM: f64 = 0.4;

/// Step of the angles that are tried for a hint, degrees.
const STEP_DEG: f64 = 5.0;

/// Conflict between features of the plate.
struct FitConflict {
    path: &'static str,
    message: String,
    hint: &'static str,
}

impl AdapterPlan<'_> {
    /// Reports features that do not fit beside each other.
    pub(super) fn check(&self, report: &mut RuleReport) {
        if let Some(trouble) = self.find_conflict() {
            let hint = self.turned_hint().unwrap_or_else(|| trouble.hint.into());
            report.require(false, trouble.path, || trouble.message, || hint);
        }
    }

    /// Finds the nearest angle at which everything fits, and returns it as a hint.
    fn turned_hint(&self) -> Option<String> {
        // 36 steps of 5 degrees to either side cover a full turn.
        let steps = (1..=36).flat_map(|step| [f64::from(step), -f64::from(step)]);
        let to = |angle: Angle, step: f64| {
            let deg = angle.deg() + step * STEP_DEG;
            Angle::from_deg(deg - 360.0 * (deg / 360.0).round())
        };
        let ((angle, path), cable) = (self.angle(), self.adapter.cable_angle);
        let fits = |plan: &Self| plan.find_conflict().is_none();
        for step in steps {
            let turned = to(angle, step)?;
            if fits(&self.with_angles(turned, cable)) {
                return Some(format!("`{path}: {turned}` fits"));
            }
            let turned = to(cable, step)?;
            if fits(&self.with_angles(angle, turned)) {
                return Some(format!("`adapter.cable_angle: {turned}` fits"));
            }
        }
        None
    }

    /// Finds the first conflict.
    fn find_conflict(&self) -> Option<FitConflict> {
        self.too_wide()
            .or_else(|| self.nuts_in_screws())
            .or_else(|| self.slot_in_holes())
            .or_else(|| self.cables_in_heads())
    }

    /// Checks that the sensor is narrow enough for the finger, or leaves room for the flange's bolts.
    fn too_wide(&self) -> Option<FitConflict> {
        let wide_mm = 2.0 * self.face.radius_mm();
        if self.finger().is_some() {
            return (!self.is_for_finger()).then(|| FitConflict {
                path: "adapter.pattern",
                message: format!(
                    "adapter.pattern: the sensor is {wide_mm:.2} mm wide and held by screws beyond \
                     {FLANGE_MM} mm from its axis, too wide for a finger"
                ),
                hint: "write `adapter.pattern: iso-9409-1-50-4-m6`",
            });
        }
        if !self.is_iso() || self.is_above_flange() {
            return None;
        }
        let gap = |at: [f64; 2]| {
            let Rect { half, corner } = self.face.outline;
            outside(at, half.map(|half| half - corner))
                - corner
                - self.bolt().head_diameter_mm / 2.0
        };
        let least = self.bolt_places().into_iter().map(gap).fold(f64::INFINITY, f64::min);
        (least < BESIDE_MM).then(|| FitConflict {
            path: "adapter.pattern",
            message: format!(
                "adapter.pattern: the sensor, up to {wide_mm:.2} mm wide, leaves {least:.2} mm to one of \
                 the M6 heads on their circle of {CIRCLE_MM} mm, and {BESIDE_MM} mm are needed between the \
                 M6 heads and it"
            ),
            hint: "make the sensor narrower, or write `adapter.pattern: rectangle`",
        })
    }

    /// Returns the positions of the robot's bolts, mm.
    fn bolt_places(&self) -> Vec<[f64; 2]> {
        self.bolts().iter().map(|pose| pose.translation_mm().xy().into()).collect()
    }

    /// Returns the positions of the sensor's screws, mm.
    fn screw_places(&self) -> Vec<[f64; 2]> {
        self.screws.poses.iter().map(|pose| pose.translation_mm().xy().into()).collect()
    }

    /// Checks the walls between nuts and the sensor's screws.
    fn nuts_in_screws(&self) -> Option<FitConflict> {
        let nut = self.nut()?.diameter_mm / 2.0;
        let screws = self.screw_places();
        let apart = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let places = self.nut_places();
        let pairs = places.iter().flat_map(|at| screws.iter().map(|own| apart(own, at)));
        let least = pairs.fold(f64::INFINITY, f64::min) - self.sink_mm() - nut;
        // Robotiq's pattern is placed at exactly this distance: rounding must not refuse it.
        (least < WALL_MM - 1e-9).then(|| FitConflict {
            path: "adapter.width",
            message: format!(
                "adapter.width is {}; {least:.2} mm stay between a nut and a screw of the sensor, and \
                 {WALL_MM} mm are needed",
                self.adapter.width
            ),
            hint: "change `adapter.width`, `adapter.depth` or `adapter.angle`",
        })
    }

    /// Checks that the cable slot is wide enough and stays clear of bolts, nuts and screws.
    fn slot_in_holes(&self) -> Option<FitConflict> {
        let least_mm = self.face.least_slot_mm();
        if self.adapter.cable_width.mm() < least_mm {
            return Some(FitConflict {
                path: "adapter.cable_width",
                message: format!(
                    "adapter.cable_width is {}; the cables that leave through the mounting face need a \
                     slot of {least_mm:.2} mm",
                    self.adapter.cable_width
                ),
                hint: "write a wider one",
            });
        }
        let nut = self.nut().map_or(0.0, |nut| nut.diameter_mm / 2.0);
        let bolt = self.bolt().head_diameter_mm / 2.0;
        let with = |places: Vec<[f64; 2]>, radius: f64, wall_mm: f64| {
            places.into_iter().map(move |at| (at, radius, wall_mm)).collect::<Vec<_>>()
        };
        let dowel = self.dowel().map(|pose| pose.translation_mm().xy().into());
        let all = [
            with(self.bolt_places(), bolt, BESIDE_MM),
            with(dowel.into_iter().collect(), bolt, BESIDE_MM),
            with(self.nut_places(), nut, BESIDE_MM),
            with(self.screw_places(), self.sink_mm(), LINE_MM),
        ];
        let spare = |(at, radius, wall_mm): ([f64; 2], f64, f64)| {
            (self.distance_to_slots(at, radius), wall_mm)
        };
        let pairs = all.into_iter().flatten().map(spare);
        let least = pairs.min_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)))?;
        (least.0 < least.1).then(|| FitConflict {
            path: "adapter.cable_angle",
            message: format!(
                "adapter.cable_angle is {}; the cables' slot passes a screw at {:.2} mm, and {} mm are \
                 needed",
                self.adapter.cable_angle, least.0, least.1
            ),
            hint: "change `adapter.cable_angle`, `adapter.angle` or `adapter.cable_width`",
        })
    }

    /// Returns the bodies that stand on the plate beside the sensor: position, and radius and height, mm.
    fn bodies_beside_sensor(&self) -> Vec<([f64; 2], [f64; 2])> {
        let bolt = self.bolt();
        match self.adapter.pattern {
            AdapterPattern::Iso50 if !self.is_above_flange() => {
                let size = [bolt.head_diameter_mm / 2.0, bolt.head_height_mm];
                self.bolt_places().into_iter().map(|at| (at, size)).collect()
            }
            AdapterPattern::FrankaHand => {
                let half = self.finger().map_or(0.0, |finger| finger.half_mm);
                let places = self.bolt_places();
                let middle = [0, 1].map(|i| places.iter().map(|at| at[i]).sum::<f64>() / 2.0);
                vec![(middle, [half, TONGUE_MM[1]])]
            }
            _ => Vec::new(),
        }
    }

    /// Checks that cables at the side stay clear of bodies on the plate.
    fn cables_in_heads(&self) -> Option<FitConflict> {
        let gaps = self
            .bodies_beside_sensor()
            .into_iter()
            .map(|(at, size)| self.distance_to_cables(at, size));
        let least = gaps.fold(f64::INFINITY, f64::min);
        let what = if self.is_iso() { "an M6 head" } else { "the gripper's carriage" };
        let (angle, path) = self.angle();
        (least < BESIDE_MM).then(|| FitConflict {
            path,
            message: format!(
                "{path} is {angle}; the sensor's cable leaves over the plate, {least:.2} mm beside {what}, \
                 and {BESIDE_MM} mm are needed"
            ),
            hint: "turn the robot's pattern, or let the cable leave on another side",
        })
    }

    /// Returns the plate's outline seen from above, and its reach from the axis, mm.
    pub(super) fn outline(&self) -> (Path, f64) {
        let face = self.face;
        let nut = self.nut().map_or(0.0, |nut| nut.diameter_mm / 2.0) + WALL_MM;
        let nuts = self.nut_places();
        if let Some(finger) = self.finger() {
            return self.keyhole(finger.half_mm, face.radius_mm());
        }
        if face.replaced_screw_mm.is_some() {
            let furthest = |i: usize| nuts.iter().map(|at| at[i].abs() + nut).fold(0.0, f64::max);
            let half = [0, 1].map(|i| face.outline.half[i].max(furthest(i)));
            let rect = Rect { half, ..face.outline };
            return (rect.path(), half[0].hypot(half[1]));
        }
        let out = nuts.iter().map(|[x, y]| x.hypot(*y) + nut).fold(0.0, f64::max);
        let radius = if self.is_iso() { FLANGE_MM } else { out.max(face.radius_mm()) };
        (Path::circle([0.0; 2], radius), radius)
    }

    /// Returns the outline of a disc below the sensor with a bar to the finger's screws, along x.
    fn keyhole(&self, half: f64, radius: f64) -> (Path, f64) {
        // The disc has to be wider than the bar, or their outlines would not meet.
        let radius = radius.max(half + 1.0);
        let beyond = self.finger().map_or(0.0, |finger| finger.beyond_mm);
        let outer = match self.adapter.pattern {
            AdapterPattern::Robotiq85 => self.finger().map_or(0.0, |f| f.apart_mm / 2.0),
            _ => 0.0,
        };
        let end = (self.middle_mm() + outer + beyond).max(radius + 1.0);
        let neck = (radius.powi(2) - half.powi(2)).sqrt();
        let path = Path::from([end, -half])
            .line([end, half])
            .line([neck, half])
            .arc([-radius, 0.0], [0.0; 2], true)
            .arc([neck, -half], [0.0; 2], true)
            .close();
        (path, end)
    }
}
