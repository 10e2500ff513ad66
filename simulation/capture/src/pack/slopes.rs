//! Tables of intensity by slope for lightings that show slopes: those of Taxim (Si and Yuan 2022), which TacEx and
//! TacSL read as well.
//!
//! For each angle and direction of a slope, a table holds the difference of a pixel from the image at rest, as a
//! polynomial of second degree in column and row. Taxim and TacEx store colours as blue, green, red and TacSL as red,
//! green, blue, all under the names of the latter.

use fabkit_camera::image_centre_px;
use fabkit_depth::ground_truth::{DepthMap, NO_LABEL};
use fabkit_export::{NpyValues, npy, npy_lists, zip};
use fabkit_files::Error;
use fabkit_geometry::{Lighting, Point3, Rgb, TouchSurface, Vector3};
use fabkit_image::encode_jpeg;
use fabkit_light::linear_fit;
use fabkit_scene::SensorView;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::super::coat::CoatScene;
use super::super::{CaptureError, LightConstants};
use super::{OpticsPack, array, background_png, file, npz_file, render_at_rest, to_rgb8};

/// Number of bins of a slope's angle, and of its direction: `floor(angle / (pi / 2 / (BINS - 1)))`.
pub const BINS: usize = 125;
/// Number of coefficients: x^2, y^2, x y, x, y, 1.
const TERMS: usize = 6;
/// Number of places over the image to which a polynomial is fitted.
const COLUMNS: usize = 16;
const ROWS: usize = 12;
/// Standard deviation of their weights around the middle, as a share of the image.
const REACH: f64 = 0.25;
/// Distance to either side of the pixels that give the image's local scale.
const BESIDE_PX: usize = 3;
/// Largest rendered slope angle, rad.
const STEEPEST: f64 = 1.5;
/// Range of slope angles for which the error of the polynomials is reported, rad.
const GENTLE: [f64; 2] = [0.05, 0.5];
/// Number of shadow directions: `k / 10` rad.
const SHADOW_DIRECTIONS: usize = 63;
/// Number of shadow heights: bin `k` begins at `0.4 mm + (k - 6) / 10 mm` and is rendered at its middle.
const SHADOW_HEIGHTS: usize = 24;
/// Step along shadows, px, and maximum number of steps.
const SHADOW_STEP_PX: f64 = 1.25;
const SHADOW_STEPS: usize = 120;
/// Loss of intensity below which a shadow ends.
const SHADOW_ENDS: f64 = 1.0;
/// Widths of GelSight's smoothing kernels in Taxim, px of 0.0295 mm.
const KERNELS_PX: [f64; 6] = [201.0, 101.0, 51.0, 21.0, 11.0, 5.0];
const TAXIM_PIXEL_MM: f64 = 0.0295;
const TAXIM_SIZE_PX: [f64; 2] = [640.0, 480.0];

/// A place on the surface that the camera sees.
#[derive(Clone, Copy, Debug)]
struct Spot {
    /// Column and row.
    pixel: [f64; 2],
    place: Point3<f64>,
    outward: Vector3<f64>,
    direction: Vector3<f64>,
    /// Displacement on the surface from one pixel to the next along columns and rows, mm.
    steps: [Vector3<f64>; 2],
}

impl Spot {
    /// Returns the gradient of a surface that rises by `per_px` pixels towards the camera per pixel along columns and
    /// rows, as a tangent vector, for pixels of one size.
    fn surface_gradient(&self, per_px: [f64; 2], pixel_mm: f64) -> Vector3<f64> {
        let [a, b] = self.steps;
        let [aa, ab, bb] = [a.dot(&a), a.dot(&b), b.dot(&b)];
        let determinant = aa * bb - ab * ab;
        let [u, v] = per_px.map(|px| px * pixel_mm);
        ((u * bb - v * ab) * a + (v * aa - u * ab) * b) / determinant
    }
}

