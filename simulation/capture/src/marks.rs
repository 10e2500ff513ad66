//! Rendering of light markers on a dark background: dots on pins, painted ends of markers.

use std::sync::Arc;

use fabkit_checks::UnknownProperty;
use fabkit_depth::ground_truth::PixelRays;
use fabkit_files::Error;
use fabkit_geometry::{
    CompiledSolid, Lighting, Matrix3, Point3, Ray, Rgb, Scratch, Sensor, Vector3, VisibleEffect,
};
use fabkit_light::Emitters;
use fabkit_optics::{OpticalStack, Tracer, ViewStacks};
use fabkit_scene::SceneError;
use fabkit_scene::ground_truth::Viewpoint;
use fabkit_scene::press_simulation::MarkerDisplacement;
use rayon::prelude::*;

use super::scene::placed_solid;
use super::surfaces::{USUAL_MARK, reflectance, unknown_in_view};
use super::{CameraGain, CaptureError, LightConstants, RenderedLight, displaced_markers};

/// Radius around a marker's visible centre within which its solid lies, in marker radii.
const SOLID_RADII: f64 = 2.5;
/// Spacing of the samples of irradiance on the background, in rays.
const COARSE: usize = 12;
/// Step of the finite differences for the irradiance at markers, mm: as far as markers move. Irradiance is taken as
/// linear over it.
const SLOPE_STEP_MM: f64 = 0.5;
/// Distance within which a ray starts at a marker's face, or two rays at one place, mm: above the rounding of positions,
/// below anything that is drawn.
const TOUCH_MM: f64 = 1e-6;
/// Number of rays along each side of a tile, for which nearby markers are listed together.
const TILE: usize = 16;
/// Intensity of visible light sources: white.
const WHITE_GREY: f64 = 255.0;

/// A sensor in a lighting that shows its markers.
#[derive(Debug)]
pub(super) struct MarkScene<'a> {
    sensor: &'a Sensor,
    /// Name and solid of the body that contains all markers.
    marks: (&'a str, CompiledSolid),
    lamps: Vec<String>,
    emitters: Emitters,
    constants: &'a LightConstants,
    pub(super) exposure: f64,
    pub(super) camera_gain: CameraGain,
    /// View and irradiance, kept where many captures share the same rays.
    kept: Option<RestMarkers>,
}

/// Everything that no press changes.
#[derive(Debug)]
struct RestMarkers {
    view: View,
    /// Markers at rest with the gradient of the irradiance vector at each, 1/mm; empty if irradiance is computed for
    /// each capture.
    at_rest: Vec<(PlacedMarker, Matrix3<f64>)>,
}

/// View of the sensor without its markers, which no press changes.
#[derive(Debug)]
struct View {
    straight: PixelRays,
    /// Rays behind all refracting bodies.
    rays: PixelRays,
    stack: OpticalStack,
    ground: Background,
    /// Length at which each ray ends at or before the background, mm. `None` for a single capture, which needs few of
    /// them.
    ends_mm: Option<Vec<f64>>,
}

impl View {
    /// Returns the length of a ray's last segment, mm; infinity where only background can lie on it.
    fn end_mm(&self, i: usize, tracer: &mut Tracer<'_>) -> f64 {
        let (Some(ray), Some(first)) = (self.rays.ray(i), self.straight.ray(i)) else {
            return f64::INFINITY;
        };
        // 0 and 1 name no body that could lie before a marker.
        if self.rays.seen_by()[i] <= 1 {
            return f64::INFINITY;
        }
        let path = tracer.follow(&first);
        // A ray that ended on an earlier segment has no length on the last one. Both rays are traced by other formulas, so
        // that they start at one place but for rounding.
        let apart_mm = (path.last.origin - ray.origin).norm();
        if apart_mm < TOUCH_MM { path.end_mm } else { f64::INFINITY }
    }
}

/// A marker at its present place and orientation.
#[derive(Clone, Copy, Debug)]
struct PlacedMarker {
    at: Point3<f64>,
    /// Visible centre of the marker at rest.
    at_rest: Point3<f64>,
    /// Rotation from the orientation at rest.
    turn: Matrix3<f64>,
    /// Irradiance vector: sum of the directions of light times its density.
    arrives: Vector3<f64>,
    reach_mm: f64,
}

impl PlacedMarker {
    fn may_meet(&self, ray: &Ray) -> bool {
        let from = self.at - ray.origin;
        let along = from.dot(&ray.direction);
        from.norm_squared() - along * along <= self.reach_mm * self.reach_mm
    }
}

