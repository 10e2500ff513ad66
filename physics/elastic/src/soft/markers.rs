//! Displacement of the markers that a camera follows, during a press.

use fabkit_geometry::{Marker, MarkerCarrier, Point3, TouchSurface, Vector3};

use super::SoftStack;
use super::rod::{Rod, Turn};
use crate::{MeridianCurve, PressOutcome};

/// Distance from an interface, as a part of the layer, below which a marker counts as lying on it.
const ON_INTERFACE: f64 = 0.02;
/// Parameter s at which the layers end.
const RIM: f64 = 1.0;

/// A displaced marker, in the sensor frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplacedMarker {
    /// Displacement from the position at rest, mm.
    pub displacement_mm: Vector3<f64>,
    /// Direction of the displaced marker's axis, unit.
    pub axis: Vector3<f64>,
}

/// Position within the layers.
struct LayerPosition {
    s: f64,
    azimuth: f64,
    /// Layer, counted from outside.
    layer: usize,
    /// Depth within the layer, from 0 at its outer face to 1 at its inner one.
    share: f64,
}

impl LayerPosition {
    fn nearest_interface(&self) -> usize {
        if self.share < 0.5 { self.layer } else { self.layer + 1 }
    }
}

impl SoftStack {
    /// Divides layers at markers inside them, so that the solver computes the displacement at just that depth. At most
    /// one interface is added to each layer, at the depth of the median marker as a part of the layer.
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
    /// use fabkit_geometry::{Marker, MarkerCarrier, Point3, Vector3};
    ///
    /// // A dot in the middle of 3 mm of gel: the gel becomes two layers, bonded to each other, with the dot between.
    /// let mut soft = SoftStack::at_tip(&sensor)?;
    /// let (point, axis) = (Point3::new(2.0, 0.0, 1.5), -Vector3::z());
    /// let dot = Marker { name: "dot 1".to_owned(), point, axis, radius_mm: 0.2, carrier: MarkerCarrier::Gel };
    /// soft.divide_at_markers(sensor.touch.as_ref().unwrap(), &[dot]);
    /// let heights_mm: Vec<f64> = soft.body.interfaces.iter().map(|face| face.at(0.0)[1]).collect();
    /// assert!(heights_mm.iter().zip([3.0, 1.5, 0.0]).all(|(found, z_mm)| (found - z_mm).abs() < 1e-9));
    /// # Ok::<(), fabkit_elastic::SoftError>(())
    /// ```
    pub fn divide_at_markers(&mut self, touch: &TouchSurface, marks: &[Marker]) {
        let mut shares = vec![Vec::new(); self.body.layers.len()];
        for within in marks.iter().filter_map(|mark| self.locate(touch, mark.point)) {
            shares[within.layer].push(within.share);
        }
        // From inside, since an insertion shifts the indices of what follows.
        for (layer, mut shares) in shares.into_iter().enumerate().rev() {
            shares.sort_by(f64::total_cmp);
            let share = shares.get(shares.len() / 2).copied().unwrap_or(0.0);
            if !(ON_INTERFACE..=1.0 - ON_INTERFACE).contains(&share) {
                continue;
            }
            let body = &mut self.body;
            let [outer, inner] = [layer, layer + 1].map(|i| &body.interfaces[i]);
            let between = MeridianCurve::between(outer, inner, share);
            body.interfaces.insert(layer + 1, between);
            body.layers.insert(layer, body.layers[layer].clone());
        }
    }

