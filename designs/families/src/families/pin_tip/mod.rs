//! Pin-tip sensors: a soft printed hemisphere with pins inside, watched by a camera through gel (the TacTip family).
//!
//! This file holds the layout and the screw joints, on which all other files of the family build.

mod chain;
mod constraints;
mod electronics;
mod housing;
mod parameters;

use std::f64::consts::SQRT_2;

use fabkit_geometry::{
    Angle, Detachable, DomeSurface, FixtureGrip, InvalidPattern, Length, Path, Pattern, Point3,
    Pose, PrintGroup, Process, Sensor,
};

use crate::blocks::bayonet::{self, HOOK_PLAY_MM};
use crate::blocks::lighting::marker_lighting;
use crate::blocks::listed_markers::{RoundPattern, nearest_mm};
use crate::blocks::mounting::Flange;
use crate::blocks::optics::ProjectionLaw;
use crate::blocks::{self, LED, ORingSeat, ScrewJoint, corners, hanging, mm, press_fit, sphere};
use crate::chain_builder::names;
use crate::fits::Fit;
use crate::hardware::{Head, Screw, SocketScrew};
use crate::parameters::RuleReport;
use crate::{Family, FamilyOutput, Header, layout};
use parameters::{BODY, LED_BOARD, PinLayout, PinTip, RING, TIP};

/// Pin-tip family, whose built-in example is the TacTip.
pub(crate) struct PinTipFamily;

impl Family for PinTipFamily {
    type Parameters = PinTip;
    const NAME: &'static str = "pin-tip";
    const SUMMARY: &'static str =
        "a soft printed hemisphere with white-tipped pins, filled with gel";
    const EXAMPLE: &'static str = "tactip";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("pin-tip.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &PinTip, report: &mut RuleReport) {
        constraints::check(parameters, report);
    }

    fn build(
        parameters: &PinTip,
        header: &Header,
        _report: &mut RuleReport,
    ) -> Option<FamilyOutput> {
        let sensor = build_sensor(parameters, header);
        // The sensor has a flange of its own, so it needs no face for an adapter.
        Some(FamilyOutput { sensor, derived: derived_dimensions(parameters), face: None })
    }
}

/// Builds the sensor: all bodies, the circuit, press fits, assembly steps and the camera.
fn build_sensor(p: &PinTip, header: &Header) -> Sensor {
    let layout = PinTipLayout::new(p);
    let made = [
        housing::lens,
        housing::led_board,
        housing::body,
        housing::mount,
        housing::gauge,
        housing::gel,
    ];
    let bodies = housing::printed_tip(p, &layout)
        .into_iter()
        .chain(made.map(|make| make(p, &layout)))
        .chain(electronics::components(p, &layout))
        .chain(electronics::controller_bodies(p, &layout));
    let board = -p.making.gap_mm(BODY, Process::Fdm, Fit::Press);
    let board = press_fit(LED_BOARD, BODY, board, "the board is pressed in");
    let screws = Joints::new(p, &layout).camera.press_fit(BODY);
    // The camera looks at the tip, along +z.
    let view = (PinTipLayout::diagonal_view(p), ProjectionLaw::Equidistant);
    let camera = p.camera.optics.camera_at(layout.pupil_z_mm, [p.camera.pixels; 2], view);
    Sensor {
        marks: housing::dot_marks(p, &layout),
        lightings: vec![marker_lighting(parameters::DOTS, LED)],
        // The ADNS-3080's data sheet: pixel data have six bits.
        intensity_bits: 6,
        contrasts: vec![[parameters::DOTS, parameters::SKIN].map(String::from)],
        chain: chain::chain(p, &layout),
        circuits: vec![electronics::circuit(p, &layout)],
        print_groups: vec![PrintGroup { name: "tip".into(), parts: names(&TIP) }],
        press_fits: [board].into_iter().chain(screws).collect(),
        touch: Some(touch_surface(&layout).into()),
        detachable: Some(tip_detachment(&layout)),
        mount: Some(Pose::translation(0.0, 0.0, layout.plate_bottom_z_mm)),
        visible_bodies: names(&[parameters::DOTS]),
        ..blocks::sensor(header, camera, bodies)
    }
}

