//! Rendering of translucent layers over a black background: thicker layers are brighter.

use fabkit_depth::ground_truth::{DepthMap, NO_LABEL};
use fabkit_files::Error;
use fabkit_geometry::{Lighting, Point3, Rgb, Scratch, Sensor};
use fabkit_light::LayerBlur;
use fabkit_scene::press_simulation::ContactSolution;
use rayon::prelude::*;

use super::scene::{LayerGeometry, path_length_mm};
use super::{CameraGain, LightConstants, RenderedLight};

/// Difference of thickness below which layers count as evenly thick, mm.
const EVEN_MM: f64 = 1e-6;

/// A sensor in a lighting that shows the thickness of its layers.
#[derive(Debug)]
pub struct LayerScene<'a> {
    /// Surface, layers and light sources.
    pub scene: LayerGeometry<'a>,
    pub(super) constants: &'a LightConstants,
    pub(super) exposure: f64,
    pub(super) camera_gain: CameraGain,
    /// Distance between the surface points of neighbouring rays, mm, where maps are parts of an image.
    ray_mm: Option<f64>,
    /// Rays of the surface at rest, where they are kept.
    at_rest: Option<RestImage>,
}

/// Layers along a ray, on the surface at rest.
#[derive(Clone, Copy, Debug)]
pub struct RestRay {
    /// Point where the ray meets the surface, sensor frame, mm.
    pub place: Point3<f64>,
    /// Thickness of the layers at that point along the normal, mm.
    pub thick_mm: f64,
    /// Length of the ray in the layers, mm.
    pub path_mm: f64,
}

/// Intersection of a ray with the layers.
#[derive(Clone, Copy, Debug)]
struct LayerHit {
    /// Irradiance there, relative to the mean over the surface.
    lit: f64,
    thickness_mm: f64,
    /// Length of the ray in the layers, mm.
    path_mm: f64,
}

/// What each ray of a part of an image meets of the layers.
#[derive(Clone, Debug)]
pub(crate) struct LayerHits {
    hits: Vec<Option<LayerHit>>,
    width: usize,
    /// Distance between the surface points of neighbouring rays, mm.
    ray_mm: f64,
}

impl LayerHits {
    /// Takes the rays to be this many times as far apart as those of the image that the scene was made for.
    pub(crate) fn with_larger_pixels(self, larger: f64) -> Self {
        Self { ray_mm: self.ray_mm * larger, ..self }
    }

    /// Returns the lateral spread of light within the pixels that see a layer.
    fn spread(&self, constants: &LightConstants) -> LayerBlur {
        let is_layer = self.hits.iter().map(Option::is_some).collect();
        LayerBlur::new(is_layer, self.width, constants.spread_mm.value / self.ray_mm)
    }
}

/// Buffers that a worker reuses from ray to ray.
type Buffers = (Scratch, Vec<[f64; 2]>);

/// Rays of the surface at rest, for reuse where a press moves nothing.
#[derive(Debug)]
struct RestImage {
    /// Range of each ray to the surface, mm.
    range_mm: Vec<f64>,
    /// Intensity, before lateral spread, and thickness of each ray, mm.
    seen: Vec<(f64, f64)>,
    /// Lateral spread of light.
    spread: LayerBlur,
    /// Intensities after the spread.
    grey: Vec<f64>,
    /// Thickness of layers that are equally thick everywhere, mm.
    even_mm: Option<f64>,
}

impl<'a> LayerScene<'a> {
    /// Sets up surface, layers and exposure for this lighting.
    ///
    /// # Errors
    /// Returns an error for light sources or bodies that light cannot be traced through.
    pub fn new(
        sensor: &'a Sensor,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        let scene = LayerGeometry::new(sensor, lighting, constants)?;
        // The middle gets its intensity first; then everything is dimmed if another place would be white.
        let exposure =
            scene.middle_light_and_path().map_or(1.0, |[lit, mm]| constants.exposure(lit, mm))
                * constants.exposure_limit_factor(scene.relative_peak());
        let camera_gain = constants.diffuser_gain();
        let exposure = exposure * camera_gain.light_factor();
        Ok(Self { scene, constants, exposure, camera_gain, ray_mm: None, at_rest: None })
    }

    /// Uses the ray spacing of `map` for maps that are parts of an image of the same resolution.
    pub fn for_crops_of(self, map: &DepthMap<'_>) -> Self {
        Self { ray_mm: Some(ray_spacing_mm(map)), ..self }
    }

    pub(super) fn words(&self) -> [String; 2] {
        [format!("thickness of {}", self.scene.layers.join(" and ")), self.scene.lamps.clone()]
    }

