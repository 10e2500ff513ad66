//! Geometry and irradiance of sensors with translucent or glowing layers.

use fabkit_files::Error;
use fabkit_geometry::{
    Assembly, Body, CompiledSolid, Lighting, Point3, Pose, Ray, Scratch, Sensor, SurfacePoints,
    TouchSurface, Vector3, VisibleEffect,
};
use fabkit_light::Emitters;

use super::irradiance_table::IrradianceTable;
use super::{CaptureError, LightConstants};

/// Smallest cosine between ray and normal in path lengths. Flatter rays are treated as if they had it.
const LEAST_COSINE: f64 = 0.2;

/// Gap below which layers count as touching, mm.
const TOUCHING_MM: f64 = 1e-3;

/// Surface, layers and light sources that form a sensor's images.
///
/// ```
/// use fabkit_capture::{LayerGeometry, LightConstants, find_lighting, surface_middle};
/// use fabkit_geometry::Scratch;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let sensor = &project.design.sensor;
/// let lighting = find_lighting(sensor, None)?;
/// let layers = LayerGeometry::new(sensor, lighting, &LightConstants::for_sensor(sensor))?;
/// assert_eq!(layers.layers, ["translucent-gel"]);
/// let (apex, outward) = surface_middle(layers.touch).ok_or("no middle")?;
/// let thick_mm = layers.thickness_mm((&apex, &outward), &mut Scratch::default(), &mut Vec::new());
/// // The cavities differ by 1.5 mm, of which the coat takes 0.05 mm.
/// assert!((thick_mm.ok_or("no layer")? - 1.45).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct LayerGeometry<'a> {
    /// The surface that is pressed.
    pub touch: &'a TouchSurface,
    /// Names of the layers, from the inside out.
    pub layers: Vec<String>,
    /// Description of the light sources.
    pub lamps: String,
    /// Irradiance over the surface.
    pub lit: IrradianceTable,
    solids: Solids,
    /// Shift of the core of the layers' mold, sensor frame, mm.
    core_off_mm: Vector3<f64>,
    pupil: Point3<f64>,
}

impl<'a> LayerGeometry<'a> {
    /// Builds the scene for a lighting that shows the layers' thickness or their glow.
    ///
    /// # Errors
    /// [`CaptureError`] for a lighting that shows something else, and if no light reaches the surface.
    pub fn new(
        sensor: &'a Sensor,
        lighting: &Lighting,
        constants: &LightConstants,
    ) -> Result<Self, Error> {
        let layers: Vec<String> = match &lighting.effect {
            VisibleEffect::Thickness { layers } => layers.clone(),
            VisibleEffect::Fluorescence { layers } => {
                layers.iter().map(|(layer, _)| layer.clone()).collect()
            }
            _ => Vec::new(),
        };
        let touch = sensor.touch.as_ref();
        let touch = touch.ok_or_else(|| CaptureError::NoSurface { sensor: sensor.name.clone() })?;
        let missing = || CaptureError::UnknownLighting { sensor: sensor.name.clone() };
        let bodies = layers.iter().map(|layer| sensor.body(layer).ok_or_else(missing));
        let bodies = bodies.collect::<Result<Vec<_>, _>>()?;
        if bodies.is_empty() {
            return Err(missing().into());
        }
        // Exciting light is attenuated along its own slanted path, whose direction depends on the layer's index.
        let slanted_in =
            lighting.is_fluorescent().then(|| bodies[0].substance.refractive_index.unwrap_or(1.0));
        let solids = bodies.into_iter().map(placed_solid).collect::<Result<Vec<_>, _>>()?;
        let solids = Solids(solids);
        let emitters = Emitters::new(sensor, lighting).map_err(CaptureError::NoLight)?;
        let points = SurfacePoints::new(touch).map_err(Error::bug)?;
        let inner_mm = |point: &Point3<f64>, outward: &Vector3<f64>| {
            let extent = solids.extent((point, outward), &mut Scratch::default(), &mut Vec::new());
            // Light arrives from inside, so irradiance is computed at the innermost face.
            extent.map_or(0.0, |[_, to]| to)
        };
        let lit =
            IrradianceTable::new(&points, &emitters, inner_mm, constants.bounce.value, slanted_in);
        let lit = lit.ok_or_else(|| CaptureError::Dark { sensor: sensor.name.clone() })?;
        let pupil = sensor.camera.sensor_from_camera.point(Point3::origin());
        let lamps = emitters.description;
        let core_off_mm = constants.core_off_mm;
        Ok(Self { touch, layers, lamps, lit, solids, core_off_mm, pupil })
    }

    /// Returns the relative irradiance in the middle of the surface at rest, and the path length in the layers there,
    /// mm.
    pub(super) fn middle_light_and_path(&self) -> Option<[f64; 2]> {
        let (point, outward) = surface_middle(self.touch)?;
        Some([self.lit.irradiance(&point), self.paths_mm(&point, &outward, 0.0)[0]])
    }

    /// Returns the largest irradiance, except near the foot, relative to that in the middle.
    pub(super) fn relative_peak(&self) -> f64 {
        let middle =
            surface_middle(self.touch).map_or(1.0, |(point, _)| self.lit.irradiance(&point));
        self.lit.maximum() / middle
    }

    /// Returns the name of the innermost layer.
    pub fn innermost(&self) -> &str {
        &self.layers[0]
    }

