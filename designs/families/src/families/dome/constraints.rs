//! Constraints between parameters: parts must fit, hold, and be manufacturable.
//!
//! Many limits read `x <= x + a - b`. They state that `b <= a`, and suggest the value of `x` that would satisfy it.

use std::f64::consts::{PI, SQRT_2};

use fabkit_geometry::Process;

use super::electronics::{self, CableSlit};
use super::housing::{self, LEDGE_MM};
use super::molds::{FLANGE_INSET_MM, cup, form, o_ring_seat, vents};
use super::parameters::*;
use super::{DomeLayout, Joints, cable_slot, cavities, mounting, relief_edges_mm};
use crate::blocks::circuit::CHIP_0603;
use crate::blocks::mounting::{Mounting, outside};
use crate::blocks::{APART_MM, PRINTED_WALL_MM, ScrewJoint, half_chord, led_ring};
use crate::fits::Fit;
use crate::hardware::Screw;
use crate::parameters::{RuleReport, limits};

/// Minimum height of the cylinder below a countersink, mm. A thinner edge would not print.
const SINK_LAND_MM: f64 = 0.25;

/// Minimum thickness of gel that can be poured, mm.
const THINNEST_GEL_MM: f64 = 0.5;

/// Reports every combination of parameters that cannot be built.
pub(super) fn check(p: &Dome, report: &mut RuleReport) {
    let layout = DomeLayout::new(p);
    check_contact_module(p, &layout, report);
    check_envelope(p, &layout, report);
    check_illumination(p, &layout, report);
    check_locking_gel(p, &layout, report);
    check_cables(p, &layout, report);
    check_camera(p, &layout, report);
    check_base(p, &layout, report);
    check_molds(p, &layout, report);
    check_tools(p, &layout, report);
}

fn check_contact_module(p: &Dome, layout: &DomeLayout, report: &mut RuleReport) {
    // The connector's flange rests on whatever its plug passes through: each lid, or the holder's slot.
    let lids = [INNER_LID, OUTER_LID].map(|lid| p.making.gap_mm(lid, Process::Fdm, Fit::Slide));
    let slot = p.making.gap_mm(HOLDER, Process::Fdm, Fit::Free);
    let passed = lids.into_iter().fold(slot, f64::max);
    let slide = p.making.gap_mm(CONNECTOR, Process::Fdm, Fit::Slide);
    limits! { report, p:
        translucent_gel.thickness <=
            layout.surface_radius_mm - layout.tube_radius_mm - THINNEST_GEL_MM,
            "the transparent gel below it needs 0.5 mm above the tube";
        coat.thickness <= p.translucent_gel.thickness.mm() / 2.0,
            "the coat is part of the translucent gel's thickness and must not fill half of it";
        tube.wall >= FLANGE_INSET_MM + passed - slide + 0.5,
            "the connector's flange, no wider than the tube, must rest on a lid or holder";
        tube.outer_diameter <= 2.0 * layout.diffuser_radius_mm,
            "the tube stands on the diffuser inside the shell";
    }
}

fn check_envelope(p: &Dome, layout: &DomeLayout, report: &mut RuleReport) {
    let diameter = p.envelope.diameter.mm();
    let joint = Joints::new(p, layout).shell_base;
    let [snug, slide] =
        [Fit::Snug, Fit::Slide].map(|fit| p.making.gap_mm(SHELL, Process::Fdm, fit));
    let countersink = joint.screw.sink_depth_mm(snug);
    let head = layout.shell_radius_mm - joint.poses[0].translation_mm().x;
    limits! { report, p:
        shell.outer_diameter <= diameter, "the shell must stay inside the envelope";
        surface.radius <= diameter / 2.0, "the sensing surface must stay inside the envelope";
        base.height <= p.base.height.mm() + p.envelope.height.mm() - layout.total_height(),
            "surface, diffuser, gap, LED board and base together must stay inside the envelope";
        shell.wall <=
            layout.shell_radius_mm - layout.tube_radius_mm - slide,
            "the tube stands inside the shell's bore";
        shell.edge_fillet <= p.shell.wall.mm() - PRINTED_WALL_MM / 2.0,
            "the gel and the printer's bed need what a rounded edge leaves of the rim";
        shell.wall >= head + countersink + SINK_LAND_MM,
            "a countersunk M2 head must find material below its cone";
    }
}