pub(super) fn slope_pack(
    scene: &SensorView,
    lighting: &Lighting,
    constants: &LightConstants,
) -> Result<OpticsPack, Error> {
    let sensor = &scene.project.design.sensor;
    let touch = scene.touch()?;
    if !matches!(touch, TouchSurface::Plane(_)) {
        return Err(CaptureError::NotFlat { sensor: sensor.name.clone() }.into());
    }
    let coat = CoatScene::new(sensor, lighting, constants)?;
    let mut spots = Vec::new();
    let image = render_at_rest(scene, lighting, constants, |seen| {
        spots = sample_spots(seen.map, touch);
        Ok(())
    })?;
    let middle = image_centre_px(image.size_px);
    // Shadows are rendered at the place nearest to the image's centre.
    let off = |spot: &&Spot| {
        let [x, y] = [0, 1].map(|k| spot.pixel[k] - middle[k]);
        x.hypot(y)
    };
    let centre = spots.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    let Some(centre) = centre.copied().filter(|_| spots.len() >= 2 * TERMS) else {
        return Err(CaptureError::NoSurface { sensor: sensor.name.clone() }.into());
    };
    let mut scales: Vec<f64> = spots.iter().flat_map(|spot| spot.steps.map(|s| s.norm())).collect();
    scales.sort_by(f64::total_cmp);
    let pixel_mm = scales[scales.len() / 2];
    let table = Table::fit(&coat, &spots, pixel_mm);
    let shadows = shadows(&coat, &centre, pixel_mm);
    let [width, height] = image.size_px;
    let rgb = to_rgb8(&image);
    let bgr: Vec<u8> = rgb.chunks(3).flat_map(|pixel| [pixel[2], pixel[1], pixel[0]]).collect();
    let shape = [height as usize, width as usize];
    let f0 = array("f0", &[shape[0], shape[1], 3], NpyValues::U8(bgr));
    let flat = NpyValues::F64(vec![0.0; shape[0] * shape[1]]);
    let gel = npy(&array("gelmap", &shape, flat)).map_err(Error::bug)?;
    let ways = NpyValues::F64((0..SHADOW_DIRECTIONS).map(|k| k as f64 / 10.0).collect());
    let ways = npy(&array("shadowDirections", &[SHADOW_DIRECTIONS], ways));
    // Blue comes first, as in the colours of these images.
    let lists: Vec<Vec<f64>> = [2, 1, 0].iter().flat_map(|k| shadows[*k].clone()).collect();
    let lists = npy_lists(&[3, SHADOW_DIRECTIONS, SHADOW_HEIGHTS], &lists).map_err(Error::bug)?;
    let shadow_table =
        zip(&[("shadowDirections.npy", &ways.map_err(Error::bug)?), ("shadowTable.npy", &lists)]);
    let params = serde_json::to_string_pretty(&tacex_settings([width, height], pixel_mm));
    let config = json!({
        "image_width": width, "image_height": height, "num_bins": BINS, "mm_per_pixel": pixel_mm,
        "background_path": "bg.jpg", "calib_path": "polycalib.npz",
    });
    let config = serde_json::to_string_pretty(&config);
    let files = vec![
        file("background.png", background_png(&image)?),
        npz_file("taxim/polycalib.npz", &table.arrays([2, 1, 0]))?,
        npz_file("taxim/dataPack.npz", &[f0])?,
        file("taxim/gelmap.npy", gel),
        file("taxim/shadowTable.npz", shadow_table.map_err(Error::bug)?),
        file("taxim/params.json", (params.map_err(Error::bug)? + "\n").into_bytes()),
        npz_file("tacsl/polycalib.npz", &table.arrays([0, 1, 2]))?,
        file("tacsl/bg.jpg", encode_jpeg([width, height], &rgb, 100).map_err(Error::bug)?),
        file("tacsl/render_cfg.json", (config.map_err(Error::bug)? + "\n").into_bytes()),
    ];
    let document = json!({
        "shows": "slopes",
        "width_px": width,
        "height_px": height,
        "mm_per_pixel": pixel_mm,
        "mm_per_pixel_range": [scales[0], scales[scales.len() - 1]],
        "bins": BINS,
        "polynomials_miss": table.missed,
    });
    Ok(OpticsPack { files, document })
}

/// Returns places over the image where the camera sees the surface and its surroundings.
fn sample_spots(map: &DepthMap<'_>, touch: &TouchSurface) -> Vec<Spot> {
    let (width, height) = (map.width_px() as usize, map.height_px() as usize);
    let places: Vec<(Point3<f64>, Vector3<f64>)> =
        map.point_in_sensor().zip(map.direction_in_sensor()).collect();
    let spot = |k: usize| {
        let column = (2 * (k % COLUMNS) + 1) * width / (2 * COLUMNS);
        let row = (2 * (k / COLUMNS) + 1) * height / (2 * ROWS);
        let at = |column: usize, row: usize| {
            let i = row * width + column;
            (map.label()[i] != NO_LABEL).then(|| places[i])
        };
        let inside = (BESIDE_PX..width - BESIDE_PX).contains(&column)
            && (BESIDE_PX..height - BESIDE_PX).contains(&row);
        if !inside {
            return None;
        }
        let (place, direction) = at(column, row)?;
        let step = |a: (usize, usize), b: (usize, usize)| {
            Some((at(b.0, b.1)?.0 - at(a.0, a.1)?.0) / (2 * BESIDE_PX) as f64)
        };
        let steps = [
            step((column - BESIDE_PX, row), (column + BESIDE_PX, row))?,
            step((column, row - BESIDE_PX), (column, row + BESIDE_PX))?,
        ];
        let (_, outward) = touch.depth_mm(&place);
        Some(Spot { pixel: [column as f64, row as f64], place, outward, direction, steps })
    };
    (0..COLUMNS * ROWS).filter_map(spot).collect()
}

