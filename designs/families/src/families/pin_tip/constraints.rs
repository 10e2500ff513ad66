//! Constraints between parameters: parts must fit, hold, and be manufacturable.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_8, PI, SQRT_2};

use fabkit_geometry::{Angle, Process};

use super::housing::pin_root_mm;
use super::parameters::{BODY, PinTip};
use super::{Joints, PinTipLayout, electronics, half_diagonal_mm, lens_play_mm};
use crate::blocks::circuit::CHIP_0402;
use crate::blocks::listed_markers::{RoundPattern, max_angle_deg};
use crate::blocks::{APART_MM, PRINTED_WALL_MM, led_ring};
use crate::fits::Fit;
use crate::parameters::{RuleReport, limits};

/// Minimum gap between neighbouring dots, mm: support material must come out of it, and the camera must resolve it.
const DOTS_APART_MM: f64 = 0.3;

/// Reports every combination of parameters that cannot be built.
pub(super) fn check(p: &PinTip, report: &mut RuleReport) {
    let layout = PinTipLayout::new(p);
    check_pins(p, &layout, report);
    check_tip(p, &layout, report);
    p.bayonet.check(&layout.tip_joint, report);
    check_illumination(p, &layout, report);
    check_view(p, &layout, report);
    check_housing(p, &layout, report);
    check_mount(p, &layout, report);
    electronics::check_controller(p, &layout, report);
}

fn check_pins(p: &PinTip, layout: &PinTipLayout, report: &mut RuleReport) {
    let half = layout.pin_diameter_mm / 2.0;
    // The rim of a pin's root is the point of the pin nearest to the skin's outside.
    let room =
        layout.outer_radius_mm.hypot(half) - (half * half + layout.skin_radius_mm.powi(2)).sqrt();
    let radius = layout.skin_radius_mm;
    let reach = radius * FRAC_PI_2 - half;
    let is_listed = p.pins.pattern == RoundPattern::List;
    // Pins point at the centre, so the distance between neighbours shrinks in proportion to their distance from it.
    let depth = if is_listed {
        radius
    } else {
        radius * (1.0 - (layout.pin_diameter_mm + DOTS_APART_MM) / closest_pins_mm(p, layout))
    };
    if is_listed {
        check_listed_pins(p, layout, reach, report);
    } else {
        limits! { report, p:
            pins.reach <= reach, "a pin that stands lower misses the skin";
        }
    }
    limits! { report, p:
        skin.thickness >= p.skin.thickness.mm() + pin_root_mm(p) - room + APART_MM,
            "the pins' roots must stay inside the skin";
        pins.length <= depth - p.pins.dot_thickness.mm(),
            "the dots, which come closer the longer the pins are, must stay 0.3 mm apart";
    }
}

/// Checks listed pins: on the skin, which ends `reach_mm` from the apex along its inside, visible, and apart from
/// each other.
fn check_listed_pins(p: &PinTip, layout: &PinTipLayout, reach_mm: f64, report: &mut RuleReport) {
    let listed = p.pins.listed();
    listed.check_lengths(report);
    let arc_mm = |polar: Angle| polar.rad() * layout.skin_radius_mm;
    let tangent = PinTipLayout::usable_tangent(p);
    let is_seen = |polar: Angle| {
        let [rim, rim_z] = layout.dot_outer_point(p, arc_mm(polar));
        rim <= layout.ray_radius(tangent, rim_z) + 1e-9
    };
    let on_skin = (reach_mm / layout.skin_radius_mm).to_degrees();
    let seen = max_angle_deg(is_seen);
    let told = if seen < on_skin {
        (
            "the pixels must see all of its dot through lens and gel, within `camera.margin`",
            "`camera.depth`",
        )
    } else {
        ("a pin that stands lower misses the skin", "`tip.diameter`")
    };
    listed.check_within(0, seen.min(on_skin), told, report);
    let apart = (
        "the dots, which come closer the longer the pins are, must stay 0.3 mm apart",
        "`pins.length`, `pins.layout` or, in the layout `free`, `pins.diameter`",
    );
    let least = layout.pin_diameter_mm + DOTS_APART_MM;
    listed.check_apart(&layout.dot_ends(p), least, apart, report);
}