/// Checks the baffle, the locking gel and its groove.
fn check_locking_gel(p: &Dome, layout: &DomeLayout, report: &mut RuleReport) {
    if p.baffle.wall.mm() > 0.0 {
        let top = layout.gel_face_z_mm.min(layout.diffuser_bottom_z_mm) - p.baffle.gap.mm();
        let above = (top + p.camera.depth.mm()).max(0.0);
        // Radius at the baffle's top of the cone through which the camera sees the whole bore of the diffuser.
        let seen = p.diffuser.bore_radius.mm() * above
            / (p.camera.depth.mm() + layout.diffuser_bottom_z_mm).max(above).max(1e-9);
        let bore = p.led_board.bore_radius.mm();
        limits! { report, p:
            baffle.wall >= PRINTED_WALL_MM, "two lines of the printer";
            baffle.wall <= bore - seen, "the baffle must not hide what the diffuser's bore shows";
            baffle.gap <= p.baffle.gap.mm() + top - layout.board_top_z_mm - 1.0,
                "the baffle stands above the LED board";
        }
    }
    if !housing::has_locking_gel(p) {
        return;
    }
    let room = p.diffuser.height_above_board.mm() - p.leds.height.mm() - APART_MM;
    limits! { report, p:
        filling_gel.lock_depth <= room, "the gel must not touch the LEDs";
        filling_gel.lock_depth <= p.camera.depth.mm() - p.camera.board.pupil_behind_front.mm()
            - p.diffuser.thickness.mm() - 0.2, "the lens must not touch the gel";
        shell.rib_depth >= layout.shell_bore_radius_mm - layout.diffuser_radius_mm
            + 1.5 * LEDGE_MM, "the diffuser rests on the ribs, inside of the step that gel flows over";
        shell.lock_groove <= p.shell.wall.mm() - PRINTED_WALL_MM, "the shell needs a wall behind it";
    }
    if p.shell.lock_groove.mm() > 0.0 {
        limits! { report, p:
            filling_gel.lock_depth >= housing::min_groove_gel_mm(p), "the gel must cover the groove";
        }
    }
}

fn check_illumination(p: &Dome, layout: &DomeLayout, report: &mut RuleReport) {
    if p.shell.shoulder.mm() > 0.0 {
        let beside = layout.shell_bore_radius_mm - layout.diffuser_radius_mm;
        limits! { report, p:
            shell.rib_depth >= beside + LEDGE_MM, "the ribs hold the diffuser inside the shoulder";
            shell.shoulder <= p.shell.shoulder.mm() + layout.diffuser_radius_mm
                - layout.tube_radius_mm,
                "the tube stands on the diffuser";
            shell.shoulder <= p.shell.shoulder.mm() + layout.diffuser_radius_mm
                - p.diffuser.notch_radius.mm() - PRINTED_WALL_MM,
                "the diffuser's notches need a rim outside";
        }
    }
    let (length, width) = (p.leds.length.mm(), p.leds.width.mm());
    let circle = p.leds.circle_radius.mm();
    let bore = (layout.shell_bore_radius_mm, "the shell's bore");
    p.leds.electric.check("leds.forward_volts", [1, p.leds.count], CHIP_0603, report);
    led_ring!(p.leds).check(p.led_board.bore_radius, bore, report);
    report.require(
        p.leds.count.is_multiple_of(p.shell.ribs),
        "shell.ribs",
        || {
            format!(
                "shell.ribs is {}; it must divide the {} LEDs, because every rib stands midway \
                 between two",
                p.shell.ribs, p.leds.count
            )
        },
        || "write a divisor of `leds.count`".into(),
    );
    // Half the angle between two LEDs; a rib stands in the middle of it.
    let step = PI / f64::from(p.leds.count);
    let outer_corner = (length / 2.0).atan2(circle + width / 2.0);
    limits! { report, p:
        leds.height <= p.diffuser.height_above_board.mm() - APART_MM,
            "the LEDs stand below the diffuser";
        shell.rib_width <=
            2.0 * layout.shell_bore_radius_mm * (step - outer_corner).max(0.0).sin()
                - 2.0 * APART_MM,
            "a rib must fit between two LEDs";
        shell.rib_depth <= layout.shell_bore_radius_mm - layout.tube_radius_mm,
            "the ribs must not stand under the tube, in its light";
        led_board.wire_hole_diameter <= (circle - width / 2.0 - p.led_board.bore_radius.mm()) / 1.5,
            "the wire holes must lie between the board's bore and the LEDs";
        diffuser.notch_radius >= p.diffuser.bore_radius.mm() + APART_MM,
            "a notch reaches outwards from the bore";
        diffuser.notch_radius <= layout.tube_bore_radius_mm - 0.2,
            "the filling gel must not run out beside the tube";
        diffuser.notch_width <=
            1.6 * p.diffuser.bore_radius.mm() * (PI / f64::from(p.diffuser.notches)).sin(),
            "notches must leave a fifth of the bore's edge standing";
    }
}

