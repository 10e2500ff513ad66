//! What is bought: glass, camera, LEDs, screws, nuts, dowels, O-ring.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Order, Path, Placement, Pose, Process, Solid};

use super::bodies::*;
use super::cavities;
use super::housing::{led_poses, relief_edges_mm};
use super::joints::Joints;
use super::layout::Layout;
use super::parameters::{CoatMethod, Dome, MoldRoute};
use super::surface::dome_shell;
use super::tooling::{form, o_ring_seat};
use super::wiring;
use crate::assembling::{AssemblyName, SENSOR, in_sensor};
use crate::blocks::cup_and_bridge::CupAndBridge;
use crate::blocks::mold::{lid_dowel_poses, side_dowel_poses};
use crate::blocks::{DOWEL, GLASS, INTO_MM, RUBBER, led_ring, merged};
use crate::fits::{Fit, gap_mm};
use crate::hardware::Dowel;

/// Everything bought.
pub fn components(p: &Dome, layout: &Layout) -> Vec<Body> {
    let each = |assembly: AssemblyName, poses: &[Pose], lift_mm: f64| -> Vec<Placement> {
        poses.iter().map(|&pose| assembly.at(pose).lifted(lift_mm)).collect()
    };
    // Fasteners leave along their own axis.
    let drawn_out = |out_mm: f64, lift_mm: f64| {
        move |pose: &Pose| SENSOR.drawn_out(pose, out_mm).lifted(lift_mm)
    };
    let here = [Pose::identity()];

    let side = side_dowel_poses(&p.mold);
    let lid = lid_dowel_poses(&p.mold);
    let dowels = [TRANSPARENT_MOLD, TRANSLUCENT_MOLD, JOINING]
        .into_iter()
        .flat_map(|mold| [each(mold, &side, 0.0), each(mold, &lid, -12.0)].concat());
    let (seat, dowel) = (o_ring_seat(p, layout), dowel(p));
    let joints = Joints::new(p, layout);

    let is_silicone = p.molds.route == MoldRoute::Silicone;
    let is_dipped = p.coat.method == CoatMethod::Dip;
    let in_form = |form: AssemblyName| move |pose: &Pose| form.at(*pose).lifted(-45.0);
    // The same screws serve both forms, one after the other.
    let form_screws = match is_silicone {
        true => [INNER_FORM, OUTER_FORM]
            .map(|form| joints.form.bought(in_form(form), in_form(form)))
            .concat(),
        false => Vec::new(),
    };
    let sensor = vec![
        TUBE.bought(
            format!(
                "glass test tube, {} mm outside, {} mm wall, cut {} mm from its tip",
                p.tube.outer_diameter.mm(),
                p.tube.wall.mm(),
                layout.wall_height_mm + layout.tube_radius_mm
            ),
            dome_shell(layout.tube_bore_radius_mm, layout.tube_radius_mm, layout.wall_height_mm),
            vec![],
        )
        .placed([
            in_sensor().lifted(56.0),
            TRANSPARENT_MOLD.in_place(),
            TRANSLUCENT_MOLD.in_place(),
            JOINING.in_place(),
            CUTTING.in_place(),
        ])
        .placed(is_dipped.then(|| COATING.in_place()))
        .times(1)
        .ordered(Order::of(
            "glass test tube",
            format!("{} mm outside, {} mm wall", p.tube.outer_diameter.mm(), p.tube.wall.mm()),
        ))
        .colored(GLASS)
        .opaque(0.3),
        camera(p, layout).placed([in_sensor().lifted(-46.0)]),
        led_ring!(p.leds).body(each(SENSOR, &led_poses(p, layout), -20.0)),
    ];
    let screws = [
        joints.camera.bought(drawn_out(0.0, -36.0), drawn_out(0.0, 0.0)),
        joints.shell_base.bought(drawn_out(12.0, 0.0), drawn_out(6.0, -66.0)),
        form_screws,
        joints.mounting.bought_nuts(drawn_out(6.0, -66.0)).into_iter().collect(),
    ];
    let screws = merged(screws.into_iter().flatten());
    let dowels = (!is_silicone).then(|| {
        DOWEL
            .bought(dowel.specification(), dowel.solid(), dowels)
            .times(2 * (side.len() + lid.len()) as u32)
            .ordered(dowel.order())
            .reached(dowel.press())
            .fastening()
    });
    let gripped =
        [TRANSPARENT_MOLD, TRANSLUCENT_MOLD].into_iter().chain(is_dipped.then_some(COATING));
    let ring = O_RING
        .bought(
            seat.ordered(),
            seat.ring()
                .between_cylinders([seat.radius_mm, layout.tube_bore_radius_mm])
                .at_z(p.connector.plug_length.mm() / 2.0),
            gripped.flat_map(|tool| each(tool, &here, -42.0)),
        )
        .times(1)
        .ordered(seat.ring().order())
        .colored(RUBBER)
        .giving(seat.ring().gives_mm());
    let forms = cavities(p, layout).map(|cavity| {
        let form = form(p, layout, &cavity);
        cavity
            .form
            .tube
            .bought(
                format!(
                    "glass test tube with rim, {} mm outside, {} mm long",
                    2.0 * cavity.radius,
                    p.form.tube_length.mm()
                ),
                form_tube(p, layout, &form, cavity.radius),
                each(cavity.form.assembly, &here, -60.0),
            )
            .ordered(Order::of(
                "glass test tube with rim",
                format!("{} mm outside, {} mm long", 2.0 * cavity.radius, p.form.tube_length.mm()),
            ))
            .colored(GLASS)
            .opaque(0.35)
    });
    let forms = is_silicone.then_some(forms).into_iter().flatten();
    let tools = dowels.into_iter().chain([ring]).chain(forms);
    sensor.into_iter().chain(wiring::bodies(p, layout)).chain(screws).chain(tools).collect()
}

