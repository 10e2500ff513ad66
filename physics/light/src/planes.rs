//! Refraction of direct light by level plates between a light source and a layer.

use fabkit_geometry::{Point3, Ray, Sensor, Vector3};
use fabkit_optics::{InvalidStack, OpticalStack, Tracer};

/// Maximum inclination of a level face, sine.
const MAX_INCLINATION: f64 = 1e-6;
/// Maximum difference in height of one face along different lines, mm.
const HEIGHT_TOLERANCE_MM: f64 = 1e-6;
/// Bisection steps by which the refracted path is found; the result is exact to rounding.
const BISECTIONS: u32 = 60;

/// Level faces between media, from the camera to the layer of interest.
///
/// ```
/// use fabkit_geometry::Point3;
/// use fabkit_light::Planes;
///
/// // Gel of index 1.41 from z = 4 mm on; the lamp is in the air below.
/// let gel = Planes::new(vec![(4.0, 1.41)]);
/// let found = gel.arrival(&Point3::origin(), &Point3::new(6.0, 0.0, 8.0)).unwrap();
/// // Snell's law: the sine shrinks by the index, at the face.
/// assert!((found.departure_direction.x / found.arrival_direction.x - 1.41).abs() < 1e-9);
/// assert!((found.refraction_points[0].z - 4.0).abs() < 1e-9);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Planes {
    /// Height of each face, mm, and the refractive index above it, from below. Air lies below all of them.
    faces: Vec<(f64, f64)>,
}

/// Arrival of a small light source's light at a point.
///
/// ```
/// use fabkit_geometry::{Point3, Vector3};
/// use fabkit_light::Planes;
///
/// // 3 mm aside and 4 mm up, without any face between: 5 mm of straight light.
/// let found = Planes::default().arrival(&Point3::origin(), &Point3::new(3.0, 0.0, 4.0)).unwrap();
/// assert!((found.arrival_direction - Vector3::new(0.6, 0.0, 0.8)).norm() < 1e-15);
/// assert!((found.density - 1.0 / 25.0).abs() < 1e-15);
/// assert_eq!(found.refraction_points, [Point3::origin(); 2]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Direction in which the light leaves the source, unit.
    pub departure_direction: Vector3<f64>,
    /// Direction in which the light arrives, unit.
    pub arrival_direction: Vector3<f64>,
    /// Irradiance on an area across the light, for a source that emits 1 per unit of solid angle, 1/mm2.
    pub density: f64,
    /// First and last point of refraction, from the source to the point; both at the source if there is none.
    pub refraction_points: [Point3<f64>; 2],
}

