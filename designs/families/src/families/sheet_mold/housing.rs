//! All parts that are cut from sheets: box, display and molds.

use std::f64::consts::FRAC_PI_2;

use fabkit_geometry::{
    Angle, Body, Color, Landmark, Lighting, LiquidColumn, Marker, MarkerCarrier, NominalCamera,
    Path, Placement, Point3, Pose, Process, Profile, Solid, Vector3, VisibleEffect,
};

use super::layers::{comb_opening, display_channel_y, display_inlet, left_channels, resting_end_x};
use super::parameters::*;
use super::{Joints, SheetMoldLayout, bolt_hole_mm, marker_centres};
use crate::blocks::adapter::{CableOutlet, MountFace};
use crate::blocks::{BLACK, MOLD_BLUE, Rect};
use crate::chain_builder::{Name, SENSOR, flipped, shrinkage};
use crate::fits::Fit;
use crate::hardware::HexSpacer;
use crate::hardware::tools::pry;
use crate::materials::window_transparency;

// ------ Housing ------
//
// The rigid box: four walls between two plates, held together by spacers and screws in the corners, without glue.
// Everything is cut from one sheet, because the molds need the laser anyway and a dark sheet is as light-tight as a
// print. Edges are square, as a laser leaves them.

/// Distance by which tabs end below the surface of the plate that they reach into, so that nothing rocks on them, mm.
const TAB_RECESS_MM: f64 = 0.3;

/// Displacement of the walls in the exploded view, mm.
const WALL_EXPLODE_MM: f64 = 34.0;

/// Displacement of a clamping bar in the exploded view, in the bar's frame, mm.
pub const BAR_EXPLODE_MM: Vector3<f64> = Vector3::new(0.0, 26.0, 76.0);

/// Number of walls of the box.
const WALL_COUNT: u32 = 4;

/// Returns plates, walls and clamping bars.
pub fn box_sheets(p: &SheetMold, layout: &SheetMoldLayout) -> Vec<Body> {
    let cut = |name, profile, thickness_mm: f64| {
        sheet(name, profile, thickness_mm, &p.housing.material).colored(BLACK)
    };
    let (thickness, cable) = (p.housing.sheet.mm(), p.housing.cable_side.quarters());
    let window = Path::rectangle([0.0; 2], [p.housing.window.mm(); 2], 0.0);
    let slotted = |name| {
        let plate = with_bolts(Profile::new(square(p)), p, layout, name);
        with_tab_slots(plate, p, layout, name)
    };
    let bar = |i| {
        let pose = quarter(i).then_in(Pose::translation(0.0, 0.0, layout.bond_z_mm));
        SENSOR.at(pose).moved_apart(pose.vector(BAR_EXPLODE_MM))
    };
    vec![
        cut(BOX_CEILING, slotted(BOX_CEILING).with_hole(window), thickness)
            .placed([SENSOR.at_z(layout.ceiling_z_mm)]),
        cut(BOX_FLOOR, Joints::new(p, layout).camera.pierce_profile(slotted(BOX_FLOOR)), thickness)
            .placed([SENSOR, BOX_FOCUSING].map(|at| at.at_z(layout.bottom_z_mm).lifted(-34.0))),
        cut(CABLE_WALL, Profile::new(wall(p, layout, true)), thickness)
            .placed([wall_placement(layout, cable)]),
        cut(BOX_WALL, Profile::new(wall(p, layout, false)), thickness)
            .placed((1..WALL_COUNT).map(|i| wall_placement(layout, (cable + i) % WALL_COUNT)))
            .one_per_place(),
        cut(CLAMP_BAR, clamp_bar(p, layout), p.housing.clamp.mm())
            .placed([0, 2].map(bar))
            .one_per_place()
            .note("one on either side without tubes"),
    ]
}

/// Rotation about z by `i` quarter turns.
fn quarter(i: u32) -> Pose {
    Pose::rotation_z(Angle::from_rad(f64::from(i) * FRAC_PI_2).expect("finite"))
}

