//! The plate itself.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Cut, Pose, Process, Solid};

use super::{
    ADAPTER, BESIDE_MM, BOSS_MM, CENTRING_GAP_MM, CENTRING_MM, DOWEL_GAP_MM, DOWEL_MM, GROOVE_MM,
    Plan, WALL_MM,
};
use crate::assembling::{SENSOR, flipped};
use crate::blocks::{BLACK, INTO_MM, copies, holes, marks};
use crate::hardware::SocketScrew;

impl Plan<'_> {
    /// With its holes and its groove, as printed.
    pub(super) fn plate(&self) -> Body {
        let top_z = self.face.bottom_z_mm;
        let disc = Solid::rod(self.radius_mm, [self.bottom_z, top_z]);
        let boss = Solid::rod(
            CENTRING_MM / 2.0 - CENTRING_GAP_MM,
            [self.bottom_z - BOSS_MM, self.bottom_z + INTO_MM],
        );
        let solid = if self.is_iso() { disc.plus(boss.named("boss")) } else { disc };
        let down_mm = top_z - self.bottom_z + if self.is_iso() { BOSS_MM } else { 0.0 };
        let sunk_mm = down_mm - self.thickness_mm;
        let plate = ADAPTER
            .made(Process::Fdm, solid)
            .from("PETG")
            .placed([SENSOR.in_place().lifted(-90.0)])
            .colored(BLACK)
            .lying(flipped())
            .note("the sensor's side down, no supports: the roof of the cable's groove is a bridge")
            .cut(self.screws.sunk(self.thickness_mm, sunk_mm, BESIDE_MM).unmarked());
        let plate = match self.groove() {
            Some(groove) => plate.cut(holes([groove])),
            None => plate,
        };
        let is_cable_inside = self.face.is_cable_inside && self.adapter.cable_width.mm() > 0.0;
        let plate = match is_cable_inside {
            true => plate.cut(self.cable_hole(down_mm)),
            false => plate,
        };
        match self.nuts() {
            Some(nuts) => plate.cut(nuts.held()),
            None => plate.cut(self.flange_holes()),
        }
    }

    /// For a cable that leaves the sensor straight down, through the plate, into the groove's end.
    fn cable_hole(&self, down_mm: f64) -> Cut {
        // Narrower than the groove, whose walls it would touch.
        let radius = 0.4 * self.adapter.cable_width.mm();
        let top_z = self.face.bottom_z_mm;
        let low_z = top_z - down_mm - CUT_OVERLAP_MM;
        let hole = Solid::rod(radius, [low_z, top_z + CUT_OVERLAP_MM]).named("cable hole");
        holes([hole]).with_handles(1)
    }

    /// Four passages and the dowel's hole.
    fn flange_holes(&self) -> Cut {
        let through_mm = self.face.bottom_z_mm - self.bottom_z + 2.0 * CUT_OVERLAP_MM;
        let hole =
            |radius: f64| Solid::cylinder(radius, through_mm).at_z(CUT_OVERLAP_MM - through_mm);
        let bolts = self.bolts();
        let mut tools = copies("bolt hole", &bolts, &hole(SocketScrew::M6.clearance_hole_mm / 2.0));
        let dowel_hole =
            hole(DOWEL_MM / 2.0 + DOWEL_GAP_MM).placed(self.dowel()).named("dowel hole");
        tools.push(dowel_hole);
        Cut { tools, landmarks: marks("bolt", &bolts), handles: bolts.len() as i32 + 1 }
    }

    /// From below the sensor's rim to the plate's.
    fn groove(&self) -> Option<Solid> {
        let width = self.adapter.cable_width.mm();
        let top_z = self.face.bottom_z_mm;
        let from = self.screws.poses.iter().map(|pose| pose.translation_mm().xy().norm());
        let from = match self.face.is_cable_inside {
            true => -width / 2.0,
            false => {
                from.fold(0.0, f64::max) + self.screws.screw.head_diameter_mm() / 2.0 + WALL_MM
            }
        };
        let turn = Pose::rotation_z(self.adapter.cable_angle);
        (width > 0.0 && from < self.radius_mm).then(|| {
            let low = [from, -width / 2.0, top_z - GROOVE_MM];
            let high = [self.radius_mm + 1.0, width / 2.0, top_z + CUT_OVERLAP_MM];
            Solid::cuboid_between(low, high).placed(turn).named("cable groove")
        })
    }
}
