//! What the parameters must fulfil together so that things fit, hold and can be made.

use std::f64::consts::{PI, SQRT_2, TAU};

use fabkit_geometry::Process;

use super::housing::relief_edge_mm;
use super::joints::Joints;
use super::layout::Layout;
use super::mold::OVERFLOW_MARGIN_MM;
use super::parameters::Dome;
use super::tooling::{FLANGE_INSET_MM, GROOVE_CORDS, groove_radius_mm};
use crate::blocks::{APART_MM, Joint, PRINTED_WALL_MM, require_castable};
use crate::fits::{Fit, gap_mm};
use crate::hardware::{ORing, Screw, stocked_cords};
use crate::parameters::Report;

/// Least height of the cylinder below a countersink, mm: its edge would not print otherwise.
const SINK_LAND_MM: f64 = 0.25;

/// Thinnest gel that can be poured, mm.
const THINNEST_GEL_MM: f64 = 0.5;

/// Reports every combination that cannot be built.
pub(super) fn check(p: &Dome, report: &mut Report) {
    let layout = Layout::new(p);
    let materials = [
        ("filling_gel.material", &p.filling_gel.material),
        ("transparent_gel.material", &p.transparent_gel.material),
        ("translucent_gel.material", &p.translucent_gel.material),
        ("coat.material", &p.coat.material),
        ("form.silicone_material", &p.form.silicone_material),
    ];
    require_castable(&materials, report);
    contact_module(p, &layout, report);
    envelope(p, &layout, report);
    illumination(p, &layout, report);
    camera(p, &layout, report);
    base(p, &layout, report);
    molds(p, &layout, report);
    tools(p, &layout, report);
}

fn contact_module(p: &Dome, layout: &Layout, report: &mut Report) {
    report.at_most(
        "translucent_gel.thickness",
        p.translucent_gel.thickness,
        layout.surface_radius - layout.tube_radius - THINNEST_GEL_MM,
        "the transparent gel below it needs 0.5 mm above the tube",
    );
    report.at_most(
        "coat.thickness",
        p.coat.thickness,
        p.translucent_gel.thickness.mm() / 2.0,
        "the coat is part of the translucent gel's thickness and must not fill half of it",
    );
    report.at_least(
        "tube.wall",
        p.tube.wall,
        FLANGE_INSET_MM + gap_mm(Process::Fdm, Fit::Free) - gap_mm(Process::Fdm, Fit::Slide) + 0.5,
        "the connector's flange, no wider than the tube, must rest on a lid or holder",
    );
    report.at_most(
        "tube.outer_diameter",
        p.tube.outer_diameter,
        2.0 * layout.diffuser_radius,
        "the tube stands on the diffuser inside the shell",
    );
}

fn envelope(p: &Dome, layout: &Layout, report: &mut Report) {
    let diameter = p.envelope.diameter.mm();
    report.at_most(
        "shell.outer_diameter",
        p.shell.outer_diameter,
        diameter,
        "the shell must stay inside the envelope",
    );
    report.at_most(
        "surface.radius",
        p.surface.radius,
        diameter / 2.0,
        "the sensing surface must stay inside the envelope",
    );
    report.at_most(
        "base.height",
        p.base.height,
        p.base.height.mm() + p.envelope.height.mm() - layout.total_height(),
        "surface, diffuser, gap, LED board and base together must stay inside the envelope",
    );
    report.at_most(
        "shell.wall",
        p.shell.wall,
        layout.shell_radius - layout.tube_radius - gap_mm(Process::Fdm, Fit::Slide),
        "the tube stands inside the shell's bore",
    );
    let joint = Joints::new(p, layout).shell_base;
    let countersink = joint.screw.sink_depth_mm(gap_mm(Process::Fdm, Fit::Snug));
    let head = layout.shell_radius - joint.poses[0].translation_mm().x;
    report.at_least(
        "shell.wall",
        p.shell.wall,
        head + countersink + SINK_LAND_MM,
        "a countersunk M2 head must find material below its cone",
    );
}

