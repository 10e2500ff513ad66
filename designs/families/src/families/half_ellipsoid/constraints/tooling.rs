//! Molds, their negatives, and what leads into them.

use std::f64::consts::PI;

use crate::blocks::around;
use crate::blocks::sprue::LEAST_WALL_MM;
use crate::families::half_ellipsoid::layout::Layout;
use crate::families::half_ellipsoid::parameters::HalfEllipsoid;
use crate::families::half_ellipsoid::runner::{REACH_MM, SILICONE_WALL_MM, half_gate_rad, seat};
use crate::families::half_ellipsoid::tooling::{key_circle_mm, vent_circle_mm, vent_radius_at};
use crate::parameters::{Report, limits};

pub(super) fn check(p: &HalfEllipsoid, layout: &Layout, report: &mut Report) {
    let tooling = &p.tooling;
    let key = tooling.key_diameter.mm() / 2.0;
    let surface = layout.foot_of(layout.black_offset_mm);
    let foot = layout.inner_offset_mm - layout.shell_offset_mm;
    let beside = REACH_MM + SILICONE_WALL_MM;
    let mouth = seat(p).mouth_mm();
    limits! { report, p:
        tooling.silicone_diameter >= 2.0 * (surface + 2.0 * key + 2.0 * beside),
            "keys stand between the ring of the sprue and the side, half a millimetre from the one";
        tooling.silicone_diameter >= 2.0 * surface + 4.0 * (mouth + 1.0),
            "the syringe's seat needs a wall of 1 mm";
        tooling.core_flange >= LEAST_WALL_MM, "it holds 3 mm of a syringe's tip";
        tooling.key_height <= 0.8 * key / 20f64.to_radians().tan(),
            "a key is a frustum: its sides meet above that";
        tooling.keys <= around(key_circle_mm(layout), 2.0 * key + 1.0),
            "keys stand side by side on their circle";
        tooling.keys <= around(key_circle_mm(layout), 2.0 * (key + mouth + SILICONE_WALL_MM)) / 2.0,
            "the syringe's seat lies between two keys";
        tooling.core_flange <= 10.0 * p.tooling.vent_diameter.mm(),
            "the pins that leave the vents must stand while silicone is poured around them";
        tooling.vent_diameter <= foot - 0.1, "a vent opens over the inner elastomer's foot alone";
    }
    // Vents and gates alternate, and a vent is widest at the foot.
    let circle = vent_circle_mm(layout);
    let step = PI / f64::from(tooling.vents);
    let gate = circle * (step - half_gate_rad(layout)).sin() - vent_radius_at(p, 0.0);
    let along = 2.0 * circle * step.sin() - tooling.vent_diameter.mm();
    let wall = gate.min(along);
    report.require(
        wall >= SILICONE_WALL_MM,
        "tooling.vents",
        || {
            format!(
                "tooling.vents is {}; vents of {} come within {:.2} mm of each other or of the gates \
                 between them, and {SILICONE_WALL_MM} mm of silicone are needed",
                tooling.vents, tooling.vent_diameter, wall
            )
        },
        || "write fewer, or a smaller `tooling.vent_diameter`".into(),
    );
}