fn check_camera(p: &Dome, layout: &DomeLayout, report: &mut RuleReport) {
    let (camera, led_board) = (&*p.camera.board, &p.led_board);
    let slide = p.making.gap_mm(BASE, Process::Fdm, Fit::Slide);
    let head = Screw::M1_6X5.head_diameter_mm();
    let bite = Screw::M1_6X5.length_mm - camera.board_thickness.mm();
    let within = layout.base_radius_mm - PRINTED_WALL_MM;
    // If the board is not square, the other edge determines how long this one may be.
    let widest = if camera.board_size == camera.board_size_y {
        within * SQRT_2 - 2.0 * slide
    } else {
        2.0 * (half_chord(within, camera.board_size_y.mm() / 2.0 + slide) - slide)
    };
    // In a square pattern the screws lie on the diagonals of the holder. In another, their heads may clear the holder
    // along y alone.
    let apart = head / 2.0 + APART_MM;
    let beside = ((camera.screw_spacing_y.mm() - camera.holder_size.mm()) / 2.0).max(0.0);
    let nearest = match camera.screw_spacing == camera.screw_spacing_y {
        true => camera.holder_size.mm() + (head + 2.0 * APART_MM) / SQRT_2,
        false if beside >= apart => 0.0,
        false => camera.holder_size.mm() + 2.0 * half_chord(apart, beside),
    };
    limits! { report:
        camera.board_size <= widest, "the board's corners must stay inside the base";
        camera.screw_spacing <= camera.board_size.mm() - head,
            "the M1.6 heads must stay on the board";
        camera.screw_spacing_y <= camera.board_size_y.mm() - head,
            "the M1.6 heads must stay on the board";
        camera.screw_spacing >= nearest, "the M1.6 heads must clear the lens holder";
        led_board.bore_radius >=
            layout.passing_radius_mm(p) + 0.5 + p.baffle.wall.mm(),
            lens_clearance_reason(p, layout);
        camera.barrel_diameter <=
            (2.0 * p.diffuser.bore_radius.mm() - 0.6).min(camera.holder_size.mm()),
            "the barrel sits on its holder and must pass the diffuser";
        camera.holder_height <= camera.lens_height.mm() - 0.5,
            "the barrel must stand out of its holder";
    }
    let depth = camera.pupil_behind_front.mm() + 0.2 - layout.gel_face_z_mm;
    report.at_least(
        "camera.depth",
        p.camera.depth,
        depth,
        "the lens must not touch the filling gel",
    );
    limits! { report:
        // Room is needed above and below the board's seat on the base.
        camera.lens_height >= camera.lens_height.mm() + layout.camera_board_top_z_mm
            + Screw::M1_6X5.head_height_mm() + APART_MM - layout.base_top_z_mm,
            "the camera's screws must end below the LED board";
        camera.lens_height <=
            camera.lens_height.mm() + layout.relief_z_mm - layout.bottom_z_mm - 1.0,
            "the base needs 1 mm of floor below the camera's connector";
        camera.lens_height <=
            camera.lens_height.mm() + layout.camera_board_bottom_z_mm - layout.bottom_z_mm - bite,
            "the M1.6x5 screws must not stand out of the base's bottom";
    }
}

/// Explains the smallest bore of the LED board, by what has to pass it.
fn lens_clearance_reason(p: &Dome, layout: &DomeLayout) -> &'static str {
    if layout.is_holder_below(p) {
        "the lens must pass the LED board and its baffle, its holder below them"
    } else {
        "lens and holder must pass the LED board and its baffle"
    }
}