fn illumination(p: &Dome, layout: &Layout, report: &mut Report) {
    let (length, width) = (p.leds.length.mm(), p.leds.width.mm());
    let circle = p.leds.circle_radius.mm();
    let reach = layout.shell_bore_radius - APART_MM;
    report.at_most(
        "leds.circle_radius",
        p.leds.circle_radius,
        (reach.powi(2) - (length / 2.0).powi(2)).max(0.0).sqrt() - width / 2.0,
        "the LEDs' outer corners must stay inside the shell's bore",
    );
    report.at_least(
        "leds.circle_radius",
        p.leds.circle_radius,
        p.led_board.bore_radius.mm() + width / 2.0 + 0.2,
        "the LEDs must stand on the board, not over its bore",
    );
    report.at_most(
        "leds.height",
        p.leds.height,
        p.diffuser.height_above_board.mm() - APART_MM,
        "the LEDs stand below the diffuser",
    );
    // Neighbours touch first at their inner corners.
    let step = PI / f64::from(p.leds.count);
    let inner_corner = (length / 2.0).atan2(circle - width / 2.0);
    let most = (PI / ((length / 2.0 + APART_MM).atan2(circle - width / 2.0))).floor();
    report.require(
        inner_corner < step,
        "leds.count",
        || {
            format!(
                "leds.count is {}; at most {most} LEDs of {length} mm fit on a circle of radius \
                 {circle} mm without overlapping",
                p.leds.count
            )
        },
        || format!("write {most}, or change `leds.circle_radius` or `leds.length`"),
    );
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
    let outer_corner = (length / 2.0).atan2(circle + width / 2.0);
    report.at_most(
        "shell.rib_width",
        p.shell.rib_width,
        2.0 * layout.shell_bore_radius * (step - outer_corner).max(0.0).sin() - 2.0 * APART_MM,
        "a rib must fit between two LEDs",
    );
    report.at_most(
        "shell.rib_depth",
        p.shell.rib_depth,
        layout.shell_bore_radius - layout.tube_radius,
        "the ribs must not stand under the tube, in its light",
    );
    report.at_most(
        "led_board.wire_hole_diameter",
        p.led_board.wire_hole_diameter,
        (circle - width / 2.0 - p.led_board.bore_radius.mm()) / 1.5,
        "the wire holes must lie between the board's bore and the LEDs",
    );

    report.at_least(
        "diffuser.notch_radius",
        p.diffuser.notch_radius,
        p.diffuser.bore_radius.mm() + APART_MM,
        "a notch reaches outwards from the bore",
    );
    report.at_most(
        "diffuser.notch_radius",
        p.diffuser.notch_radius,
        layout.tube_bore_radius - 0.2,
        "the filling gel must not run out beside the tube",
    );
    report.at_most(
        "diffuser.notch_width",
        p.diffuser.notch_width,
        1.6 * p.diffuser.bore_radius.mm() * (PI / f64::from(p.diffuser.notches)).sin(),
        "notches must leave a fifth of the bore's edge standing",
    );
}

fn camera(p: &Dome, layout: &Layout, report: &mut Report) {
    let camera = &p.camera;
    let slide = gap_mm(Process::Fdm, Fit::Slide);
    report.at_most(
        "camera.board_size",
        camera.board_size,
        (layout.base_radius - PRINTED_WALL_MM) * SQRT_2 - 2.0 * slide,
        "the board's corners must stay inside the base",
    );
    let head = Screw::M1_6X5.head_diameter_mm();
    report.at_most(
        "camera.screw_spacing",
        camera.screw_spacing,
        camera.board_size.mm() - head,
        "the M1.6 heads must stay on the board",
    );
    report.at_least(
        "camera.screw_spacing",
        camera.screw_spacing,
        camera.holder_size.mm() + (head + 2.0 * APART_MM) / SQRT_2,
        "the M1.6 heads must clear the lens holder",
    );
    report.at_least(
        "led_board.bore_radius",
        p.led_board.bore_radius,
        (camera.holder_size.mm() / SQRT_2).max(camera.barrel_diameter.mm() / 2.0) + 0.5,
        "lens and holder must pass the LED board",
    );
    report.at_most(
        "camera.barrel_diameter",
        camera.barrel_diameter,
        (2.0 * p.diffuser.bore_radius.mm() - 0.6).min(camera.holder_size.mm()),
        "the barrel sits on its holder and must pass the diffuser",
    );
    report.at_most(
        "camera.holder_height",
        camera.holder_height,
        camera.lens_height.mm() - 0.5,
        "the barrel must stand out of its holder",
    );
    report.at_least(
        "camera.depth",
        camera.depth,
        camera.pupil_behind_front.mm() + 0.2,
        "the lens must not touch the filling gel",
    );
    // From the board's seat on the base upwards and downwards there must be room.
    report.at_least(
        "camera.lens_height",
        camera.lens_height,
        camera.lens_height.mm() + layout.camera_board_top_z - layout.base_top_z
            + Screw::M1_6X5.head_height_mm()
            + APART_MM,
        "the camera's screws must end below the LED board",
    );
    let floor = 1.0;
    report.at_most(
        "camera.lens_height",
        camera.lens_height,
        camera.lens_height.mm() + layout.relief_z - layout.bottom_z - floor,
        "the base needs 1 mm of floor below the camera's connector",
    );
    let bite = Screw::M1_6X5.length_mm - camera.board_thickness.mm();
    report.at_most(
        "camera.lens_height",
        camera.lens_height,
        camera.lens_height.mm() + layout.camera_board_bottom_z - layout.bottom_z - bite,
        "the M1.6x5 screws must not stand out of the base's bottom",
    );
}

