//! Scene: the compiled bodies of a sensor at their poses in each assembly.

use std::collections::BTreeMap;

use fabkit_geometry::{
    Body, CompiledSolid, InvalidSolid, Placement, Pose, Sensor, Solid, ToolAccess,
};
use rayon::prelude::*;

use crate::memo;

/// Error for a body whose solid is not valid.
///
/// ```
/// use fabkit_checks::{check, example};
/// use fabkit_geometry::Solid;
/// let mut sensor = example::puck();
/// sensor.bodies[1].solid = Solid::cylinder(-1.0, 5.0);
/// assert_eq!(check(&sensor).unwrap_err().body, "lid");
/// ```
#[derive(Clone, Debug, thiserror::Error)]
#[error("{body}: {source}")]
pub struct InvalidBody {
    /// Name of the body.
    pub body: String,
    /// Error of its solid.
    pub source: InvalidSolid,
}

/// A body at one placement.
#[derive(Clone, Debug)]
pub(crate) struct Placed<'a> {
    pub(crate) name: &'a str,
    /// Solid in the assembly's frame.
    pub(crate) body: CompiledSolid,
    /// Cache key of solid and pose, equal for equal ones; see [`memo`].
    pub(crate) key: u128,
    /// The body itself, with its solid in its own frame.
    pub(crate) of: &'a Body,
    /// Transform from its own frame to the assembly's.
    pub(crate) pose: Pose,
    /// Rooms that each of its tools may take, in the assembly's frame.
    pub(crate) tools: Vec<Vec<Tool>>,
}

/// Room that a tool takes.
#[derive(Clone, Debug)]
pub(crate) struct Tool {
    pub(crate) room: CompiledSolid,
    /// Cache key of solid and pose.
    pub(crate) key: u128,
}

impl<'a> Placed<'a> {
    fn new(of: &'a Body, placement: &Placement) -> Result<Self, InvalidBody> {
        let pose = placement.assembly_from_body;
        let compiled = |solid: &Solid| {
            CompiledSolid::new(&solid.clone().placed(pose))
                .map_err(|source| InvalidBody { body: of.name.clone(), source })
        };
        let key = memo::body_key(&of.solid, placement);
        let tool = |solid: &Solid| {
            let key = memo::body_key(solid, placement);
            compiled(solid).map(|room| Tool { room, key })
        };
        let rooms = |reach: &ToolAccess| reach.spaces().map(tool).collect::<Result<Vec<_>, _>>();
        let tools = of.reach.iter().map(rooms).collect::<Result<_, _>>()?;
        Ok(Self { name: &of.name, body: compiled(&of.solid)?, key, of, pose, tools })
    }
}

impl Placed<'_> {
    /// Returns whether a tool drives it in, as a screw or a nut.
    pub(crate) fn is_drawn(&self) -> bool {
        self.of.reach.iter().any(|reach| reach.is_driven_in)
    }
}

/// All assemblies with their bodies, in the order of the sensor's lists.
#[derive(Clone, Debug)]
pub(crate) struct Assemblies<'a> {
    pub(crate) assemblies: BTreeMap<&'a str, Vec<Placed<'a>>>,
}

impl<'a> Assemblies<'a> {
    pub(crate) fn new(sensor: &'a Sensor) -> Result<Self, InvalidBody> {
        // Collected first, so that all solids are compiled in parallel.
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

    /// Returns the bodies of an assembly; empty if there is no such assembly.
    pub(crate) fn bodies(&self, assembly: &str) -> &[Placed<'a>] {
        self.assemblies.get(assembly).map_or(&[], Vec::as_slice)
    }

    /// Returns all placements of one body in an assembly.
    pub(crate) fn places(&self, assembly: &str, name: &str) -> Vec<&Placed<'a>> {
        self.bodies(assembly).iter().filter(|placed| placed.name == name).collect()
    }
}
