//! What is bought: cameras, screws, spacers, tubes, needles, LEDs.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Color, Placement, Pose, Process, Solid, Vector3};

use super::channels::Side;
use super::housing::{BAR_EXPLODE_MM, camera_holes, sensor_from_wall};
use super::layers::{display_channel_y, display_inlet, tube_poses};
use super::layout::{Layout, camera_board_top_mm, flipped, hanging, upright};
use super::parameters::SheetMold;
use super::{AssemblyName, CHANNEL_MOLD, MARKER_MOLD, SENSOR};
use crate::fits::{Fit, gap_mm};
use crate::hardware::{HexNut, HexSpacer, Screw};

const STEEL: Color = [176, 180, 186];
const BRASS: Color = [205, 170, 90];

/// Length of tube that is shown at either end, mm.
const TUBE_STUB_MM: f64 = 20.0;

/// Pieces of one body reach this far into each other, mm.
const JOIN_MM: f64 = 0.2;

/// Height of an LED strip's middle above the box's floor, mm: below the camera's lens.
const LED_HEIGHT_MM: f64 = 14.0;

/// Everything bought.
pub fn components(p: &SheetMold, layout: &Layout) -> Vec<Body> {
    let bought = |name: &str, specification: String, solid, placements: Vec<Placement>| {
        Body::bought(name, specification, solid).placed(placements).one_per_place().colored(STEEL)
    };
    let sheet = p.housing.sheet.mm();
    let clamp_z = layout.bond_z + p.housing.clamp.mm();
    let on_display = |pose: Pose| SENSOR.at(layout.sensor_from_display.then_in(pose));
    let below_box = |c: [f64; 2]| SENSOR.at(hanging(c, layout.bottom_z)).lifted(-52.0);

    let mut m3 = Vec::new();
    for corner in layout.bolts() {
        let side = Vector3::new(0.0, BAR_EXPLODE_MM.y * corner[1].signum(), BAR_EXPLODE_MM.z);
        m3.push(SENSOR.at(upright(corner, clamp_z)).moved_apart(side).lifted(16.0));
        m3.push(below_box(corner));
    }
    for corner in layout.display_bolts(p) {
        m3.push(on_display(hanging(corner, 0.0)).lifted(-16.0));
        m3.push(on_display(upright(corner, layout.stand_z + sheet)).lifted(112.0));
    }
    // The molds borrow the sensor's screws: they are needed one after the other.
    let m3_in_use = m3.len() as u32;
    let mut nuts = Vec::new();
    for (mold, bottom_z, top_z) in stacks(p, layout) {
        for corner in layout.bolts() {
            m3.push(mold.at(hanging(corner, bottom_z)).lifted(-34.0));
            nuts.push(mold.at(upright(corner, top_z)).lifted(30.0));
        }
    }

    let camera_poses = [
        SENSOR.at(Pose::translation(0.0, 0.0, layout.floor_z)).lifted(-12.0),
        on_display(Pose::translation(0.0, 0.0, layout.stand_z).then_in(flipped())).lifted(84.0),
    ];
    // Each camera's frame: origin on the plate that carries it, z axis along the line of sight.
    let at_holes = |z: f64, out_mm: f64, is_head_down: bool| -> Vec<Placement> {
        let place = |camera: &Placement| {
            let plate = camera.assembly_from_body;
            let out = plate.vector(Vector3::new(0.0, 0.0, out_mm));
            let camera = camera.clone();
            camera_holes(p).map(move |hole| {
                let pose = if is_head_down { hanging(hole, z) } else { upright(hole, z) };
                Placement { assembly_from_body: plate.then_in(pose), ..camera.clone() }
                    .moved_apart(out)
            })
        };
        camera_poses.iter().flat_map(place).collect()
    };

    let tube_ends = Side::BOTH.into_iter().flat_map(|side| {
        let out = Vector3::new(40.0 * side.sign(), 0.0, 44.0);
        tube_poses(p, layout, side).into_iter().map(move |pose| SENSOR.at(pose).moved_apart(out))
    });
    let inlets: Vec<[f64; 2]> =
        display_channel_y(p).into_iter().map(|y| display_inlet(p, y)).collect();
    let display_tubes =
        inlets.iter().map(|&c| on_display(upright(c, layout.cover_top)).lifted(92.0));
    let needle_z = layout.cover_top - p.display.sheet.mm();

    vec![
        bought("camera", camera_specification(p), camera(p), camera_poses.to_vec())
            .colored([35, 60, 45]),
        bought(
            "spacer-m2",
            format!("round spacer, 2.2 x 4 mm, {} mm long", p.camera.spacer.mm()),
            tube(1.1, 2.0, p.camera.spacer.mm()),
            at_holes(0.0, -8.0, false),
        ),
        bought(
            "screw-m2x12",
            "pan head screw ISO 7045 M2x12".into(),
            Screw::M2X12.solid(),
            at_holes(-sheet, -40.0, true),
        ),
        bought(
            "nut-m2",
            "hexagon nut ISO 4032 M2".into(),
            HexNut::M2.solid(),
            at_holes(camera_board_top_mm(p), 8.0, false),
        ),
        bought(
            "screw-m3x12",
            "pan head screw ISO 7045 M3x12; the molds borrow them".into(),
            Screw::M3X12.solid(),
            m3,
        )
        .times(m3_in_use),
        bought("nut-m3", "hexagon nut ISO 4032 M3".into(), HexNut::M3.solid(), nuts),
        bought(
            "box-spacer",
            format!("hexagonal spacer M3, female both ends, {} mm", p.housing.height.mm()),
            HexSpacer::M3.solid(p.housing.height.mm()),
            layout.bolts().map(|c| SENSOR.at(upright(c, layout.floor_z)).lifted(-10.0)).to_vec(),
        )
        .colored(BRASS),
        bought(
            "stand-spacer",
            format!("hexagonal spacer M3, female both ends, {} mm", p.display.camera_spacer.mm()),
            HexSpacer::M3.solid(p.display.camera_spacer.mm()),
            layout
                .display_bolts(p)
                .map(|c| on_display(upright(c, layout.cover_top)).lifted(80.0))
                .to_vec(),
        )
        .colored(BRASS),
        bought(
            "tube",
            format!(
                "silicone tube, {} x {} mm, {} mm long; shown are its two ends",
                p.tubes.inner_diameter.mm(),
                p.tubes.outer_diameter.mm(),
                p.tubes.length.mm()
            ),
            tube(
                p.tubes.inner_diameter.mm() / 2.0,
                p.tubes.outer_diameter.mm() / 2.0,
                TUBE_STUB_MM,
            ),
            tube_ends.chain(display_tubes).collect(),
        )
        .times(inlets.len() as u32)
        .colored([228, 222, 210])
        .opaque(0.7),
        bought(
            "needle",
            format!(
                "steel tube (blunt dispensing needle), {} mm outside, {} mm inside, cut to {} mm",
                p.tubes.needle_outer_diameter.mm(),
                p.tubes.needle_inner_diameter.mm(),
                p.tubes.needle_length.mm()
            ),
            tube(
                p.tubes.needle_inner_diameter.mm() / 2.0,
                p.tubes.needle_outer_diameter.mm() / 2.0,
                p.tubes.needle_length.mm(),
            ),
            inlets.iter().map(|&c| on_display(upright(c, needle_z)).lifted(78.0)).collect(),
        ),
        bought(
            "led-strip",
            format!(
                "self-adhesive LED strip, white, diffuse, {} x {} mm, with a resistor for 5 V",
                p.housing.led_strip_length.mm(),
                p.housing.led_strip_width.mm()
            ),
            led_strip(p),
            (0..4).map(|i| led_placement(layout, i)).collect(),
        )
        .colored([250, 240, 170]),
    ]
}

