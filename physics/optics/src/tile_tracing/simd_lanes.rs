//! Operations on blocks of rays, written as loops that compilers vectorize.

use fabkit_geometry::{Aabb, Point3, Pose};

use super::quadric::{Quadric, Surface, ZERO_TOLERANCE};
use super::trim::Room;

/// Number of rays of a block: few enough to stay in the cache, enough for loops to pay.
pub(super) const LANES: usize = 64;

/// One number for each ray of a block.
pub(super) type Lane = [f64; LANES];

/// Coordinates of points or directions, by axis and lane.
pub(super) type Triple = [Lane; 3];

/// Flag for each ray: 0 is false.
pub(super) type Mask = [u64; LANES];

pub(super) const ZERO_TRIPLE: Triple = [[0.0; LANES]; 3];

/// Returns the point in a lane.
pub(super) fn lane_point(points: &Triple, lane: usize) -> Point3<f64> {
    Point3::new(points[0][lane], points[1][lane], points[2][lane])
}

/// Rotates vectors.
pub(super) fn rotate(pose: &Pose, vectors: &Triple) -> Triple {
    let [x, y, z] = vectors;
    let mut turned = ZERO_TRIPLE;
    for (axis, turned) in turned.iter_mut().enumerate() {
        let row = pose.rotation().row(axis);
        let [a, b, c] = [row[0], row[1], row[2]];
        for lane in 0..LANES {
            turned[lane] = a * x[lane] + b * y[lane] + c * z[lane];
        }
    }
    turned
}

/// Transforms points.
pub(super) fn transform(pose: &Pose, points: &Triple) -> Triple {
    let mut moved = rotate(pose, points);
    for (axis, values) in moved.iter_mut().enumerate() {
        let by_mm = pose.translation_mm()[axis];
        values.iter_mut().for_each(|value| *value += by_mm);
    }
    moved
}

/// Computes the points at a distance along rays.
pub(super) fn advance(origin: &Triple, direction: &Triple, t_mm: &Lane, points: &mut Triple) {
    for axis in 0..3 {
        for lane in 0..LANES {
            points[axis][lane] = origin[axis][lane] + t_mm[lane] * direction[axis][lane];
        }
    }
}

/// Computes the distances at which the function grows through zero, and at which it falls. See [`Quadric::pass`], whose
/// two forms are combined here.
pub(super) fn intersect(quadric: &Quadric, origin: &Triple, direction: &Triple) -> [Lane; 2] {
    let Quadric { a, b, l, d } = *quadric;
    let ([px, py, pz], [vx, vy, vz]) = (origin, direction);
    let mut up = [0.0; LANES];
    if quadric.is_flat() {
        for i in 0..LANES {
            let m = l.x * vx[i] + l.y * vy[i] + l.z * vz[i];
            let c = (l.x * px[i] + l.y * py[i] + l.z * pz[i]) + d;
            // A plane is passed only once, where its function grows.
            up[i] = if m > 0.0 { -c / m } else { f64::INFINITY };
        }
        return [up, [f64::NEG_INFINITY; LANES]];
    }
    let mut down = [0.0; LANES];
    for i in 0..LANES {
        let h = a * (vx[i] * vx[i] + vy[i] * vy[i]) + b * vz[i] * vz[i];
        let m = a * (px[i] * vx[i] + py[i] * vy[i])
            + b * pz[i] * vz[i]
            + 0.5 * (l.x * vx[i] + l.y * vy[i] + l.z * vz[i]);
        let c = a * (px[i] * px[i] + py[i] * py[i])
            + b * pz[i] * pz[i]
            + (l.x * px[i] + l.y * py[i] + l.z * pz[i])
            + d;
        let q = (m * m - h * c).sqrt() + m.abs();
        let (near, far) = (c / q, q / h);
        up[i] = if m >= 0.0 { -near } else { far };
        down[i] = if m >= 0.0 { -far } else { near };
    }
    [up, down]
}

/// Computes gradients. See [`Quadric::across`].
pub(super) fn gradients(quadric: &Quadric, points: &Triple) -> Triple {
    let Quadric { a, b, l, .. } = *quadric;
    let mut across = ZERO_TRIPLE;
    for (axis, factor) in [a, a, b].into_iter().enumerate() {
        for lane in 0..LANES {
            across[axis][lane] = 2.0 * factor * points[axis][lane] + l[axis];
        }
    }
    across
}

/// Computes the distance at which a ray that starts on the surface meets it again. There the function is h t^2 +
/// (gradient . direction) t, with one zero at the start.
pub(super) fn second_intersections(quadric: &Quadric, across: &Triple, direction: &Triple) -> Lane {
    let Quadric { a, b, .. } = *quadric;
    let ([gx, gy, gz], [vx, vy, vz]) = (across, direction);
    let mut again_mm = [0.0; LANES];
    for i in 0..LANES {
        let h = a * (vx[i] * vx[i] + vy[i] * vy[i]) + b * vz[i] * vz[i];
        again_mm[i] = -(gx[i] * vx[i] + gy[i] * vy[i] + gz[i] * vz[i]) / h;
    }
    again_mm
}