impl Planes {
    /// Finds the level faces above a sensor's camera, if they are the same on its axis and beside it. Returns no faces
    /// if any face on the way is not level.
    ///
    /// # Errors
    /// If light cannot be traced through the bodies.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, NominalCamera, Pose};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_geometry::{Assembly, Body, MaterialProperties, OpticalClarity, Placement, Sensor, Solid};
    /// use fabkit_light::Planes;
    ///
    /// // A pane of glass from z = 5 mm to 7 mm: into index 1.5, and back into air.
    /// let mut pane = Body::bought("pane", "glass", Solid::cylinder(20.0, 2.0).at_z(5.0))
    ///     .with_clarity(OpticalClarity::Clear)
    ///     .placed([Placement::in_place(Assembly::sensor())]);
    /// pane.substance = MaterialProperties { refractive_index: Some(1.5), ..MaterialProperties::default() };
    /// let planes = Planes::from_sensor(&Sensor::new("window", "A window", "", camera, [pane]))?;
    /// assert_eq!(planes, Planes::new(vec![(5.0, 1.5), (7.0, 1.0)]));
    /// # Ok::<(), fabkit_optics::InvalidStack>(())
    /// ```
    pub fn from_sensor(sensor: &Sensor) -> Result<Self, InvalidStack> {
        let stack = OpticalStack::from_sensor(sensor)?;
        let mut tracer = Tracer::new(&stack);
        let pupil = sensor.camera.sensor_from_camera.point(Point3::origin());
        let mut faces_at = |x: f64, y: f64| {
            let ray = Ray { origin: pupil + Vector3::new(x, y, 0.0), direction: Vector3::z() };
            tracer.follow(&ray);
            let is_level =
                tracer.bends().iter().all(|bend| bend.normal.xy().norm() < MAX_INCLINATION);
            let faces = tracer.bends().iter().map(|bend| (bend.place.z, bend.indices[1]));
            is_level.then(|| faces.collect::<Vec<_>>())
        };
        // Chosen at different distances and directions from the axis.
        let beside = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.5], [-2.0, 0.5]];
        let all: Option<Vec<_>> = beside.into_iter().map(|[x, y]| faces_at(x, y)).collect();
        let is_same = |a: &[(f64, f64)], b: &[(f64, f64)]| {
            let near = |(a, b): (&(f64, f64), &(f64, f64))| {
                (a.0 - b.0).abs() < HEIGHT_TOLERANCE_MM && a.1 == b.1
            };
            a.len() == b.len() && a.iter().zip(b).all(near)
        };
        Ok(match all.as_deref() {
            Some([first, more @ ..]) if more.iter().all(|other| is_same(first, other)) => {
                Self { faces: first.clone() }
            }
            _ => Self::default(),
        })
    }

    /// Creates planes from heights, mm, and the refractive indices above them, from below.
    pub fn new(faces: Vec<(f64, f64)>) -> Self {
        Self { faces }
    }

    /// Returns whether there are no faces, so that light is not refracted.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Computes the light that arrives from a source. It is refracted at each face by Snell's law, and reduced by the
    /// reflection of each (Fresnel, unpolarised). Returns `None` if none arrives because the point lies below the
    /// source.
    ///
    /// A cone of light from the source widens differently behind each face. The irradiance is the solid angle in which
    /// the light leaves divided by the area on which it arrives.
    pub fn arrival(&self, lamp: &Point3<f64>, place: &Point3<f64>) -> Option<Arrival> {
        let way = place - lamp;
        let across_mm = way.xy().norm();
        // Thickness and refractive index of each crossed layer.
        let mut layers = Vec::with_capacity(self.faces.len() + 1);
        let (mut z, mut index) = (lamp.z, 1.0);
        for &(face, above) in &self.faces {
            // Faces below the source only determine its medium.
            if face <= lamp.z {
                index = above;
            } else if face < place.z {
                layers.push((face - z, index));
                (z, index) = (face, above);
            }
        }
        layers.push((place.z - z, index));
        let (_, first) = layers[0];
        if layers.len() == 1 {
            let distance_mm = way.norm();
            let arrives = way / distance_mm;
            let density = distance_mm.powi(-2);
            let bends = [*lamp; 2];
            return (distance_mm > 0.0).then_some(Arrival {
                departure_direction: arrives,
                arrival_direction: arrives,
                density,
                refraction_points: bends,
            });
        }
        if way.z <= 0.0 {
            return None;
        }
        // The Snell invariant, index times sine, is the same in all layers. The smallest index limits it.
        let most = layers.iter().map(|(_, index)| *index).fold(f64::INFINITY, f64::min);
        // The horizontal distance grows monotonically with the invariant, so bisection finds it.
        let reach = |kept: f64| -> f64 {
            layers
                .iter()
                .map(|(high, index)| high * kept / (index * index - kept * kept).sqrt())
                .sum()
        };
        let (mut low, mut high) = (0.0, most);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            *(if reach(middle) < across_mm { &mut low } else { &mut high }) = middle;
        }
        let kept = 0.5 * (low + high);
        let cosine = |index: f64| (1.0 - (kept / index).powi(2)).sqrt();
        let out = if across_mm > 0.0 { way.xy() / across_mm } else { Vector3::x().xy() };
        let along = |index: f64| {
            let sine = kept / index;
            Vector3::new(sine * out.x, sine * out.y, cosine(index))
        };
        // Derivative of the distance by the invariant: h n^2 / (n^2 - kept^2)^(3/2) for each layer of height h.
        let widens: f64 = layers
            .iter()
            .map(|(high, index)| high * index * index / (index * index - kept * kept).powf(1.5))
            .sum();
        // Solid angle of a ring, sin t dt dphi, over its area, across d(across) dphi, where kept = n sin t. On the axis
        // both vanish, and the limit is used.
        let per_level_area = if across_mm > 1e-9 {
            kept / (first * first * cosine(first) * across_mm * widens)
        } else {
            (first * widens).powi(-2)
        };
        let last = layers[layers.len() - 1].1;
        let mut passes = 1.0;
        for pair in layers.windows(2) {
            passes *= fresnel_transmittance(pair[0].1, pair[1].1, kept);
        }
        let from_below = lamp + along(first) * (layers[0].0 / cosine(first));
        // One face: both points coincide. Several faces: the path between the two points is not returned.
        let arrives = along(last);
        let to_above = place - arrives * (layers[layers.len() - 1].0 / arrives.z);
        Some(Arrival {
            departure_direction: along(first),
            arrival_direction: arrives,
            density: passes * per_level_area / arrives.z,
            refraction_points: [from_below, to_above],
        })
    }
}

