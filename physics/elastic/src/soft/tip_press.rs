//! Presses of a ball on the tip of a dome or the middle of a pad. They rate a design within tenths of a second, because
//! the problem is axisymmetric.

use fabkit_geometry::{Point3, Sensor, SurfacePoints, Vector3};

use super::{SoftError, SoftStack};
use crate::{
    BallIndenter, BoundaryCondition, ElasticStack, FiniteStack, LayeredBody, MeridianCurve,
    MeshDensity, Press, PressOutcome,
};

/// Nodes across the radius of the undeformed intersection of ball and surface.
const ACROSS: f64 = 24.0;
/// Radius of the fine part of the mesh, as a multiple of that radius.
const FINE_RADIUS_RATIO: f64 = 2.5;
/// Fraction of a layer next to a bond in which the layer's strain is measured.
const AT_BOND: f64 = 0.04;
/// Last fraction of the depth, over which the stiffness is measured.
const STIFFNESS_STEP_SHARE: f64 = 0.05;
/// Initial height of the ball above the surface, mm.
const ABOVE_MM: f64 = 1.0;
/// Steps along a bond line.
const BOND_LINE_STEPS: usize = 400;

/// Result of a press on the tip.
#[derive(Clone, Debug)]
pub struct TipPressOutcome {
    /// Magnitude of the force of the ball on the sensor, N.
    pub force_n: f64,
    /// Derivative of force by depth at the end, N/mm.
    pub stiffness_n_mm: f64,
    /// Height of the bulge beside the ball, mm.
    pub bulge_mm: f64,
    /// Radius of the contact, mm.
    pub contact_radius_mm: f64,
    /// Bond below each layer that is bonded to something, from outside inwards.
    pub bonds: Vec<BondLine>,
}

/// Bond between a layer and what lies below.
#[derive(Clone, Debug, PartialEq)]
pub struct BondLine {
    /// Name of the layer.
    pub layer: String,
    /// Name of what it is bonded to: the next layer, or what holds the last one; `None` if that has no known name.
    pub below: Option<String>,
    /// Largest shear strain of the layer next to the bond, as an angle's tangent.
    pub shear_strain: f64,
    /// Shear stress along the bond there, MPa.
    pub shear_mpa: f64,
    /// Distance of that place from the axis, mm.
    pub radius_mm: f64,
}

impl SoftStack {
    /// Builds the layers below the tip of a dome, or below the middle of a pad.
    ///
    /// # Errors
    /// As [`SoftStack::from_sensor`]; a sensor without a surface has nothing soft.
    pub fn at_tip(sensor: &Sensor) -> Result<Self, SoftError> {
        let stiff = || SoftError::NothingSoft { sensor: sensor.name.clone() };
        let touch = sensor.touch.as_ref().ok_or_else(stiff)?;
        let points = SurfacePoints::new(touch)?;
        let [x, y] = match &points {
            SurfacePoints::Dome(_) => [0.0; 2],
            SurfacePoints::Plane(face) => face.bounds_mm().map(|[a, b]| f64::midpoint(a, b)),
        };
        let place = (Point3::new(x, y, touch.apex_z_mm()), Vector3::z());
        Self::from_sensor(sensor, &points, &place)
    }

