//! Body and mount, the printed tip, and the gauge in which its lens is focused.

use fabkit_geometry::{
    Body, CUT_OVERLAP_MM, Color, Landmark, Marker, MarkerCarrier, Path, Point3, Pose, Process,
    Profile, Shells, Solid, Vector3,
};

use super::parameters::*;
use super::{Joints, PinTipLayout};
use crate::blocks::cable_openings::{HousingSide, wall_opening};
use crate::blocks::{
    GLASS, MASK_GREEN, TOOL_GREY, copies, edge, holes, landmarks_at, led_ring, ring,
};
use crate::chain_builder::{Name, flipped, in_sensor};
use crate::materials::window_transparency;

// ------ Body ------
//
// Body, LED board and robot mount.

const ABS_GREY: Color = [104, 110, 120];
const MOUNT_GREY: Color = [150, 156, 164];

/// Poses of the LEDs on their board: z axis up, x axis outwards.
pub fn led_poses(p: &PinTip, layout: &PinTipLayout) -> Vec<Pose> {
    led_ring!(p.leds).poses(layout.board_top_z_mm, 0.0)
}

/// Returns the body: spigot, shaft, cone and housing in one print.
pub fn body(p: &PinTip, layout: &PinTipLayout) -> Body {
    let (tip, mount) = (&layout.tip_joint, &layout.mount_joint);
    let bottom = layout.body_bottom_z_mm;
    let fillet = p.body.edge_fillet.mm();
    let outside = Solid::revolution(edge::rounded(&[
        ([0.0, layout.neck_top_z_mm], 0.0),
        ([layout.neck_radius_mm, layout.neck_top_z_mm], 0.0),
        ([layout.neck_radius_mm, layout.seal_z_mm], 0.0),
        ([tip.spigot_radius, layout.seal_z_mm], 0.0),
        ([tip.spigot_radius, layout.shoulder_z_mm], 0.0),
        ([layout.shaft_radius_mm, layout.shoulder_z_mm], 0.0),
        ([layout.shaft_radius_mm, layout.shaft_bottom_z_mm], 0.0),
        ([mount.outer_radius, layout.cone_bottom_z_mm], fillet),
        ([mount.outer_radius, bottom], fillet),
        ([0.0, bottom], 0.0),
    ]));
    let above = layout.neck_top_z_mm + CUT_OVERLAP_MM;
    let below = bottom - CUT_OVERLAP_MM;
    let cavity = Solid::revolution(Path::polygon(&[
        [0.0, above],
        [layout.board_seat_radius_mm, above],
        [layout.board_seat_radius_mm, layout.board_bottom_z_mm],
        [layout.shaft_bore_radius_mm, layout.board_bottom_z_mm],
        [layout.shaft_bore_radius_mm, layout.bore_bottom_z_mm],
        [mount.bore_radius, layout.cavity_top_z_mm],
        [mount.bore_radius, below],
        [0.0, below],
    ]))
    .named("cavity");
    // The posts are spared from the cavity, so they grow out of the cone at any slope.
    let screws = Joints::new(p, layout).camera;
    let post = Solid::cylinder(
        p.body.post_diameter.mm() / 2.0,
        layout.shaft_bottom_z_mm - layout.camera_board_top_z_mm,
    );
    let posts = screws.poses.iter().zip(1..).map(|(pose, i)| {
        let at = pose.translation_mm();
        post.clone().at(at.x, at.y, layout.camera_board_top_z_mm).named(format!("post {i}"))
    });
    let lugs = tip.male().at_z(layout.ring_bottom_z_mm);
    BODY.made(Process::Fdm, outside.plus(lugs).minus(cavity.minus_all(posts)))
        .with_material(&p.body.material)
        .placed([in_sensor().lifted(-30.0)])
        .colored(ABS_GREY)
        // With the spigot down, cone, posts and both bayonets print without support.
        .with_bed_orientation(flipped())
        .note("print with the spigot down, without support")
        .with_supports(false)
        .note(
            "a tall part on a narrow ring: print it on a brim 8 mm wide, slowly where it is narrow, \
             and trim the brim off the spigot's edge",
        )
        .on_brim(8.0)
        .note("paint the shaft's inside matt black if the filament is bright")
        // Two handles: the bore for the light, and the slot for the cable.
        .with_handles(2)
        .cut(screws.thread_cut())
        .cut(holes(mount.female_tools(bottom)))
        .cut(holes([cable_slot(p, layout)]))
}

