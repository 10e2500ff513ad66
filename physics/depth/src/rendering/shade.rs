//! Shading: albedo, light by true normals, hatched cut faces, background.

use fabkit_geometry::Vector3;

use super::framing::Framing;
use super::surface::{CUT_LEAF, VisibleSurface};
use super::{Actor, SectionCut, View};

/// Linear light: red, green, blue, 0 to 1.
pub(super) type Linear = [f32; 3];

/// Colour of the background's top and of the space between images, sRGB.
pub(super) const PAPER: [u8; 3] = [252, 252, 253];
/// Colour of the background's bottom, sRGB.
const PAPER_BELOW: [u8; 3] = [231, 234, 238];
/// Colour of lines, sRGB.
const INK: [u8; 3] = [16, 18, 24];

/// Directions of the lights as (right, up, towards the viewer), and their strengths.
const KEY: ([f64; 3], f64) = ([-0.50, 0.55, 0.67], 0.66);
const FILL: ([f64; 3], f64) = ([0.80, 0.00, 0.60], 0.15);
/// Ambient light from the ground and from the sky.
const AMBIENT: (f64, f64) = (0.24, 0.46);
/// Strength and exponent of the highlight (Blinn, 1977).
const HIGHLIGHT: (f64, i32) = (0.10, 40);

/// Amount of white added to black, in linear light.
const DARK_LIFT: f32 = 0.085;

/// Reach of ambient occlusion as a fraction of the diagonal of the body's box.
const OCCLUSION_REACH: f64 = 0.08;
/// Fraction of the light that full occlusion removes.
const OCCLUSION_STRENGTH: f64 = 0.6;

/// Colour data that all samples share.
#[derive(Clone, Debug)]
pub(super) struct Shader {
    actors: Vec<Paint>,
    /// Section cut, with `outward` of unit length.
    pub cut: Option<SectionCut>,
    key: Vector3<f64>,
    fill: Vector3<f64>,
    halfway: Vector3<f64>,
    height_px: f64,
    paper: [Linear; 2],
    ink: Linear,
}

/// Appearance of one actor.
#[derive(Clone, Debug)]
struct Paint {
    albedo: Linear,
    opacity: f64,
    shelter_reach_mm: f64,
}

impl Paint {
    fn from_actor(actor: &Actor) -> Self {
        let bounds = actor.body.bounds();
        let reach_mm = if bounds.is_empty() { 0.0 } else { (bounds.max - bounds.min).norm() };
        Self {
            albedo: lift_black(linear(actor.color)),
            opacity: actor.opacity,
            shelter_reach_mm: OCCLUSION_REACH * reach_mm,
        }
    }
}

impl Shader {
    /// Prepares lights and paints for a valid `view`.
    pub fn new(actors: &[Actor], framing: &Framing, view: &View) -> Self {
        let towards = -framing.forward;
        let in_scene = |[right, up, near]: [f64; 3]| {
            (framing.right * right + framing.up * up + towards * near).normalize()
        };
        let key = in_scene(KEY.0);
        Self {
            actors: actors.iter().map(Paint::from_actor).collect(),
            cut: view.cut.map(|cut| SectionCut { outward: cut.outward.normalize(), ..cut }),
            key,
            fill: in_scene(FILL.0),
            halfway: (key + towards).normalize(),
            height_px: f64::from(view.height_px),
            paper: [linear(PAPER), linear(PAPER_BELOW)],
            ink: linear(INK),
        }
    }

    pub fn opacity(&self, actor: u32) -> f64 {
        self.actors[actor as usize].opacity
    }

    /// Opacity of a surface at a viewing direction. A cut face is opaque; a clear one is more opaque at a glancing
    /// angle, as glass is.
    pub fn surface_opacity(&self, surface: &VisibleSurface, direction: &Vector3<f64>) -> f64 {
        let opacity = self.opacity(surface.actor);
        if surface.leaf == CUT_LEAF || opacity == 1.0 {
            return 1.0;
        }
        let glancing = 1.0 - surface.normal.dot(direction).abs().min(1.0);
        opacity + (1.0 - opacity) * 0.6 * glancing.powi(3)
    }

    /// Strength of lines on an unobstructed surface.
    pub fn line_strength(&self, surface: &VisibleSurface) -> f64 {
        let opacity = self.opacity(surface.actor);
        if surface.leaf == CUT_LEAF { 1.0 } else { 0.3 + 0.7 * opacity * opacity }
    }