/// Pose of the wall's frame (x along the wall, y up, z outwards) for wall `i`, which stands on the floor. Wall 0 is
/// at +x.
pub fn sensor_from_wall(layout: &SheetMoldLayout, i: u32) -> Pose {
    let right_angle = Angle::from_rad(FRAC_PI_2).expect("finite");
    let upright = Pose::rotation_z(right_angle).then_in(Pose::rotation_x(right_angle));
    quarter(i)
        .then_in(Pose::translation(layout.wall_inner_mm, 0.0, layout.floor_z_mm))
        .then_in(upright)
}

fn wall_placement(layout: &SheetMoldLayout, i: u32) -> Placement {
    SENSOR.at_exploded(&sensor_from_wall(layout, i), WALL_EXPLODE_MM)
}

/// Positions of a wall's two tabs along the wall, mm.
fn tab_centres(layout: &SheetMoldLayout) -> [f64; 2] {
    [-layout.wall_inner_mm / 2.0, layout.wall_inner_mm / 2.0]
}

/// Outline of a wall. Its right edge has fingers where its left edge has gaps, so that four equal walls close the
/// box.
fn wall(p: &SheetMold, layout: &SheetMoldLayout, has_cable: bool) -> Path {
    // Fingers of either wall mesh with those of the other, so the larger gap applies.
    let meshing = [CABLE_WALL, BOX_WALL].map(|wall| (wall, Process::Laser));
    let (height, play) = (p.housing.height.mm(), p.making.widest_gap_mm(meshing, Fit::Snug));
    let (finger, gap) = (layout.wall_outer_mm, layout.wall_inner_mm - play);
    let tab = p.housing.tab.mm() / 2.0;
    let reach = p.housing.sheet.mm() - TAB_RECESS_MM;

    // Corners, from bottom to top, of an edge whose fingers are the intervals of this parity.
    let edge = |parity: u32| -> Vec<[f64; 2]> {
        let is_finger = |j: u32| j % 2 == parity;
        let x = |j: u32| if is_finger(j) { finger } else { gap };
        let mut points = vec![[x(0), 0.0]];
        for j in 1..p.housing.fingers {
            let boundary = height * f64::from(j) / f64::from(p.housing.fingers);
            // Each finger is narrower than its gap by the play on both sides.
            let y = if is_finger(j) { boundary + play } else { boundary - play };
            points.extend([[x(j - 1), y], [x(j), y]]);
        }
        points.push([x(p.housing.fingers - 1), height]);
        points
    };
    let mut points = Vec::new();
    let [left_tab, right_tab] = tab_centres(layout);
    let tab_below = |x: f64| [[x - tab, 0.0], [x - tab, -reach], [x + tab, -reach], [x + tab, 0.0]];
    points.extend(tab_below(left_tab));
    if has_cable {
        let (w, h) = (p.housing.cable_width.mm() / 2.0, p.housing.cable_height.mm());
        points.extend([[-w, 0.0], [-w, h], [w, h], [w, 0.0]]);
    }
    points.extend(tab_below(right_tab));
    points.extend(edge(0));
    for x in [right_tab, left_tab] {
        points.extend(tab_below(x).iter().rev().map(|[x, y]| [*x, height - y]));
    }
    points.extend(edge(1).into_iter().rev().map(|[x, y]| [-x, y]));
    Path::polygon(&points)
}

fn with_tab_slots(
    profile: Profile,
    p: &SheetMold,
    layout: &SheetMoldLayout,
    plate: Name,
) -> Profile {
    let play = 2.0 * p.making.gap_mm(plate, Process::Laser, Fit::Slide);
    let (along, across) = (p.housing.tab.mm() + play, p.housing.sheet.mm() + play);
    let middle = (layout.wall_inner_mm + layout.wall_outer_mm) / 2.0;
    (0..WALL_COUNT).fold(profile, |profile, i| {
        tab_centres(layout).into_iter().fold(profile, |profile, offset| {
            let (centre, size) = match i {
                0 => ([middle, offset], [across, along]),
                1 => ([offset, middle], [along, across]),
                2 => ([-middle, offset], [across, along]),
                _ => ([offset, -middle], [along, across]),
            };
            profile.with_hole(Path::rectangle(centre, size, 0.0))
        })
    })
}

