//! Where things are: every radius and height that more than one part needs, derived once.

use fabkit_geometry::Process;

use super::bodies::{BASE, HOLDER};
use super::joints::MOLD_BOLT;
use super::parameters::Cap;
use crate::blocks::marks::RoundPattern;
use crate::fits::Fit;
use crate::layout;

layout! {
    /// Radii and heights in the sensor frame, mm.
    ///
    /// The skin's foot is z = 0, the top of the plate and of the holder. Below the plate lies a
    /// round chamber; the camera's housing is clamped between the holder's and the base's corners.
    pub struct Layout from p: &Cap {
        /// Radius of the skin's foot.
        foot_radius_mm = p.skin.base_diameter.mm() / 2.0;
        let height = p.skin.height.mm();
        // Intersecting chords: foot^2 = height (2 radius - height).
        /// Radius of the sphere that the skin is a cap of.
        sphere_radius_mm = (foot_radius_mm.powi(2) + height.powi(2)) / (2.0 * height);
        /// Height of the sphere's centre, below the foot for less than a hemisphere.
        sphere_z_mm = height - sphere_radius_mm;

        /// Outside of the plate.
        plate_radius_mm = p.plate.diameter.mm() / 2.0;
        /// Inside of the holder around the plate.
        recess_radius_mm =
            plate_radius_mm + p.making.gap_mm(HOLDER, Process::Fdm, Fit::Slide);
        /// Inside of the holder below the plate.
        chamber_radius_mm = p.holder.aperture_diameter.mm() / 2.0;
        /// Bottom of the plate, top of the ledge.
        plate_bottom_z_mm = -p.plate.thickness.mm();
        // A strip's face touches the chamber's wall in the middle.
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
        // One pocket in both pieces: the larger gap.
        let clamping = [HOLDER, BASE].map(|part| (part, Process::Fdm));
        let slide = p.making.widest_mm(clamping, Fit::Slide);
        /// Half the edge of the pocket around the housing.
        pocket_half_mm = p.camera.housing_size.mm() / 2.0 + slide;
        /// Radius of the pocket's corners.
        pocket_corner_mm = p.camera.housing_corner.mm() + slide;
        /// Bottom of the holder, top of the base.
        joint_z_mm = -p.holder.height.mm();
        /// Bottom of everything.
        bottom_z_mm = joint_z_mm - p.base.height.mm();
        /// Top of the base's floor.
        floor_z_mm = bottom_z_mm + p.base.floor.mm();

        /// Outside of the mold.
        mold_radius_mm = p.mold.diameter.mm() / 2.0;
        /// Outside of the lid's boss.
        boss_radius_mm = foot_radius_mm + p.mold.land.mm();
        /// Inside of the spacer.
        spacer_bore_mm = boss_radius_mm + p.mold.trough.mm();
        /// Side of the lid's flange that the spacer touches.
        flange_z_mm = -p.mold.spacer.mm();
        /// Outer side of the lid, where the bolts' heads bear.
        lid_z_mm = flange_z_mm - p.mold.lid_thickness.mm();
        // The bolt's tip ends flush with its nut.
        /// Side of the nuts that bears on the block.
        nut_z_mm = lid_z_mm + MOLD_BOLT.0.length_mm - MOLD_BOLT.1.height_mm;
    }
}

impl Layout {
    /// Angle between the axis and the normal on ring `index` of the dimples, rad.
    pub fn ring_tilt_rad(&self, p: &Cap, index: u32) -> f64 {
        f64::from(index) * p.dimples.spacing.mm() / self.sphere_radius_mm
    }

    /// Angle between the axis and the normal where the outermost dimples are, rad.
    pub fn outermost_tilt_rad(&self, p: &Cap) -> f64 {
        match p.dimples.pattern {
            RoundPattern::Rings => self.ring_tilt_rad(p, p.dimples.rings),
            RoundPattern::List => p.dimples.listed().outermost_rad(),
        }
    }

    /// Distance between neighbours of one ring, on the sphere as the crow flies, mm.
    pub fn ring_pitch_mm(&self, p: &Cap, index: u32) -> f64 {
        let half_turn = std::f64::consts::PI / f64::from(6 * index);
        2.0 * self.sphere_radius_mm * self.ring_tilt_rad(p, index).sin() * half_turn.sin()
    }
}
