//! Pin-tip sensors: a soft printed hemisphere with pins inside, watched by a camera through gel
//! (the TacTip family).
//!
//! Its layout and joints stand below, because all the rest is built from them.

mod chain;
mod constraints;
mod electronics;
mod housing;
mod parameters;

use std::f64::consts::SQRT_2;

use fabkit_geometry::{
    Angle, Detachable, DomeSurface, Grip, InvalidPattern, Length, Path, Pattern, Point3, Pose,
    PrintGroup, Process, Sensor,
};

use crate::assembling::names;
use crate::blocks::bayonet::{self, HOOK_PLAY_MM};
use crate::blocks::lighting::places;
use crate::blocks::marks::{RoundPattern, nearest_mm};
use crate::blocks::mounting::Flange;
use crate::blocks::optics::LensLaw;
use crate::blocks::{self, Joint, LED, ORingSeat, corners, hanging, mm, press_fit, sphere};
use crate::fits::Fit;
use crate::hardware::{Head, Screw, SocketScrew};
use crate::parameters::Report;
use crate::{Built, Family, Header, layout};
use parameters::{BODY, LED_BOARD, PinLayout, PinTip, RING, TIP};

/// The family of the TacTip.
pub(crate) struct PinTipFamily;

impl Family for PinTipFamily {
    type Parameters = PinTip;
    const NAME: &'static str = "pin-tip";
    const SUMMARY: &'static str =
        "a soft printed hemisphere with white-tipped pins, filled with gel";
    const EXAMPLE: &'static str = "tactip";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("pin-tip.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &PinTip, report: &mut Report) {
        constraints::check(parameters, report);
    }

    fn build(parameters: &PinTip, header: &Header, _report: &mut Report) -> Option<Built> {
        let sensor = sensor(parameters, header);
        // It has a flange of its own.
        Some(Built { sensor, derived: derived(parameters), face: None })
    }
}

/// Everything a pin-tip sensor consists of.
fn sensor(p: &PinTip, header: &Header) -> Sensor {
    let layout = Layout::new(p);
    let made = [
        housing::lens,
        housing::led_board,
        housing::body,
        housing::mount,
        housing::gauge,
        housing::gel,
    ];
    let bodies = housing::printed(p, &layout)
        .into_iter()
        .chain(made.map(|make| make(p, &layout)))
        .chain(electronics::components(p, &layout))
        .chain(electronics::controller_bodies(p, &layout));
    let board = -p.making.gap_mm(BODY, Process::Fdm, Fit::Press);
    let board = press_fit(LED_BOARD, BODY, board, "the board is pressed in");
    let screws = Joints::new(p, &layout).camera.press_fit(BODY);
    // The camera looks at the tip.
    let view = (Layout::diagonal_view(p), LensLaw::Equidistant);
    let camera = p.camera.optics.camera_at(layout.pupil_z_mm, [p.camera.pixels; 2], view);
    Sensor {
        marks: housing::dot_marks(p, &layout),
        lightings: vec![places(parameters::DOTS, LED)],
        // ADNS-3080 data sheet: pixel data of six bits.
        grey_bits: 6,
        contrasts: vec![[parameters::DOTS, parameters::SKIN].map(String::from)],
        chain: chain::chain(p, &layout),
        circuits: vec![electronics::circuit(p, &layout)],
        print_groups: vec![PrintGroup { name: "tip".into(), parts: names(&TIP) }],
        press_fits: [board].into_iter().chain(screws).collect(),
        touch: Some(touch(&layout).into()),
        detachable: Some(detachable(&layout)),
        mount: Some(Pose::translation(0.0, 0.0, layout.plate_bottom_z_mm)),
        sight: names(&[parameters::DOTS]),
        ..blocks::sensor(header, camera, bodies)
    }
}

/// The tip comes off its bayonet: the housing behind it is twice as wide.
fn detachable(layout: &Layout) -> Detachable {
    let tip = [&TIP[..], &[parameters::LENS, parameters::GEL]].concat();
    Detachable {
        bodies: names(&tip),
        back: layout.tip_joint.male_onto([]).legs,
        instruction: "push the body's lugs into the tip and turn it until it stops,".into(),
    }
}

/// How far a tip is pressed in use, mm: lens and ring are stiff enough for that.
const PRESS_MM: f64 = 5.0;