    /// Presses a ball onto the tip, or onto the place of the pad that the stack was made for, at small strain.
    ///
    /// Shear at a bond is measured in the last twenty-fifth of the layer above it, and equals that of the bond line to
    /// the resolution of that part.
    ///
    /// # Errors
    /// An invalid radius or depth, a press deeper than the layers, or no convergence.
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
    /// // 3 mm of gel on a stiff plate, and a ball of radius 4 mm.
    /// let soft = SoftStack::at_tip(&sensor)?;
    /// let [shallow, deep] = [soft.press_tip(4.0, 0.2)?, soft.press_tip(4.0, 0.4)?];
    /// // Twice as deep needs more than twice the force, since the contact grows.
    /// assert!(deep.force_n > 2.0 * shallow.force_n && deep.stiffness_n_mm > shallow.stiffness_n_mm);
    /// // One bond: that of the gel to the plate.
    /// assert_eq!(deep.bonds[0].below.as_deref(), Some("plate"));
    /// # Ok::<(), fabkit_elastic::SoftError>(())
    /// ```
    pub fn press_tip(&self, radius_mm: f64, depth_mm: f64) -> Result<TipPressOutcome, SoftError> {
        let (body, lines) = self.with_bond_lines();
        let stack = ElasticStack::new(&body, &self.tip_division(radius_mm, depth_mm), 1)?;
        let ball = self.ball_above(radius_mm)?;
        let pressed = |depth_mm: f64| stack.press(&ball, &Press::along(-Vector3::z(), depth_mm)?);
        // The force at two close depths yields the stiffness.
        let (before, last) =
            (pressed((1.0 - STIFFNESS_STEP_SHARE) * depth_mm)?, pressed(depth_mm)?);
        let bonds = lines.iter().map(|line| line.measure(self, &last)).collect();
        Ok(TipPressOutcome {
            force_n: -last.force_n.z,
            stiffness_n_mm: (before.force_n.z - last.force_n.z) / (STIFFNESS_STEP_SHARE * depth_mm),
            bulge_mm: last.bulge_mm,
            contact_radius_mm: last.contact_radius_mm,
            bonds,
        })
    }

    /// Computes the same press at large strain, to each of several rising depths, mm. It takes seconds.
    ///
    /// # Errors
    /// As [`SoftStack::press_tip`].
    pub fn press_tip_finite(
        &self,
        radius_mm: f64,
        depths_mm: &[f64],
    ) -> Result<Vec<PressOutcome>, SoftError> {
        let deepest_mm = depths_mm.iter().copied().fold(0.0, f64::max);
        let division = self.tip_division(radius_mm, deepest_mm);
        let stack = FiniteStack::new(&self.body, &division)?;
        Ok(stack.press(&self.ball_above(radius_mm)?, depths_mm)?)
    }

    /// Computes each press by both theories on the same nodes, the linear one first.
    ///
    /// # Errors
    /// As [`SoftStack::press_tip`].
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
    /// use fabkit_elastic::{SoftStack, StrainTheory};
    ///
    /// // 3 mm of gel on a stiff plate, pressed by a ball of radius 4 mm to a tenth of that.
    /// let [linear, finite] = SoftStack::at_tip(&sensor)?.press_tip_both(4.0, &[0.3])?.remove(0);
    /// assert_eq!([linear.level, finite.level], [StrainTheory::Linear, StrainTheory::Finite]);
    /// // At a depth this small both agree to a tenth.
    /// assert!((linear.force_n.z / finite.force_n.z - 1.0).abs() < 0.1);
    /// # Ok::<(), fabkit_elastic::SoftError>(())
    /// ```
    pub fn press_tip_both(
        &self,
        radius_mm: f64,
        depths_mm: &[f64],
    ) -> Result<Vec<[PressOutcome; 2]>, SoftError> {
        let deepest_mm = depths_mm.iter().copied().fold(0.0, f64::max);
        let stack = ElasticStack::new(&self.body, &self.tip_division(radius_mm, deepest_mm), 1)?;
        let ball = self.ball_above(radius_mm)?;
        let finite = self.press_tip_finite(radius_mm, depths_mm)?;
        let both = depths_mm.iter().zip(finite).map(|(depth_mm, finite)| {
            Ok([stack.press(&ball, &Press::along(-Vector3::z(), *depth_mm)?)?, finite])
        });
        both.collect()
    }

    /// Chooses a mesh by the radius at which the undeformed surface cuts the ball.
    fn tip_division(&self, radius_mm: f64, depth_mm: f64) -> MeshDensity {
        let cut_mm = (depth_mm * (2.0 * radius_mm - depth_mm)).max(0.0).sqrt();
        MeshDensity::around_pole(cut_mm / ACROSS, FINE_RADIUS_RATIO * cut_mm, 0)
    }

    /// Places a ball above the pole.
    fn ball_above(&self, radius_mm: f64) -> Result<BallIndenter, SoftError> {
        let top_mm = self.body.interfaces.first().map_or(0.0, |surface| surface.at(0.0)[1]);
        Ok(BallIndenter::new(Point3::new(0.0, 0.0, top_mm + radius_mm + ABOVE_MM), radius_mm)?)
    }

