//! Element boundaries along the meridian and through the layers.

use crate::ElasticError;
use crate::meridian::LayeredBody;

/// Number of chords by which a curve's length is measured.
const LENGTH_STEPS: usize = 4000;
/// Maximum number of nodes along a meridian; each is a ring.
const MAX_RINGS: usize = 2000;
/// Maximum number of elements through one layer.
const MAX_THROUGH: usize = 60;

/// Mesh density of a body.
///
/// Nodes of the touched surface are `spacing_mm` apart up to `reach_mm` from the pole, along the meridian. Beyond,
/// elements (each has two spacings) grow by the factor `growth` from one to the next.
///
/// ```
/// use fabkit_elastic::{ElasticLayer, ElasticMaterial, ElasticStack, LayeredBody, MeshDensity};
///
/// // Nodes 0.5 mm apart on a disc of radius 10 mm: 21 rings. Without harmonics each is one node.
/// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
/// let pad = LayeredBody::pad(10.0, vec![(gel, 2.0)]);
/// let nodes = |density: &MeshDensity| Ok(ElasticStack::new(&pad, density, 1)?.surface_nodes());
/// assert_eq!(nodes(&MeshDensity::uniform(0.5, 0))?, 21);
/// // What is coarse far from the press needs fewer.
/// assert!(nodes(&MeshDensity::around_pole(0.5, 2.0, 0))? < 21);
/// # Ok::<(), fabkit_elastic::ElasticError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshDensity {
    /// Distance of neighbouring nodes of the touched surface, mm.
    pub spacing_mm: f64,
    /// Distance from the pole, along the meridian, up to which the spacing is constant, mm; infinite for the whole
    /// surface.
    pub reach_mm: f64,
    /// Length ratio of neighbouring elements beyond `reach_mm`; 1 for equal lengths.
    pub growth: f64,
    /// Maximum thickness ratio of an element to its outer neighbour; 1 for equal thicknesses.
    pub growth_inwards: f64,
    /// Highest harmonic of the azimuth; 0 restricts the body to axisymmetric presses.
    pub max_harmonic: usize,
}

impl MeshDensity {
    /// Creates a division with constant spacing.
    pub fn uniform(spacing_mm: f64, max_harmonic: usize) -> Self {
        Self { spacing_mm, reach_mm: f64::INFINITY, growth: 1.0, growth_inwards: 1.4, max_harmonic }
    }

