//! Draws a few parts and writes them as PNG files into a folder:
//! `cargo run --release -p fabkit-depth --example gallery -- out/gallery`

use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;
use std::time::Instant;

use fabkit_depth::{Actor, RenderedImage, View, contact_sheet, render};
use fabkit_geometry::{Angle, CompiledSolid, Point3, Pose, Solid, Vector3};

const BLACK: [u8; 3] = [34, 34, 36];
const BLUE: [u8; 3] = [86, 140, 196];
const ORANGE: [u8; 3] = [226, 140, 72];
const GREY: [u8; 3] = [176, 180, 188];
const GREEN: [u8; 3] = [120, 176, 120];
const GLASS: [u8; 3] = [170, 214, 232];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "out/gallery".into());
    std::fs::create_dir_all(&folder)?;
    let (width, height) = (800, 600);
    let isometric = View::isometric(width, height);
    let section = View::section(width, height, Point3::origin(), -Vector3::y());
    let perspective = isometric.clone().perspective(Angle::from_deg(25.0).ok_or("not finite")?);
    let drawings: [(&str, Vec<Actor>, &View); 6] = [
        ("shell", vec![Actor::new(CompiledSolid::new(&shell())?, BLACK)], &isometric),
        ("dome", vec![Actor::new(CompiledSolid::new(&dome())?, ORANGE)], &isometric),
        ("mold", vec![Actor::new(CompiledSolid::new(&mold())?, GREY)], &section),
        ("stack", stack(0.35)?, &isometric),
        ("stack-section", stack(0.35)?, &section),
        ("exploded", exploded()?, &perspective),
    ];
    let mut images = Vec::new();
    for (name, actors, view) in &drawings {
        let start = Instant::now();
        let image = render(actors, view)?;
        println!("{name}: {:.2} s", start.elapsed().as_secs_f64());
        write_png(&Path::new(&folder).join(format!("{name}.png")), &image)?;
        images.push(image);
    }
    write_png(&Path::new(&folder).join("sheet.png"), &contact_sheet(&images, 3, 12)?)
}

/// Builds a cylindrical shell with two windows, side holes and a flange.
fn shell() -> Solid {
    let windows = [0.0, 0.5]
        .map(|turn| Solid::cuboid(30.0, 10.0, 9.0).at(15.0, 0.0, 7.0).turned_z(turned(turn)));
    let holes = (0..8).map(|i| {
        Solid::cylinder(1.0, 20.0)
            .turned_y(turned(0.25))
            .at(0.0, 0.0, 19.0)
            .turned_z(turned(f64::from(i) / 8.0))
    });
    let bolts = (0..4).map(|i| {
        Solid::cylinder(1.1, 5.0).at(17.5, 0.0, -1.0).turned_z(turned(f64::from(i) / 4.0 + 0.125))
    });
    Solid::cylinder(15.0, 22.0)
        .plus(Solid::cylinder(20.0, 2.5))
        .minus(Solid::cylinder(13.0, 30.0).at(0.0, 0.0, -1.0))
        .minus_all(windows)
        .minus_all(holes)
        .minus_all(bolts)
}

/// Builds a hemispherical dome on a wall, with 30 radial holes on a Fibonacci lattice.
fn dome() -> Solid {
    let holes = (0..30).map(|i| {
        let z = 0.12 + 0.86 * (f64::from(i) + 0.5) / 30.0;
        let turn = f64::from(i) * 2.399_963;
        let r = (1.0 - z * z).sqrt();
        let axis = Vector3::new(r * turn.cos(), r * turn.sin(), z);
        Solid::cylinder(0.8, 8.0).placed(Pose::z_to(axis, Point3::from(axis * 12.0)))
    });
    let outer = Solid::sphere(18.0).plus(Solid::cylinder(18.0, 6.0).at(0.0, 0.0, -6.0));
    outer
        .minus(Solid::sphere(15.0))
        .minus(Solid::cylinder(15.0, 20.0).at(0.0, 0.0, -20.0))
        .minus(Solid::cuboid(60.0, 60.0, 60.0).at(0.0, 0.0, -66.0))
        .minus_all(holes)
}

/// Builds a block with a hemispherical cavity on a straight wall, four sockets and a pouring gate.
fn mold() -> Solid {
    let sockets = [[-20.0, -20.0], [20.0, -20.0], [-20.0, 20.0], [20.0, 20.0]]
        .map(|[x, y]| Solid::cylinder(2.0, 5.0).at(x, y, 21.0));
    Solid::cuboid(49.0, 49.0, 25.0)
        .minus(Solid::sphere(13.5).at(0.0, 0.0, 19.0))
        .minus(Solid::cylinder(13.5, 7.0).at(0.0, 0.0, 19.0))
        .minus(Solid::cylinder(1.0, 20.0).at(0.0, 0.0, -5.0))
        .minus_all(sockets)
}

/// Builds three gel layers over one another, the outer two translucent.
fn stack(opacity: f64) -> Result<Vec<Actor>, Box<dyn Error>> {
    let bullet = |radius: f64| {
        Solid::sphere(radius)
            .at(0.0, 0.0, 6.0)
            .plus(Solid::cylinder(radius, 6.0))
            .and(Solid::cuboid(60.0, 60.0, 60.0))
    };
    let below = |radius: f64| bullet(radius).plus(Solid::cylinder(radius, 1.0).at(0.0, 0.0, -0.5));
    let layers = [
        Actor::new(CompiledSolid::new(&bullet(8.0))?, ORANGE),
        Actor::new(CompiledSolid::new(&bullet(13.5).minus(below(8.0)))?, GREEN)
            .with_opacity(opacity),
        Actor::new(CompiledSolid::new(&bullet(15.0).minus(below(13.5)))?, GLASS)
            .with_opacity(opacity),
    ];
    Ok(layers.into())
}

fn exploded() -> Result<Vec<Actor>, Box<dyn Error>> {
    let lift = |actor: Actor, z_mm: f64| actor.placed(Pose::translation(0.0, 0.0, z_mm));
    let mut actors = vec![
        lift(Actor::new(CompiledSolid::new(&Solid::cuboid(30.0, 32.0, 8.65))?, GREY), -20.0),
        Actor::new(CompiledSolid::new(&shell())?, BLUE),
        lift(Actor::new(CompiledSolid::new(&dome())?, ORANGE), 66.0),
    ];
    actors.extend(stack(0.5)?.into_iter().map(|actor| lift(actor, 30.0)));
    Ok(actors)
}

fn turned(turns: f64) -> Angle {
    Angle::from_rad(turns * TAU).expect("finite")
}

fn write_png(path: &Path, image: &RenderedImage) -> Result<(), Box<dyn Error>> {
    let file = std::io::BufWriter::new(std::fs::File::create(path)?);
    let mut encoder = png::Encoder::new(file, image.width_px, image.height_px);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(&image.rgb)?;
    Ok(())
}
