//! Grids of saddles: first neighbours along edges, then coordinates.
//!
//! Nothing here assumes straight lines or even spacing, so that fisheye images need no undistortion. Two saddles are
//! neighbours if each is the nearest along an edge of the other, a light and a dark side run along the line between
//! them, and the sides change places at both ends.

use std::collections::{BTreeMap, VecDeque};

use fabkit_camera::{Point2, Vector2};

use super::saddle::{self, Saddle};
use crate::image::GreyImage;

/// Number of nearest saddles among which neighbours are searched. It is large, because the markers of ChArUco boards
/// contain many saddles of their own.
const NEAREST: usize = 80;
/// Smallest cosine of the angle between an edge as seen at one end and the line to the other end.
const MIN_EDGE_COSINE: f64 = 0.88;
/// Distance from an edge at which its sides are sampled, in lengths of the edge: between the edge and the markers.
const SIDE: f64 = 0.1;
/// Smallest difference of intensity between the sides, as a multiple of the saddles' contrast.
const MIN_SIDE_CONTRAST: f64 = 0.2;
/// Largest ratio of opposite sides of a square, as distortion and tilt leave them.
const MAX_SIDE_RATIO: f64 = 2.0;
/// Largest distance of a missing saddle from the position that its neighbours predict, in spacings.
const SEARCH: f64 = 0.25;
/// Standard deviation of the final smoothing, in spacings: wide against noise, narrow against distortion and markers.
const SMOOTHING: f64 = 0.08;
/// Limits of the final smoothing, px.
const SMOOTHING_LIMITS_PX: [f64; 2] = [1.0, 3.0];

/// Column and row within a grid, from an arbitrary origin; right-handed like the image (+x right, +y down).
pub(super) type Cell = (i32, i32);

/// Saddles with coordinates. The square to the lower right of the corner (i, j) is light if i + j is even.
pub(super) type Grid = BTreeMap<Cell, Saddle>;

/// Indices of a saddle's neighbours along its +first, -first, +second and -second edge.
type Links = [Option<usize>; 4];

/// Image with its noise (standard deviation of the intensity) and the smoothing in use, px.
pub(super) struct BoardImage<'a> {
    pub image: &'a GreyImage,
    pub noise: f64,
    pub sigma_px: f64,
}

/// Finds all grids of at least 2 x 2 corners, the largest first.
pub(super) fn find_grids(scene: &BoardImage, saddles: &[Saddle]) -> Vec<Grid> {
    let links = keep_square_sides(saddles, &links(scene.image, saddles));
    let mut taken = vec![false; saddles.len()];
    let mut grids: Vec<Grid> = Vec::new();
    for seed in 0..saddles.len() {
        if taken[seed] || links[seed].iter().all(Option::is_none) {
            continue;
        }
        let mut grid = number_saddles(saddles, &links, seed, &mut taken);
        prune(&mut grid);
        if grid.len() >= 4 {
            fill(scene, &mut grid);
            grids.push(grid);
        }
    }
    grids.sort_by_key(|grid| std::cmp::Reverse(grid.len()));
    grids
}

/// Finds the neighbours of each saddle.
fn links(image: &GreyImage, saddles: &[Saddle]) -> Vec<Links> {
    let wanted: Vec<Links> = (0..saddles.len())
        .map(|from| {
            let here = &saddles[from];
            let mut near: Vec<(f64, usize)> = (0..saddles.len())
                .filter(|to| *to != from)
                .map(|to| ((saddles[to].at - here.at).norm_squared(), to))
                .collect();
            let order =
                |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
            if near.len() > NEAREST {
                near.select_nth_unstable_by(NEAREST, order);
                near.truncate(NEAREST);
            }
            near.sort_by(order);
            [0, 1, 2, 3].map(|way| {
                near.iter()
                    .map(|(_, to)| *to)
                    .find(|to| are_joined(image, here, way, &saddles[*to]))
            })
        })
        .collect();
    // A link counts only in both directions.
    let mutual = |from: usize, to: usize| wanted[to].contains(&Some(from));
    let keep = |(from, ways): (usize, &Links)| ways.map(|to| to.filter(|to| mutual(from, *to)));
    wanted.iter().enumerate().map(keep).collect()
}

