//! Sample of one ray: the surfaces that it sees from front to back, and their blended colour.

use fabkit_geometry::{Crossing, Ray, Vector3};

use super::SectionCut;
use super::framing::Framing;
use super::pen::Pen;
use super::shade::{Linear, Shader, add};
use super::surface::{CUT_LEAF, VisibleSurface};
use crate::{Scene, SceneScratch};

/// Distance below which surfaces count as touching, mm; the earlier actor is then in front, whatever rounding prefers.
const TOUCHING_MM: f64 = 1e-6;

/// Thickness below which the remainder of a body between two crossings is ignored, mm.
const THINNEST_MM: f64 = 1e-9;

/// Transmitted light below which surfaces behind are ignored.
const LEAST_LIGHT: f64 = 0.02;

/// Distance, as a fraction of the reach, below which hits are ignored: a surface does not occlude itself.
const MIN_OCCLUSION_DISTANCE: f64 = 1e-4;

/// Result of one ray; its surfaces are stored in the [`Tracer`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    first: u32,
    end: u32,
    pub color: Linear,
}

/// Data that all samples of an image share.
pub(super) struct Setup<'a> {
    pub scene: Scene<'a>,
    /// Opaque bodies of the scene: clear ones do not cast ambient occlusion.
    pub occluders: Scene<'a>,
    pub framing: Framing,
    pub shader: Shader,
    pub pen: Pen,
}

/// Traces samples and stores their surfaces in one growing list.
pub(super) struct Tracer<'a> {
    scene: &'a Scene<'a>,
    shelters: &'a Scene<'a>,
    pub framing: &'a Framing,
    shader: &'a Shader,
    scratch: SceneScratch,
    seen: Vec<VisibleSurface>,
    surfaces: Vec<VisibleSurface>,
}

impl<'a> Tracer<'a> {
    pub fn new(setup: &'a Setup<'a>) -> Self {
        let Setup { scene, occluders: shelters, framing, shader, pen: _ } = setup;
        let (scratch, seen, surfaces) = Default::default();
        Self { scene, shelters, framing, shader, scratch, seen, surfaces }
    }

    pub fn surfaces(&self, sample: &Sample) -> &[VisibleSurface] {
        &self.surfaces[sample.first as usize..sample.end as usize]
    }

    /// Returns whether anything is visible at a position in the image, px.
    pub fn meets(&mut self, x_px: f64, y_px: f64) -> bool {
        self.surfaces.clear();
        let sample = self.trace(x_px, y_px);
        !self.surfaces(&sample).is_empty()
    }

    /// Traces a ray through a position in the image, px.
    pub fn trace(&mut self, x_px: f64, y_px: f64) -> Sample {
        let Self { scene, shelters, framing, shader, scratch, seen, surfaces } = self;
        let ray = framing.ray(x_px, y_px);
        let kept = UncutInterval::from_cut(shader.cut.as_ref(), &ray);
        seen.clear();
        let mut nearest_opaque = f64::INFINITY;
        scene.visit_crossings(&ray, scratch, |actor, crossings| {
            let opacity = shader.opacity(actor);
            if opacity == 0.0 {
                return nearest_opaque;
            }
            // Crossings alternate, so the next one after an entry is the matching exit.
            for (index, entering) in crossings.iter().enumerate().filter(|(_, c)| c.entering) {
                // The remainder of a body after the cut must have some thickness.
                let leaving_t = crossings.get(index + 1).map_or(f64::INFINITY, |c| c.t);
                let Some(surface) = kept.surface(actor, entering, leaving_t, &ray) else {
                    continue;
                };
                seen.push(surface);
                if opacity == 1.0 || surface.leaf == CUT_LEAF {
                    // Nothing behind an opaque surface is visible.
                    nearest_opaque = nearest_opaque.min(surface.t);
                    break;
                }
            }
            nearest_opaque
        });
        front_to_back(seen);

        let first = surfaces.len() as u32;
        let mut color = [0.0; 3];
        let mut light = 1.0;
        for surface in seen.iter_mut() {
            let opacity = shader.surface_opacity(surface, &ray.direction);
            surface.line_weight = light * shader.line_strength(surface);
            let shelter = match shader.occlusion_reach_mm(surface) {
                Some(reach_mm) => {
                    compute_occlusion(shelters, surface, reach_mm, shader.cut.as_ref(), scratch)
                }
                None => 0.0,
            };
            let shade = shader.shade(surface, shelter, x_px, y_px);
            color = add(color, shade, (light * opacity) as f32);
            light *= 1.0 - opacity;
            surfaces.push(*surface);
            if light < LEAST_LIGHT {
                break;
            }
        }
        let color = add(color, shader.background(y_px), light as f32);
        Sample { first, end: surfaces.len() as u32, color }
    }
}

