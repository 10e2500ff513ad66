//! How much light arrives at each place of a layer, at rest.

use fabkit_geometry::{Point3, SurfacePoints, Vector3};
use fabkit_light::Emitters;

use super::table::{Place, Plan};

/// A table over the sensing surface: between its places in proportion.
#[derive(Debug)]
pub(crate) struct Lit {
    plan: Plan,
    /// 1 on average over the surface.
    values: Vec<f64>,
}

impl Lit {
    /// Light that arrives straight, and `bounce` of its average everywhere; the places are `below_mm` below the surface
    /// and look inwards. Nothing where no light arrives at all.
    pub(super) fn new(
        points: &SurfacePoints,
        emitters: &Emitters,
        below_mm: impl Fn(&Point3<f64>, &Vector3<f64>) -> f64,
        bounce: f64,
    ) -> Option<Self> {
        let plan = Plan::of(points);
        let places = plan.places(points);
        let known: Vec<Place> = places
            .iter()
            .filter_map(|(place, _)| *place)
            .map(|(point, outward)| (point - below_mm(&point, &outward) * outward, -outward))
            .collect();
        let mut arrives = emitters.irradiance(&known).into_iter();
        let grey = |[red, green, blue]: [f64; 3]| (red + green + blue) / 3.0;
        let mut next = || arrives.next().map_or(0.0, grey);
        // Beyond a pad's rounded corners nothing is looked at.
        let mut values: Vec<f64> =
            places.iter().map(|(place, _)| place.map_or(0.0, |_| next())).collect();
        let on = values.iter().zip(&places).filter(|(_, (place, _))| place.is_some());
        let sums =
            on.fold([0.0; 2], |[lit, all], (value, (_, share))| [lit + value * share, all + share]);
        let mean = sums[0] / sums[1];
        if mean.is_nan() || mean <= 0.0 {
            return None;
        }
        values.iter_mut().for_each(|value| *value = (*value / mean + bounce) / (1.0 + bounce));
        Some(Self { plan, values })
    }

    /// The most of it anywhere but near a dome's foot.
    pub(super) fn most(&self) -> f64 {
        let from_foot = self.plan.is_near_foot();
        let seen = self.values.iter().enumerate().filter(|(i, _)| !from_foot(*i));
        seen.map(|(_, value)| *value).fold(0.0, f64::max)
    }

    /// At a point of the surface at rest.
    pub(crate) fn at(&self, point: &Point3<f64>) -> f64 {
        self.plan.around(point).iter().map(|(place, share)| share * self.values[*place]).sum()
    }
}