    /// Keeps the rays of the surface at rest, so that a press recomputes only the rays that it changes.
    pub(super) fn prepare(&mut self, map: &DepthMap<'_>) {
        let seen = self.rays(map, None);
        let spread = self.spread(self.constants, map, &seen);
        let mut grey: Vec<f64> = seen.iter().map(|(grey, _)| *grey).collect();
        spread.apply(&mut grey);
        let range_mm = map.range_mm().to_vec();
        let known = seen.iter().map(|(_, mm)| *mm).filter(|mm| mm.is_finite());
        let [least, most] = known.fold([f64::INFINITY, 0.0], |[least, most], mm| {
            [f64::min(least, mm), f64::max(most, mm)]
        });
        let even_mm = (most - least < EVEN_MM).then_some(f64::midpoint(least, most));
        self.at_rest = Some(RestImage { range_mm, seen, spread, grey, even_mm });
    }

    /// Computes intensities and thickness for the rays of a map.
    pub fn paint(&self, map: &DepthMap<'_>, answer: Option<&ContactSolution<'_>>) -> RenderedLight {
        let rays = self.rays(map, answer);
        let mut grey: Vec<f64> = rays.iter().map(|(grey, _)| *grey).collect();
        match &self.at_rest {
            // The spread is linear, so only the change from rest is spread. The change is 0 almost everywhere.
            Some(rest) => {
                grey.iter_mut().zip(&rest.seen).for_each(|(now, before)| *now -= before.0);
                rest.spread.apply(&mut grey);
                grey.iter_mut().zip(&rest.grey).for_each(|(change, before)| *change += before);
            }
            None => self.spread(self.constants, map, &rays).apply(&mut grey),
        }
        let light: Vec<Rgb> = grey.into_iter().map(|grey| [grey; 3]).collect();
        let thickness_mm = rays.into_iter().map(|(_, mm)| mm).collect();
        RenderedLight { light, thickness_mm, marks: Vec::new(), not_known: Vec::new() }
    }

    /// Computes the intensities of one surface for each of several sets of constants. The geometry is traced once; rays
    /// kept from the surface at rest are not used.
    pub fn grey_by_each<const N: usize>(
        &self,
        constants: [&LightConstants; N],
        map: &DepthMap<'_>,
        answer: Option<&ContactSolution<'_>>,
    ) -> [Vec<f64>; N] {
        let hits = self.hits(map, answer);
        constants.map(|constants| {
            let mut grey = self.grey_of(constants, &hits);
            hits.spread(constants).apply(&mut grey);
            grey
        })
    }

    /// Returns what the rays of a map meet.
    pub(crate) fn hits(
        &self,
        map: &DepthMap<'_>,
        answer: Option<&ContactSolution<'_>>,
    ) -> LayerHits {
        let look = self.hit_finder(map, answer);
        let rays = 0..map.range_mm().len();
        let hits = rays.into_par_iter().map_init(Buffers::default, look).collect();
        let ray_mm = self.ray_mm.unwrap_or_else(|| ray_spacing_mm(map));
        LayerHits { hits, width: map.width_px() as usize, ray_mm }
    }

    /// Computes how much darker each ray is than at rest, for other constants.
    pub(crate) fn grey_lost(
        &self,
        constants: &LightConstants,
        rest: &LayerHits,
        pressed: &LayerHits,
    ) -> Vec<f64> {
        let mut lost = self.grey_of(constants, rest);
        let now = self.grey_of(constants, pressed);
        lost.iter_mut().zip(now).for_each(|(rest, now)| *rest -= now);
        // The spread is linear, so only the change is spread.
        rest.spread(constants).apply(&mut lost);
        lost
    }

    /// Computes intensities before the lateral spread.
    fn grey_of(&self, constants: &LightConstants, seen: &LayerHits) -> Vec<f64> {
        seen.hits.iter().map(|met| self.intensity(constants, *met).0).collect()
    }

    /// Returns what each ray meets of the layers at rest; `None` for rays that meet no layer.
    pub fn seen_at_rest(&self, map: &DepthMap<'_>) -> Vec<Option<RestRay>> {
        let ray = |(scratch, found): &mut Buffers, i: usize| {
            let (place, direction) = map.arrival(i).filter(|_| map.label()[i] != NO_LABEL)?;
            let (_, outward) = self.scene.touch.depth_mm(&place);
            let thick_mm = self.scene.thickness_mm((&place, &outward), scratch, found)?;
            let path_mm = path_length_mm(thick_mm, &outward, &direction);
            Some(RestRay { place, thick_mm, path_mm })
        };
        (0..map.range_mm().len()).into_par_iter().map_init(Buffers::default, ray).collect()
    }

