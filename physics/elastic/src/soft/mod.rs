//! Soft layers below a sensing surface, found by rays through the drawn bodies, as input of the elastic solver.

mod bodies;
mod deformed_surface;
mod error;
mod floor;
mod markers;
mod meridian;
mod rod;
mod surface_coordinates;
mod tip_press;

use std::sync::Arc;

use fabkit_geometry::{
    DomePoints, Elasticity, PlanePoints, Point3, Pose, Sensor, SurfacePoints, Vector3,
};

use self::bodies::{Bodies, RayInterval};
pub use self::deformed_surface::DeformedSurface;
pub use self::error::SoftError;
use self::floor::Floor;
pub use self::markers::DisplacedMarker;
use self::meridian::{Meridian, ROUND_MM, find_usual_layers, is_rim_held};
use self::surface_coordinates::SurfaceCoordinates;
pub use self::tip_press::{BondLine, TipPressOutcome};
use crate::{BoundaryCondition, ElasticLayer, ElasticMaterial, LayeredBody, MeridianCurve};

/// Thickness below which a layer on the axis is merged with the next one, mm. Such layers are coats of paint, which
/// bend with the layer below. A coat of 0.1 mm that came out thicker counts too.
const THIN_MM: f64 = 0.15;
/// Radius of the disc that stands for a pad, in thicknesses. Farther from the press nothing moves, since the pad is
/// bonded below.
const PAD_THICKNESSES: f64 = 10.0;
/// Depth of a press up to which strain counts as small, as a part of all layers.
const SMALL_STRAIN: f64 = 0.2;
/// The same limit for skins, as a part of the skin's own thickness.
const SMALL_STRAIN_OF_SKINS: f64 = 0.44;
/// Stiffness ratio to the layer below from which the touched layer counts as a skin.
const SKIN: f64 = 3.0;
/// Distance from its edge, in thicknesses, below which a pad is noticeably softer than the disc.
const EDGE_THICKNESSES: f64 = 3.0;

/// A soft layer of a sensor.
#[derive(Clone, Debug)]
pub struct SoftLayer {
    /// Name of the body.
    pub name: String,
    /// Material as the design names it.
    pub material: String,
    /// Thickness below the pole, or below the press on a pad, mm.
    pub thickness_mm: f64,
    /// Elastic properties of the material.
    pub elasticity: Elasticity,
}

/// The soft layers of a sensor, as a body for the solver.
///
/// ```
/// # use fabkit_geometry::{Angle, Assembly, Body, Elasticity, FixtureGrip, MaterialProperties, NominalCamera};
/// # use fabkit_geometry::{Path, Placement, PlaneSurface, Pose, Sensor, Solid};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// # let outline = Path::circle([0.0, 0.0], 15.0);
/// # let grip = FixtureGrip {
/// #     outline: outline.clone(), top_z_mm: 0.0, bottom_z_mm: -9.0, clear_radius_mm: 8.0,
/// #     key: None, threads: Vec::new(),
/// # };
/// # let touch = PlaneSurface { outline, top_z_mm: 3.0, foot_z_mm: 0.0, max_indentation_mm: 1.0, grip };
/// # let elasticity = Some(Elasticity {
/// #     young_mpa: 0.2, young_range_mpa: [0.1, 0.3], poissons_ratio: 0.49, friction: None, source: String::new(),
/// # });
/// # let mut gel = Body::cast("gel", "", Solid::cylinder(15.0, 3.0));
/// # gel.substance = MaterialProperties { elasticity, ..MaterialProperties::default() };
/// # let plate = Body::bought("plate", "", Solid::cylinder(15.0, 2.0).at_z(-2.0));
/// # let [gel, plate] = [gel, plate].map(|body| body.placed([Placement::in_place(Assembly::sensor())]));
/// # let mut sensor = Sensor::new("pad", "A pad", "", camera, [gel, plate]);
/// # sensor.touch = Some(touch.into());
/// use fabkit_elastic::SoftStack;
///
/// // 3 mm of gel of 0.2 MPa, cast onto a stiff plate.
/// let soft = SoftStack::at_tip(&sensor)?;
/// assert_eq!((soft.layers.len(), soft.held_by.as_deref()), (1, Some("plate")));
/// assert!((soft.layers[0].thickness_mm - 3.0).abs() < 1e-9);
/// // Small strain holds for a fifth of the thickness.
/// let (limit_mm, part) = soft.small_strain_mm();
/// assert!((limit_mm - 0.6).abs() < 1e-9 && (part - 0.2).abs() < 1e-9);
/// # Ok::<(), fabkit_elastic::SoftError>(())
/// ```
#[derive(Debug)]
pub struct SoftStack {
    /// Layers from the touched one inwards.
    pub layers: Vec<SoftLayer>,
    /// Body for the solver.
    pub body: LayeredBody,
    /// Pose of the solver's frame; the identity for domes.
    pub sensor_from_stack: Pose,
    /// Simplifications, in words.
    pub simplifications: Vec<String>,
    /// Body that holds the innermost layer below most of the surface; `None` where the rim alone holds.
    pub held_by: Option<String>,
    plan: SurfaceCoordinates,
}

