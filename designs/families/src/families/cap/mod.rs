//! Dome-cap sensors: a dimpled cap of clear gel, painted outside, on a clear plate, with coloured LEDs and a camera
//! below (ShadowTac).
//!
//! This file holds the layout and the screw joints, on which all other files of the family build.

mod chain;
mod constraints;
mod electronics;
mod housing;
mod molds;
mod parameters;

use fabkit_geometry::{
    CUT_OVERLAP_MM, DomeSurface, FixtureGrip, NominalCamera, Point3, Pose, Process, Sensor, Vector3,
};

use crate::blocks::adapter::MountFace;
use crate::blocks::lighting::{RED_GREEN_BLUE, slope_lighting};
use crate::blocks::listed_markers::RoundPattern;
use crate::blocks::mounting::{MountHold, MountRing, Mounting};
use crate::blocks::{self, ScrewJoint, corners, hanging, mm, ring, sphere};
use crate::chain_builder::names;
use crate::fits::Fit;
use crate::hardware::{HexNut, Screw};
use crate::parameters::RuleReport;
use crate::{Family, FamilyOutput, Header, layout};
use parameters::{BASE, BLOCK, Cap, Direction, HOLDER};

/// Dome-cap family, whose built-in example is ShadowTac.
pub(crate) struct CapFamily;

impl Family for CapFamily {
    type Parameters = Cap;
    const NAME: &'static str = "dome-cap";
    const SUMMARY: &'static str = "a dimpled, painted cap of gel on a plate, lit in three colours";
    const EXAMPLE: &'static str = "shadowtac";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("dome-cap.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &Cap, report: &mut RuleReport) {
        constraints::check(parameters, report);
    }

    fn build(parameters: &Cap, header: &Header, report: &mut RuleReport) -> Option<FamilyOutput> {
        let layout = CapLayout::new(parameters);
        match housing::dimple_poses(parameters, &layout) {
            Ok(dimples) => Some(FamilyOutput {
                sensor: build_sensor(parameters, header, &layout, &dimples),
                derived: derived_dimensions(parameters, &layout),
                face: Some(mount_face(parameters, &layout)),
            }),
            Err(error) => {
                report.require(
                    false,
                    "dimples.rings",
                    || format!("dimples.rings: {error}"),
                    || "write fewer rings, or a smaller `dimples.spacing`".into(),
                );
                None
            }
        }
    }
}

/// Returns the face by which the sensor is mounted.
fn mount_face(p: &Cap, layout: &CapLayout) -> MountFace {
    MountFace {
        holder: parameters::BASE,
        mounting: Joints::new(p, layout).mounting,
        replaced_screw_mm: None,
        bottom_z_mm: layout.bottom_z_mm,
        outline: housing::casing_outline(p),
        exits: vec![electronics::cable_exit(p, layout)],
        heads: Vec::new(),
    }
}

/// Builds the sensor: all bodies, the circuit, press fits, casting steps and the camera.
fn build_sensor(p: &Cap, header: &Header, layout: &CapLayout, dimples: &[Pose]) -> Sensor {
    let casing = [housing::plate(p, layout), housing::holder(p, layout), housing::base(p, layout)];
    let (touch, joints) = (touch_surface(p, layout), Joints::new(p, layout));
    let bodies = casing
        .into_iter()
        .chain(molds::mold_parts(p, layout, dimples))
        .chain(housing::layers(p, layout, &touch, dimples))
        .chain(electronics::components(p, layout));
    Sensor {
        chain: chain::chain(p, layout),
        circuits: vec![electronics::circuit(p)],
        press_fits: joints
            .casing
            .press_fit(parameters::HOLDER)
            .into_iter()
            .chain(joints.insert_joint().and_then(|mounting| mounting.press_fit(parameters::BASE)))
            .collect(),
        // Bumps stand out of the sphere, so fixtures that fit the smooth cap would not fit them.
        touch: (p.dimples.direction == Direction::IntoGel).then(|| touch.into()),
        marks: housing::dimple_marks(p, dimples),
        lightings: vec![slope_lighting(
            parameters::PAINT,
            None,
            LED_COLOR_ORDER.map(|i| RED_GREEN_BLUE[i]),
        )],
        visible_bodies: names(&[parameters::PAINT]),
        ..blocks::sensor(header, nominal_camera(p), bodies)
    }
}

