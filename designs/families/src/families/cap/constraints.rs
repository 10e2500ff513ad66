//! Constraints between parameters: parts must fit, hold, and be manufacturable.

use std::f64::consts::{PI, SQRT_2};

use fabkit_geometry::{Angle, CUT_OVERLAP_MM, Point3, Process};

use super::electronics::CONNECTOR_MM;
use super::housing::{WIRE_GROOVE_MM, dimple_count, dimple_poses};
use super::molds::vents;
use super::parameters::{BASE, Cap, Direction, HOLDER};
use super::{
    BITE_MM, CASING_SCREW, CapLayout, Joints, MOLD_BOLT, casing_tip_z, mounting, plug_room_mm,
};
use crate::blocks::listed_markers::{RoundPattern, max_angle_deg, nearest_mm};
use crate::blocks::mounting::MountHold;
use crate::blocks::{APART_MM, PRINTED_WALL_MM, edge, half_chord};
use crate::fits::Fit;
use crate::parameters::{RuleReport, limits};

/// Minimum gap between LEDs and plate, mm: half a layer's error of a filament printer.
const LED_GAP_MM: f64 = 0.1;

/// Minimum thickness of gel, or of the mold's resin, between two dimples, mm.
const WEB_MM: f64 = 0.2;

/// Minimum width of a pin that resin printers make, mm.
const THINNEST_PIN_MM: f64 = 0.2;

/// Minimum height of gel between a dimple and the foot, mm. Less would tear at the rim.
const RIM_MM: f64 = 0.3;

/// Height that an angled USB plug needs behind the connector, mm.
const PLUG_MM: f64 = 8.0;

/// Reports every combination of parameters that cannot be built.
pub(super) fn check(p: &Cap, report: &mut RuleReport) {
    let layout = CapLayout::new(p);
    limits! { report, p:
        skin.height <=
            layout.foot_radius_mm, "more than a hemisphere cannot be drawn out of its mold";
        leds.below_plate >= LED_GAP_MM,
            "an LED that touches the plate lifts it off its ledge, and lights its edge instead of the skin";
    }
    if layout.sphere_z_mm > 0.0 {
        return; // A sphere's centre above the foot is reported already, and would break every check below.
    }
    dimples(p, &layout, report);
    check_optics(p, &layout, report);
    check_holder(p, &layout, report);
    check_camera(p, &layout, report);
    check_base(p, &layout, report);
    check_mold(p, &layout, report);
}

/// Returns the distance of the nearest two dimples on the gel's surface, mm; `None` for a single dimple.
pub(super) fn nearest_dimples_mm(p: &Cap, layout: &CapLayout) -> Option<f64> {
    if p.dimples.pattern == RoundPattern::List {
        return nearest_mm(&dimple_points(p, layout, 0.0));
    }
    let between_rings = 2.0 * layout.sphere_radius_mm * (layout.ring_tilt_rad(p, 1) / 2.0).sin();
    Some((1..=p.dimples.rings).map(|k| layout.ring_pitch_mm(p, k)).fold(between_rings, f64::min))
}

/// Points on the dimples' axes, `depth_mm` below the gel's surface, in the sensor frame.
fn dimple_points(p: &Cap, layout: &CapLayout, depth_mm: f64) -> Vec<Point3<f64>> {
    let below = Point3::new(0.0, 0.0, -depth_mm);
    let poses = dimple_poses(p, layout).unwrap_or_default();
    poses.iter().map(|pose| pose.point(below)).collect()
}

/// Height above the foot, mm, of the lowest point of a dimple whose normal makes the angle `tilt` (rad) with the
/// axis.
pub(super) fn lowest_dimple_z(p: &Cap, layout: &CapLayout, tilt: f64) -> f64 {
    let radius = p.dimples.width.mm() / 2.0;
    let mouth = layout.sphere_radius_mm * tilt.cos() - radius * tilt.sin();
    let tip = match p.dimples.direction {
        Direction::IntoGel => {
            (layout.sphere_radius_mm - p.dimples.height.mm() + radius) * tilt.cos() - radius
        }
        Direction::OutOfGel => mouth,
    };
    layout.sphere_z_mm + mouth.min(tip)
}