/// Describes how the tip comes off its bayonet. Fixtures need this, because the housing behind the tip is twice as
/// wide.
fn tip_detachment(layout: &PinTipLayout) -> Detachable {
    let tip = [&TIP[..], &[parameters::LENS, parameters::GEL]].concat();
    Detachable {
        bodies: names(&tip),
        back: layout.tip_joint.male_onto([]).legs,
        instruction: "push the body's lugs into the tip and turn it until it stops,".into(),
    }
}

/// Indentation in use, mm. Lens and ring are stiff enough for it.
const INDENTATION_MM: f64 = 5.0;

/// Returns the touched surface, and the part that fixtures grip: the tip's rigid ring, which is wider than the shaft
/// below it.
fn touch_surface(layout: &PinTipLayout) -> DomeSurface {
    let radius_mm = layout.outer_radius_mm;
    DomeSurface {
        dome: sphere(radius_mm),
        centre_z_mm: 0.0,
        foot_z_mm: layout.skirt_z_mm,
        max_indentation_mm: INDENTATION_MM,
        grip: FixtureGrip {
            outline: Path::circle([0.0, 0.0], radius_mm),
            top_z_mm: layout.skirt_z_mm,
            bottom_z_mm: layout.ring_bottom_z_mm,
            // The body approaches the tip from below, lugs first.
            clear_radius_mm: layout.shaft_radius_mm.max(layout.tip_joint.lug_radius),
            key: None,
            threads: Vec::new(),
        },
    }
}

/// Lists the derived dimensions that `fabkit show` prints.
fn derived_dimensions(p: &PinTip) -> Vec<(String, String)> {
    let layout = PinTipLayout::new(p);
    let pins = layout.pin_poses(p).map_or(0, |poses| poses.len());
    let [rim, rim_z] = layout.outermost_dot_point(p);
    let seen = 2.0 * layout.ray_radius(PinTipLayout::half_view_tangent(p), rim_z);
    let mut figures =
        vec![("pins".into(), pins.to_string()), mm("pin diameter", layout.pin_diameter_mm)];
    figures.extend(match p.pins.pattern {
        RoundPattern::Rings => Some(mm("pin spacing", layout.pin_spacing_mm)),
        RoundPattern::List => {
            nearest_mm(&layout.dot_ends(p)).map(|least| mm("nearest dots", least))
        }
    });
    figures.extend([
        mm("diameter of the circle around all dots", 2.0 * rim),
        mm("width that the camera sees at the outermost dots", seen),
        mm("margin around the dots at that distance", seen / 2.0 - rim),
        mm("target in the focusing gauge beyond the lens's front", layout.focus_distance_mm(p)),
        ("angle that the camera sees".into(), format!("{:.2} deg", PinTipLayout::view(p).deg())),
        mm("bayonet bore radius, tip", layout.tip_joint.bore_radius),
        mm("bayonet bore radius, mount", layout.mount_joint.bore_radius),
        mm("housing diameter", 2.0 * layout.mount_joint.outer_radius),
        mm(
            "height from the mount's plate to the apex",
            layout.outer_radius_mm - layout.plate_bottom_z_mm,
        ),
    ]);
    figures
}

// ------ Layout ------
//
// Radii and heights that more than one part needs, each derived once.

/// Height of the O-ring's neck above its seat, in cord diameters. The neck holds the ring while the tip is off, and
/// stays clear of the lens.
const NECK_HEIGHT_CORDS: f64 = 0.5;

/// Width of the O-ring's groove, in cord diameters: a squeezed cord grows wider. The stretched ring stays on its
/// neck.
pub const GROOVE_WIDTH_CORDS: f64 = 1.2;

