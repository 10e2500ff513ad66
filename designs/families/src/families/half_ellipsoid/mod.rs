//! Half-ellipsoid sensors: elastomers on a machined shell, LEDs and a camera below it (UVDtact).
//!
//! This file holds the layout, the screw joints and the ellipsoid, on which all other files of the family build.

mod chain;
mod constraints;
mod electronics;
mod housing;
mod molds;
mod parameters;

use std::f64::consts::{FRAC_PI_2, PI};

use fabkit_geometry::{
    CUT_OVERLAP_MM, DomeSurface, EllipsoidOffset, FixtureGrip, Lighting, Path, Point3, Pose,
    Process, Rgb, Sensor, Solid, Vector3, VisibleEffect,
};

use crate::blocks::adapter::MountFace;
use crate::blocks::listed_markers::{RoundPattern, nearest_mm};
use crate::blocks::mounting::{MountHold, MountRing, Mounting};
use crate::blocks::{self, Rect, ScrewJoint, mm, ring};
use crate::chain_builder::visible_layers;
use crate::fits::Fit;
use crate::hardware::Screw;
use crate::parameters::RuleReport;
use crate::{Family, FamilyOutput, Header, layout};
use parameters::{BASE, HOLDER, HalfEllipsoid, MeasuredTo, POST};

/// Half-ellipsoid family, whose built-in example is UVDtact.
pub(crate) struct HalfEllipsoidFamily;

impl Family for HalfEllipsoidFamily {
    type Parameters = HalfEllipsoid;
    const NAME: &'static str = "half-ellipsoid";
    const SUMMARY: &'static str = "half ellipsoids of elastomer on a machined shell, UV markers";
    const EXAMPLE: &'static str = "uvdtact";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("half-ellipsoid.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &HalfEllipsoid, report: &mut RuleReport) {
        constraints::check(parameters, report);
    }

    fn build(
        parameters: &HalfEllipsoid,
        header: &Header,
        _report: &mut RuleReport,
    ) -> Option<FamilyOutput> {
        let layout = HalfEllipsoidLayout::new(parameters);
        let face = MountFace {
            holder: parameters::BASE,
            mounting: Joints::new(parameters, &layout).mounting,
            replaced_screw_mm: None,
            bottom_z_mm: layout.bottom_z_mm,
            outline: Rect::round(layout.holder_radius_mm),
            exits: housing::cable_exits(parameters, &layout),
            heads: Vec::new(),
        };
        let sensor = build_sensor(parameters, header);
        Some(FamilyOutput { sensor, derived: derived_dimensions(parameters), face: Some(face) })
    }
}

/// Builds the sensor: all bodies, the circuit, press fits, casting steps, light sources and the camera.
fn build_sensor(p: &HalfEllipsoid, header: &Header) -> Sensor {
    let layout = HalfEllipsoidLayout::new(p);
    let mut parts = housing::housing_parts(p, &layout);
    parts.extend(molds::mold_parts(p, &layout));
    let pupil_z = layout.camera_front_z_mm - p.camera.pupil_behind_front.mm();
    let bodies = parts
        .into_iter()
        .chain(housing::layers(p, &layout))
        .chain(electronics::components(p, &layout));
    Sensor {
        chain: chain::chain(p, &layout),
        circuits: vec![electronics::circuit(p, &layout)],
        press_fits: Joints::new(p, &layout)
            .holder
            .press_fit(parameters::BASE)
            .into_iter()
            .collect(),
        touch: Some(touch_surface(p, &layout).into()),
        marks: molds::tracked_markers(p, &layout),
        lightings: sensor_lightings(p),
        visible_bodies: visible_layers(
            &housing::elastomer_names(p)
                .into_iter()
                .map(|name| match name {
                    parameters::OUTER => (name, &p.outer_elastomer.material),
                    _ => (name, &p.inner_elastomer.material),
                })
                .collect::<Vec<_>>(),
            parameters::BLACK,
        ),
        ..blocks::sensor(
            header,
            p.camera.optics.camera_at(
                pupil_z,
                p.camera.images.size_px(),
                (p.camera.field_of_view, p.camera.projection),
            ),
            bodies,
        )
    }
}

