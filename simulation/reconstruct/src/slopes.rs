//! Reconstruction of depth from a coat's slopes under coloured light sources.

use fabkit_capture::plausibility::CheckedImage;
use fabkit_capture::{CoatScene, LightConstants};
use fabkit_depth::ground_truth::NO_LABEL;
use fabkit_files::Error;
use fabkit_geometry::{Lighting, Marker, Matrix3, Rgb, TouchSurface, Vector3, VisibleEffect};
use fabkit_light::{Coat, linear_fit};
use fabkit_scene::press_simulation::{ContactModel, LinearOptions};
use fabkit_scene::{Cast, SensorView};
use rayon::prelude::*;

use super::surface_integration::{Grid, Node};
use super::{DepthResult, ReconstructError};

/// Maximum number of grid columns. Pixels are averaged to nodes: normals are more certain then, and gel has no finer
/// shape.
const COLUMNS: usize = 160;
/// Intensity of a value of 1 in an image.
const WHITE: f64 = 255.0;
/// Minimum intensity of a colour at rest for it to be used.
const LEAST_GREY: f64 = 8.0;
/// Minimum share of lit nodes among those that see the surface, for an image at rest.
const LEAST_LIT: f64 = 0.25;
/// Change of intensity below which a node looks as at rest, in the mean of its pixels. Chosen: several times the noise
/// that remains there.
const REST_TOLERANCE: f64 = 1.0;
/// Depth above which a pixel is in contact, mm. Chosen: the depth that remains from false slopes.
const CONTACT_MM: f64 = 0.1;
/// Ratio of sizes up to which a region at rest counts as surrounding a press, relative to the largest region. Chosen.
const REGION_RATIO: usize = 4;
/// Expected standard deviation of slopes, and the largest slope, as tangents.
const SLOPE_SIGMA: f64 = 0.7;
const STEEPEST: f64 = 2.0;
/// Expected standard deviation of the share of light lost to shadow. Chosen.
const SHADOW_SIGMA: f64 = 0.3;
/// Stride of the nodes that are sampled for the drift of an image, which gives some thousand nodes with a noise below
/// one intensity level, and number of iterations.
const DRIFT_STRIDE: usize = 7;
const DRIFT_STEPS: usize = 10;
/// Maximum number of iterations for a normal; step below which it has converged, a hundredth of the noise; and step of
/// finite differences. All as tangents.
const STEPS: usize = 5;
const STEP_TOLERANCE: f64 = 2e-4;
const DIFFERENCE_STEP: f64 = 1e-3;
/// Number of passes: first with the light at rest, then with that at the depth of the first result.
const PASSES: usize = 2;
/// Radius around printed markers that is left out, in their radii: they move along with the coat.
const AROUND_MARK: f64 = 1.5;

/// Light of a node at rest.
#[derive(Clone, Debug)]
struct NodeLight {
    /// Irradiance vectors by colour of light source: direction of light times density, at rest and at the depth of the
    /// soft layers.
    arrives: Vec<[Vector3<f64>; 2]>,
    /// Intensities at rest.
    grey: Rgb,
    /// Ratio of the intensities at rest to those that the design predicts.
    gain: Rgb,
    /// Unit tangents of the surface.
    tangents: [Vector3<f64>; 2],
}

/// Photometric-stereo model of a sensor, calibrated with the image at rest.
#[derive(Clone, Debug)]
pub(super) struct PhotometricStereo {
    size_px: [usize; 2],
    /// Number of pixels along a side of a node.
    binned: usize,
    grid: Grid,
    lit: Vec<Option<NodeLight>>,
    /// Whether a node shows the coat alone, without a printed marker.
    is_coat: Vec<bool>,
    /// Whether a pixel sees the surface.
    is_seen: Vec<bool>,
    colors: Vec<Rgb>,
    coat: Coat,
    bounced: Rgb,
    touch: TouchSurface,
    soft_mm: f64,
}

