//! Small cameras on rectangular boards: the parts that the cameras of several families share.

use fabkit_geometry::{Body, Length, Order, Solid};

use super::optics::{ImageFormat, Module, View};
use super::{CAMERA, CAMERA_GREEN, INTO_MM};
use crate::hardware::ThreadedLens;
use crate::parameters;

parameters! {
    /// Board and lens of a small camera, in its section `camera`.
    pub struct Board {
        /// Distance of the optical centre behind the lens's front.
        pupil_behind_front: Length = 0.0..=20.0,
        /// Edge of the camera board along x.
        board_size: Length = 4.0..=60.0,
        /// Edge of the camera board along y.
        board_size_y: Length = 4.0..=60.0,
        /// Thickness of the camera board.
        board_thickness: Length = 0.4..=3.2,
        /// Distance between the centres of the board's screw holes along x.
        screw_spacing: Length = 2.0..=58.0,
        /// Distance between the centres of the board's screw holes along y.
        screw_spacing_y: Length = 2.0..=58.0,
        /// Edge of the square lens holder.
        holder_size: Length = 2.0..=40.0,
        /// Height of the lens holder above the camera board.
        holder_height: Length = 0.5..=30.0,
        /// Diameter of the lens barrel.
        barrel_diameter: Length = 1.0..=40.0,
        /// Height of the lens's front above the camera board.
        lens_height: Length = 1.0..=60.0,
    }
}

/// Creates a [`BoardCamera`] from the parameters of a family's section `camera`.
macro_rules! board_camera {
    ($camera:expr) => {{
        let camera = &$camera;
        $crate::blocks::BoardCamera {
            board: [camera.board_size, camera.board_size_y],
            thickness: camera.board_thickness,
            holder: camera.holder_size,
            holder_height: camera.holder_height,
            barrel: camera.barrel_diameter,
            lens_height: camera.lens_height,
        }
    }};
}
pub(crate) use board_camera;

impl Board {
    /// Returns the camera as a bought body, its board between two heights (mm), with `holes` for screws and a plug
    /// behind it.
    pub fn bought(
        &self,
        (module, images, view): (&Module, &ImageFormat, &View),
        heights: [f64; 2],
        holes: Vec<Solid>,
        plug: Solid,
    ) -> Body {
        let [x, y] = [self.board_size, self.board_size_y].map(Length::mm);
        let (model, view) = (&module.model, view.field_of_view);
        let text = format!("{model}, {images}, {view} lens, board {x} x {y} mm");
        let camera = board_camera!(self);
        CAMERA
            .bought(text, camera.solid(heights, holes, plug), [])
            .with_order(Order::new(model, ""))
            .with_quantity(1)
            .with_tool_access(camera.lens(heights[1]).front_access())
            .colored(CAMERA_GREEN)
    }
}

/// Board with a lens holder and a barrel on it.
pub struct BoardCamera {
    /// Edges of the board along x and y.
    pub board: [Length; 2],
    /// Thickness of the board.
    pub thickness: Length,
    /// Edge of the square lens holder.
    pub holder: Length,
    /// Height of the lens holder above the board.
    pub holder_height: Length,
    /// Diameter of the barrel.
    pub barrel: Length,
    /// Height of the lens's front above the board.
    pub lens_height: Length,
}

impl BoardCamera {
    /// Returns the lens of a camera whose board has its upper face at a height, mm.
    pub fn lens(&self, board_top_z: f64) -> ThreadedLens {
        ThreadedLens { barrel_mm: self.barrel.mm(), front_z: board_top_z + self.lens_height.mm() }
    }

    /// Returns the solid of the camera, looking along +z, its board between two heights (mm), with `holes` for screws
    /// and a plug behind it.
    pub fn solid(&self, [bottom, top]: [f64; 2], holes: Vec<Solid>, plug: Solid) -> Solid {
        let ([x, y], holder) = (self.board.map(Length::mm), self.holder.mm());
        let holder_height = self.holder_height.mm();
        let plate = Solid::cuboid(x, y, self.thickness.mm()).at_z(bottom).minus_all(holes);
        let holder = Solid::cuboid(holder, holder, holder_height + INTO_MM).at_z(top - INTO_MM);
        let length = self.lens_height.mm() - holder_height + INTO_MM;
        let barrel = Solid::cylinder(self.barrel.mm() / 2.0, length);
        Solid::union([
            plate,
            holder.named("lens holder"),
            barrel.at_z(top + holder_height - INTO_MM).named("lens barrel"),
            plug,
        ])
    }
}
