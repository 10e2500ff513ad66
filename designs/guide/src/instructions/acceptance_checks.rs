//! Checks after a step, with numbers that are measured on the bodies in their places.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use fabkit_checks::{Movement, PlacedBody, Stage};
use fabkit_geometry::{
    Aabb, Action, Body, BodyKind, CompiledSolid, Point3, Pose, Ray, Scratch, Sensor, Step, Vector3,
};
use rayon::prelude::*;

use crate::StepMix;
use crate::extent::extent;

/// Smallest difference that is visible without a gauge, mm.
const FLUSH_MM: f64 = 0.05;

/// Distance of bounding boxes below which bodies count as touching, mm.
const TOUCHING_MM: f64 = 0.1;

/// Distances from a body at which the face around it is sampled, mm; chosen: farther than the gap of a fit, not farther
/// than a wall.
const BESIDE_MM: [f64; 3] = [0.2, 0.5, 1.0];

/// Number of sampled points around a body.
const AROUND: u32 = 180;

/// Larger than any height of a rim, mm.
const FAR_MM: f64 = 1e6;

/// Maximum number of checks: more are not read.
const MOST: usize = 6;

/// Compiled solids of all bodies of the stages.
pub(super) struct StageMeasurements<'a> {
    solids: BTreeMap<&'a str, CompiledSolid>,
}

