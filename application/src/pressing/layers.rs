//! What lies below a sensing surface, as far down as it gives way: the elastic solver's layers, met by rays in the
//! drawn bodies.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use fabkit_elastic::{Body, Curve, Hold, Layer, Material};
use fabkit_geometry::{
    Assembly, CompiledSolid, DomePoints, Elasticity, Kind, PlanePoints, Point3, Pose, Ray, Scratch,
    Sensor, SurfacePoints, TouchSurface, Vector3,
};

use super::error::PressingError;

/// Layers thinner than this on the axis are given to the next one: coats of paint, which bend with it, mm.
const THIN_MM: f64 = 0.1;
/// Stretches that begin this near to where the last one ended follow it, mm.
const JOINT_MM: f64 = 1e-3;
/// Places along the meridian at which the bodies are asked.
const STEPS: usize = 240;
/// Meridians that are compared: what differs between them is no body of revolution.
const MERIDIANS: usize = 36;
/// Of the usual depth of all layers: where they end earlier, something stands in them.
const SHALLOW: f64 = 0.5;
/// Of the smallest radius of curvature of a dome: deeper, layers are taken for stiff.
const DEEPEST: f64 = 0.6;
/// Steps to either side over which dimples, pins and slots are spread.
const SPREAD_STEPS: usize = 16;
/// Differences between meridians below this are rounding, mm.
const ROUND_MM: f64 = 1e-6;
/// A pad is a disc of this many thicknesses around the press: farther off nothing moves that is bonded below.
const PAD_THICKNESSES: f64 = 10.0;
/// Nearer to its edge than this many thicknesses, a pad gives way more than the disc does.
const EDGE_THICKNESSES: f64 = 3.0;
/// The rim is held where something stiff begins within this distance beyond it, mm.
const RIM_MM: f64 = 0.3;

/// A layer that gives way.
#[derive(Clone, Debug)]
pub struct SoftLayer {
    /// The body's name.
    pub name: String,
    /// What it is made of, as the design calls it.
    pub material: String,
    /// Below the pole, or below the press on a pad, mm.
    pub thickness_mm: f64,
    /// What is known of its material.
    pub elasticity: Elasticity,
}

/// What can be pressed.
#[derive(Debug)]
pub struct SoftStack {
    /// From the touched one inwards.
    pub layers: Vec<SoftLayer>,
    /// For the solver.
    pub body: Body,
    /// Where the solver's frame lies; the identity for domes.
    pub sensor_from_stack: Pose,
    /// What was simplified, in words.
    pub left_out: Vec<String>,
}

/// A body in its place in the sensor.
struct Placed {
    name: String,
    material: String,
    elasticity: Option<Elasticity>,
    solid: CompiledSolid,
}

/// One body on a ray: which, and from where to where, mm.
#[derive(Clone, Copy)]
struct Stretch {
    body: usize,
    begin_mm: f64,
    end_mm: f64,
}

/// Everything below a place of the surface until it no longer gives way.
struct Column {
    /// From outside inwards, each beginning where the one before ends.
    soft: Vec<Stretch>,
    /// Whether something stiff follows.
    is_held: bool,
    /// Which body follows; nothing where none does, and deeper than one looks.
    next: Option<usize>,
}

/// All bodies of the sensor, and how deep they are looked into, mm.
struct Bodies {
    placed: Vec<Placed>,
    deepest_mm: f64,
}

impl Bodies {
    fn of(sensor: &Sensor) -> Result<Self, PressingError> {
        let mut placed = Vec::new();
        for body in &sensor.bodies {
            for place in body.placements.iter().filter(|p| p.assembly == Assembly::sensor()) {
                let solid = body.solid.clone().placed(place.assembly_from_body);
                let solid = CompiledSolid::new(&solid).map_err(PressingError::Solid)?;
                let elasticity = body.substance.elasticity.clone();
                let is_soft = body.kind == Kind::Cast || body.gives_way;
                placed.push(Placed {
                    name: body.name.clone(),
                    material: body.material.clone(),
                    elasticity: elasticity.filter(|_| is_soft),
                    solid,
                });
            }
        }
        // Normals of a dome meet in its middle: far below a press, what gives way is taken for stiff.
        let curvature = |touch: &TouchSurface| DEEPEST * touch.least_curvature_radius_mm();
        let deepest_mm = sensor.touch.as_ref().map_or(f64::INFINITY, curvature);
        Ok(Self { placed, deepest_mm })
    }