/// Share of the gel's depth below the hemisphere along which its wall slopes towards the lens.
const SLOPE_SHARE: f64 = 0.8;

/// Refractive index of acrylic, for visible light.
const ACRYLIC_INDEX: f64 = 1.49;

/// Refractive index of clear silicone gels.
const GEL_INDEX: f64 = 1.41;

/// Half the diagonal of a rectangle, mm. It is computed from the mean square of the edges, so that a square loses no
/// digit.
pub fn half_diagonal_mm(x: Length, y: Length) -> f64 {
    let edge = (0.5 * (x.mm() * x.mm() + y.mm() * y.mm())).sqrt();
    edge / 2.0 * SQRT_2
}

/// Rise per run of the housing's cone. A slope of 45 degrees prints without support.
const CONE_RISE_PER_RUN: f64 = 1.0;

/// Play of the lens in its ring, mm. It is that of a laser-cut part, unless a file sets how the ring is made.
pub fn lens_play_mm(p: &PinTip) -> f64 {
    p.making.gap_mm(RING, Process::Laser, Fit::Slide)
}

layout! {
    /// Radii and heights in the sensor frame, mm.
    ///
    /// The origin is the hemisphere's centre. Below it the ring holds the lens and locks onto the body's spigot. LED
    /// board, shaft, camera and robot mount follow downwards.
    pub struct PinTipLayout from p: &PinTip {
        /// Outer radius of skin and ring.
        outer_radius_mm = p.tip.diameter.mm() / 2.0;
        /// Inner radius of the skin, where the pins stand.
        skin_radius_mm = outer_radius_mm - p.skin.thickness.mm();
        /// Radius of the interface between the ring's upstand and the skin's skirt.
        upstand_radius_mm = skin_radius_mm + p.skin.upstand.mm();
        /// Lower end of the skirt.
        skirt_z_mm = -p.skin.skirt_height.mm();

        let (diameter, spacing) = match p.pins.layout {
            PinLayout::A => (1.0, 3.0),
            PinLayout::B => (1.0, 4.0),
            PinLayout::C => (1.0, 4.5),
            PinLayout::D => (1.7, 4.5),
            PinLayout::Free => (p.pins.diameter.mm(), p.pins.spacing.mm()),
        };
        /// Diameter of a pin and of its dot.
        pin_diameter_mm = diameter;
        /// Distance of neighbouring circles of pins along the skin's inside.
        pin_spacing_mm = spacing;

        // Grooves are in one part, lugs on the other, and each is made by its own process: the larger gap applies.
        let both = [(RING, Process::PolyJet), (BODY, Process::Fdm)];
        let play = p.making.widest_gap_mm(both, Fit::Slide);
        /// Bayonet between ring and body.
        tip_joint: bayonet::BayonetJoint = bayonet::BayonetJoint::within(&p.bayonet, play, outer_radius_mm);
        /// Radius of the opening that the lens closes.
        ledge_radius_mm = tip_joint.bore_radius - p.lens.ledge.mm();
        /// Outer radius of the lens.
        lens_radius_mm = tip_joint.bore_radius - lens_play_mm(p);
        /// Upper face of the lens, below gel and ledge.
        lens_top_z_mm = -p.fill.depth.mm();
        /// Lower face of the lens.
        lens_bottom_z_mm = lens_top_z_mm - p.lens.thickness.mm();
        // The plastic above the groove is as high as the hook below it, so that neither is weaker.
        let seat_to_groove = p.bayonet.hook_height.mm();
        /// Lower end of the ring, which is the mouth of its bayonet.
        ring_bottom_z_mm = lens_bottom_z_mm - seat_to_groove - tip_joint.groove_top;
        let cord = p.seal.cord.mm();
        /// Outer radius of the neck that holds the O-ring.
        neck_radius_mm = tip_joint.bore_radius - GROOVE_WIDTH_CORDS * cord;
        /// Height of the O-ring's seat on the body.
        seal_z_mm = lens_bottom_z_mm - cord * (1.0 - p.seal.squeeze);
        /// Upper end of the body.
        neck_top_z_mm = seal_z_mm + NECK_HEIGHT_CORDS * cord;
        /// Height of the shoulder on which the ring would meet the body.
        shoulder_z_mm = ring_bottom_z_mm - HOOK_PLAY_MM;

        /// Radius of the bore into which the LED board is pressed.
        board_seat_radius_mm = neck_radius_mm - p.body.neck_wall.mm();
        /// Outer radius of the LED board.
        board_radius_mm = board_seat_radius_mm - p.making.gap_mm(BODY, Process::Fdm, Fit::Press);
        /// Upper face of the LED board.
        board_top_z_mm = lens_bottom_z_mm - p.leds.gap.mm() - p.leds.height.mm();
        /// Lower face of the LED board, on its ledge in the body.
        board_bottom_z_mm = board_top_z_mm - p.led_board.thickness.mm();

        /// Outer radius of the shaft.
        shaft_radius_mm = p.body.shaft_diameter.mm() / 2.0;
        /// Inner radius of the shaft.
        shaft_bore_radius_mm = shaft_radius_mm - p.body.shaft_wall.mm();
        /// Lower end of the shaft, where the cone begins on the outside.
        shaft_bottom_z_mm = neck_top_z_mm - p.body.shaft_length.mm();
        // Both cones rise at 45 degrees, so the wall measured along z is sqrt 2 times its thickness.
        /// Height at which the cone begins on the inside.
        bore_bottom_z_mm = shaft_bottom_z_mm
            - CONE_RISE_PER_RUN * (p.body.shaft_wall.mm() * SQRT_2 - p.body.shaft_wall.mm());
        let half_diagonal = half_diagonal_mm(p.camera.board_size, p.camera.board_size_y);
        let [slide, free] =
            [Fit::Slide, Fit::Free].map(|fit| p.making.gap_mm(BODY, Process::Fdm, fit));
        let mount_bore = half_diagonal + free;
        /// Bayonet between housing and robot mount.
        mount_joint: bayonet::BayonetJoint = bayonet::BayonetJoint::in_bore(&p.bayonet, slide, mount_bore);
        /// Height at which the cone ends on the outside.
        cone_bottom_z_mm =
            shaft_bottom_z_mm - CONE_RISE_PER_RUN * (mount_joint.outer_radius - shaft_radius_mm);
        /// Height at which the cone ends on the inside.
        cavity_top_z_mm =
            bore_bottom_z_mm - CONE_RISE_PER_RUN * (mount_bore - shaft_bore_radius_mm);

        /// Optical centre of the camera.
        pupil_z_mm = -p.camera.depth.mm();
        /// Front face of the camera's lens.
        lens_front_z_mm = pupil_z_mm + p.camera.pupil_behind_front.mm();
        /// Face of the camera board that rests on the posts.
        camera_board_top_z_mm = lens_front_z_mm - p.camera.lens_height.mm();
        /// Face of the camera board on which the screws bear.
        camera_board_bottom_z_mm = camera_board_top_z_mm - p.camera.board_thickness.mm();
        /// Lower end of the body, which is the mouth of its bayonet.
        body_bottom_z_mm =
            camera_board_bottom_z_mm - p.body.wiring_room.mm() - p.mount.spigot_height.mm();
        /// Upper face of the mount's plate.
        plate_top_z_mm = body_bottom_z_mm - HOOK_PLAY_MM;
        /// Lower face of the mount's plate, on the robot's flange.
        plate_bottom_z_mm = plate_top_z_mm - p.mount.plate.mm();
    }
}