    /// Computes the displacement of a marker during a press; `None` beyond the end of the layers.
    ///
    /// The gel carries a marker like its centre. This is exact for markers as stiff as the gel around them, and for any
    /// symmetric marker in a strain that is uniform over its size. A pin follows the displacement and the rotation of
    /// the interface that it stands on, averaged over its foot; beyond its foot it is a beam in the surrounding gel.
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
    /// use fabkit_elastic::{BallIndenter, Press, SoftStack};
    /// use fabkit_geometry::{Marker, MarkerCarrier, Point3, Vector3};
    ///
    /// // A dot on the face of 3 mm of gel, 2 mm beside a ball that comes down 0.2 mm deep.
    /// let soft = SoftStack::at_tip(&sensor)?;
    /// let stack = soft.build_stack(0.25, 3.0, 8, 1)?;
    /// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 9.0), 4.0)?;
    /// let outcome = stack.press(&ball, &Press::along(-Vector3::z(), 0.2)?)?;
    /// let (point, axis) = (Point3::new(2.0, 0.0, 3.0), -Vector3::z());
    /// let dot = Marker { name: "dot 1".to_owned(), point, axis, radius_mm: 0.2, carrier: MarkerCarrier::Gel };
    /// let moved = soft.displace_marker(&outcome, sensor.touch.as_ref().unwrap(), &dot).unwrap();
    /// // It moves away from the ball, and not around it.
    /// assert!(moved.displacement_mm.x > 0.0 && moved.displacement_mm.y.abs() < 1e-6);
    /// # Ok::<(), fabkit_elastic::SoftError>(())
    /// ```
    pub fn displace_marker(
        &self,
        outcome: &PressOutcome,
        touch: &TouchSurface,
        mark: &Marker,
    ) -> Option<DisplacedMarker> {
        let here = self.locate(touch, mark.point)?;
        let gel_moved_mm = self.gel_displacement_mm(outcome, &here);
        let MarkerCarrier::Pin { root } = mark.carrier else {
            let turn =
                self.interface_rotation(outcome, touch, mark.point, &here, mark.radius_mm)?;
            return Some(DisplacedMarker {
                displacement_mm: gel_moved_mm,
                axis: turn.rotate(mark.axis),
            });
        };
        let foot = self.locate(touch, root)?;
        let turn = self.interface_rotation(outcome, touch, root, &foot, mark.radius_mm)?;
        // The pin's material is that of the layer outside of its interface.
        let below = foot.nearest_interface().min(self.body.layers.len() - 1);
        let [pin, gel] = [below.saturating_sub(1), below].map(|i| &self.body.layers[i].material);
        let lever_mm = mark.point - root;
        let rod = Rod::new(pin, gel, mark.radius_mm, lever_mm.norm());
        let root_moved_mm = self.gel_displacement_mm(outcome, &foot);
        let (displacement_mm, axis) =
            rod.displace_end(lever_mm, root_moved_mm, gel_moved_mm, &turn);
        Some(DisplacedMarker { displacement_mm, axis })
    }

    /// Locates a point in the layers; `None` beyond their end.
    fn locate(&self, touch: &TouchSurface, point: Point3<f64>) -> Option<LayerPosition> {
        let (depth_mm, outward) = touch.depth_mm(&point);
        let [s, azimuth] = self.coordinates(&(point + depth_mm * outward));
        if s > RIM {
            return None;
        }
        let places: Vec<[f64; 2]> = self.body.interfaces.iter().map(|curve| curve.at(s)).collect();
        let depth_of = |i: usize| {
            let [[r, z], [outer_r, outer_z]] = [places[i], places[0]];
            (r - outer_r).hypot(z - outer_z)
        };
        // Points outside of all layers, or below them, are put on the nearest face.
        let layers = self.body.layers.len();
        let layer = (1..layers).rev().find(|layer| depth_of(*layer) <= depth_mm).unwrap_or(0);
        let [outer_mm, inner_mm] = [layer, layer + 1].map(depth_of);
        let share = ((depth_mm - outer_mm) / (inner_mm - outer_mm)).clamp(0.0, 1.0);
        Some(LayerPosition { s, azimuth, layer, share })
    }

    /// Interpolates the displacement linearly between interfaces, in the sensor frame, mm.
    fn gel_displacement_mm(&self, outcome: &PressOutcome, at: &LayerPosition) -> Vector3<f64> {
        let [outer, inner] =
            [at.layer, at.layer + 1].map(|i| outcome.displacement_mm(i, at.azimuth, at.s));
        self.sensor_from_stack.vector((1.0 - at.share) * outer + at.share * inner)
    }

    /// Computes the rotation of the nearest interface from two tangents across the point, before and after the press.
    fn interface_rotation(
        &self,
        outcome: &PressOutcome,
        touch: &TouchSurface,
        point: Point3<f64>,
        at: &LayerPosition,
        radius_mm: f64,
    ) -> Option<Turn> {
        let (depth_mm, outward) = touch.depth_mm(&point);
        let surface = point + depth_mm * outward;
        let interface = at.nearest_interface();
        let ways = self.surface_tangents(&surface, &outward).map(|way| {
            // Central difference over the marker's own width, which averages over its foot.
            let [ahead, behind] = [1.0, -1.0].map(|side| {
                let [s, azimuth] = self.coordinates(&(surface + side * radius_mm * way));
                let s = s.min(RIM);
                let place = outcome.place_mm(interface, azimuth, s).coords;
                [place, place + outcome.displacement_mm(interface, azimuth, s)]
            });
            [ahead[0] - behind[0], ahead[1] - behind[1]]
        });
        let normal = |when: usize| {
            let normal = ways[0][when].cross(&ways[1][when]).try_normalize(1e-12)?;
            Some(self.sensor_from_stack.vector(normal))
        };
        Some(Turn { before: normal(0)?, after: normal(1)? })
    }
}
