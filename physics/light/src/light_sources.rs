//! Light sources of a sensor, and the direct light from them.

use std::f64::consts::PI;

use fabkit_geometry::{
    Assembly, Body, BodyKind, CompiledSolid, InvalidSolid, LightSourceGroup, Lighting,
    OpticalClarity, Point3, Ray, Rgb, Sensor, Solid, Vector3, VisibleEffect, WHITE,
};
use fabkit_optics::{InvalidStack, OpticalStack, Tracer};
use rayon::prelude::*;

use crate::{Arrival, Planes};

/// Sampling lines along each side of a light source, on which its faces are found.
const SAMPLING_LINES: usize = 16;
/// Sampling lines along each side if all three axes are sampled: about the same number of pieces in all.
const SAMPLING_LINES_PER_AXIS: usize = 10;
/// Approximate number of pieces of all light sources together where each piece casts its own shadows.
const PIECES_WITH_SHADOWS: usize = 24;
/// Part of the light that passes a diffuser whose material does not state it. Chosen: frosted and opal sheets pass 30 to
/// 90 %.
pub const DEFAULT_TRANSMITTANCE: f64 = 0.5;
/// Distance from a light source at which a ray counts as having reached it, mm.
const ARRIVAL_TOLERANCE_MM: f64 = 1e-3;
/// Distance from their layer at which rays start, mm, so that they do not hit it.
const RAY_OFFSET_MM: f64 = 1e-3;

/// Minimum cosine inside a layer. Flatter light is treated as if it had this angle.
const MIN_COSINE: f64 = 0.05;

