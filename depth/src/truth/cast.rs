//! Casting: the reference surface once per camera, pressers once per press.

use fabkit_geometry::{
    Body, InvalidSolid, Point3, Pose, Ray, Scratch, Solid, TouchSurface, Vector3,
};
use rayon::prelude::*;

use super::PixelRays;
use super::ball::Ball;
use super::inside::Inside;
use super::map::{DepthMap, NO_LABEL, SURFACE_LABEL};
use super::tiles::Tile;

/// A crossing nearer than this to where a ray starts is that start itself, mm.
pub(super) const START_MM: f64 = 1e-9;

/// A rigid body that is pressed into the surface.
#[derive(Clone, Debug)]
pub struct Presser {
    /// For the list of labels, for example `protrusion 3`.
    pub name: String,
    /// Its shape.
    body: Body,
    sensor_from_body: Pose,
    body_from_sensor: Pose,
    /// Around it, sensor frame; `None` where nothing is.
    ball: Option<Ball>,
}

impl Presser {
    /// A solid in its place.
    ///
    /// # Errors
    /// A solid that is none.
    pub fn new(
        name: impl Into<String>,
        solid: &Solid,
        sensor_from_body: Pose,
    ) -> Result<Self, InvalidSolid> {
        let body = Body::new(solid)?;
        let ball = Ball::around(&body.bounds(), &sensor_from_body);
        let body_from_sensor = sensor_from_body.inverse();
        Ok(Self { name: name.into(), body, sensor_from_body, body_from_sensor, ball })
    }

    /// Whether a point of the sensor frame lies inside.
    pub fn contains(&self, point_in_sensor: &Point3<f64>) -> bool {
        self.body.contains(&self.body_from_sensor.point(*point_in_sensor))
    }

    /// Where a ray first enters, with the normal out of the presser in the sensor frame.
    fn entry(&self, ray: &Ray, scratch: &mut Scratch) -> Option<(f64, Vector3<f64>)> {
        let ray_in_body = Ray {
            origin: self.body_from_sensor.point(ray.origin),
            direction: self.body_from_sensor.vector(ray.direction),
        };
        let crossing = self.body.first_crossing(&ray_in_body, START_MM, true, scratch)?;
        Some((crossing.t, self.sensor_from_body.vector(crossing.normal)))
    }
}

/// The sensing surface as one camera sees it without contact.
#[derive(Clone, Debug)]
pub struct Surface<'a> {
    rays: &'a PixelRays,
    /// Row by row; `NaN` where the surface is not seen.
    range_mm: Vec<f64>,
    normal: Vec<Vector3<f64>>,
}

impl<'a> Surface<'a> {
    /// Casts every ray against the touch surface of a sensor.
    ///
    /// # Errors
    /// Dimensions that make no solid.
    pub fn cast(touch: &TouchSurface, rays: &'a PixelRays) -> Result<Self, InvalidSolid> {
        let inside = Inside::new(touch)?;
        let width = rays.width_px() as usize;
        let mut range_mm = vec![f64::NAN; rays.len()];
        let mut normal = vec![Vector3::repeat(f64::NAN); rays.len()];
        range_mm.par_chunks_mut(width).zip(normal.par_chunks_mut(width)).enumerate().for_each_init(
            Scratch::default,
            |scratch, (row, (range_mm, normal))| {
                for column in 0..width {
                    let Some(ray) = rays.ray(row * width + column) else { continue };
                    if let Some((range, outward)) = inside.exit(&ray, scratch) {
                        (range_mm[column], normal[column]) = (range, outward);
                    }
                }
            },
        );
        Ok(Self { rays, range_mm, normal })
    }

    /// The rays it was cast with.
    pub fn rays(&self) -> &'a PixelRays {
        self.rays
    }

    /// Range of the surface at a pixel, mm; `NaN` where it is not seen.
    pub fn range_mm(&self) -> &[f64] {
        &self.range_mm
    }

    /// Unit normals out of the gel, sensor frame; `NaN` where the surface is not seen.
    pub fn normal_in_sensor(&self) -> &[Vector3<f64>] {
        &self.normal
    }

    /// How many pixels see the surface.
    pub fn seen(&self) -> usize {
        self.range_mm.iter().filter(|range| range.is_finite()).count()
    }

    /// The map without contact.
    pub fn untouched(&self) -> DepthMap<'_> {
        let seen = |range: &f64| if range.is_finite() { SURFACE_LABEL } else { NO_LABEL };
        DepthMap {
            surface: self,
            range_mm: self.range_mm.clone(),
            label: self.range_mm.iter().map(seen).collect(),
            names: vec!["none".into(), "surface".into()],
            moved: Vec::new(),
        }
    }

    /// The map with pressers, whose labels follow [`SURFACE_LABEL`] in their order.
    ///
    /// The nearest presser wins; where two are equally near, the first in the list.
    pub fn pressed(&self, pressers: &[Presser]) -> DepthMap<'_> {
        let mut map = self.untouched();
        map.names.extend(pressers.iter().map(|presser| presser.name.clone()));
        let hits: Vec<Vec<Touched>> = self
            .rays
            .tiles()
            .par_iter()
            .map_init(Scratch::default, |scratch, tile| self.press_tile(tile, pressers, scratch))
            .collect();
        map.moved.reserve_exact(hits.iter().map(Vec::len).sum());
        for Touched { pixel, range_mm, normal, label } in hits.into_iter().flatten() {
            (map.range_mm[pixel], map.label[pixel]) = (range_mm, label);
            map.moved.push((pixel as u32, normal));
        }
        map
    }

    fn press_tile(&self, tile: &Tile, pressers: &[Presser], scratch: &mut Scratch) -> Vec<Touched> {
        let balls = (SURFACE_LABEL + 1..).zip(pressers).filter_map(|(l, p)| Some((l, p, p.ball?)));
        let near: Vec<_> = balls.filter(|(_, _, ball)| tile.may_meet(ball)).collect();
        let mut touched = Vec::new();
        if near.is_empty() {
            return touched;
        }
        for pixel in tile.pixels(self.rays.width_px()) {
            let Some(ray) = self.rays.ray(pixel) else { continue };
            let mut nearest_mm = self.range_mm[pixel];
            let mut first = None;
            for (label, presser, ball) in &near {
                // Where the surface is not seen, nearest is NaN and nothing is nearer.
                if ball.may_meet(&ray)
                    && let Some((range_mm, normal)) = presser.entry(&ray, scratch)
                    && range_mm < nearest_mm
                {
                    nearest_mm = range_mm;
                    // Out of the gel is into the presser.
                    first = Some(Touched { pixel, range_mm, normal: -normal, label: *label });
                }
            }
            touched.extend(first);
        }
        touched
    }
}

/// A pixel that sees a presser.
struct Touched {
    pixel: usize,
    range_mm: f64,
    normal: Vector3<f64>,
    label: u16,
}
