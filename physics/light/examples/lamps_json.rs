//! Prints the irradiance on a plane in scenes that a path tracer renders too: see `tests/oracles/check_mitsuba.py`.

use fabkit_geometry::{
    Angle, Assembly, Body, LightSourceGroup, Lighting, NominalCamera, NominalLens, OpticalClarity,
    Placement, Point3, Pose, Process, Rgb, Sensor, Solid, Vector3, VisibleEffect, WHITE,
};
use fabkit_light::Emitters;

/// Half the side of the plane, mm; number of cells along it; and its height, mm.
const HALF_MM: f64 = 10.0;
const SIDE: usize = 40;
const HEIGHT_MM: f64 = 10.0;
/// Sample points along each side of a cell.
const IN_CELL: usize = 4;

/// Name, poses of the light sources, their colours, and another body.
type Scene = (&'static str, Vec<Pose>, Vec<Rgb>, Option<Body>);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let lamp = Solid::cuboid(4.0, 3.0, 0.1).at_z(-0.1);
    let in_middle = vec![Pose::translation(0.0, 0.0, 0.0)];
    let around = [[8.0, 0.0], [-4.0, 7.0], [-4.0, -7.0]];
    let around = around.map(|[x, y]| Pose::translation(x, y, 0.0)).to_vec();
    let colors = vec![[1.0, 0.1, 0.0], [0.0, 1.0, 0.2], [0.1, 0.0, 1.0]];
    let black = |solid| {
        Body::made("black", "in the way", Process::Laser, solid)
            .with_clarity(OpticalClarity::Opaque)
    };
    let mut glass =
        Body::made("glass", "a slab", Process::Laser, Solid::cuboid(400.0, 400.0, 100.0).at_z(4.0))
            .with_clarity(OpticalClarity::Clear);
    glass.substance.refractive_index = Some(1.5);
    let scenes: [Scene; 4] = [
        ("open", in_middle.clone(), vec![WHITE], None),
        (
            "plate in the way",
            in_middle.clone(),
            vec![WHITE],
            Some(black(Solid::cuboid(3.0, 3.0, 0.5).at(1.0, 0.0, 4.0))),
        ),
        (
            "three colours round a ball",
            around,
            colors,
            Some(black(Solid::sphere(2.0).at(0.0, 0.0, 6.0))),
        ),
        ("into glass", in_middle, vec![WHITE], Some(glass)),
    ];
    let mut all = Vec::new();
    for (name, poses, colors, other) in scenes {
        let placed = poses.into_iter().map(|pose| Placement {
            assembly_from_body: pose,
            ..Placement::in_place(Assembly::sensor())
        });
        let lamp = Body::bought("lamp", "an LED", lamp.clone()).as_light_source().placed(placed);
        let other = other.map(|body| body.placed([Placement::in_place(Assembly::sensor())]));
        let camera = NominalCamera {
            // Beside everything that blocks light.
            sensor_from_camera: Pose::translation(0.0, 20.0, -30.0),
            width_px: 640,
            height_px: 480,
            field_of_view: Angle::from_deg(90.0).ok_or("no angle")?,
            lens: NominalLens::default(),
        };
        let sensor = Sensor::new("try", "", "", camera, std::iter::once(lamp).chain(other));
        let lighting = Lighting {
            name: "lamps",
            light_sources: vec![LightSourceGroup { body: "lamp".into(), colors }],
            effect: VisibleEffect::Thickness { layers: Vec::new() },
            camera: None,
            diffuser: None,
        };
        // Mean over each cell, because shadow edges cross cells.
        let fine = SIDE * IN_CELL;
        let step = 2.0 * HALF_MM / fine as f64;
        let place = |i: usize| {
            let [x, y] = [i % fine, i / fine].map(|k| (k as f64 + 0.5) * step - HALF_MM);
            (Point3::new(x, y, HEIGHT_MM), -Vector3::z())
        };
        let places: Vec<_> = (0..fine * fine).map(place).collect();
        let found = Emitters::new(&sensor, &lighting)?.irradiance(&places);
        let mut light = vec![[0.0; 3]; SIDE * SIDE];
        for (i, lit) in found.iter().enumerate() {
            let cell = &mut light[i / fine / IN_CELL * SIDE + i % fine / IN_CELL];
            *cell = [0, 1, 2].map(|part| cell[part] + lit[part] / (IN_CELL * IN_CELL) as f64);
        }
        let numbers: Vec<String> = light.iter().map(|[r, g, b]| format!("[{r},{g},{b}]")).collect();
        all.push(format!("\"{name}\": [{}]", numbers.join(",")));
    }
    println!("{{{}}}", all.join(",\n"));
    Ok(())
}