/// Memory per ray of the model, bytes: rays with place, direction and normal, once as seen and once as nodes, normals, and
/// the colours of images at rest and pressed. Derived by counting.
const STEREO_BYTES: u64 = 80 + 80 + 24 + 1 + 4 * 3 * 4;

impl PhotometricStereo {
    /// Creates the model from the view of a sensor and its colours at rest.
    ///
    /// # Errors
    /// Returns an error for light sources that light nothing, and for an image that shows something else.
    pub fn new(
        scene: &SensorView,
        lighting: &Lighting,
        constants: &LightConstants,
        reference: &CheckedImage,
    ) -> Result<Self, Error> {
        let sensor = &scene.project.design.sensor;
        let coat = CoatScene::new(sensor, lighting, constants)?;
        let touch = scene.touch()?;
        let camera = scene.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        let binned = size_px[0].div_ceil(COLUMNS);
        let cast = Cast::at_rest(ContactModel::Linear(LinearOptions::default()));
        let (grid, is_seen) = scene.cast(&cast, STEREO_BYTES, |seen| {
            let map = seen.map;
            let is_seen: Vec<bool> = map.label().iter().map(|label| *label != NO_LABEL).collect();
            let normals = map.normal_in_sensor();
            let rays: Vec<Option<Node>> = map
                .point_in_sensor()
                .zip(map.direction_in_sensor())
                .zip(&normals)
                .zip(&is_seen)
                .map(|(((place, direction), outward), is_seen)| {
                    is_seen.then_some(Node { place, outward: *outward, direction })
                })
                .collect();
            let grid = Grid {
                columns: size_px[0] / binned,
                nodes: map_nodes(size_px, binned, |pixels| mean_node(&rays, pixels)),
            };
            Ok::<_, Error>((grid, is_seen))
        })?;
        let apart_mm = node_spacing_mm(&grid);
        let stands_out = matches!(lighting.effect, VisibleEffect::Slopes { printed: None, .. });
        let mut own = Self {
            size_px,
            binned,
            lit: Vec::new(),
            is_coat: Vec::new(),
            is_seen,
            colors: Vec::new(),
            coat: coat.coat(),
            bounced: coat.reflected_light(),
            touch: touch.clone(),
            soft_mm: touch.max_indentation_mm(),
            grid,
        };
        // `own` must exist before its light, since predictions use its coat and grid.
        let grey = own.grey(&reference.image().values);
        let nodes = own.grid.nodes.clone();
        let first = nodes.iter().flatten().next();
        let by_color = first.map(|node| coat.irradiance_by_color(&node.place)).unwrap_or_default();
        own.colors = by_color.into_iter().map(|(color, _)| color).collect();
        let lit = |(node, grey): (&Option<Node>, &Rgb)| {
            let node = node.as_ref()?;
            let tangents = tangents(&node.outward);
            let by_color = coat.irradiance_by_color(&node.place);
            let arrives = by_color.into_iter().map(|(_, arrives)| arrives).collect();
            let mut lit = NodeLight { arrives, grey: *grey, gain: [0.0; 3], tangents };
            let sent = own.predicted_light(node, &lit, &-node.outward, 0.0);
            // Colours that are too dark at rest get a gain of 0 and are ignored from then on.
            lit.gain = [0, 1, 2].map(|k| {
                if grey[k] >= LEAST_GREY && sent[k] > 0.0 { grey[k] / sent[k] } else { 0.0 }
            });
            Some(lit).filter(|lit| lit.gain.iter().any(|gain| *gain > 0.0))
        };
        own.lit = nodes.iter().zip(&grey).map(lit).collect();
        let [seen, lit] = [nodes.iter().flatten().count(), own.lit.iter().flatten().count()];
        if (lit as f64) < LEAST_LIT * seen as f64 {
            return Err(ReconstructError::TooDark {
                file: reference.file().to_owned(),
                least_grey: LEAST_GREY,
            }
            .into());
        }
        let marks: &[Marker] = if stands_out { &[] } else { &sensor.marks };
        let is_coat = |(node, lit): (&Option<Node>, &Option<NodeLight>)| {
            let Some(node) = node else { return false };
            let is_in = |mark: &Marker| {
                (mark.point - node.place).norm() < AROUND_MARK * mark.radius_mm + 0.5 * apart_mm
            };
            lit.is_some() && !marks.iter().any(is_in)
        };
        own.is_coat = nodes.par_iter().zip(&own.lit).map(is_coat).collect();
        Ok(own)
    }