fn dimples(p: &Cap, layout: &CapLayout, report: &mut RuleReport) {
    let dimples = &p.dimples;
    // Neighbouring dimples converge towards the sphere's centre, so they are nearest at their deepest point.
    let depth = match dimples.direction {
        Direction::IntoGel => dimples.height.mm(),
        Direction::OutOfGel => 0.0,
    };
    let is_listed = dimples.pattern == RoundPattern::List;
    if is_listed {
        check_listed_dimples(p, layout, depth, report);
    } else {
        let shrinks = 1.0 - depth / layout.sphere_radius_mm;
        let nearest = nearest_dimples_mm(p, layout).unwrap_or(f64::INFINITY);
        limits! { report, p:
            dimples.width <= nearest * shrinks - WEB_MM,
                "a dimple must be smaller than its spacing, with 0.2 mm between neighbours";
        }
    }
    limits! { report, p:
        dimples.width >= THINNEST_PIN_MM, "thinner pins do not survive resin printing";
        dimples.height >= dimples.width.mm() / 2.0,
            "the hemispherical tip alone is half as high as the dimple is wide";
        dimples.height <= (p.skin.height.mm() - RIM_MM).min(4.0 * dimples.width.mm()),
            "higher pins bend when the gel is peeled off";
    }
    if !is_listed {
        check_rings(p, layout, report);
    }
    limits! { report, p:
        paint.thickness <= dimples.height.mm() / 2.0, "thicker paint would hide the dimples";
    }
}

/// Checks listed dimples: apart from each other down to `depth_mm` below the surface, visible, and clear of the rim.
fn check_listed_dimples(p: &Cap, layout: &CapLayout, depth_mm: f64, report: &mut RuleReport) {
    let listed = p.dimples.listed();
    listed.check_lengths(report);
    let is_above_foot = |polar: Angle| lowest_dimple_z(p, layout, polar.rad()) >= RIM_MM - 1e-9;
    let most = max_angle_deg(|polar| {
        is_above_foot(polar) && occlusion_mm(p, layout, polar.rad()).iter().all(|mm| *mm <= 1e-9)
    });
    // The message names the limit that is violated just beyond the largest allowed angle.
    let told = if Angle::from_deg(most + 1e-6).is_some_and(is_above_foot) {
        (
            "ledge and LEDs must not hide the dimple from the camera",
            "`holder.aperture_diameter` or `leds.package_height`",
        )
    } else {
        ("a dimple must end 0.3 mm above the foot", "`dimples.width` or `skin.height`")
    };
    listed.check_within(0, most, told, report);
    let web = ("0.2 mm must remain between two dimples", "`dimples.width`");
    let least = p.dimples.width.mm() + WEB_MM;
    listed.check_apart(&dimple_points(p, layout, depth_mm), least, web, report);
}

/// Requires that all rings of dimples end above the foot.
fn check_rings(p: &Cap, layout: &CapLayout, report: &mut RuleReport) {
    let dimples = &p.dimples;
    let lowest = |ring: u32| lowest_dimple_z(p, layout, layout.ring_tilt_rad(p, ring));
    let fits = |rings: u32| (1..=rings).all(|k| lowest(k) >= RIM_MM - 1e-9);
    let most = (0..=dimples.rings).rev().find(|&rings| fits(rings)).unwrap_or(0);
    let lowest = lowest(dimples.rings);
    report.require(
        most == dimples.rings,
        "dimples.rings",
        || {
            format!(
                "dimples.rings is {}; its outermost ring would end {lowest:.2} mm above the foot, \
                 and {RIM_MM} mm are needed so that the rim cuts none of the {} dimples",
                dimples.rings,
                dimple_count(p)
            )
        },
        || format!("write at most {most}, or change `dimples.spacing` or `skin.height`"),
    );
}

