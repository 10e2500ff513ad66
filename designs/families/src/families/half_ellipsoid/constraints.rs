//! Constraints between parameters: parts must fit, hold, and be manufacturable.

use std::f64::consts::PI;

use fabkit_geometry::{Angle, Point3, Pose, Process};

use super::electronics::{self, has_board_parts, switch_pocket_radius_mm};
use super::housing::{
    LED_HOLE_MARGIN_MM, PRY_SLOT_MM, RESIN_WALL_MM, diffuser_bore_mm, pocket_radii_mm, wire_row_mm,
    wire_slot,
};
use super::molds::{
    RUNNER_REACH_MM, SILICONE_WALL_MM, half_gate_rad, key_circle_mm, marker_end_centres,
    syringe_seat, vent_circle_mm, vent_radius_at,
};
use super::parameters::{HOLDER, HalfEllipsoid};
use super::{BOLT, HalfEllipsoidLayout, Joints, mounting};
use crate::blocks::circuit::CHIP_0603;
use crate::blocks::listed_markers::{self, RoundPattern, max_angle_deg};
use crate::blocks::sprue::LEAST_WALL_MM;
use crate::blocks::{APART_MM, around, edge, half_chord, turn};
use crate::fits::Fit;
use crate::parameters::{RuleReport, limits};

/// Minimum radius of curvature of a parallel surface at its tip, mm.
const TIP_RADIUS_MM: f64 = 0.3;

/// Reports every combination of parameters that cannot be built.
pub(super) fn check(p: &HalfEllipsoid, report: &mut RuleReport) {
    let layout = HalfEllipsoidLayout::new(p);
    check_layers(p, &layout, report);
    // Everything below is measured from these surfaces.
    if report.is_clean() {
        check_markers(p, &layout, report);
        check_shell(p, &layout, report);
        check_illumination(p, &layout, report);
        check_camera(p, &layout, report);
        check_base(p, &layout, report);
        check_tooling(p, &layout, report);
    }
}

fn check_layers(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout, report: &mut RuleReport) {
    // Every layer of elastomer lies on a smooth parallel surface. Only the shell's inside may be deeper, because a
    // ball mill rounds it.
    let reach = layout.ellipsoid.tip_curvature_radius() - TIP_RADIUS_MM;
    let inner = p.inner_elastomer.thickness.mm();
    limits! { report, p:
        surface.height >= 0.6 * p.surface.diameter.mm(),
            "the surface is a half ellipsoid that is longer than wide";
        inner_elastomer.thickness <= reach + layout.shell_offset_mm + inner,
            "below the tip's radius of curvature a parallel surface has an edge";
        shell.thickness <= layout.foot_radius_mm(layout.shell_offset_mm) - p.camera.diameter.mm(),
            "the shell needs a bore twice as wide as the camera";
    }
}

fn check_markers(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout, report: &mut RuleReport) {
    let markers = &p.markers;
    limits! { report, p:
        markers.straight_depth <=
            p.inner_elastomer.thickness.mm() - markers.wall.mm() - markers.radius.mm(),
            "a slot, its round end included, must end inside its layer";
    }
    if !report.is_clean() {
        return; // Such slots end where there is no surface.
    }
    if markers.pattern == RoundPattern::List {
        return check_listed_markers(p, layout, report);
    }
    if markers.count < 2 {
        return; // A single marker has no neighbour.
    }
    let nearest = |count: u32| nearest_slots_mm(p, layout, count);
    let needed = 2.0 * markers.radius.mm() + markers.wall.mm();
    if nearest(markers.count) >= needed {
        limits! { report, p:
            // Slots must also clear the base circle, which matters if they are few and large.
            markers.radius <= lowest_slot_mm(p, layout) - markers.wall.mm(),
                "the base circle must cut no marker";
        }
        return;
    }
    // Distances shrink with the square root of the count. The search runs downwards from a little above that
    // estimate.
    let scale = (nearest(markers.count) / needed).powi(2);
    let about = (1.1 * scale * f64::from(markers.count)) as u32;
    let fits = |count: &u32| *count < 2 || nearest(*count) >= needed;
    let most = (0..markers.count.min(about + 2)).rev().find(fits);
    report.require(
        false,
        "markers.count",
        || {
            format!(
                "markers.count is {}; two slots come within {:.2} mm from axis to axis, and a slot \
                 and its wall need {needed} mm",
                markers.count,
                nearest(markers.count)
            )
        },
        || {
            format!(
                "write at most {}, or a smaller `markers.radius` or `markers.wall`",
                most.unwrap_or(0)
            )
        },
    );
}

