//! Irradiance at each place of the layers, at rest.

use fabkit_geometry::{Point3, Rgb, SurfacePoints, Vector3};
use fabkit_light::{Emitters, diffuse_path_ratio};

use super::surface_table::{SurfaceGrid, SurfacePlace};

/// Table of irradiance over the sensing surface, interpolated linearly.
#[derive(Debug)]
pub struct IrradianceTable {
    plan: SurfaceGrid,
    /// Irradiance relative to its mean over the surface.
    values: Vec<f64>,
    /// Ratio of the light's path through the layers to their thickness; empty where it is not needed.
    slants: Vec<f64>,
}

impl IrradianceTable {
    /// Computes direct light plus `bounce` of its mean everywhere. The places lie `below_mm` below the surface and face
    /// inwards. With a refractive index in `slanted_in`, the slant of the light in layers of that index is tabulated
    /// too. `None` if no light arrives.
    pub(super) fn new(
        points: &SurfacePoints,
        emitters: &Emitters,
        below_mm: impl Fn(&Point3<f64>, &Vector3<f64>) -> f64,
        bounce: f64,
        slanted_in: Option<f64>,
    ) -> Option<Self> {
        let plan = SurfaceGrid::new(points);
        let places = plan.places(points);
        let known: Vec<SurfacePlace> = places
            .iter()
            .filter_map(|(place, _)| *place)
            .map(|(point, outward)| (point - below_mm(&point, &outward) * outward, -outward))
            .collect();
        let over_table = |arrives: Vec<Rgb>| -> Vec<f64> {
            let mut arrives = arrives.into_iter();
            let grey = |[red, green, blue]: Rgb| (red + green + blue) / 3.0;
            let mut next = || arrives.next().map_or(0.0, grey);
            // Places beyond a pad's rounded corners are not on the surface.
            places.iter().map(|(place, _)| place.map_or(0.0, |_| next())).collect()
        };
        let mut values = over_table(emitters.irradiance(&known));
        let on = values.iter().zip(&places).filter(|(_, (place, _))| place.is_some());
        let sums =
            on.fold([0.0; 2], |[lit, all], (value, (_, share))| [lit + value * share, all + share]);
        let mean = sums[0] / sums[1];
        if mean.is_nan() || mean <= 0.0 {
            return None;
        }
        let slants = slanted_in.map(|index| {
            // Repeatedly reflected light arrives diffusely and has the slant of diffuse light.
            let around = bounce * mean;
            let slanted = over_table(emitters.irradiance_times_path(&known, index));
            let both = slanted.into_iter().zip(&values);
            both.map(|(slanted, lit)| {
                (slanted + around * diffuse_path_ratio(index)) / (lit + around)
            })
            .map(|slant| if slant.is_finite() { slant } else { 1.0 })
            .collect()
        });
        values.iter_mut().for_each(|value| *value = (*value / mean + bounce) / (1.0 + bounce));
        Some(Self { plan, values, slants: slants.unwrap_or_default() })
    }

    /// Returns the largest irradiance, except near a dome's foot.
    pub(super) fn maximum(&self) -> f64 {
        let from_foot = self.plan.is_near_foot();
        let seen = self.values.iter().enumerate().filter(|(i, _)| !from_foot(*i));
        seen.map(|(_, value)| *value).fold(0.0, f64::max)
    }

    /// Returns the relative irradiance at a point of the undeformed surface.
    pub fn irradiance(&self, point: &Point3<f64>) -> f64 {
        self.plan.weights_at(point).iter().map(|(place, share)| share * self.values[*place]).sum()
    }

    /// Returns the mean ratio of the light's path through the layers to their thickness at a point; 1 without a table.
    pub(super) fn slant(&self, point: &Point3<f64>) -> f64 {
        let slant = |(place, share): &(usize, f64)| share * self.slants.get(*place).unwrap_or(&1.0);
        self.plan.weights_at(point).iter().map(slant).sum()
    }
}