    /// Reconstructs depth from the colours of an image.
    pub fn reconstruct(&self, image: &CheckedImage) -> DepthResult {
        let mut grey = self.grey(&image.image().values);
        let [times, plus] = self.drift(&grey);
        // Undoes the drift, so that undisturbed nodes have their intensities at rest.
        grey.iter_mut().flatten().for_each(|part| *part = (*part - plus) / times);
        let still: Vec<bool> = self
            .lit
            .iter()
            .zip(&grey)
            .zip(&self.is_coat)
            .map(|((lit, grey), is_coat)| {
                lit.as_ref().filter(|_| *is_coat).is_none_or(|lit| {
                    (0..3).all(|k| (grey[k] - lit.grey[k]).abs() < REST_TOLERANCE)
                })
            })
            .collect();
        let around = self.surrounding_regions(&still);
        let mut nearer_mm = vec![0.0; self.grid.nodes.len()];
        for _ in 0..PASSES {
            let way = |i: usize| {
                let Some(node) = &self.grid.nodes[i] else { return Vector3::zeros() };
                match &self.lit[i] {
                    Some(lit) if self.is_coat[i] && !still[i] => {
                        self.solve_normal(node, lit, &grey[i], nearer_mm[i])
                    }
                    _ => node.outward,
                }
            };
            let normals: Vec<Vector3<f64>> =
                (0..self.grid.nodes.len()).into_par_iter().map(way).collect();
            // Nodes with markers have no reliable intensity, so only their neighbours determine them.
            let held: Vec<bool> =
                around.iter().zip(&self.is_coat).map(|(held, is_coat)| *held && *is_coat).collect();
            nearer_mm = self.grid.solve_displacements_mm(&normals, &held, &self.is_coat, nearer_mm);
        }
        let depth_mm = self.interpolate_pixels(&nearer_mm);
        let contact = depth_mm.iter().map(|mm| *mm > CONTACT_MM as f32).collect();
        let middle = median(self.lit.iter().flatten().map(|lit| lit.grey[1]).collect());
        // The offset counts relative to the median green intensity.
        let brighter = (times + plus / middle) as f32;
        DepthResult { size_px: self.size_px, depth_mm, contact, relative_brightness: brighter }
    }

    /// Returns the predicted light of a node with the normal `facing`, at `nearer_mm` towards the camera.
    fn predicted_light(
        &self,
        node: &Node,
        lit: &NodeLight,
        facing: &Vector3<f64>,
        nearer_mm: f64,
    ) -> Rgb {
        let place = node.place - nearer_mm * node.direction;
        // Irradiance is interpolated between the surface at rest and the depth of the soft layers.
        let deep = (self.touch.depth_mm(&place).0 / self.soft_mm).clamp(0.0, 1.0);
        let mut sum = self.bounced;
        for ([at_rest, lower], color) in lit.arrives.iter().zip(&self.colors) {
            let arrives = (1.0 - deep) * at_rest + deep * lower;
            let density = arrives.norm();
            if density > 0.0 {
                let sent =
                    density * self.coat.reflect(facing, &(arrives / density), &-node.direction);
                sum = [0, 1, 2].map(|k| sum[k] + sent * color[k]);
            }
        }
        sum
    }

