//! Reflection of a coat.

use fabkit_geometry::Vector3;

/// Reflection model of a coat: a diffuse part (Lambert) and a glossy part (Blinn 1977, scaled so that it reflects no
/// more than its share).
///
/// ```
/// use fabkit_geometry::Vector3;
/// use fabkit_light::Coat;
///
/// // Light falls in at 45 degrees; seen from the mirror direction, a glossy coat outshines a diffuse one.
/// let (matt, glossy) =
///     (Coat { diffuse: 0.5, gloss: 0.0, exponent: 1.0 }, Coat { diffuse: 0.0, gloss: 0.5, exponent: 100.0 });
/// let arrives = Vector3::new(1.0, 0.0, -1.0).normalize();
/// let [mirrored, back] = [Vector3::new(1.0, 0.0, 1.0).normalize(), -arrives];
/// let seen = |coat: Coat, to_viewer| coat.reflect(&Vector3::z(), &arrives, &to_viewer);
/// assert!(seen(glossy, mirrored) > 10.0 * seen(matt, mirrored));
/// // From where the light comes, there is no gloss, and the diffuse coat looks as from everywhere.
/// assert!(seen(glossy, back) < 1e-6 && seen(matt, back) == seen(matt, mirrored));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Diffusely reflected part of the light.
    pub diffuse: f64,
    /// Glossily reflected part, about the mirror direction.
    pub gloss: f64,
    /// Exponent of the gloss: 1 is nearly as wide as diffuse reflection, 1000 is polished.
    pub exponent: f64,
}

impl Coat {
    /// Computes the light reflected towards a viewer: pi times the radiance, for light of unit irradiance on an area
    /// across its direction. The cosine of incidence is included. All vectors are unit vectors: the coat's normal on
    /// the side of the light, the direction in which light travels, and the direction to the viewer.
    ///
    /// ```
    /// use fabkit_geometry::Vector3;
    /// let paper = fabkit_light::Coat { diffuse: 0.8, gloss: 0.0, exponent: 1.0 };
    /// let up = Vector3::z();
    /// assert_eq!(paper.reflect(&up, &-up, &up), 0.8);
    /// // Light from behind does nothing.
    /// assert_eq!(paper.reflect(&up, &up, &up), 0.0);
    /// ```
    #[inline]
    pub fn reflect(
        &self,
        normal: &Vector3<f64>,
        arrives: &Vector3<f64>,
        to_viewer: &Vector3<f64>,
    ) -> f64 {
        let cosine = -normal.dot(arrives);
        if cosine <= 0.0 {
            return 0.0;
        }
        // Length of the unnormalized half vector; it vanishes only for light that grazes away from the viewer.
        let between = (to_viewer - arrives).norm();
        let shine = (between > 1e-12).then(|| {
            let along = ((normal.dot(to_viewer) + cosine) / between).max(0.0);
            // Fitted exponents are whole numbers, for which `powi` is many times faster.
            let lobe = if f64::from(self.exponent as i32) == self.exponent && self.exponent < 1e6 {
                along.powi(self.exponent as i32)
            } else {
                along.powf(self.exponent)
            };
            self.gloss * (self.exponent + 8.0) / 8.0 * lobe
        });
        cosine * (self.diffuse + shine.unwrap_or(0.0))
    }
}
