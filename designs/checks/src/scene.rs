//! The bodies of a sensor, each in its place in each assembly, prepared for questions.

use std::collections::BTreeMap;

use fabkit_geometry::{Body, CompiledSolid, InvalidSolid, Placement, Pose, Reach, Sensor, Solid};
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
    pub(crate) body: CompiledSolid,
    /// The same for the same shape in the same place, see [`memo`].
    pub(crate) key: u128,
    /// Its shape in its own frame, and all else that is known of it.
    pub(crate) of: &'a Body,
    /// Maps its own frame to the assembly's.
    pub(crate) pose: Pose,
    /// Of each of its tools every room that it may take, in the assembly's frame.
    pub(crate) tools: Vec<Vec<Tool>>,
}

/// A room of a tool.
#[derive(Clone, Debug)]
pub(crate) struct Tool {
    pub(crate) room: CompiledSolid,
    /// As of a body.
    pub(crate) key: u128,
}

impl<'a> Placed<'a> {
    fn new(of: &'a Body, placement: &Placement) -> Result<Self, InvalidBody> {
        let pose = placement.assembly_from_body;
        let compiled = |solid: &Solid| {
            CompiledSolid::new(&solid.clone().placed(pose))
                .map_err(|source| InvalidBody { body: of.name.clone(), source })
        };
        let key = memo::of_body(&of.solid, placement);
        let tool = |solid: &Solid| {
            let key = memo::of_body(solid, placement);
            compiled(solid).map(|room| Tool { room, key })
        };
        let rooms = |reach: &Reach| reach.rooms().map(tool).collect::<Result<Vec<_>, _>>();
        let tools = of.reach.iter().map(rooms).collect::<Result<_, _>>()?;
        Ok(Self { name: &of.name, body: compiled(&of.solid)?, key, of, pose, tools })
    }
}

impl Placed<'_> {
    /// Whether a tool drives it in: a screw, a nut.
    pub(crate) fn is_drawn(&self) -> bool {
        self.of.reach.iter().any(|reach| reach.is_drawn)
    }
}

/// Every assembly with its bodies, in the order of the sensor's lists.
#[derive(Clone, Debug)]
pub(crate) struct Assemblies<'a> {
    pub(crate) assemblies: BTreeMap<&'a str, Vec<Placed<'a>>>,
}

impl<'a> Assemblies<'a> {
    pub(crate) fn new(sensor: &'a Sensor) -> Result<Self, InvalidBody> {
        let places = |body: &'a Body| body.placements.iter().map(move |place| (body, place));
        let places: Vec<(&Body, &Placement)> = sensor.bodies.iter().flat_map(places).collect();
        let placed: Vec<(&str, Placed)> = places
            .into_par_iter()
            .map(|(of, placement)| Ok((placement.assembly.0.as_str(), Placed::new(of, placement)?)))
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
