//! Example: the smallest sensor that exercises the rules, a puck of gel, cast in a dish under a lid.

use fabkit_geometry::{
    Action, Angle, Assembly, Body, Cure, Mix, NominalCamera, Opening, Placement, Point3, Pose,
    Pour, Process, Pull, Sensor, Solid, Step, Vector3,
};

/// Radius of the puck, mm.
pub const RADIUS_MM: f64 = 10.0;

/// Height of the puck, mm.
pub const HEIGHT_MM: f64 = 2.0;

/// Thickness of the lid, mm; thick enough for two fingers to hold it.
pub const LID_MM: f64 = 5.0;

/// Radius of the lid's hole, through which the puck is poured, mm.
pub const GATE_RADIUS_MM: f64 = 1.0;

/// Name of its only assembly.
pub const MOLD: &str = "mold";

/// Creates a printed part in the mold's assembly.
fn part(name: &str, solid: Solid, genus: i32) -> Body {
    Body::made(name, String::new(), Process::Sla, solid)
        .with_material("resin")
        .placed([Placement::in_place(Assembly(MOLD.into()))])
        .colored([0; 3])
        .with_handles(genus)
}

/// A dish around the puck, 2 mm thick.
fn dish() -> Solid {
    // The well is cut beyond the dish's top, so that no two faces coincide.
    let overlap = fabkit_geometry::CUT_OVERLAP_MM;
    let well = Solid::cylinder(RADIUS_MM, HEIGHT_MM + overlap);
    Solid::cylinder(RADIUS_MM + 2.0, HEIGHT_MM + 2.0).at(0.0, 0.0, -2.0).minus(well)
}

/// A lid with a hole in the middle.
fn lid() -> Solid {
    let gate = Solid::cylinder(GATE_RADIUS_MM, LID_MM + 2.0).at(0.0, 0.0, HEIGHT_MM - 1.0);
    Solid::cylinder(RADIUS_MM + 2.0, LID_MM).at(0.0, 0.0, HEIGHT_MM).minus(gate)
}

/// Creates a step in the mold's assembly.
fn step(name: &str, action: Action) -> Step {
    Step {
        name: name.into(),
        instruction: String::new(),
        assembly: Some(Assembly(MOLD.into())),
        bodies: Vec::new(),
        motions: Vec::new(),
        fixings: Vec::new(),
        adjustments: Vec::new(),
        during_cure_of: None,
        action,
        source: String::new(),
    }
}

/// Builds the sensor: dish, lid and puck, with the puck's lower face at z = 0. It is poured through the lid; then lid
/// and dish are taken off.
///
/// ```
/// use fabkit_checks::example;
/// use fabkit_geometry::CompiledSolid;
/// let sensor = example::puck();
/// let names: Vec<&str> = sensor.bodies.iter().map(|body| &*body.name).collect();
/// assert_eq!(names, ["dish", "lid", "puck"]);
/// let puck = CompiledSolid::new(&sensor.bodies[2].solid)?.bounds();
/// assert_eq!(puck.size_mm(), [20.0, 20.0, 2.0]);
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
pub fn puck() -> Sensor {
    let pour = Pour {
        layer: "puck".into(),
        walls: vec!["dish".into(), "lid".into()],
        up: Vector3::z(),
        openings: vec![Opening {
            name: "gate".into(),
            point: Point3::new(0.0, 0.0, HEIGHT_MM),
            axis: Vector3::z(),
            radius_mm: GATE_RADIUS_MM,
        }],
        mix: Mix {
            by_mass: vec![("A".into(), 1.0), ("B".into(), 1.0)],
            density_g_per_cm3: 1.0,
            pot_life_h: None,
            degas: true,
        },
        waste: 0.1,
        cure: Cure { hours: 4.0, celsius: 23.0 },
    };
    let pull = |body: &str, direction| Pull { body: body.into(), direction, strain_limit: None };
    Sensor {
        chain: vec![
            step("pour", Action::Pour(pour)),
            step(
                "open",
                Action::Demold(vec![pull("lid", Vector3::z()), pull("dish", -Vector3::z())]),
            ),
        ],
        ..Sensor::new(
            "puck",
            "a puck",
            "",
            NominalCamera {
                sensor_from_camera: Pose::identity(),
                width_px: 640,
                height_px: 480,
                field_of_view: Angle::from_deg(90.0).expect("finite"),
                lens: Default::default(),
            },
            [part("dish", dish(), 0), part("lid", lid(), 1)].into_iter().chain([Body::cast(
                "puck",
                String::new(),
                Solid::cylinder(RADIUS_MM, HEIGHT_MM),
            )
            .with_material("gel")
            .placed([Placement::in_place(Assembly(MOLD.into()))])
            .colored([0; 3])]),
        )
    }
}