/// Checks listed markers: apart from each other, and clear of the base circle.
fn check_listed_markers(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout, report: &mut RuleReport) {
    let (markers, listed) = (&p.markers, p.markers.listed());
    listed.check_lengths(report);
    let surface = layout.ellipsoid.parallel(layout.inner_offset_mm);
    let lowest = markers.radius.mm() + markers.wall.mm() - 1e-9;
    let most = max_angle_deg(|polar| {
        surface.meridian_point(polar)[1] - markers.straight_depth.mm() * polar.rad().cos() >= lowest
    });
    let or = "`markers.radius` or `markers.wall`";
    listed.check_within(0, most, ("the base circle must cut no marker", or), report);
    let wall = ("a wall must remain between two slots", or);
    let least = 2.0 * markers.radius.mm() + markers.wall.mm();
    listed.check_apart(&marker_end_centres(p, layout), least, wall, report);
}

/// Minimum distance between the round ends of any two of `count` slots, mm. Slots along normals of a convex surface
/// are nearest at their ends.
fn nearest_slots_mm(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout, count: u32) -> f64 {
    let mut counted = p.clone();
    counted.markers.count = count;
    listed_markers::nearest_mm(&marker_end_centres(&counted, layout)).unwrap_or(f64::INFINITY)
}

/// Height of the lowest slot's end centre above the base circle, mm.
fn lowest_slot_mm(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> f64 {
    marker_end_centres(p, layout).iter().map(|end| end.z).fold(f64::INFINITY, f64::min)
}

fn check_shell(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout, report: &mut RuleReport) {
    let head = Joints::new(p, layout).holder.poses[0].translation_mm().x;
    let countersink = BOLT.sink_depth_mm(p.making.gap_mm(HOLDER, Process::Sla, Fit::Snug));
    limits! { report, p:
        shell.shoulder <= p.shell.thickness.mm() - 1.0,
            "the foot below the shoulder needs 1 mm of wall";
        shell.ball_mill_diameter <= 1.8 * layout.bore_radius(),
            "the ball mill must move inside the shell's bore";
        holder.outer_diameter >= 2.0 * (layout.foot_radius_mm(layout.shell_offset_mm) + RESIN_WALL_MM),
            "the shell's shoulder and the elastomers' feet stand on the holder";
        holder.skirt >= layout.holder_radius_mm - head + countersink + RESIN_WALL_MM,
            "a countersunk M1.2 head must find material below its cone";
        holder.skirt <= layout.holder_radius_mm - layout.collar_radius_mm - RESIN_WALL_MM,
            "a step between collar and skirt keeps the electronics apart from the shell";
    }
    let sink = BOLT.sink_diameter_mm(p.making.gap_mm(HOLDER, Process::Sla, Fit::Snug)) / 2.0;
    let inner = [p.holder.skirt.mm() - RESIN_WALL_MM, -layout.step_z_mm];
    let fed = layout.holder_radius_mm - layout.foot_radius_mm(layout.black_offset_mm);
    limits! { report, p:
        holder.edge_fillet <= edge::max_radius_sparing_mm(inner), "the skirt below the step needs its wall";
        holder.edge_fillet <= -layout.bolt_z_mm - sink - RESIN_WALL_MM,
            "the edge must end above the bolts' heads";
    }
    let because = "the elastomers' feet stand on what a rounded edge leaves of the top";
    report.at_most_or_absent("holder.edge_fillet", p.holder.edge_fillet, fed, because);
}

fn check_illumination(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout, report: &mut RuleReport) {
    for (electric, kind) in electronics::electric_by_kind(p).into_iter().zip(["white", "uv"]) {
        let forward = format!("leds.{kind}_forward_volts");
        electric.check(&forward, [p.leds.pairs, 2 * p.leds.pairs], CHIP_0603, report);
    }
    let radius = p.leds.diameter.mm() / 2.0;
    let count = f64::from(2 * p.leds.pairs);
    let circle = p.leds.circle_radius.mm();
    // Wide LEDs touch their neighbours before they touch the diffuser's bore.
    let room = (circle * (PI / count).sin()).min(circle - diffuser_bore_mm(p, layout) - APART_MM);
    limits! { report, p:
        leds.circle_radius <= layout.diffuser_wall_radius_mm - APART_MM - radius,
            "the LEDs stand inside the diffusion ring's wall";
        leds.diameter <= 2.0 * (room - APART_MM / 2.0),
            format!("{count} LEDs on one circle around the camera must not overlap");
        // The hole over a UV LED leaves a bridge of the plate to its neighbours.
        leds.pairs <= around(circle, 2.0 * (radius + LED_HOLE_MARGIN_MM) + RESIN_WALL_MM),
            "the holes over UV LEDs need bridges between them";
    }
}

fn check_camera(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout, report: &mut RuleReport) {
    limits! { report, p:
        camera.front_depth <= -layout.diffuser_top_z_mm,
            "the diffusion ring must not stand in the camera's view";
        camera.length <= layout.camera_front_z_mm - layout.post_end_z_mm - 1.0,
            "the camera rests in its post, above the passage for the cable";
        camera.cable_diameter <=
            p.camera.cable_diameter.mm()
                + 2.0 * (layout.post_bore_radius_mm - layout.cable_radius_mm) - 0.2,
            "the camera rests on the step around its cable";
        camera.diameter <=
            2.0 * (layout.bore_radius() - layout.post_radius_mm) + p.camera.diameter.mm() - 1.0,
            "light passes between the post and the shell's bore";
        camera_holder.socket_depth <= layout.base_top_z_mm - layout.bottom_z_mm - 1.0,
            "the post's socket needs a floor";
    }
}

fn check_base(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout, report: &mut RuleReport) {
    let [pocket_inner, pocket_outer] = pocket_radii_mm(p, layout);
    let joints = Joints::new(p, layout);
    let (bolts, mounts) = (joints.holder.holes(), joints.mounting.holes());
    let bolt_end = bolts.poses[0].translation_mm().x - bolts.depth_mm;
    let width = p.base.wire_slot_width.mm();
    let (middle, half) = (wire_slot(p, layout).at, p.base.wire_slot_length.mm() / 2.0);
    let slot = middle[0].hypot(middle[1]) + width / 2.0;
    let mount = mounts.radius_mm;
    limits! { report, p:
        base.wire_slot_width <=
            (pocket_outer - pocket_inner - 0.2).min(bolt_end - pocket_inner - 0.6),
            "the wires' slot opens into the pocket, inside the bolts";
        base.wire_slot_length >= wire_row_mm(p),
            "the wires pass the slot side by side";
        led_board.wire_diameter <= width - 0.1, "the wires pass the slot";
        led_board.wire_hole_diameter <= width - 0.1, "the board's holes stand over the slot";
        base.wire_slot_length <= 2.0 * half_chord(pocket_outer, slot),
            "the wires' slot opens into the pocket";
    }
    if has_board_parts(p) {
        limits! { report, p:
            led_board.parts_height <= p.base.pocket_depth.mm() - 0.05,
                "switch and resistors hang into the pocket";
            base.pocket_depth >= p.base.pocket_depth.mm() + switch_pocket_radius_mm(p, layout) - pocket_outer,
                "the pocket must be wide enough for the switch";
        }
    }
    let outside = layout.holder_radius_mm - PRY_SLOT_MM[0] - RESIN_WALL_MM;
    let wall = (outside, "mounting holes need a wall beside the pry slots");
    let mounting = mounting(p);
    mounting.check(wall, RESIN_WALL_MM, report);
    report.require(
        mounting.least_depth_mm() <= mounting.depth_mm,
        "mount.thread",
        || {
            format!(
                "mount.thread is {}; it needs holes {:.1} mm deep, and the base has {} mm",
                p.mount.thread.word(),
                mounting.least_depth_mm(),
                mounting.depth_mm
            )
        },
        || "write `M2`, `M2.5` or `M3`".into(),
    );
    if !mounting.is_ring() {
        let clear = |at: &[f64; 2]| {
            at[0].hypot(at[1]) - layout.cable_radius_mm - mounting.hole_mm() - RESIN_WALL_MM
        };
        mounting.require_all(clear, "the wall to the passage of the camera's cable lacks", report);
    }
    // In the frame turned back by the cable's angle, the slot lies along y at x > 0. It is treated as a rectangle,
    // whose corners bound its rounded ends.
    let back = Pose::rotation_z(Angle::from_rad(-p.base.cable_angle.rad()).expect("finite"));
    let to_slot = |at: Point3<f64>| {
        let at = back.point(at);
        let dx = (at.x - slot).max(slot - width - at.x).max(0.0);
        dx.hypot((at.y.abs() - half).max(0.0))
    };
    check_bolt_clearance(p, bolts.poses, &to_slot, bolts.radius_mm, bolt_end, report);
    let clearance = mounts
        .poses
        .iter()
        .map(|pose| to_slot((*pose.translation_mm()).into()) - mount)
        .fold(f64::INFINITY, f64::min);
    report.require(
        clearance >= RESIN_WALL_MM,
        mounting.radius_parameter(),
        || {
            format!(
                "{}; a mounting hole comes within {clearance:.2} mm of the wires' slot, and \
                 {RESIN_WALL_MM} mm are needed",
                mounting.parameter_text()
            )
        },
        || {
            if mounting.is_ring() {
                "write a larger radius, or change `base.cable_angle`, `mount.angle`, \
                 `base.mount_holes` or `base.wire_slot_length`"
                    .into()
            } else {
                format!(
                    "{}, or change `base.cable_angle` or `base.wire_slot_length`",
                    mounting.move_hint()
                )
            }
        },
    );
    // Mounting holes end below the bolts, unless they are well between them.
    let between = layout.bolt_z_mm - bolts.radius_mm - RESIN_WALL_MM - layout.bottom_z_mm;
    let nearest_turn = mounting
        .places()
        .into_iter()
        .flat_map(|at| (0..p.base.bolts).map(move |j| (at, turn(j, p.base.bolts, 0.0).rad())))
        .map(|([x, y], bolt)| {
            ((x * bolt.sin() - y * bolt.cos()).abs(), x * bolt.cos() + y * bolt.sin())
        })
        .filter(|(_, same_side)| *same_side > 0.0)
        .map(|(beside, _)| beside - mount - bolts.radius_mm)
        .fold(f64::INFINITY, f64::min);
    report.require(
        between >= mounts.depth_mm || nearest_turn >= RESIN_WALL_MM,
        mounting.turn_parameter(),
        || {
            let what = if mounting.is_ring() {
                format!("base.mount_holes is {}", p.base.mount_holes)
            } else {
                mounting.parameter_text()
            };
            format!(
                "{what}; a hole comes within {:.2} mm of a bolt, and {RESIN_WALL_MM} mm are needed",
                nearest_turn.max(0.0)
            )
        },
        || match mounting.is_ring() {
            true if p.base.mount_holes == p.base.bolts => "change `mount.angle`".into(),
            true => format!("write {}, as many as `base.bolts`", p.base.bolts),
            false => mounting.move_hint(),
        },
    );
}

/// Steps of the ternary search for the nearest point of a bolt. Each keeps two thirds of the interval.
const SEARCH_STEPS: u32 = 60;

/// Requires the wires' slot to clear the bolts, which have the radius `radius_mm` and end `bolt_end` mm from the
/// axis.
fn check_bolt_clearance(
    p: &HalfEllipsoid,
    bolts: &[Pose],
    to_slot: &impl Fn(Point3<f64>) -> f64,
    radius_mm: f64,
    bolt_end: f64,
    report: &mut RuleReport,
) {
    let nearest = |pose: &Pose, aside: f64| {
        let head = pose.translation_mm().xy();
        let out = head.norm();
        let way = head / out;
        let at = |along: f64| {
            let aside = aside * radius_mm;
            let [x, y] = [along * way.x - aside * way.y, along * way.y + aside * way.x];
            to_slot(Point3::new(x, y, 0.0))
        };
        // Along a line, the distance to a convex shape has a single minimum.
        let (mut low, mut high) = (bolt_end.min(out), out);
        for _ in 0..SEARCH_STEPS {
            let third = (high - low) / 3.0;
            if at(low + third) <= at(high - third) { high -= third } else { low += third }
        }
        at(low)
    };
    // Lines along the bolt: its axis, its sides, and half way between.
    let lines = bolts.iter().flat_map(|bolt| [-1.0, -0.5, 0.0, 0.5, 1.0].map(|side| (bolt, side)));
    let clearance = lines.map(|(bolt, side)| nearest(bolt, side)).fold(f64::INFINITY, f64::min);
    report.require(
        clearance >= RESIN_WALL_MM,
        "base.cable_angle",
        || {
            format!(
                "base.cable_angle is {}; a bolt comes within {:.2} mm of the wires' slot, and \
                 {RESIN_WALL_MM} mm are needed",
                p.base.cable_angle,
                clearance.max(0.0)
            )
        },
        || {
            format!(
                "write 0 deg, where a bolt ends outside of the slot, an angle between two of the {} \
                 bolts, or change `base.wire_slot_length`",
                p.base.bolts
            )
        },
    );
}

// ------ Tooling ------
//
// Silicone molds, their negatives, and the channels that lead into them.

pub(super) fn check_tooling(
    p: &HalfEllipsoid,
    layout: &HalfEllipsoidLayout,
    report: &mut RuleReport,
) {
    let tooling = &p.tooling;
    let key = tooling.key_diameter.mm() / 2.0;
    let surface = layout.foot_radius_mm(layout.black_offset_mm);
    let foot = layout.inner_offset_mm - layout.shell_offset_mm;
    let beside = RUNNER_REACH_MM + SILICONE_WALL_MM;
    let mouth = syringe_seat(p).mouth_mm();
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
    // Vents and gates alternate. A vent is widest at the foot.
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