/// Checks the LEDs, and the camera's view of the dimples.
fn check_optics(p: &Cap, layout: &CapLayout, report: &mut RuleReport) {
    let leds = &p.leds;
    let count = f64::from(leds.count);
    let half = (leds.strip_length.mm() + APART_MM) / 2.0;
    let slide = p.making.gap_mm(HOLDER, Process::Fdm, Fit::Slide);
    let recess = half_chord(layout.recess_radius_mm, layout.strip_back_mm);
    let tilt = layout.outermost_tilt_rad(p);
    limits! { report, p:
        // Strips are chords of the chamber. Neighbours touch first at their inner ends.
        leds.count <= PI / half.atan2(layout.chamber_radius_mm),
            "the strips must fit around the chamber without overlapping";
        leds.package_size <=
            leds.strip_width.mm().min(2.0 * (layout.led_front_mm * (PI / count).tan() - APART_MM)),
            "packages must stay on their strips and apart from each other";
        leds.strip_length >= leds.package_size.mm(), "the package sits on its strip";
        leds.strip_length <= 2.0 * (recess - slide),
            "the strip is pushed in from the plate's recess";
        leds.below_plate <= layout.plate_bottom_z_mm - layout.housing_front_z_mm
            - leds.strip_width.mm() - PRINTED_WALL_MM,
            "the strips must end above the camera's housing";
    }
    if p.dimples.pattern == RoundPattern::List {
        return; // Each listed dimple has been checked by itself.
    }
    limits! { report, p:
        leds.package_height <=
            layout.chamber_radius_mm - sight_line_radius_mm(p, layout, tilt, led_top_z(p, layout)) - APART_MM,
            "the LEDs must not hide the outermost dimples from the camera";
        holder.aperture_diameter >=
            2.0 * (sight_line_radius_mm(p, layout, tilt, layout.plate_bottom_z_mm) + APART_MM),
            "the ledge must not hide the outermost dimples from the camera";
    }
}

/// Height of the LEDs' upper edges, mm.
fn led_top_z(p: &Cap, layout: &CapLayout) -> f64 {
    layout.led_z_mm + p.leds.package_size.mm() / 2.0
}

/// Distance from the axis, mm, at height `z` of the straight line from the optical centre to the surface point whose
/// normal makes the angle `tilt` (rad) with the axis. Refraction in the plate only bends the ray inwards, so the line
/// is a safe bound.
fn sight_line_radius_mm(p: &Cap, layout: &CapLayout, tilt: f64, z: f64) -> f64 {
    let ring = layout.sphere_radius_mm * tilt.sin();
    let ring_z = layout.sphere_z_mm + layout.sphere_radius_mm * tilt.cos();
    let depth = p.camera.depth.mm();
    ring * ((z + depth) / (ring_z + depth))
}

/// Lengths, mm, by which LEDs and ledge reach into the line of sight to the surface point at `tilt`; negative if they
/// are clear of it.
fn occlusion_mm(p: &Cap, layout: &CapLayout, tilt: f64) -> [f64; 2] {
    let sight = |z: f64| sight_line_radius_mm(p, layout, tilt, z) + APART_MM;
    [
        sight(led_top_z(p, layout)) - (layout.chamber_radius_mm - p.leds.package_height.mm()),
        sight(layout.plate_bottom_z_mm) - p.holder.aperture_diameter.mm() / 2.0,
    ]
}

/// Radius of a counterbore for the casing's screws, mm.
fn counterbore_radius_mm(p: &Cap) -> f64 {
    CASING_SCREW.head_diameter_mm() / 2.0 + p.making.gap_mm(BASE, Process::Fdm, Fit::Snug)
}

