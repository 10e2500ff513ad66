//! What a reflective coat sends back.

use fabkit_geometry::Vector3;

/// A coat that spreads light as paper does (Lambert), and sends a part of it on as a rough mirror does (Blinn 1977,
/// scaled so that it sends back no more than its share).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Which part of the light is spread.
    pub diffuse: f64,
    /// Which part is sent on, about the way of a mirror.
    pub shine: f64,
    /// How narrow that is; 1 is nearly as wide as paper, 1000 is polished.
    pub exponent: f64,
}

impl Coat {
    /// What is sent towards a viewer, of light that arrives on an area across it: radiance times pi over the light's
    /// density, with the cosine. All unit vectors: the coat's normal towards the light's side, the way in which light
    /// arrives, the way towards the viewer.
    ///
    /// ```
    /// use fabkit_geometry::Vector3;
    /// let paper = fabkit_light::Coat { diffuse: 0.8, shine: 0.0, exponent: 1.0 };
    /// let up = Vector3::z();
    /// assert_eq!(paper.sends(&up, &-up, &up), 0.8);
    /// // Light from behind does nothing.
    /// assert_eq!(paper.sends(&up, &up, &up), 0.0);
    /// ```
    #[inline]
    pub fn sends(
        &self,
        normal: &Vector3<f64>,
        arrives: &Vector3<f64>,
        to_viewer: &Vector3<f64>,
    ) -> f64 {
        let cosine = -normal.dot(arrives);
        if cosine <= 0.0 {
            return 0.0;
        }
        let between = (to_viewer - arrives).norm();
        let shine = (between > 1e-12).then(|| {
            let along = ((normal.dot(to_viewer) + cosine) / between).max(0.0);
            // Whole numbers are what constants are, and many times as fast.
            let lobe = match f64::from(self.exponent as i32) == self.exponent && self.exponent < 1e6
            {
                true => along.powi(self.exponent as i32),
                false => along.powf(self.exponent),
            };
            self.shine * (self.exponent + 8.0) / 8.0 * lobe
        });
        cosine * (self.diffuse + shine.unwrap_or(0.0))
    }
}