/// Profile of the clamping bar at +y. The other bar is the same, rotated.
fn clamp_bar(p: &SheetMold, layout: &SheetMoldLayout) -> Profile {
    let half = p.plate.side.mm() / 2.0;
    let inner = clamp_inner_mm(p);
    let r = half - layout.bolt_mm;
    let outline = Path::from([-half, inner])
        .line([half, inner])
        .line([half, half - r])
        .arc([half - r, half], [half - r, half - r], true)
        .line([r - half, half])
        .arc([-half, half - r], [r - half, half - r], true)
        .close();
    let holes = [[layout.bolt_mm, layout.bolt_mm], [-layout.bolt_mm, layout.bolt_mm]];
    with_holes(Profile::new(outline), &holes, bolt_hole_mm(p, CLAMP_BAR))
}

/// Distance of a clamping bar's inner edge from the axis, mm.
pub fn clamp_inner_mm(p: &SheetMold) -> f64 {
    p.channel_layer.side.mm() / 2.0 + p.housing.clamp_gap.mm()
}

/// Returns the face by which the box is mounted: the corner screws in its floor, which then pass through a plate
/// below it too.
pub fn mount_face(p: &SheetMold, layout: &SheetMoldLayout) -> MountFace {
    let joints = Joints::new(p, layout);
    let is_below = |pose: &Pose| pose.vector(Vector3::z()).z < 0.0;
    let mut mounting = joints.housing.clone();
    mounting.poses.retain(is_below);
    let sheet = p.housing.sheet.mm();
    let head = &joints.camera.screw;
    let size = [head.head_diameter_mm() / 2.0, head.head_height_mm()];
    let half = p.plate.side.mm() / 2.0;
    MountFace {
        holder: BOX_FLOOR,
        mounting,
        replaced_screw_mm: Some([sheet, sheet + HexSpacer::M3.thread_depth_mm]),
        bottom_z_mm: layout.bottom_z_mm,
        outline: Rect { half: [half; 2], corner: half - layout.bolt_mm },
        exits: vec![CableOutlet::Sideways {
            angle: p.housing.cable_side.angle(),
            width_mm: p.housing.cable_width.mm(),
            above_mm: sheet,
        }],
        heads: joints
            .camera
            .poses
            .iter()
            .map(|pose| (pose.translation_mm().xy().into(), size))
            .collect(),
    }
}

// ------ Sheets ------
//
// Laser-cut sheets. Each is an extrusion of one profile, standing on z = 0 of its own frame; placements lift it into
// position.

/// Returns a sheet with this profile. Each of its holes counts as one handle.
pub fn sheet(name: Name, profile: Profile, thickness_mm: f64, material: &str) -> Body {
    let handles = profile.holes.len() as i32;
    name.made(Process::Laser, Solid::extrusion(profile, thickness_mm))
        .with_material(material)
        .with_handles(handles)
        .as_window(window_transparency(material))
}

/// Outline that all square plates share.
pub fn square(p: &SheetMold) -> Path {
    Path::rectangle([0.0; 2], [p.plate.side.mm(); 2], corner_mm(p))
}

/// The same outline with a notch for a screwdriver in the middle of each of the sides at -y and +y.
pub fn notched_plate_outline(p: &SheetMold) -> Path {
    let (half, r) = (p.plate.side.mm() / 2.0, corner_mm(p));
    let (w, depth) = (p.plate.pry_width.mm() / 2.0, p.plate.pry_depth.mm());
    let floor = half - depth;
    Path::from([half - r, -half])
        .arc([half, r - half], [half - r, r - half], true)
        .line([half, half - r])
        .arc([half - r, half], [half - r, half - r], true)
        .line([w, half])
        .line([w, floor])
        .line([-w, floor])
        .line([-w, half])
        .line([r - half, half])
        .arc([-half, half - r], [r - half, half - r], true)
        .line([-half, r - half])
        .arc([r - half, -half], [r - half, r - half], true)
        .line([-w, -half])
        .line([-w, -floor])
        .line([w, -floor])
        .line([w, -half])
        .close()
}

/// Adds the screwdriver poses that part a notched sheet from its neighbours.
pub fn with_pry_tools(p: &SheetMold, sheet: Body, thickness_mm: f64) -> Body {
    let turns =
        [-90.0, 90.0].map(|deg| Angle::from_deg(deg).expect("a quarter of a turn is finite"));
    let mouth = Pose::translation(p.plate.side.mm() / 2.0, 0.0, thickness_mm / 2.0);
    turns.into_iter().fold(sheet, |sheet, turn| {
        sheet.with_tool_access(pry(Pose::rotation_z(turn).then_in(mouth), p.plate.pry_depth.mm()))
    })
}