    /// Reach of ambient occlusion on a surface, mm; `None` for flatly lit or translucent surfaces.
    pub fn occlusion_reach_mm(&self, surface: &VisibleSurface) -> Option<f64> {
        let paint = &self.actors[surface.actor as usize];
        let is_plain = surface.leaf == CUT_LEAF || paint.opacity < 1.0;
        (!is_plain).then_some(paint.shelter_reach_mm)
    }

    /// Returns the background colour of a row.
    pub fn background(&self, y_px: f64) -> Linear {
        mix(self.paper[0], self.paper[1], (y_px / self.height_px) as f32)
    }

    /// Draws a line over a colour.
    pub fn blend_ink(&self, color: Linear, strength: f32) -> Linear {
        mix(color, self.ink, strength)
    }

    /// Computes the light from a surface at a position in the image. `shelter` is 0 for an open surface and up to 1
    /// where something stands close in front of it.
    pub fn shade(&self, surface: &VisibleSurface, shelter: f64, x_px: f64, y_px: f64) -> Linear {
        let albedo = self.actors[surface.actor as usize].albedo;
        if surface.leaf == CUT_LEAF {
            return self.hatched(albedo, surface.actor, x_px, y_px);
        }
        let n = &surface.normal;
        let lambert = |light: &Vector3<f64>| n.dot(light).max(0.0);
        // Hemispherical ambient light: 0 from the ground, 1 from the sky.
        let sky = 0.5 + 0.5 * n.z;
        let light = AMBIENT.0
            + (AMBIENT.1 - AMBIENT.0) * sky
            + KEY.1 * lambert(&self.key)
            + FILL.1 * lambert(&self.fill);
        let highlight = HIGHLIGHT.0 * lambert(&self.halfway).powi(HIGHLIGHT.1);
        let open = 1.0 - OCCLUSION_STRENGTH * shelter * shelter;
        albedo.map(|channel| (open * (f64::from(channel) * light + highlight)) as f32)
    }

    /// Shades a cut face as on a technical drawing: flat, lighter, hatched at 45 degrees, neighbours the other way
    /// round (ISO 128-3).
    fn hatched(&self, albedo: Linear, actor: u32, x_px: f64, y_px: f64) -> Linear {
        // Pitch and direction alternate, so that neighbouring bodies differ.
        let pitch_px = (self.height_px / 70.0).max(6.0) * if actor % 4 < 2 { 1.0 } else { 0.7 };
        let along = if actor.is_multiple_of(2) { x_px + y_px } else { x_px - y_px };
        let phase_px = (along * std::f64::consts::FRAC_1_SQRT_2).rem_euclid(pitch_px);
        let half_width_px = 0.06 * pitch_px;
        // Coverage of a box one pixel wide around the sample.
        let covered = (half_width_px + 0.5 - (phase_px - pitch_px / 2.0).abs()).clamp(0.0, 1.0);
        let covered = covered.min(2.0 * half_width_px);
        let flat = mix(albedo, [1.0; 3], 0.35);
        mix(flat, mix(albedo, self.ink, 0.6), 0.75 * covered as f32)
    }
}

/// Lifts black to dark grey: on black, neither shade nor lines would show.
fn lift_black(albedo: Linear) -> Linear {
    // Luminance of linear sRGB (ITU-R BT.709).
    let luminance = 0.2126 * albedo[0] + 0.7152 * albedo[1] + 0.0722 * albedo[2];
    mix(albedo, [1.0; 3], DARK_LIFT * (1.0 - luminance).powi(4))
}

/// Interpolates: `a` where `weight` is 0, `b` where it is 1.
pub(super) fn mix(a: Linear, b: Linear, weight: f32) -> Linear {
    std::array::from_fn(|i| a[i] + weight * (b[i] - a[i]))
}

/// Returns `color` plus `weight` times `other`.
pub(super) fn add(color: Linear, other: Linear, weight: f32) -> Linear {
    std::array::from_fn(|i| color[i] + weight * other[i])
}

/// Converts sRGB to linear light (IEC 61966-2-1).
pub(super) fn linear(srgb: [u8; 3]) -> Linear {
    srgb.map(|channel| {
        let v = f32::from(channel) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    })
}

/// Converts linear light to sRGB (IEC 61966-2-1).
pub(super) fn srgb(color: Linear) -> [u8; 3] {
    color.map(|channel| {
        let v = channel.clamp(0.0, 1.0);
        let v = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (255.0 * v).round() as u8
    })
}