/// Returns the touched surface, and the part that fixtures grip: holder and base, which are equally wide.
fn touch_surface(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> DomeSurface {
    let gels = [&p.black_gel.thickness, &p.outer_elastomer.thickness, &p.inner_elastomer.thickness];
    DomeSurface {
        dome: EllipsoidOffset {
            equatorial_mm: layout.ellipsoid.equatorial,
            polar_mm: layout.ellipsoid.polar,
            offset_mm: layout.black_offset_mm,
        },
        centre_z_mm: 0.0,
        foot_z_mm: 0.0,
        max_indentation_mm: gels.iter().map(|thickness| thickness.mm()).sum(),
        grip: FixtureGrip {
            outline: Path::circle([0.0, 0.0], layout.holder_radius_mm),
            top_z_mm: 0.0,
            bottom_z_mm: layout.bottom_z_mm,
            clear_radius_mm: p.base.mount_radius.mm(),
            key: None,
            threads: Joints::new(p, layout).mounting.thread_cut().landmarks,
        },
    }
}

/// Lists the derived dimensions that `fabkit show` prints.
fn derived_dimensions(p: &HalfEllipsoid) -> Vec<(String, String)> {
    let layout = HalfEllipsoidLayout::new(p);
    let mill = p.shell.ball_mill_diameter.mm() / 2.0;
    let outside = layout.ellipsoid.polar + layout.shell_offset_mm;
    let mut figures = vec![
        mm("outer diameter", 2.0 * layout.foot_radius_mm(layout.black_offset_mm)),
        mm("tip above the base circle", layout.ellipsoid.polar + layout.black_offset_mm),
        mm("total height", layout.ellipsoid.polar + layout.black_offset_mm - layout.bottom_z_mm),
        mm("tip's radius of curvature", layout.ellipsoid.tip_curvature_radius()),
        mm("shell bore radius", layout.bore_radius()),
        mm(
            "shell thickness at the tip",
            outside - layout.ellipsoid.cavity_tip_z(layout.cavity_depth_mm, mill),
        ),
        mm("slot depth", molds::marker_depth(&p.markers)),
        mm("LED board radius", layout.board_radius_mm),
        mm("LED board top below the base circle", -layout.board_top_z_mm),
    ];
    if p.markers.pattern == RoundPattern::List {
        let ends = molds::marker_end_centres(p, &layout);
        figures.push(("markers".into(), ends.len().to_string()));
        figures.extend(nearest_mm(&ends).map(|least| mm("nearest round ends", least)));
    } else if let Ok(spread) = molds::marker_spread(&layout, p.markers.count) {
        figures.push(mm("marker spacing along the meridian", spread.spacing));
        figures.push(("markers per ring, from the tip".into(), spread.counts()));
    }
    figures
}

/// Response of the camera's red, green and blue channels to the glow of each ink. Chosen values: fluorescent inks
/// glow in bands of 60 to 100 nm.
const INK_RESPONSES: [Rgb; 2] = [[1.0, 0.15, 0.05], [0.05, 0.25, 1.0]];

/// Returns two lightings: white light for shape, in which both inks scatter alike, and ultraviolet light for markers,
/// in which each ink glows in its own colour. The ultraviolet light passes through holes of the diffuser.
fn sensor_lightings(p: &HalfEllipsoid) -> Vec<Lighting> {
    let layers: Vec<String> = housing::elastomer_names(p).into_iter().map(String::from).collect();
    let glowing = layers.iter().cloned().zip(INK_RESPONSES).collect();
    vec![
        Lighting::from_body("white", parameters::WHITE_LED, VisibleEffect::Thickness { layers })
            .through(parameters::DIFFUSER),
        Lighting::from_body(
            "uv",
            parameters::UV_LED,
            VisibleEffect::Fluorescence { layers: glowing },
        ),
    ]
}

// ------ Layout ------
//
// Radii and heights that more than one part needs, each derived once.

/// Gap between the shell's foot and the step of its holder, mm. Glue runs into it.
const FOOT_SPARE_MM: f64 = 0.8;

/// Gap between the holder's step and the diffuser, mm. The holder rests on the base's flange, not here.
const STEP_GAP_MM: f64 = 0.1;

/// Wall between a bolt's hole and the pocket above it, and between a bolt's head and the skirt's end below it, mm.
const BOLT_WALL_MM: f64 = 0.6;

/// Bolts that join holder and base.
pub const BOLT: Screw = Screw::M1_2X3;

layout! {
    /// Radii and heights in the sensor frame, mm.
    ///
    /// Downwards from the base circle follow the holder's collar around the shell's foot, a step, and the skirt
    /// around diffuser, LEDs, board and base, which are stacked on each other.
    pub struct HalfEllipsoidLayout from p: &HalfEllipsoid {
        /// Ellipsoid from which all layers are offset.
        ellipsoid: Ellipsoid =
            Ellipsoid { equatorial: p.surface.diameter.mm() / 2.0, polar: p.surface.height.mm() };
        /// Offset of the black gel's outside, which is the finished surface.
        black_offset_mm = match p.surface.measured_to {
            MeasuredTo::BlackGel => 0.0,
            MeasuredTo::OuterElastomer => p.black_gel.thickness.mm(),
        };
        /// Offset of the outer elastomer's outside.
        outer_offset_mm = black_offset_mm - p.black_gel.thickness.mm();
        let without_outer = outer_offset_mm - p.outer_elastomer.thickness.mm();
        /// Offset of the inner elastomer's outside. Without markers, it is cast as thick as both elastomers together.
        inner_offset_mm = if p.markers.is_plain() { outer_offset_mm } else { without_outer };
        /// Offset of the shell's outside.
        shell_offset_mm = without_outer - p.inner_elastomer.thickness.mm();
        /// Depth of the shell's inside below the ellipsoid.
        cavity_depth_mm = p.shell.thickness.mm() - shell_offset_mm;

        /// Outer radius of the shell's foot.
        foot_radius_mm = ellipsoid.equatorial + shell_offset_mm - p.shell.shoulder.mm();
        /// Lower end of the foot.
        foot_z_mm = -p.shell.foot_height.mm();
        /// Outer radius of holder and flange.
        holder_radius_mm = p.holder.outer_diameter.mm() / 2.0;
        let snug = p.making.gap_mm(HOLDER, Process::Sla, Fit::Snug);
        /// Inner radius of the holder's collar.
        collar_radius_mm = foot_radius_mm + snug;
        /// Height of the step between collar and skirt.
        step_z_mm = foot_z_mm - FOOT_SPARE_MM;
        /// Inner radius of the skirt.
        skirt_radius_mm = holder_radius_mm - p.holder.skirt.mm();
        /// Outer radius of diffuser and board.
        board_radius_mm = skirt_radius_mm - p.making.gap_mm(HOLDER, Process::Sla, Fit::Free);
        /// Outer radius of the base's plug.
        base_radius_mm = skirt_radius_mm - p.making.gap_mm(HOLDER, Process::Sla, Fit::Slide);

        /// Top of the diffuser.
        diffuser_top_z_mm = step_z_mm - STEP_GAP_MM;
        /// Lower face of the diffuser's plate.
        diffuser_plate_z_mm = diffuser_top_z_mm - p.diffuser.thickness.mm();
        /// Inner radius of the diffuser's wall.
        diffuser_wall_radius_mm = board_radius_mm - p.diffuser.wall.mm();
        /// Top of the board, on which the LEDs stand.
        board_top_z_mm = diffuser_plate_z_mm - p.diffuser.gap.mm() - p.leds.height.mm();
        /// Top of the base, on which the board lies.
        base_top_z_mm = board_top_z_mm - p.led_board.thickness.mm();
        /// Floor of the pocket for the parts on the board's lower side.
        pocket_z_mm = base_top_z_mm - p.base.pocket_depth.mm();
        /// Height of the bolts' axes.
        bolt_z_mm = pocket_z_mm - BOLT_WALL_MM - BOLT.pilot_hole_mm() / 2.0;
        /// Lower end of the skirt, which is the top of the flange.
        flange_z_mm = bolt_z_mm - BOLT.sink_diameter_mm(snug) / 2.0 - BOLT_WALL_MM;
        /// Bottom of everything.
        bottom_z_mm = flange_z_mm - p.base.flange.mm();

        /// Inner radius of the post that carries the camera.
        post_bore_radius_mm = p.camera.diameter.mm() / 2.0
            + p.making.gap_mm(POST, Process::Sla, Fit::Snug);
        /// Outer radius of that post.
        post_radius_mm = post_bore_radius_mm + p.camera_holder.wall.mm();
        /// Front of camera and post.
        camera_front_z_mm = -p.camera.front_depth.mm();
        /// Lower end of the post, in its socket in the base.
        post_end_z_mm = base_top_z_mm - p.camera_holder.socket_depth.mm();
        // The cable passes through both parts, so the larger gap applies to both.
        let passed = [POST, BASE].map(|part| (part, Process::Sla));
        /// Radius of the passage for the camera's cable.
        cable_radius_mm =
            p.camera.cable_diameter.mm() / 2.0 + p.making.widest_gap_mm(passed, Fit::Free);

        /// Outer radius of the silicone molds.
        silicone_radius_mm = p.tooling.silicone_diameter.mm() / 2.0;
        /// Top of the silicone molds, beyond the tip.
        silicone_top_z_mm = ellipsoid.polar + black_offset_mm + p.tooling.silicone_floor.mm();
        /// Lower face of the core's flange.
        core_flange_z_mm = -p.tooling.core_flange.mm();
    }
}

impl HalfEllipsoidLayout {
    /// Radius of the base circle of the surface at `offset`, mm.
    pub fn foot_radius_mm(&self, offset: f64) -> f64 {
        self.ellipsoid.equatorial + offset
    }

    /// Inner radius of the shell's foot, mm.
    pub fn bore_radius(&self) -> f64 {
        self.ellipsoid.equatorial - self.cavity_depth_mm
    }
}

// ------ Joints ------
//
// Screws of the sensor. Each joint is defined here and nowhere else.

/// Depth of a bolt's hole beyond its tip, mm.
const BOLT_SPARE_MM: f64 = 0.4;

/// Depth of the mounting holes, mm.
const MOUNT_DEPTH_MM: f64 = 3.0;

/// All joints, in the sensor frame.
pub struct Joints {
    /// Bolts through the shell holder's skirt into the base, pointing at the axis.
    pub holder: ScrewJoint,
    /// Holes in the base's bottom for mounting the sensor. The user provides the screws.
    pub mounting: ScrewJoint,
}

impl Joints {
    /// Places the joints. The result is meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Self {
        // A flat head is flush with a round wall where its rim, not its centre, meets the wall.
        let head = BOLT.head_diameter_mm() / 2.0;
        let radius = (layout.holder_radius_mm.powi(2) - head.powi(2)).sqrt();
        let bolt = Pose::z_to(Vector3::x(), Point3::new(radius, 0.0, layout.bolt_z_mm));
        let bolts = ring(p.base.bolts, 0.0, bolt);
        let depth = BOLT.length_mm + BOLT_SPARE_MM;
        Self {
            holder: ScrewJoint::self_tapping("bolt", BOLT, bolts, depth).named_bolts(),
            mounting: mounting(p).joint(layout.bottom_z_mm),
        }
    }
}