/// Radius of the plates' corners, mm. The rounded corner is as far from the bolt as the straight sides are.
fn corner_mm(p: &SheetMold) -> f64 {
    (p.plate.side.mm() - p.plate.bolt_spacing.mm()) / 2.0
}

/// Adds the four bolt holes of a square plate.
pub fn with_bolts(
    profile: Profile,
    p: &SheetMold,
    layout: &SheetMoldLayout,
    plate: Name,
) -> Profile {
    with_holes(profile, &layout.bolts(), bolt_hole_mm(p, plate))
}

/// Adds round holes.
pub fn with_holes(profile: Profile, centres: &[[f64; 2]], radius_mm: f64) -> Profile {
    centres.iter().fold(profile, |p, &centre| p.with_hole(Path::circle(centre, radius_mm)))
}

// ------ Display ------
//
// The display: three sheets with straight channels between them, a strip that closes their vents, and a plate on
// spacers that holds the second camera above.

const CLEAR: Color = [214, 228, 234];
const WHITE: Color = [246, 246, 242];

/// Radius of the display's corners, mm.
const CORNER_MM: f64 = 4.0;

/// Radius of the holes into which the needles are glued, mm.
pub fn needle_hole_mm(p: &SheetMold) -> f64 {
    p.tubes.needle_outer_diameter.mm() / 2.0
        + p.making.gap_mm(DISPLAY_COVER, Process::Laser, Fit::Snug)
}

/// Largest radius of a vent at a channel's far end, mm. Air passes through it, and a film of cement closes it.
const VENT_MM: f64 = 0.6;

/// Half width along the channels of the strip that closes the vents, mm.
const SEAL_HALF_MM: f64 = 3.0;

/// Overhang of that strip beyond the outermost vents, mm.
const SEAL_OVERHANG_MM: f64 = 2.0;

/// Radius of the vents, mm. Each opens over its own channel alone.
fn vent_radius_mm(p: &SheetMold) -> f64 {
    (p.display.channel_width.mm() / 2.0 - 0.1).min(VENT_MM)
}

/// Position of the vents: x in the display's frame, mm. They are far enough from the channels' ends for the strip to
/// clear the spacers.
pub fn vent_x(p: &SheetMold) -> f64 {
    let [inlet, _] = display_inlet(p, 0.0);
    SEAL_HALF_MM - inlet
}

/// Edge of the strip over the vents that faces the liquid: x in the display's frame, mm.
pub fn seal_end_x(p: &SheetMold) -> f64 {
    vent_x(p) + SEAL_HALF_MM
}

/// Volume of air enclosed ahead of one column of liquid at rest, mm3: in its channel, and in the vent below the
/// strip.
pub fn enclosed_air_mm3(p: &SheetMold) -> f64 {
    let ([inlet, _], rest) = (display_inlet(p, 0.0), resting_end_x(p));
    let radius = p.display.channel_width.mm() / 2.0;
    let ahead = Path::from([rest, radius])
        .line([-inlet, radius])
        .arc([-inlet, -radius], [-inlet, 0.0], true)
        .line([rest, -radius])
        .close();
    let vent = Path::circle([0.0; 2], vent_radius_mm(p));
    p.display.sheet.mm() * (ahead.signed_area_mm2().abs() + vent.signed_area_mm2())
}

/// Profile of the strip that is cemented over the vents, with its centre on the axis.
fn seal(p: &SheetMold) -> Profile {
    let last = display_channel_y(p).into_iter().fold(0.0, f64::max);
    let half = last + vent_radius_mm(p) + SEAL_OVERHANG_MM;
    Profile::new(Path::rectangle([0.0; 2], [2.0 * SEAL_HALF_MM, 2.0 * half], 0.0))
}

