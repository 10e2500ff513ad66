//! Molds that cast the elastomers: negatives, silicone molds, runner, and slots for the markers.

use std::f64::consts::{PI, TAU};

use fabkit_geometry::{
    Body, CUT_OVERLAP_MM, InvalidPattern, Marker, MarkerCarrier, Path, Pattern, Point3, Pose,
    Process, Profile, Solid, ToolAccess,
};

use super::HalfEllipsoidLayout;
use super::parameters::*;
use crate::blocks::cup_and_bridge::bowl;
use crate::blocks::listed_markers::RoundPattern;
use crate::blocks::sprue::LuerSeat;
use crate::blocks::{TOOL_GREY, copies, hanging, landmarks_at, ring};
use crate::chain_builder::{AssemblyName, Name, flipped, shrinkage};
use crate::fits::Fit;
use crate::hardware::tools;
use crate::materials::Castable;

// ------ Tooling ------
//
// Printed negatives of the silicone molds, and features that negatives and molds share.
//
// Everything stands in the sensor frame. Molds close at z = 0, the plane of the elastomers' feet.

/// Height of the lip that centres the sleeve, and of the core negative's rim above the silicone, mm.
const LIP_MM: f64 = 2.0;

/// Length by which pins that leave vents stand out of the silicone, mm.
const PIN_SPARE_MM: f64 = 1.0;

/// Boundary surface that a silicone mold shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Outside of the inner elastomer.
    Inner,
    /// Outside of the outer elastomer.
    Outer,
    /// Outside of the black gel.
    Black,
}

impl Boundary {
    /// Returns the boundaries from the inside out. Without markers there is no outer elastomer.
    pub fn for_design(p: &HalfEllipsoid) -> Vec<Self> {
        if p.markers.is_plain() {
            vec![Self::Inner, Self::Black]
        } else {
            vec![Self::Inner, Self::Outer, Self::Black]
        }
    }

    /// Names of the layer, of its silicone mold, and of the mold's printed negative.
    fn bodies(self) -> [Name; 3] {
        match self {
            Self::Inner => [INNER, INNER_CUP, INNER_NEGATIVE],
            Self::Outer => [OUTER, OUTER_CUP, OUTER_NEGATIVE],
            Self::Black => [BLACK, BLACK_CUP, BLACK_NEGATIVE],
        }
    }

    /// Layer that the surface bounds.
    pub fn layer(self) -> Name {
        self.bodies()[0]
    }

    /// Silicone mold of the layer.
    pub fn cup(self) -> Name {
        self.bodies()[1]
    }

    /// Printed negative of the silicone mold.
    pub fn negative(self) -> Name {
        self.bodies()[2]
    }

    /// Assembly in which the silicone mold is cast.
    pub fn mold_casting_assembly(self) -> AssemblyName {
        match self {
            Self::Inner => CAST_INNER_CUP,
            Self::Outer => CAST_OUTER_CUP,
            Self::Black => CAST_BLACK_CUP,
        }
    }

    /// Assembly in which the layer is cast.
    pub fn casting_assembly(self) -> AssemblyName {
        match self {
            Self::Inner => INNER_MOLD,
            Self::Outer => OUTER_MOLD,
            Self::Black => BLACK_MOLD,
        }
    }
}

