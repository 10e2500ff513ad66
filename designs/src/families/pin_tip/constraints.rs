//! What the parameters must fulfil together so that things fit, hold and can be made.

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

use fabkit_geometry::Process;

use super::joints::Joints;
use super::layout::Layout;
use super::parameters::PinTip;
use super::tip::pin_root_mm;
use crate::blocks::{APART_MM, PRINTED_WALL_MM, require_castable};
use crate::fits::{Fit, gap_mm};
use crate::hardware::{ORing, stocked_cords};
use crate::parameters::Report;

/// Smallest gap between neighbouring dots, mm: support must come out of it, and the camera must see
/// it.
const DOTS_APART_MM: f64 = 0.3;

/// Reports every combination that cannot be built.
pub(super) fn check(p: &PinTip, report: &mut Report) {
    let layout = Layout::new(p);
    require_castable(&[("fill.material", &p.fill.material)], report);
    pins(p, &layout, report);
    tip(p, &layout, report);
    bayonets(p, &layout, report);
    illumination(p, &layout, report);
    view(p, &layout, report);
    housing(p, &layout, report);
    mount(p, &layout, report);
}

fn pins(p: &PinTip, layout: &Layout, report: &mut Report) {
    let half = layout.pin_diameter / 2.0;
    report.at_most(
        "pins.reach",
        p.pins.reach,
        layout.skin_radius * FRAC_PI_2 - half,
        "a pin that stands lower misses the skin",
    );
    // The root's rim is the point of a pin that comes nearest to the outside.
    let room = layout.outer_radius.hypot(half) - (half * half + layout.skin_radius.powi(2)).sqrt();
    report.at_least(
        "skin.thickness",
        p.skin.thickness,
        p.skin.thickness.mm() + pin_root_mm(p) - room + APART_MM,
        "the pins' roots must stay inside the skin",
    );
    let closest = closest_pins_mm(p, layout);
    let radius = layout.skin_radius;
    // Pins lean towards each other: distances shrink with the distance from the centre.
    let depth = radius * (1.0 - (layout.pin_diameter + DOTS_APART_MM) / closest);
    report.at_most(
        "pins.length",
        p.pins.length,
        depth - p.pins.dot_thickness.mm(),
        "the dots, which come closer the longer the pins are, must stay 0.3 mm apart",
    );
}

/// Smallest distance of two pins at the skin's inside, mm: along the surface from circle to circle,
/// straight on a circle.
fn closest_pins_mm(p: &PinTip, layout: &Layout) -> f64 {
    let spacing = layout.pin_spacing;
    // The chord between two circles; pins on neighbouring circles are never nearer.
    let across = 2.0 * layout.skin_radius * (spacing / (2.0 * layout.skin_radius)).sin();
    (1..=layout.pin_rings(p))
        .map(|k| {
            let radius =
                layout.skin_radius * (f64::from(k) * spacing / layout.skin_radius).sin().abs();
            let count = (2.0 * PI * radius / spacing).round().max(1.0);
            2.0 * radius * (PI / count).sin()
        })
        .filter(|chord| *chord > 0.0)
        .fold(across, f64::min)
}

fn tip(p: &PinTip, layout: &Layout, report: &mut Report) {
    report.at_most(
        "skin.upstand",
        p.skin.upstand,
        p.skin.thickness.mm() - 0.3,
        "the skin's skirt around it needs 0.3 mm",
    );
    let groove_ceiling = layout.ring_bottom_z + layout.tip_joint.groove_top;
    report.at_most(
        "skin.skirt_height",
        p.skin.skirt_height,
        -groove_ceiling - 0.5,
        "the skirt must end above the bayonet's grooves",
    );
    report.at_most(
        "lens.hole_radius",
        p.lens.hole_radius,
        layout.ledge_radius - p.lens.hole_diameter.mm() / 2.0 - APART_MM,
        "the holes must open into the gel, not onto the ledge",
    );
    report.at_least(
        "lens.hole_radius",
        p.lens.hole_radius,
        layout.sight_radius(p, layout.lens_bottom_z) + p.lens.hole_diameter.mm() / 2.0,
        "the holes must stay out of the camera's sight of the dots",
    );
    report.at_least(
        "lens.ledge",
        p.lens.ledge,
        gap_mm(Process::Laser, Fit::Slide) + 0.4,
        "the glue needs 0.4 mm of the lens's rim",
    );
    report.at_least(
        "tip.diameter",
        p.tip.diameter,
        2.0 * (layout.sight_radius(p, layout.lens_top_z) - layout.ledge_radius
            + layout.outer_radius),
        "the ledge must stay out of the camera's sight of the dots",
    );
}