/// Reason why the illumination of a sensor cannot be computed.
///
/// ```
/// # use fabkit_geometry::{Angle, NominalCamera, Pose};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// use fabkit_geometry::{Lighting, Sensor, VisibleEffect};
/// use fabkit_light::Emitters;
///
/// // Lamps that are not drawn give no light.
/// let effect = VisibleEffect::Markers { marks: "dots".to_owned() };
/// let sensor = Sensor::new("dark", "A dark one", "", camera, []);
/// let error = Emitters::new(&sensor, &Lighting::from_body("white", "led", effect)).unwrap_err();
/// assert_eq!(error.to_string(), "`dark` has no light sources that shine at its surface");
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LightingError {
    /// Sensor without light sources.
    #[error("`{sensor}` has no light sources that shine at its surface")]
    NoLamps {
        /// Name of the sensor.
        sensor: String,
    },
    /// Invalid solid of a light source.
    #[error(transparent)]
    Solid(#[from] InvalidSolid),
    /// Bodies through which light cannot be traced.
    #[error(transparent)]
    Stack(#[from] InvalidStack),
}

/// Piece of a face that emits light as a Lambertian source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// Centre, sensor frame, mm.
    pub place: Point3<f64>,
    /// Outward normal, unit.
    pub outward: Vector3<f64>,
    /// Area, mm2, times brightness.
    pub power: f64,
    /// Colour of the light.
    pub color: Rgb,
    /// Index of the light source that it belongs to.
    pub source: usize,
}

/// All emitting faces of a sensor, and the bodies that block or refract their light.
///
/// ```
/// # use fabkit_geometry::{Angle, NominalCamera, Pose};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// use fabkit_geometry::{Assembly, Body, Lighting, Placement, Point3, Sensor, Solid, Vector3, VisibleEffect};
/// use fabkit_light::Emitters;
///
/// // An LED of 0.1 x 0.1 mm, whose upper face at z = 0 shines up.
/// let led = Body::bought("led", "LED", Solid::cuboid(0.1, 0.1, 0.1).at_z(-0.1))
///     .as_light_source()
///     .placed([Placement::in_place(Assembly::sensor())]);
/// let sensor = Sensor::new("lit", "A lit one", "", camera, [led]);
/// let effect = VisibleEffect::Markers { marks: "dots".to_owned() };
/// let emitters = Emitters::new(&sensor, &Lighting::from_body("white", "led", effect))?;
/// // At twice the distance a quarter arrives: 0.01 mm2 / (10 mm)^2 and (20 mm)^2.
/// let [near, far] = [10.0, 20.0].map(|z_mm| (Point3::new(0.0, 0.0, z_mm), -Vector3::z()));
/// let light = emitters.irradiance(&[near, far]);
/// assert!((light[0][0] - 1e-4).abs() < 1e-7 && (light[0][0] / light[1][0] - 4.0).abs() < 0.01);
/// # Ok::<(), fabkit_light::LightingError>(())
/// ```
#[derive(Debug)]
pub struct Emitters {
    emitters: Vec<Emitter>,
    planes: Planes,
    stack: OpticalStack,
    /// Description of the light sources.
    pub description: String,
}

impl Emitters {
    /// Finds the emitting faces of a sensor under a lighting.
    ///
    /// These are the faces of the light sources that point along the z axes of their bodies. If the sensor has a
    /// diffuser (the body that the lighting names, or else any translucent body that is not cast), and the lighting does not excite fluorescence, they are all
    /// faces of the diffuser instead, each piece as bright as the light sources make it from behind.
    ///
    /// # Errors
    /// If nothing emits light, a solid is invalid, or light cannot be traced through the bodies.
    pub fn new(sensor: &Sensor, lighting: &Lighting) -> Result<Self, LightingError> {
        let no_lamps = || LightingError::NoLamps { sensor: sensor.name.clone() };
        // Only bodies of the assembled sensor emit light.
        let in_use = Assembly::sensor();
        let count = |group: &LightSourceGroup| {
            let body = sensor.body(&group.body);
            let places = body.map_or(&[][..], |body| &body.placements);
            places.iter().filter(|place| place.assembly == in_use).count()
        };
        let lines = sampling_lines(lighting, lighting.light_sources.iter().map(count).sum());
        let mut lamps = Vec::new();
        for group in &lighting.light_sources {
            let body = sensor.body(&group.body).ok_or_else(no_lamps)?;
            let solid = body.light_source.as_ref().ok_or_else(no_lamps)?;
            let first = lamps.last().map_or(0, |lamp: &Emitter| lamp.source + 1);
            let mut found = sample_faces(body, solid, EmittingFaces::Forwards, lines)?;
            for piece in &mut found {
                piece.color = group.color(piece.source);
                // Light sources are numbered through all groups.
                piece.source += first;
            }
            lamps.extend(found);
        }
        if lamps.is_empty() {
            return Err(no_lamps());
        }
        let spreads = |body: &&Body| {
            body.clarity() == OpticalClarity::Translucent
                && body.kind != BodyKind::Cast
                && body.light_source.is_none()
        };
        // Light is taken to travel straight except through level plates; other refraction is neglected.
        let planes = Planes::from_sensor(sensor)?;
        let stack = OpticalStack::without_refraction(&without_displayed_bodies(sensor, lighting))?;
        let own = Self {
            emitters: lamps,
            planes,
            stack,
            description: format!("{}s", lighting.light_sources[0].body),
        };
        // The light that excites fluorescence does not pass a diffuser: white plastic absorbs it.
        let named = lighting.diffuser.as_ref().and_then(|name| sensor.body(name)).filter(spreads);
        let diffuser = named.or_else(|| sensor.bodies.iter().find(spreads));
        let Some(diffuser) = diffuser.filter(|_| !lighting.is_fluorescent()) else {
            return Ok(own);
        };
        let passes = diffuser.substance.optics.transmission.as_ref();
        let transmittance = passes.map_or(DEFAULT_TRANSMITTANCE, |passes| passes.value);
        let mut spread = sample_faces(
            diffuser,
            &diffuser.solid,
            EmittingFaces::AllAround,
            SAMPLING_LINES_PER_AXIS,
        )?;
        for piece in &mut spread {
            let from_behind = |lamp: &Emitter| lamp.form_factor(&piece.place, &-piece.outward);
            // A Lambertian diffuser spreads the transmitted light: radiance is irradiance over pi.
            let lit =
                own.emitters.iter().map(|lamp| transmittance * lamp.power * from_behind(lamp) / PI);
            let color = [0, 1, 2].map(|part| {
                let colored = own.emitters.iter().zip(lit.clone());
                colored.map(|(lamp, lit)| lit * lamp.color[part]).sum::<f64>()
            });
            // Brightness goes into the power, so that the colour has a maximum of 1.
            let brightest = color.iter().copied().fold(0.0, f64::max);
            piece.power *= brightest;
            piece.color = color.map(|part| if brightest > 0.0 { part / brightest } else { 0.0 });
        }
        spread.retain(|piece| piece.power > 0.0);
        if spread.is_empty() {
            return Ok(own);
        }
        let what = format!("{}, as bright as the light sources make it from behind", diffuser.name);
        Ok(Self { emitters: spread, description: what, ..own })
    }

    /// Returns the emitting pieces.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, NominalCamera, Pose};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_geometry::{Assembly, Body, Lighting, Placement, Sensor, Solid, Vector3, VisibleEffect};
    /// use fabkit_light::Emitters;
    ///
    /// let led = Body::bought("led", "LED", Solid::cuboid(2.0, 3.0, 1.0))
    ///     .as_light_source()
    ///     .placed([Placement::in_place(Assembly::sensor())]);
    /// let effect = VisibleEffect::Markers { marks: "dots".to_owned() };
    /// let sensor = Sensor::new("lit", "A lit one", "", camera, [led]);
    /// let emitters = Emitters::new(&sensor, &Lighting::from_body("white", "led", effect))?;
    /// // The pieces share the upper face: 2 mm x 3 mm, all of it facing up.
    /// let power: f64 = emitters.pieces().iter().map(|piece| piece.power).sum();
    /// assert!((power - 6.0).abs() < 1e-9);
    /// assert!(emitters.pieces().iter().all(|piece| piece.outward == Vector3::z()));
    /// # Ok::<(), fabkit_light::LightingError>(())
    /// ```
    pub fn pieces(&self) -> &[Emitter] {
        &self.emitters
    }

    /// Computes the arrival of a piece's light at a point below the layer of interest; `None` if an opaque body hides
    /// it. The density is that of the whole piece.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, NominalCamera, Pose};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_geometry::{Assembly, Body, Lighting, Placement, Point3, Sensor, Solid, VisibleEffect};
    /// use fabkit_light::Emitters;
    ///
    /// // A small LED below a disc of radius 1 mm, half way to the points at z = 10 mm.
    /// let led = Body::bought("led", "LED", Solid::cuboid(0.1, 0.1, 0.1).at_z(-0.1)).as_light_source();
    /// let disc = Body::bought("disc", "steel", Solid::cylinder(1.0, 0.1).at_z(5.0));
    /// let bodies = [led, disc].map(|body| body.placed([Placement::in_place(Assembly::sensor())]));
    /// let sensor = Sensor::new("lit", "A lit one", "", camera, bodies);
    /// # let effect = VisibleEffect::Markers { marks: "dots".to_owned() };
    /// let emitters = Emitters::new(&sensor, &Lighting::from_body("white", "led", effect))?;
    /// let is_lit = |x_mm| {
    ///     let place = Point3::new(x_mm, 0.0, 10.0);
    ///     emitters.arrival(&emitters.pieces()[0], &place, &mut emitters.tracer()).is_some()
    /// };
    /// // The shadow is twice as wide as the disc.
    /// assert_eq!([is_lit(1.8), is_lit(2.2)], [false, true]);
    /// # Ok::<(), fabkit_light::LightingError>(())
    /// ```
    pub fn arrival(
        &self,
        emitter: &Emitter,
        place: &Point3<f64>,
        tracer: &mut Tracer<'_>,
    ) -> Option<Arrival> {
        let mut found = self.planes.arrival(&emitter.place, place)?;
        found.density *= emitter.power * found.departure_direction.dot(&emitter.outward).max(0.0);
        let is_free = found.density > 0.0 && {
            // Each straight part of a refracted path is tested for shadows.
            let corners = if self.planes.is_empty() {
                vec![*place, emitter.place]
            } else {
                vec![*place, found.refraction_points[1], found.refraction_points[0], emitter.place]
            };
            corners.windows(2).all(|pair| is_free(&pair[0], &pair[1], tracer))
        };
        is_free.then_some(found)
    }

    /// Creates a tracer for [`Emitters::arrival`]; one is needed per thread.
    pub fn tracer(&self) -> Tracer<'_> {
        Tracer::new(&self.stack)
    }

    /// Computes the direct irradiance at points with unit normals, relative: with both cosines and the squared
    /// distance, shadows of opaque bodies, and refraction by level plates.
    pub fn irradiance(&self, places: &[(Point3<f64>, Vector3<f64>)]) -> Vec<Rgb> {
        self.sum_light(places, |cosine| cosine)
    }

    /// Computes the same irradiance with each contribution multiplied by its path length through a layer of refractive
    /// index `index`, relative to the thickness. Light from air is refracted where it enters; light from level plates
    /// has been refracted already.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, NominalCamera, Pose};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// # use fabkit_geometry::{Assembly, Body, Lighting, Placement, Point3, Sensor, Solid, Vector3, VisibleEffect};
    /// # let led = Body::bought("led", "LED", Solid::cuboid(0.1, 0.1, 0.1).at_z(-0.1))
    /// #     .as_light_source()
    /// #     .placed([Placement::in_place(Assembly::sensor())]);
    /// # let sensor = Sensor::new("lit", "A lit one", "", camera, [led]);
    /// # let lighting = Lighting::from_body("white", "led", VisibleEffect::Markers { marks: "dots".to_owned() });
    /// // A small LED at the origin lights a place at 60 degrees from its normal.
    /// let emitters = fabkit_light::Emitters::new(&sensor, &lighting)?;
    /// let place = [(Point3::new(10.0 * 3_f64.sqrt(), 0.0, 10.0), -Vector3::z())];
    /// let plain = emitters.irradiance(&place)[0][0];
    /// let longer = |index| emitters.irradiance_times_path(&place, index)[0][0] / plain;
    /// // In air the way through a layer is 1 / cos 60 degrees; in gel, into which light is bent, less.
    /// assert!((longer(1.0) - 2.0).abs() < 0.01);
    /// assert!((longer(1.41) - 1.0 / (1.0 - 0.75 / 1.41_f64.powi(2)).sqrt()).abs() < 0.01);
    /// # Ok::<(), fabkit_light::LightingError>(())
    /// ```
    pub fn irradiance_times_path(
        &self,
        places: &[(Point3<f64>, Vector3<f64>)],
        index: f64,
    ) -> Vec<Rgb> {
        let index = if self.planes.is_empty() { index } else { 1.0 };
        self.sum_light(places, |cosine| cosine / refracted_cosine(cosine, index))
    }

    /// Sums the light of all pieces at each point, each weighted by `part` of its cosine of incidence.
    fn sum_light(
        &self,
        places: &[(Point3<f64>, Vector3<f64>)],
        part: impl Fn(f64) -> f64 + Sync,
    ) -> Vec<Rgb> {
        let arrives = |tracer: &mut Tracer<'_>, (place, facing): &(Point3<f64>, Vector3<f64>)| {
            let from = place + RAY_OFFSET_MM * facing;
            let mut sum = [0.0; 3];
            for emitter in &self.emitters {
                // Pieces behind the surface cannot contribute, unless refraction bends their light.
                if (emitter.place - from).dot(facing) <= 0.0 && self.planes.is_empty() {
                    continue;
                }
                let Some(found) = self.arrival(emitter, &from, tracer) else { continue };
                let lit = found.density * part((-found.arrival_direction.dot(facing)).max(0.0));
                sum = [0, 1, 2].map(|part| sum[part] + lit * emitter.color[part]);
            }
            sum
        };
        let places = places.par_iter();
        places.map_init(|| self.tracer(), |tracer, at| arrives(tracer, at)).collect()
    }
}