    /// Splits off a thin part of each layer next to its bond as a layer of its own.
    fn with_bond_lines(&self) -> (LayeredBody, Vec<BondInterface>) {
        let old = &self.body;
        let last = old.layers.len().saturating_sub(1);
        let (mut interfaces, mut layers, mut lines) = (Vec::new(), Vec::new(), Vec::new());
        for (i, layer) in old.layers.iter().enumerate() {
            interfaces.push(old.interfaces[i].clone());
            layers.push(layer.clone());
            if i == last && matches!(old.inner, BoundaryCondition::Free) {
                continue;
            }
            let pair = [&old.interfaces[i], &old.interfaces[i + 1]];
            interfaces.push(MeridianCurve::between(pair[0], pair[1], 1.0 - AT_BOND));
            layers.push(layer.clone());
            // The interface that the thin layer begins at.
            lines.push(BondInterface { layer: i, above: interfaces.len() - 1 });
        }
        interfaces.extend(old.interfaces.last().cloned());
        (LayeredBody { interfaces, layers, ..old.clone() }, lines)
    }
}

/// Bond line, given by the interface just above it.
struct BondInterface {
    layer: usize,
    above: usize,
}

impl BondInterface {
    /// Finds the largest shear strain along the line.
    fn measure(&self, soft: &SoftStack, outcome: &PressOutcome) -> BondLine {
        let (mut worst, mut radius_mm) = (0.0, 0.0);
        for i in 1..BOND_LINE_STEPS {
            let s = i as f64 / BOND_LINE_STEPS as f64;
            let strain = self.shear_strain(outcome, s);
            if strain > worst {
                (worst, radius_mm) = (strain, outcome.place_mm(self.above + 1, 0.0, s).x);
            }
        }
        let layer = &soft.body.layers[self.layer];
        let next = soft.layers.get(self.layer + 1).map(|layer| layer.name.clone());
        BondLine {
            layer: layer.name.clone(),
            below: next.or_else(|| soft.held_by.clone()),
            shear_strain: worst,
            shear_mpa: layer.material.shear_modulus_mpa() * worst,
            radius_mm,
        }
    }

    /// Computes the engineering shear strain along the line: du_t/dn + du_n/dt.
    fn shear_strain(&self, outcome: &PressOutcome, s: f64) -> f64 {
        let place = |interface: usize, s: f64| outcome.place_mm(interface, 0.0, s);
        let moved = |interface: usize, s: f64| outcome.displacement_mm(interface, 0.0, s);
        let step = 0.5 / BOND_LINE_STEPS as f64;
        let along = place(self.above + 1, s + step) - place(self.above + 1, s - step);
        let tangent = along.normalize();
        let across = place(self.above, s) - place(self.above + 1, s);
        // Out of the body, since the tangent points away from the pole.
        let normal = Vector3::new(-tangent.z, 0.0, tangent.x);
        let apart_mm = across.dot(&normal);
        let turns = moved(self.above + 1, s + step) - moved(self.above + 1, s - step);
        let by_length = turns / along.norm();
        // Opposite points of the two interfaces need not lie along the normal; the offset along the tangent is
        // corrected.
        let slides =
            moved(self.above, s) - moved(self.above + 1, s) - across.dot(&tangent) * by_length;
        (slides.dot(&tangent) / apart_mm + by_length.dot(&normal)).abs()
    }
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::Pose;

    use super::*;
    use crate::soft::SurfaceCoordinates;
    use crate::{ElasticLayer, ElasticMaterial};

    fn pad(layers: &[(f64, f64)]) -> SoftStack {
        let layer = |(young_mpa, thickness_mm): &(f64, f64)| {
            let material = ElasticMaterial::new(*young_mpa, 0.499).unwrap();
            (ElasticLayer { name: format!("{young_mpa} MPa"), material }, *thickness_mm)
        };
        SoftStack {
            layers: Vec::new(),
            body: LayeredBody::pad(12.0, layers.iter().map(layer).collect()),
            sensor_from_stack: Pose::identity(),
            simplifications: Vec::new(),
            held_by: Some("floor".to_owned()),
            plan: SurfaceCoordinates::Disc { radius_mm: 12.0 },
        }
    }