/// Returns the columns of liquid as the second camera sees them.
pub fn display_lighting(p: &SheetMold, layout: &SheetMoldLayout) -> Lighting {
    let column = |y: f64| LiquidColumn {
        end: layout.sensor_from_display.point(Point3::new(
            resting_end_x(p),
            y,
            2.0 * p.display.sheet.mm(),
        )),
        direction: layout.sensor_from_display.vector(-Vector3::x()),
        width_mm: p.display.channel_width.mm(),
    };
    let columns = display_channel_y(p).into_iter().map(column).collect();
    let size = [p.camera.width_px, p.camera.height_px];
    let view = (p.camera.field_of_view, p.camera.projection);
    let camera = p.camera.optics.camera_at(0.0, size, view);
    // The camera is above the display and looks down.
    let above = Pose::translation(0.0, 0.0, layout.display_pupil_z_mm).then_in(flipped());
    Lighting {
        name: "display",
        light_sources: Vec::new(),
        effect: VisibleEffect::LiquidColumns { liquid: DISPLAY_LIQUID.into(), columns },
        camera: Some(NominalCamera {
            sensor_from_camera: layout.sensor_from_display.then_in(above),
            ..camera
        }),
        diffuser: None,
    }
}

/// Returns the display's sheets from below, and the plate of its camera.
pub fn display_sheets(p: &SheetMold, layout: &SheetMoldLayout) -> Vec<Body> {
    let plate = |name| {
        let outline = Path::rectangle([0.0; 2], layout.display_size_mm, CORNER_MM);
        with_holes(Profile::new(outline), &layout.display_bolts(p), bolt_hole_mm(p, name))
    };
    let place = |z: f64, lift_mm: f64| {
        let in_display = Pose::translation(0.0, 0.0, z);
        [SENSOR.at(layout.sensor_from_display.then_in(in_display)).lifted(lift_mm)]
    };
    let t = p.display.sheet.mm();
    let inlets: Vec<[f64; 2]> =
        display_channel_y(p).into_iter().map(|y| display_inlet(p, y)).collect();
    let vents: Vec<[f64; 2]> = display_channel_y(p).into_iter().map(|y| [vent_x(p), y]).collect();
    let channels = inlets.iter().fold(plate(DISPLAY_CHANNELS), |profile, &[x, y]| {
        profile.with_hole(Path::slot([-x, y], [x, y], p.display.channel_width.mm() / 2.0))
    });
    let over_vents = layout.sensor_from_display.then_in(Pose::translation(vent_x(p), 0.0, 3.0 * t));
    vec![
        sheet(DISPLAY_BACK, plate(DISPLAY_BACK), t, &p.display.back_material)
            .placed(place(0.0, 0.0))
            .colored(WHITE),
        sheet(DISPLAY_CHANNELS, channels, t, &p.display.clear_material)
            .placed(place(t, 10.0))
            .with_landmarks(rest_landmarks(p))
            .colored(CLEAR),
        sheet(
            DISPLAY_COVER,
            with_holes(
                with_holes(plate(DISPLAY_COVER), &inlets, needle_hole_mm(p)),
                &vents,
                vent_radius_mm(p),
            ),
            t,
            &p.display.clear_material,
        )
        .placed(place(2.0 * t, 28.0))
        .colored(CLEAR),
        sheet(DISPLAY_SEAL, seal(p), t, &p.display.clear_material)
            .placed([SENSOR.at(over_vents).lifted(46.0)])
            .colored(CLEAR),
        sheet(
            STAND_PLATE,
            Joints::new(p, layout).camera.pierce_profile(plate(STAND_PLATE)),
            p.housing.sheet.mm(),
            &p.housing.material,
        )
        .placed(place(layout.stand_z_mm, 96.0))
        .colored(BLACK),
    ]
}

/// Landmarks at the ends of the liquid columns at rest, at mid height, in the channel sheet's frame.
fn rest_landmarks(p: &SheetMold) -> Vec<Landmark> {
    let rest = |(k, y): (usize, f64)| Landmark {
        name: format!("rest {}", k + 1),
        point: Point3::new(resting_end_x(p), y, p.display.sheet.mm() / 2.0),
        axis: -Vector3::x(),
    };
    display_channel_y(p).into_iter().enumerate().map(rest).collect()
}

// ------ Molds ------
//
// The two mold stacks. Bolts through the corners align and close each. Every sheet is as thick as the layer that it
// casts.

const PLYWOOD: Color = [214, 180, 130];
const SEAL_NOTE: &str =
    "seal the wood with acrylic lacquer before use: bare wood can keep silicone from curing";