    /// Finds the outward normal for which a node has these colours, by Gauss-Newton iteration from its normal at rest.
    /// A shadow dims all colours about equally; its strength is a third unknown.
    fn solve_normal(
        &self,
        node: &Node,
        lit: &NodeLight,
        grey: &Rgb,
        nearer_mm: f64,
    ) -> Vector3<f64> {
        let outward =
            |a: f64, b: f64| (node.outward + a * lit.tangents[0] + b * lit.tangents[1]).normalize();
        let miss = |at: &Vector3<f64>| {
            let sent = self.predicted_light(node, lit, &-outward(at[0], at[1]), nearer_mm);
            Vector3::from_fn(|k, _| {
                if lit.gain[k] > 0.0 { at[2] * lit.gain[k] * sent[k] - grey[k] } else { 0.0 }
            })
        };
        let rest = Vector3::new(0.0, 0.0, 1.0);
        // Prior weights keep the two slopes and the brightness near rest where colours do not determine them.
        let hold = Vector3::new(SLOPE_SIGMA, SLOPE_SIGMA, SHADOW_SIGMA).map(|sigma| sigma.powi(-2));
        let mut at = rest;
        for _ in 0..STEPS {
            let off = miss(&at);
            // The Jacobian, by forward differences.
            let by = |k: usize| {
                (miss(&(at + DIFFERENCE_STEP * Vector3::ith(k, 1.0))) - off) / DIFFERENCE_STEP
            };
            let slopes = Matrix3::from_columns(&[by(0), by(1), by(2)]);
            let square = slopes.transpose() * slopes + Matrix3::from_diagonal(&hold);
            let towards = slopes.transpose() * off + hold.component_mul(&(at - rest));
            let Some(step) = square.cholesky().map(|square| square.solve(&towards)) else { break };
            at -= step;
            let steep = at[0].hypot(at[1]);
            // Keeps the direction of the slope and limits its steepness.
            if steep > STEEPEST {
                at[0] *= STEEPEST / steep;
                at[1] *= STEEPEST / steep;
            }
            if step.amax() < STEP_TOLERANCE {
                break;
            }
        }
        outward(at[0], at[1])
    }

    /// Returns factor and offset of most of an image relative to the one at rest, by iteratively reweighted least
    /// squares. A press changes the smaller part, and pixels count less the more they differ (Cauchy weights).
    fn drift(&self, grey: &[Rgb]) -> [f64; 2] {
        let lit = self.lit.iter().zip(grey).step_by(DRIFT_STRIDE);
        let both = lit.filter_map(|(lit, grey)| Some((lit.as_ref()?.grey, grey)));
        let pairs: Vec<[f64; 2]> =
            both.flat_map(|(rest, now)| [0, 1, 2].map(|k| [rest[k], now[k]])).collect();
        // The median difference is a start that a press does not disturb.
        let mut drift = [1.0, median(pairs.iter().map(|[rest, now]| now - rest).collect())];
        for _ in 0..DRIFT_STEPS {
            let weigh = |[rest, now]: &[f64; 2]| {
                let off = (now - drift[0] * rest - drift[1]) / REST_TOLERANCE;
                // The square root of the Cauchy weight, since rows are squared.
                let root = (1.0 + off * off).sqrt().recip();
                ([root * rest, root], root * now)
            };
            let (rows, wanted): (Vec<_>, Vec<_>) = pairs.iter().map(weigh).unzip();
            let Some(found) = linear_fit(&rows, &wanted) else { break };
            drift = found;
        }
        drift
    }

    /// Returns which of the nodes that look as at rest surround a press rather than lie within it, as the middle of a
    /// flat punch does. They form a connected region that is not much smaller than the largest.
    fn surrounding_regions(&self, still: &[bool]) -> Vec<bool> {
        let columns = self.grid.columns;
        let is_one = |i: usize| still[i] && self.grid.nodes[i].is_some();
        // Flood fill; region 0 means none.
        let mut region = vec![0usize; still.len()];
        let mut sizes = vec![0usize];
        for first in 0..still.len() {
            if !is_one(first) || region[first] != 0 {
                continue;
            }
            let own = sizes.len();
            sizes.push(0);
            region[first] = own;
            let mut open = vec![first];
            while let Some(i) = open.pop() {
                sizes[own] += 1;
                let column = i % columns;
                let beside = [
                    (column > 0).then(|| i - 1),
                    (column + 1 < columns).then_some(i + 1),
                    i.checked_sub(columns),
                    Some(i + columns).filter(|i| *i < still.len()),
                ];
                for j in beside.into_iter().flatten() {
                    if is_one(j) && region[j] == 0 {
                        region[j] = own;
                        open.push(j);
                    }
                }
            }
        }
        let largest = sizes.iter().copied().max().unwrap_or(0);
        region.iter().map(|own| *own != 0 && REGION_RATIO * sizes[*own] >= largest).collect()
    }