    /// All bodies on a ray, in the order in which they begin.
    fn met(&self, ray: &Ray) -> Vec<Stretch> {
        let (mut scratch, mut found, mut met) = (Scratch::default(), Vec::new(), Vec::new());
        for (body, placed) in self.placed.iter().enumerate() {
            placed.solid.stretches_into(ray, &mut scratch, &mut found);
            met.extend(found.iter().map(|&[begin_mm, end_mm]| Stretch { body, begin_mm, end_mm }));
        }
        met.sort_by(|a, b| a.begin_mm.total_cmp(&b.begin_mm));
        met
    }

    fn below(&self, place: Point3<f64>, outward: Vector3<f64>) -> Column {
        // From a little outside, so that the surface itself is crossed.
        let ray = Ray { origin: place + outward, direction: -outward };
        let met = self.met(&ray);
        let (mut soft, mut at_mm) = (Vec::<Stretch>::new(), 1.0);
        loop {
            let next =
                met.iter().find(|s| (s.begin_mm - at_mm).abs() < JOINT_MM && s.end_mm > at_mm);
            match next {
                Some(next) if self.placed[next.body].elasticity.is_some() => {
                    at_mm = next.end_mm.min(1.0 + self.deepest_mm);
                    soft.push(Stretch {
                        begin_mm: next.begin_mm - 1.0,
                        end_mm: at_mm - 1.0,
                        ..*next
                    });
                    if next.end_mm > at_mm {
                        return Column { soft, is_held: true, next: None };
                    }
                }
                other => {
                    let next = other.map(|stretch| stretch.body);
                    return Column { soft, is_held: next.is_some(), next };
                }
            }
        }
    }
}

impl SoftStack {
    /// The layers below the whole surface of a dome, or below a place of a pad.
    ///
    /// # Errors
    /// Nothing soft below the surface, or nothing that holds it.
    pub fn of(
        sensor: &Sensor,
        points: &SurfacePoints,
        place: &Place,
    ) -> Result<Self, PressingError> {
        let bodies = Bodies::of(sensor)?;
        match points {
            SurfacePoints::Dome(face) => dome(bodies, sensor, face),
            SurfacePoints::Plane(face) => pad(&bodies, sensor, face, place),
        }
    }
}

/// Where a press is centred: a point of the surface and its outward unit normal, sensor frame, mm.
pub type Place = (Point3<f64>, Vector3<f64>);

fn pad(
    bodies: &Bodies,
    sensor: &Sensor,
    face: &PlanePoints,
    (point, outward): &Place,
) -> Result<SoftStack, PressingError> {
    let column = bodies.below(*point, *outward);
    if column.soft.is_empty() {
        return Err(nothing_soft(sensor));
    }
    if !column.is_held {
        return Err(PressingError::Loose);
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
        .map(|layer| Ok((layer_of(layer)?, layer.thickness_mm)))
        .collect::<Result<Vec<_>, PressingError>>()?;
    let floor_mm = point.z - thickness_mm;
    Ok(SoftStack {
        body: Body::pad(PAD_THICKNESSES * thickness_mm, solver),
        sensor_from_stack: Pose::translation(point.x, point.y, floor_mm),
        layers,
        left_out,
    })
}

/// How far a place of a pad is from its edge, mm: the nearest of many directions.
fn edge_mm(face: &PlanePoints, [x, y]: [f64; 2]) -> f64 {
    let directions = (0..72).map(|i| f64::from(i).to_radians() * 5.0);
    let to_edge = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let is_on = |r: f64| face.at([x + r * cos, y + r * sin]).is_some();
        let (mut on, mut off) = (0.0, 1e3);
        for _ in 0..40 {
            let middle = f64::midpoint(on, off);
            if is_on(middle) { on = middle } else { off = middle }
        }
        on
    };
    directions.map(to_edge).fold(f64::INFINITY, f64::min)
}