fn bayonets(p: &PinTip, layout: &Layout, report: &mut Report) {
    report.at_least(
        "bayonet.key_width",
        p.bayonet.key_width,
        p.bayonet.lug_width.mm() + 2.0 * gap_mm(Process::Fdm, Fit::Slide) + 0.5,
        "the first lug must not pass an entry of the others",
    );
    let land = layout.tip_joint.land_mm();
    let most = p.bayonet.turn.deg() + (land - 1.0) / layout.tip_joint.bore_radius * 180.0 / PI;
    report.require(
        land >= 1.0,
        "bayonet.turn",
        || {
            format!(
                "bayonet.turn is {}; it must be at most {:.1} deg, because 1 mm must stand between \
                 one groove and the next entry (bayonet.lugs is {})",
                p.bayonet.turn,
                (most * 10.0).floor() / 10.0,
                p.bayonet.lugs
            )
        },
        || {
            format!(
                "write at most {:.1} deg, or change `bayonet.lugs`",
                (most * 10.0).floor() / 10.0
            )
        },
    );
    let least = (p.bayonet.lug_width.mm().max(p.bayonet.key_width.mm())
        + 2.0 * gap_mm(Process::Fdm, Fit::Slide))
        / layout.tip_joint.bore_radius
        * 180.0
        / PI;
    report.require(
        p.bayonet.turn.deg() >= least,
        "bayonet.turn",
        || {
            format!(
                "bayonet.turn is {}; it must be at least {:.1} deg, because a lug must leave its \
                 entry altogether",
                p.bayonet.turn,
                (least * 10.0).ceil() / 10.0
            )
        },
        || {
            format!(
                "write at least {:.1} deg, or change `bayonet.key_width`",
                (least * 10.0).ceil() / 10.0
            )
        },
    );
    report.at_least(
        "mount.spigot_height",
        p.mount.spigot_height,
        layout.mount_joint.lug_top + 0.5,
        "the spigot must carry its lugs",
    );
}

