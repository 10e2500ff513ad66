//! How much light arrives at each place of a layer, at rest.

use fabkit_geometry::{Point3, Rgb, SurfacePoints, Vector3};
use fabkit_light::{Emitters, diffuse_slant};

use super::table::{Place, Plan};

/// A table over the sensing surface: between its places in proportion.
#[derive(Debug)]
pub struct Lit {
    plan: Plan,
    /// 1 on average over the surface.
    values: Vec<f64>,
    /// How much longer the light's way through the layers is than they are thick; nothing where nobody asks.
    slants: Vec<f64>,
}

impl Lit {
    /// Light that arrives straight, and `bounce` of its average everywhere; the places are `below_mm` below the surface
    /// and look inwards. How slanted it is, in layers with this refractive index, is known where there is one. Nothing where no
    /// light arrives at all.
    pub(super) fn new(
        points: &SurfacePoints,
        emitters: &Emitters,
        below_mm: impl Fn(&Point3<f64>, &Vector3<f64>) -> f64,
        bounce: f64,
        slanted_in: Option<f64>,
    ) -> Option<Self> {
        let plan = Plan::of(points);
        let places = plan.places(points);
        let known: Vec<Place> = places
            .iter()
            .filter_map(|(place, _)| *place)
            .map(|(point, outward)| (point - below_mm(&point, &outward) * outward, -outward))
            .collect();
        let over_table = |arrives: Vec<Rgb>| -> Vec<f64> {
            let mut arrives = arrives.into_iter();
            let grey = |[red, green, blue]: Rgb| (red + green + blue) / 3.0;
            let mut next = || arrives.next().map_or(0.0, grey);
            // Beyond a pad's rounded corners nothing is looked at.
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
            let around = bounce * mean;
            let slanted = over_table(emitters.slanted(&known, index));
            let both = slanted.into_iter().zip(&values);
            both.map(|(slanted, lit)| (slanted + around * diffuse_slant(index)) / (lit + around))
                .map(|slant| if slant.is_finite() { slant } else { 1.0 })
                .collect()
        });
        values.iter_mut().for_each(|value| *value = (*value / mean + bounce) / (1.0 + bounce));
        Some(Self { plan, values, slants: slants.unwrap_or_default() })
    }

    /// The most of it anywhere but near a dome's foot.
    pub(super) fn most(&self) -> f64 {
        let from_foot = self.plan.is_near_foot();
        let seen = self.values.iter().enumerate().filter(|(i, _)| !from_foot(*i));
        seen.map(|(_, value)| *value).fold(0.0, f64::max)
    }

    /// At a point of the surface at rest.
    pub fn at(&self, point: &Point3<f64>) -> f64 {
        self.plan.around(point).iter().map(|(place, share)| share * self.values[*place]).sum()
    }

    /// How much longer than they are thick the light's way through the layers is there, on average of what arrives; 1 where
    /// nobody has asked for it.
    pub(super) fn slant(&self, point: &Point3<f64>) -> f64 {
        let slant = |(place, share): &(usize, f64)| share * self.slants.get(*place).unwrap_or(&1.0);
        self.plan.around(point).iter().map(slant).sum()
    }
}
