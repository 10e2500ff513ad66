//! Words that every family builds with: where bodies stand, and the steps of a chain.

use fabkit_geometry::{
    Action, Angle, Assembly, Color, Cure, Mix, Placement, Pose, Pull, Step, Vector3,
};

use crate::materials::{Castable, castable};

/// Black plastic as pictures show it: light enough that its edges can be told apart.
pub const BLACK: Color = [92, 96, 104];

/// Name of an assembly, as a family's constants hold it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AssemblyName(pub &'static str);

/// The sensor in use.
pub const SENSOR: AssemblyName = AssemblyName("sensor");

impl AssemblyName {
    /// The assembly.
    pub fn assembly(self) -> Assembly {
        Assembly(self.0.into())
    }

    /// In the assembly's own frame.
    pub fn in_place(self) -> Placement {
        self.at(Pose::identity())
    }

    /// At a pose.
    pub fn at(self, assembly_from_body: Pose) -> Placement {
        Placement::at(self.assembly(), assembly_from_body)
    }
}

/// In the sensor, in the sensor frame.
pub fn in_sensor() -> Placement {
    SENSOR.in_place()
}

/// Upside down.
pub fn flipped() -> Pose {
    Pose::rotation_x(Angle::from_deg(180.0).expect("half a turn is finite"))
}

/// One step of a chain.
pub fn step(
    name: impl Into<String>,
    instruction: impl Into<String>,
    assembly: Option<AssemblyName>,
    bodies: &[&str],
    action: Action,
    source: &str,
) -> Step {
    Step {
        name: name.into(),
        instruction: instruction.into(),
        assembly: assembly.map(AssemblyName::assembly),
        bodies: names(bodies),
        action,
        source: source.into(),
    }
}

/// Names of bodies.
pub fn names(of: &[&str]) -> Vec<String> {
    of.iter().map(|name| name.to_string()).collect()
}

/// What a layer is mixed from; nothing for an unknown material, which constraints refuse.
pub fn mix(material: &str) -> Mix {
    castable(material).map_or_else(
        || Mix { by_mass: Vec::new(), density_g_per_cm3: 0.0, degas: false },
        Castable::mix,
    )
}

/// How a layer cures; not at all for an unknown material, which constraints refuse.
pub fn cure(material: &str) -> Cure {
    castable(material).map_or(Cure { hours: 0.0, celsius: 23.0 }, |material| material.cure)
}

/// A rigid tool that comes off in a direction.
pub fn rigid(body: &str, direction: Vector3<f64>) -> Pull {
    Pull { body: body.into(), direction, strain_limit: None }
}