/// Computes the transmittance of a face for unpolarised light (Fresnel). `kept` is the Snell invariant.
fn fresnel_transmittance(before: f64, behind: f64, kept: f64) -> f64 {
    let [cos_before, cos_behind] =
        [before, behind].map(|n| (1.0 - (kept / n).powi(2)).max(0.0).sqrt());
    let across =
        (before * cos_before - behind * cos_behind) / (before * cos_before + behind * cos_behind);
    let along =
        (before * cos_behind - behind * cos_before) / (before * cos_behind + behind * cos_before);
    1.0 - 0.5 * (across * across + along * along)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const PLATE: [(f64, f64); 2] = [(1.0, 1.49), (4.0, 1.41)];

    #[test]
    fn light_is_bent_by_snells_law_and_arrives() {
        let planes = Planes::new(PLATE.to_vec());
        let (lamp, place) = (Point3::new(-9.0, 2.0, 0.0), Point3::new(3.0, -1.0, 8.0));
        let found = planes.arrival(&lamp, &place).unwrap();
        // Traced face by face.
        let [mut at, mut way, mut index] =
            [lamp.coords, found.departure_direction, Vector3::repeat(1.0)];
        for (z, above) in PLATE {
            at += way * ((z - at.z) / way.z);
            let sine = way.xy() * (index.x / above);
            way = Vector3::new(sine.x, sine.y, (1.0 - sine.norm_squared()).sqrt());
            index = Vector3::repeat(above);
        }
        at += way * ((8.0 - at.z) / way.z);
        assert!((at - place.coords).norm() < 1e-9, "{at}");
        assert!((way - found.arrival_direction).norm() < 1e-12);
        assert!(
            (found.refraction_points[1].z - 4.0).abs() < 1e-12
                && (found.refraction_points[0].z - 1.0).abs() < 1e-12
        );
    }

    #[test]
    fn energy_is_conserved_except_for_reflections() {
        // All light that leaves within 45 degrees of the vertical arrives on a level above, except for reflections at
        // the faces.
        let planes = Planes::new(PLATE.to_vec());
        let lamp = Point3::origin();
        let edge = |angle: f64| {
            let kept = f64::sin(angle);
            [(1.0, 1.0), (3.0, 1.49), (4.0, 1.41)]
                .iter()
                .map(|(high, n): &(f64, f64)| high * kept / (n * n - kept * kept).sqrt())
                .sum::<f64>()
        };
        let (steps, reach) = (4_000, edge(TAU / 8.0));
        let arrives = |i: i32| {
            let r = reach * (f64::from(i) + 0.5) / f64::from(steps);
            let found = planes.arrival(&lamp, &Point3::new(r, 0.0, 8.0)).unwrap();
            let kept = (1.0 - found.departure_direction.z.powi(2)).sqrt();
            let passed =
                fresnel_transmittance(1.0, 1.49, kept) * fresnel_transmittance(1.49, 1.41, kept);
            found.density * found.arrival_direction.z / passed * TAU * r * reach / f64::from(steps)
        };
        let sum: f64 = (0..steps).map(arrives).sum();
        let sent = TAU * (1.0 - (TAU / 8.0).cos());
        assert!((sum / sent - 1.0).abs() < 1e-5, "{sum} {sent}");
        // At normal incidence, each face between glass and air reflects 4 %.
        assert!((fresnel_transmittance(1.0, 1.5, 0.0) - 0.96).abs() < 1e-12);
    }

    #[test]
    fn without_faces_light_goes_straight() {
        let found =
            Planes::default().arrival(&Point3::origin(), &Point3::new(0.0, 3.0, 4.0)).unwrap();
        assert_eq!(found.departure_direction, found.arrival_direction);
        assert!((found.density - 1.0 / 25.0).abs() < 1e-15);
    }
}