impl<'a> MarkScene<'a> {
    pub(super) fn new(
        sensor: &'a Sensor,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        let missing = || CaptureError::UnknownLighting { sensor: sensor.name.clone() };
        let VisibleEffect::Markers { marks } = &lighting.effect else {
            return Err(missing().into());
        };
        let compiled = placed_solid(sensor.body(marks).ok_or_else(missing)?)?;
        let emitters = Emitters::new(sensor, lighting).map_err(CaptureError::NoLight)?;
        let mut own = Self {
            sensor,
            marks: (marks, compiled),
            lamps: lighting.light_sources.iter().map(|group| group.body.clone()).collect(),
            emitters,
            constants,
            exposure: 1.0,
            camera_gain: CameraGain::new(USUAL_MARK / constants.marks[0].value),
            kept: None,
        };
        let at_rest = own.place_markers(&displaced_markers(sensor, None));
        let facing = sensor.marks.iter().zip(&at_rest);
        // Irradiance on the end of each marker, which faces along its axis.
        let lit = facing.map(|(mark, placed)| -placed.arrives.dot(&mark.axis));
        let brightest = constants.marks[0].value * lit.fold(0.0, f64::max);
        if brightest <= 0.0 {
            return Err(CaptureError::Dark { sensor: sensor.name.clone() }.into());
        }
        own.exposure = own.camera_gain.light_factor() * constants.mark_grey.value / brightest;
        Ok(own)
    }

    pub(super) fn words(&self) -> [String; 2] {
        [
            format!("positions of {} markers", self.sensor.marks.len()),
            self.emitters.description.clone(),
        ]
    }

    /// Returns properties of bodies in the kept view that no source states.
    pub(super) fn unknown_in_view(&self) -> Vec<UnknownProperty> {
        let kept = self.kept.as_ref();
        kept.map_or_else(Vec::new, |kept| {
            unknown_in_view(self.sensor, &kept.view.rays, &self.lamps)
        })
    }

    /// Keeps the view for several captures with the same rays.
    pub(super) fn keep_view(&mut self, viewpoint: &Viewpoint, samples: u32) -> Result<(), Error> {
        self.kept = Some(RestMarkers { view: self.view(viewpoint, samples)?, at_rest: Vec::new() });
        Ok(())
    }