/// Computes the mean path length of diffuse light through a layer, relative to its thickness. For light from air into a
/// refractive index n it is 2 n (n - sqrt(n^2 - 1)): Snell's law averaged over Lambert's.
///
/// ```
/// // Without bending 2, as known of diffuse light; into glass nearly straight.
/// assert!((fabkit_light::diffuse_path_ratio(1.0) - 2.0).abs() < 1e-12);
/// assert!((fabkit_light::diffuse_path_ratio(1.5) - 1.146).abs() < 1e-3);
/// ```
pub fn diffuse_path_ratio(index: f64) -> f64 {
    2.0 * index * (index - (index * index - 1.0).max(0.0).sqrt())
}

/// Computes the cosine of refraction for light that enters a refractive index from air.
fn refracted_cosine(cosine: f64, index: f64) -> f64 {
    let sine_squared = (1.0 - cosine * cosine).max(0.0) / (index * index);
    (1.0 - sine_squared).max(0.0).sqrt().max(MIN_COSINE)
}

impl Emitter {
    /// Computes the product of both cosines over the squared distance, 1/mm2.
    fn form_factor(&self, place: &Point3<f64>, facing: &Vector3<f64>) -> f64 {
        let way = self.place - place;
        let square = way.norm_squared();
        let both = way.dot(facing).max(0.0) * (-way.dot(&self.outward)).max(0.0);
        if square > 0.0 { both / (square * square) } else { 0.0 }
    }
}