/// Keeps the links that are a side of a square of four saddles. A single link may lead into a marker or off the board,
/// a square hardly ever.
fn keep_square_sides(saddles: &[Saddle], links: &[Links]) -> Vec<Links> {
    let length = |a: usize, b: usize| (saddles[a].at - saddles[b].at).norm();
    let alike = |a: f64, b: f64| a < MAX_SIDE_RATIO * b && b < MAX_SIDE_RATIO * a;
    let is_side = |from: usize, to: usize, way: usize| {
        // Ways 0 and 1 lie on one axis, 2 and 3 on the other: these two are across `way`.
        let sideways = [way ^ 2, way ^ 3];
        sideways.into_iter().filter_map(|side| links[from][side]).any(|beside| {
            links[to].iter().flatten().any(|&across| {
                across != from
                    && links[beside].contains(&Some(across))
                    && alike(length(from, to), length(beside, across))
                    && alike(length(from, beside), length(to, across))
            })
        })
    };
    (0..saddles.len())
        .map(|from| [0, 1, 2, 3].map(|way| links[from][way].filter(|to| is_side(from, *to, way))))
        .collect()
}

/// Returns the direction of one of the four ways along a saddle's edges.
fn way_direction(saddle: &Saddle, way: usize) -> Vector2<f64> {
    if way & 1 == 0 { saddle.edges[way / 2] } else { -saddle.edges[way / 2] }
}

/// Returns whether an edge leads from one saddle, along one of its ways, to the other.
fn are_joined(image: &GreyImage, from: &Saddle, way: usize, to: &Saddle) -> bool {
    let line = to.at - from.at;
    let length = line.norm();
    let direction = line / length;
    // The light side changes places, so that one corner's first edge is the other's second.
    let other = &to.edges[1 - way / 2];
    if way_direction(from, way).dot(&direction) < MIN_EDGE_COSINE
        || other.dot(&direction).abs() < MIN_EDGE_COSINE
    {
        return false;
    }
    let left = Vector2::new(-direction.y, direction.x);
    let light = if way / 2 == 0 { left } else { -left };
    // At least 1.5 px, to be outside the blur of the edge.
    let side = light * (SIDE * length).max(1.5);
    let least = MIN_SIDE_CONTRAST * from.contrast.min(to.contrast);
    [0.3, 0.5, 0.7].into_iter().all(|t| {
        let middle = from.at + line * t;
        let step = sample(image, middle + side).zip(sample(image, middle - side));
        step.is_some_and(|(light, dark)| light - dark > least)
    })
}

/// Interpolates the intensity between pixels linearly; `None` outside the image.
pub(super) fn sample(image: &GreyImage, at: Point2<f64>) -> Option<f64> {
    let (x0, y0) = (at.x.floor(), at.y.floor());
    let fits = |v: f64, n: usize| v >= 0.0 && v + 1.0 < n as f64;
    if !fits(x0, image.width_px()) || !fits(y0, image.height_px()) {
        return None;
    }
    let (x, y, u, v) = (x0 as usize, y0 as usize, at.x - x0, at.y - y0);
    let p = |dx: usize, dy: usize| f64::from(image.at(x + dx, y + dy));
    let top = p(0, 0) * (1.0 - u) + p(1, 0) * u;
    let bottom = p(0, 1) * (1.0 - u) + p(1, 1) * u;
    Some(top * (1.0 - v) + bottom * v)
}

/// Walks along links from a seed and assigns coordinates to the saddles on the way.
fn number_saddles(saddles: &[Saddle], links: &[Links], seed: usize, taken: &mut [bool]) -> Grid {
    // Each entry: a saddle, its cell, and which of its ways are +i and +j.
    let mut queue = VecDeque::from([(seed, (0, 0), [0, 2])]);
    let mut corners = Grid::new();
    taken[seed] = true;
    corners.insert((0, 0), saddles[seed]);
    while let Some((from, (i, j), [way_i, way_j])) = queue.pop_front() {
        // Ways come in pairs of opposites: 0 and 1, 2 and 3.
        let steps = [(way_i, (1, 0)), (way_i ^ 1, (-1, 0)), (way_j, (0, 1)), (way_j ^ 1, (0, -1))];
        for (way, (di, dj)) in steps {
            let Some(to) = links[from][way] else { continue };
            let cell = (i + di, j + dj);
            if taken[to] || corners.contains_key(&cell) {
                continue;
            }
            let line = (saddles[to].at - saddles[from].at).normalize();
            // The way of `to` along an axis that points in the direction of `goal`.
            let same = |axis: usize, goal: &Vector2<f64>| {
                let way = 2 * axis;
                if way_direction(&saddles[to], way).dot(goal) > 0.0 { way } else { way + 1 }
            };
            // The edge that was a saddle's first is the other saddle's second.
            let axis = 1 - way / 2;
            let onward = same(axis, &line);
            let forward = if di + dj > 0 { onward } else { onward ^ 1 };
            let is_i = di != 0;
            // The direction of the other axis for which the frame stays right-handed.
            let e = way_direction(&saddles[to], forward);
            let candidate = 2 * (1 - axis);
            let f = way_direction(&saddles[to], candidate);
            let turn = e.x * f.y - e.y * f.x;
            let sideways = if (turn > 0.0) == is_i { candidate } else { candidate ^ 1 };
            let ways = if is_i { [forward, sideways] } else { [sideways, forward] };
            taken[to] = true;
            corners.insert(cell, saddles[to]);
            queue.push_back((to, cell, ways));
        }
    }
    // A saddle's edges turn from the first to the second through light, so that the square at cell (0, 0) is light.
    corners
}