impl SoftStack {
    /// Builds the layers below the whole surface of a dome, or below a place of a pad.
    ///
    /// # Errors
    /// Nothing soft below the surface, or nothing rigid that holds it.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, Assembly, Body, Elasticity, FixtureGrip, MaterialProperties, NominalCamera};
    /// # use fabkit_geometry::{Path, Placement, PlaneSurface, Pose, Sensor, Solid};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// # let outline = Path::circle([0.0, 0.0], 15.0);
    /// # let grip = FixtureGrip {
    /// #     outline: outline.clone(), top_z_mm: 0.0, bottom_z_mm: -9.0, clear_radius_mm: 8.0,
    /// #     key: None, threads: Vec::new(),
    /// # };
    /// # let touch = PlaneSurface { outline, top_z_mm: 3.0, foot_z_mm: 0.0, max_indentation_mm: 1.0, grip };
    /// # let elasticity = Some(Elasticity {
    /// #     young_mpa: 0.2, young_range_mpa: [0.1, 0.3], poissons_ratio: 0.49, friction: None, source: String::new(),
    /// # });
    /// # let mut gel = Body::cast("gel", "", Solid::cylinder(15.0, 3.0));
    /// # gel.substance = MaterialProperties { elasticity, ..MaterialProperties::default() };
    /// # let plate = Body::bought("plate", "", Solid::cylinder(15.0, 2.0).at_z(-2.0));
    /// # let [gel, plate] = [gel, plate].map(|body| body.placed([Placement::in_place(Assembly::sensor())]));
    /// # let mut sensor = Sensor::new("pad", "A pad", "", camera, [gel, plate]);
    /// # sensor.touch = Some(touch.into());
    /// use fabkit_elastic::SoftStack;
    /// use fabkit_geometry::{Point3, SurfacePoints, Vector3};
    ///
    /// // A place 13 mm from the middle of a pad whose radius is 15 mm, and whose gel is 3 mm thick.
    /// let points = SurfacePoints::new(sensor.touch.as_ref().unwrap())?;
    /// let soft = SoftStack::from_sensor(&sensor, &points, &(Point3::new(13.0, 0.0, 3.0), Vector3::z()))?;
    /// // The solver's frame stands on the plate below the place. That the edge is near is not modelled, and said.
    /// assert!((soft.sensor_from_stack.translation_mm() - Vector3::new(13.0, 0.0, 0.0)).norm() < 1e-9);
    /// assert!(soft.simplifications[0].starts_with("the pad's edge, 2.0 mm from the press"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_sensor(
        sensor: &Sensor,
        points: &SurfacePoints,
        place: &PressPoint,
    ) -> Result<Self, SoftError> {
        let bodies = Bodies::from_sensor(sensor)?;
        match points {
            SurfacePoints::Dome(face) => dome(bodies, sensor, face),
            SurfacePoints::Plane(face) => pad(&bodies, sensor, face, place),
        }
    }
}

impl SoftStack {
    /// Returns the depth of a press above which small strain is doubtful, mm, and that depth as a part of all layers.
    ///
    /// Fitted to large-strain results for a ball of 8 mm on the built-in sensors (the book's table). Forces deviate by
    /// 10 % from a fifth of the layers' thickness on, or never. A skin on a much softer layer stretches like a
    /// membrane; there they deviate from less than half of the skin's own thickness on.
    pub fn small_strain_mm(&self) -> (f64, f64) {
        let thickness_mm: f64 = self.layers.iter().map(|layer| layer.thickness_mm).sum();
        let young = |layer: Option<&SoftLayer>| layer.map_or(0.0, |l| l.elasticity.young_mpa);
        let is_skin =
            young(self.layers.first()) > SKIN * young(self.layers.get(1)) && self.layers.len() > 1;
        let skin_mm = self.layers.first().map_or(0.0, |layer| layer.thickness_mm);
        let limit_mm =
            if is_skin { SMALL_STRAIN_OF_SKINS * skin_mm } else { SMALL_STRAIN * thickness_mm };
        (limit_mm, limit_mm / thickness_mm)
    }
}

/// Centre of a press: a point of the surface and its outward unit normal, sensor frame, mm.
pub type PressPoint = (Point3<f64>, Vector3<f64>);