/// Order of the LEDs' colours as indices into red, green, blue, counter-clockwise seen from outside; measured in the
/// published code.
const LED_COLOR_ORDER: [usize; 3] = [0, 2, 1];

/// Nominal camera, turned to the side on which its plug leaves.
fn nominal_camera(p: &Cap) -> NominalCamera {
    let c = &p.camera;
    let camera = c.view.camera_at(-c.depth.mm(), c.images.size_px());
    let sensor_from_camera = electronics::turned_to_cable_side(p, camera.sensor_from_camera);
    NominalCamera { sensor_from_camera, ..camera }
}

/// Share of the skin's height up to which it is measurably soft. Beyond, a solid cap of gel stiffens.
const SOFT_SHARE: f64 = 0.4;

/// Returns the touched surface, and the part that fixtures grip: the whole casing. The plug's window serves as key,
/// because only one side has it.
fn touch_surface(p: &Cap, layout: &CapLayout) -> DomeSurface {
    let radius_mm = layout.sphere_radius_mm + p.paint.thickness.mm();
    let outside = housing::casing_outline(p);
    let out = p.base.cable_side.out();
    let height = Vector3::new(0.0, 0.0, (layout.floor_z_mm + layout.housing_back_z_mm) / 2.0);
    let window = Point3::from(outside.narrow() * out + height);
    DomeSurface {
        dome: sphere(radius_mm),
        centre_z_mm: layout.sphere_z_mm,
        foot_z_mm: 0.0,
        max_indentation_mm: SOFT_SHARE * p.skin.height.mm(),
        grip: FixtureGrip {
            outline: outside.path(),
            top_z_mm: 0.0,
            bottom_z_mm: layout.bottom_z_mm,
            clear_radius_mm: 0.0,
            key: Some(Pose::z_to(out, window)),
            threads: Joints::new(p, layout).mounting.thread_cut().landmarks,
        },
    }
}

/// Lists the derived dimensions that `fabkit show` prints.
fn derived_dimensions(p: &Cap, layout: &CapLayout) -> Vec<(String, String)> {
    let mut figures = vec![
        mm("sphere radius", layout.sphere_radius_mm),
        mm("sphere centre below the foot", -layout.sphere_z_mm),
        ("dimples".into(), housing::dimple_count(p).to_string()),
    ];
    let is_ring = p.dimples.pattern == RoundPattern::Rings;
    if is_ring {
        let step_deg = layout.ring_tilt_rad(p, 1).to_degrees();
        figures.push(("polar step from ring to ring".into(), format!("{step_deg:.3} deg")));
    }
    figures.extend(
        constraints::nearest_dimples_mm(p, layout).map(|least| mm("nearest neighbours", least)),
    );
    let lowest = constraints::lowest_dimple_z(p, layout, layout.outermost_tilt_rad(p));
    let outermost = if is_ring { "ring" } else { "dimple" };
    figures.extend([
        mm(&format!("outermost {outermost} above the foot"), lowest),
        mm("total height", p.skin.height.mm() + p.paint.thickness.mm() - layout.bottom_z_mm),
        mm("casing height", -layout.bottom_z_mm),
        mm("lens front below the plate", layout.plate_bottom_z_mm - layout.lens_front_z_mm),
        mm("plug room behind the connector", plug_room_mm(p, layout)),
    ]);
    figures
}

/// Free height between the camera's connector and the base's floor, mm.
fn plug_room_mm(p: &Cap, layout: &CapLayout) -> f64 {
    layout.housing_back_z_mm - p.camera.connector_height.mm() - layout.floor_z_mm
}

// ------ Layout ------
//
// Radii and heights that more than one part needs, each derived once.

