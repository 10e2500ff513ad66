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
    /// // A half ellipsoid, 12 mm wide and 10 mm high.
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
    pub fn disc(radius_mm: f64, height_mm: f64) -> Self {
        Self::new(move |s| [s * radius_mm, height_mm])
    }

    /// Interpolates between two curves: a `share` of 0 returns the first, 1 the second.
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
