//! Words that every family builds with: where bodies stand, and the steps of a chain.

use fabkit_geometry::{
    Action, Angle, Assembly, Cure, Mix, Opening, Placement, Point3, Pose, Pull, Step, Vector3,
};

use crate::materials::{Castable, castable};

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

    /// At a height.
    pub fn at_z(self, z_mm: f64) -> Placement {
        self.at(Pose::translation(0.0, 0.0, z_mm))
    }

    /// At a pose, moved along its z axis in the exploded picture.
    pub fn drawn_out(self, assembly_from_body: &Pose, out_mm: f64) -> Placement {
        let out = assembly_from_body.vector(Vector3::new(0.0, 0.0, out_mm));
        self.at(*assembly_from_body).moved_apart(out)
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

/// The open top of what is poured, within `radius_mm` around the z axis, at a height; `up` is out of it.
pub fn free_surface(radius_mm: f64, z_mm: f64, up: Vector3<f64>) -> Opening {
    let point = Point3::new(0.0, 0.0, z_mm);
    Opening { name: "free surface".into(), point, axis: up, radius_mm }
}

/// An opening of a layer at a pose, out of the layer along its z axis.
pub fn opening(name: impl Into<String>, out: &Pose, radius_mm: f64) -> Opening {
    let (point, axis) = (out.point(Point3::origin()), out.vector(Vector3::z()));
    Opening { name: name.into(), point, axis, radius_mm }
}

/// A layer's openings `vent 1`, `vent 2`, ...: at the poses, out of the layer against their z axes.
pub fn vents(poses: &[Pose], radius_mm: f64) -> Vec<Opening> {
    let vent = |(pose, i): (&Pose, i32)| Opening {
        axis: -Vector3::z(),
        ..opening(format!("vent {i}"), pose, radius_mm)
    };
    poses.iter().zip(1..).map(vent).collect()
}