/// Returns the slot for the cable, between camera board and mount.
fn cable_slot(p: &PinTip, layout: &PinTipLayout) -> Solid {
    let (bore, outer) = (layout.mount_joint.bore_radius, layout.mount_joint.outer_radius);
    let width = p.body.cable_slot_width.mm();
    let height = p.body.wiring_room.mm() / 2.0;
    // It starts well inside the wall, whose inner face is curved, and ends beyond its outside.
    let inner = bore - width / 2.0;
    let bottom = layout.camera_board_bottom_z_mm - p.body.wiring_room.mm() / 2.0 - height / 2.0;
    let reach = [inner, outer + CUT_OVERLAP_MM];
    let slot = wall_opening(HousingSide::Right, width, reach, [bottom, bottom + height])
        .named("cable slot");
    if p.body.cable_angle.rad() == 0.0 { slot } else { slot.turned_z(p.body.cable_angle) }
}

/// Returns the annular LED board.
pub fn led_board(p: &PinTip, layout: &PinTipLayout) -> Body {
    let outline = Profile::new(Path::circle([0.0, 0.0], layout.board_radius_mm))
        .with_hole(Path::circle([0.0, 0.0], p.led_board.bore_radius.mm()));
    LED_BOARD
        .made(
            Process::Pcb,
            Solid::extrusion(outline, p.led_board.thickness.mm()).at_z(layout.board_bottom_z_mm),
        )
        .with_material(&p.led_board.material)
        .placed([in_sensor().lifted(-12.0)])
        .with_landmarks(landmarks_at("led", &led_poses(p, layout)))
        .colored(MASK_GREEN)
        .note("solder the wires to the lower side, inside the ledge, and lead them down the shaft")
        .note("press it in from above until it meets the ledge")
        .with_handles(1)
}

/// Returns the flange onto which the body locks.
pub fn mount(p: &PinTip, layout: &PinTipLayout) -> Body {
    let joint = &layout.mount_joint;
    let inner = joint.spigot_radius - p.mount.spigot_wall.mm();
    let top = layout.body_bottom_z_mm + p.mount.spigot_height.mm();
    let outside = Solid::revolution(Path::polygon(&[
        [0.0, layout.plate_bottom_z_mm],
        [joint.outer_radius, layout.plate_bottom_z_mm],
        [joint.outer_radius, layout.plate_top_z_mm],
        [joint.spigot_radius, layout.plate_top_z_mm],
        [joint.spigot_radius, top],
        [inner, top],
        [inner, layout.plate_top_z_mm],
        [0.0, layout.plate_top_z_mm],
    ]));
    ROBOT_MOUNT
        .made(Process::Fdm, outside.plus(joint.male().at_z(layout.body_bottom_z_mm)))
        .with_material(&p.body.material)
        .placed([in_sensor().lifted(-112.0)])
        .colored(MOUNT_GREY)
        .note("print on its plate; the lugs stand out far enough to print freely")
        .cut(Joints::new(p, layout).robot.clearance_cut())
}

// ------ Tip ------
//
// Printed tip (skin with pins, dots, ring), and the gel and lens that fill and close it.
//
// The three printed bodies leave the printer as one piece. They are built from the same numbers wherever they meet,
// so that their meshes share the vertices of the common faces.

const SKIN_BLACK: Color = [70, 72, 78];
const VERO_WHITE: Color = [244, 244, 240];
const GEL_BLUE: Color = [170, 210, 235];

/// Depth of a pin's root, as a share of the skin's thickness.
const PIN_ROOT_SHARE: f64 = 0.5;

/// Depth of a pin's root in the skin, mm.
pub fn pin_root_mm(p: &PinTip) -> f64 {
    PIN_ROOT_SHARE * p.skin.thickness.mm()
}

/// Poses of the pins. `check` has already refused layouts without any.
fn pin_poses(p: &PinTip, layout: &PinTipLayout) -> Vec<Pose> {
    layout.pin_poses(p).unwrap_or_default()
}

/// Returns a cylinder of a pin's diameter at each pin, between two heights above the skin's inside (positive into the
/// tip).
fn pin_cylinders(
    p: &PinTip,
    layout: &PinTipLayout,
    word: &str,
    from_mm: f64,
    to_mm: f64,
) -> Vec<Solid> {
    let column = Solid::cylinder(layout.pin_diameter_mm / 2.0, to_mm - from_mm).at_z(-to_mm);
    copies(word, &pin_poses(p, layout), &column)
}