/// The meridian of a dome's layers, as a table: what differs around the axis is left out.
struct Meridian {
    /// The last polar angle that has all layers, rad.
    end_rad: f64,
    /// How deep each layer's lower face lies below the surface, mm, by step and layer.
    depths_mm: Vec<Vec<f64>>,
    /// Whether something stiff follows the last layer, by step.
    is_held: Vec<bool>,
    /// How far depths differ around the axis, at most, mm, by layer.
    uneven_mm: Vec<f64>,
}

fn dome(bodies: Bodies, sensor: &Sensor, face: &DomePoints) -> Result<SoftStack, PressingError> {
    let (names, usual_mm) = most_common(&bodies, face);
    if names.is_empty() {
        return Err(nothing_soft(sensor));
    }
    let meridian = Meridian::of(&bodies, face, &names, usual_mm);
    if meridian.depths_mm.is_empty() {
        return Err(nothing_soft(sensor));
    }
    let mut left_out = Vec::new();
    let last_rad = face.last_polar_rad();
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
    let inner = meridian.inner(&mut left_out);
    let most_mm =
        meridian.depths_mm.iter().filter_map(|row| row.last()).copied().fold(0.0, f64::max);
    if most_mm >= bodies.deepest_mm {
        left_out.push(format!("that what lies deeper than {:.1} mm gives way", bodies.deepest_mm));
    }
    let is_rim_bonded = rim_is_held(&bodies, face, &meridian);
    if matches!(inner, Hold::Free) && !is_rim_bonded {
        return Err(PressingError::Loose);
    }
    // The stretches at the pole, but with depths that are the same all around.
    let soft: Vec<Stretch> = (0..names.len())
        .map(|i| Stretch {
            body: names[i],
            begin_mm: if i == 0 { 0.0 } else { meridian.depths_mm[0][i - 1] },
            end_mm: meridian.depths_mm[0][i],
        })
        .collect();
    let kept: Vec<usize> =
        (0..soft.len()).filter(|i| !is_thin(&soft[*i]) || soft.len() == 1).collect();
    let layers = layers(&bodies, &soft, &mut left_out)?;
    let (face, meridian) = (Arc::new(face.clone()), Arc::new(meridian));
    let outer = curve(&face, &meridian, None);
    let interfaces = std::iter::once(outer)
        .chain(kept.iter().map(|layer| curve(&face, &meridian, Some(*layer))))
        .collect();
    let body = Body {
        interfaces,
        layers: layers.iter().map(layer_of).collect::<Result<_, _>>()?,
        inner,
        is_rim_bonded,
        kinks: Vec::new(),
    };
    Ok(SoftStack { layers, body, sensor_from_stack: Pose::identity(), left_out })
}

/// The bodies that lie below most places of the surface, from outside inwards: not below a pin or a hole; and how
/// deep they reach, mm: the median.
fn most_common(bodies: &Bodies, face: &DomePoints) -> (Vec<usize>, f64) {
    let mut counted = BTreeMap::<Vec<usize>, Vec<f64>>::new();
    for ring in 0..MERIDIANS {
        // By area, about: more places where the rings are longer.
        let polar = face.last_polar_rad() * (ring as f64 + 0.5) / MERIDIANS as f64;
        let places = ((polar.sin() * MERIDIANS as f64).ceil() as usize).max(1);
        for place in 0..places {
            let azimuth = (place as f64 + 0.37) * TAU / places as f64;
            if let Some((point, outward)) = face.towards(polar, azimuth) {
                let soft = bodies.below(point, outward).soft;
                let names = soft.iter().map(|stretch| stretch.body).collect();
                counted.entry(names).or_default().extend(soft.last().map(|last| last.end_mm));
            }
        }
    }
    let Some((names, mut depths_mm)) = counted.into_iter().max_by_key(|(_, depths)| depths.len())
    else {
        return (Vec::new(), 0.0);
    };
    depths_mm.sort_by(f64::total_cmp);
    let usual_mm = depths_mm.get(depths_mm.len() / 2).copied().unwrap_or(0.0);
    (names, usual_mm)
}