fn check_base(p: &Dome, layout: &DomeLayout, report: &mut RuleReport) {
    let joints = Joints::new(p, layout);
    let nuts = joints.shell_base.holes();
    let nut_top = nuts.poses[0].translation_mm().z + nuts.radius_mm;
    let room = layout.camera_board_bottom_z_mm - nut_top - 0.5;
    // The hole of a nut must end before it meets any other hole through the base.
    let nut_end = layout.base_radius_mm - nuts.depth_mm - 0.1;
    let relief = relief_edges_mm(p);
    let is_square = p.camera.board.screw_spacing == p.camera.board.screw_spacing_y;
    let half = p.camera.board.screw_spacing_y.mm() / 2.0;
    let pilot_radius = joints.camera.holes().radius_mm;
    // Radii that the camera's screws and the corners of the recess reach.
    let (pilot, corner) = if is_square {
        (p.camera.board.screw_spacing.mm() / SQRT_2 + pilot_radius, relief[0] / SQRT_2)
    } else {
        (
            (p.camera.board.screw_spacing.mm() / 2.0).hypot(half) + pilot_radius,
            (relief[0] / 2.0).hypot(relief[1] / 2.0),
        )
    };
    let most_spacing = if is_square {
        p.camera.board.screw_spacing.mm() + (nut_end - pilot) * SQRT_2
    } else {
        2.0 * half_chord(nut_end - pilot_radius, half)
    };
    let m3 = joints.mounting.holes().radius_mm;
    let (base, camera) = (&p.base, &*p.camera.board);
    limits! { report:
        base.height >= base.height.mm() - room,
            "the nuts of the joint need room below the camera board";
        camera.screw_spacing <= most_spacing,
            "the camera's screws must clear the nuts of the joint";
    }
    let mounting = mounting(p, layout);
    if mounting.is_ring() {
        limits! { report, p:
            base.mount_radius >= corner.min(relief[0].max(relief[1]) / 2.0 + 1.0) + m3 + PRINTED_WALL_MM,
                "a mounting hole must clear the recess behind the camera";
        }
    } else {
        let clear =
            |at: &[f64; 2]| outside(*at, relief.map(|edge| edge / 2.0)) - m3 - PRINTED_WALL_MM;
        mounting.require_all(clear, "the wall to the recess behind the camera lacks", report);
    }
    let least = mounting.least_depth_mm();
    let thread = p.mount.thread.word();
    limits! { report, p:
        base.height >= p.base.height.mm() + least - mounting.depth_mm,
            format!("an {thread} mounting hole needs {least} mm of depth below the camera's pocket");
    }
    let outside = layout.base_radius_mm - PRINTED_WALL_MM;
    let wall = (outside, "a mounting hole needs a wall outside");
    mounting.check(wall, PRINTED_WALL_MM, report);
    check_mount_hole_clearance(p, &mounting, &joints, report);
}

/// Minimum bend radius of a wire that is bent once, in wire diameters.
const MIN_BEND_DIAMETERS: f64 = 1.5;

/// Minimum width of the board's rim beside a wire hole, mm.
const BOARD_EDGE_MM: f64 = 0.3;

/// Minimum wall between the cables' slit and screws or nuts, mm.
const SLIT_WALL_MM: f64 = 0.45;

