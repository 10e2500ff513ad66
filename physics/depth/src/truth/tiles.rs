//! Square tiles of an image, each with a cone around its rays: which pressers can it see?

use fabkit_geometry::{Point3, Ray, Vector3};
use rayon::prelude::*;

use super::PixelRays;
use super::ball::Ball;

/// Edge of a tile, px. Smaller tiles have tighter cones, larger ones fewer of them to test.
pub(super) const TILE_PX: u32 = 16;

/// Cones are widened by this much, rad: rounding must not hide anything.
const SLACK_RAD: f64 = 1e-9;

/// A tile of an image.
#[derive(Clone, Debug)]
pub(super) struct Tile {
    columns: [u32; 2],
    rows: [u32; 2],
    /// Every ray starts within `spread_mm` of here.
    origin: Point3<f64>,
    spread_mm: f64,
    axis: Vector3<f64>,
    /// Of the largest angle between the axis and a ray.
    cosine: f64,
    sine: f64,
}

/// All tiles, row by row; those without any ray are left out.
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
            // Across the unit sphere, which tells small angles better than their cosine.
            let chord = (ray.direction - axis).norm_squared();
            [largest[0].max(spread), largest[1].max(chord)]
        };
        let [spread, chord] = own().fold([0.0f64; 2], farthest);
        let half_angle_rad = 2.0 * (0.5 * chord.sqrt()).min(1.0).asin() + SLACK_RAD;
        let (sine, cosine) = half_angle_rad.sin_cos();
        Some(Self { columns, rows, origin, spread_mm: spread.sqrt(), axis, cosine, sine })
    }

    /// The tile's pixels as places in the list of all.
    pub(super) fn pixels(&self, width_px: u32) -> impl Iterator<Item = usize> + use<> {
        pixels(self.columns, self.rows, width_px)
    }

    /// Whether any ray may meet the ball; `true` too often costs time, `false` too often a hit.
    pub(super) fn may_meet(&self, ball: &Ball) -> bool {
        // A ray from elsewhere within the spread sees the ball as one from the middle sees a ball
        // that is larger by the spread.
        let radius_mm = ball.radius_mm + self.spread_mm;
        let towards = ball.centre - self.origin;
        let distance_squared = towards.norm_squared();
        if distance_squared.is_nan() || distance_squared <= radius_mm * radius_mm {
            return true;
        }
        // From the cone's side to the ball's centre, across the side; a centre behind the cone
        // passes for one before it.
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