/// Returns whether no opaque body lies between two points.
fn is_free(from: &Point3<f64>, to: &Point3<f64>, tracer: &mut Tracer<'_>) -> bool {
    let way = to - from;
    let distance_mm = way.norm();
    if distance_mm < ARRIVAL_TOLERANCE_MM {
        return true;
    }
    let path = tracer.follow(&Ray { origin: *from, direction: way / distance_mm });
    path.lead_mm + path.end_mm > distance_mm - ARRIVAL_TOLERANCE_MM
}

/// Returns a copy of the sensor without the coat, print or markers that the lighting displays. They move, so their
/// shadows are computed at their displaced positions elsewhere.
fn without_displayed_bodies(sensor: &Sensor, lighting: &Lighting) -> Sensor {
    let mut without = sensor.clone();
    let is_shown = |name: &String| match &lighting.effect {
        VisibleEffect::Slopes { coat, printed } => name == coat || printed.as_ref() == Some(name),
        VisibleEffect::Markers { marks } => name == marks,
        VisibleEffect::Thickness { .. }
        | VisibleEffect::Fluorescence { .. }
        | VisibleEffect::LiquidColumns { .. } => false,
    };
    without.bodies.retain(|body| !is_shown(&body.name));
    without
}

/// Selection of emitting faces.
#[derive(Clone, Copy, PartialEq)]
enum EmittingFaces {
    /// Faces that point along the body's z axis: those of a light source.
    Forwards,
    /// All faces: those of a diffuser.
    AllAround,
}

