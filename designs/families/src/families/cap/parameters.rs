//! Parameters of the dome-cap family, and the names of its bodies.

use fabkit_geometry::{Angle, Length};

use crate::blocks::cable_openings::HousingSide;
use crate::blocks::listed_markers::{ListedMarkers, RoundPattern};
use crate::blocks::mounting::Mount;
use crate::blocks::optics::{ImageFormat, Module, View};
pub use crate::blocks::{CAMERA, CAMERA_CABLE};
use crate::chain_builder::AssemblyName;
use crate::materials::Castable;
use crate::parameters::Inline;
use crate::processes::ProcessAssignments;
use crate::{choices, parameters, sections};

parameters! {
    /// Clear gel: a spherical cap that stands on the plate.
    pub struct Skin {
        /// Diameter of the cap's foot, the circle in which it meets the plate.
        base_diameter: Length = 8.0..=120.0,
        /// Height of the cap. The sphere follows from this height and the foot's diameter.
        height: Length = 1.0..=60.0,
        /// Trade name of the gel.
        material: Castable,
    }
}

choices! {
    /// Direction in which the dimples point.
    pub enum Direction {
        /// Holes in the gel: the mold carries pins.
        IntoGel = "into-gel",
        /// Bumps on the gel: the mold carries holes.
        OutOfGel = "out-of-gel",
    }
}