/// Builds the layers below a place of a pad as a disc around it.
fn pad(
    bodies: &Bodies,
    sensor: &Sensor,
    face: &PlanePoints,
    (point, outward): &PressPoint,
) -> Result<SoftStack, SoftError> {
    let column = bodies.find_soft_below(*point, *outward);
    if column.soft.is_empty() {
        return Err(nothing_soft(sensor));
    }
    if !column.is_held {
        return Err(SoftError::NotHeld);
    }
    let mut left_out = Vec::new();
    let layers = layers(bodies, &column.soft, &mut left_out)?;
    let thickness_mm: f64 = layers.iter().map(|layer| layer.thickness_mm).sum();
    let edge_mm = edge_mm(face, [point.x, point.y]);
    if edge_mm < EDGE_THICKNESSES * thickness_mm {
        left_out.push(format!(
            "the pad's edge, {edge_mm:.1} mm from the press: within {:.1} mm of it the pad gives way more",
            EDGE_THICKNESSES * thickness_mm
        ));
    }
    let solver = layers
        .iter()
        .map(|layer| Ok((to_elastic_layer(layer)?, layer.thickness_mm)))
        .collect::<Result<Vec<_>, SoftError>>()?;
    // The solver's frame has its origin on the floor below the press.
    let (floor_mm, radius_mm) = (point.z - thickness_mm, PAD_THICKNESSES * thickness_mm);
    Ok(SoftStack {
        body: LayeredBody::pad(radius_mm, solver),
        sensor_from_stack: Pose::translation(point.x, point.y, floor_mm),
        layers,
        simplifications: left_out,
        held_by: column.next.map(|body| bodies.placed[body].name.clone()),
        plan: SurfaceCoordinates::Disc { radius_mm },
    })
}

/// Computes the distance of a point of a pad from its edge, mm: the smallest over 72 directions.
fn edge_mm(face: &PlanePoints, [x, y]: [f64; 2]) -> f64 {
    let directions = (0..72).map(|i| f64::from(i).to_radians() * 5.0);
    let to_edge = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let is_on = |r: f64| face.at([x + r * cos, y + r * sin]).is_some();
        let (mut on, mut off) = (0.0, 1e3);
        for _ in 0..40 {
            // Bisection, for an outline without reentrant parts along the ray.
            let middle = f64::midpoint(on, off);
            if is_on(middle) { on = middle } else { off = middle }
        }
        on
    };
    directions.map(to_edge).fold(f64::INFINITY, f64::min)
}

/// Builds the layers of a dome as a body of revolution.
fn dome(bodies: Bodies, sensor: &Sensor, face: &DomePoints) -> Result<SoftStack, SoftError> {
    let (names, usual_mm) = find_usual_layers(&bodies, face);
    if names.is_empty() {
        return Err(nothing_soft(sensor));
    }
    let meridian = Meridian::from_bodies(&bodies, face, &names, usual_mm);
    if meridian.depths_mm.is_empty() {
        return Err(nothing_soft(sensor));
    }
    let mut left_out = Vec::new();
    let last_rad = face.max_polar_rad();
    if meridian.end_rad < 0.98 * last_rad {
        left_out.push(format!(
            "what lies more than {:.0} deg from the tip, where the layers end",
            meridian.end_rad.to_degrees()
        ));
    }
    for (&body, uneven_mm) in
        names.iter().zip(&meridian.uneven_mm).filter(|(_, uneven)| **uneven > ROUND_MM)
    {
        let name = &bodies.placed[body].name;
        left_out.push(format!(
            "the shape of what is not round below {name}: up to {uneven_mm:.2} mm of pins, dimples or slots are \
             spread evenly"
        ));
    }
    let holding = meridian.held_by.map(|body| bodies.placed[body].name.clone());
    let mut inner = meridian.inner_boundary(&mut left_out);
    let mut held_by = holding.filter(|_| !matches!(inner, BoundaryCondition::Free));
    let most_mm =
        meridian.depths_mm.iter().filter_map(|row| row.last()).copied().fold(0.0, f64::max);
    let apex_z_mm = face.point_in_direction(0.0, 0.0).map_or(f64::NAN, |(point, _)| point.z);
    // Rays were cut off at the depth limit: look for a floor that they could not reach.
    let is_deep = most_mm >= bodies.deepest_mm - ROUND_MM;
    let floor = if is_deep { Floor::find(&bodies, face, apex_z_mm) } else { None };
    if let Some(floor) = &floor {
        (inner, held_by) =
            (BoundaryCondition::Bonded, Some(bodies.placed[floor.body].name.clone()));
    } else if is_deep {
        left_out.push(format!("that what lies deeper than {:.1} mm gives way", bodies.deepest_mm));
    }
    // Gel that reaches down to a floor is held at the rim by the outer layers' surroundings.
    let rim_layer = if floor.is_some() { 0 } else { names.len() - 1 };
    let is_rim_bonded = is_rim_held(&bodies, face, &meridian, rim_layer);
    if matches!(inner, BoundaryCondition::Free) && !is_rim_bonded {
        return Err(SoftError::NotHeld);
    }
    // Intervals at the pole, with depths that are averaged around the axis.
    let mut soft: Vec<RayInterval> = (0..names.len())
        .map(|i| RayInterval {
            body: names[i],
            begin_mm: if i == 0 { 0.0 } else { meridian.depths_mm[0][i - 1] },
            end_mm: meridian.depths_mm[0][i],
        })
        .collect();
    if let (Some(floor), Some(lowest)) = (&floor, soft.last_mut()) {
        lowest.end_mm = apex_z_mm - floor.z_mm;
    }
    let kept: Vec<usize> =
        (0..soft.len()).filter(|i| !is_thin(&soft[*i]) || soft.len() == 1).collect();
    let layers = layers(&bodies, &soft, &mut left_out)?;
    let plan = SurfaceCoordinates::Dome {
        centre: face.centre(),
        end_rad: meridian.end_rad,
        equator_radius_mm: face.equator_radius_mm(),
    };
    let (face, meridian) = (Arc::new(face.clone()), Arc::new(meridian));
    let outer = curve(&face, &meridian, None);
    let mut interfaces: Vec<MeridianCurve> = std::iter::once(outer)
        .chain(kept.iter().map(|layer| curve(&face, &meridian, Some(*layer))))
        .collect();
    if let (Some(floor), Some(lowest)) = (&floor, interfaces.last_mut()) {
        *lowest = floor.curve();
    }
    let body = LayeredBody {
        interfaces,
        layers: layers.iter().map(to_elastic_layer).collect::<Result<_, _>>()?,
        inner,
        is_rim_bonded,
        kinks: Vec::new(),
    };
    Ok(SoftStack {
        layers,
        body,
        sensor_from_stack: Pose::identity(),
        simplifications: left_out,
        held_by,
        plan,
    })
}