/// Returns cones on the core that fit the cups' sockets. They extend into the core's flange.
pub fn keys(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Solid> {
    let (radius, height) = (p.tooling.key_diameter.mm() / 2.0, p.tooling.key_height.mm());
    // A taper of 20 degrees lets a key find its socket and come out of it.
    let slope = 20f64.to_radians().tan();
    let key = Solid::revolution(Path::polygon(&[
        [0.0, -CUT_OVERLAP_MM],
        [radius + CUT_OVERLAP_MM * slope, -CUT_OVERLAP_MM],
        [radius - height * slope, height],
        [0.0, height],
    ]));
    let first = Pose::translation(key_circle_mm(layout), 0.0, 0.0);
    copies("key", &ring(p.tooling.keys, 0.0, first), &key)
}

/// Radius of the circle of the keys, mm: midway between the finished surface and the molds' side.
pub fn key_circle_mm(layout: &HalfEllipsoidLayout) -> f64 {
    (layout.foot_radius_mm(layout.black_offset_mm) + layout.silicone_radius_mm) / 2.0
}

/// Draft of a vent: decrease of its radius per mm on its way out. The vent's pin is thickest at its root, the core
/// slips off it, and cured elastomer comes out of the vent.
const VENT_DRAFT: f64 = 0.02;

/// Radius of the circle of vents, mm: below the middle of the inner elastomer's foot.
pub fn vent_circle_mm(layout: &HalfEllipsoidLayout) -> f64 {
    (layout.foot_radius_mm(layout.shell_offset_mm) + layout.foot_radius_mm(layout.inner_offset_mm))
        / 2.0
}

/// Poses at which the vents meet the foot, z axis up.
pub fn vent_poses(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Pose> {
    ring(p.tooling.vents, 0.0, Pose::translation(vent_circle_mm(layout), 0.0, 0.0))
}

/// Radius of a vent `depth_mm` below the foot, mm.
pub fn vent_radius_at(p: &HalfEllipsoid, depth_mm: f64) -> f64 {
    p.tooling.vent_diameter.mm() / 2.0 - VENT_DRAFT * depth_mm
}

/// Returns the vents through the core's flange, extended by `beyond_mm` beyond its far side.
fn vents(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout, beyond_mm: f64) -> Vec<Solid> {
    let depth = beyond_mm - layout.core_flange_z_mm;
    let [far, near] = [depth, -CUT_OVERLAP_MM].map(|depth| vent_radius_at(p, depth));
    let pin = Solid::cone(far, near, depth + CUT_OVERLAP_MM).at_z(-depth);
    copies("vent", &vent_poses(p, layout), &pin)
}

/// Returns vents, gates and sprue, which are cut from the core's flange and added to its negative. They extend
/// `beyond_mm` beyond the far side.
pub fn flange_openings(
    p: &HalfEllipsoid,
    layout: &HalfEllipsoidLayout,
    beyond_mm: f64,
) -> Vec<Solid> {
    [vents(p, layout, beyond_mm), runner_tools(p, layout, beyond_mm)].concat()
}

/// Returns the vent at the tip of the mold for the outer elastomer, from within the cavity to above the silicone.
pub fn tip_vent(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Solid {
    let bottom = layout.ellipsoid.polar + layout.inner_offset_mm;
    let top = layout.silicone_top_z_mm + PIN_SPARE_MM;
    Solid::rod(p.tooling.tip_vent_diameter.mm() / 2.0, [bottom, top]).named("tip vent")
}

/// Returns all negatives and the sleeve.
pub fn mold_parts(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Body> {
    let mut parts: Vec<Body> = Boundary::for_design(p)
        .iter()
        .map(|&boundary| negative_of_cup(p, layout, boundary))
        .collect();
    parts.extend([negative_of_core(p, layout), sleeve(p, layout)]);
    parts
}

fn tool(p: &HalfEllipsoid, name: Name, solid: Solid) -> Body {
    name.made(Process::Sla, solid)
        .with_material(&p.tooling.resin)
        .colored(TOOL_GREY)
        .sealed("varnish")
        .note(
            "0.025 mm layers; wash twice, cure fully and bake at 60 C overnight: uncured resin \
             keeps the silicone from curing",
        )
        .note("a coat of clear acrylic varnish, then release agent")
}

/// Combined linear shrinkage of silicone mold and elastomer, for a negative whose silicone casts `layer`.
fn double_shrinkage(p: &HalfEllipsoid, layer: &Castable) -> f64 {
    1.0 - (1.0 - shrinkage(&p.tooling.silicone_material)) * (1.0 - shrinkage(layer))
}

/// Returns the dome on a plate around which a silicone cup is cast.
fn negative_of_cup(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout, boundary: Boundary) -> Body {
    let (radius, wall) = (layout.silicone_radius_mm, p.tooling.wall.mm());
    let lip = radius + wall + p.making.gap_mm(boundary.negative(), Process::Sla, Fit::Slide);
    let plate = bowl([lip, lip + wall], LIP_MM, [0.0, -wall]);
    let on_plate = |solid: Solid| solid.minus(Solid::below(-CUT_OVERLAP_MM));
    let (dome, material) = match boundary {
        Boundary::Inner => (on_plate(slotted_solid(p, layout)), &p.inner_elastomer.material),
        Boundary::Outer => {
            (layout.ellipsoid.dome_tool(layout.outer_offset_mm), &p.outer_elastomer.material)
        }
        Boundary::Black => {
            (layout.ellipsoid.dome_tool(layout.black_offset_mm), &p.black_gel.material)
        }
    };
    let pin = (boundary == Boundary::Outer).then(|| tip_vent(p, layout));
    let pieces = [plate, dome.named("dome")].into_iter().chain(keys(p, layout)).chain(pin);
    let landmarks = match boundary {
        Boundary::Inner => landmarks_at("marker", &marker_poses(p, layout)),
        _ => Vec::new(),
    };
    tool(p, boundary.negative(), Solid::union(pieces))
        .placed([boundary.mold_casting_assembly().in_place()])
        .with_landmarks(landmarks)
        .for_shrinkage(double_shrinkage(p, material))
}

/// Returns the vessel in which the silicone core is cast.
fn negative_of_core(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Body {
    let (radius, wall) = (layout.silicone_radius_mm, p.tooling.wall.mm());
    let mouth = layout.core_flange_z_mm - LIP_MM;
    let top = layout.ellipsoid.polar + layout.shell_offset_mm + wall;
    let vessel = Solid::rod(radius + wall, [mouth, top]);
    let recess = Solid::cylinder(radius, CUT_OVERLAP_MM - mouth)
        .at_z(mouth - CUT_OVERLAP_MM)
        .named("flange");
    let body = vessel
        .minus(recess)
        .minus(layout.ellipsoid.dome_tool(layout.shell_offset_mm).named("core"))
        .minus_all(keys(p, layout));
    tool(
        p,
        CORE_NEGATIVE,
        Solid::union(std::iter::once(body).chain(flange_openings(p, layout, PIN_SPARE_MM))),
    )
    .placed([CAST_CORE.in_place().lifted(45.0)])
    .with_bed_orientation(flipped())
    .for_shrinkage(double_shrinkage(p, &p.inner_elastomer.material))
}

/// Returns the wall around the negatives of the cups.
fn sleeve(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Body {
    let inner = layout.silicone_radius_mm;
    let outer = inner + p.tooling.wall.mm();
    let top = layout.silicone_top_z_mm;
    let outline = [[inner, 0.0], [outer, 0.0], [outer, top], [inner, top]];
    tool(p, SLEEVE, Solid::revolution(Path::polygon(&outline)))
        .placed(
            Boundary::for_design(p)
                .into_iter()
                .map(|boundary| boundary.mold_casting_assembly().in_place().lifted(110.0)),
        )
        .with_handles(1)
        .note("push the cured silicone out with two thumbs")
}

// ------ Runner ------
//
// Channels through which the thin layers' mixture reaches their feet, and surplus leaves them: gates under the feet,
// a ring that joins the gates, and a seat for a syringe.
//
// All lie in the face of the core's flange that the cups close. So each gate opens over the whole width of a foot,
// however thin the layer is, and the cured runner is lifted out once the cup is off.

/// Width of a gate, mm. In the negative it is a ridge twice as wide as high.
const GATE_MM: f64 = 2.4;

/// Depth of gates and ring, mm.
const RUNNER_DEPTH_MM: f64 = 1.2;

/// Width of the land between the outermost layer's foot and the ring, mm, which the cup closes.
const LAND_MM: f64 = 0.6;

/// Width of the ring channel, mm.
const RING_MM: f64 = 1.0;

/// Distance from the outermost layer's foot to the outside of the ring channel, mm.
pub const RUNNER_REACH_MM: f64 = LAND_MM + RING_MM;

/// Minimum silicone between a vent, a gate, a key or the seat and its neighbour, mm.
pub const SILICONE_WALL_MM: f64 = 0.5;

/// Seat for the syringe in the core's flange.
pub fn syringe_seat(p: &HalfEllipsoid) -> LuerSeat {
    LuerSeat { wall_mm: p.tooling.core_flange.mm() }
}

/// Angle of the seat around the axis, rad. It lies between two keys.
fn seat_angle_rad(p: &HalfEllipsoid) -> f64 {
    PI / f64::from(p.tooling.keys)
}

/// Half the angle, rad, that a gate covers at the inner radius of the thin layers' feet.
pub fn half_gate_rad(layout: &HalfEllipsoidLayout) -> f64 {
    (GATE_MM / 2.0 / layout.foot_radius_mm(layout.inner_offset_mm)).min(1.0).asin()
}

/// Angles of the gates' middles, rad: half a step off the vents of the inner elastomer.
pub fn gate_angles_rad(p: &HalfEllipsoid) -> impl Iterator<Item = f64> {
    let count = p.tooling.vents;
    (0..count).map(move |i| TAU * (f64::from(i) + 0.5) / f64::from(count))
}

fn polar(radius: f64, rad: f64) -> [f64; 2] {
    [radius * rad.cos(), radius * rad.sin()]
}

/// Returns gates, ring, and the channel from the ring to the seat, from above the flange's face down to their floor.
fn runner_solid(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Solid {
    let gate = layout.foot_radius_mm(layout.inner_offset_mm);
    let inner = layout.foot_radius_mm(layout.black_offset_mm) + LAND_MM;
    let (outer, half) = (inner + RING_MM, half_gate_rad(layout));
    let mut teeth = Path::from(polar(gate, -half + first_gate_rad(p)));
    for middle in gate_angles_rad(p) {
        let next = middle + TAU / f64::from(p.tooling.vents) - half;
        teeth = teeth
            .arc(polar(gate, middle + half), [0.0; 2], true)
            .line(polar(inner, middle + half))
            .arc(polar(inner, next), [0.0; 2], true)
            .line(polar(gate, next));
    }
    let (to, end) = (seat_angle_rad(p), key_circle_mm(layout));
    let side = (GATE_MM / 2.0 / outer).min(1.0).asin();
    let outline = Path::from(polar(outer, to + side))
        .arc(polar(outer, to + PI), [0.0; 2], true)
        .arc(polar(outer, to - side), [0.0; 2], true)
        .line(polar(end, to - side))
        .arc(polar(end, to + side), [0.0; 2], true)
        .close();
    Solid::prism(Profile::new(outline).with_hole(teeth.close()), [-RUNNER_DEPTH_MM, CUT_OVERLAP_MM])
        .named("runner")
}

fn first_gate_rad(p: &HalfEllipsoid) -> f64 {
    PI / f64::from(p.tooling.vents)
}

/// Returns the runner and the seat, which are cut from the core's flange and added to its negative. The seat extends
/// `beyond_mm` beyond the far side.
pub fn runner_tools(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout, beyond_mm: f64) -> Vec<Solid> {
    let [x, y] = polar(key_circle_mm(layout), seat_angle_rad(p));
    let mouth = Pose::translation(x, y, layout.core_flange_z_mm);
    vec![runner_solid(p, layout), syringe_seat(p).tool(&mouth, beyond_mm)]
}

/// Returns the space that the syringe takes in its seat, in the core's frame.
pub fn syringe(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> ToolAccess {
    let at = polar(key_circle_mm(layout), seat_angle_rad(p));
    tools::syringe(hanging(at, layout.core_flange_z_mm), syringe_seat(p).stands_out_mm())
}

/// Centre and radius, mm, of a disc that contains the opening of one gate in a foot between two radii.
pub fn gate_opening_disc(
    rad: f64,
    layout: &HalfEllipsoidLayout,
    [inner, outer]: [f64; 2],
) -> (Point3<f64>, f64) {
    let middle = (inner + outer) / 2.0;
    let [x, y] = polar(middle, rad);
    let half = half_gate_rad(layout);
    let corner = polar(outer, half);
    let radius = (corner[0] - middle).abs().max((outer - inner) / 2.0).hypot(corner[1]);
    (Point3::new(x, y, 0.0), radius + CUT_OVERLAP_MM)
}

// ------ Markers ------
//
// Markers: their places, and the slot that each one fills.

/// Distribution of the markers over rings around the tip.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerSpread {
    /// Distance from ring to ring along the surface, mm.
    pub spacing: f64,
    /// Places of the markers on the inner elastomer's outside.
    pub pattern: Pattern,
}

impl MarkerSpread {
    /// Numbers of markers on the rings, as text for users.
    pub fn counts(&self) -> String {
        match &self.pattern {
            Pattern::SurfaceRings { counts, .. } => {
                counts.iter().map(u32::to_string).collect::<Vec<_>>().join(", ")
            }
            _ => String::new(),
        }
    }
}

/// Distributes `count` markers: one at the tip, the others on rings of latitude at equal distances along the surface.
/// The last ring stays half a step above the base circle, so that the rim cuts no marker.
///
/// Each ring gets a share in proportion to its circumference (largest remainders first). The number of rings is
/// chosen so that the spacing along a ring is most similar to the spacing between rings. So any count is possible,
/// and all markers stand for about the same area.
///
/// # Errors
/// Fails for a surface without meridian, or without any markers.
pub fn marker_spread(
    layout: &HalfEllipsoidLayout,
    count: u32,
) -> Result<MarkerSpread, InvalidPattern> {
    let surface = layout.ellipsoid.parallel(layout.inner_offset_mm);
    let length = layout.ellipsoid.meridian_length(layout.inner_offset_mm);
    let others = count.checked_sub(1).ok_or(InvalidPattern::Empty)?;
    let mut best: Option<(f64, MarkerSpread)> = None;
    // If each marker stands for the same square, rings are as far apart as a square is wide. The best number of rings
    // is close to that.
    let square = layout.ellipsoid.area_estimate(layout.inner_offset_mm) / f64::from(count);
    let about = (length / square.sqrt()) as u32;
    for rings in about.saturating_sub(2).max(1)..=about + 2 {
        let spacing = length / (f64::from(rings) + 0.5);
        let one_each = Pattern::SurfaceRings {
            surface: surface.clone(),
            spacing_mm: spacing,
            counts: vec![1; rings as usize + 1],
        };
        let circles: Vec<f64> = one_each.poses()?[1..]
            .iter()
            .map(|pose| TAU * pose.translation_mm().xy().norm())
            .collect();
        let along = circles.iter().sum::<f64>() / f64::from(others.max(1));
        // Deviation as a ratio, so that too wide and too narrow count alike.
        let uneven = (along / spacing).ln().abs();
        if best.as_ref().is_none_or(|(least, _)| uneven < *least) {
            let mut counts = vec![1];
            counts.extend(apportion(&circles, others));
            let pattern =
                Pattern::SurfaceRings { surface: surface.clone(), spacing_mm: spacing, counts };
            best = Some((uneven, MarkerSpread { spacing, pattern }));
        }
    }
    best.map(|(_, spread)| spread).ok_or(InvalidPattern::Empty)
}

/// Splits `total` into integers in proportion to `weights` (largest remainders first).
fn apportion(weights: &[f64], total: u32) -> Vec<u32> {
    let sum: f64 = weights.iter().sum();
    let exact: Vec<f64> = weights.iter().map(|w| w / sum * f64::from(total)).collect();
    let mut counts: Vec<u32> = exact.iter().map(|e| e.floor() as u32).collect();
    let mut order: Vec<usize> = (0..weights.len()).collect();
    order.sort_by(|&i, &j| (exact[j].fract()).total_cmp(&exact[i].fract()));
    let missing = total - counts.iter().sum::<u32>();
    for &i in order.iter().take(missing as usize) {
        counts[i] += 1;
    }
    counts
}

/// Poses of the markers on the inner elastomer's outside, z axis outwards along the normal. Empty without markers, or
/// for a surface that `check` refuses.
pub fn marker_poses(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Pose> {
    if p.markers.pattern == RoundPattern::List {
        return p.markers.listed().poses(&layout.ellipsoid.parallel(layout.inner_offset_mm));
    }
    marker_spread(layout, p.markers.count).and_then(|s| s.pattern.poses()).unwrap_or_default()
}

/// Depth of a slot including its round end, mm.
pub fn marker_depth(markers: &Markers) -> f64 {
    markers.straight_depth.mm() + markers.radius.mm()
}

/// Centre of each slot's round end, mm.
pub fn marker_end_centres(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Point3<f64>> {
    let end = Point3::new(0.0, 0.0, -p.markers.straight_depth.mm());
    marker_poses(p, layout).iter().map(|pose| pose.point(end)).collect()
}

/// Markers that the camera tracks: the ends of the slots.
pub fn tracked_markers(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Marker> {
    let slots = &p.markers;
    Marker::place_below_poses(
        "marker",
        &marker_poses(p, layout),
        marker_depth(slots),
        slots.radius.mm(),
        |_| MarkerCarrier::Gel,
    )
}

/// Returns the solid within the inner elastomer's outside without the slots. The inner elastomer and its negative are
/// cut from it; it is cut from the outer elastomer and the silicone mold.
pub fn slotted_solid(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Solid {
    let (radius, straight) = (p.markers.radius.mm(), p.markers.straight_depth.mm());
    // The surface curves away from the slot's mouth, so the overlap lies outside.
    let slot = Solid::revolution(
        Path::from([0.0, -straight - radius])
            .arc([radius, -straight], [0.0, -straight], true)
            .line([radius, CUT_OVERLAP_MM])
            .line([0.0, CUT_OVERLAP_MM])
            .close(),
    );
    let slots = copies("marker", &marker_poses(p, layout), &slot);
    layout.ellipsoid.whole(layout.inner_offset_mm).minus_all(slots)
}