fn check_cables(p: &Dome, layout: &DomeLayout, report: &mut RuleReport) {
    if p.base.cable_exit == CableExit::Floor {
        let relief = relief_edges_mm(p);
        let slot = cable_slot(p);
        let slot_half = p.base.cable_slot_width.mm() / 2.0;
        // Half the slot's extent along x and y. 0.25 mm of the recess stay beyond each of its ends.
        let reach = [0, 1].map(|i| slot.ends()[1][i].abs() + slot_half);
        limits! { report, p:
            base.cable_slot_length <=
                p.base.cable_slot_length.mm() + relief[0] - 0.5 - 2.0 * reach[0],
                "the slot must end inside the recess behind the camera";
            base.cable_slot_length <=
                p.base.cable_slot_length.mm() + relief[1] - 0.5 - 2.0 * reach[1],
                "the slot must end inside the recess behind the camera";
        }
        return slot.check("base.cable_slot_width", report);
    }
    let slit = CableSlit::new(p, layout);
    let wire = electronics::led_wire(p, layout);
    wire.check("cables.wire_bend", p.cables.wire_bend, MIN_BEND_DIAMETERS, report);
    limits! { report, p:
        cables.wire_bend <= p.cables.wire_bend.mm() + wire.least_straight_mm(),
            "the wires turn between the LED board and the cable";
        cables.diameter <= p.cables.diameter.mm() + slit.tongue_z - layout.bottom_z_mm - PRINTED_WALL_MM,
            "the cable's slit needs a floor";
        led_board.wire_hole_diameter <= p.led_board.wire_hole_diameter.mm()
            + layout.board_radius_mm - BOARD_EDGE_MM - electronics::wire_hole_end_radius_mm(p),
            "the wire holes stand beside the camera's board and on the LED board";
    }
    check_slit_clearance(p, layout, &slit, report);
}

/// Requires nuts, mounting holes and the camera's screws to clear the slit.
fn check_slit_clearance(p: &Dome, layout: &DomeLayout, slit: &CableSlit, report: &mut RuleReport) {
    let joints = Joints::new(p, layout);
    let (sin, cos) = p.base.exit_angle.rad().sin_cos();
    let [nuts, mounts, screws] =
        [&joints.shell_base, &joints.mounting, &joints.camera].map(ScrewJoint::holes);
    let beside = |[x, y]: [f64; 2], radius: f64| {
        let (along, across) = (x * cos + y * sin, (y * cos - x * sin).abs());
        // The slit starts at the axis, so behind it the distance is that to its end.
        let off = if along > 0.0 { across } else { across.hypot(along) };
        off - radius - slit.width_mm / 2.0
    };
    // A nut's hole comes nearest to the slit at its inner end.
    let inner = layout.base_radius_mm - nuts.depth_mm;
    let nuts = nuts.poses.iter().map(|pose| {
        let axis = pose.vector(fabkit_geometry::Vector3::z());
        beside([axis.x * inner, axis.y * inner], nuts.radius_mm)
    });
    let other = [mounts, screws].into_iter().flat_map(|holes| {
        holes.poses.iter().map(move |pose| {
            let at = pose.translation_mm();
            beside([at.x, at.y], holes.radius_mm)
        })
    });
    let least = nuts.chain(other).fold(f64::INFINITY, f64::min);
    report.require(
        least >= SLIT_WALL_MM,
        "base.exit_angle",
        || {
            format!(
                "base.exit_angle is {}; {least:.2} mm stay between the cables' slit and a nut, a mounting \
                 hole or a screw of the camera, and {SLIT_WALL_MM} mm are needed",
                p.base.exit_angle
            )
        },
        || "turn it, write a smaller `cables.diameter`, or `base.cable_exit: floor`".into(),
    );
}

/// Requires mounting holes to clear the joint's nuts and the camera's screws.
fn check_mount_hole_clearance(
    p: &Dome,
    mounting: &Mounting,
    joints: &Joints,
    report: &mut RuleReport,
) {
    let [mounts, nuts, screws] =
        [&joints.mounting, &joints.shell_base, &joints.camera].map(ScrewJoint::holes);
    let wall = 0.6;
    let mut nearest_nut = f64::INFINITY;
    let mut nearest_screw = f64::INFINITY;
    for mount in mounts.poses {
        let mount = mount.translation_mm();
        for nut in nuts.poses {
            // A nut lies along a radius, so the distance to it is the distance to a line.
            let axis = nut.vector(fabkit_geometry::Vector3::z());
            let along = mount.dot(&axis);
            let beside = (mount.xy() - axis.xy() * along).norm();
            // Only nuts on the mounting hole's side of the axis are near it.
            if along > 0.0 {
                nearest_nut = nearest_nut.min(beside - nuts.radius_mm - mounts.radius_mm);
            }
        }
        for screw in screws.poses {
            let apart = (mount.xy() - screw.translation_mm().xy()).norm();
            nearest_screw = nearest_screw.min(apart - screws.radius_mm - mounts.radius_mm);
        }
    }
    if !mounting.is_ring() {
        let nearest = nearest_nut.min(nearest_screw);
        return report.require(
            nearest >= wall,
            mounting.radius_parameter(),
            || {
                format!(
                    "{}; {nearest:.2} mm stay between a mounting hole and a nut of the shell or a screw \
                     of the camera, and {wall} mm are needed",
                    mounting.parameter_text()
                )
            },
            || mounting.move_hint(),
        );
    }
    report.require(
        nearest_nut >= wall,
        "base.mount_holes",
        || {
            format!(
                "base.mount_holes is {}; with {} screws in the shell a mounting hole comes within \
                 {nearest_nut:.2} mm of a nut, and {wall} mm are needed",
                p.base.mount_holes, p.shell.screws
            )
        },
        || {
            let screws = p.shell.screws;
            format!("write {screws}, as many as `shell.screws`, or `mount.pattern: rectangle`")
        },
    );
    report.require(
        nearest_screw >= wall,
        "base.mount_radius",
        || {
            format!(
                "base.mount_radius is {}; a mounting hole comes within {nearest_screw:.2} mm of a \
                 camera screw, and {wall} mm are needed",
                p.base.mount_radius
            )
        },
        || "write a larger radius, or change `base.mount_holes`".into(),
    );
}