    /// Creates a division that is fine around the pole and coarser beyond `reach_mm`.
    pub fn around_pole(spacing_mm: f64, reach_mm: f64, max_harmonic: usize) -> Self {
        Self { spacing_mm, reach_mm, growth: 1.15, growth_inwards: 1.4, max_harmonic }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// Lengths that are not positive and finite (`reach_mm` may be infinite), or growth factors outside 1 to 2.
    pub(crate) fn check(&self) -> Result<(), ElasticError> {
        let positive = |what, value: f64| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(ElasticError::MeshDensity { what, value, hint: "take a positive length in mm" })
            }
        };
        let growing = |what, value: f64| {
            if (1.0..=2.0).contains(&value) {
                Ok(())
            } else {
                Err(ElasticError::MeshDensity { what, value, hint: "take 1 to 2" })
            }
        };
        positive("a spacing", self.spacing_mm)?;
        // An infinite reach stands for constant spacing everywhere.
        if !self.reach_mm.is_infinite() {
            positive("a reach", self.reach_mm)?;
        }
        growing("a growth", self.growth)?;
        growing("a growth inwards", self.growth_inwards)
    }

    /// Computes the boundaries of elements along s, from 0 to 1.
    ///
    /// # Errors
    /// A curve that fails, or more rings than [`MAX_RINGS`].
    pub(crate) fn boundaries_along(&self, body: &LayeredBody) -> Result<Vec<f64>, ElasticError> {
        let lengths = lengths(body)?;
        let total_mm = lengths[LENGTH_STEPS];
        let mut kinks_mm: Vec<f64> = body.ends().iter().map(|&s| length_at(&lengths, s)).collect();
        kinks_mm.push(total_mm);
        // An element has two node spacings.
        let (mut ends_mm, mut size_mm) = (vec![0.0], 2.0 * self.spacing_mm);
        for kink_mm in kinks_mm {
            let begin_mm = ends_mm[ends_mm.len() - 1];
            let (mut sizes, mut sum_mm) = (Vec::new(), 0.0);
            // A remainder of less than half an element is not added; the other elements are stretched instead.
            while sum_mm + 0.5 * size_mm < kink_mm - begin_mm || sizes.is_empty() {
                if begin_mm + sum_mm >= self.reach_mm {
                    size_mm *= self.growth;
                }
                sizes.push(size_mm);
                sum_mm += size_mm;
                if ends_mm.len() + sizes.len() > MAX_RINGS / 2 {
                    return Err(ElasticError::MeshDensity {
                        what: "a spacing",
                        value: self.spacing_mm,
                        hint: "it makes more than 2,000 rings: take a wider one",
                    });
                }
            }
            // All elements up to the kink are stretched alike to end exactly there.
            let scale = (kink_mm - begin_mm) / sum_mm;
            let mut end_mm = begin_mm;
            for size in &sizes {
                end_mm += size * scale;
                ends_mm.push(end_mm);
            }
        }
        let last = ends_mm.len() - 1;
        let mut ends: Vec<f64> = ends_mm.iter().map(|&mm| s_at(&lengths, mm)).collect();
        ends[last] = 1.0;
        for kink in body.ends() {
            // Exactly where the caller put the kink, not where rounding of lengths moved it.
            let nearest =
                ends.iter_mut().min_by(|a, b| (**a - kink).abs().total_cmp(&(**b - kink).abs()));
            if let Some(end) = nearest {
                *end = kink;
            }
        }
        Ok(ends)
    }

    /// Computes the boundaries of elements through each layer, as fractions from its outer face (0) to its inner face
    /// (1).
    ///
    /// # Errors
    /// A curve that fails.
    pub(crate) fn boundaries_through(
        &self,
        body: &LayeredBody,
    ) -> Result<Vec<Vec<f64>>, ElasticError> {
        let mut size_mm = 2.0 * self.spacing_mm;
        let mut through = Vec::new();
        for layer in 0..body.layers.len() {
            let (outer, inner) = (body.place(layer, 0.0)?, body.place(layer + 1, 0.0)?);
            let thickness_mm = (outer[1] - inner[1]).abs();
            let (mut sizes, mut sum_mm) = (Vec::new(), 0.0);
            // At least two elements through each layer, however thin.
            while sum_mm < thickness_mm * (1.0 - 1e-9) && sizes.len() < MAX_THROUGH
                || sizes.len() < 2
            {
                sizes.push(size_mm);
                sum_mm += size_mm;
                size_mm *= self.growth_inwards;
            }
            let (mut end, mut ends) = (0.0, vec![0.0]);
            for size in &sizes {
                end += size / sum_mm;
                ends.push(end);
            }
            let count = ends.len() - 1;
            ends[count] = 1.0;
            // The next layer continues with the size that this one has reached.
            size_mm = sizes[sizes.len() - 1] * thickness_mm / sum_mm;
            through.push(ends);
        }
        Ok(through)
    }
}

/// Computes the length of the touched surface's meridian up to each of evenly spaced s, mm.
fn lengths(body: &LayeredBody) -> Result<Vec<f64>, ElasticError> {
    let mut lengths = vec![0.0];
    let mut before = body.place(0, 0.0)?;
    for i in 1..=LENGTH_STEPS {
        let here = body.place(0, i as f64 / LENGTH_STEPS as f64)?;
        lengths.push(lengths[i - 1] + (here[0] - before[0]).hypot(here[1] - before[1]));
        before = here;
    }
    Ok(lengths)
}

fn length_at(lengths: &[f64], s: f64) -> f64 {
    let place = s * LENGTH_STEPS as f64;
    let i = (place as usize).min(LENGTH_STEPS - 1);
    lengths[i] + (place - i as f64) * (lengths[i + 1] - lengths[i])
}

fn s_at(lengths: &[f64], length_mm: f64) -> f64 {
    let i = lengths.partition_point(|&l| l <= length_mm).clamp(1, LENGTH_STEPS) - 1;
    let step_mm = lengths[i + 1] - lengths[i];
    let within = if step_mm > 0.0 { (length_mm - lengths[i]) / step_mm } else { 0.0 };
    (i as f64 + within) / LENGTH_STEPS as f64
}