layout! {
    /// Radii and heights in the sensor frame, mm.
    ///
    /// The skin's foot is at z = 0, which is the top of the plate and of the holder. Below the plate lies a round
    /// chamber. The camera's housing is clamped between the corners of holder and base.
    pub struct CapLayout from p: &Cap {
        /// Radius of the skin's foot.
        foot_radius_mm = p.skin.base_diameter.mm() / 2.0;
        let height = p.skin.height.mm();
        // Intersecting chords: foot^2 = height (2 radius - height).
        /// Radius of the sphere that the skin is a cap of.
        sphere_radius_mm = (foot_radius_mm.powi(2) + height.powi(2)) / (2.0 * height);
        /// Height of the sphere's centre. It lies below the foot if the cap is less than a hemisphere.
        sphere_z_mm = height - sphere_radius_mm;

        /// Outer radius of the plate.
        plate_radius_mm = p.plate.diameter.mm() / 2.0;
        /// Inner radius of the holder around the plate.
        recess_radius_mm =
            plate_radius_mm + p.making.gap_mm(HOLDER, Process::Fdm, Fit::Slide);
        /// Inner radius of the holder below the plate.
        chamber_radius_mm = p.holder.aperture_diameter.mm() / 2.0;
        /// Bottom of the plate, which is the top of the ledge that it is glued to.
        plate_bottom_z_mm = -p.plate.thickness.mm();
        // A strip is flat and the chamber round: its face touches the chamber's wall in the middle.
        /// Distance of a strip's back from the axis.
        strip_back_mm = chamber_radius_mm + p.leds.strip_thickness.mm();
        /// Distance of the LEDs' light-emitting faces from the axis.
        led_front_mm = chamber_radius_mm - p.leds.package_height.mm();
        /// Height of the LEDs' centres.
        led_z_mm = plate_bottom_z_mm - p.leds.below_plate.mm() - p.leds.strip_width.mm() / 2.0;

        /// Front of the lens.
        lens_front_z_mm = p.camera.pupil_behind_front.mm() - p.camera.depth.mm();
        /// Front of the lens mount.
        mount_front_z_mm = lens_front_z_mm - p.camera.lens_protrusion.mm();
        /// Front of the camera's housing, which the holder's corners bear on.
        housing_front_z_mm = mount_front_z_mm - p.camera.mount_height.mm();
        /// Back of the camera's housing, which rests on the base's corners.
        housing_back_z_mm = housing_front_z_mm - p.camera.housing_height.mm();
        // Holder and base form one pocket, so the larger of their gaps applies.
        let clamping = [HOLDER, BASE].map(|part| (part, Process::Fdm));
        let slide = p.making.widest_gap_mm(clamping, Fit::Slide);
        /// Half the edge length of the pocket around the housing.
        pocket_half_mm = p.camera.housing_size.mm() / 2.0 + slide;
        /// Radius of the pocket's corners.
        pocket_corner_mm = p.camera.housing_corner.mm() + slide;
        /// Bottom of the holder, which is the top of the base.
        joint_z_mm = -p.holder.height.mm();
        /// Bottom of everything.
        bottom_z_mm = joint_z_mm - p.base.height.mm();
        /// Top of the base's floor.
        floor_z_mm = bottom_z_mm + p.base.floor.mm();

        /// Outer radius of the mold.
        mold_radius_mm = p.mold.diameter.mm() / 2.0;
        /// Outer radius of the lid's boss.
        boss_radius_mm = foot_radius_mm + p.mold.land.mm();
        /// Inner radius of the spacer.
        spacer_bore_mm = boss_radius_mm + p.mold.trough.mm();
        /// Face of the lid's flange that touches the spacer.
        flange_z_mm = -p.mold.spacer.mm();
        /// Outer face of the lid, on which the bolts' heads bear.
        lid_z_mm = flange_z_mm - p.mold.lid_thickness.mm();
        // The bolt's tip ends flush with its nut.
        /// Face of the nuts that bears on the block.
        nut_z_mm = lid_z_mm + MOLD_BOLT.0.length_mm - MOLD_BOLT.1.height_mm;
    }
}

impl CapLayout {
    /// Angle between the axis and the normal on ring `index` of the dimples, rad. The spacing is measured along the
    /// arc.
    pub fn ring_tilt_rad(&self, p: &Cap, index: u32) -> f64 {
        f64::from(index) * p.dimples.spacing.mm() / self.sphere_radius_mm
    }