fn check_molds(p: &Dome, layout: &DomeLayout, report: &mut RuleReport) {
    let cavity = [layout.surface_radius_mm, layout.apex_z()];
    let with_dowels = [INNER_A, INNER_B, INNER_LID, OUTER_A, OUTER_B, OUTER_LID, COLLAR];
    let slide = p.making.widest_gap_mm(with_dowels.map(|part| (part, Process::Fdm)), Fit::Slide);
    crate::blocks::mold::check(&p.mold, slide, cavity, report);
    // The vents open between the core of the mold and the cavity's wall.
    let transparent = layout.transparent_radius_mm - layout.tube_radius_mm;
    if transparent < THINNEST_GEL_MM {
        return; // Reported already; every limit below would follow from it.
    }
    let thinnest = transparent.min(p.translucent_gel.thickness.mm());
    let foot = (thinnest, "a vent must open over the gel alone");
    // The overflow channel lies beside the connector's flange.
    let flange = layout.tube_radius_mm - FLANGE_INSET_MM;
    vents(p, &cavities(p, layout)[0]).check(foot, flange, report);
}

/// Minimum wall of the collar, mm.
const COLLAR_WALL_MM: f64 = 2.0;

fn check_tools(p: &Dome, layout: &DomeLayout, report: &mut RuleReport) {
    let connector = &p.connector;
    let seat = o_ring_seat(p, layout);
    seat.check("connector.o_ring_cord", "groove", "connector.o_ring_squeeze", report);
    if p.molds.route == MoldRoute::Silicone {
        // The wider tube leaves less silicone around it.
        form(p, layout, &cavities(p, layout)[1]).check(report);
        let collar = layout.shell_radius_mm + COLLAR_WALL_MM - cup(p, layout).silicone_radius;
        limits! { report, p:
            form.silicone >= p.form.silicone.mm() + collar,
                "the collar around the shell stands on the silicone";
        }
    } else {
        let dowel = p.mold.dowel_diameter.mm() / 2.0 + p.mold.dowel_inset.mm();
        limits! { report, p:
            mold.width >= 2.0 * (layout.shell_radius_mm + dowel + COLLAR_WALL_MM / 2.0),
                "the collar's dowels stand beside the shell";
        }
    }
    let slide = p.making.gap_mm(CONTAINER, Process::Fdm, Fit::Slide);
    limits! { report, p:
        connector.plug_length <= layout.wall_height_mm,
            "the plug must end in the tube's straight part";
        connector.plug_length >= seat.width_mm() + 2.0 * PRINTED_WALL_MM,
            "the O-ring's groove needs walls on both sides";
        connector.air_channel_diameter <=
            (2.0 * seat.radius_mm).min(connector.handle_diameter.mm()) - 2.4,
            "the air channel needs 1.2 mm of wall around it";
        connector.handle_diameter <= 2.0 * (layout.tube_radius_mm - FLANGE_INSET_MM) - 1.0,
            "the handle stands on the flange";
        coating.gap >= p.coating.wall.mm() + slide + 0.5,
            "the holder's spigot stands between module and container";
    }
}
