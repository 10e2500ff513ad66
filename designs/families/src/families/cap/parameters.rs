//! Parameters of the dome-cap family, and the names of its bodies.

use fabkit_geometry::{Angle, Length};

use crate::assembling::AssemblyName;
use crate::blocks::cable_way::Side;
use crate::blocks::marks::{Listed, RoundPattern};
use crate::blocks::mounting::Mount;
use crate::blocks::optics::{Module, Pictures, View};
pub use crate::blocks::{CAMERA, CAMERA_CABLE};
use crate::materials::Castable;
use crate::parameters::Inline;
use crate::processes::Making;
use crate::{choices, parameters, sections};

parameters! {
    /// The clear gel: a spherical cap that stands on the plate.
    pub struct Skin {
        /// Diameter of the cap's foot.
        base_diameter: Length = 8.0..=120.0,
        /// Height of the cap; with the foot it gives the sphere.
        height: Length = 1.0..=60.0,
        /// Trade name.
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
    /// The dimples that cast coloured shadows: cylinders with a hemispherical tip.
    pub struct Dimples {
        /// Diameter of the cylinder and the hemisphere.
        width: Length = 0.05..=5.0,
        /// Height with the hemisphere, along the surface's normal.
        height: Length = 0.05..=5.0,
        /// How they lie: `rings` around the apex, or a `list` of places `polar` and `azimuth`.
        pattern: RoundPattern,
        /// List: angle of each dimple from the apex, at the sphere's centre.
        polar: Vec<Angle> = (1..=1000, 0.0..=90.0),
        /// List: angle of each dimple around the axis, from +x towards +y.
        azimuth: Vec<Angle> = (1..=1000, -360.0..=360.0),
        /// Rings: distance between neighbours along the surface.
        spacing: Length = 0.1..=20.0,
        /// Rings around the central dimple; ring k holds 6 k dimples.
        rings: u32 = 1..=40,
        /// Into or out of the gel.
        direction: Direction,
    }

    /// The reflective paint outside.
    pub struct Paint {
        /// Thickness when dry.
        thickness: Length = 0.005..=1.0,
        /// Trade name.
        material: Castable,
    }

    /// The clear plate that carries the skin.
    pub struct Plate {
        /// Diameter.
        diameter: Length = 8.0..=120.0,
        /// Thickness of the sheet.
        thickness: Length = 1.0..=10.0,
        /// Material.
        material: String = 1..=80,
    }

    /// The printed upper piece of the casing: holds plate, LEDs and the camera's front.
    pub struct Holder {
        /// Edge of the square outline.
        width: Length = 10.0..=150.0,
        /// Height.
        height: Length = 5.0..=100.0,
        /// Radius of the outline's corners.
        corner: Length = 0.5..=20.0,
        /// Radius of the upper rim's outer edge, around the skin; 0 for a sharp one. The base's lower edge
        /// stays sharp: the sensor stands on it, and the screws' heads lie beside it.
        edge_fillet: Length = 0.0..=5.0,
        /// Diameter of the opening below the plate; the plate is glued to the ledge around it.
        aperture_diameter: Length = 5.0..=118.0,
        /// Distance of neighbouring M2 screws that join holder and base.
        screw_spacing: Length = 5.0..=140.0,
        /// Material.
        material: String = 1..=80,
    }

    /// The printed lower piece of the casing: clamps the camera, is screwed to a gripper.
    pub struct Base {
        /// Height.
        height: Length = 10.0..=100.0,
        /// Thickness of the floor.
        floor: Length = 2.0..=20.0,
        /// Width of the window for the camera's plug.
        window_width: Length = 5.0..=60.0,
        /// Which side the window for the camera's plug looks to, and the camera is turned to: `right` at +x,
        /// `left` at -x, `front` at -y, `back` at +y.
        cable_side: Side,
        /// Number of M3 holes in the floor for the gripper's screws.
        mount_holes: u32 = 2..=8,
        /// Radius of the circle of these holes.
        mount_radius: Length = 3.0..=60.0,
    }

    /// The coloured LEDs, each on a piece of strip glued to the holder's inside.
    pub struct Leds {
        /// How many, evenly around; they take red, green, blue in turn.
        count: u32 = 3..=12,
        /// Length of a piece of strip, around the axis.
        strip_length: Length = 2.0..=40.0,
        /// Width of the strip, along the axis.
        strip_width: Length = 2.0..=12.0,
        /// Thickness of the strip with its adhesive.
        strip_thickness: Length = 0.1..=2.0,
        /// Edge of the square package.
        package_size: Length = 1.0..=6.0,
        /// Height of the package above the strip.
        package_height: Length = 0.3..=4.0,
        /// Distance of the strip's upper edge below the plate.
        below_plate: Length = 0.0..=10.0,
        /// Type.
        model: String = 1..=80,
    }

    /// The camera with its lens.
    pub struct Camera {
        /// Which it is.
        module: Inline<Module>,
        /// Type of the lens.
        lens: String = 1..=80,
        /// Its pictures.
        pictures: Inline<Pictures>,
        /// What its lens sees.
        view: Inline<View>,
        /// Distance of the optical centre below the skin's foot.
        depth: Length = 1.0..=100.0,
        /// Distance of the optical centre behind the lens's front.
        pupil_behind_front: Length = 0.0..=20.0,
        /// Diameter of the lens's head.
        lens_diameter: Length = 2.0..=40.0,
        /// How far the lens stands out of its mount when it is in focus.
        lens_protrusion: Length = 0.5..=30.0,
        /// Diameter of the mount.
        mount_diameter: Length = 4.0..=50.0,
        /// Height of the mount above the housing.
        mount_height: Length = 0.5..=30.0,
        /// Edge of the square housing.
        housing_size: Length = 8.0..=60.0,
        /// Radius of the housing's corners.
        housing_corner: Length = 0.2..=10.0,
        /// Height of the housing with its board.
        housing_height: Length = 2.0..=40.0,
        /// Height of the connector behind the housing.
        connector_height: Length = 0.5..=20.0,
    }

    /// The resin mold for the skin: cavity, spacer and lid, bolted together.
    pub struct Mold {
        /// Outer diameter.
        diameter: Length = 20.0..=200.0,
        /// Height of the block with the cavity.
        height: Length = 5.0..=100.0,
        /// Thinnest floor and wall allowed around the cavity.
        wall: Length = 1.0..=20.0,
        /// Thickness of the spacer: the height of the lid's boss above its flange.
        spacer: Length = 1.5..=10.0,
        /// Thickness of the lid's flange.
        lid_thickness: Length = 2.0..=10.0,
        /// Width of the land that seals between boss and block.
        land: Length = 0.3..=5.0,
        /// Width of the trough around the land that takes the surplus.
        trough: Length = 0.5..=10.0,
        /// Number of M3x16 bolts.
        bolts: u32 = 3..=12,
        /// Diameter of the bolts' circle.
        bolt_circle: Length = 10.0..=190.0,
        /// Diameter of the bolt holes in lid and spacer.
        lid_hole: Length = 3.1..=5.0,
        /// Diameter of the bolt holes in the block.
        block_hole: Length = 3.1..=5.0,
        /// Number of vents in the lid.
        vents: u32 = 2..=24,
        /// Diameter of a vent.
        vent_diameter: Length = 0.6..=4.0,
        /// Width of a pry slot.
        pry_width: Length = 3.0..=20.0,
        /// How far a pry slot reaches in.
        pry_depth: Length = 0.8..=6.0,
        /// Height of a pry slot.
        pry_gap: Length = 0.5..=4.0,
        /// Material.
        material: String = 1..=80,
    }

    /// A dome-cap sensor.
    pub struct Cap {
        /// The clear gel.
        skin: Skin,
        /// The dimples.
        dimples: Dimples,
        /// The reflective paint.
        paint: Paint,
        /// The plate.
        plate: Plate,
        /// The casing's upper piece.
        holder: Holder,
        /// The casing's lower piece.
        base: Base,
        /// The holes that it is mounted by.
        mount: Mount,
        /// The LEDs.
        leds: Leds,
        /// The camera.
        camera: Camera,
        /// The mold.
        mold: Mold,
        /// Which parts are made how.
        making: Making,
    }
}

impl Dimples {
    /// Returns the listed dimples.
    pub fn listed(&self) -> Listed<'_, Angle> {
        Listed::new("dimple", ("dimples.polar", &self.polar), ("dimples.azimuth", &self.azimuth))
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