impl PinTipLayout {
    /// Returns the seat over which the O-ring is stretched.
    pub fn seal_seat(&self, p: &PinTip) -> ORingSeat {
        ORingSeat { cord: p.seal.cord, radius_mm: self.neck_radius_mm }
    }

    /// Height at which the slope from the skin to the lens's opening ends. While the tip is filled with the lens on
    /// top, air runs along it to the holes.
    pub fn slope_bottom_z(&self) -> f64 {
        SLOPE_SHARE * self.lens_top_z_mm
    }

    /// Poses of the pins on the skin's inside, z axes out of the tip, ordered from the apex outwards or as listed.
    ///
    /// # Errors
    /// Fails if circles lie beyond the skin, or if there are too many pins.
    pub fn pin_poses(&self, p: &PinTip) -> Result<Vec<Pose>, InvalidPattern> {
        let (surface, rings) = (sphere(self.skin_radius_mm), self.pin_ring_count(p));
        if p.pins.pattern == RoundPattern::List {
            return Ok(p.pins.listed().poses(&surface));
        }
        Pattern::even_surface_rings(surface, rings, self.pin_spacing_mm)?.poses()
    }

    /// Number of circles of pins around the one at the apex.
    pub fn pin_ring_count(&self, p: &PinTip) -> u32 {
        // Limits of both parameters keep the quotient below 200.
        (p.pins.reach.mm() / self.pin_spacing_mm + 1e-9).floor() as u32
    }