    /// Prepares many captures with the same rays: also tabulates where rays end, and irradiance at markers to first
    /// order.
    pub(super) fn prepare(&mut self, viewpoint: &Viewpoint, samples: u32) -> Result<(), Error> {
        let at_rest = self.place_markers(&displaced_markers(self.sensor, None));
        let mut view = self.view(viewpoint, samples)?;
        let memory = || Tracer::new(&view.stack);
        let end_mm = |tracer: &mut Tracer<'_>, i| view.end_mm(i, tracer);
        let rays = (0..view.rays.len()).into_par_iter();
        view.ends_mm = Some(rays.map_init(memory, end_mm).collect());
        let slope = |tracer: &mut Tracer<'_>, mark: &PlacedMarker| {
            let along = |axis: usize| {
                let mut step = Vector3::zeros();
                step[axis] = SLOPE_STEP_MM;
                let [after, before] =
                    [mark.at + step, mark.at - step].map(|at| self.irradiance_vector(&at, tracer));
                (after - before) / (2.0 * SLOPE_STEP_MM)
            };
            Matrix3::from_columns(&[0, 1, 2].map(along))
        };
        let with_slope = |tracer: &mut Tracer<'_>, mark: PlacedMarker| (mark, slope(tracer, &mark));
        let marks = at_rest.into_par_iter();
        let at_rest = marks.map_init(|| self.emitters.tracer(), with_slope).collect();
        self.kept = Some(RestMarkers { view, at_rest });
        Ok(())
    }

    fn place_markers(&self, marks: &[MarkerDisplacement]) -> Vec<PlacedMarker> {
        let known = marks.par_iter().enumerate();
        let known = known.filter_map(|(i, moved)| Some((i, moved, moved.displacement_mm?)));
        known
            .map_init(
                || self.emitters.tracer(),
                |tracer, (i, moved, by_mm)| {
                    let at = moved.mark.point + by_mm;
                    // All displacements are known at rest, so `at_rest` has the same indices as `marks`.
                    let kept = self.kept.as_ref();
                    let arrives = match kept.and_then(|kept| kept.at_rest.get(i)) {
                        Some((at_rest, slope)) => at_rest.arrives + slope * by_mm,
                        // The place is shifted outwards so that the marker does not shadow itself.
                        None => self.irradiance_vector(&(at + 1e-3 * moved.axis), tracer),
                    };
                    PlacedMarker {
                        at,
                        at_rest: moved.mark.point,
                        turn: smallest_rotation(&moved.mark.axis, &moved.axis),
                        arrives,
                        reach_mm: SOLID_RADII * moved.mark.radius_mm,
                    }
                },
            )
            .collect()
    }

    fn view(&self, viewpoint: &Viewpoint, samples: u32) -> Result<View, Error> {
        let stack = viewpoint.stack(self.sensor).map_err(SceneError::Light)?;
        // Markers are drawn where they have moved to. Where they were, there is what surrounds them.
        let stack = stack.without_body(self.marks.0);
        let sights = Arc::new(ViewStacks::new(stack.clone()));
        let straight = viewpoint.rays(samples);
        let rays = straight.clone().traced_through(&sights);
        let ground = self.background(&straight, &rays, &stack);
        Ok(View { straight, rays, stack, ground, ends_mm: None })
    }

    /// Returns the irradiance vector at a place: the sum of the directions of light times its density.
    fn irradiance_vector(&self, place: &Point3<f64>, tracer: &mut Tracer<'_>) -> Vector3<f64> {
        let pieces = self.emitters.pieces().iter();
        let all = pieces.filter_map(|piece| self.emitters.arrival(piece, place, tracer));
        all.map(|found| found.density * found.arrival_direction).sum()
    }

    pub(super) fn paint(
        &self,
        viewpoint: &Viewpoint,
        samples: u32,
        marks: Vec<MarkerDisplacement>,
    ) -> Result<RenderedLight, Error> {
        let own;
        let view = match &self.kept {
            Some(kept) => &kept.view,
            None => {
                own = self.view(viewpoint, samples)?;
                &own
            }
        };
        let View { rays, stack, ground, .. } = view;
        let placed = self.place_markers(&marks);
        let (width, [light, _]) = (rays.width_px() as usize, &self.constants.marks);
        let bounced = self.constants.bounce.value;
        let mean =
            placed.iter().map(|mark| mark.arrives.norm()).sum::<f64>() / placed.len().max(1) as f64;
        let tiles = Tiles::of(rays, &placed);
        let ray = |(scratch, tracer): &mut (Scratch, Tracer<'_>), i: usize| -> Rgb {
            let behind = ground.at(i, width, bounced * mean) * self.exposure;
            let Some(ray) = rays.ray(i) else { return [self.constants.beside_grey.value; 3] };
            let near = tiles.near(i).iter().map(|mark| &placed[*mark as usize]);
            let Some((at_mm, normal, mark)) = self.first_marker(near, &ray, scratch) else {
                return [behind; 3];
            };
            // A body other than the background may hide the marker.
            let end_mm = match &view.ends_mm {
                Some(known) => known[i],
                None => view.end_mm(i, tracer),
            };
            if end_mm < at_mm {
                return [behind; 3];
            }
            let lit = (-mark.arrives.dot(&normal)).max(0.0) + bounced * mean;
            [self.exposure * light.value * lit; 3]
        };
        let memory = || (Scratch::default(), Tracer::new(stack));
        let light = (0..rays.len()).into_par_iter().map_init(memory, ray).collect();
        let not_known = unknown_in_view(self.sensor, rays, &self.lamps);
        Ok(RenderedLight { light, thickness_mm: Vec::new(), marks, not_known })
    }

    /// Finds the first marker on a ray: distance along the ray, mm, normal there, and the marker.
    fn first_marker<'p>(
        &self,
        placed: impl Iterator<Item = &'p PlacedMarker>,
        ray: &Ray,
        scratch: &mut Scratch,
    ) -> Option<(f64, Vector3<f64>, &'p PlacedMarker)> {
        let mut nearest: Option<(f64, Vector3<f64>, &PlacedMarker)> = None;
        for mark in placed {
            if !mark.may_meet(ray) {
                continue;
            }
            // The ray is transformed to the marker's pose at rest, in which its solid is compiled.
            let back = mark.turn.transpose();
            let origin = mark.at_rest + back * (ray.origin - mark.at);
            let drawn = Ray { origin, direction: back * ray.direction };
            let mut crossings = Vec::new();
            self.marks.1.crossings_into(&drawn, scratch, &mut crossings);
            let is_it = |t: f64| (drawn.at(t) - mark.at_rest).norm() < mark.reach_mm;
            let first = crossings
                .iter()
                .find(|crossing| crossing.entering && crossing.t > -TOUCH_MM && is_it(crossing.t));
            if let Some(first) = first
                && nearest.as_ref().is_none_or(|(t, ..)| first.t < *t)
            {
                nearest = Some((first.t, mark.turn * first.normal, mark));
            }
        }
        nearest
    }

    /// Computes reflectance and irradiance of everything behind the markers.
    fn background(
        &self,
        straight: &PixelRays,
        rays: &PixelRays,
        stack: &OpticalStack,
    ) -> Background {
        let [_, dark] = &self.constants.marks;
        let sends = |name: &String| match self.lamps.contains(name) {
            true => f64::INFINITY,
            // The surface is seen through the layers that the markers stand on, so it counts as background.
            false => reflectance(self.sensor.body(name), dark),
        };
        let sends: Vec<f64> = rays.seen_by_names().iter().map(sends).collect();
        let (width, height) = (rays.width_px() as usize, rays.height_px() as usize);
        let columns = width.div_ceil(COARSE) + 1;
        let rows = height.div_ceil(COARSE) + 1;
        let node = |(of_light, of_camera): &mut (Tracer<'_>, Tracer<'_>), i: usize| {
            let pixel = |k: usize, most: usize| (k * COARSE).min(most - 1);
            let at = pixel(i / columns, height) * width + pixel(i % columns, width);
            let Some(ray) = straight.ray(at) else { return 0.0 };
            let path = of_camera.follow(&ray);
            if !path.end_mm.is_finite() {
                return 0.0;
            }
            // The background is taken to face the camera, since its normal is not known here.
            let place = path.last.at(path.end_mm - 1e-2);
            self.irradiance_vector(&place, of_light).dot(&path.last.direction).max(0.0)
        };
        let memory = || (self.emitters.tracer(), Tracer::new(stack));
        let lit = (0..rows * columns).into_par_iter().map_init(memory, node).collect();
        let sends = rays.seen_by().iter().map(|by| sends[usize::from(*by)]).collect();
        Background { columns, lit, sends }
    }
}

