//! A sensor's soft layers, ready to be pressed by the bodies of fixtures.

use std::f64::consts::PI;

use fabkit_elastic::{Outcome, Place, Press, SoftError, SoftStack, SolidPresser, Stack};
use fabkit_fixtures::PressBody;
use fabkit_geometry::{CompiledSolid, Point3, Sensor, SurfacePoints, TouchSurface, Vector3};

use super::PressingError;
use super::contact::deepest_place;

/// Nodes of a dome's surface for a first look, about: a press takes some milliseconds.
const COARSE_NODES: f64 = 5000.0;
/// The most nodes of a surface that nobody asked for: its setup takes some seconds.
const MOST_NODES: f64 = 25_000.0;
/// Nothing that is pressed is thinner, mm.
const LEAST_LOOK_MM: f64 = 0.1;
/// Nodes across a contact, from its middle to its edge, about.
const ACROSS_CONTACT: f64 = 8.0;
/// A pad is looked at finely up to this many times the contact's radius.
const AROUND_CONTACT: f64 = 2.5;
/// Harmonics of the azimuth around a single contact in the middle of what is looked at.
const HARMONICS_OF_ONE: usize = 24;
/// Limits of the distance of nodes, mm.
const SPACING_LIMITS_MM: [f64; 2] = [0.01, 5.0];

/// Layers whose answers to tractions are known.
#[derive(Debug)]
pub struct Ready {
    /// What gives way.
    pub soft: SoftStack,
    /// The same, solved.
    pub stack: Stack,
    /// Distance of the surface's nodes, mm.
    pub spacing_mm: f64,
}

impl Ready {
    /// For one press: with nodes as fine as its contact asks for, or `spacing_mm` apart.
    ///
    /// # Errors
    /// Nothing soft, a distance of nodes that is none, what the solver says.
    pub fn for_press(
        sensor: &Sensor,
        bodies: &[PressBody],
        spacing_mm: Option<f64>,
        threads: usize,
    ) -> Result<Self, PressingError> {
        check_spacing(spacing_mm)?;
        let touch = touch(sensor)?;
        let points = SurfacePoints::new(touch).map_err(SoftError::Solid)?;
        if bodies.len() > 1 {
            return Self::for_all(sensor, spacing_mm, false, threads);
        }
        let place = deepest_place(touch, bodies)?;
        let new = |soft: SoftStack, spacing_mm: f64| {
            let reach_mm = AROUND_CONTACT * ACROSS_CONTACT * spacing_mm;
            let stack = soft.stack(spacing_mm, reach_mm, HARMONICS_OF_ONE, threads)?;
            Ok::<_, PressingError>(Self { soft, stack, spacing_mm })
        };
        let soft = stack_of(sensor, touch, &points, &place)?;
        if let Some(spacing_mm) = spacing_mm {
            return new(soft, spacing_mm);
        }
        // A coarse press tells how wide the contact is.
        let (coarse_mm, finest_mm) = match touch {
            TouchSurface::Dome(_) => {
                let apart_mm = |nodes: f64| (points.area_mm2() / nodes).sqrt();
                (apart_mm(COARSE_NODES), apart_mm(MOST_NODES))
            }
            // A ball of 4 mm touches a circle of radius sqrt(2 r d).
            TouchSurface::Plane(_) => {
                let depth_mm = deepest_mm(touch, bodies)?.max(0.01);
                ((8.0 * depth_mm).sqrt() / 4.0, 0.0)
            }
        };
        let (mut coarse, mut coarse_mm) = (new(soft, coarse_mm)?, coarse_mm);
        let contact_mm = loop {
            match coarse.press(bodies, &Press::in_place()) {
                Ok(found) => break found.contact_radius_mm,
                // It slips between nodes, as a pin does: so fine until it does not.
                Err(error) if error.is_too_coarse() && coarse_mm > finest_mm.max(LEAST_LOOK_MM) => {
                    coarse_mm = (0.5 * coarse_mm).max(finest_mm);
                    coarse = new(coarse.soft, coarse_mm)?;
                }
                Err(error) => return Err(error),
            }
        };
        let fine_mm = (contact_mm / ACROSS_CONTACT).clamp(finest_mm, coarse_mm);
        if fine_mm == coarse_mm { Ok(coarse) } else { new(coarse.soft, fine_mm) }
    }