fn illumination(p: &PinTip, layout: &Layout, report: &mut Report) {
    let (length, width) = (p.leds.length.mm(), p.leds.width.mm());
    let circle = p.leds.circle_radius.mm();
    let reach = layout.board_seat_radius - APART_MM;
    report.at_most(
        "leds.circle_radius",
        p.leds.circle_radius,
        (reach.powi(2) - (length / 2.0).powi(2)).max(0.0).sqrt() - width / 2.0,
        "the LEDs' outer corners must stay inside the body",
    );
    report.at_least(
        "leds.circle_radius",
        p.leds.circle_radius,
        p.led_board.bore_radius.mm() + width / 2.0 + 0.2,
        "the LEDs must stand on the board, not over its bore",
    );
    // Neighbours touch first at their inner corners.
    let most = (PI / ((length + APART_MM) / 2.0).atan2(circle - width / 2.0)).floor();
    report.require(
        f64::from(p.leds.count) <= most,
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
    report.at_least(
        "leds.gap",
        p.leds.gap,
        p.leds.gap.mm() + layout.board_top_z - layout.neck_top_z,
        "the board must be pressed in up to its upper side",
    );
    report.at_least(
        "body.shaft_wall",
        p.body.shaft_wall,
        layout.shaft_radius - layout.board_seat_radius + 0.5,
        "the LED board needs a ledge of 0.5 mm in the shaft",
    );
    let neck_mm = 2.0 * layout.neck_radius;
    report.require(
        ORing::on(p.seal.cord.mm(), neck_mm).is_some(),
        "seal.cord",
        || {
            format!(
                "seal.cord is {}; no O-ring of that cord is stocked for a neck of {neck_mm:.2} mm",
                p.seal.cord
            )
        },
        || format!("cords of {} mm are stocked; or change `tip.diameter`", stocked_cords()),
    );
    report.at_least(
        "body.neck_wall",
        p.body.neck_wall,
        PRINTED_WALL_MM,
        "the neck must be printable",
    );
    report.at_most(
        "led_board.bore_radius",
        p.led_board.bore_radius,
        layout.shaft_bore_radius - 0.5,
        "the board must rest on its ledge",
    );
}

/// What the camera must see, and what must not stand in its way.
fn view(p: &PinTip, layout: &Layout, report: &mut Report) {
    let tangent = Layout::half_view_tangent(p);
    let [rim, rim_z] = layout.outermost_dot(p);
    report.at_least(
        "camera.depth",
        p.camera.depth,
        // A millimetre farther back, the same ray lies farther out by its slope.
        p.camera.depth.mm() + (rim - layout.ray_radius(tangent, rim_z)) / tangent,
        "the pixels must see all dots through lens and gel",
    );
    let corners = 2.0 * (tangent * SQRT_2).atan().to_degrees();
    // Rounded up to a view that does cover them.
    let works = (corners * 10.0).ceil() / 10.0;
    report.require(
        p.camera.lens_view.deg() >= corners,
        "camera.lens_view",
        || {
            format!(
                "camera.lens_view is {}; it must be at least {works:.1} deg, because the lens \
                 must light the chip's corners",
                p.camera.lens_view
            )
        },
        || "take a lens that covers more, or change `camera.focal_length`".into(),
    );
    report.at_least(
        "led_board.bore_radius",
        p.led_board.bore_radius,
        layout.sight_radius(p, layout.board_top_z + p.leds.height.mm()) + APART_MM,
        "board and LEDs must stay out of the camera's sight of the dots",
    );
}

fn housing(p: &PinTip, layout: &Layout, report: &mut Report) {
    let (camera, slide) = (&p.camera, gap_mm(Process::Fdm, Fit::Slide));
    let screws = Joints::new(p, layout).camera;
    let (pilot, head_mm) = (screws.holes(), screws.screw.head_diameter_mm());
    report.at_most(
        "body.shaft_diameter",
        p.body.shaft_diameter,
        2.0 * layout.outer_radius,
        "the tip must be the widest thing near the surface",
    );
    report.at_least(
        "body.shaft_diameter",
        p.body.shaft_diameter,
        2.0 * (layout.tip_joint.bore_radius + APART_MM),
        "the shaft must reach under the tip's ring",
    );
    report.at_most(
        "camera.barrel_diameter",
        camera.barrel_diameter,
        2.0 * (layout.shaft_bore_radius - slide),
        "the lens barrel stands in the shaft",
    );
    // The holder's corners lie where the cone has opened as far as they reach.
    let corner = camera.holder_size.mm() / SQRT_2 + slide;
    let opened_z = layout.bore_bottom_z - (corner - layout.shaft_bore_radius).max(0.0);
    let holder_top = layout.camera_board_top_z + camera.holder_height.mm();
    report.at_most(
        "camera.holder_height",
        camera.holder_height,
        camera.holder_height.mm() + opened_z - holder_top,
        "the lens holder must stay inside the cone",
    );
    report.at_most(
        "camera.holder_height",
        camera.holder_height,
        camera.lens_height.mm() - 0.5,
        "the barrel must stand out of its holder",
    );
    report.at_most(
        "body.shaft_length",
        p.body.shaft_length,
        p.body.shaft_length.mm() + layout.cavity_top_z - layout.camera_board_top_z - APART_MM,
        "the housing must be as wide as the camera board where that stands",
    );
    report.at_least(
        "body.shaft_length",
        p.body.shaft_length,
        layout.neck_top_z - layout.shoulder_z + 2.0,
        "the shaft must reach below the tip's ring",
    );
    // Each post ends in the cone above it, with room for the screw's tip.
    let post = p.body.post_diameter.mm() / 2.0;
    let centre = camera.screw_spacing.mm() / SQRT_2;
    report.at_least(
        "body.post_diameter",
        p.body.post_diameter,
        2.0 * pilot.radius_mm + 2.0 * PRINTED_WALL_MM,
        "a post needs a wall around its screw",
    );
    report.at_most(
        "camera.screw_spacing",
        camera.screw_spacing,
        (layout.mount_joint.bore_radius - post - APART_MM) * SQRT_2,
        "the posts must stand inside the housing",
    );
    report.at_most(
        "camera.screw_spacing",
        camera.screw_spacing,
        camera.board_size.mm() - head_mm,
        "the screws' heads must stay on the board",
    );
    report.at_least(
        "camera.screw_spacing",
        camera.screw_spacing,
        camera.holder_size.mm() + p.body.post_diameter.mm() + 2.0 * slide,
        "the posts must clear the lens holder",
    );
    let outside_z = layout.shaft_bottom_z - (centre + pilot.radius_mm - layout.shaft_radius);
    report.at_least(
        "camera.lens_height",
        camera.lens_height,
        camera.lens_height.mm()
            + layout.camera_board_top_z
            + (pilot.depth_mm - camera.board_thickness.mm())
            + PRINTED_WALL_MM * SQRT_2
            - outside_z,
        "the camera's screws must end inside the cone",
    );
    report.at_most(
        "body.cable_slot_width",
        p.body.cable_slot_width,
        layout.mount_joint.bore_radius,
        "the slot must leave the housing's wall standing",
    );
}

fn mount(p: &PinTip, layout: &Layout, report: &mut Report) {
    let inside = layout.mount_joint.spigot_radius - p.mount.spigot_wall.mm();
    let head = Joints::new(p, layout).robot.bolt.head_diameter_mm / 2.0;
    report.at_most(
        "mount.bolt_circle",
        p.mount.bolt_circle,
        2.0 * (inside - head - 0.5),
        "the bolts' heads lie inside the spigot",
    );
    let most = (PI / ((head + 0.5) / (p.mount.bolt_circle.mm() / 2.0)).min(1.0).asin()).floor();
    report.require(
        f64::from(p.mount.bolts) <= most,
        "mount.bolts",
        || {
            format!(
                "mount.bolts is {}; at most {most} M5 heads fit on a circle of {}",
                p.mount.bolts, p.mount.bolt_circle
            )
        },
        || format!("write {most}, or change `mount.bolt_circle`"),
    );
}