/// Smallest distance between two pins at the skin's inside, mm. Circles are spaced along the surface, pins of one
/// circle by their chord.
fn closest_pins_mm(p: &PinTip, layout: &PinTipLayout) -> f64 {
    let spacing = layout.pin_spacing_mm;
    // Chord between two circles. Pins on neighbouring circles are never nearer than that.
    let across = 2.0 * layout.skin_radius_mm * (spacing / (2.0 * layout.skin_radius_mm)).sin();
    (1..=layout.pin_ring_count(p))
        .map(|k| {
            let radius = layout.skin_radius_mm
                * (f64::from(k) * spacing / layout.skin_radius_mm).sin().abs();
            let count = (2.0 * PI * radius / spacing).round().max(1.0);
            2.0 * radius * (PI / count).sin()
        })
        .filter(|chord| *chord > 0.0)
        .fold(across, f64::min)
}

fn check_tip(p: &PinTip, layout: &PinTipLayout, report: &mut RuleReport) {
    let groove_ceiling = layout.ring_bottom_z_mm + layout.tip_joint.groove_top;
    limits! { report, p:
        skin.upstand <= p.skin.thickness.mm() - 0.3, "the skin's skirt around it needs 0.3 mm";
        skin.skirt_height <= -groove_ceiling - 0.5,
            "the skirt must end above the bayonet's grooves";
        lens.hole_radius <= layout.ledge_radius_mm - p.lens.hole_diameter.mm() / 2.0 - APART_MM,
            "the holes must open into the gel, not onto the ledge";
        lens.hole_radius >=
            layout.view_cone_radius(p, layout.lens_bottom_z_mm) + p.lens.hole_diameter.mm() / 2.0,
            "the holes must stay out of the camera's sight of the dots";
        lens.ledge >= lens_play_mm(p) + 0.4,
            "the glue needs 0.4 mm of the lens's rim";
        tip.diameter >= 2.0 * (layout.view_cone_radius(p, layout.lens_top_z_mm) - layout.ledge_radius_mm
            + layout.outer_radius_mm),
            "the ledge must stay out of the camera's sight of the dots";
    }
}

fn check_illumination(p: &PinTip, layout: &PinTipLayout, report: &mut RuleReport) {
    p.leds.electric.check("leds.forward_volts", [1, p.leds.count], CHIP_0402, report);
    led_ring!(p.leds).check(
        p.led_board.bore_radius,
        (layout.board_seat_radius_mm, "the body"),
        report,
    );
    layout.seal_seat(p).check("seal.cord", "neck", "tip.diameter", report);
    limits! { report, p:
        leds.gap >= p.leds.gap.mm() + layout.board_top_z_mm - layout.neck_top_z_mm,
            "the board must be pressed in up to its upper side";
        body.shaft_wall >= layout.shaft_radius_mm - layout.board_seat_radius_mm + 0.5,
            "the LED board needs a ledge of 0.5 mm in the shaft";
        body.neck_wall >= PRINTED_WALL_MM, "the neck must be printable";
        led_board.bore_radius <=
            layout.shaft_bore_radius_mm - 0.5, "the board must rest on its ledge";
    }
}

/// Checks that the camera sees all dots, and that nothing stands in its view.
fn check_view(p: &PinTip, layout: &PinTipLayout, report: &mut RuleReport) {
    let (tangent, usable) = (PinTipLayout::half_view_tangent(p), PinTipLayout::usable_tangent(p));
    let [rim, rim_z] = layout.outermost_dot_point(p);
    // Listed pins have been checked one by one.
    if p.pins.pattern == RoundPattern::Rings {
        limits! { report, p:
            // Moving the camera back by 1 mm moves the same ray outwards by its slope.
            camera.depth >=
                p.camera.depth.mm() + (rim - layout.ray_radius(usable, rim_z)) / usable,
                "the pixels must see all dots through lens and gel, within `camera.margin`";
        }
    }
    limits! { report, p:
        camera.lens_view >= 2.0 * (tangent * SQRT_2).atan().to_degrees(),
            "the lens must light the chip's corners";
        led_board.bore_radius >=
            layout.view_cone_radius(p, layout.board_top_z_mm + p.leds.height.mm()) + APART_MM,
            "board and LEDs must stay out of the camera's sight of the dots";
    }
}

