//! Square tiles of an image, each with a cone around its rays, to reject indenters quickly.

use fabkit_geometry::{Point3, Ray, Vector3};
use rayon::prelude::*;

use super::PixelRays;
use super::ball::BoundingBall;

/// Edge of a tile, px. Smaller tiles have tighter cones, larger ones need fewer tests.
pub(super) const TILE_PX: u32 = 16;

/// Widening of the cones, rad, so that rounding hides nothing.
const SLACK_RAD: f64 = 1e-9;

/// A tile of an image with the cone that holds its rays.
#[derive(Clone, Debug)]
pub(super) struct Tile {
    columns: [u32; 2],
    rows: [u32; 2],
    /// Centre of the ray origins, all of which lie within `spread_mm` of it.
    origin: Point3<f64>,
    spread_mm: f64,
    axis: Vector3<f64>,
    /// Cosine of the largest angle between the axis and a ray.
    cosine: f64,
    sine: f64,
}

/// Creates all tiles, row by row; tiles without any ray are left out.
pub(super) fn tiles(rays: &PixelRays) -> Vec<Tile> {
    let (width, height) = (rays.width_px(), rays.height_px());
    let starts = |length: u32| (0..length).step_by(TILE_PX as usize);
    let corners: Vec<[u32; 2]> =
        starts(height).flat_map(|top| starts(width).map(move |left| [left, top])).collect();
    let tile = |[left, top]: [u32; 2]| {
        let columns = [left, (left + TILE_PX).min(width)];
        let rows = [top, (top + TILE_PX).min(height)];
        Tile::new(rays, columns, rows)
    };
    corners.into_par_iter().filter_map(tile).collect()
}

impl Tile {
    /// Bounds the rays of a tile by a cone; `None` for a tile without rays.
    fn new(rays: &PixelRays, columns: [u32; 2], rows: [u32; 2]) -> Option<Self> {
        let width = rays.width_px();
        let own = || pixels(columns, rows, width).filter_map(|pixel| rays.ray(pixel));
        let (mut count, mut origins, mut directions) = (0.0, Vector3::zeros(), Vector3::zeros());
        for ray in own() {
            count += 1.0;
            origins += ray.origin.coords;
            directions += ray.direction;
        }
        if count == 0.0 {
            return None;
        }
        let (origin, axis) = (Point3::from(origins / count), directions.normalize());
        let farthest = |largest: [f64; 2], ray: Ray| {
            let spread = (ray.origin - origin).norm_squared();
            // The chord on the unit sphere resolves small angles better than their cosine.
            let chord = (ray.direction - axis).norm_squared();
            [largest[0].max(spread), largest[1].max(chord)]
        };
        let [spread, chord] = own().fold([0.0f64; 2], farthest);
        let half_angle_rad = 2.0 * (0.5 * chord.sqrt()).min(1.0).asin() + SLACK_RAD;
        let (sine, cosine) = half_angle_rad.sin_cos();
        Some(Self { columns, rows, origin, spread_mm: spread.sqrt(), axis, cosine, sine })
    }

    /// Returns the indices of the tile's pixels.
    pub(super) fn pixels(&self, width_px: u32) -> impl Iterator<Item = usize> + use<> {
        pixels(self.columns, self.rows, width_px)
    }

    /// Returns whether any ray may meet the ball. A false positive costs time, a false negative would lose a hit.
    pub(super) fn may_meet(&self, ball: &BoundingBall) -> bool {
        // A ray that starts within the spread misses the ball if one from the centre misses a ball larger by the
        // spread.
        let radius_mm = ball.radius_mm + self.spread_mm;
        let towards = ball.centre - self.origin;
        let distance_squared = towards.norm_squared();
        if distance_squared.is_nan() || distance_squared <= radius_mm * radius_mm {
            return true;
        }
        // Distance of the ball's centre from the cone's side. A centre behind the apex is treated as if in front.
        let along = towards.dot(&self.axis);
        let across = towards.cross(&self.axis).norm();
        across * self.cosine - along * self.sine <= radius_mm
    }
}

fn pixels(columns: [u32; 2], rows: [u32; 2], width_px: u32) -> impl Iterator<Item = usize> {
    let place = move |row: u32, column: u32| row as usize * width_px as usize + column as usize;
    (rows[0]..rows[1])
        .flat_map(move |row| (columns[0]..columns[1]).map(move |column| place(row, column)))
}
