//! Prints the light from coats, layers and fluorescent gels in scenes that a path tracer renders too: see
//! `tests/oracles/check_mitsuba_models.py`.

use fabkit_geometry::{
    Angle, Assembly, Body, LightSourceGroup, Lighting, NominalCamera, NominalLens, Placement,
    Point3, Pose, Rgb, Sensor, Solid, Vector3, VisibleEffect,
};
use fabkit_light::{Coat, Emitters, RaisedMarker, TwoStream, fluorescence};

/// Half the side of the plane, mm; number of cells along it; and its height above the light sources, mm.
const HALF_MM: f64 = 6.0;
const SIDE: usize = 40;
const HEIGHT_MM: f64 = 10.0;
/// Sample points along each side of a cell.
const IN_CELL: usize = 4;
const TILT_DEG: f64 = 20.0;
const BALL_MM: f64 = 15.0;
/// Distance from a point at which its shadow ray starts, mm.
const OFF_MM: f64 = 1e-3;
/// Default constants of coats, without and with a glossy part.
const MATT: Coat = Coat { diffuse: 0.45, gloss: 0.0, exponent: 12.0 };
const SATIN: Coat = Coat { diffuse: 0.45, gloss: 0.15, exponent: 12.0 };

/// Point of a coat that is seen from below, with its normal.
type Surface = fn(f64, f64) -> (Point3<f64>, Vector3<f64>);

/// Plane tilted by [`TILT_DEG`].
fn tilted(x: f64, y: f64) -> (Point3<f64>, Vector3<f64>) {
    let (sine, cosine) = TILT_DEG.to_radians().sin_cos();
    (Point3::new(x, y, HEIGHT_MM + x * sine / cosine), Vector3::new(sine, 0.0, -cosine))
}

/// Lower side of a ball of radius [`BALL_MM`].
fn ball(x: f64, y: f64) -> (Point3<f64>, Vector3<f64>) {
    let below = (BALL_MM * BALL_MM - x * x - y * y).sqrt();
    let place = Point3::new(x, y, HEIGHT_MM + BALL_MM - below);
    (place, Vector3::new(x, y, -below) / BALL_MM)
}

/// Marker that stands out of the plane.
fn bump() -> RaisedMarker {
    let centre = Point3::new(1.0, 0.5, HEIGHT_MM);
    RaisedMarker { centre, axis: -Vector3::z(), radius_mm: 1.5 }
}

/// Plane with one marker.
fn plane_with_bump(x: f64, y: f64) -> (Point3<f64>, Vector3<f64>) {
    let origin = Point3::new(x, y, 0.0);
    match bump().entry(&origin, &Vector3::z()) {
        Some(hit) => (origin + hit.at_mm * Vector3::z(), hit.normal),
        None => (Point3::new(x, y, HEIGHT_MM), -Vector3::z()),
    }
}

/// Builds three light sources in three colours, divided into pieces as for coats.
fn lamps() -> Result<Emitters, Box<dyn std::error::Error>> {
    let around = [[8.0, 0.0], [-4.0, 7.0], [-4.0, -7.0]];
    let placed = around.map(|[x, y]| Placement {
        assembly_from_body: Pose::translation(x, y, 0.0),
        ..Placement::in_place(Assembly::sensor())
    });
    let lamp = Solid::cuboid(2.0, 1.5, 0.1).at_z(-0.1);
    let lamp = Body::bought("lamp", "an LED", lamp).as_light_source().placed(placed);
    let camera = NominalCamera {
        sensor_from_camera: Pose::translation(0.0, 20.0, -30.0),
        width_px: 640,
        height_px: 480,
        field_of_view: Angle::from_deg(90.0).ok_or("no angle")?,
        lens: NominalLens::default(),
    };
    let sensor = Sensor::new("try", "", "", camera, [lamp]);
    let colors = vec![[1.0, 0.1, 0.0], [0.0, 1.0, 0.2], [0.1, 0.0, 1.0]];
    let lighting = Lighting {
        name: "lamps",
        light_sources: vec![LightSourceGroup { body: "lamp".into(), colors }],
        effect: VisibleEffect::Slopes { coat: "coat".into(), printed: None },
        camera: None,
        diffuser: None,
    };
    Ok(Emitters::new(&sensor, &lighting)?)
}

/// Computes the light that each cell sends straight down, times pi.
fn compute_reflected_light(
    coat: Coat,
    surface: Surface,
    is_bump: bool,
    emitters: &Emitters,
) -> Vec<Rgb> {
    let fine = SIDE * IN_CELL;
    let step = 2.0 * HALF_MM / fine as f64;
    let (mut light, mut tracer) = (vec![[0.0; 3]; SIDE * SIDE], emitters.tracer());
    for i in 0..fine * fine {
        let [x, y] = [i % fine, i / fine].map(|k| (k as f64 + 0.5) * step - HALF_MM);
        let (place, normal) = surface(x, y);
        let from = place + OFF_MM * normal;
        for piece in emitters.pieces() {
            let Some(found) = emitters.arrival(piece, &from, &mut tracer) else { continue };
            if is_bump && bump().entry(&from, &-found.arrival_direction).is_some() {
                continue;
            }
            let sent =
                found.density * coat.reflect(&normal, &found.arrival_direction, &-Vector3::z());
            let cell = &mut light[i / fine / IN_CELL * SIDE + i % fine / IN_CELL];
            let mean = sent / (IN_CELL * IN_CELL) as f64;
            *cell = [0, 1, 2].map(|part| cell[part] + mean * piece.color[part]);
        }
    }
    light
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let emitters = lamps()?;
    let surfaces: [(&str, Surface, bool); 3] = [
        ("tilted plane", tilted, false),
        ("ball", ball, false),
        ("bump on a plane", plane_with_bump, true),
    ];
    let mut coats = Vec::new();
    for (name, surface, is_bump) in surfaces {
        for (finish, coat) in [("matt", MATT), ("satin", SATIN)] {
            let light = compute_reflected_light(coat, surface, is_bump, &emitters);
            let numbers: Vec<String> =
                light.iter().map(|[r, g, b]| format!("[{r},{g},{b}]")).collect();
            coats.push(format!("\"{name}, {finish}\": [{}]", numbers.join(",")));
        }
    }
    let Coat { diffuse, gloss: shine, exponent } = SATIN;
    println!("{{\"coat\": [{diffuse}, {shine}, {exponent}],");
    println!("\"coats\": {{{}}},", coats.join(",\n"));
    // Depths in mean free paths across the layer. The two-stream coefficient is 3/4 of an isotropic scattering
    // coefficient.
    let layers = [0.5, 1.0, 5.0].map(|depth| {
        format!("\"{depth}\": {}", TwoStream { scatter_per_mm: 0.75 }.reflectance(depth))
    });
    println!("\"layers\": {{{}}},", layers.join(","));
    // One gel; one lit from the side; two of them.
    let (one, _) = fluorescence(0.5, 2.0, [1.0; 2]);
    let (aside, _) = fluorescence(0.5, 2.0, [f64::sqrt(2.0), 1.0]);
    let (first, left) = fluorescence(0.3, 0.8, [1.0; 2]);
    let two = first + left * fluorescence(0.7, 1.2, [1.0; 2]).0;
    println!("\"glow\": {{\"one\": {one}, \"aside\": {aside}, \"two\": {two}}}}}");
    Ok(())
}
