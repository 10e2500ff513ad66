//! Solid of the adapter plate.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, CutFeature, Pose, Process, Solid};

use super::pattern::{BOSS_MM, CENTRING_GAP_MM, CENTRING_MM, DOWEL_GAP_MM, DOWEL_MM};
use super::{ADAPTER, ALONE, AdapterPlan, BESIDE_MM, SINK_MM};
use crate::blocks::{BLACK, INTO_MM, copies, holes, landmarks_at};
use crate::chain_builder::{SENSOR, flipped};

/// Clearance above a head of the sensor's own screws in its pocket, mm.
const ABOVE_HEAD_MM: f64 = 0.3;

impl AdapterPlan<'_> {
    /// Returns the plate with its holes and its slot, as printed.
    pub(super) fn plate(&self) -> Body {
        let (top_z, is_iso) = (self.face.bottom_z_mm, self.is_iso());
        let (outline, reach_mm) = self.outline();
        let mut solid = Solid::prism(outline, [self.bottom_z, top_z]);
        if self.finger().is_some() {
            solid = solid.placed(Pose::rotation_z(self.angle().0));
        }
        if is_iso {
            let boss = Solid::rod(
                CENTRING_MM / 2.0 - CENTRING_GAP_MM,
                [self.bottom_z - BOSS_MM, self.bottom_z + INTO_MM],
            );
            solid = solid.plus(boss.named("boss"));
        }
        // The counterbores of the sensor's screws also pass through the boss.
        let down_mm = top_z - self.bottom_z + if is_iso { BOSS_MM } else { 0.0 };
        let sunk_mm = down_mm - self.thickness_mm;
        let is_prepared = self.nut().is_some() || self.is_above_flange();
        let alone = is_prepared.then(|| ALONE.in_place());
        let placements = [SENSOR.in_place().lifted(-90.0)].into_iter().chain(alone);
        let plate = ADAPTER
            .made(Process::Fdm, solid)
            .with_material("PETG")
            .placed(placements)
            .colored(BLACK)
            .with_bed_orientation(flipped())
            .note("the sensor's side down, no supports")
            .with_supports(false)
            .cut(
                self.screws
                    .counterbore_cut(self.thickness_mm, sunk_mm, SINK_MM)
                    .without_landmarks(),
            );
        let ways = self.slot_tools(reach_mm + 1.0);
        let plate = if ways.is_empty() { plate } else { plate.cut(holes(ways)) };
        let pockets = self.pockets();
        let plate = if pockets.is_empty() { plate } else { plate.cut(holes(pockets)) };
        match self.nuts() {
            Some(nuts) => plate.cut(nuts.thread_cut()),
            None => plate.cut(self.bolt_holes()),
        }
    }

    /// Returns the pockets for the heads of the sensor's own screws.
    fn pockets(&self) -> Vec<Solid> {
        let top_z = self.face.bottom_z_mm;
        let pocket = |([x, y], [radius, height]): &([f64; 2], [f64; 2])| {
            let heights = [top_z - height - ABOVE_HEAD_MM, top_z + CUT_OVERLAP_MM];
            Solid::rod(radius + BESIDE_MM, heights).at(*x, *y, 0.0).named("head pocket")
        };
        self.face.heads.iter().map(pocket).collect()
    }

    /// Returns the holes for the robot's bolts, counterbored where the sensor lies above them, and the dowel's hole.
    fn bolt_holes(&self) -> CutFeature {
        let (top_z, bolt) = (self.face.bottom_z_mm, self.bolt());
        let bolts: Vec<Pose> = self.bolts();
        let through_mm = top_z - self.bottom_z + 2.0 * CUT_OVERLAP_MM;
        let hole = |radius: f64| {
            let heights = [top_z - through_mm + CUT_OVERLAP_MM, top_z + CUT_OVERLAP_MM];
            Solid::rod(radius, heights)
        };
        // The rods below have absolute heights, so only x and y of the bolts count.
        let flat = |pose: &Pose| {
            let at = pose.translation_mm();
            Pose::translation(at.x, at.y, 0.0)
        };
        let places: Vec<Pose> = bolts.iter().map(flat).collect();
        let mut tools = copies("bolt hole", &places, &hole(bolt.clearance_hole_mm / 2.0));
        if self.is_above_flange() {
            let seat_z = top_z - bolt.head_height_mm - BESIDE_MM;
            let sink = Solid::rod(
                bolt.head_diameter_mm / 2.0 + BESIDE_MM,
                [seat_z, top_z + 2.0 * CUT_OVERLAP_MM],
            );
            tools.extend(copies("bolt sink", &places, &sink));
        }
        let dowel = self.dowel();
        let mut handles = bolts.len() as i32;
        if let Some(dowel) = dowel {
            let solid = hole(DOWEL_MM / 2.0 + DOWEL_GAP_MM).placed(flat(&dowel));
            tools.push(solid.named("dowel hole"));
            handles += 1;
        }
        CutFeature { tools, landmarks: landmarks_at("bolt", &bolts), handles }
    }
}
