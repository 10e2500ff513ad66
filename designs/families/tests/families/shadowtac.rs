//! The built-in ShadowTac: the paper's and the published CAD's figures follow from its parameters,
//! and what cannot be built is refused.

use std::f64::consts::PI;

use fabkit_designs::parameters::InvalidDesign;
use fabkit_designs::{Design, builtin_yaml, load};
use fabkit_geometry::measure::ray_volume;
use fabkit_geometry::{CompiledSolid, Point3, Solid};

fn try_load(name: &str, overrides: &[&str]) -> Result<Design, InvalidDesign> {
    let overrides: Vec<String> = overrides.iter().map(|o| o.to_string()).collect();
    load(&format!("{name}.yaml"), builtin_yaml(name).unwrap(), &overrides, &["fixtures"])
}

fn built(name: &str, overrides: &[&str]) -> Design {
    try_load(name, overrides).unwrap_or_else(|e| panic!("{e}: {:#?}", e.problems))
}

fn derived(design: &Design, name: &str) -> String {
    let found = design.derived.iter().find(|(known, _)| known == name);
    found.unwrap_or_else(|| panic!("no figure `{name}`")).1.clone()
}

fn layer<'a>(design: &'a Design, name: &str) -> &'a Solid {
    &design.sensor.layers().find(|l| l.name == name).unwrap().solid
}

/// Volume of a cap of height `h` over a foot of radius `a`.
fn cap_mm3(a: f64, h: f64) -> f64 {
    PI * h / 6.0 * (3.0 * a * a + h * h)
}

/// Volume of one dimple below its tangent plane: a cylinder with a hemisphere.
fn dimple_mm3() -> f64 {
    let r: f64 = 0.225;
    PI * r * r * (0.5 - r) + 2.0 / 3.0 * PI * r.powi(3)
}

#[test]
fn every_solid_is_valid() {
    for name in ["shadowtac", "shadowtac-published-cad"] {
        for overrides in [&[][..], &["dimples.direction=out-of-gel"]] {
            let sensor = built(name, overrides).sensor;
            let solids = sensor.bodies.iter().map(|b| (&b.name, &b.solid));
            for (body, solid) in solids {
                solid.validate().unwrap_or_else(|e| panic!("{name} / {body}: {e}"));
            }
        }
    }
}

#[test]
fn the_papers_cap_has_the_sphere_that_its_foot_and_height_give() {
    // (17.5^2 + 8^2) / 16.
    let design = built("shadowtac", &[]);
    assert_eq!(derived(&design, "sphere radius"), "23.141 mm");
    assert_eq!(derived(&design, "dimples"), "469");
}

#[test]
fn the_published_cad_follows_from_height_rings_and_spacing() {
    let design = built("shadowtac-published-cad", &[]);
    assert_eq!(derived(&design, "sphere radius"), "22.500 mm");
    assert_eq!(derived(&design, "dimples"), "469");
    assert_eq!(derived(&design, "polar step from ring to ring"), "3.947 deg");
}

#[test]
fn the_mold_lists_every_dimple_on_the_sphere() {
    let design = built("shadowtac-published-cad", &[]);
    let block = design.sensor.body("mold-skin-block").unwrap();
    assert_eq!(block.landmarks.len(), 469);
    let centre = Point3::new(0.0, 0.0, 8.357864 - 22.5);
    let mut steps_deg = Vec::new();
    for dimple in &block.landmarks {
        let out = dimple.point - centre;
        // The height is written to 1e-6 mm.
        assert!((out.norm() - 22.5).abs() < 1e-6, "{}", dimple.name);
        assert!((out.normalize() - dimple.axis).norm() < 1e-6, "{}", dimple.name);
        steps_deg.push(dimple.axis.z.clamp(-1.0, 1.0).acos().to_degrees() / 3.947);
    }
    for k in 0..=12u32 {
        // 1.55 mm on the sphere is 3.94704 degrees: twelve steps add up to 5e-4 degrees.
        let on_ring = steps_deg.iter().filter(|s| (**s - f64::from(k)).abs() < 2e-4).count();
        assert_eq!(on_ring, if k == 0 { 1 } else { 6 * k as usize }, "ring {k}");
    }
}

#[test]
fn dimples_take_their_volume_from_the_gel_or_add_it() {
    for (overrides, sign) in [(&[][..], -1.0), (&["dimples.direction=out-of-gel"], 1.0)] {
        let design = built("shadowtac", overrides);
        let volume =
            ray_volume(&CompiledSolid::new(layer(&design, "skin")).unwrap(), 200_000).unwrap();
        let smooth = cap_mm3(17.5, 8.0);
        // Between surface and tangent plane lies pi r^4 / (4 R) at each dimple: below 1e-4 mm3.
        let bound = volume.error_mm3 + 469.0 * 1e-4;
        let expected = smooth + sign * 469.0 * dimple_mm3();
        assert!((volume.value_mm3 - expected).abs() < bound, "{volume:?}, expected {expected}");
        // The bound would notice a missing ring.
        assert!(bound < 40.0 * dimple_mm3());
    }
}

