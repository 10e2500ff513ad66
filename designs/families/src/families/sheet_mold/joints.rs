//! The screws of the sensor and of its molds: each joint is stated here, and nowhere else.

use fabkit_geometry::Pose;

use super::layout::{Layout, camera_board_top_mm};
use super::parameters::SheetMold;
use crate::blocks::{Joint, corners, hanging, upright};
use crate::hardware::{HexNut, Screw};

/// What holds every stack of sheets in its corners; the molds borrow the sensor's screws.
pub const CORNER: (Screw, HexNut) = (Screw::M3X12, HexNut::M3);

/// What holds the cameras.
pub const CAMERA: (Screw, HexNut) = (Screw::M2X12, HexNut::M2);

/// All joints.
pub struct Joints {
    /// Through the mold of the channel layer, and that of the marker layer.
    pub stacks: [Joint; 2],
    /// Down and up into the spacers of the box, corner by corner.
    pub housing: Joint,
    /// Up and down into the spacers on the display, corner by corner, in its frame.
    pub display: Joint,
    /// Through plate, spacers and board, in the camera's frame: origin on the plate that carries
    /// it, z axis along the line of sight.
    pub camera: Joint,
}

impl Joints {
    /// Where they are; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &SheetMold, layout: &Layout) -> Self {
        let (screw, nut) = CORNER;
        let (sheet, floor) = (p.housing.sheet.mm(), p.molds.floor.mm());
        let all = |at: [[f64; 2]; 4], pose: &dyn Fn([f64; 2]) -> Pose| at.map(pose).to_vec();
        let stack = |bottom_z: f64, top_z: f64| {
            let [heads, nuts] = [
                all(layout.bolts(), &|at| hanging(at, bottom_z)),
                all(layout.bolts(), &|at| upright(at, top_z)),
            ];
            Joint::nutted("bolt", screw, heads, (nut, nuts))
        };
        let clamp_z = layout.bond_z_mm + p.housing.clamp.mm();
        let housing =
            layout.bolts().map(|at| [upright(at, clamp_z), hanging(at, layout.bottom_z_mm)]);
        let stand_z = layout.stand_z_mm + sheet;
        let display = layout.display_bolts(p).map(|at| [hanging(at, 0.0), upright(at, stand_z)]);
        let holes =
            corners([p.camera.hole_spacing, p.camera.hole_spacing_y].map(|edge| edge.mm() / 2.0));
        let nuts = all(holes, &|at| upright(at, camera_board_top_mm(p)));
        Self {
            stacks: [
                stack(layout.bond_z_mm - floor, layout.touch_z_mm),
                stack(layout.marker_end_z_mm - floor, layout.bond_z_mm),
            ],
            housing: Joint::in_threads("corner screw", screw, housing.concat()),
            display: Joint::in_threads("corner screw", screw, display.concat()),
            camera: Joint::nutted(
                "camera screw",
                CAMERA.0,
                all(holes, &|at| hanging(at, -sheet)),
                (CAMERA.1, nuts),
            ),
        }
    }
}