/// Defines the holes that the sensor is mounted by.
pub(super) fn mounting(p: &HalfEllipsoid) -> Mounting<'_> {
    Mounting {
        mount: &p.mount,
        // Offset by half a step from the bolts.
        ring: MountRing::Circle(p.base.mount_holes, p.base.mount_radius, 0.5),
        depth_mm: MOUNT_DEPTH_MM,
        is_through: false,
        holds: (
            &[MountHold::Tapped],
            "the base is of resin, which does not melt around an insert, and everything in it is glued \
             in above the holes",
        ),
    }
}

// ------ Surface ------
//
// The half ellipsoid, its parallel surfaces, and the inside of the shell.
//
// An ellipse with half axes a (across) and c (along z) has, at the eccentric angle t from its tip, the point (a sin
// t, c cos t) and an outward normal along (sin t / a, cos t / c).

/// Number of biarcs along the shell's inside. With these, its distance from the parallel surface stays below 0.1 um
/// for every ellipsoid up to 1 : 4.
const BIARC_COUNT: u32 = 32;

/// Ellipsoid of revolution from which all layers are offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Half axis across, mm.
    pub equatorial: f64,
    /// Half axis along z, mm. It is the longer one.
    pub polar: f64,
}

impl Ellipsoid {
    /// Smallest radius of curvature, which is that at the tip, mm. Parallel surfaces deeper than this are not smooth.
    pub fn tip_curvature_radius(&self) -> f64 {
        self.equatorial.powi(2) / self.polar
    }