/// Polynomials by angle and direction of slopes.
struct Table {
    /// Coefficients of each bin, for red, green and blue.
    terms: Vec<[[f64; TERMS]; 3]>,
    /// Root mean square error of the polynomials for gentle slopes, as a share of the change of intensity.
    missed: f64,
}

impl Table {
    fn fit(coat: &CoatScene<'_>, spots: &[Spot], pixel_mm: f64) -> Self {
        let at_rest: Vec<Rgb> =
            spots.iter().map(|spot| coat.sloped_light(spot, &Vector3::zeros())).collect();
        // Scaled coordinates keep the numbers near one during the fit.
        let unit = spots.iter().flat_map(|spot| spot.pixel).fold(1.0, f64::max);
        let features = |[x, y]: [f64; 2]| [x * x, y * y, x * y, x, y, 1.0];
        let rows: Vec<[f64; TERMS]> =
            spots.iter().map(|spot| features(spot.pixel.map(|px| px / unit))).collect();
        // The middle, where contact happens, counts more than the rim, where the light falls off steeply.
        let middle = [0, 1]
            .map(|k| spots.iter().map(|spot| spot.pixel[k]).sum::<f64>() / spots.len() as f64);
        let weight = |spot: &Spot| {
            let [x, y] = [0, 1].map(|k| (spot.pixel[k] - middle[k]) / (REACH * 2.0 * middle[k]));
            (-0.5 * (x * x + y * y)).exp()
        };
        let weights: Vec<f64> = spots.iter().map(weight).collect();
        let weighted: Vec<[f64; TERMS]> =
            rows.iter().zip(&weights).map(|(row, w)| row.map(|x| w * x)).collect();
        let back = [unit * unit, unit * unit, unit * unit, unit, unit, 1.0];
        let bin = |k: usize| {
            let [angle, way] = [k / BINS, k % BINS];
            // The flat bin keeps its angle of exactly 0, other bins use their middle.
            let angle = if angle == 0 { 0.0 } else { (angle as f64 + 0.5) * bin_width_rad() };
            let way = (way as f64 + 0.5) * 4.0 * bin_width_rad() - std::f64::consts::PI;
            let per_px = [way.cos(), way.sin()].map(|part| angle.min(STEEPEST).tan() * part);
            let sloped: Vec<Rgb> = spots
                .iter()
                .zip(&at_rest)
                .map(|(spot, rest)| {
                    let now = coat.sloped_light(spot, &spot.surface_gradient(per_px, pixel_mm));
                    [0, 1, 2].map(|k| now[k] - rest[k])
                })
                .collect();
            let (mut left, mut all) = (0.0, 0.0);
            let is_gentle = (GENTLE[0]..GENTLE[1]).contains(&angle);
            let terms = [0, 1, 2].map(|color| {
                let wanted: Vec<f64> = sloped.iter().map(|value| value[color]).collect();
                let heavy: Vec<f64> = wanted.iter().zip(&weights).map(|(x, w)| w * x).collect();
                let terms = linear_fit(&weighted, &heavy).unwrap_or([0.0; TERMS]);
                for (row, wanted) in weighted.iter().zip(&heavy).filter(|_| is_gentle) {
                    let fitted: f64 = row.iter().zip(&terms).map(|(x, term)| x * term).sum();
                    left += (wanted - fitted).powi(2);
                    all += wanted.powi(2);
                }
                std::array::from_fn(|k| terms[k] / back[k])
            });
            (terms, [left, all])
        };
        let all: Vec<_> = (0..BINS * BINS).into_par_iter().map(bin).collect();
        let sum = |k: usize| all.iter().map(|(_, sums)| sums[k]).sum::<f64>();
        let missed = (sum(0) / sum(1)).sqrt();
        Self { terms: all.into_iter().map(|(terms, _)| terms).collect(), missed }
    }

    /// Returns the table as arrays with the colours in a given order.
    fn arrays(&self, order: [usize; 3]) -> [fabkit_export::NpyArray; 4] {
        let of = |k: usize| {
            let values = self.terms.iter().flat_map(|colors| colors[order[k]]).collect();
            array(["grad_r", "grad_g", "grad_b"][k], &[BINS, BINS, TERMS], NpyValues::F64(values))
        };
        let bins = array("bins", &[], NpyValues::U16(vec![BINS as u16]));
        [bins, of(0), of(1), of(2)]
    }
}