    /// Returns the mean intensities of the nodes.
    fn grey(&self, values: &[f32]) -> Vec<Rgb> {
        let mean = |pixels: &[usize]| {
            let mut sum = [0.0; 3];
            for i in pixels {
                (0..3).for_each(|k| sum[k] += f64::from(values[3 * i + k]));
            }
            sum.map(|part| WHITE * part / pixels.len() as f64)
        };
        map_nodes(self.size_px, self.binned, mean)
    }

    /// Interpolates from nodes to pixels linearly; NaN where no surface is seen.
    fn interpolate_pixels(&self, nearer_mm: &[f64]) -> Vec<f32> {
        let [width, _] = self.size_px;
        let columns = self.grid.columns;
        let rows = nearer_mm.len() / columns;
        let between = |px: usize, count: usize| {
            let at = ((px as f64 + 0.5) / self.binned as f64 - 0.5).clamp(0.0, (count - 1) as f64);
            (at as usize, (at as usize + 1).min(count - 1), at.fract())
        };
        let pixel = |i: usize| {
            if !self.is_seen[i] {
                return f32::NAN;
            }
            let (left, right, x) = between(i % width, columns);
            let (above, below, y) = between(i / width, rows);
            let row = |row: usize| {
                (1.0 - x) * nearer_mm[row * columns + left] + x * nearer_mm[row * columns + right]
            };
            ((1.0 - y) * row(above) + y * row(below)) as f32
        };
        (0..self.is_seen.len()).into_par_iter().map(pixel).collect()
    }
}

/// Applies `of` to the pixels of each node, row by row. Pixels beyond the last whole node are left out.
fn map_nodes<T: Send>(
    [width, height]: [usize; 2],
    binned: usize,
    of: impl Fn(&[usize]) -> T + Sync,
) -> Vec<T> {
    let columns = width / binned;
    let node = |i: usize| {
        let (row, column) = (i / columns * binned, i % columns * binned);
        let pixels: Vec<usize> = (row..row + binned)
            .flat_map(|row| (column..column + binned).map(move |column| row * width + column))
            .collect();
        of(&pixels)
    };
    (0..columns * (height / binned)).into_par_iter().map(node).collect()
}

/// Returns the mean of rays that all see the surface; `None` if one does not.
fn mean_node(rays: &[Option<Node>], pixels: &[usize]) -> Option<Node> {
    let nodes: Vec<&Node> = pixels.iter().map(|i| rays[*i].as_ref()).collect::<Option<_>>()?;
    let mean = |of: fn(&Node) -> Vector3<f64>| {
        nodes.iter().map(|node| of(node)).sum::<Vector3<f64>>() / nodes.len() as f64
    };
    Some(Node {
        place: mean(|node| node.place.coords).into(),
        outward: mean(|node| node.outward).normalize(),
        direction: mean(|node| node.direction).normalize(),
    })
}

/// Returns two unit vectors in the surface, at right angles to each other.
fn tangents(outward: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let first = outward.cross(&Vector3::ith(outward.iamin(), 1.0)).normalize();
    [first, outward.cross(&first)]
}

/// Returns the median distance between neighbouring nodes of a row, mm.
fn node_spacing_mm(grid: &Grid) -> f64 {
    let beside = |i: &usize| !i.is_multiple_of(grid.columns);
    let apart = (1..grid.nodes.len()).filter(beside).filter_map(|i| {
        let [a, b] = [grid.nodes[i - 1]?, grid.nodes[i]?];
        Some((b.place - a.place).norm())
    });
    median(apart.collect())
}

/// Returns the median, the upper one of an even number; 0 without values.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