sections! {
    /// Dimples that cast coloured shadows: cylinders with a hemispherical tip.
    pub struct Dimples {
        /// Diameter of a dimple's cylinder and hemisphere.
        width: Length = 0.05..=5.0,
        /// Height of a dimple including its hemisphere, along the surface's normal.
        height: Length = 0.05..=5.0,
        /// Pattern of the dimples: `rings` around the apex, or a `list` of positions `polar` and `azimuth`.
        pattern: RoundPattern,
        /// For a list: angle of each dimple from the apex, at the sphere's centre.
        polar: Vec<Angle> = (1..=1000, 0.0..=90.0),
        /// For a list: angle of each dimple around the axis, from +x towards +y.
        azimuth: Vec<Angle> = (1..=1000, -360.0..=360.0),
        /// For rings: distance between neighbouring dimples along the surface.
        spacing: Length = 0.1..=20.0,
        /// For rings: number of rings around the central dimple; ring k holds 6 k dimples.
        rings: u32 = 1..=40,
        /// Direction of the dimples: into the gel or out of it.
        direction: Direction,
    }

    /// Reflective paint on the outside of the gel.
    pub struct Paint {
        /// Thickness of the paint when dry.
        thickness: Length = 0.005..=1.0,
        /// Trade name of the paint.
        material: Castable,
    }

    /// Clear plate that carries the skin.
    pub struct Plate {
        /// Diameter of the plate.
        diameter: Length = 8.0..=120.0,
        /// Thickness of the sheet from which the plate is cut.
        thickness: Length = 1.0..=10.0,
        /// Material of the plate.
        material: String = 1..=80,
    }

    /// Printed upper piece of the casing, which holds the plate, the LEDs and the camera's front.
    pub struct Holder {
        /// Edge of the holder's square outline.
        width: Length = 10.0..=150.0,
        /// Height of the holder.
        height: Length = 5.0..=100.0,
        /// Radius of the outline's corners.
        corner: Length = 0.5..=20.0,
        /// Radius of the upper rim's outer edge, around the skin; 0 for a sharp edge. The base's lower edge stays
        /// sharp, because the sensor stands on it and the screws' heads lie beside it.
        edge_fillet: Length = 0.0..=5.0,
        /// Diameter of the opening below the plate. The plate is glued to the ledge around it.
        aperture_diameter: Length = 5.0..=118.0,
        /// Distance between neighbouring M2 screws that join holder and base.
        screw_spacing: Length = 5.0..=140.0,
        /// Material of the holder.
        material: String = 1..=80,
    }

    /// Printed lower piece of the casing, which clamps the camera and is screwed to a gripper.
    pub struct Base {
        /// Height of the base.
        height: Length = 10.0..=100.0,
        /// Thickness of the base's floor.
        floor: Length = 2.0..=20.0,
        /// Width of the window for the camera's plug.
        window_width: Length = 5.0..=60.0,
        /// Side of the window for the camera's plug, towards which the camera is turned: `right` at +x, `left` at -x,
        /// `front` at -y, `back` at +y.
        cable_side: HousingSide,
        /// Number of M3 holes in the floor for the gripper's screws.
        mount_holes: u32 = 2..=8,
        /// Radius of the circle on which these holes lie.
        mount_radius: Length = 3.0..=60.0,
    }

    /// Coloured LEDs, each on a piece of strip that is glued to the inside of the holder.
    pub struct Leds {
        /// Number of LEDs, evenly spaced around the axis; their colours are red, green and blue in turn.
        count: u32 = 3..=12,
        /// Length of a piece of LED strip, around the axis.
        strip_length: Length = 2.0..=40.0,
        /// Width of the LED strip, along the axis.
        strip_width: Length = 2.0..=12.0,
        /// Thickness of the LED strip with its adhesive.
        strip_thickness: Length = 0.1..=2.0,
        /// Edge of an LED's square package.
        package_size: Length = 1.0..=6.0,
        /// Height of an LED's package above the strip.
        package_height: Length = 0.3..=4.0,
        /// Distance of the strip's upper edge below the plate.
        below_plate: Length = 0.0..=10.0,
        /// Type of LED to buy.
        model: String = 1..=80,
    }

    /// Camera with its lens.
    pub struct Camera {
        /// Camera module.
        module: Inline<Module>,
        /// Type of lens to buy.
        lens: String = 1..=80,
        /// Images of the camera.
        images: Inline<ImageFormat>,
        /// View of the camera's lens.
        view: Inline<View>,
        /// Distance of the lens's optical centre below the skin's foot.
        depth: Length = 1.0..=100.0,
        /// Distance of the optical centre behind the lens's front.
        pupil_behind_front: Length = 0.0..=20.0,
        /// Diameter of the lens's head.
        lens_diameter: Length = 2.0..=40.0,
        /// Length by which the lens stands out of its mount when it is in focus.
        lens_protrusion: Length = 0.5..=30.0,
        /// Diameter of the lens mount.
        mount_diameter: Length = 4.0..=50.0,
        /// Height of the lens mount above the camera's housing.
        mount_height: Length = 0.5..=30.0,
        /// Edge of the camera's square housing.
        housing_size: Length = 8.0..=60.0,
        /// Radius of the corners of the camera's housing.
        housing_corner: Length = 0.2..=10.0,
        /// Height of the camera's housing with its board.
        housing_height: Length = 2.0..=40.0,
        /// Height of the connector behind the camera's housing.
        connector_height: Length = 0.5..=20.0,
    }

    /// Resin mold for the skin: cavity, spacer and lid, bolted together.
    pub struct Mold {
        /// Outer diameter of the mold.
        diameter: Length = 20.0..=200.0,
        /// Height of the block with the cavity.
        height: Length = 5.0..=100.0,
        /// Minimum thickness of floor and wall around the cavity.
        wall: Length = 1.0..=20.0,
        /// Thickness of the spacer, which is the height of the lid's boss above its flange.
        spacer: Length = 1.5..=10.0,
        /// Thickness of the lid's flange.
        lid_thickness: Length = 2.0..=10.0,
        /// Width of the land, the flat ring that seals between the lid's boss and the block.
        land: Length = 0.3..=5.0,
        /// Width of the trough around the land, which takes surplus gel.
        trough: Length = 0.5..=10.0,
        /// Number of M3x16 bolts.
        bolts: u32 = 3..=12,
        /// Diameter of the circle on which the bolts lie.
        bolt_circle: Length = 10.0..=190.0,
        /// Diameter of the bolt holes in lid and spacer.
        lid_hole: Length = 3.1..=5.0,
        /// Diameter of the bolt holes in the block.
        block_hole: Length = 3.1..=5.0,
        /// Number of vents in the lid.
        vents: u32 = 2..=24,
        /// Diameter of a vent.
        vent_diameter: Length = 0.6..=4.0,
        /// Width of a pry slot, in which a screwdriver opens the mold.
        pry_width: Length = 3.0..=20.0,
        /// Radial depth of a pry slot.
        pry_depth: Length = 0.8..=6.0,
        /// Height of a pry slot.
        pry_gap: Length = 0.5..=4.0,
        /// Material of the mold.
        material: String = 1..=80,
    }

    /// Parameters of a dome-cap sensor.
    pub struct Cap {
        /// Clear gel: a spherical cap that stands on the plate.
        skin: Skin,
        /// Dimples that cast coloured shadows: cylinders with a hemispherical tip.
        dimples: Dimples,
        /// Reflective paint on the outside of the gel.
        paint: Paint,
        /// Clear plate that carries the gel.
        plate: Plate,
        /// Printed upper piece of the casing, which holds the plate, the LEDs and the camera's front.
        holder: Holder,
        /// Printed lower piece of the casing, which clamps the camera and is screwed to a gripper.
        base: Base,
        /// Holes by which the sensor is mounted.
        mount: Mount,
        /// Coloured LEDs, each on a piece of strip that is glued to the inside of the holder.
        leds: Leds,
        /// Camera with its lens.
        camera: Camera,
        /// Resin mold for the gel: cavity, spacer and lid, bolted together.
        mold: Mold,
        /// Processes by which the parts are made.
        making: ProcessAssignments,
    }
}

impl Dimples {
    /// Returns the listed dimples.
    pub fn listed(&self) -> ListedMarkers<'_, Angle> {
        ListedMarkers::new(
            "dimple",
            ("dimples.polar", &self.polar),
            ("dimples.azimuth", &self.azimuth),
        )
    }
}

// ------ Bodies ------
//
// Bodies of the sensor and of its mold, and the assembly in which the mold is used.

/// Assembly that casts the skin.
pub const SKIN_MOLD: AssemblyName = AssemblyName("skin-mold");

crate::bodies! {
    pub PLATE "plate" "clear plate that carries the skin";
    pub HOLDER "holder" "casing's upper piece: holds plate, LEDs and the camera's front";
    pub BASE "base" "casing's lower piece: clamps the camera, is screwed to a gripper";
    pub BLOCK "mold-skin-block" "cavity of the skin, with the dimples' pins";
    pub SPACER "mold-skin-spacer"
        "sets the height of the lid; its notches let surplus out and a screwdriver in";
    pub LID "mold-skin-lid" "closes the mold; the skin's flat foot forms on its boss";
    pub SKIN "skin";
    pub PAINT "reflective-paint";
}