/// Returns skin with pins, dots, and ring.
pub fn printed_tip(p: &PinTip, layout: &PinTipLayout) -> [Body; 3] {
    let part = |name: Name, solid: Solid, lift_mm: f64| {
        name.made(Process::PolyJet, solid)
            .with_material(&p.tip.rigid_material)
            .placed([in_sensor().lifted(lift_mm), FILLING.at(flipped()).lifted(-lift_mm)])
            .colored(VERO_WHITE)
            .note(
                "one piece with the other bodies of the group `tip`: load their common 3MF, or \
                 their STL files as one assembly; they share their coordinates",
            )
            .note("wash the support out from below with water, between the pins last and gently")
    };
    let (from, to) = (p.pins.length.mm(), p.pins.length.mm() + p.pins.dot_thickness.mm());
    let dots = Solid::union(pin_cylinders(p, layout, "dot", from, to));
    [
        part(SKIN, skin(p, layout), 84.0)
            .with_material(p.tip.soft_material.clone())
            .as_deformable()
            .colored(SKIN_BLACK),
        part(DOTS, dots, 62.0)
            .with_landmarks(dot_landmarks(p, layout))
            // Each dot is a separate piece without a hole.
            .with_shells(Shells::pieces(dot_landmarks(p, layout).len())),
        part(RING, printed_ring(layout), 24.0)
            .with_landmarks(vec![Landmark {
                name: "mouth".into(),
                point: Point3::new(0.0, 0.0, layout.ring_bottom_z_mm),
                axis: -Vector3::z(),
            }])
            .with_handles(1),
    ]
}

fn skin(p: &PinTip, layout: &PinTipLayout) -> Solid {
    let (inner, outer, upstand) =
        (layout.skin_radius_mm, layout.outer_radius_mm, layout.upstand_radius_mm);
    let bowl = Path::from([inner, 0.0])
        .arc([0.0, inner], [0.0, 0.0], true)
        .line([0.0, outer])
        .arc([outer, 0.0], [0.0, 0.0], false)
        .line([outer, layout.skirt_z_mm])
        .line([upstand, layout.skirt_z_mm])
        .line([upstand, 0.0])
        .close();
    let pins = pin_cylinders(p, layout, "pin", -pin_root_mm(p), p.pins.length.mm());
    Solid::union(std::iter::once(Solid::revolution(bowl).named("skin")).chain(pins))
}

fn printed_ring(layout: &PinTipLayout) -> Solid {
    let bore = layout.tip_joint.bore_radius;
    let outline = Path::polygon(&[
        [layout.skin_radius_mm, 0.0],
        [layout.upstand_radius_mm, 0.0],
        [layout.upstand_radius_mm, layout.skirt_z_mm],
        [layout.outer_radius_mm, layout.skirt_z_mm],
        [layout.outer_radius_mm, layout.ring_bottom_z_mm],
        [bore, layout.ring_bottom_z_mm],
        [bore, layout.lens_top_z_mm],
        [layout.ledge_radius_mm, layout.lens_top_z_mm],
        [layout.ledge_radius_mm, layout.slope_bottom_z()],
    ]);
    Solid::revolution(outline).minus_all(layout.tip_joint.female_tools(layout.ring_bottom_z_mm))
}

/// Markers that the camera tracks: the dots on the ends of the pins.
pub fn dot_marks(p: &PinTip, layout: &PinTipLayout) -> Vec<Marker> {
    let depth = p.pins.length.mm() + p.pins.dot_thickness.mm();
    let pin = |pose: &Pose| MarkerCarrier::Pin { root: pose.point(Point3::origin()) };
    Marker::place_below_poses(
        "dot",
        &pin_poses(p, layout),
        depth,
        layout.pin_diameter_mm / 2.0,
        pin,
    )
}

/// Landmarks at the centres of the dots' outer faces, along the directions of their pins.
fn dot_landmarks(p: &PinTip, layout: &PinTipLayout) -> Vec<Landmark> {
    let landmark = |mark: Marker| Landmark { name: mark.name, point: mark.point, axis: mark.axis };
    dot_marks(p, layout).into_iter().map(landmark).collect()
}

/// Returns the gel between skin and lens, around pins and dots.
pub fn gel(p: &PinTip, layout: &PinTipLayout) -> Body {
    let inner = layout.skin_radius_mm;
    let core = Path::from([0.0, layout.lens_top_z_mm])
        .line([layout.ledge_radius_mm, layout.lens_top_z_mm])
        .line([layout.ledge_radius_mm, layout.slope_bottom_z()])
        .line([inner, 0.0])
        .arc([0.0, inner], [0.0, 0.0], true)
        .close();
    let end = p.pins.length.mm() + p.pins.dot_thickness.mm();
    GEL.cast(Solid::revolution(core).minus_all(pin_cylinders(
        p,
        layout,
        "pin",
        -pin_root_mm(p),
        end,
    )))
    .with_material(&p.fill.material)
    .placed([in_sensor().lifted(44.0), FILLING.at(flipped()).lifted(-44.0)])
    .colored(GEL_BLUE)
    .opaque(0.35)
    // Pins leave blind dimples in the gel, so it has no handles.
}