/// Computes how close something stands in front of a surface: 1 at no distance, 0 at `reach_mm` or more.
///
/// One ray along the normal is a coarse stand-in for ambient occlusion, but it has no noise, costs no more than the
/// sample itself, and darkens what should look deep: holes, slots and gaps.
fn compute_occlusion(
    shelters: &Scene<'_>,
    surface: &VisibleSurface,
    reach_mm: f64,
    cut: Option<&SectionCut>,
    scratch: &mut SceneScratch,
) -> f64 {
    let ray = Ray { origin: surface.point, direction: surface.normal };
    let range = MIN_OCCLUSION_DISTANCE * reach_mm..reach_mm;
    let Some(hit) = shelters.first_hit(&ray, range, scratch) else { return 0.0 };
    let t = hit.crossing.t;
    let is_cut_away = |cut: &SectionCut| cut.excess_mm(&ray.at(t)) > 0.0;
    if cut.is_some_and(is_cut_away) { 0.0 } else { 1.0 - t / reach_mm }
}

/// Interval of a ray that the cut leaves.
struct UncutInterval {
    from_t: f64,
    to_t: f64,
    /// Normal of the cut face at `from_t`.
    outward: Vector3<f64>,
}

impl UncutInterval {
    /// Clips a ray by the cut.
    fn from_cut(cut: Option<&SectionCut>, ray: &Ray) -> Self {
        let (mut from_t, mut to_t) = (f64::NEG_INFINITY, f64::INFINITY);
        let Some(cut) = cut else { return Self { from_t, to_t, outward: Vector3::zeros() } };
        let excess_mm = cut.excess_mm(&ray.origin);
        let slope = ray.direction.dot(&cut.outward);
        if slope < 0.0 {
            from_t = excess_mm / -slope;
        } else if slope > 0.0 {
            to_t = -excess_mm / slope;
        } else if excess_mm > 0.0 {
            to_t = f64::NEG_INFINITY;
        }
        Self { from_t, to_t, outward: cut.outward }
    }

    /// Returns the front surface of a body that the ray is in between two crossings; `None` if the cut removes it.
    fn surface(
        &self,
        actor: u32,
        entering: &Crossing,
        leaving_t: f64,
        ray: &Ray,
    ) -> Option<VisibleSurface> {
        let t = entering.t.max(self.from_t);
        if leaving_t.min(self.to_t) - t < THINNEST_MM {
            return None;
        }
        // The body began before the cut, so the ray enters it through the cut face.
        let (normal, leaf, face) = if entering.t < self.from_t {
            (self.outward, CUT_LEAF, 0)
        } else {
            (entering.normal, entering.leaf, entering.face)
        };
        let point = ray.at(t);
        Some(VisibleSurface { t, point, normal, actor, leaf, face, line_weight: 0.0 })
    }
}

/// Sorts surfaces from front to back by insertion: the lists are short, and "touching" is not an order that a general
/// sort would accept.
fn front_to_back(surfaces: &mut [VisibleSurface]) {
    let before = |a: &VisibleSurface, b: &VisibleSurface| {
        if (a.t - b.t).abs() <= TOUCHING_MM { a.actor < b.actor } else { a.t < b.t }
    };
    for end in 1..surfaces.len() {
        let mut at = end;
        while at > 0 && before(&surfaces[at], &surfaces[at - 1]) {
            surfaces.swap(at, at - 1);
            at -= 1;
        }
    }
}