impl<'a> StageMeasurements<'a> {
    /// Compiles the solids of all bodies, in parallel.
    pub(super) fn new(stages: &'a [Stage<'a>]) -> Self {
        let all = stages.iter().flat_map(|stage| stage.before.iter().chain(&stage.after));
        let bodies: BTreeMap<&str, &Body> =
            all.map(|stand| (stand.body.name.as_str(), stand.body)).collect();
        let prepared = bodies.into_par_iter().filter_map(|(name, body)| {
            // Bodies with an invalid solid appear in no stage.
            Some((name, CompiledSolid::new(&body.solid).ok()?))
        });
        Self { solids: prepared.collect() }
    }

    /// Returns the extent of a placed body along a direction of the assembly, mm.
    fn extent(&self, stand: &PlacedBody, along: &Vector3<f64>) -> Option<[f64; 2]> {
        let solid = self.solids.get(stand.body.name.as_str())?;
        let pose: &Pose = &stand.assembly_from_body;
        let shift = pose.translation_mm().dot(along);
        let ends = extent(solid, &pose.inverse().vector(*along).normalize())?;
        Some(ends.map(|end| end + shift))
    }

    /// Returns the dimensions along the axes of the assembly, mm.
    fn size_mm(&self, stand: &PlacedBody) -> Option<[f64; 3]> {
        let along =
            |axis| self.extent(stand, &Vector3::ith(axis, 1.0)).map(|[low, high]| high - low);
        Some([along(0)?, along(1)?, along(2)?])
    }

    /// Returns the checks after a step, at most [`MOST`].
    pub(super) fn checks(
        &self,
        sensor: &Sensor,
        step: &Step,
        stage: Option<&Stage>,
        mix: Option<&StepMix>,
    ) -> Vec<String> {
        let mut said = Vec::new();
        if step.action == Action::Make {
            let parts = sensor
                .parts()
                .filter(|part| step.bodies.is_empty() || step.bodies.contains(&part.name));
            let count: u32 = parts.map(|part| part.quantity).sum();
            said.push(format!("{count} pieces are made, each of the size in the table of parts"));
        }
        if let Some(mix) = mix {
            let total_g: f64 = mix.components.iter().map(|c| c.mass_g).sum();
            let takes_g = total_g / (1.0 + mix.waste);
            said.push(format!(
                "the cup holds {total_g:.2} g; {} takes {takes_g:.2} g of it",
                mix.layer
            ));
        }
        if let Some(stage) = stage {
            match &step.action {
                Action::Pour(pour) => {
                    said.extend(self.level(&pour.layer, &pour.walls, &pour.up, stage))
                }
                Action::Demold(_) => said.extend(self.demolded_sizes(sensor, step, stage)),
                _ => {}
            }
            said.extend(self.seats(stage));
            said.extend(press_fit_checks(sensor, stage));
        }
        said.truncate(MOST);
        said
    }

    /// Returns a check of the liquid's level against the rim of a wall.
    fn level(
        &self,
        layer: &str,
        walls: &[String],
        up: &Vector3<f64>,
        stage: &Stage,
    ) -> Option<String> {
        let top = |stand: &PlacedBody| self.extent(stand, up).map(|[_, high]| high);
        let liquid = stage.after.iter().find(|stand| stand.body.name == layer)?;
        let rims = stage.before.iter().chain(stage.coming.iter().flat_map(|came| &came.bodies));
        let rims = rims.filter(|stand| walls.contains(&stand.body.name));
        let liquid_mm = top(liquid)?;
        let rims = rims.filter_map(|stand| Some((stand.body.name.as_str(), top(stand)?)));
        // The reference is the rim closest above the liquid, since eyes compare with that one; otherwise the closest
        // rim below it. Of two alike, the first counts.
        let over = |rim: f64| match rim - liquid_mm {
            below_mm if below_mm > -FLUSH_MM => below_mm.abs(),
            above_mm => FAR_MM - above_mm,
        };
        let (wall, rim) = rims.fold(None, |most: Option<(&str, f64)>, next| match most {
            Some(most) if over(most.1) <= over(next.1) => Some(most),
            _ => Some(next),
        })?;
        let below_mm = rim - liquid_mm;
        Some(if below_mm.abs() < FLUSH_MM {
            format!("{layer} stands level with the top of {wall}")
        } else if below_mm > 0.0 {
            format!("{layer} ends {below_mm:.1} mm below the top of {wall}")
        } else {
            format!("{layer} ends {:.1} mm above the top of {wall}", -below_mm)
        })
    }

    /// Returns checks of the dimensions of cast bodies after demolding.
    fn demolded_sizes(&self, sensor: &Sensor, step: &Step, stage: &Stage) -> Vec<String> {
        let here = |layer: &str| {
            sensor.chain.iter().any(|other| {
                let is_poured = matches!(&other.action, Action::Pour(pour) if pour.layer == layer);
                is_poured && other.assembly == step.assembly
            })
        };
        let cast = stage.after.iter().filter(|stand| stand.body.kind == BodyKind::Cast);
        let cast = cast.filter(|stand| here(&stand.body.name));
        let told = |stand: &PlacedBody| {
            let [x, y, z] = self.size_mm(stand)?;
            Some(format!(
                "{} measures {x:.1} × {y:.1} × {z:.1} mm, without bubbles",
                stand.body.name
            ))
        };
        cast.filter_map(told).collect()
    }

    /// Returns checks of the seats: how far inserted bodies end from the face around them.
    fn seats(&self, stage: &Stage) -> Vec<String> {
        let mut counts: Vec<(String, String, usize)> = Vec::new();
        self.collect_seats(&stage.coming, stage.before.clone(), &mut counts);
        let told = counts.into_iter().map(|(name, rest, count)| match count {
            1 => format!("{name} {rest}"),
            count => format!("each of {count} {name} {rest}"),
        });
        told.collect()
    }

    /// Counts equal seats of arriving bodies, subassemblies first.
    fn collect_seats<'s>(
        &self,
        coming: &[Movement<'s>],
        mut standing: Vec<PlacedBody<'s>>,
        counts: &mut Vec<(String, String, usize)>,
    ) {
        for came in coming {
            self.collect_seats(&came.parts, Vec::new(), counts);
            // Of bodies that arrive together, the made part is checked, which the others sit on.
            let largest = came.bodies.iter().find(|stand| stand.body.is_made());
            if let (Some(out), Some(stand)) =
                (came.removal_direction, largest.or(came.bodies.first()))
                && let Some(beside) = self.find_seat_body(stand, &out, &standing)
                && let (Some([_, end]), Some(face)) =
                    (self.extent(stand, &out), self.face(beside, stand, &out))
            {
                let (name, on) = (&stand.body.name, &beside.body.name);
                let out_mm = end - face;
                let rest = if out_mm.abs() < FLUSH_MM {
                    format!("ends flush with {on} around it")
                } else if out_mm > 0.0 {
                    format!("stands {out_mm:.1} mm out of {on} around it")
                } else {
                    format!("ends {:.1} mm deep in {on}", -out_mm)
                };
                match counts.iter_mut().find(|(known, told, _)| known == name && *told == rest) {
                    Some((.., count)) => *count += 1,
                    None => counts.push((name.clone(), rest, 1)),
                }
            }
            standing.extend(&came.bodies);
        }
    }

    /// Returns the height of the face of `body` just beside `around`, along a direction, mm.
    fn face(&self, body: &PlacedBody, around: &PlacedBody, out: &Vector3<f64>) -> Option<f64> {
        let solid = self.solids.get(body.body.name.as_str())?;
        let inner = self.solids.get(around.body.name.as_str())?;
        let inner = moved_box(&inner.bounds(), &around.assembly_from_body);
        let [u, v] = across(out);
        let [[u0, u1], [v0, v1]] = [box_extent(&inner, &u), box_extent(&inner, &v)];
        // Rays start behind the body.
        let back = self.extent(body, out)?[0] - 1.0;
        let pose = body.assembly_from_body.inverse();
        let (mut scratch, mut stretches) = (Scratch::default(), Vec::new());
        let mut ends: Vec<f64> = Vec::new();
        for beyond in BESIDE_MM {
            let middle = [0.5 * (u0 + u1), 0.5 * (v0 + v1)];
            let half = [0.5 * (u1 - u0) + beyond, 0.5 * (v1 - v0) + beyond];
            for index in 0..AROUND {
                // Along an ellipse through the centres of the box's sides, so that the samples follow round bodies.
                let (sin, cos) = (TAU * f64::from(index) / f64::from(AROUND)).sin_cos();
                let place = u * (middle[0] + half[0] * cos) + v * (middle[1] + half[1] * sin);
                let origin = Point3::from(place + out * back);
                let ray = Ray { origin: pose.point(origin), direction: pose.vector(*out) };
                solid.stretches_into(&ray, &mut scratch, &mut stretches);
                // The last surface along a ray is the outer face.
                ends.extend(stretches.last().map(|[_, leave]| back + leave));
            }
        }
        // The median ignores a wall or a rib that rises on one side.
        ends.sort_by(f64::total_cmp);
        ends.get(ends.len() / 2).copied()
    }

    /// Finds the body that another one is inserted into or placed on: among those it touches, the smallest one that
    /// covers its outline, otherwise the largest.
    fn find_seat_body<'s>(
        &self,
        stand: &PlacedBody,
        out: &Vector3<f64>,
        standing: &'s [PlacedBody<'s>],
    ) -> Option<&'s PlacedBody<'s>> {
        let bounds = |stand: &PlacedBody| {
            let solid = self.solids.get(stand.body.name.as_str())?;
            Some(moved_box(&solid.bounds(), &stand.assembly_from_body))
        };
        let own = bounds(stand)?;
        let near = own.grown(TOUCHING_MM);
        let [u, v] = across(out);
        let is_within = |other: &Aabb| {
            [u, v].iter().all(|w| {
                let ([a, b], [c, d]) = (box_extent(&own, w), box_extent(other, w));
                c - TOUCHING_MM <= a && b <= d + TOUCHING_MM
            })
        };
        // Order: bodies that cover the outline, then made parts, then the smallest (or the largest, if they do not
        // cover it).
        let rank = |other: &Aabb, body: &Body| {
            let volume: f64 = other.size_mm().iter().product();
            let holds = is_within(other);
            (holds, body.is_made(), if holds { -volume } else { volume })
        };
        let touching = standing.iter().filter_map(|other| {
            let of = bounds(other).filter(|of| !near.common(of).is_empty())?;
            Some((other, rank(&of, other.body)))
        });
        let best = touching.fold(None, |best: Option<(&PlacedBody, _)>, next| match best {
            Some(best) if best.1 >= next.1 => Some(best),
            _ => Some(next),
        });
        best.map(|(other, _)| other)
    }
}