/// What is touched, and what fixtures hold on to: the tip's rigid ring, wider than the shaft below.
fn touch(layout: &Layout) -> DomeSurface {
    let radius_mm = layout.outer_radius_mm;
    DomeSurface {
        dome: sphere(radius_mm),
        centre_z_mm: 0.0,
        foot_z_mm: layout.skirt_z_mm,
        soft_mm: PRESS_MM,
        grip: Grip {
            outline: Path::circle([0.0, 0.0], radius_mm),
            top_z_mm: layout.skirt_z_mm,
            bottom_z_mm: layout.ring_bottom_z_mm,
            // The body comes to the tip from below, lugs first.
            clear_radius_mm: layout.shaft_radius_mm.max(layout.tip_joint.lug_radius),
            key: None,
            threads: Vec::new(),
        },
    }
}

/// What follows from the parameters, for `fabkit show`.
fn derived(p: &PinTip) -> Vec<(String, String)> {
    let layout = Layout::new(p);
    let pins = layout.pin_poses(p).map_or(0, |poses| poses.len());
    let [rim, rim_z] = layout.outermost_dot(p);
    let seen = 2.0 * layout.ray_radius(Layout::half_view_tangent(p), rim_z);
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
        mm("target in the focusing gauge beyond the lens's front", layout.focus_mm(p)),
        ("angle that the camera sees".into(), format!("{:.2} deg", Layout::view(p).deg())),
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
// Where things are: every radius and height that more than one part needs, derived once.

/// How far the O-ring's neck stands above its seat, as a share of the cord: it holds the ring while
/// the tip is off and stays clear of the lens.
const NECK_SHARE: f64 = 0.5;

/// Width of the O-ring's groove, in cords: a squeezed cord grows wider. Stretched over the neck, it
/// stays put.
pub const CORD_ROOM: f64 = 1.2;

/// Share of the gel's depth below the hemisphere that slopes towards the lens.
const SLOPE_SHARE: f64 = 0.8;

/// Refractive index of acrylic, for visible light.
const ACRYLIC_INDEX: f64 = 1.49;

/// Refractive index of clear silicone gels.
const GEL_INDEX: f64 = 1.41;

/// Half the diagonal of a rectangle, mm; through the mean square of its edges, so that of a square no digit is
/// lost.
pub fn half_diagonal_mm(x: Length, y: Length) -> f64 {
    let edge = (0.5 * (x.mm() * x.mm() + y.mm() * y.mm())).sqrt();
    edge / 2.0 * SQRT_2
}

/// Steepness of the housing's cone: 45 degrees print without support.
const CONE_RISE_PER_RUN: f64 = 1.0;

/// Play of the lens in its ring, mm: as of what is cut, until a file says how the ring is made.
pub fn lens_play_mm(p: &PinTip) -> f64 {
    p.making.gap_mm(RING, Process::Laser, Fit::Slide)
}

layout! {
    /// Radii and heights in the sensor frame, mm.
    ///
    /// The hemisphere's centre is the origin. Below it the ring holds the lens and locks onto the
    /// body's spigot; LED board, shaft, camera and robot mount follow downwards.
    pub struct Layout from p: &PinTip {
        /// Outside of skin and ring.
        outer_radius_mm = p.tip.diameter.mm() / 2.0;
        /// Inside of the skin, where the pins stand.
        skin_radius_mm = outer_radius_mm - p.skin.thickness.mm();
        /// Between the ring's upstand and the skin's skirt.
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
        /// Diameter of a pin and its dot.
        pin_diameter_mm = diameter;
        /// Distance of neighbouring circles of pins along the skin's inside.
        pin_spacing_mm = spacing;

        // Grooves in one, lugs on the other, each made in its own way: the larger gap.
        let both = [(RING, Process::PolyJet), (BODY, Process::Fdm)];
        let play = p.making.widest_mm(both, Fit::Slide);
        /// Ring and body.
        tip_joint: bayonet::Joint = bayonet::Joint::within(&p.bayonet, play, outer_radius_mm);
        /// The opening that the lens closes.
        ledge_radius_mm = tip_joint.bore_radius - p.lens.ledge.mm();
        /// Outside of the lens.
        lens_radius_mm = tip_joint.bore_radius - lens_play_mm(p);
        /// Upper face of the lens: gel above, and the ledge.
        lens_top_z_mm = -p.fill.depth.mm();
        /// Lower face of the lens.
        lens_bottom_z_mm = lens_top_z_mm - p.lens.thickness.mm();
        // Plastic above the groove as high as the hook below it, so that neither is the weaker.
        let seat_to_groove = p.bayonet.hook_height.mm();
        /// Lower end of the ring, the mouth of its bayonet.
        ring_bottom_z_mm = lens_bottom_z_mm - seat_to_groove - tip_joint.groove_top;
        let cord = p.seal.cord.mm();
        /// Outside of the neck that holds the O-ring.
        neck_radius_mm = tip_joint.bore_radius - CORD_ROOM * cord;
        /// Where the O-ring lies on the body.
        seal_z_mm = lens_bottom_z_mm - cord * (1.0 - p.seal.squeeze);
        /// Upper end of the body.
        neck_top_z_mm = seal_z_mm + NECK_SHARE * cord;
        /// Where the ring would meet the body.
        shoulder_z_mm = ring_bottom_z_mm - HOOK_PLAY_MM;

        /// The bore that it is pressed into.
        board_seat_radius_mm = neck_radius_mm - p.body.neck_wall.mm();
        /// Outside of the LED board.
        board_radius_mm = board_seat_radius_mm - p.making.gap_mm(BODY, Process::Fdm, Fit::Press);
        /// Upper side of the LED board.
        board_top_z_mm = lens_bottom_z_mm - p.leds.gap.mm() - p.leds.height.mm();
        /// Lower side of the LED board, and its ledge in the body.
        board_bottom_z_mm = board_top_z_mm - p.led_board.thickness.mm();

        /// Outside of the shaft.
        shaft_radius_mm = p.body.shaft_diameter.mm() / 2.0;
        /// Inside of the shaft.
        shaft_bore_radius_mm = shaft_radius_mm - p.body.shaft_wall.mm();
        /// Lower end of the shaft, where the cone begins outside.
        shaft_bottom_z_mm = neck_top_z_mm - p.body.shaft_length.mm();
        // Both cones rise at 45 degrees; the wall is thinner than it measures along z by sqrt 2.
        /// Where the cone begins inside.
        bore_bottom_z_mm = shaft_bottom_z_mm
            - CONE_RISE_PER_RUN * (p.body.shaft_wall.mm() * SQRT_2 - p.body.shaft_wall.mm());
        let half_diagonal = half_diagonal_mm(p.camera.board_size, p.camera.board_size_y);
        let [slide, free] =
            [Fit::Slide, Fit::Free].map(|fit| p.making.gap_mm(BODY, Process::Fdm, fit));
        let mount_bore = half_diagonal + free;
        /// Housing and robot mount.
        mount_joint: bayonet::Joint = bayonet::Joint::in_bore(&p.bayonet, slide, mount_bore);
        /// Where the cone ends outside.
        cone_bottom_z_mm =
            shaft_bottom_z_mm - CONE_RISE_PER_RUN * (mount_joint.outer_radius - shaft_radius_mm);
        /// Where the cone ends inside.
        cavity_top_z_mm =
            bore_bottom_z_mm - CONE_RISE_PER_RUN * (mount_bore - shaft_bore_radius_mm);

        /// Optical centre of the camera.
        pupil_z_mm = -p.camera.depth.mm();
        /// Front face of the camera's lens.
        lens_front_z_mm = pupil_z_mm + p.camera.pupil_behind_front.mm();
        /// Side of the camera board that rests on the posts.
        camera_board_top_z_mm = lens_front_z_mm - p.camera.lens_height.mm();
        /// Side of the camera board that the screws bear on.
        camera_board_bottom_z_mm = camera_board_top_z_mm - p.camera.board_thickness.mm();
        /// Lower end of the body, the mouth of its bayonet.
        body_bottom_z_mm =
            camera_board_bottom_z_mm - p.body.wiring_room.mm() - p.mount.spigot_height.mm();
        /// Upper side of the mount's plate.
        plate_top_z_mm = body_bottom_z_mm - HOOK_PLAY_MM;
        /// Lower side of the mount's plate, on the robot's flange.
        plate_bottom_z_mm = plate_top_z_mm - p.mount.plate.mm();
    }
}

impl Layout {
    /// What the O-ring is stretched over.
    pub fn seal_seat(&self, p: &PinTip) -> ORingSeat {
        ORingSeat { cord: p.seal.cord, radius_mm: self.neck_radius_mm }
    }

    /// Where the slope from the skin to the lens's opening ends. Filled with the lens on top, air
    /// runs along it to the holes.
    pub fn slope_bottom_z(&self) -> f64 {
        SLOPE_SHARE * self.lens_top_z_mm
    }

    /// Where the pins stand on the skin's inside, from the apex outwards or as listed, z axes out of the
    /// tip.
    ///
    /// # Errors
    /// Circles beyond the skin, or too many pins.
    pub fn pin_poses(&self, p: &PinTip) -> Result<Vec<Pose>, InvalidPattern> {
        let (surface, rings) = (sphere(self.skin_radius_mm), self.pin_rings(p));
        if p.pins.pattern == RoundPattern::List {
            return Ok(p.pins.listed().poses(&surface));
        }
        Pattern::even_surface_rings(surface, rings, self.pin_spacing_mm)?.poses()
    }

    /// Circles of pins around the one at the apex.
    pub fn pin_rings(&self, p: &PinTip) -> u32 {
        // Limits of both parameters keep the quotient below 200.
        (p.pins.reach.mm() / self.pin_spacing_mm + 1e-9).floor() as u32
    }

    /// Where the dots' outer faces are in the middle, sensor frame.
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
    pub fn dot_rim(&self, p: &PinTip, arc_mm: f64) -> [f64; 2] {
        let (sin, cos) = (arc_mm / self.skin_radius_mm).sin_cos();
        let (radius, half) = (self.dot_sphere_radius(p), self.pin_diameter_mm / 2.0);
        [radius * sin + half * cos, radius * cos - half * sin]
    }

    /// Tangent of half the angle that a side of the pixel array sees.
    pub fn half_view_tangent(p: &PinTip) -> f64 {
        p.camera.array_size.mm() / 2.0 / p.camera.focal_length.mm()
    }

    /// Tangent of half the angle that dots may lie in: what tolerances of lens and chip leave of it.
    pub fn usable_tangent(p: &PinTip) -> f64 {
        (1.0 - p.camera.margin) * Self::half_view_tangent(p)
    }

    /// From the lens's front to where a target in air is as sharp as the dots are behind lens and gel, mm:
    /// for rays near the axis a medium is as deep as its thickness over its index. Midway between the dots
    /// at the apex and the outermost ones.
    pub fn focus_mm(&self, p: &PinTip) -> f64 {
        let [_, lowest] = self.outermost_dot(p);
        let dots = 0.5 * (self.dot_sphere_radius(p) + lowest);
        self.lens_bottom_z_mm - self.lens_front_z_mm
            + p.lens.thickness.mm() / ACRYLIC_INDEX
            + (dots - self.lens_top_z_mm) / GEL_INDEX
    }

    /// Full angle that a side of the pixel array sees.
    pub fn view(p: &PinTip) -> Angle {
        Self::view_of(Self::half_view_tangent(p))
    }

    /// Full angle that the diagonal of the square pixel array sees.
    pub fn diagonal_view(p: &PinTip) -> Angle {
        Self::view_of(Self::half_view_tangent(p) * SQRT_2)
    }

    fn view_of(half_tangent: f64) -> Angle {
        let half = half_tangent.atan();
        Angle::from_rad(2.0 * half).expect("lengths are finite and above 0")
    }

    /// Distance from the axis and height, mm, of the outermost point of the outermost dots.
    pub fn outermost_dot(&self, p: &PinTip) -> [f64; 2] {
        self.dot_rim(
            p,
            match p.pins.pattern {
                RoundPattern::Rings => f64::from(self.pin_rings(p)) * self.pin_spacing_mm,
                RoundPattern::List => p.pins.listed().outermost_rad() * self.skin_radius_mm,
            },
        )
    }

    /// Distance from the axis, mm, at the height `z` of a ray that leaves the pupil with a slope
    /// (tangent of its angle with the axis). Lens and gel bend it towards the axis (Snell), so that
    /// the camera sees less of the tip than its angle of view suggests.
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

    /// Radius at the height `z` of the cone of rays from the pupil to the outermost dots, mm.
    pub fn sight_radius(&self, p: &PinTip, z: f64) -> f64 {
        let [rim, rim_z] = self.outermost_dot(p);
        // Bisection on an increasing function; bent rays start steeper than straight ones, but not
        // twice as steep.
        let (mut low, mut high) = (0.0, 2.0 * rim / (rim_z - self.pupil_z_mm));
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
// The screws of the sensor: each joint is stated here, and nowhere else.

/// Below the tip of a board screw, for chips, mm.
const PILOT_SPARE_MM: f64 = 1.5;

/// All joints, in the sensor frame.
pub struct Joints {
    /// Through the corners of the camera's board, from below, into the body's posts.
    pub camera: Joint,
    /// Through the mount's plate into the robot's flange.
    pub robot: Flange,
}

impl Joints {
    /// The camera's screws.
    pub const SCREW: Screw = Screw { thread_mm: 3.0, length_mm: 6.0, head: Head::Pan };

    /// Where they are; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &PinTip, layout: &Layout) -> Self {
        let half = [p.camera.screw_spacing, p.camera.screw_spacing_y].map(|edge| edge.mm() / 2.0);
        let screw = Self::SCREW;
        let poses = corners(half).map(|at| hanging(at, layout.camera_board_bottom_z_mm));
        let thickness = p.camera.board_thickness.mm();
        let in_post = screw.length_mm - thickness + PILOT_SPARE_MM;
        Self {
            camera: Joint::self_tapping("camera screw", screw, poses.to_vec(), thickness + in_post),
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