/// Returns the number of sampling lines along each side of a light source. It is smaller for many sources, and where
/// each piece casts its own shadows.
fn sampling_lines(lighting: &Lighting, lamps: usize) -> usize {
    match lighting.effect {
        VisibleEffect::Slopes { .. } => {
            ((PIECES_WITH_SHADOWS / lamps.max(1)) as f64).sqrt().floor().max(1.0) as usize
        }
        _ if lamps > 2 => SAMPLING_LINES / 4,
        _ => SAMPLING_LINES,
    }
}

/// Divides the faces of a solid into equally bright pieces, in all placements of its body, numbered by placement.
fn sample_faces(
    body: &Body,
    solid: &Solid,
    shines: EmittingFaces,
    lines: usize,
) -> Result<Vec<Emitter>, LightingError> {
    let mut pieces = Vec::new();
    // Sampled in the body's own frame, so that all light sources are divided alike.
    let compiled = CompiledSolid::new(solid)?;
    let mut own = Vec::new();
    for axis in 0..3 {
        if axis == 2 || shines == EmittingFaces::AllAround {
            add_faces_along(axis, &compiled, lines, &mut own);
        }
    }
    if shines == EmittingFaces::Forwards {
        own.retain(|piece| piece.outward.z > 0.0);
    }
    let places = body.placements.iter().filter(|place| place.assembly == Assembly::sensor());
    for (lamp, place) in places.enumerate() {
        let pose = &place.assembly_from_body;
        pieces.extend(own.iter().map(|piece| Emitter {
            place: pose.point(piece.place),
            outward: pose.vector(piece.outward),
            source: lamp,
            ..*piece
        }));
    }
    Ok(pieces)
}

/// Adds the pieces of faces whose normals are closest to the given axis, in either direction.
fn add_faces_along(axis: usize, solid: &CompiledSolid, lines: usize, pieces: &mut Vec<Emitter>) {
    let (bounds, size) = (solid.bounds(), solid.bounds().size_mm());
    let [first, second] = [(axis + 1) % 3, (axis + 2) % 3];
    let steps = [first, second].map(|side| size[side] / lines as f64);
    let mut direction = Vector3::zeros();
    direction[axis] = 1.0;
    for i in 0..lines * lines {
        // The line runs through the centre of a grid cell on the bounding box, and starts outside of it.
        let mut origin = bounds.min;
        origin[axis] -= 1.0;
        origin[first] += (0.5 + (i % lines) as f64) * steps[0];
        origin[second] += (0.5 + (i / lines) as f64) * steps[1];
        let line = Ray { origin, direction };
        for crossing in solid.crossings(&line) {
            let outward = crossing.normal;
            let slope = outward[axis].abs();
            // The unequal comparison assigns a normal between two axes to one of them only.
            if slope >= outward[first].abs() && slope > outward[second].abs() {
                // Area of the face under one cell of the sampling grid.
                let power = steps[0] * steps[1] / slope;
                let place = line.at(crossing.t);
                pieces.push(Emitter { place, outward, power, color: WHITE, source: 0 });
            }
        }
    }
}