    #[test]
    fn a_thin_layer_is_sheared_by_what_flows_out() {
        // An incompressible layer, much wider than thick, bonded below and free to slide above: pressure drives it out
        // like a viscous film, and the floor bears all of it. Shear is thickness times the slope of pressure.
        let (soft, thickness_mm) = (pad(&[(0.3, 0.1)]), 0.1);
        let (body, lines) = soft.with_bond_lines();
        let stack = ElasticStack::new(&body, &soft.tip_division(50.0, 0.02), 1).unwrap();
        let press = Press::along(-Vector3::z(), 0.02).unwrap();
        let outcome = stack.press(&soft.ball_above(50.0).unwrap(), &press).unwrap();
        let edge_mm = outcome.contact_radius_mm;
        // At the edge it is free to rise, and in the middle nothing flows.
        for share in [0.3, 0.5, 0.7] {
            let here_mm = share * edge_mm;
            let at = outcome.nodes.iter().position(|node| node.place_mm.x > here_mm).unwrap();
            let [a, b] = [&outcome.nodes[at - 4], &outcome.nodes[at + 4]];
            let slope = (a.pressure_mpa - b.pressure_mpa) / (b.place_mm.x - a.place_mm.x);
            let middle_mm = f64::midpoint(a.place_mm.x, b.place_mm.x);
            let strain = lines[0].shear_strain(&outcome, middle_mm / 12.0);
            let (shear_mpa, film_mpa) =
                (body.layers[0].material.shear_modulus_mpa() * strain, thickness_mm * slope);
            assert!((shear_mpa / film_mpa - 1.0).abs() < 0.06, "{share}: {shear_mpa} {film_mpa}");
        }
        let press = soft.press_tip(50.0, 0.02).unwrap();
        let [line] = &press.bonds[..] else { panic!("{press:?}") };
        assert_eq!(line.below.as_deref(), Some("floor"));
        assert!((0.6..1.1).contains(&(line.radius_mm / press.contact_radius_mm)), "{line:?}");
    }

    #[test]
    fn stress_goes_through_a_bond_and_strain_does_not() {
        // The same material twice is one layer: its middle bears half the shear of its floor or less; a stiffer
        // half below is strained less by about the ratio of moduli.
        let twice = pad(&[(0.1, 1.5), (0.1, 1.5)]).press_tip(4.0, 0.6).unwrap();
        let once = pad(&[(0.1, 3.0)]).press_tip(4.0, 0.6).unwrap();
        assert!(
            (twice.force_n / once.force_n - 1.0).abs() < 2e-3,
            "{} {}",
            twice.force_n,
            once.force_n
        );
        let (floor, all) = (&twice.bonds[1], &once.bonds[0]);
        assert!((floor.shear_mpa / all.shear_mpa - 1.0).abs() < 0.05, "{floor:?} {all:?}");
        let stiffer = pad(&[(0.1, 1.5), (1.0, 1.5)]).press_tip(4.0, 0.6).unwrap();
        let [above, below] = &stiffer.bonds[..] else { panic!("{stiffer:?}") };
        assert!(above.shear_strain > 4.0 * below.shear_strain);
        assert!(stiffer.stiffness_n_mm > 1.2 * once.stiffness_n_mm);
        assert!((2.0 * stiffer.force_n..).contains(&(stiffer.stiffness_n_mm * 0.6 * 1.4)));
    }

    #[test]
    fn large_strain_tells_how_far_the_other_is_off() {
        let soft = pad(&[(0.1, 3.0)]);
        let levels = soft.press_tip_both(4.0, &[0.1, 1.4]).unwrap();
        let off = |[linear, finite]: &[PressOutcome; 2]| linear.force_n.z / finite.force_n.z - 1.0;
        assert!(off(&levels[0]).abs() < 0.03, "{}", off(&levels[0]));
        assert!(off(&levels[1]).abs() > off(&levels[0]).abs());
    }
}