fn check_holder(p: &Cap, layout: &CapLayout, report: &mut RuleReport) {
    let half_width = p.holder.width.mm() / 2.0;
    let painted = ((layout.sphere_radius_mm + p.paint.thickness.mm()).powi(2)
        - layout.sphere_z_mm.powi(2))
    .sqrt();
    let slide = p.making.gap_mm(HOLDER, Process::Fdm, Fit::Slide);
    let head = counterbore_radius_mm(p);
    let passage = CASING_SCREW.clearance_hole_mm() / 2.0;
    let centre = layout.pocket_half_mm - layout.pocket_corner_mm;
    let inset = half_width - p.holder.screw_spacing.mm() / 2.0;
    limits! { report, p:
        plate.diameter <= (2.0 * layout.foot_radius_mm)
            .min(2.0 * (half_width - PRINTED_WALL_MM - slide)),
            "the skin covers the plate's edge, and the holder needs a wall around it";
        holder.width >= 2.0 * (painted + APART_MM),
            "the painted skin must not stand over the casing";
        holder.aperture_diameter <= 2.0 * (layout.plate_radius_mm - PRINTED_WALL_MM),
            "the plate is glued to a ledge at least 0.8 mm wide";
        leds.strip_thickness <= half_width - layout.chamber_radius_mm - PRINTED_WALL_MM,
            "the LEDs' pockets need a wall behind them";
        holder.width >= 2.0 * (layout.pocket_half_mm + WIRE_GROOVE_MM[0] + PRINTED_WALL_MM),
            "the wires' groove beside the camera needs a wall";
        holder.screw_spacing <= 2.0 * (half_width - head - PRINTED_WALL_MM),
            "the screws' heads need a wall outside";
        holder.screw_spacing >=
            2.0 * centre + SQRT_2 * (layout.pocket_corner_mm + passage + PRINTED_WALL_MM),
            "the screws need a wall beside the camera";
        // A larger corner radius than that of a corner around the screw's centre comes nearer to its head.
        holder.corner <= inset + (inset - head - PRINTED_WALL_MM).max(0.0) / (SQRT_2 - 1.0),
            "the screws' heads need a wall at the rounded corner";
    }
    check_rim(p, layout, (half_width, painted), report);
}

/// Limits the rounding of the holder's rim. `half_width` is half the holder's edge, `painted` the radius of the
/// painted skin, mm.
fn check_rim(
    p: &Cap,
    layout: &CapLayout,
    (half_width, painted): (f64, f64),
    report: &mut RuleReport,
) {
    let (wall, pilot) = (PRINTED_WALL_MM, CASING_SCREW.pilot_hole_mm() / 2.0);
    // The LED pockets reach up to the plate. A screw's head has a wall outside, so its thinner hole has more.
    let pocket =
        [half_width - layout.strip_back_mm - wall, -layout.plate_bottom_z_mm - CUT_OVERLAP_MM];
    let screw = [counterbore_radius_mm(p) - pilot, -casing_tip_z(layout)];
    limits! { report, p:
        holder.edge_fillet <= p.holder.corner.mm(),
            "a rounded rim goes around the upright edges, which are at least as round";
        holder.edge_fillet <= edge::max_radius_sparing_mm(pocket),
            "the LEDs' pockets need a wall behind them";
        holder.edge_fillet <= edge::max_radius_sparing_mm(screw), "the screws need a wall around their tips";
    }
    for (room, because) in [
        (half_width - painted - APART_MM, "the painted skin must not stand over a rounded edge"),
        (
            half_width - layout.recess_radius_mm - wall / 2.0,
            "a wall around the plate must be left of the rim",
        ),
    ] {
        report.at_most_or_absent("holder.edge_fillet", p.holder.edge_fillet, room, because);
    }
}