/// Returns the width of a bin of angles, rad.
fn bin_width_rad() -> f64 {
    std::f64::consts::FRAC_PI_2 / (BINS - 1) as f64
}

impl CoatScene<'_> {
    /// Returns the light of a place whose surface rises by `climbs`, in intensities.
    fn sloped_light(&self, spot: &Spot, climbs: &Vector3<f64>) -> Rgb {
        let facing = (-spot.outward - climbs).normalize();
        self.light(spot, &facing, &mut |_| false)
    }

    fn light(
        &self,
        spot: &Spot,
        facing: &Vector3<f64>,
        is_hidden: &mut dyn FnMut(&Vector3<f64>) -> bool,
    ) -> Rgb {
        let light = self.shade(&spot.place, facing, &spot.direction, 0.0, is_hidden);
        light.map(|part| self.exposure * part)
    }
}

/// Returns the loss of intensity beside an edge, by colour, then direction, height and distance: light from behind the
/// edge is blocked.
fn shadows(coat: &CoatScene<'_>, spot: &Spot, pixel_mm: f64) -> [Vec<Vec<f64>>; 3] {
    let facing = -spot.outward;
    let lit = coat.light(spot, &facing, &mut |_| false);
    let of = |k: usize| {
        let way = (k / SHADOW_HEIGHTS) as f64 / 10.0;
        let height_mm = (0.45 + (k % SHADOW_HEIGHTS) as f64 / 10.0 - 0.6).max(0.0);
        let away = spot.surface_gradient([way.cos(), way.sin()], pixel_mm).normalize();
        let mut lists: [Vec<f64>; 3] = Default::default();
        let mut is_over = [false; 3];
        for step in 1..=SHADOW_STEPS {
            let far_mm = step as f64 * SHADOW_STEP_PX * pixel_mm;
            let now = coat.light(spot, &facing, &mut |arrives| {
                // Light from behind the edge is blocked unless it passes above or beside it. Gels round their edges:
                // the top lies as far behind the foot as it is high.
                let [back, up] = [arrives.dot(&away), -arrives.dot(&facing)];
                back > 0.0 && up * (far_mm + height_mm) < back * height_mm
            });
            for color in 0..3 {
                let darker = now[color] - lit[color];
                is_over[color] |= darker > -SHADOW_ENDS;
                if !is_over[color] {
                    lists[color].push(darker);
                }
            }
            if is_over == [true; 3] {
                break;
            }
        }
        lists
    };
    let all: Vec<[Vec<f64>; 3]> =
        (0..SHADOW_DIRECTIONS * SHADOW_HEIGHTS).into_par_iter().map(of).collect();
    std::array::from_fn(|color| all.iter().map(|lists| lists[color].clone()).collect())
}

/// Returns the settings that TacEx reads beside the tables, relative to the image's width and height. The deformation
/// of the gel around an object is Taxim's, in millimetres of its own sensor: neither elastic nor this sensor's.
fn tacex_settings([width, height]: [u32; 2], pixel_mm: f64) -> Value {
    let sides = [f64::from(width), f64::from(height)];
    let same = |px: f64| TAXIM_SIZE_PX.map(|side| px / side);
    let mm = |px: f64| sides.map(|side| px * TAXIM_PIXEL_MM / pixel_mm / side);
    // OpenCV's standard deviation for a kernel given only by its width.
    let sigma = |kernel: f64| 0.3 * ((kernel - 1.0) / 2.0 - 1.0) + 0.8;
    let pyramid = KERNELS_PX.map(|kernel| mm(sigma(kernel)));
    json!({
        "simulator": {
            "initial_frame_sigma_rel": same(50.0),
            "diff_threshold": 5,
            "frame_mixing_percentage": 0.15,
            "shadow_step_rel": sides.map(|side| SHADOW_STEP_PX / side),
            "discretize_precision": 0.1,
            "height_precision": 0.1,
            "fan_angle": 0.1,
            "fan_precision": 0.05,
            "contact_scale": 0.4,
            "deform_pyramid_sigma_rel": [pyramid.map(|[x, _]| x), pyramid.map(|[_, y]| y)],
            "deform_final_sigma_rel": mm(2.0),
            "shadow_blur_sigma_rel": same(sigma(5.0)),
            "shadow_attachment_kernel_size_rel": same(5.0),
        },
        "sensor": { "pixmm": pixel_mm, "num_bins": BINS, "w": width, "h": height },
    })
}