/// Returns the meridian of the surface, or of a layer's lower face.
fn curve(face: &Arc<DomePoints>, meridian: &Arc<Meridian>, layer: Option<usize>) -> MeridianCurve {
    let (face, meridian) = (Arc::clone(face), Arc::clone(meridian));
    MeridianCurve::new(move |s| {
        let Some((point, outward)) = face.point_in_direction(s * meridian.end_rad, 0.0) else {
            return [f64::NAN; 2];
        };
        let depth_mm = layer.map_or(0.0, |layer| meridian.depth_mm(layer, s));
        let place = point - depth_mm * outward;
        [if s == 0.0 { 0.0 } else { place.x }, place.z]
    })
}

fn is_thin(stretch: &RayInterval) -> bool {
    stretch.end_mm - stretch.begin_mm < THIN_MM
}

/// Builds the layers. A thin one is merged with the next one below, or with the one above if nothing is below.
fn layers(
    bodies: &Bodies,
    soft: &[RayInterval],
    left_out: &mut Vec<String>,
) -> Result<Vec<SoftLayer>, SoftError> {
    let (mut layers, mut begin_mm) = (Vec::<SoftLayer>::new(), 0.0);
    for (i, stretch) in soft.iter().enumerate() {
        let placed = &bodies.placed[stretch.body];
        if is_thin(stretch) && soft.len() > 1 {
            let thickness_mm = stretch.end_mm - stretch.begin_mm;
            left_out.push(format!("the stiffness of {}, {thickness_mm:.3} mm thick", placed.name));
            // `begin_mm` stays, so that the next layer includes the thin one.
            if i + 1 == soft.len()
                && let Some(last) = layers.last_mut()
            {
                last.thickness_mm += thickness_mm;
            }
            continue;
        }
        let Some(elasticity) = placed.elasticity.clone() else { continue };
        layers.push(SoftLayer {
            name: placed.name.clone(),
            material: placed.material.clone(),
            thickness_mm: stretch.end_mm - begin_mm,
            elasticity,
        });
        begin_mm = stretch.end_mm;
    }
    if layers.is_empty() { Err(SoftError::NotHeld) } else { Ok(layers) }
}

fn to_elastic_layer(layer: &SoftLayer) -> Result<ElasticLayer, SoftError> {
    let Elasticity { young_mpa, poissons_ratio, .. } = layer.elasticity;
    let material = ElasticMaterial::new(young_mpa, poissons_ratio)?;
    Ok(ElasticLayer { name: layer.name.clone(), material })
}

fn nothing_soft(sensor: &Sensor) -> SoftError {
    SoftError::NothingSoft { sensor: sensor.name.clone() }
}