/// The meridian of the surface, or of a layer's lower face.
fn curve(face: &Arc<DomePoints>, meridian: &Arc<Meridian>, layer: Option<usize>) -> Curve {
    let (face, meridian) = (Arc::clone(face), Arc::clone(meridian));
    Curve::new(move |s| {
        let Some((point, outward)) = face.towards(s * meridian.end_rad, 0.0) else {
            return [f64::NAN; 2];
        };
        let depth_mm = layer.map_or(0.0, |layer| meridian.depth_mm(layer, s));
        let place = point - depth_mm * outward;
        [if s == 0.0 { 0.0 } else { place.x }, place.z]
    })
}

impl Meridian {
    fn of(bodies: &Bodies, face: &DomePoints, names: &[usize], usual_mm: f64) -> Self {
        let column = |polar: f64, azimuth: f64| {
            let (point, outward) = face.towards(polar, azimuth)?;
            let column = bodies.below(point, outward);
            let has_all = column.soft.len() >= names.len()
                && column.soft.iter().zip(names).all(|(stretch, name)| stretch.body == *name);
            // A dot or a pin may stand in the last of them.
            let is_whole = has_all && column.soft[names.len() - 1].end_mm > SHALLOW * usual_mm;
            is_whole.then_some(column)
        };
        let around = |polar: f64| -> Vec<Column> {
            let azimuths =
                (0..MERIDIANS).map(|i| (f64::from(i as u32) + 0.37) * 360.0 / MERIDIANS as f64);
            let mut columns: Vec<Column> =
                azimuths.filter_map(|deg| column(polar, deg.to_radians())).collect();
            // Without those that end at what stands in the layer: a dot, a pin.
            let follow = |next| columns.iter().filter(|column| column.next == next).count();
            let usual = columns.iter().map(|column| column.next).max_by_key(|next| follow(*next));
            columns.retain(|column| Some(column.next) == usual);
            columns
        };
        // Most meridians must have all layers; those that pass a pin or a slot may not.
        let is_whole = |columns: &[Column]| 2 * columns.len() > MERIDIANS;
        let last_rad = face.last_polar_rad() * (1.0 - 1e-6);
        let polar = |i: usize| last_rad * i as f64 / STEPS as f64;
        let whole = (1..=STEPS).rev().find(|i| is_whole(&around(polar(*i)))).unwrap_or(1);
        let end_rad = polar(whole);
        let mut uneven_mm = vec![0.0f64; names.len()];
        let mut rows: Vec<Option<(Vec<f64>, bool)>> = Vec::new();
        for i in 0..=STEPS {
            let columns = around(end_rad * i as f64 / STEPS as f64);
            if !is_whole(&columns) {
                rows.push(None);
                continue;
            }
            let mut here = Vec::new();
            for (layer, uneven) in uneven_mm.iter_mut().enumerate() {
                let ends = || columns.iter().map(|column| column.soft[layer].end_mm);
                let (least, most) =
                    (ends().fold(f64::INFINITY, f64::min), ends().fold(0.0, f64::max));
                *uneven = uneven.max(most - least);
                // What is even stays exact.
                let is_even = most - least < ROUND_MM;
                here.push(if is_even { least } else { ends().sum::<f64>() / columns.len() as f64 });
            }
            let held = columns.iter().filter(|c| c.is_held && c.soft.len() == names.len()).count();
            rows.push(Some((here, 2 * held > columns.len())));
        }
        // Where a pin or a hole is all around, as at a tip, it is as beside it.
        let nearest =
            |i: usize| (0..=STEPS).filter(|j| rows[*j].is_some()).min_by_key(|j| j.abs_diff(i));
        let filled = (0..=STEPS).filter_map(|i| rows[nearest(i)?].clone());
        let (mut depths_mm, is_held): (Vec<_>, Vec<_>) = filled.unzip();
        for layer in (0..names.len()).filter(|layer| uneven_mm[*layer] > ROUND_MM) {
            spread(&mut depths_mm, layer);
        }
        Self { end_rad, depths_mm, is_held, uneven_mm }
    }