    /// Parallel surface `offset` mm outside the ellipsoid.
    pub fn parallel(&self, offset: f64) -> EllipsoidOffset {
        EllipsoidOffset { equatorial_mm: self.equatorial, polar_mm: self.polar, offset_mm: offset }
    }

    /// Solid within that surface, including the half below the base circle.
    pub fn whole(&self, offset: f64) -> Solid {
        Solid::EllipsoidOffset(self.parallel(offset))
    }

    /// Solid within that surface that ends below the base circle, by the overlap of cuts.
    pub fn dome_tool(&self, offset: f64) -> Solid {
        self.whole(offset).minus(Solid::below(-CUT_OVERLAP_MM))
    }

    /// Point and unit normal of the meridian at an eccentric angle, as (radius, z).
    fn meridian(&self, eccentric: f64) -> ([f64; 2], [f64; 2]) {
        let (s, c) = eccentric.sin_cos();
        let normal = [s / self.equatorial, c / self.polar];
        let length = normal[0].hypot(normal[1]);
        ([self.equatorial * s, self.polar * c], normal.map(|v| v / length))
    }

    /// Eccentric angle at which the normal reaches the axis after `depth` mm, so that the parallel surface meets
    /// itself there; 0 if that surface is smooth at its tip.
    ///
    /// The normal from angle t meets the axis after a^2 |(sin t / a, cos t / c)|.
    fn fold(&self, depth: f64) -> f64 {
        let (a, c) = (self.equatorial, self.polar);
        let square = ((depth / a.powi(2)).powi(2) - c.powi(-2)) / (a.powi(-2) - c.powi(-2));
        square.clamp(0.0, 1.0).sqrt().asin()
    }

