//! The bodies of a sensor, each in its place in each assembly, prepared for questions.

use std::collections::BTreeMap;

use fabkit_geometry::{Body, InvalidSolid, Placement, Sensor, Solid};
use rayon::prelude::*;

use crate::memo;

/// Why a sensor cannot be examined.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{body}: {source}")]
pub struct InvalidBody {
    /// Which body.
    pub body: String,
    /// What is wrong with its solid.
    pub source: InvalidSolid,
}

/// One body in its place.
#[derive(Clone, Debug)]
pub(crate) struct Placed<'a> {
    pub(crate) name: &'a str,
    /// In the assembly's frame.
    pub(crate) body: Body,
    /// The same for the same shape in the same place, see [`memo`].
    pub(crate) key: u128,
}

/// Every assembly with its bodies, in the order of the sensor's lists.
#[derive(Clone, Debug)]
pub(crate) struct Scene<'a> {
    pub(crate) assemblies: BTreeMap<&'a str, Vec<Placed<'a>>>,
}

impl<'a> Scene<'a> {
    pub(crate) fn new(sensor: &'a Sensor) -> Result<Self, InvalidBody> {
        let places: Vec<(&str, &Solid, &Placement)> = solids(sensor)
            .flat_map(|(name, solid, placements)| placements.iter().map(move |p| (name, solid, p)))
            .collect();
        let placed: Vec<(&str, Placed)> = places
            .into_par_iter()
            .map(|(name, solid, placement)| {
                let body = Body::new(&solid.clone().placed(placement.assembly_from_body))
                    .map_err(|source| InvalidBody { body: name.into(), source })?;
                let key = memo::of_body(solid, placement);
                Ok((placement.assembly.0.as_str(), Placed { name, body, key }))
            })
            .collect::<Result<_, _>>()?;
        let mut assemblies = BTreeMap::<_, Vec<_>>::new();
        for (assembly, placed) in placed {
            assemblies.entry(assembly).or_default().push(placed);
        }
        Ok(Self { assemblies })
    }

    /// The bodies of an assembly; none if there is no such assembly.
    pub(crate) fn bodies(&self, assembly: &str) -> &[Placed<'a>] {
        self.assemblies.get(assembly).map_or(&[], Vec::as_slice)
    }

    /// All places of one body in an assembly.
    pub(crate) fn places(&self, assembly: &str, name: &str) -> Vec<&Placed<'a>> {
        self.bodies(assembly).iter().filter(|placed| placed.name == name).collect()
    }
}

/// Parts, layers and components as one list.
pub(crate) fn solids(sensor: &Sensor) -> impl Iterator<Item = (&str, &Solid, &[Placement])> {
    let parts = sensor.parts.iter().map(|p| (p.name.as_str(), &p.solid, p.placements.as_slice()));
    let layers = sensor.layers.iter().map(|l| (l.name.as_str(), &l.solid, l.placements.as_slice()));
    let components =
        sensor.components.iter().map(|c| (c.name.as_str(), &c.solid, c.placements.as_slice()));
    parts.chain(layers).chain(components)
}