/// Board with four holes, lens holder and barrel, connector behind.
fn camera(p: &Dome, layout: &Layout) -> Body {
    let thickness = p.camera.board.board_thickness.mm();
    let holes = Joints::new(p, layout).camera.passed(thickness, gap_mm(Process::Pcb, Fit::Snug));
    let edges = relief_edges_mm(p).map(|edge| edge - 2.0);
    let connector =
        Solid::cuboid(edges[0], edges[1] / 2.0, p.camera.back_clearance.mm() - 0.5 + INTO_MM)
            .at_z(layout.relief_z_mm + 0.5)
            .named("connector");
    let heights = [layout.camera_board_bottom_z_mm, layout.camera_board_top_z_mm];
    let c = &p.camera;
    c.board.bought((&c.module, &c.pictures, &c.view), heights, holes.tools, connector)
}

fn dowel(p: &Dome) -> Dowel {
    Dowel { diameter_mm: p.mold.dowel_diameter.mm(), length_mm: p.mold.dowel_length.mm() }
}

/// The glass tube whose outside shapes the silicone mold; its rim rests on the bridge's sleeve.
fn form_tube(p: &Dome, layout: &Layout, form: &CupAndBridge<'_>, outer: f64) -> Solid {
    let wall = layout.wall_height_mm;
    let inner = outer - p.tube.wall.mm();
    let centre = [0.0, wall];
    let outside = Path::from([0.0, form.rim_z])
        .line([outer + p.form.tube_rim.mm(), form.rim_z])
        .line([outer + p.form.tube_rim.mm(), form.sleeve_z])
        .line([outer, form.sleeve_z])
        .line([outer, wall])
        .arc([0.0, wall + outer], centre, true)
        .close();
    let below = form.rim_z - CUT_OVERLAP_MM;
    let inside = Path::from([0.0, below])
        .line([inner, below])
        .line([inner, wall])
        .arc([0.0, wall + inner], centre, true)
        .close();
    Solid::revolution(outside).minus(Solid::revolution(inside))
}