/// The two mold stacks: their lowest and highest face.
fn stacks(p: &SheetMold, layout: &Layout) -> [(AssemblyName, f64, f64); 2] {
    let floor = p.molds.floor.mm();
    [
        (CHANNEL_MOLD, layout.bond_z - floor, layout.touch_z),
        (MARKER_MOLD, layout.marker_end_z - floor, layout.bond_z),
    ]
}

/// A tube standing on z = 0.
fn tube(inner_mm: f64, outer_mm: f64, length_mm: f64) -> Solid {
    let bore = Solid::cylinder(inner_mm, length_mm + 2.0 * CUT_OVERLAP_MM);
    Solid::cylinder(outer_mm, length_mm).minus(bore.at(0.0, 0.0, -CUT_OVERLAP_MM))
}

/// A strip in its wall's frame, on the inside.
fn led_strip(p: &SheetMold) -> Solid {
    let (length, width, thickness) = (
        p.housing.led_strip_length.mm(),
        p.housing.led_strip_width.mm(),
        p.housing.led_strip_thickness.mm(),
    );
    Solid::cuboid(length, width, thickness).at(0.0, LED_HEIGHT_MM, -thickness)
}

fn led_placement(layout: &Layout, i: u32) -> Placement {
    let pose = sensor_from_wall(layout, i);
    SENSOR.at(pose).moved_apart(pose.vector(Vector3::new(0.0, 0.0, 18.0)))
}

/// Top of the LED strips above the box's floor, mm.
pub fn led_top_mm(p: &SheetMold) -> f64 {
    LED_HEIGHT_MM + p.housing.led_strip_width.mm() / 2.0
}

fn camera_specification(p: &SheetMold) -> String {
    format!(
        "{}, {} x {} px, {} lens, board {} x {} mm",
        p.camera.model,
        p.camera.width_px,
        p.camera.height_px,
        p.camera.field_of_view,
        p.camera.board_size.mm(),
        p.camera.board_size.mm()
    )
}

/// Board with four holes, lens holder, barrel, and the plug behind; its origin lies on the plate
/// that carries it, spacers away.
fn camera(p: &SheetMold) -> Solid {
    let (board, holder) = (p.camera.board_size.mm(), p.camera.holder_size.mm());
    let (bottom, top) = (p.camera.spacer.mm(), camera_board_top_mm(p));
    let plate = Solid::cuboid(board, board, p.camera.board_thickness.mm())
        .at(0.0, 0.0, bottom)
        .minus_all(camera_holes(p).map(|hole| {
            Screw::M2X12
                .clearance_tool(p.camera.board_thickness.mm(), gap_mm(Process::Pcb, Fit::Snug))
                .placed(upright(hole, top))
        }));
    let holder = Solid::cuboid(holder, holder, p.camera.holder_height.mm() + JOIN_MM)
        .at(0.0, 0.0, top - JOIN_MM)
        .named("lens holder");
    let barrel = Solid::cylinder(
        p.camera.barrel_diameter.mm() / 2.0,
        p.camera.lens_height.mm() - p.camera.holder_height.mm() + JOIN_MM,
    )
    .at(0.0, 0.0, top + p.camera.holder_height.mm() - JOIN_MM)
    .named("lens barrel");
    // The plug leaves a little air above the plate.
    let plug =
        Solid::cuboid(8.0, 5.0, bottom - 0.5 + JOIN_MM).at(board / 4.0, 0.0, 0.5).named("plug");
    Solid::union([plate, holder, barrel, plug])
}
