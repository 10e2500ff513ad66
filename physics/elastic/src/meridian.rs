//! A layered body of revolution, as its interfaces' exact meridians.

use std::fmt;
use std::sync::Arc;

use crate::{ElasticError, Material};

/// Radius, mm, and height, mm, at s from 0 (on the axis) to 1 (at the rim).
type Meridian = Arc<dyn Fn(f64) -> [f64; 2] + Send + Sync>;

/// The meridian of one interface between layers.
#[derive(Clone)]
pub struct Curve(Meridian);

impl Curve {
    /// From a function of s, which runs from 0 on the axis to 1 at the rim, to radius and height, mm.
    ///
    /// The curve must be smooth but for kinks at [`Body::kinks`], and equal s on neighbouring curves should
    /// lie across from each other: elements reach from one to the next in straight lines.
    ///
    /// ```
    /// use fabkit_elastic::Curve;
    /// // A half ellipsoid, 12 mm wide and 10 mm high.
    /// let dome = Curve::new(|s| {
    ///     let angle = s * std::f64::consts::FRAC_PI_2;
    ///     [12.0 * angle.sin(), 10.0 * angle.cos()]
    /// });
    /// assert_eq!(dome.at(0.0), [0.0, 10.0]);
    /// ```
    pub fn new(at: impl Fn(f64) -> [f64; 2] + Send + Sync + 'static) -> Self {
        Self(Arc::new(at))
    }

    /// A disc: the meridian of a flat pad's face.
    pub fn disc(radius_mm: f64, height_mm: f64) -> Self {
        Self::new(move |s| [s * radius_mm, height_mm])
    }

    /// Between two curves: at 0 on the first, at 1 on the second.
    #[must_use]
    pub fn between(first: &Self, second: &Self, share: f64) -> Self {
        let (first, second) = (first.clone(), second.clone());
        Self::new(move |s| {
            let (a, b) = (first.at(s), second.at(s));
            [0, 1].map(|k| (1.0 - share) * a[k] + share * b[k])
        })
    }

    /// Radius, mm, and height, mm.
    pub fn at(&self, s: f64) -> [f64; 2] {
        (self.0)(s)
    }
}

impl fmt::Debug for Curve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Curve({:?} to {:?})", self.at(0.0), self.at(1.0))
    }
}

/// What lies between two interfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// What messages call it.
    pub name: String,
    /// What it is made of.
    pub material: Material,
}

/// What holds a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hold {
    /// Nothing: no traction.
    Free,
    /// Bonded to what is stiff: no displacement.
    Bonded,
    /// Bonded from this s on to the rim.
    BondedBeyond(f64),
}

impl Hold {
    /// Whether it holds at a place.
    pub(crate) fn holds(self, s: f64) -> bool {
        match self {
            Self::Free => false,
            Self::Bonded => true,
            Self::BondedBeyond(from) => s >= from - 1e-12,
        }
    }
}

/// Layers of revolution about the z axis, bonded to each other.
///
/// A flat pad is the same thing: its interfaces are discs.
#[derive(Clone, Debug)]
pub struct Body {
    /// From the touched surface inwards; one more than layers.
    pub interfaces: Vec<Curve>,
    /// From the touched surface inwards.
    pub layers: Vec<Layer>,
    /// What holds the innermost interface.
    pub inner: Hold,
    /// Whether the rim, s = 1, of all layers is bonded to what is stiff.
    pub is_rim_bonded: bool,
    /// Where a curve has a kink, as s between 0 and 1: elements end there.
    pub kinks: Vec<f64>,
}

impl Body {
    /// A pad of one or more flat layers, the touched one first, on a stiff floor at z = 0 with a free rim.
    ///
    /// Thicknesses in mm.
    pub fn pad(radius_mm: f64, layers: Vec<(Layer, f64)>) -> Self {
        let mut height_mm: f64 = layers.iter().map(|(_, thickness_mm)| thickness_mm).sum();
        let mut interfaces = vec![Curve::disc(radius_mm, height_mm)];
        let last = layers.len().saturating_sub(1);
        for (i, (_, thickness_mm)) in layers.iter().enumerate() {
            height_mm = if i == last { 0.0 } else { height_mm - thickness_mm };
            interfaces.push(Curve::disc(radius_mm, height_mm));
        }
        Self {
            interfaces,
            layers: layers.into_iter().map(|(layer, _)| layer).collect(),
            inner: Hold::Bonded,
            is_rim_bonded: false,
            kinks: Vec::new(),
        }
    }

    /// # Errors
    /// Numbers of interfaces and layers that do not go together, a kink off the curve, nothing that holds.
    pub(crate) fn check(&self) -> Result<(), ElasticError> {
        let (layers, interfaces) = (self.layers.len(), self.interfaces.len());
        if layers == 0 || interfaces != layers + 1 {
            return Err(ElasticError::Interfaces { layers, interfaces });
        }
        let ends = match self.inner {
            Hold::BondedBeyond(from) => vec![from],
            Hold::Free | Hold::Bonded => Vec::new(),
        };
        for &value in self.kinks.iter().chain(&ends) {
            if !(value > 0.0 && value < 1.0) {
                let hint = "a kink, or where a bond begins, lies between s = 0 and s = 1";
                return Err(ElasticError::Division { what: "a kink", value, hint });
            }
        }
        if self.inner == Hold::Free && !self.is_rim_bonded {
            return Err(ElasticError::Loose);
        }
        Ok(())
    }

    /// Where elements must end besides at 0 and 1, in order.
    pub(crate) fn ends(&self) -> Vec<f64> {
        let mut ends = self.kinks.clone();
        if let Hold::BondedBeyond(from) = self.inner {
            ends.push(from);
        }
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        ends
    }

    /// # Errors
    /// A curve that says nothing finite, or leaves the half plane of positive radii.
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
