//! Reflection of a translucent layer on a black ground.

/// Two-stream model of a layer that scatters and does not absorb, on a black ground (Kubelka and Munk 1931, without
/// absorption).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoStream {
    /// Scattering coefficient: part of the light that turns back per millimetre, 1/mm.
    pub scatter_per_mm: f64,
}

impl TwoStream {
    /// Returns the reflectance for diffuse light of a layer of this thickness, mm: 0 for no layer, nearly 1 for a thick
    /// one.
    ///
    /// ```
    /// use fabkit_light::TwoStream;
    ///
    /// // Where a layer is thin, twice the thickness is nearly twice as bright; where it is thick, hardly brighter.
    /// let gel = TwoStream { scatter_per_mm: 1.0 };
    /// let gain = |thickness_mm: f64| gel.reflectance(2.0 * thickness_mm) / gel.reflectance(thickness_mm);
    /// assert!(gain(0.01) > 1.98 && gain(100.0) < 1.01);
    /// // Without a layer, only the black ground is left.
    /// assert_eq!(gel.reflectance(0.0), 0.0);
    /// ```
    pub fn reflectance(self, thickness_mm: f64) -> f64 {
        let sent = self.scatter_per_mm * thickness_mm.max(0.0);
        sent / (1.0 + sent)
    }

    /// Returns the thickness, mm, of a layer with this reflectance; infinite at 1 and above.
    ///
    /// ```
    /// use fabkit_light::TwoStream;
    ///
    /// // Half of the light comes back from 2 mm, two thirds from 4 mm.
    /// let gel = TwoStream { scatter_per_mm: 0.5 };
    /// assert_eq!(gel.thickness_mm(0.5), 2.0);
    /// assert!((gel.thickness_mm(2.0 / 3.0) - 4.0).abs() < 1e-12);
    /// assert_eq!(gel.thickness_mm(1.0), f64::INFINITY);
    /// ```
    pub fn thickness_mm(self, reflectance: f64) -> f64 {
        let part = reflectance.clamp(0.0, 1.0);
        part / (1.0 - part) / self.scatter_per_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thickness_is_recovered_from_reflectance() {
        let gel = TwoStream { scatter_per_mm: 0.39 };
        for thickness_mm in [0.0, 0.01, 0.5, 1.5, 8.0] {
            let back = gel.thickness_mm(gel.reflectance(thickness_mm));
            assert!((back - thickness_mm).abs() < 1e-12 * (1.0 + thickness_mm));
        }
        assert_eq!(gel.reflectance(-0.2), 0.0);
        assert_eq!(gel.thickness_mm(1.0), f64::INFINITY);
    }

    #[test]
    fn two_streams_agree_with_a_stack_of_thin_layers() {
        // Thin layers on top of each other, each reflecting S dh and transmitting the rest, with all multiple
        // reflections between them: a layer with reflectance r and transmittance t in front of R gives r + t^2 R / (1 -
        // r R).
        let (gel, steps) = (TwoStream { scatter_per_mm: 0.7 }, 200_000);
        let thin = 0.7 * 2.0 / f64::from(steps);
        let stacked = (0..steps)
            .fold(0.0, |below, _| thin + (1.0 - thin).powi(2) * below / (1.0 - thin * below));
        assert!((stacked - gel.reflectance(2.0)).abs() < 1e-5, "{stacked}");
    }
}
