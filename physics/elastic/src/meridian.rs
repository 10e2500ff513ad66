//! A layered body of revolution, given by the exact meridians of its interfaces.

use std::fmt;
use std::sync::Arc;

use crate::{ElasticError, ElasticMaterial};

/// Function from s (0 on the axis, 1 at the rim) to radius, mm, and height, mm.
type Meridian = Arc<dyn Fn(f64) -> [f64; 2] + Send + Sync>;

/// The meridian of one interface between layers.
#[derive(Clone)]
pub struct MeridianCurve(Meridian);

impl MeridianCurve {
    /// Creates a curve from a function of s, which runs from 0 on the axis to 1 at the rim, to radius and height, mm.
    ///
    /// The curve must be smooth except at [`LayeredBody::kinks`]. Points of equal s on neighbouring curves should lie opposite
    /// each other: elements span from one curve to the next in straight lines.
    ///
    /// ```
    /// use fabkit_elastic::MeridianCurve;
    /// // A half ellipsoid, 24 mm wide at its rim and 10 mm high.
    /// let dome = MeridianCurve::new(|s| {
    ///     let angle = s * std::f64::consts::FRAC_PI_2;
    ///     [12.0 * angle.sin(), 10.0 * angle.cos()]
    /// });
    /// assert_eq!(dome.at(0.0), [0.0, 10.0]);
    /// ```
    pub fn new(at: impl Fn(f64) -> [f64; 2] + Send + Sync + 'static) -> Self {
        Self(Arc::new(at))
    }

    /// Creates a disc: the meridian of a flat pad's face.
    ///
    /// ```
    /// use fabkit_elastic::MeridianCurve;
    ///
    /// // The face of a pad of radius 8 mm, 3 mm above the origin.
    /// let face = MeridianCurve::disc(8.0, 3.0);
    /// assert_eq!((face.at(0.0), face.at(0.5), face.at(1.0)), ([0.0, 3.0], [4.0, 3.0], [8.0, 3.0]));
    /// ```
    pub fn disc(radius_mm: f64, height_mm: f64) -> Self {
        Self::new(move |s| [s * radius_mm, height_mm])
    }

    /// Interpolates between two curves: a `share` of 0 returns the first, 1 the second.
    ///
    /// ```
    /// use fabkit_elastic::MeridianCurve;
    ///
    /// // A quarter of the way from the touched face, at 3 mm, to the floor.
    /// let (face, floor) = (MeridianCurve::disc(8.0, 3.0), MeridianCurve::disc(8.0, 0.0));
    /// assert_eq!(MeridianCurve::between(&face, &floor, 0.25).at(0.5), [4.0, 2.25]);
    /// ```
    #[must_use]
    pub fn between(first: &Self, second: &Self, share: f64) -> Self {
        let (first, second) = (first.clone(), second.clone());
        Self::new(move |s| {
            let (a, b) = (first.at(s), second.at(s));
            [0, 1].map(|k| (1.0 - share) * a[k] + share * b[k])
        })
    }

    /// Returns radius, mm, and height, mm, at s.
    pub fn at(&self, s: f64) -> [f64; 2] {
        (self.0)(s)
    }
}

impl fmt::Debug for MeridianCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Curve({:?} to {:?})", self.at(0.0), self.at(1.0))
    }
}

/// Soft layer between two interfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct ElasticLayer {
    /// Name used in messages.
    pub name: String,
    /// Material of the layer.
    pub material: ElasticMaterial,
}

/// Boundary condition of an interface.
///
/// ```
/// use fabkit_elastic::{BoundaryCondition, ElasticError, ElasticLayer, ElasticMaterial, ElasticStack};
/// use fabkit_elastic::{LayeredBody, MeshDensity};
///
/// // A pad of which only a ring outside of half of its radius is glued on. If nothing is, there is no solution.
/// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
/// let mut pad = LayeredBody::pad(10.0, vec![(gel, 2.0)]);
/// pad.inner = BoundaryCondition::BondedBeyond(0.5);
/// assert!(ElasticStack::new(&pad, &MeshDensity::uniform(0.5, 0), 1).is_ok());
/// pad.inner = BoundaryCondition::Free;
/// let error = ElasticStack::new(&pad, &MeshDensity::uniform(0.5, 0), 1).unwrap_err();
/// assert_eq!(error, ElasticError::NotBonded);
/// # Ok::<(), ElasticError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoundaryCondition {
    /// Free: no traction.
    Free,
    /// Bonded to a rigid part: no displacement.
    Bonded,
    /// Bonded from this s on to the rim.
    BondedBeyond(f64),
}

impl BoundaryCondition {
    /// Returns whether the interface is bonded at s.
    pub(crate) fn is_bonded_at(self, s: f64) -> bool {
        match self {
            Self::Free => false,
            Self::Bonded => true,
            Self::BondedBeyond(from) => s >= from - 1e-12,
        }
    }
}