fn base(p: &Dome, layout: &Layout, report: &mut Report) {
    let joints = Joints::new(p, layout);
    let (nuts, mounts) = (joints.shell_base.holes(), joints.mounting.holes());
    let nut_top = nuts.poses[0].translation_mm().z + nuts.radius_mm;
    let room = layout.camera_board_bottom_z - nut_top - 0.5;
    report.at_least(
        "base.height",
        p.base.height,
        p.base.height.mm() - room,
        "the nuts of the joint need room below the camera board",
    );
    // A nut's hole ends outside of whatever else goes through the base.
    let nut_end = layout.base_radius - nuts.depth_mm - 0.1;
    let pilot = p.camera.screw_spacing.mm() / SQRT_2 + joints.camera.holes().radius_mm;
    report.at_most(
        "camera.screw_spacing",
        p.camera.screw_spacing,
        p.camera.screw_spacing.mm() + (nut_end - pilot) * SQRT_2,
        "the camera's screws must clear the nuts of the joint",
    );
    let corner = relief_edge_mm(p) / SQRT_2;
    report.at_most(
        "base.cable_slot_length",
        p.base.cable_slot_length,
        relief_edge_mm(p) - 0.5,
        "the slot must end inside the recess behind the camera",
    );
    report.at_most(
        "base.cable_slot_width",
        p.base.cable_slot_width,
        p.base.cable_slot_length.mm() - 0.5,
        "the slot's width is its shorter side",
    );
    let m3 = mounts.radius_mm;
    report.at_most(
        "base.mount_radius",
        p.base.mount_radius,
        layout.base_radius - m3 - PRINTED_WALL_MM,
        "a mounting hole needs a wall outside",
    );
    report.at_least(
        "base.mount_radius",
        p.base.mount_radius,
        corner.min(relief_edge_mm(p) / 2.0 + 1.0) + m3 + PRINTED_WALL_MM,
        "a mounting hole must clear the recess behind the camera",
    );
    let depth = mounts.depth_mm;
    report.at_least(
        "base.height",
        p.base.height,
        p.base.height.mm() + 2.5 - depth,
        "an M3 mounting hole needs 2.5 mm of depth below the camera's pocket",
    );
    mount_holes_clear(p, &joints, report);
}

/// Mounting holes stand between the joint's nuts and the camera's screws.
fn mount_holes_clear(p: &Dome, joints: &Joints, report: &mut Report) {
    let [mounts, nuts, screws] =
        [&joints.mounting, &joints.shell_base, &joints.camera].map(Joint::holes);
    let wall = 0.6;
    let mut nearest_nut = f64::INFINITY;
    let mut nearest_screw = f64::INFINITY;
    for mount in mounts.poses {
        let mount = mount.translation_mm();
        for nut in nuts.poses {
            // A nut lies along its radius, so that its distance is that to a line.
            let axis = nut.vector(fabkit_geometry::Vector3::z());
            let along = mount.dot(&axis);
            let beside = (mount.xy() - axis.xy() * along).norm();
            if along > 0.0 {
                nearest_nut = nearest_nut.min(beside - nuts.radius_mm - mounts.radius_mm);
            }
        }
        for screw in screws.poses {
            let apart = (mount.xy() - screw.translation_mm().xy()).norm();
            nearest_screw = nearest_screw.min(apart - screws.radius_mm - mounts.radius_mm);
        }
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
        || format!("write {}, as many as `shell.screws`", p.shell.screws),
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
        || "write a larger radius, or change `camera.screw_spacing` or `base.mount_holes`".into(),
    );
}

