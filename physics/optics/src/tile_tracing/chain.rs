//! Sequence of refracting surfaces of a ray. Neighbouring rays that meet the same surfaces follow it in closed form.

use fabkit_geometry::{Point3, Ray, Vector3};

use super::faces::Faces;
use super::quadric::Surface;
use crate::snell::refract;
use crate::stack::OpticalStack;
use crate::trace::{PieceEnd, TOUCH_TOLERANCE_MM, Tracer};

/// Surfaces of the faces of a stack.
#[derive(Clone, Debug)]
pub(crate) struct FaceSurfaces(Faces);

/// Refracting surfaces of a ray, in order.
#[derive(Clone, Debug)]
pub(crate) struct RefractionSequence {
    bends: Vec<RefractingSurface>,
}

/// One refracting surface.
#[derive(Clone, Debug)]
struct RefractingSurface {
    surface: Surface,
    face: u32,
    grows: bool,
    /// Refractive index before the surface over that behind it.
    ratio: f64,
}

impl FaceSurfaces {
    /// Prepares the surfaces of a stack.
    pub(crate) fn of(stack: &OpticalStack) -> Self {
        Self(Faces::from_items(&stack.items))
    }
}

impl RefractionSequence {
    /// Finds the refracting surfaces of a ray up to a path length of `way_mm`; `None` if one of them has no closed
    /// form.
    pub(crate) fn from_ray(
        tracer: &mut Tracer,
        FaceSurfaces(faces): &FaceSurfaces,
        ray: &Ray,
        way_mm: f64,
    ) -> Option<Self> {
        let (mut line, mut index, mut left_mm) = (*ray, None, way_mm);
        let (mut bends, mut scratch, mut passed) = (Vec::new(), Default::default(), Vec::new());
        loop {
            let event = tracer.trace_piece(&line, &mut index);
            left_mm -= event.at_mm();
            let PieceEnd::Bend { at_mm, normal, to_index, .. } = event else { break };
            if left_mm <= 0.0 {
                break;
            }
            passed.clear();
            for item in tracer.boxes_before(at_mm + TOUCH_TOLERANCE_MM) {
                faces.intersect_item(item, &line, &mut scratch, &mut passed);
            }
            // Faces that touch each other lie in one surface, so any of them that has a closed form will do.
            let there =
                passed.iter().filter(|face| (face.t_mm - at_mm).abs() <= TOUCH_TOLERANCE_MM);
            let face =
                there.map(|passed| passed.face).find(|face| faces.surface(*face).is_some())?;
            let surface = faces.surface(face)?.clone();
            let grows = surface.grows(&line, at_mm);
            // The first piece has determined `index`.
            let ratio = index? / to_index;
            // Total reflection ends the sequence.
            let Some(direction) = refract(&line.direction, &normal, ratio) else { break };
            bends.push(RefractingSurface { surface, face, grows, ratio });
            line = Ray { origin: line.at(at_mm), direction };
            index = Some(to_index);
        }
        Some(Self { bends })
    }

    /// Returns whether both sequences consist of the same faces.
    pub(crate) fn has_same_faces(&self, other: &Self) -> bool {
        let faces = |chain: &Self| chain.bends.iter().map(|bend| bend.face).collect::<Vec<_>>();
        faces(self) == faces(other)
    }

    /// Returns the last straight piece of a ray and the length of those before it, mm; `None` if the ray misses a
    /// surface or is totally reflected.
    pub(crate) fn follow(
        &self,
        pupil: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<(Ray, f64)> {
        let (mut line, mut lead_mm) = (Ray { origin: *pupil, direction: *direction }, 0.0);
        for bend in &self.bends {
            let t_mm = bend.surface.pass_mm(&line, bend.grows);
            if !(t_mm > 0.0 && t_mm.is_finite()) {
                return None;
            }
            let origin = line.at(t_mm);
            let direction = refract(&line.direction, &bend.surface.normal(&origin), bend.ratio)?;
            line = Ray { origin, direction };
            lead_mm += t_mm;
        }
        Some((line, lead_mm))
    }
}