    /// Centres of the dots' outer faces in the sensor frame.
    pub fn dot_ends(&self, p: &PinTip) -> Vec<Point3<f64>> {
        let end = Point3::new(0.0, 0.0, -p.pins.length.mm() - p.pins.dot_thickness.mm());
        self.pin_poses(p).unwrap_or_default().iter().map(|pose| pose.point(end)).collect()
    }

    /// Distance of the dots' outer faces from the hemisphere's centre, mm.
    pub fn dot_sphere_radius(&self, p: &PinTip) -> f64 {
        self.skin_radius_mm - p.pins.length.mm() - p.pins.dot_thickness.mm()
    }

    /// Distance from the axis and height, mm, of the outermost point of a dot on a circle that lies
    /// `arc_mm` from the apex along the skin's inside.
    pub fn dot_outer_point(&self, p: &PinTip, arc_mm: f64) -> [f64; 2] {
        let (sin, cos) = (arc_mm / self.skin_radius_mm).sin_cos();
        let (radius, half) = (self.dot_sphere_radius(p), self.pin_diameter_mm / 2.0);
        [radius * sin + half * cos, radius * cos - half * sin]
    }

    /// Tangent of the half angle that a side of the pixel array sees.
    pub fn half_view_tangent(p: &PinTip) -> f64 {
        p.camera.array_size.mm() / 2.0 / p.camera.focal_length.mm()
    }

    /// Tangent of the half angle within which dots may lie. The margin covers tolerances of lens and chip.
    pub fn usable_tangent(p: &PinTip) -> f64 {
        (1.0 - p.camera.margin) * Self::half_view_tangent(p)
    }

    /// Distance, mm, in air from the lens's front at which a target is as sharp as the dots are behind lens and gel.
    /// For rays near the axis, the apparent depth of a medium is its thickness divided by its index. It is taken
    /// midway between the dots at the apex and the outermost ones.
    pub fn focus_distance_mm(&self, p: &PinTip) -> f64 {
        let [_, lowest] = self.outermost_dot_point(p);
        let dots = 0.5 * (self.dot_sphere_radius(p) + lowest);
        self.lens_bottom_z_mm - self.lens_front_z_mm
            + p.lens.thickness.mm() / ACRYLIC_INDEX
            + (dots - self.lens_top_z_mm) / GEL_INDEX
    }

    /// Full angle of view along a side of the pixel array.
    pub fn view(p: &PinTip) -> Angle {
        Self::view_of(Self::half_view_tangent(p))
    }