fn molds(p: &Dome, layout: &Layout, report: &mut Report) {
    crate::blocks::mold::check(&p.mold, layout.surface_radius, layout.apex_z(), report);
    vents(p, layout, report);
}

/// Vents open between what stands in the mold and the cavity's wall.
fn vents(p: &Dome, layout: &Layout, report: &mut Report) {
    let mold = &p.mold;
    let transparent = layout.transparent_radius - layout.tube_radius;
    if transparent < THINNEST_GEL_MM {
        return; // Reported already; every limit below would follow from it.
    }
    let thinnest = transparent.min(p.translucent_gel.thickness.mm());
    report.at_most(
        "mold.vent_diameter",
        mold.vent_diameter,
        (thinnest - 0.2).min(transparent - 2.0 * (OVERFLOW_MARGIN_MM - FLANGE_INSET_MM)),
        "a vent must open over the gel alone",
    );
    let circle = (layout.tube_radius + layout.transparent_radius) / 2.0;
    let most = (TAU * circle / (mold.vent_diameter.mm() + PRINTED_WALL_MM)).floor();
    report.require(
        f64::from(mold.vents) <= most,
        "mold.vents",
        || {
            format!(
                "mold.vents is {}; at most {most} vents of {} leave walls between them",
                mold.vents, mold.vent_diameter
            )
        },
        || format!("write {most}, or a smaller `mold.vent_diameter`"),
    );
}

fn tools(p: &Dome, layout: &Layout, report: &mut Report) {
    let connector = &p.connector;
    let cord = connector.o_ring_cord.mm();
    report.at_most(
        "connector.plug_length",
        connector.plug_length,
        layout.wall_height,
        "the plug must end in the tube's straight part",
    );
    let bottom_mm = 2.0 * groove_radius_mm(p, layout);
    report.require(
        ORing::on(cord, bottom_mm).is_some(),
        "connector.o_ring_cord",
        || {
            format!(
                "connector.o_ring_cord is {}; no O-ring of that cord is stocked for a groove of \
                 {bottom_mm:.2} mm",
                connector.o_ring_cord
            )
        },
        || {
            format!(
                "cords of {} mm are stocked; or change `connector.o_ring_squeeze`",
                stocked_cords()
            )
        },
    );
    report.at_least(
        "connector.plug_length",
        connector.plug_length,
        GROOVE_CORDS * cord + 2.0 * PRINTED_WALL_MM,
        "the O-ring's groove needs walls on both sides",
    );
    report.at_most(
        "connector.air_channel_diameter",
        connector.air_channel_diameter,
        (2.0 * groove_radius_mm(p, layout)).min(connector.handle_diameter.mm()) - 2.4,
        "the air channel needs 1.2 mm of wall around it",
    );
    report.at_most(
        "connector.handle_diameter",
        connector.handle_diameter,
        2.0 * (layout.tube_radius - FLANGE_INSET_MM) - 1.0,
        "the handle stands on the flange",
    );

    let form = &p.form;
    let lead = form.headroom.mm() + form.plate.mm();
    report.at_least(
        "form.tube_length",
        form.tube_length,
        layout.wall_height + layout.transparent_radius + lead + 4.0,
        "the glass tube must reach from the mold's tip through the bridge",
    );
    report.at_least(
        "form.silicone",
        form.silicone,
        gap_mm(Process::Fdm, Fit::Slide) + form.plate.mm() + 4.0,
        "silicone is poured through windows between the tube's sleeve and the cup",
    );
    report.at_least(
        "form.cup_wall",
        form.cup_wall,
        Screw::M3X4.head_diameter_mm(),
        "the heads of the bridge's M3 screws rest on the wall",
    );
    report.at_most(
        "form.plate",
        form.plate,
        Screw::M3X4.length_mm - 1.5,
        "an M3x4 must bite 1.5 mm into the cup",
    );
    report.at_least(
        "form.tube_rim",
        form.tube_rim,
        gap_mm(Process::Fdm, Fit::Slide) + 0.3,
        "the tube hangs by its rim",
    );
    report.at_least(
        "coating.gap",
        p.coating.gap,
        p.coating.wall.mm() + gap_mm(Process::Fdm, Fit::Slide) + 0.5,
        "the holder's spigot stands between module and container",
    );
}