    /// Between the table's rows.
    fn depth_mm(&self, layer: usize, s: f64) -> f64 {
        let place = s.clamp(0.0, 1.0) * STEPS as f64;
        let i = (place as usize).min(STEPS - 1);
        let share = place - i as f64;
        (1.0 - share) * self.depths_mm[i][layer] + share * self.depths_mm[i + 1][layer]
    }

    /// What holds the innermost face, mostly.
    fn inner(&self, left_out: &mut Vec<String>) -> Hold {
        let held = self.is_held.iter().filter(|held| **held).count();
        let from = self.is_held.iter().position(|held| *held).unwrap_or(STEPS);
        if from > 0 && from < STEPS && self.is_held[from..].iter().all(|held| *held) {
            return Hold::BondedBeyond(from as f64 / STEPS as f64);
        }
        let share = 100.0 * held as f64 / (STEPS + 1) as f64;
        match share {
            100.0 => Hold::Bonded,
            0.0 => Hold::Free,
            50.0.. => {
                left_out.push(format!(
                    "that nothing stiff holds {:.0} % of the inner face",
                    100.0 - share
                ));
                Hold::Bonded
            }
            _ => {
                left_out.push(format!("that something stiff holds {share:.0} % of the inner face"));
                Hold::Free
            }
        }
    }
}

/// Spreads what is not round along the meridian as well, so that the layer keeps its volume, about.
fn spread(depths_mm: &mut [Vec<f64>], layer: usize) {
    let before: Vec<f64> = depths_mm.iter().map(|row| row[layer]).collect();
    for (i, row) in depths_mm.iter_mut().enumerate() {
        let (from, to) = (i.saturating_sub(SPREAD_STEPS), (i + SPREAD_STEPS).min(STEPS));
        row[layer] = before[from..=to].iter().sum::<f64>() / (to - from + 1) as f64;
    }
}

/// Whether something stiff begins beyond the end of the meridian, in the middle of what is soft.
fn rim_is_held(bodies: &Bodies, face: &DomePoints, meridian: &Meridian) -> bool {
    let depth_mm = meridian.depths_mm[STEPS].last().copied().unwrap_or(0.0) / 2.0;
    let place =
        |polar: f64| face.towards(polar, 0.01).map(|(point, outward)| point - depth_mm * outward);
    let (Some(end), Some(before)) = (place(meridian.end_rad), place(meridian.end_rad * 0.995))
    else {
        return false;
    };
    let ray = Ray { origin: before, direction: (end - before).normalize() };
    let end_mm = (end - before).norm();
    bodies.met(&ray).iter().any(|stretch| {
        let is_stiff = bodies.placed[stretch.body].elasticity.is_none();
        is_stiff && stretch.begin_mm < end_mm + RIM_MM && stretch.end_mm > end_mm
    })
}

fn is_thin(stretch: &Stretch) -> bool {
    stretch.end_mm - stretch.begin_mm < THIN_MM
}

/// Layers with what is thin given to the next one below; if nothing is below, to the one above.
fn layers(
    bodies: &Bodies,
    soft: &[Stretch],
    left_out: &mut Vec<String>,
) -> Result<Vec<SoftLayer>, PressingError> {
    let (mut layers, mut begin_mm) = (Vec::<SoftLayer>::new(), 0.0);
    for (i, stretch) in soft.iter().enumerate() {
        let placed = &bodies.placed[stretch.body];
        if is_thin(stretch) && soft.len() > 1 {
            let thickness_mm = stretch.end_mm - stretch.begin_mm;
            left_out.push(format!("the stiffness of {}, {thickness_mm:.3} mm thick", placed.name));
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
    if layers.is_empty() { Err(PressingError::Loose) } else { Ok(layers) }
}

fn layer_of(layer: &SoftLayer) -> Result<Layer, PressingError> {
    let Elasticity { young_mpa, poissons_ratio, .. } = layer.elasticity;
    let material = Material::new(young_mpa, poissons_ratio).map_err(PressingError::Elastic)?;
    Ok(Layer { name: layer.name.clone(), material })
}

fn nothing_soft(sensor: &Sensor) -> PressingError {
    PressingError::Stiff { sensor: sensor.name.clone() }
}
