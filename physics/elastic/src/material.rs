//! Elastic material of a layer.

use crate::error::{ElasticError, MAX_POISSON_RATIO};

/// An isotropic elastic material at small strain.
///
/// ```
/// use fabkit_elastic::ElasticMaterial;
/// let soft = ElasticMaterial::new(0.07, 0.495)?;
/// assert!((soft.shear_modulus_mpa() - 0.07 / 2.99).abs() < 1e-15);
/// assert!(ElasticMaterial::new(0.07, 0.5).is_err());
/// # Ok::<(), fabkit_elastic::ElasticError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticMaterial {
    young_mpa: f64,
    poisson: f64,
}

impl ElasticMaterial {
    /// Creates a material from Young's modulus, MPa, and Poisson's ratio.
    ///
    /// # Errors
    /// A modulus that is not positive and finite, or a ratio outside 0 to [`MAX_POISSON_RATIO`].
    pub fn new(young_mpa: f64, poisson: f64) -> Result<Self, ElasticError> {
        if !(young_mpa > 0.0 && young_mpa.is_finite()) {
            return Err(ElasticError::Young { young_mpa });
        }
        if !(0.0..=MAX_POISSON_RATIO).contains(&poisson) {
            return Err(ElasticError::Poisson { poisson });
        }
        Ok(Self { young_mpa, poisson })
    }

    /// Young's modulus, MPa.
    pub fn young_mpa(&self) -> f64 {
        self.young_mpa
    }

    /// Poisson's ratio.
    pub fn poisson(&self) -> f64 {
        self.poisson
    }

    /// Shear modulus (Lame's second constant), MPa.
    pub fn shear_modulus_mpa(&self) -> f64 {
        self.young_mpa / (2.0 * (1.0 + self.poisson))
    }

    /// Lame's first constant, MPa.
    pub(crate) fn lame_mpa(&self) -> f64 {
        2.0 * self.shear_modulus_mpa() * self.poisson / (1.0 - 2.0 * self.poisson)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_material_has_is_refused_with_its_number() {
        for young_mpa in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = ElasticMaterial::new(young_mpa, 0.4).unwrap_err().to_string();
            assert!(error.contains(&format!("{young_mpa} MPa")), "{error}");
        }
        for poisson in [-0.1, 0.5, 0.49995, 0.7, f64::NAN] {
            let error = ElasticMaterial::new(1.0, poisson).unwrap_err().to_string();
            assert!(error.contains(&poisson.to_string()), "{error}");
            assert!(error.contains("0.4999"), "{error}");
        }
    }

    #[test]
    fn constants_give_youngs_modulus_back() {
        let material = ElasticMaterial::new(1.7, 0.45).unwrap();
        let (g, lame) = (material.shear_modulus_mpa(), material.lame_mpa());
        let young = g * (3.0 * lame + 2.0 * g) / (lame + g);
        assert!((young - 1.7).abs() < 1e-14);
    }
}