    /// Returns the lateral spread of light within the pixels that see a layer.
    fn spread(
        &self,
        constants: &LightConstants,
        map: &DepthMap<'_>,
        seen: &[(f64, f64)],
    ) -> LayerBlur {
        let is_layer = seen.iter().map(|(_, mm)| mm.is_finite()).collect();
        let ray_mm = self.ray_mm.unwrap_or_else(|| ray_spacing_mm(map));
        let sigma_px = constants.spread_mm.value / ray_mm;
        LayerBlur::new(is_layer, map.width_px() as usize, sigma_px)
    }

    /// Computes intensity and thickness, mm, for each ray.
    fn rays(&self, map: &DepthMap<'_>, answer: Option<&ContactSolution<'_>>) -> Vec<(f64, f64)> {
        let (look, rest) = (self.hit_finder(map, answer), self.at_rest.as_ref());
        let ray = |memory: &mut Buffers, i: usize| {
            // A ray whose range is exactly that at rest meets unchanged layers.
            let as_before = rest.filter(|rest| map.range_mm()[i] == rest.range_mm[i]);
            as_before.map_or_else(|| self.intensity(self.constants, look(memory, i)), |r| r.seen[i])
        };
        (0..map.range_mm().len()).into_par_iter().map_init(Buffers::default, ray).collect()
    }

    /// Returns a function from a ray's index to its intersection with the layers.
    fn hit_finder<'s>(
        &'s self,
        map: &'s DepthMap<'_>,
        answer: Option<&'s ContactSolution<'_>>,
    ) -> impl Fn(&mut Buffers, usize) -> Option<LayerHit> + Sync + 's {
        let scene = &self.scene;
        let lower = answer.and_then(|answer| answer.lower_face(scene.innermost()));
        let even_mm = self.at_rest.as_ref().and_then(|rest| rest.even_mm);
        move |(scratch, found), i| {
            let (place, direction) = map.arrival(i).filter(|_| map.label()[i] != NO_LABEL)?;
            // The foot of the point on the undeformed surface, its depth below that surface, and the layers below it at
            // rest.
            let (depth_mm, outward) = scene.touch.depth_mm(&place);
            let foot = place + depth_mm * outward;
            let thick_mm =
                even_mm.or_else(|| scene.thickness_mm((&foot, &outward), scratch, found))?;
            let lower_mm = lower.as_ref().map_or(0.0, |lower| lower.outwards_mm(&foot));
            let thickness_mm = (thick_mm - depth_mm - lower_mm).max(0.0);
            let path_mm = path_length_mm(thickness_mm, &outward, &direction);
            Some(LayerHit { lit: scene.lit.irradiance(&foot), thickness_mm, path_mm })
        }
    }

    /// Returns the intensity of a ray and the thickness of the layers, mm; a constant background and NaN without
    /// layers.
    fn intensity(&self, constants: &LightConstants, met: Option<LayerHit>) -> (f64, f64) {
        let Some(met) = met else { return (constants.beside_grey.value, f64::NAN) };
        let sent = constants.ground_grey.value
            + constants.layer_grey.value * constants.layer().reflectance(met.path_mm);
        (self.exposure * met.lit * sent, met.thickness_mm)
    }
}

/// Returns the median distance, mm, between the surface points of neighbouring rays in a row; infinity without any.
///
/// ```
/// use fabkit_capture::ray_spacing_mm;
/// use fabkit_scene::{Cast, press_simulation::ContactModel};
///
/// # let yaml = fabkit_designs::builtin_yaml("gelsight-like").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("gelsight-like.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([64, 48])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// let spacing_mm = |samples| {
///     let cast = Cast { samples, ..Cast::at_rest(ContactModel::Rigid) };
///     scene.cast(&cast, 0, |seen| Ok::<_, fabkit_files::Error>(ray_spacing_mm(seen.map)))
/// };
/// // 64 pixels span some 19 mm; twice as many rays are half as far apart.
/// assert!((spacing_mm(1)? - 19.0 / 64.0).abs() < 0.03);
/// assert!((spacing_mm(2)? - 0.5 * spacing_mm(1)?).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn ray_spacing_mm(map: &DepthMap<'_>) -> f64 {
    let places: Vec<_> = map.point_in_sensor().collect();
    let width = map.width_px() as usize;
    // Pairs across the surface's outline have no distance on it.
    let both = |pair: &[usize; 2]| pair.iter().all(|i| map.label()[*i] != NO_LABEL);
    let beside = (1..places.len()).filter(|i| i % width != 0).map(|i| [i - 1, i]).filter(both);
    let mut apart: Vec<f64> = beside.map(|[a, b]| (places[b] - places[a]).norm()).collect();
    apart.sort_by(f64::total_cmp);
    apart.get(apart.len() / 2).copied().unwrap_or(f64::INFINITY)
}