    /// Height of the tip of a cavity that lies `depth` mm inside and whose tip is no sharper than `tip_radius`, mm.
    pub fn cavity_tip_z(&self, depth: f64, tip_radius: f64) -> f64 {
        let fold = self.fold(depth + tip_radius);
        if fold == 0.0 {
            return self.polar - depth;
        }
        self.ball_centre_z(depth + tip_radius) + tip_radius
    }

    /// Height of the centre of the highest ball of `radius` mm that touches the ellipsoid from inside, for radii
    /// beyond the tip's radius of curvature.
    fn ball_centre_z(&self, radius: f64) -> f64 {
        self.fold(radius).cos() * (self.polar - self.tip_curvature_radius())
    }

    /// Returns the cavity that a ball mill of `tip_radius` mm leaves if it stays `depth` mm away from the ellipsoid,
    /// with a bore down to `bottom_z`. It is the parallel surface, rounded at the tip: deeper than the tip's radius
    /// of curvature, the parallel surface would fold there.
    ///
    /// The parallel surface is approximated by circular arcs that share its points and normals at 33 places (biarcs:
    /// Bolton, "Biarc curves", Computer-Aided Design 7, 1975).
    pub fn cavity(&self, depth: f64, tip_radius: f64, bottom_z: f64) -> Solid {
        let fold = self.fold(depth + tip_radius);
        let node = |i: u32| {
            let eccentric = FRAC_PI_2 + (fold - FRAC_PI_2) * f64::from(i) / f64::from(BIARC_COUNT);
            let (point, normal) = self.meridian(eccentric);
            ([point[0] - depth * normal[0], point[1] - depth * normal[1]], normal)
        };
        let bore = self.equatorial - depth;
        let mut path = Path::from([0.0, bottom_z]).line([bore, bottom_z]).line([bore, 0.0]);
        // The first point is set exactly on the base circle, where rounding would leave z = 1e-16.
        let (mut from, mut from_normal) = ([bore, 0.0], [1.0, 0.0]);
        for i in 1..=BIARC_COUNT {
            let (mut to, to_normal) = node(i);
            // The last point lies on the axis, exactly.
            if i == BIARC_COUNT && fold == 0.0 {
                to[0] = 0.0;
            }
            let [first, joint, second] = biarc(from, from_normal, to, to_normal);
            path = path.arc(joint, first, true).arc(to, second, true);
            (from, from_normal) = (to, to_normal);
        }
        if fold > 0.0 {
            let centre_z = self.ball_centre_z(depth + tip_radius);
            path = path.arc([0.0, centre_z + tip_radius], [0.0, centre_z], true);
        }
        Solid::revolution(path.close())
    }

    /// Estimates the area above the base circle of the surface at `offset`, mm2, to about a thousandth: enough for
    /// choosing a number of rings.
    pub fn area_estimate(&self, offset: f64) -> f64 {
        const STEPS: u32 = 100;
        let point = |i: u32| {
            let (p, n) = self.meridian(FRAC_PI_2 * f64::from(i) / f64::from(STEPS));
            [p[0] + offset * n[0], p[1] + offset * n[1]]
        };
        let band = |i: u32| {
            let ([r, z], [s, w]) = (point(i), point(i + 1));
            PI * (r + s) * (r - s).hypot(z - w)
        };
        (0..STEPS).map(band).sum()
    }