/// Returns all sheets of both stacks.
pub fn mold_sheets(p: &SheetMold, layout: &SheetMoldLayout) -> Vec<Body> {
    // All sheets of a stack are scaled alike, and both stacks share their floor, so one shrinkage serves for all.
    let shrinkage = shrinkage(&p.marker_layer.material);
    let floor_mm = p.molds.floor.mm();
    let channels = left_channels(p);
    let opening = |side_mm: f64| Path::rectangle([0.0; 2], [side_mm; 2], 0.0);
    let cut = |name, profile, thickness_mm, material: &str| {
        sheet(name, with_bolts(profile, p, layout, name), thickness_mm, material)
            .sealed("lacquer")
            .colored(PLYWOOD)
            .for_shrinkage(shrinkage)
    };
    let notched = |name, profile, thickness_mm, material: &str| {
        with_pry_tools(p, cut(name, profile, thickness_mm, material), thickness_mm)
    };
    let (acrylic, wood) = (&p.molds.channel_material, &p.molds.marker_material);
    let centres = marker_centres(p);
    vec![
        cut(MOLD_FLOOR, Profile::new(square(p)), floor_mm, wood)
            .placed([
                CHANNEL_MOLD.at_z(layout.bond_z_mm - floor_mm).lifted(-18.0),
                MARKER_MOLD.at_z(layout.marker_end_z_mm - floor_mm).lifted(-18.0),
            ])
            .with_quantity(2)
            .note(SEAL_NOTE),
        notched(
            CHANNEL_COMB,
            Profile::new(notched_plate_outline(p))
                .with_hole(comb_opening(&channels, p.channel_layer.side.mm())),
            p.channels.height.mm(),
            acrylic,
        )
        .placed([CHANNEL_MOLD.at_z(layout.bond_z_mm)])
        .colored(MOLD_BLUE)
        .note("peel the protective film off")
        .note("silicone creeps under the fingers: trim that film off the channels after casting"),
        cut(
            CHANNEL_FRAME,
            Profile::new(square(p)).with_hole(opening(p.channel_layer.side.mm())),
            p.channel_layer.roof.mm(),
            acrylic,
        )
        .placed([CHANNEL_MOLD.at_z(layout.channel_top_z_mm).lifted(18.0)])
        .colored(MOLD_BLUE)
        .note("silicone is poured in here and scraped off level with the top"),
        notched(
            MARKER_PLATE,
            with_holes(
                Profile::new(notched_plate_outline(p)),
                &centres,
                p.markers.diameter.mm() / 2.0,
            ),
            p.markers.height.mm(),
            wood,
        )
        .placed([MARKER_MOLD.at_z(layout.marker_end_z_mm)])
        .with_landmarks(marker_landmarks(&centres))
        .note(SEAL_NOTE),
        cut(
            MARKER_FRAME,
            Profile::new(square(p)).with_hole(opening(p.marker_layer.side.mm())),
            p.marker_layer.thickness.mm(),
            wood,
        )
        .placed([MARKER_MOLD.in_place().lifted(18.0), SENSOR.in_place().lifted(10.0)])
        .note(SEAL_NOTE),
    ]
}

/// Ends of the markers, paint included, which the camera tracks.
pub fn marks(p: &SheetMold, layout: &SheetMoldLayout) -> Vec<Marker> {
    let end_mm = layout.marker_end_z_mm - p.markers.paint.mm();
    let poses = marker_centres(p).into_iter().map(|[x, y]| Pose::translation(x, y, end_mm));
    let radius_mm = p.markers.diameter.mm() / 2.0;
    Marker::place_below_poses("marker", &poses.collect::<Vec<_>>(), 0.0, radius_mm, |_| {
        MarkerCarrier::Gel
    })
}

/// Landmarks at the ends of the markers, in the frame of the sheet that shapes them.
fn marker_landmarks(centres: &[[f64; 2]]) -> Vec<Landmark> {
    let landmark = |(i, [x, y]): (usize, &[f64; 2])| Landmark {
        name: format!("marker {}", i + 1),
        point: Point3::new(*x, *y, 0.0),
        axis: -Vector3::z(),
    };
    centres.iter().enumerate().map(landmark).collect()
}
