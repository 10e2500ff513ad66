//! Where things are: every edge and height that more than one body needs, derived once.

use fabkit_geometry::Process;

use super::bodies::{BASE, SHELL};
use super::parameters::FlatGel;
use crate::blocks::Rect;
use crate::blocks::chamber_light::Light;
use crate::blocks::clamshell::Clamshell;
use crate::blocks::posted_camera::Posted;
use crate::fits::Fit;

/// Refractive index of acrylic; gel has less, so that this underestimates what is seen.
const PLATE_INDEX: f64 = 1.49;

/// Edges and heights in the sensor frame, mm. z = 0 is the pad's foot, the upper rim of the shell.
#[derive(Clone, Debug)]
pub struct Layout<'a> {
    /// The pad with its coat.
    pub pad: Rect,
    /// The pad's gel.
    pub gel: Rect,
    /// The opening that plate and bed lie in.
    pub opening: Rect,
    /// The plate.
    pub plate: Rect,
    /// The pad's top.
    pub top_z_mm: f64,
    /// The gel under the coat: what the camera sees.
    pub seen_z_mm: f64,
    /// Top of the plate.
    pub plate_top_z_mm: f64,
    /// Bottom of the plate.
    pub plate_bottom_z_mm: f64,
    /// The camera.
    pub camera: Posted<'a>,
    /// Shell and base.
    pub housing: Clamshell<'a>,
    /// The chamber below the plate's ledge, and its light.
    pub light: Light<'a>,
}

impl<'a> Layout<'a> {
    /// Derives the layout; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &'a FlatGel) -> Self {
        let gap_mm = |part, fit| p.making.gap_mm(part, Process::Fdm, fit);
        let slide = gap_mm(SHELL, Fit::Slide);
        let half = [p.pad.length, p.pad.width].map(|edge| edge.mm() / 2.0);
        let pad = Rect { half, corner: p.pad.corner.mm() };
        let side = p.coat.side.mm();
        let gel = Rect { corner: p.pad.corner.mm() - side, ..pad.shrunk(side) };
        let opening = pad.shrunk(p.plate.overlap.mm());

        let (top_z_mm, plate_top_z_mm) = (p.pad.thickness.mm(), -p.bed.thickness.mm());
        let seen_z_mm = top_z_mm - p.coat.thickness.mm();
        let plate_bottom_z_mm = plate_top_z_mm - p.plate.thickness.mm();
        let camera = p.camera.before(seen_z_mm, gap_mm(BASE, Fit::Slide));

        let chamber = opening.half.map(|half| half - p.plate.ledge.mm());
        // The camera comes in from below; what it needs, the room below the chamber has.
        let board = p.camera.board_mm().map(|edge| edge / 2.0 + slide);
        let room = [0, 1].map(|i| (chamber[i] + p.leds.step_mm()).max(board[i]));
        let sections = (&p.shell, &p.base, &p.mount);
        let play = [slide, gap_mm(BASE, Fit::Snug)];
        let housing = Clamshell::around(sections, play, half, room, camera.foot_z);
        let light = Light {
            leds: &p.leds,
            chamber: Rect { half: chamber, ..housing.room },
            room: housing.room,
            ceiling_z: plate_bottom_z_mm,
            camera: camera.clone(),
            slide_mm: slide,
        };
        Self {
            pad,
            gel,
            opening,
            plate: opening.shrunk(slide),
            top_z_mm,
            seen_z_mm,
            plate_top_z_mm,
            plate_bottom_z_mm,
            camera,
            housing,
            light,
        }
    }

    /// How far from the middle the camera sees the gel under the coat, along x and y, mm: up to the
    /// gel's edge, its picture's edge, the plate's ledge or the LEDs, through plate and gel.
    pub fn seen_mm(&self) -> [f64; 2] {
        let camera = self.camera.camera;
        let px = camera.pictures.size_px().map(f64::from);
        let (air, inside) =
            (self.plate_bottom_z_mm - self.camera.pupil_z, self.seen_z_mm - self.plate_bottom_z_mm);
        let light = &self.light;
        [0, 1].map(|axis| {
            // The picture's long side lies along the pad's.
            let px = if (axis == self.pad.longer()) == (px[0] >= px[1]) { px[0] } else { px[1] };
            let ledge = light.chamber.half[axis];
            let mut slope = (px / 2.0 * camera.rad_per_px()).min(1.5).tan().min(ledge / air);
            if light.leds.out_mm() > 0.0 {
                let above = light.strip_top_z() - self.camera.pupil_z;
                slope = slope.min((ledge - light.leds.out_mm()) / above);
            }
            let n2 = PLATE_INDEX.powi(2);
            let bent = inside * slope / (n2 + (n2 - 1.0) * slope.powi(2)).sqrt();
            (air * slope + bent).min(self.gel.half[axis])
        })
    }
}