    /// Length of the meridian from the tip to the base circle on the surface at `offset`, mm: that of the ellipse,
    /// plus the offset times the quarter turn of the normal (Steiner's formula).
    pub fn meridian_length(&self, offset: f64) -> f64 {
        // The trapezoidal rule converges geometrically on a quarter of a period.
        const PANELS: u32 = 256;
        let speed = |i: u32| {
            let (s, c) = (FRAC_PI_2 * f64::from(i) / f64::from(PANELS)).sin_cos();
            (self.equatorial * c).hypot(self.polar * s)
        };
        let ends = (speed(0) + speed(PANELS)) / 2.0;
        let sum = ends + (1..PANELS).map(speed).sum::<f64>();
        FRAC_PI_2 * (sum / f64::from(PANELS) + offset)
    }
}

/// Joins two points with given normals by two arcs. Returns the first centre, the joint and the second centre. At the
/// joint both arcs have the normal half way between the given ones.
fn biarc(p: [f64; 2], n: [f64; 2], q: [f64; 2], m: [f64; 2]) -> [[f64; 2]; 3] {
    let middle = [n[0] + m[0], n[1] + m[1]];
    let length = middle[0].hypot(middle[1]);
    let middle = middle.map(|v| v / length);
    // The radii r and s solve p + r (middle - n) + s (m - middle) = q.
    let (u, v) = ([middle[0] - n[0], middle[1] - n[1]], [m[0] - middle[0], m[1] - middle[1]]);
    let d = [q[0] - p[0], q[1] - p[1]];
    let cross = |x: [f64; 2], y: [f64; 2]| x[0] * y[1] - x[1] * y[0];
    let r = cross(d, v) / cross(u, v);
    let s = cross(u, d) / cross(u, v);
    let first = [p[0] - r * n[0], p[1] - r * n[1]];
    let joint = [first[0] + r * middle[0], first[1] + r * middle[1]];
    [first, joint, [q[0] - s * m[0], q[1] - s * m[1]]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabkit_geometry::{CompiledSolid, Point3, Ray, Vector3};

    const UVDTACT: Ellipsoid = Ellipsoid { equatorial: 9.0, polar: 24.0 };

    #[test]
    fn the_cavity_is_parallel_to_a_tenth_of_a_micrometre_below_its_rounded_tip() {
        for (ellipsoid, depth, tip_radius) in [
            (UVDTACT, 4.4, 1.5),
            (UVDTACT, 4.0, 0.5),
            (Ellipsoid { equatorial: 10.0, polar: 40.0 }, 4.4, 1.5),
            (Ellipsoid { equatorial: 20.0, polar: 24.0 }, 3.0, 1.5),
        ] {
            let body = CompiledSolid::new(&ellipsoid.cavity(depth, tip_radius, -3.0)).unwrap();
            let fold = ellipsoid.fold(depth + tip_radius);
            for i in 0..500 {
                let eccentric = fold + (FRAC_PI_2 - fold) * (f64::from(i) + 0.5) / 500.0;
                let (point, normal) = ellipsoid.meridian(eccentric);
                // From the ellipsoid inwards along its own normal, in an odd half plane.
                let (s, c) = 0.3f64.sin_cos();
                let at = |v: [f64; 2]| Vector3::new(v[0] * c, v[0] * s, v[1]);
                let ray = Ray { origin: Point3::from(at(point)), direction: -at(normal) };
                let thickness = body.crossings(&ray)[0].t;
                assert!((thickness - depth).abs() < 1e-4, "{ellipsoid:?} {eccentric}: {thickness}");
            }
            // The tip: as far as it says, and nowhere nearer to the ellipsoid than the depth.
            let down = Ray { origin: Point3::new(0.0, 0.0, 99.0), direction: -Vector3::z() };
            let tip_z = 99.0 - body.crossings(&down)[0].t;
            assert!((tip_z - ellipsoid.cavity_tip_z(depth, tip_radius)).abs() < 1e-6);
            assert!(tip_z <= ellipsoid.polar - depth + 1e-9);
        }
    }

    #[test]
    fn the_meridian_of_a_near_sphere_is_a_quarter_circle() {
        let sphere = Ellipsoid { equatorial: 10.0, polar: 10.0 };
        assert!((sphere.meridian_length(-2.0) - FRAC_PI_2 * 8.0).abs() < 1e-12);
        // Ramanujan's second formula, good to 1e-7 here.
        let h = ((24.0 - 9.0f64) / (24.0 + 9.0)).powi(2);
        let perimeter = PI * 33.0 * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()));
        assert!((UVDTACT.meridian_length(0.0) - perimeter / 4.0).abs() < 1e-4);
    }
}