    /// For presses anywhere: nodes as fine as a few seconds allow, or `spacing_mm` apart. Presses that then move along
    /// the surface, `is_dragged`, are solved for as well: three times the work.
    ///
    /// # Errors
    /// As for one press.
    pub fn for_all(
        sensor: &Sensor,
        spacing_mm: Option<f64>,
        is_dragged: bool,
        threads: usize,
    ) -> Result<Self, PressingError> {
        check_spacing(spacing_mm)?;
        let touch = touch(sensor)?;
        let points = SurfacePoints::new(touch).map_err(SoftError::Solid)?;
        let (place, reach_mm, area_mm2) = middle(&points);
        let soft = stack_of(sensor, touch, &points, &place)?;
        let spacing_mm = spacing_mm.unwrap_or((area_mm2 / MOST_NODES).sqrt());
        let stack = soft.stack(spacing_mm, reach_mm, usize::MAX, threads)?;
        let stack = stack.everywhere(is_dragged).map_err(SoftError::from)?;
        Ok(Self { soft, stack, spacing_mm })
    }

    /// Presses bodies in, all at once.
    ///
    /// # Errors
    /// No contact, one that is deeper than the layers or does not converge.
    pub fn press(&self, bodies: &[PressBody], how: &Press) -> Result<Outcome, PressingError> {
        let solids = bodies.iter().map(|body| CompiledSolid::new(&body.solid));
        let solids = solids.collect::<Result<Vec<_>, _>>().map_err(SoftError::Solid)?;
        let stack_from_sensor = self.soft.sensor_from_stack.inverse();
        let pressers: Vec<SolidPresser> = solids
            .iter()
            .zip(bodies)
            .map(|(solid, body)| {
                SolidPresser::new(solid, &stack_from_sensor.then_in(body.sensor_from_body))
            })
            .collect();
        Ok(self.stack.press(&pressers, how)?)
    }
}

/// The layers below a place, divided where the camera follows marks.
pub(super) fn stack_of(
    sensor: &Sensor,
    touch: &TouchSurface,
    points: &SurfacePoints,
    place: &Place,
) -> Result<SoftStack, SoftError> {
    let mut soft = SoftStack::of(sensor, points, place)?;
    soft.divide_at_marks(touch, &sensor.marks);
    Ok(soft)
}

/// The surface that is pressed.
pub(super) fn touch(sensor: &Sensor) -> Result<&TouchSurface, PressingError> {
    let stiff = || SoftError::Stiff { sensor: sensor.name.clone() };
    Ok(sensor.touch.as_ref().ok_or_else(stiff)?)
}

/// What a stack for all presses is centred on, how far it reaches, mm, and the area within, mm2.
fn middle(points: &SurfacePoints) -> (Place, f64, f64) {
    match points {
        // Of a dome all is looked at.
        SurfacePoints::Dome(_) => ((Point3::origin(), Vector3::z()), 0.0, points.area_mm2()),
        SurfacePoints::Plane(face) => {
            let [x, y] = face.bounds_mm();
            let centre = [x, y].map(|[least, most]| f64::midpoint(least, most));
            let reach_mm = 0.5 * (x[1] - x[0]).hypot(y[1] - y[0]);
            let z_mm = face.at(centre).map_or(0.0, |(point, _)| point.z);
            let point = Point3::new(centre[0], centre[1], z_mm);
            ((point, Vector3::z()), reach_mm, PI * reach_mm * reach_mm)
        }
    }
}

fn deepest_mm(touch: &TouchSurface, bodies: &[PressBody]) -> Result<f64, PressingError> {
    let mut deepest_mm = 0.0;
    for body in bodies {
        let found = crate::ground_truth::penetration(touch, body).map_err(SoftError::Solid)?;
        deepest_mm = found.map_or(deepest_mm, |found| found.depth_mm.max(deepest_mm));
    }
    Ok(deepest_mm)
}

fn check_spacing(spacing_mm: Option<f64>) -> Result<(), PressingError> {
    let [least, most] = SPACING_LIMITS_MM;
    match spacing_mm.filter(|mm| !(least..=most).contains(mm)) {
        None => Ok(()),
        Some(mm) => Err(PressingError::Range {
            what: "spacing",
            value: format!("{mm} mm"),
            limit: format!("{least} mm to {most} mm"),
        }),
    }
}