    /// Returns the intervals of a straight ray in the layers, in order: start and end, mm, and index of the layer.
    pub(super) fn stretches(&self, ray: &Ray, scratch: &mut Scratch) -> Vec<(f64, f64, usize)> {
        self.solids.stretches(ray, scratch)
    }

    /// Returns the thickness of all layers below a point of the undeformed surface, along the normal, mm; `None` where
    /// there are none.
    pub fn thickness_mm(
        &self,
        place: (&Point3<f64>, &Vector3<f64>),
        scratch: &mut Scratch,
        found: &mut Vec<[f64; 2]>,
    ) -> Option<f64> {
        let drawn = self.solids.extent(place, scratch, found).map(|[from, to]| to - from);
        // On the side towards which the core is shifted, the layers are thinner.
        drawn.map(|mm| (mm - self.core_off_mm.dot(place.1)).max(0.0))
    }

    /// Returns the length of the camera's straight path in the layers at rest, and with layers thicker by `gains_mm`,
    /// mm. The camera is at its pose in the design.
    pub fn paths_mm(&self, rest: &Point3<f64>, outward: &Vector3<f64>, gains_mm: f64) -> [f64; 2] {
        let thick_mm = self
            .thickness_mm((rest, outward), &mut Scratch::default(), &mut Vec::new())
            .unwrap_or(0.0);
        let direction = (rest - self.pupil).normalize();
        [0.0, gains_mm]
            .map(|gains_mm| path_length_mm((thick_mm + gains_mm).max(0.0), outward, &direction))
    }
}

/// Compiles a body's solid at its place in the finished sensor.
///
/// ```
/// # let yaml = fabkit_designs::builtin_yaml("gelsight-like").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("gelsight-like.yaml", yaml, &[])?;
/// // The plate behind the gel is a sheet of 3 mm.
/// let plate = project.design.sensor.body("plate").ok_or("no such body")?;
/// let size_mm = fabkit_capture::placed_solid(plate)?.bounds().size_mm();
/// assert!((size_mm[2] - 3.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn placed_solid(body: &Body) -> Result<CompiledSolid, Error> {
    let place = body.placements.iter().find(|place| place.assembly == Assembly::sensor());
    let pose = place.map_or_else(Pose::identity, |place| place.assembly_from_body);
    CompiledSolid::new(&body.solid.clone().placed(pose)).map_err(Error::bug)
}

/// Returns the middle of the surface and its normal.
///
/// ```
/// use fabkit_geometry::{Point3, Vector3};
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// // A hemisphere of radius 15 mm on a wall of 6 mm.
/// let touch = project.design.sensor.touch.as_ref().ok_or("no surface")?;
/// let (apex, outward) = fabkit_capture::surface_middle(touch).ok_or("no middle")?;
/// assert!((apex - Point3::new(0.0, 0.0, 21.0)).norm() < 1e-9);
/// assert!((outward - Vector3::z()).norm() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn surface_middle(touch: &TouchSurface) -> Option<(Point3<f64>, Vector3<f64>)> {
    match SurfacePoints::new(touch).ok()? {
        SurfacePoints::Dome(dome) => dome.point_in_direction(0.0, 0.0),
        SurfacePoints::Plane(pad) => {
            pad.at(pad.bounds_mm().map(|[least, most]| f64::midpoint(least, most)))
        }
    }
}

/// Returns the path length along a direction in a layer of a given thickness. The layer's faces are taken as parallel.
pub(super) fn path_length_mm(
    thickness_mm: f64,
    outward: &Vector3<f64>,
    direction: &Vector3<f64>,
) -> f64 {
    thickness_mm / outward.dot(direction).max(LEAST_COSINE)
}

/// Solids of the layers, from the inside out.
#[derive(Debug)]
struct Solids(Vec<CompiledSolid>);

impl Solids {
    fn stretches(&self, ray: &Ray, scratch: &mut Scratch) -> Vec<(f64, f64, usize)> {
        let mut all = Vec::new();
        for (layer, solid) in self.0.iter().enumerate() {
            let mut found = Vec::new();
            solid.stretches_into(ray, scratch, &mut found);
            all.extend(found.into_iter().map(|[from, to]| (from, to, layer)));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    }

    /// Returns start and end, mm, of the connected layers below a point along the normal, whatever overlaps.
    fn extent(
        &self,
        (point, outward): (&Point3<f64>, &Vector3<f64>),
        scratch: &mut Scratch,
        found: &mut Vec<[f64; 2]>,
    ) -> Option<[f64; 2]> {
        // The ray starts 1 mm outside, so that it crosses the surface itself. This 1 mm is subtracted again.
        let ray = Ray { origin: point + outward, direction: -outward };
        if let [only] = &self.0[..] {
            only.stretches_into(&ray, scratch, found);
            return found.first().map(|[from, to]| [from - 1.0, to - 1.0]);
        }
        let mut extent: Option<[f64; 2]> = None;
        for (from, to, _) in self.stretches(&ray, scratch) {
            match &mut extent {
                None => extent = Some([from, to]),
                // Touching or overlapping layers continue the extent; the first gap ends it.
                Some([_, last]) if from - *last < TOUCHING_MM => *last = last.max(to),
                Some(_) => break,
            }
        }
        extent.map(|[from, to]| [from - 1.0, to - 1.0])
    }
}