/// Markers that the rays of each tile of the image may meet.
struct Tiles {
    width: usize,
    columns: usize,
    near: Vec<Vec<u32>>,
}

impl Tiles {
    fn of(rays: &PixelRays, placed: &[PlacedMarker]) -> Self {
        let (width, height) = (rays.width_px() as usize, rays.height_px() as usize);
        let (columns, rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let of_tile = |tile: usize| {
            let (row, column) = (tile / columns * TILE, tile % columns * TILE);
            let own = (row..(row + TILE).min(height)).flat_map(|row| {
                (column..(column + TILE).min(width)).map(move |column| row * width + column)
            });
            let own: Vec<Ray> = own.filter_map(|i| rays.ray(i)).collect();
            let meets = |mark: &PlacedMarker| own.iter().any(|ray| mark.may_meet(ray));
            // A ball around the marker, widened by the tile's spread, must reach the middle ray; only then are all rays
            // tested.
            let Some(middle) = own.get(own.len() / 2) else { return Vec::new() };
            let spread = |at_mm: f64| {
                let off = own.iter().map(|ray| (ray.at(at_mm) - middle.at(at_mm)).norm());
                off.fold(0.0, f64::max)
            };
            let nearest = placed.iter().map(|mark| (mark.at - middle.origin).norm());
            let farthest_mm = nearest.fold(0.0, f64::max);
            let spread_mm = spread(0.0).max(spread(farthest_mm));
            let near = placed.iter().enumerate().filter(|(_, mark)| {
                let wide = PlacedMarker { reach_mm: mark.reach_mm + spread_mm, ..**mark };
                wide.may_meet(middle) && meets(mark)
            });
            near.map(|(i, _)| i as u32).collect()
        };
        let near = (0..rows * columns).into_par_iter().map(of_tile).collect();
        Self { width, columns, near }
    }

    fn near(&self, ray: usize) -> &[u32] {
        &self.near[ray / self.width / TILE * self.columns + ray % self.width / TILE]
    }
}

/// Irradiance and reflectance of the background behind the markers.
#[derive(Debug)]
struct Background {
    columns: usize,
    /// Irradiance at every [`COARSE`]-th ray.
    lit: Vec<f64>,
    /// Reflectance at each ray; infinite for visible light sources.
    sends: Vec<f64>,
}

impl Background {
    fn at(&self, ray: usize, width: usize, bounced: f64) -> f64 {
        let sends = self.sends[ray];
        if sends.is_infinite() {
            return WHITE_GREY;
        }
        let [row, column] = [ray / width, ray % width].map(|k| k as f64 / COARSE as f64);
        let (i, j) = (row as usize, column as usize);
        let (by_row, by_column) = (row - i as f64, column - j as f64);
        let lit = |i: usize, j: usize| self.lit[i * self.columns + j];
        let between = (1.0 - by_row) * ((1.0 - by_column) * lit(i, j) + by_column * lit(i, j + 1))
            + by_row * ((1.0 - by_column) * lit(i + 1, j) + by_column * lit(i + 1, j + 1));
        sends * (between + bounced)
    }
}

/// Returns the smallest rotation that takes one unit vector to another (Rodrigues 1840).
fn smallest_rotation(from: &Vector3<f64>, to: &Vector3<f64>) -> Matrix3<f64> {
    let (axis, cosine) = (from.cross(to), from.dot(to));
    let across = axis.cross_matrix();
    // The denominator vanishes only for opposite vectors, and no marker turns over.
    Matrix3::identity() + across + across * across / (1.0 + cosine).max(1e-6)
}