fn check_housing(p: &PinTip, layout: &PinTipLayout, report: &mut RuleReport) {
    let (camera, slide) = (&p.camera, p.making.gap_mm(BODY, Process::Fdm, Fit::Slide));
    let screws = Joints::new(p, layout).camera;
    let (pilot, head_mm) = (screws.holes(), screws.screw.head_diameter_mm());
    // The corners of the lens holder must lie where the cone has opened that far.
    let corner = camera.holder_size.mm() / SQRT_2 + slide;
    let opened_z = layout.bore_bottom_z_mm - (corner - layout.shaft_bore_radius_mm).max(0.0);
    let holder_top = layout.camera_board_top_z_mm + camera.holder_height.mm();
    // Each post ends in the cone above it, which must have room for the screw's tip.
    let post = p.body.post_diameter.mm() / 2.0;
    let reach = half_diagonal_mm(camera.screw_spacing, camera.screw_spacing_y) + pilot.radius_mm;
    let inside = (layout.mount_joint.bore_radius - post - APART_MM) * SQRT_2;
    // A post that clears the holder along one axis clears it altogether.
    let beside_holder = camera.holder_size.mm() + p.body.post_diameter.mm() + 2.0 * slide;
    let is_beside = camera.screw_spacing_y.mm() >= beside_holder;
    let outside_z = layout.shaft_bottom_z_mm - (reach - layout.shaft_radius_mm);
    let tip_z = layout.camera_board_top_z_mm + pilot.depth_mm - camera.board_thickness.mm();
    limits! { report, p:
        body.shaft_diameter <= 2.0 * layout.outer_radius_mm,
            "the tip must be the widest thing near the surface";
        body.shaft_diameter >= 2.0 * (layout.tip_joint.bore_radius + APART_MM),
            "the shaft must reach under the tip's ring";
        camera.barrel_diameter <= 2.0 * (layout.shaft_bore_radius_mm - slide),
            "the lens barrel stands in the shaft";
        camera.holder_height <= camera.holder_height.mm() + opened_z - holder_top,
            "the lens holder must stay inside the cone";
        camera.holder_height <= camera.lens_height.mm() - 0.5,
            "the barrel must stand out of its holder";
        body.shaft_length <=
            p.body.shaft_length.mm() + layout.cavity_top_z_mm - layout.camera_board_top_z_mm
                - APART_MM,
            "the housing must be as wide as the camera board where that stands";
        body.shaft_length >= layout.neck_top_z_mm - layout.shoulder_z_mm + 2.0,
            "the shaft must reach below the tip's ring";
        body.post_diameter >= 2.0 * pilot.radius_mm + 2.0 * PRINTED_WALL_MM,
            "a post needs a wall around its screw";
        camera.screw_spacing <= inside, "the posts must stand inside the housing";
        camera.screw_spacing_y <= inside, "the posts must stand inside the housing";
        camera.screw_spacing <= camera.board_size.mm() - head_mm,
            "the screws' heads must stay on the board";
        camera.screw_spacing_y <= camera.board_size_y.mm() - head_mm,
            "the screws' heads must stay on the board";
        camera.screw_spacing >= if is_beside { 0.0 } else { beside_holder },
            "the posts must clear the lens holder";
        camera.lens_height >=
            camera.lens_height.mm() + tip_z + PRINTED_WALL_MM * SQRT_2 - outside_z,
            "the camera's screws must end inside the cone";
        body.cable_slot_width <= layout.mount_joint.bore_radius,
            "the slot must leave the housing's wall standing";
    }
    check_edges(p, layout, report);
}

/// Half the angle, rad, by which the wall turns where the 45 degree cone ends.
const HALF_CONE_TURN_RAD: f64 = FRAC_PI_8;

/// Limits the rounding of the housing's edges.
fn check_edges(p: &PinTip, layout: &PinTipLayout, report: &mut RuleReport) {
    if p.body.edge_fillet.mm() == 0.0 {
        return; // Sharp edges need no room. The housing may then be as narrow as its shaft.
    }
    let outer = layout.mount_joint.outer_radius;
    let (cone, wall) = (
        SQRT_2 * (outer - layout.shaft_radius_mm),
        layout.cone_bottom_z_mm - layout.body_bottom_z_mm,
    );
    limits! { report, p:
        body.edge_fillet <= p.bayonet.wall.mm() - PRINTED_WALL_MM / 2.0,
            "the wall outside of the bayonet's entries needs what a rounded edge leaves of its end";
        body.edge_fillet <= p.mount.spigot_height.mm(), "the edge must end below the cable's slot";
        body.edge_fillet <= (cone / HALF_CONE_TURN_RAD.tan()).max(0.0),
            "the upper edge must end on the cone";
        body.edge_fillet <= (wall / (1.0 + HALF_CONE_TURN_RAD.tan())).max(0.0),
            "both edges share the housing's wall";
    }
}

fn check_mount(p: &PinTip, layout: &PinTipLayout, report: &mut RuleReport) {
    let inside = layout.mount_joint.spigot_radius - p.mount.spigot_wall.mm();
    limits! { report, p:
        mount.spigot_height >= layout.mount_joint.lug_top + 0.5, "the spigot must carry its lugs";
    }
    Joints::new(p, layout).robot.check((inside, "the spigot"), report);
}