/// Layers of revolution about the z axis, bonded to each other.
///
/// Interfaces of a flat pad are discs.
#[derive(Clone, Debug)]
pub struct LayeredBody {
    /// Interfaces from the touched surface inwards; one more than layers.
    pub interfaces: Vec<MeridianCurve>,
    /// Layers from the touched surface inwards.
    pub layers: Vec<ElasticLayer>,
    /// Boundary condition of the innermost interface.
    pub inner: BoundaryCondition,
    /// True if the rim, s = 1, of all layers is bonded to a rigid part.
    pub is_rim_bonded: bool,
    /// Values of s between 0 and 1 where a curve has a kink; elements end there.
    pub kinks: Vec<f64>,
}

impl LayeredBody {
    /// Creates a pad of one or more flat layers, the touched one first, on a rigid floor at z = 0 with a free rim.
    ///
    /// Thicknesses are in mm.
    ///
    /// ```
    /// use fabkit_elastic::{ElasticLayer, ElasticMaterial, LayeredBody};
    ///
    /// // A skin of 0.5 mm on 2 mm of softer gel: the touched face lies at 2.5 mm, the floor at 0.
    /// let layer = |name: &str, young_mpa| {
    ///     Ok::<_, fabkit_elastic::ElasticError>(ElasticLayer {
    ///         name: name.to_owned(),
    ///         material: ElasticMaterial::new(young_mpa, 0.49)?,
    ///     })
    /// };
    /// let pad = LayeredBody::pad(10.0, vec![(layer("skin", 1.0)?, 0.5), (layer("gel", 0.1)?, 2.0)]);
    /// let heights_mm: Vec<f64> = pad.interfaces.iter().map(|face| face.at(0.0)[1]).collect();
    /// assert_eq!(heights_mm, [2.5, 2.0, 0.0]);
    /// # Ok::<(), fabkit_elastic::ElasticError>(())
    /// ```
    pub fn pad(radius_mm: f64, layers: Vec<(ElasticLayer, f64)>) -> Self {
        let mut height_mm: f64 = layers.iter().map(|(_, thickness_mm)| thickness_mm).sum();
        let mut interfaces = vec![MeridianCurve::disc(radius_mm, height_mm)];
        let last = layers.len().saturating_sub(1);
        for (i, (_, thickness_mm)) in layers.iter().enumerate() {
            // The last interface lies exactly on the floor, whatever rounding the sum left.
            height_mm = if i == last { 0.0 } else { height_mm - thickness_mm };
            interfaces.push(MeridianCurve::disc(radius_mm, height_mm));
        }
        Self {
            interfaces,
            layers: layers.into_iter().map(|(layer, _)| layer).collect(),
            inner: BoundaryCondition::Bonded,
            is_rim_bonded: false,
            kinks: Vec::new(),
        }
    }

    /// Checks the body.
    ///
    /// # Errors
    /// Numbers of interfaces and layers that do not match, a kink off the curve, or no bonded boundary.
    pub(crate) fn check(&self) -> Result<(), ElasticError> {
        let (layers, interfaces) = (self.layers.len(), self.interfaces.len());
        if layers == 0 || interfaces != layers + 1 {
            return Err(ElasticError::Interfaces { layers, interfaces });
        }
        let ends = match self.inner {
            BoundaryCondition::BondedBeyond(from) => vec![from],
            BoundaryCondition::Free | BoundaryCondition::Bonded => Vec::new(),
        };
        for &value in self.kinks.iter().chain(&ends) {
            if !(value > 0.0 && value < 1.0) {
                let hint = "a kink, or where a bond begins, lies between s = 0 and s = 1";
                return Err(ElasticError::MeshDensity { what: "a kink", value, hint });
            }
        }
        if self.inner == BoundaryCondition::Free && !self.is_rim_bonded {
            return Err(ElasticError::NotBonded);
        }
        Ok(())
    }

    /// Returns, in order, the values of s besides 0 and 1 where elements must end.
    pub(crate) fn ends(&self) -> Vec<f64> {
        let mut ends = self.kinks.clone();
        if let BoundaryCondition::BondedBeyond(from) = self.inner {
            ends.push(from);
        }
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        ends
    }

    /// Evaluates an interface at s as radius and height, mm.
    ///
    /// # Errors
    /// A curve that returns a number that is not finite, does not begin on the axis, or leaves the half plane of
    /// positive radii.
    pub(crate) fn place(&self, interface: usize, s: f64) -> Result<[f64; 2], ElasticError> {
        let [radius_mm, height_mm] = self.interfaces[interface].at(s);
        let is_in_place = if s == 0.0 {
            radius_mm.abs() < 1e-9
        } else {
            radius_mm > 1e-9 && radius_mm.is_finite()
        };
        if !is_in_place || !height_mm.is_finite() {
            return Err(ElasticError::Curve { interface, s, radius_mm, height_mm });
        }
        Ok([if s == 0.0 { 0.0 } else { radius_mm }, height_mm])
    }
}