/// Centres of the two holes in the lens, mm: gel enters at one, air leaves at the other.
pub fn lens_holes(p: &PinTip) -> [[f64; 2]; 2] {
    let radius = p.lens.hole_radius.mm();
    [[radius, 0.0], [-radius, 0.0]]
}

/// Returns the lens, a flat window that closes the tip.
pub fn lens(p: &PinTip, layout: &PinTipLayout) -> Body {
    let hole = p.lens.hole_diameter.mm() / 2.0;
    let outline = lens_holes(p)
        .into_iter()
        .fold(Profile::new(Path::circle([0.0, 0.0], layout.lens_radius_mm)), |profile, centre| {
            profile.with_hole(Path::circle(centre, hole))
        });
    let solid = Solid::extrusion(outline, p.lens.thickness.mm()).at_z(layout.lens_bottom_z_mm);
    LENS.made(Process::Laser, solid)
        .with_material(&p.lens.material)
        .as_window(window_transparency(&p.lens.material))
        .placed([in_sensor().lifted(8.0), FILLING.at(flipped()).lifted(-8.0)])
        .colored(GLASS)
        .note("cut with the film on; peel it off before gluing")
        .with_handles(2)
}

// ------ Gauge ------
//
// Gauge in which the lens is focused: once the board is screwed in, no finger reaches the lens.

/// Thickness of the gauge's wall and of its target, mm.
const GAUGE_WALL_MM: f64 = 2.0;

/// Clearance beside lens holder and barrel, mm.
const GAUGE_CLEARANCE_MM: f64 = 0.6;

/// Reach of the finger windows beyond the lens's front, mm: the width of a fingertip.
const FINGERS_MM: f64 = 16.0;

/// Width of those windows as a share of the gauge's radius. Four legs remain, over the board's corners.
const WINDOW_SHARE: f64 = 0.9;

/// Number of the target's holes around the one in the middle.
const TARGET_COUNT: u32 = 6;

/// Radius of the circle of target holes, mm: the middle of the image, where the pins are pressed first.
const TARGET_CIRCLE_MM: f64 = 4.0;

/// Outer and inner radius of the gauge, mm. It stands on the board, around the lens holder.
fn radii_mm(p: &PinTip) -> [f64; 2] {
    let camera = &p.camera;
    let corner = camera.holder_size.mm() * std::f64::consts::FRAC_1_SQRT_2;
    let least = corner.max(camera.barrel_diameter.mm() / 2.0) + GAUGE_CLEARANCE_MM + GAUGE_WALL_MM;
    let board = camera.board_size.mm().min(camera.board_size_y.mm()) / 2.0 - GAUGE_CLEARANCE_MM;
    let outer = least.max(board);
    [outer, outer - GAUGE_WALL_MM]
}

/// Returns the gauge: a tube on four legs with a target on top, whose holes are seen against the light. The target is
/// as far away in air as the dots appear through lens and gel.
pub fn gauge(p: &PinTip, layout: &PinTipLayout) -> Body {
    let [outer, inner] = radii_mm(p);
    let bottom = layout.camera_board_top_z_mm;
    let target = layout.lens_front_z_mm + layout.focus_distance_mm(p);
    let bell = Solid::revolution(Path::polygon(&[
        [inner, bottom],
        [outer, bottom],
        [outer, target + GAUGE_WALL_MM],
        [0.0, target + GAUGE_WALL_MM],
        [0.0, target],
        [inner, target],
    ]));
    let (half, far) = (WINDOW_SHARE * outer / 2.0, outer + CUT_OVERLAP_MM);
    // The tube stays closed below the target, even if that is near.
    let top = (layout.lens_front_z_mm + FINGERS_MM).min(target - GAUGE_WALL_MM);
    let bottom = bottom - CUT_OVERLAP_MM;
    let windows = [
        Solid::cuboid_between([-far, -half, bottom], [far, half, top]).named("window along x"),
        Solid::cuboid_between([-half, -far, bottom], [half, far, top]).named("window along y"),
    ];
    let hole = Solid::rod(
        layout.pin_diameter_mm / 2.0,
        [target - CUT_OVERLAP_MM, target + GAUGE_WALL_MM + CUT_OVERLAP_MM],
    );
    let around = ring(TARGET_COUNT, 0.0, Pose::translation(TARGET_CIRCLE_MM, 0.0, 0.0));
    let places = [&[Pose::identity()], &around[..]].concat();
    FOCUS_GAUGE
        .made(Process::Fdm, bell.minus_all(windows).minus_all(copies("target", &places, &hole)))
        .with_material(&p.body.material)
        .placed([FOCUSING.in_place().lifted(30.0)])
        .colored(TOOL_GREY)
        .with_bed_orientation(flipped())
        .note("print on the target, legs up, without support")
        .with_supports(false)
        .with_handles(places.len() as i32)
}