/// Removes corners that belong to no complete square.
fn prune(grid: &mut Grid) {
    let whole = |(i, j): Cell| {
        [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].iter().all(|c| grid.contains_key(c))
    };
    let lonely: Vec<Cell> = grid
        .keys()
        .copied()
        .filter(|&(i, j)| ![(i, j), (i - 1, j), (i, j - 1), (i - 1, j - 1)].into_iter().any(whole))
        .collect();
    for cell in lonely {
        grid.remove(&cell);
    }
}

/// Searches for missing corners at the positions that their neighbours predict.
fn fill(scene: &BoardImage, grid: &mut Grid) {
    loop {
        let mut found = Vec::new();
        let around = |(i, j): Cell| [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)];
        let mut missing: Vec<Cell> = grid.keys().flat_map(|c| around(*c)).collect();
        missing.sort_unstable();
        missing.dedup();
        missing.retain(|cell| !grid.contains_key(cell));
        for cell in missing {
            let Some((at, spacing)) = predict(grid, cell) else { continue };
            let Some(saddle) = saddle::refine(scene.image, at, scene.sigma_px, scene.noise) else {
                continue;
            };
            // The refinement may have found the saddle of a marker or of another corner.
            let near = (saddle.at - at).norm() <= SEARCH * spacing;
            // Every existing neighbour must be joined by an edge, from both ends.
            let joined = |other: &Saddle| {
                let one_way =
                    |a: &Saddle, b: &Saddle| (0..4).any(|way| are_joined(scene.image, a, way, b));
                one_way(other, &saddle) && one_way(&saddle, other)
            };
            let mut others = around(cell).into_iter().filter_map(|c| grid.get(&c));
            if near && others.all(joined) {
                found.push((cell, saddle));
            }
        }
        if found.is_empty() {
            return;
        }
        let before = grid.len();
        grid.extend(found);
        prune(grid);
        // If pruning removes all that was added, another round would repeat itself.
        if grid.len() <= before {
            return;
        }
    }
}

/// Predicts the position of a corner, and the spacing there, from the corners around it that continue a line or
/// complete a square.
pub(super) fn predict(grid: &Grid, (i, j): Cell) -> Option<(Point2<f64>, f64)> {
    let at = |di: i32, dj: i32| grid.get(&(i + di, j + dj)).map(|saddle| saddle.at.coords);
    let mut sum = Vector2::zeros();
    let (mut count, mut spacing) = (0.0, f64::INFINITY);
    for (di, dj) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
        let line = at(di, dj).zip(at(2 * di, 2 * dj));
        if let Some((one, two)) = line {
            // A third corner gives the change of the spacing, which is extrapolated linearly.
            let three = at(3 * di, 3 * dj);
            sum += three.map_or(2.0 * one - two, |three| 3.0 * (one - two) + three);
            count += 1.0;
            spacing = spacing.min((one - two).norm());
        }
    }
    for (di, dj) in [(1, 1), (1, -1), (-1, 1), (-1, -1)] {
        if let (Some(a), Some(b), Some(across)) = (at(di, 0), at(0, dj), at(di, dj)) {
            sum += a + b - across;
            count += 1.0;
            spacing = spacing.min((a - across).norm()).min((b - across).norm());
        }
    }
    (count > 0.0).then(|| (Point2::from(sum / count), spacing))
}

/// Refines every saddle with a smoothing that fits the spacing around it. Saddles that are not found again are dropped.
pub(super) fn refine_saddles(scene: &BoardImage, grid: &mut Grid) {
    let refined = grid.iter().filter_map(|(&(i, j), saddle)| {
        let others = [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)];
        let distances = others
            .iter()
            .filter_map(|cell| grid.get(cell))
            .map(|other| (other.at - saddle.at).norm());
        let spacing = distances.fold(f64::INFINITY, f64::min);
        let [least, most] = SMOOTHING_LIMITS_PX;
        let sigma_px = (SMOOTHING * spacing).clamp(least, most);
        saddle::refine(scene.image, saddle.at, sigma_px, scene.noise).map(|fine| ((i, j), fine))
    });
    *grid = refined.collect();
}