/// Refracts directions by Snell's law; see [`refract`](crate::refract). Normals need not have unit length.
///
/// Returns the squared cosines behind the surface. Where they are below 0, light is totally reflected.
pub(super) fn refract_lanes(direction: &mut Triple, normal: &Triple, ratio: f64) -> Lane {
    let mut squares = [0.0; LANES];
    let [dx, dy, dz] = direction;
    let [nx, ny, nz] = normal;
    for i in 0..LANES {
        let per_length = 1.0 / (nx[i] * nx[i] + ny[i] * ny[i] + nz[i] * nz[i]).sqrt();
        let [x, y, z] = [nx[i] * per_length, ny[i] * per_length, nz[i] * per_length];
        let cosine = dx[i] * x + dy[i] * y + dz[i] * z;
        let [ax, ay, az] = [
            ratio * (dx[i] - cosine * x),
            ratio * (dy[i] - cosine * y),
            ratio * (dz[i] - cosine * z),
        ];
        let squared = 1.0 - (ax * ax + ay * ay + az * az);
        squares[i] = squared;
        let along = squared.sqrt().copysign(cosine);
        let [bx, by, bz] = [ax + along * x, ay + along * y, az + along * z];
        // One Newton step towards length 1, from which the vector differs by rounding only.
        let per_length = 1.5 - 0.5 * (bx * bx + by * by + bz * bz);
        (dx[i], dy[i], dz[i]) = (bx * per_length, by * per_length, bz * per_length);
    }
    squares
}

/// Marks as lost the rays that may lie outside a face that fills a room exactly.
pub(super) fn mark_outside(room: &Room, points: &Triple, is_lost: &mut Mask) {
    let own = room.own_from_sensor.as_ref().map(|pose| transform(pose, points));
    let [x, y, z] = own.as_ref().unwrap_or(points);
    let Room { low, high, squared_mm2: [near, far], .. } = *room;
    for i in 0..LANES {
        let squared = x[i] * x[i] + y[i] * y[i];
        let is_in = (low[0] <= x[i])
            & (x[i] <= high[0])
            & (low[1] <= y[i])
            & (y[i] <= high[1])
            & (low[2] <= z[i])
            & (z[i] <= high[2])
            & (near <= squared)
            & (squared <= far);
        is_lost[i] |= u64::from(!is_in);
    }
}

/// Returns which of the straight ways between points do not certainly lie on one side of a surface.
///
/// At the share s of a way, the function is `p (1 - s) + q s - h s (1 - s)`, where p and q are its values at the ends.
/// It differs from the straight line between them by at most a quarter of h.
pub(super) fn may_intersect(surface: &Surface, from: &Triple, to: &Triple) -> Mask {
    let own = surface.frame().map(|pose| (transform(pose, from), transform(pose, to)));
    let (from, to) = own.as_ref().map_or((from, to), |(from, to)| (from, to));
    let Quadric { a, b, l, d } = *surface.quadric();
    let ([fx, fy, fz], [tx, ty, tz]) = (from, to);
    let value = |x: f64, y: f64, z: f64| {
        a * (x * x + y * y) + b * z * z + (l.x * x + l.y * y + l.z * z) + d
    };
    let mut is_near = [0; LANES];
    for i in 0..LANES {
        let (p, q) = (value(fx[i], fy[i], fz[i]), value(tx[i], ty[i], tz[i]));
        let [x, y, z] = [tx[i] - fx[i], ty[i] - fy[i], tz[i] - fz[i]];
        let quarter = 0.25 * (a * (x * x + y * y) + b * z * z);
        let (least, most) = if p < q { (p, q) } else { (q, p) };
        let is_below = most + if quarter < 0.0 { -quarter } else { 0.0 } < -ZERO_TOLERANCE;
        let is_above = least - if quarter > 0.0 { quarter } else { 0.0 } > ZERO_TOLERANCE;
        is_near[i] = u64::from(!(is_below | is_above));
    }
    is_near
}

/// Returns the box around the points of the rays that are not lost.
pub(super) fn bounding_box(points: &Triple, is_lost: &Mask) -> Aabb {
    let is_whole = is_lost.iter().fold(0, |any, is_lost| any | is_lost) == 0;
    let [x, y, z] = [0, 1, 2].map(|axis| {
        // Four accumulators let the loop be vectorized.
        let [mut lows, mut highs] = [[f64::INFINITY; 4], [f64::NEG_INFINITY; 4]];
        for (points, is_lost) in points[axis].chunks_exact(4).zip(is_lost.chunks_exact(4)) {
            for i in 0..4 {
                let is_kept = is_whole || is_lost[i] == 0;
                lows[i] = if is_kept & (points[i] < lows[i]) { points[i] } else { lows[i] };
                highs[i] = if is_kept & (points[i] > highs[i]) { points[i] } else { highs[i] };
            }
        }
        let low = lows.into_iter().fold(f64::INFINITY, f64::min);
        [low, highs.into_iter().fold(f64::NEG_INFINITY, f64::max)]
    });
    if x[0] > x[1] {
        // All rays are lost.
        return Aabb::nothing();
    }
    Aabb { min: Point3::new(x[0], y[0], z[0]), max: Point3::new(x[1], y[1], z[1]) }
}
