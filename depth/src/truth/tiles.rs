//! Square tiles of an image, each with a cone around its rays: which pressers can it see?

use fabkit_geometry::{Aabb, Point3, Vector3};

use super::PixelRays;

/// Edge of a tile, px. Smaller tiles have tighter cones, larger ones fewer of them to test.
const TILE_PX: u32 = 16;

/// Angles are widened by this much, rad: rounding must not hide anything.
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
    half_angle_rad: f64,
}

/// All tiles, row by row; those without any ray are left out.
pub(super) fn tiles(rays: &PixelRays) -> Vec<Tile> {
    let (width, height) = (rays.width_px(), rays.height_px());
    let starts = |length: u32| (0..length).step_by(TILE_PX as usize);
    starts(height)
        .flat_map(|top| starts(width).map(move |left| (left, top)))
        .filter_map(|(left, top)| {
            let columns = [left, (left + TILE_PX).min(width)];
            let rows = [top, (top + TILE_PX).min(height)];
            Tile::new(rays, columns, rows)
        })
        .collect()
}

impl Tile {
    fn new(rays: &PixelRays, columns: [u32; 2], rows: [u32; 2]) -> Option<Self> {
        let mut tile = Self {
            columns,
            rows,
            origin: Point3::origin(),
            spread_mm: 0.0,
            axis: Vector3::zeros(),
            half_angle_rad: 0.0,
        };
        let own: Vec<_> =
            tile.pixels(rays.width_px()).filter_map(|pixel| rays.ray(pixel)).collect();
        let count = own.len() as f64;
        if own.is_empty() {
            return None;
        }
        let sum = own.iter().fold(Vector3::zeros(), |sum, ray| sum + ray.origin.coords);
        tile.origin = Point3::from(sum / count);
        tile.axis = own.iter().fold(Vector3::zeros(), |sum, ray| sum + ray.direction).normalize();
        for ray in own {
            tile.spread_mm = tile.spread_mm.max((ray.origin - tile.origin).norm());
            tile.half_angle_rad = tile.half_angle_rad.max(angle(&tile.axis, &ray.direction));
        }
        Some(tile)
    }

    /// The tile's pixels as places in the list of all.
    pub(super) fn pixels(&self, width_px: u32) -> impl Iterator<Item = usize> + use<> {
        let [left, right] = self.columns;
        let place = move |row: u32, column: u32| row as usize * width_px as usize + column as usize;
        (self.rows[0]..self.rows[1])
            .flat_map(move |row| (left..right).map(move |column| place(row, column)))
    }

    /// Whether any ray may meet the box; `true` too often costs time, `false` too often a hit.
    pub(super) fn may_meet(&self, bounds: &Aabb) -> bool {
        if bounds.is_empty() {
            return false;
        }
        let centre = bounds.centre();
        // A ray from elsewhere within the spread sees the box as one from the middle sees a box
        // that is larger by the spread.
        let radius_mm = Vector3::from(bounds.size_mm()).norm() / 2.0 + self.spread_mm;
        let towards = centre - self.origin;
        let distance_mm = towards.norm();
        if distance_mm.is_nan() || distance_mm <= radius_mm {
            return true;
        }
        let own = angle(&self.axis, &(towards / distance_mm));
        own <= self.half_angle_rad + (radius_mm / distance_mm).asin() + SLACK_RAD
    }
}

/// Between unit vectors; exact for small angles too (Kahan, "How futile are mindless assessments of
/// roundoff in floating-point computation?", 2006, section 12).
fn angle(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    2.0 * (a - b).norm().atan2((a + b).norm())
}