fn check_camera(p: &Cap, layout: &CapLayout, report: &mut RuleReport) {
    let camera = &p.camera;
    let wide = 2.0 * (layout.led_front_mm - APART_MM);
    // The camera is clamped by the corners of its housing, which lie outside the chamber.
    let reach = (camera.housing_size.mm() / 2.0 - camera.housing_corner.mm()) * SQRT_2
        + camera.housing_corner.mm();
    let engaged = 1.0;
    limits! { report, p:
        camera.depth >= p.plate.thickness.mm() + camera.pupil_behind_front.mm() + 0.5,
            "the lens must not touch the plate";
        camera.lens_diameter <= wide.min(camera.mount_diameter.mm()),
            "the lens passes its mount and the LEDs";
        camera.mount_diameter <=
            (2.0 * layout.chamber_radius_mm - 1.0).min(camera.housing_size.mm()),
            "the mount stands on the housing, in the chamber";
        holder.aperture_diameter <= 2.0 * (reach - 1.5),
            "the housing's corners must rest 1.5 mm deep on holder and base";
        holder.height >= engaged - layout.housing_front_z_mm,
            "the holder must centre the camera's housing over 1 mm";
        holder.height <= -layout.housing_back_z_mm - engaged,
            "the base must centre the camera's housing over 1 mm";
    }
}

fn check_base(p: &Cap, layout: &CapLayout, report: &mut RuleReport) {
    let grip = CASING_SCREW.length_mm - BITE_MM;
    let room = half_chord(layout.chamber_radius_mm, layout.chamber_radius_mm / 2.0);
    let head = counterbore_radius_mm(p);
    limits! { report, p:
        base.height >= grip + 2.0, "the joint's M2x16 screws are sunk into the base";
        base.height >= p.base.height.mm() + PLUG_MM - plug_room_mm(p, layout),
            "an angled USB plug needs 8 mm behind the camera's connector";
        base.window_width <=
            2.0 * room.min(p.holder.screw_spacing.mm() / 2.0 - head - PRINTED_WALL_MM),
            "the window opens into the round room behind the camera, between two screws";
        base.window_width >= CONNECTOR_MM[0] + 1.0, "the camera's plug must pass the window";
    }
    let room = (layout.chamber_radius_mm, "a mounting hole ends in the room behind the camera");
    let mounting = mounting(p);
    mounting.check(room, PRINTED_WALL_MM, report);
    if p.mount.hold == MountHold::Insert {
        limits! { report, p:
            base.floor >= mounting.least_depth_mm(), "the inserts lie in the floor";
        }
    }
}

fn check_mold(p: &Cap, layout: &CapLayout, report: &mut RuleReport) {
    let (mold, (bolt, nut)) = (&p.mold, MOLD_BOLT);
    // The larger of both holes decides, because the bolts pass through all three parts.
    let hole = mold.lid_hole.mm().max(mold.block_hole.mm()) / 2.0;
    let pocket = Joints::new(p, layout).mold.holes().radius_mm;
    let seen = layout.foot_radius_mm - layout.chamber_radius_mm;
    limits! { report, p:
        mold.height >= p.skin.height.mm() + mold.wall.mm(),
            "the block needs a floor below the cavity";
        mold.height >= layout.nut_z_mm + nut.height_mm,
            "the nuts must lie inside the block, which stands on that side";
        mold.lid_thickness <= bolt.length_mm - nut.height_mm - mold.spacer.mm() - 2.0,
            "an M3x16 must reach through lid, spacer and 2 mm of block into its nut";
        mold.bolt_circle >= 2.0 * (layout.spacer_bore_mm + hole + 1.0),
            "bolts need a wall beside the trough";
        mold.diameter >= mold.bolt_circle.mm() + 2.0 * (pocket + 1.0),
            "the nuts' pockets need a wall outside";
        mold.pry_width <=
            2.0 * (mold.bolt_circle.mm() / 2.0 * (PI / f64::from(mold.bolts)).sin() - pocket - 1.0),
            "pry slots lie between bolts";
        mold.pry_depth <= layout.mold_radius_mm - layout.spacer_bore_mm - 1.0,
            "the block's pry slots must end outside the trough";
    }
    let foot = (seen, "vents open between what the camera sees and the gel's edge");
    vents(p, layout).check(foot, 0.0, report);
}