    /// Full angle of view along the diagonal of the square pixel array.
    pub fn diagonal_view(p: &PinTip) -> Angle {
        Self::view_of(Self::half_view_tangent(p) * SQRT_2)
    }

    fn view_of(half_tangent: f64) -> Angle {
        let half = half_tangent.atan();
        Angle::from_rad(2.0 * half).expect("lengths are finite and above 0")
    }

    /// Distance from the axis and height, mm, of the outermost point of the outermost dots.
    pub fn outermost_dot_point(&self, p: &PinTip) -> [f64; 2] {
        self.dot_outer_point(
            p,
            match p.pins.pattern {
                RoundPattern::Rings => f64::from(self.pin_ring_count(p)) * self.pin_spacing_mm,
                RoundPattern::List => p.pins.listed().outermost_rad() * self.skin_radius_mm,
            },
        )
    }

    /// Distance from the axis, mm, at height `z` of a ray that leaves the pupil with `slope` (tangent of its angle
    /// with the axis). Lens and gel refract the ray towards the axis (Snell's law), so the camera sees less of the
    /// tip than its angle of view suggests.
    pub fn ray_radius(&self, slope: f64, z: f64) -> f64 {
        let sine = slope / 1.0f64.hypot(slope);
        let within = |index: f64| {
            let bent = sine / index;
            bent / (1.0 - bent * bent).sqrt()
        };
        slope * (z.min(self.lens_bottom_z_mm) - self.pupil_z_mm)
            + within(ACRYLIC_INDEX) * (z.min(self.lens_top_z_mm) - self.lens_bottom_z_mm).max(0.0)
            + within(GEL_INDEX) * (z - self.lens_top_z_mm).max(0.0)
    }

    /// Radius at height `z`, mm, of the cone of rays from the pupil to the outermost dots.
    pub fn view_cone_radius(&self, p: &PinTip, z: f64) -> f64 {
        let [rim, rim_z] = self.outermost_dot_point(p);
        // Bisection on an increasing function. Refracted rays start steeper than straight ones, but never twice as
        // steep.
        let (mut low, mut high) = (0.0, 2.0 * rim / (rim_z - self.pupil_z_mm));
        // 60 halvings exhaust the digits of f64.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.ray_radius(middle, rim_z) < rim {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.ray_radius(high, z)
    }
}

// ------ Joints ------
//
// Screws of the sensor. Each joint is defined here and nowhere else.

/// Depth of a screw's hole below its tip, for chips, mm.
const PILOT_SPARE_MM: f64 = 1.5;

/// All joints, in the sensor frame.
pub struct Joints {
    /// Screws through the corners of the camera board, from below, into the body's posts.
    pub camera: ScrewJoint,
    /// Bolts through the mount's plate into the robot's flange.
    pub robot: Flange,
}

impl Joints {
    /// Screw that holds the camera board.
    pub const CAMERA_SCREW: Screw = Screw { thread_mm: 3.0, length_mm: 6.0, head: Head::Pan };

    /// Places the joints. The result is meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &PinTip, layout: &PinTipLayout) -> Self {
        let half = [p.camera.screw_spacing, p.camera.screw_spacing_y].map(|edge| edge.mm() / 2.0);
        let screw = Self::CAMERA_SCREW;
        let poses = corners(half).map(|at| hanging(at, layout.camera_board_bottom_z_mm));
        let thickness = p.camera.board_thickness.mm();
        let in_post = screw.length_mm - thickness + PILOT_SPARE_MM;
        Self {
            camera: ScrewJoint::self_tapping(
                "camera screw",
                screw,
                poses.to_vec(),
                thickness + in_post,
            ),
            robot: Flange {
                bolt: SocketScrew::M5,
                bolts: p.mount.bolts,
                bolt_circle: p.mount.bolt_circle,
                top_z: layout.plate_top_z_mm,
                plate_mm: p.mount.plate.mm(),
            },
        }
    }
}