    /// Angle between the axis and the normal at the outermost dimples, rad.
    pub fn outermost_tilt_rad(&self, p: &Cap) -> f64 {
        match p.dimples.pattern {
            RoundPattern::Rings => self.ring_tilt_rad(p, p.dimples.rings),
            RoundPattern::List => p.dimples.listed().outermost_rad(),
        }
    }

    /// Straight distance between neighbouring dimples of ring `index`, mm. Ring k has 6 k dimples.
    pub fn ring_pitch_mm(&self, p: &Cap, index: u32) -> f64 {
        let half_turn = std::f64::consts::PI / f64::from(6 * index);
        2.0 * self.sphere_radius_mm * self.ring_tilt_rad(p, index).sin() * half_turn.sin()
    }
}

// ------ Joints ------
//
// Screws of the sensor and of its mold. Each joint is defined here and nowhere else.

/// Length of a casing screw's thread in the holder, mm: two and a half times its diameter.
pub const BITE_MM: f64 = 5.0;

/// Depth of a screw's pilot hole beyond its tip, mm.
const PILOT_SPARE_MM: f64 = 1.0;

/// Screws that join holder and base.
pub const CASING_SCREW: Screw = Screw::M2X16;

/// Bolts of the mold, and their nuts.
pub const MOLD_BOLT: (Screw, HexNut) = (Screw::M3X16, HexNut::M3);

/// All screw joints, in the sensor frame.
pub struct Joints {
    /// Screws through the base's corners into the holder.
    pub casing: ScrewJoint,
    /// Holes in the base's floor for a gripper. The user provides the screws.
    pub mounting: ScrewJoint,
    /// Bolts through lid, spacer and block of the mold.
    pub mold: ScrewJoint,
}

impl Joints {
    /// Places the joints. The result is meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &Cap, layout: &CapLayout) -> Self {
        let half = p.holder.screw_spacing.mm() / 2.0;
        let head_z = casing_head_z(layout);
        let casing = corners([half, half]).map(|at| hanging(at, head_z)).to_vec();

        let slide = p.making.gap_mm(BLOCK, Process::Sla, Fit::Slide);
        let (bolt, nut) = MOLD_BOLT;
        let (circle, bolts) = (p.mold.bolt_circle.mm() / 2.0, p.mold.bolts);
        let down = hanging([circle, 0.0], layout.lid_z_mm);
        let nuts = ring(bolts, 0.0, Pose::translation(circle, 0.0, layout.nut_z_mm));
        Self {
            casing: ScrewJoint::self_tapping(
                "screw",
                CASING_SCREW,
                casing,
                CASING_SCREW.length_mm + PILOT_SPARE_MM,
            ),
            mounting: mounting(p).joint(layout.bottom_z_mm),
            mold: ScrewJoint::in_hex_nuts("bolt", bolt, ring(bolts, 0.0, down), (nut, nuts))
                .in_pockets(slide, p.mold.height.mm() - layout.nut_z_mm)
                .named_bolts(),
        }
    }

    /// Returns the mounting joint if its holes hold heat-set nuts.
    pub fn insert_joint(&self) -> Option<&ScrewJoint> {
        self.mounting.nut_name().map(|_| &self.mounting)
    }
}

/// Defines the holes for a gripper's screws.
pub(super) fn mounting(p: &Cap) -> Mounting<'_> {
    Mounting {
        mount: &p.mount,
        ring: MountRing::Circle(p.base.mount_holes, p.base.mount_radius, 0.0),
        depth_mm: p.base.floor.mm() + CUT_OVERLAP_MM,
        is_through: true,
        holds: (&[MountHold::Tapped, MountHold::Insert, MountHold::Through], ""),
    }
}

/// Height at which the pilot holes of the casing's screws end, mm.
pub fn casing_tip_z(layout: &CapLayout) -> f64 {
    casing_head_z(layout) + CASING_SCREW.length_mm + PILOT_SPARE_MM
}

/// Height on which the heads of the casing's screws bear, mm.
pub fn casing_head_z(layout: &CapLayout) -> f64 {
    layout.joint_z_mm + BITE_MM - CASING_SCREW.length_mm
}