/// Returns two unit vectors perpendicular to a direction and to each other.
fn across(along: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let aside = if along.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
    let u = along.cross(&aside).normalize();
    [u, along.cross(&u)]
}

/// Returns the extent of a box along a unit vector.
fn box_extent(bounds: &Aabb, along: &Vector3<f64>) -> [f64; 2] {
    let half = 0.5 * along.abs().dot(&(bounds.max - bounds.min));
    let middle = along.dot(&bounds.centre().coords);
    [middle - half, middle + half]
}

/// Returns the axis-aligned box around a moved box.
fn moved_box(bounds: &Aabb, pose: &Pose) -> Aabb {
    let half = pose.rotation().abs() * (0.5 * (bounds.max - bounds.min));
    let centre = pose.point(bounds.centre());
    Aabb { min: centre - half, max: centre + half }
}

/// Returns checks of press fits, with their interference.
fn press_fit_checks(sensor: &Sensor, stage: &Stage) -> Vec<String> {
    let comes = |name: &str| {
        let mut bodies = stage.coming.iter().flat_map(|came| &came.bodies);
        bodies.any(|stand| stand.body.name == name)
    };
    let stands = |name: &str| stage.after.iter().any(|stand| stand.body.name == name);
    let is_meant = |body: &str| sensor.body(body).is_some_and(Body::is_made);
    let fits = sensor.press_fits.iter().filter(|fit| {
        (comes(&fit.inner) || comes(&fit.outer)) && stands(&fit.inner) && stands(&fit.outer)
    });
    // Threads are left out: they hold by cutting into the plastic.
    let fits = fits.filter(|fit| is_meant(&fit.inner) && is_meant(&fit.outer));
    let told = fits.map(|fit| {
        format!(
            "{} sits tight in {}: drawn {:.2} mm per side too large for it",
            fit.inner, fit.outer, fit.interference_mm
        )
    });
    told.collect()
}