#[test]
fn paint_and_gel_together_are_a_smooth_cap() {
    let design = built("shadowtac", &[]);
    let volume =
        |name| ray_volume(&CompiledSolid::new(layer(&design, name)).unwrap(), 200_000).unwrap();
    let (gel, paint) = (volume("skin"), volume("reflective-paint"));
    // The painted cap: same centre, 0.05 mm more radius.
    let (centre, radius) = (-15.140625f64, 23.140625 + 0.05);
    let outside = cap_mm3((radius * radius - centre * centre).sqrt(), 8.05);
    let off = gel.value_mm3 + paint.value_mm3 - outside;
    assert!(off.abs() < gel.error_mm3 + paint.error_mm3, "{off} of {outside}");
}

/// Each refusal: the override, the path it is reported at, and what the message must name.
#[test]
fn what_cannot_be_built_is_refused_with_limit_and_remedy() {
    let cases: &[(&str, &str, &str)] = &[
        ("dimples.width=1.5mm", "dimples.width", "spacing"),
        ("dimples.spacing=0.5mm", "dimples.width", "spacing"),
        ("dimples.width=0.1mm", "dimples.width", "resin"),
        ("dimples.height=0.2mm", "dimples.height", "tip"),
        ("dimples.height=3mm", "dimples.height", "peeled"),
        ("dimples.rings=14 dimples.spacing=1.4mm", "dimples.rings", "rim"),
        ("dimples.rings=40 dimples.spacing=1.4mm", "dimples.rings", "rim"),
        ("skin.height=18mm", "skin.height", "hemisphere"),
        ("skin.material=Jelly", "skin.material", "mix"),
        ("paint.thickness=0.4mm", "paint.thickness", "dimples"),
        ("plate.diameter=36mm", "plate.diameter", "skin"),
        ("leds.strip_length=9.2mm leds.count=12", "leds.count", "overlapping"),
        ("leds.package_size=5.5mm", "leds.package_size", "strips"),
        (
            "leds.package_height=4mm dimples.rings=13 camera.depth=30mm",
            "leds.package_height",
            "hide",
        ),
        ("leds.strip_length=12mm", "leds.strip_length", "recess"),
        ("leds.below_plate=10mm leds.strip_width=12mm", "leds.below_plate", "housing"),
        ("camera.depth=4mm", "camera.depth", "touch"),
        ("camera.housing_size=31mm holder.screw_spacing=31mm", "holder.screw_spacing", "camera"),
        ("holder.width=35mm", "holder.width", "painted"),
        ("holder.height=20mm", "holder.height", "centre"),
        ("holder.corner=6mm", "holder.corner", "corner"),
        ("base.height=14mm", "base.height", "plug"),
        ("base.window_width=10mm", "base.window_width", "plug"),
        ("base.window_width=28mm", "base.window_width", "screws"),
        ("camera.housing_size=36mm holder.width=37mm", "holder.width", "groove"),
        ("base.mount_radius=15.5mm", "base.mount_radius", "room"),
        ("base.mount_radius=3mm base.mount_holes=8", "base.mount_radius", "walls between"),
        ("mold.height=11mm mold.wall=4mm", "mold.height", "floor"),
        ("mold.diameter=50mm", "mold.diameter", "nuts"),
        ("mold.trough=4mm mold.bolt_circle=47mm", "mold.bolt_circle", "trough"),
        ("mold.vent_diameter=1.5mm holder.aperture_diameter=32mm", "mold.vent_diameter", "vents"),
        ("mold.lid_thickness=10mm", "mold.lid_thickness", "reach"),
        ("mold.pry_depth=6mm mold.trough=3mm mold.bolt_circle=47mm", "mold.pry_depth", "trough"),
    ];
    let mut missed = Vec::new();
    for (settings, path, word) in cases {
        let settings: Vec<&str> = settings.split(' ').collect();
        let problems = try_load("shadowtac", &settings).err().map_or(vec![], |e| e.problems);
        let as_expected = problems
            .iter()
            .any(|p| p.path == *path && p.message.contains(word) && p.hint.is_some());
        if !as_expected {
            missed.push(format!("{settings:?} at {path}: {problems:#?}"));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

#[test]
fn the_nearest_value_that_is_offered_works() {
    // As the messages of the cases above round it.
    let spacing = "dimples.spacing=1.4mm";
    let error = try_load("shadowtac", &["dimples.rings=14", spacing]).expect_err("the rim cuts it");
    assert!(error.problems[0].hint.as_deref().unwrap().contains("at most 13"), "{error:#?}");
    built("shadowtac", &["dimples.rings=13", spacing]);
    let error = try_load("shadowtac", &["leds.strip_length=9.2mm", "leds.count=12"])
        .expect_err("twelve strips overlap");
    let count = error.problems.iter().find(|p| p.path == "leds.count").unwrap();
    assert!(count.hint.as_deref().unwrap().contains("11"), "{error:#?}");
}
