//! Where things are: every radius and height that more than one part needs, derived once.

use fabkit_geometry::Process;

use super::joints::MOLD_BOLT;
use super::parameters::Cap;
use crate::fits::{Fit, gap_mm};

/// Radii and heights in the sensor frame, mm.
///
/// The skin's foot is z = 0, the top of the plate and of the holder. Below the plate lies a round
/// chamber; the camera's housing is clamped between the holder's and the base's corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Radius of the skin's foot.
    pub foot_radius: f64,
    /// Radius of the sphere that the skin is a cap of.
    pub sphere_radius: f64,
    /// Height of the sphere's centre, below the foot for less than a hemisphere.
    pub sphere_z: f64,

    /// Outside of the plate.
    pub plate_radius: f64,
    /// Inside of the holder around the plate.
    pub recess_radius: f64,
    /// Inside of the holder below the plate.
    pub chamber_radius: f64,
    /// Bottom of the plate, top of the ledge.
    pub plate_bottom_z: f64,
    /// Distance of a strip's back from the axis.
    pub strip_back: f64,
    /// Distance of the LEDs' light-emitting faces from the axis.
    pub led_front: f64,
    /// Height of the LEDs' centres.
    pub led_z: f64,

    /// Front of the lens.
    pub lens_front_z: f64,
    /// Front of the lens mount.
    pub mount_front_z: f64,
    /// Front of the camera's housing, which the holder's corners bear on.
    pub housing_front_z: f64,
    /// Back of the camera's housing, which rests on the base's corners.
    pub housing_back_z: f64,
    /// Half the edge of the pocket around the housing.
    pub pocket_half: f64,
    /// Radius of the pocket's corners.
    pub pocket_corner: f64,
    /// Bottom of the holder, top of the base.
    pub joint_z: f64,
    /// Top of the base's floor.
    pub floor_z: f64,
    /// Bottom of everything.
    pub bottom_z: f64,

    /// Outside of the mold.
    pub mold_radius: f64,
    /// Outside of the lid's boss.
    pub boss_radius: f64,
    /// Inside of the spacer.
    pub spacer_bore: f64,
    /// Side of the lid's flange that the spacer touches.
    pub flange_z: f64,
    /// Outer side of the lid, where the bolts' heads bear.
    pub lid_z: f64,
    /// Side of the nuts that bears on the block.
    pub nut_z: f64,
}

impl Layout {
    /// Derives the layout; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &Cap) -> Self {
        let foot_radius = p.skin.base_diameter.mm() / 2.0;
        let height = p.skin.height.mm();
        // Intersecting chords: foot^2 = height (2 radius - height).
        let sphere_radius = (foot_radius.powi(2) + height.powi(2)) / (2.0 * height);
        let plate_radius = p.plate.diameter.mm() / 2.0;
        let slide = gap_mm(Process::Fdm, Fit::Slide);
        let chamber_radius = p.holder.aperture_diameter.mm() / 2.0;
        let plate_bottom_z = -p.plate.thickness.mm();
        // A strip's face touches the chamber's wall in the middle.
        let strip_back = chamber_radius + p.leds.strip_thickness.mm();

        let lens_front_z = p.camera.pupil_behind_front.mm() - p.camera.depth.mm();
        let mount_front_z = lens_front_z - p.camera.lens_protrusion.mm();
        let housing_front_z = mount_front_z - p.camera.mount_height.mm();
        let joint_z = -p.holder.height.mm();
        let bottom_z = joint_z - p.base.height.mm();

        let boss_radius = foot_radius + p.mold.land.mm();
        let flange_z = -p.mold.spacer.mm();
        let lid_z = flange_z - p.mold.lid_thickness.mm();
        Self {
            foot_radius,
            sphere_radius,
            sphere_z: height - sphere_radius,
            plate_radius,
            recess_radius: plate_radius + slide,
            chamber_radius,
            plate_bottom_z,
            strip_back,
            led_front: chamber_radius - p.leds.package_height.mm(),
            led_z: plate_bottom_z - p.leds.below_plate.mm() - p.leds.strip_width.mm() / 2.0,
            lens_front_z,
            mount_front_z,
            housing_front_z,
            housing_back_z: housing_front_z - p.camera.housing_height.mm(),
            pocket_half: p.camera.housing_size.mm() / 2.0 + slide,
            pocket_corner: p.camera.housing_corner.mm() + slide,
            joint_z,
            floor_z: bottom_z + p.base.floor.mm(),
            bottom_z,
            mold_radius: p.mold.diameter.mm() / 2.0,
            boss_radius,
            spacer_bore: boss_radius + p.mold.trough.mm(),
            flange_z,
            lid_z,
            // The bolt's tip ends flush with its nut.
            nut_z: lid_z + MOLD_BOLT.0.length_mm - MOLD_BOLT.1.height_mm,
        }
    }

    /// Angle between the axis and the normal on ring `index` of the dimples, rad.
    pub fn ring_tilt_rad(&self, p: &Cap, index: u32) -> f64 {
        f64::from(index) * p.dimples.spacing.mm() / self.sphere_radius
    }

    /// Distance between neighbours of one ring, on the sphere as the crow flies, mm.
    pub fn ring_pitch_mm(&self, p: &Cap, index: u32) -> f64 {
        let half_turn = std::f64::consts::PI / f64::from(6 * index);
        2.0 * self.sphere_radius * self.ring_tilt_rad(p, index).sin() * half_turn.sin()
    }
}
