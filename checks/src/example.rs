//! The smallest sensor that has something to check: a puck of gel, cast in a dish under a lid.

use fabkit_geometry::{
    Action, Angle, Assembly, Cure, Layer, Mix, NominalCamera, Opening, Part, Placement, Point3,
    Pose, Pour, Process, Pull, Sensor, Shells, Solid, Step, Vector3,
};

/// Radius of the puck, mm.
pub const RADIUS_MM: f64 = 10.0;

/// Height of the puck, mm.
pub const HEIGHT_MM: f64 = 2.0;

/// Radius of the lid's hole, through which the puck is poured, mm.
pub const GATE_RADIUS_MM: f64 = 1.0;

/// Name of its only assembly.
pub const MOLD: &str = "mold";

fn part(name: &str, solid: Solid, genus: i32) -> Part {
    Part {
        name: name.into(),
        summary: String::new(),
        solid,
        placements: vec![Placement::in_place(Assembly(MOLD.into()))],
        process: Process::Sla,
        material: "resin".into(),
        quantity: 1,
        landmarks: Vec::new(),
        color: [0; 3],
        bed_from_part: Pose::identity(),
        print_notes: Vec::new(),
        shrinkage: 0.0,
        genus,
        shells: Shells::ONE,
    }
}

/// A dish around the puck, 2 mm thick.
fn dish() -> Solid {
    let overlap = fabkit_geometry::CUT_OVERLAP_MM;
    let well = Solid::cylinder(RADIUS_MM, HEIGHT_MM + overlap);
    Solid::cylinder(RADIUS_MM + 2.0, HEIGHT_MM + 2.0).at(0.0, 0.0, -2.0).minus(well)
}

/// A lid with a hole in the middle.
fn lid() -> Solid {
    let gate = Solid::cylinder(GATE_RADIUS_MM, 4.0).at(0.0, 0.0, HEIGHT_MM - 1.0);
    Solid::cylinder(RADIUS_MM + 2.0, 2.0).at(0.0, 0.0, HEIGHT_MM).minus(gate)
}

fn step(name: &str, action: Action) -> Step {
    Step {
        name: name.into(),
        instruction: String::new(),
        assembly: Some(Assembly(MOLD.into())),
        bodies: Vec::new(),
        action,
        source: String::new(),
    }
}

/// Dish, lid and puck on z = 0; poured through the lid, then lid and dish taken off.
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
            degas: true,
        },
        waste: 0.1,
        cure: Cure { hours: 4.0, celsius: 23.0 },
    };
    let pull = |body: &str, direction| Pull { body: body.into(), direction, strain_limit: None };
    Sensor {
        name: "puck".into(),
        title: "a puck".into(),
        reference: String::new(),
        parts: vec![part("dish", dish(), 0), part("lid", lid(), 1)],
        layers: vec![Layer {
            name: "puck".into(),
            summary: String::new(),
            solid: Solid::cylinder(RADIUS_MM, HEIGHT_MM),
            placements: vec![Placement::in_place(Assembly(MOLD.into()))],
            material: "gel".into(),
            color: [0; 3],
            opacity: 1.0,
            genus: 0,
            shells: Shells::ONE,
        }],
        components: Vec::new(),
        chain: vec![
            step("pour", Action::Pour(pour)),
            step(
                "open",
                Action::Demold(vec![pull("lid", Vector3::z()), pull("dish", -Vector3::z())]),
            ),
        ],
        print_groups: Vec::new(),
        press_fits: Vec::new(),
        camera: NominalCamera {
            sensor_from_camera: Pose::identity(),
            width_px: 640,
            height_px: 480,
            field_of_view: Angle::from_deg(90.0).expect("finite"),
        },
        touch: None,
    }
}
