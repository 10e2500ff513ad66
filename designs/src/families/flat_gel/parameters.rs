//! Parameters of the flat-gel family.

use fabkit_geometry::{Angle, Length};

use crate::blocks::frame_mold::FrameMold;
use crate::{choices, parameters};

parameters! {
    /// The pad that touches: gel under a coat. The housing follows from its edges.
    pub struct Pad {
        /// Edge along x, with the coat.
        length: Length = 8.0..=120.0,
        /// Edge along y, with the coat.
        width: Length = 8.0..=120.0,
        /// Thickness of gel and coat together.
        thickness: Length = 0.8..=20.0,
        /// Radius of the upright edges, with the coat.
        corner: Length = 0.2..=20.0,
        /// Trade name of the gel.
        material: String = 1..=80,
    }
}

choices! {
    /// How the coat comes onto the gel.
    pub enum CoatBy {
        /// Poured around the gel in a second, wider frame.
        Pour = "pour",
        /// Sprayed, or brushed, when the gel is in place.
        Spray = "spray",
    }
}

parameters! {
    /// The opaque coat on the pad's top and sides.
    pub struct Coat {
        /// Thickness on the top.
        thickness: Length = 0.02..=3.0,
        /// Thickness on the sides.
        side: Length = 0.02..=5.0,
        /// How it is made.
        by: CoatBy,
        /// Trade name.
        material: String = 1..=80,
    }
}

parameters! {
    /// The clear gel between plate and pad, poured into the shell.
    pub struct Bed {
        /// Thickness; 0 for a pad that is glued to the plate itself.
        thickness: Length = 0.0..=30.0,
        /// Trade name.
        material: String = 1..=80,
    }
}

parameters! {
    /// Dots printed on the gel, under the coat: a grid around the middle.
    pub struct Markers {
        /// Dots along x; 0 for none.
        columns: u32 = 0..=60,
        /// Dots along y; 0 for none.
        rows: u32 = 0..=60,
        /// Distance between neighbours.
        spacing: Length = 0.2..=20.0,
        /// Diameter of a dot.
        diameter: Length = 0.1..=5.0,
        /// Thickness of the ink.
        thickness: Length = 0.005..=0.5,
        /// Trade name of the ink.
        material: String = 1..=80,
    }
}

parameters! {
    /// The clear plate that carries the gel; it lies on a ledge in the shell.
    pub struct Plate {
        /// Thickness of the sheet.
        thickness: Length = 1.0..=10.0,
        /// How far the pad reaches over the opening that the plate lies in, on each side.
        overlap: Length = 0.2..=10.0,
        /// Width of the ledge.
        ledge: Length = 0.8..=10.0,
        /// Material.
        material: String = 1..=80,
    }
}

parameters! {
    /// The printed shell: holds plate and light, closes over the camera.
    pub struct Shell {
        /// How far it stands out beyond the pad, at least; a wide camera makes it wider.
        rim: Length = 0.0..=20.0,
        /// Thinnest wall.
        wall: Length = 0.8..=10.0,
        /// Radius of the upright edges.
        corner: Length = 0.2..=20.0,
        /// Width of the notch for cable and wires.
        cable_width: Length = 1.0..=30.0,
        /// Height of the notch.
        cable_height: Length = 1.0..=20.0,
        /// Material.
        material: String = 1..=80,
    }
}

parameters! {
    /// The printed base: carries the camera, closes the shell, is screwed to a gripper.
    pub struct Base {
        /// Thickness of its floor.
        thickness: Length = 1.0..=20.0,
        /// Material.
        material: String = 1..=80,
    }
}

choices! {
    /// Where the light comes from.
    pub enum LightFrom {
        /// LEDs on strips at the shell's walls, below the plate.
        Sides = "sides",
        /// LEDs on a board around the lens.
        Below = "below",
    }
}

parameters! {
    /// The LEDs.
    pub struct Leds {
        /// Where they are.
        from: LightFrom,
        /// From the sides: at how many walls. From below: LEDs in each of the two rows.
        count: u32 = 1..=12,
        /// Length of strip that each LED takes; from below, of its package.
        pitch: Length = 1.0..=40.0,
        /// Width of the strip; from below, of the package.
        width: Length = 0.5..=12.0,
        /// Thickness of strip or board.
        board_thickness: Length = 0.1..=3.2,
        /// Height of the package above strip or board.
        package_height: Length = 0.3..=4.0,
        /// Distance of a strip's upper edge below the plate.
        below_plate: Length = 0.0..=10.0,
        /// Type.
        model: String = 1..=80,
    }
}

parameters! {
    /// The camera and the board it comes on. Its distance follows from the pitch of its pixels.
    pub struct Camera {
        /// Type.
        model: String = 1..=80,
        /// Image width in pixels.
        width_px: u32 = 16..=20000,
        /// Image height in pixels.
        height_px: u32 = 16..=20000,
        /// Frames per second.
        frame_rate: u32 = 1..=10000,
        /// Full angle of view of the lens, over the image's diagonal.
        field_of_view: Angle = 10.0..=220.0,
        /// Distance of neighbouring pixels on the gel under the coat, in the middle, by straight rays.
        pixel_pitch: Length = 0.001..=1.0,
        /// Distance of the optical centre behind the lens's front.
        pupil_behind_front: Length = 0.0..=20.0,
        /// Edge of the square board.
        board_size: Length = 4.0..=60.0,
        /// Thickness of the board.
        board_thickness: Length = 0.4..=3.2,
        /// Distance of the screw holes' centres along an edge.
        screw_spacing: Length = 2.0..=58.0,
        /// Edge of the square lens holder.
        holder_size: Length = 2.0..=40.0,
        /// Height of the lens holder above the board.
        holder_height: Length = 0.5..=30.0,
        /// Diameter of the lens barrel.
        barrel_diameter: Length = 1.0..=40.0,
        /// Height of the lens's front above the board.
        lens_height: Length = 1.0..=60.0,
        /// Room behind the board for connector and cable.
        back_clearance: Length = 1.0..=20.0,
    }
}

parameters! {
    /// A flat-gel sensor.
    pub struct FlatGel {
        /// The pad that touches.
        pad: Pad,
        /// The coat.
        coat: Coat,
        /// The clear gel below the pad.
        bed: Bed,
        /// The printed dots.
        markers: Markers,
        /// The clear plate.
        plate: Plate,
        /// The shell.
        shell: Shell,
        /// The base.
        base: Base,
        /// The LEDs.
        leds: Leds,
        /// The camera.
        camera: Camera,
        /// The molds.
        mold: FrameMold,
    }
}
