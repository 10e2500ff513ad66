//! The built-in UVDtact: solids, thicknesses, markers, the closed loop of its molds, and what is
//! refused.

use fabkit_designs::{Design, builtin_yaml, load};
use fabkit_geometry::measure::{overlap_volume, ray_volume};
use fabkit_geometry::{Action, CompiledSolid, Point3, Ray, Solid, Vector3};

fn try_uvdtact(overrides: &[&str]) -> Result<Design, Vec<String>> {
    let overrides: Vec<String> = overrides.iter().map(|o| o.to_string()).collect();
    let yaml = builtin_yaml("uvdtact").unwrap();
    load("uvdtact.yaml", yaml, &overrides, &["fixtures"]).map_err(|e| {
        let line = |p: &fabkit_designs::parameters::Problem| {
            format!("{}: {} ({})", p.path, p.message, p.hint.as_deref().unwrap_or(""))
        };
        e.problems.iter().map(line).collect()
    })
}

fn uvdtact(overrides: &[&str]) -> Design {
    try_uvdtact(overrides).unwrap_or_else(|e| panic!("{e:#?}"))
}

fn solid<'a>(design: &'a Design, name: &str) -> &'a Solid {
    let sensor = &design.sensor;
    let parts = sensor.parts().map(|p| (&p.name, &p.solid));
    let layers = sensor.layers().map(|l| (&l.name, &l.solid));
    parts.chain(layers).find(|(known, _)| *known == name).unwrap().1
}

fn body(design: &Design, name: &str) -> CompiledSolid {
    CompiledSolid::new(solid(design, name)).unwrap()
}

#[test]
fn every_solid_is_valid_with_85_43_and_0_markers() {
    for count in ["85", "43", "0"] {
        let sensor = uvdtact(&[&format!("markers.count={count}")]).sensor;
        let solids = sensor.bodies.iter().map(|b| (&b.name, &b.solid));
        for (name, solid) in solids {
            solid.validate().unwrap_or_else(|e| panic!("{name}: {e}"));
        }
        let negative = sensor.body("negative-cup-inner").unwrap();
        assert_eq!(negative.landmarks.len().to_string(), count);
    }
}

/// A point of the 18 x 24 ellipsoid and its outward normal.
fn on_ellipsoid(eccentric: f64, azimuth: f64) -> (Point3<f64>, Vector3<f64>) {
    let ((s, c), (sa, ca)) = (eccentric.sin_cos(), azimuth.sin_cos());
    let normal = Vector3::new(s * ca / 9.0, s * sa / 9.0, c / 24.0).normalize();
    (Point3::new(9.0 * s * ca, 9.0 * s * sa, 24.0 * c), normal)
}

/// The layers' boundaries along the normals of the sensing surface, which all parallel surfaces
/// share: depths of black, outer, inner elastomer's outside, shell's outside, shell's inside.
#[test]
fn every_layer_is_as_thick_as_it_says_along_every_normal() {
    for (to, first_mm) in [("black-gel", 0.0), ("outer-elastomer", -0.4)] {
        // One marker, at the tip: where lines pass beside it, layers are as thick as without.
        let one = ["markers.count=1", &format!("surface.measured_to={to}")];
        let design = uvdtact(&one);
        let bounds = [
            ("black-gel", 0.0, 0.4),
            ("outer-elastomer", 0.4, 0.9),
            ("inner-elastomer", 0.9, 2.4),
            ("shell", 2.4, 4.4),
        ];
        for (name, outside, inside) in bounds {
            let body = body(&design, name);
            let mut worst_mm = 0.0f64;
            for i in 0..400 {
                let eccentric = std::f64::consts::FRAC_PI_2 * (f64::from(i) + 0.5) / 400.0;
                let (surface, normal) = on_ellipsoid(eccentric, 2.4 * f64::from(i));
                if surface.xy().coords.norm() < 1.5 {
                    continue; // The marker.
                }
                // Above the shell's rounded tip only its outside is parallel.
                let inside = (name != "shell" || eccentric > 0.7).then_some(inside + first_mm);
                let origin = surface + 2.0 * normal;
                // Depths are small against the radii of curvature except at the tip, where a normal
                // could leave the half ellipsoid again: only the first two crossings count.
                let crossings = body.crossings(&Ray { origin, direction: -normal });
                let at = |k: usize| crossings[k].t - 2.0;
                if surface.z - 5.0 * normal.z < 0.0 {
                    continue; // The normal passes the base plane first.
                }
                worst_mm = worst_mm.max((at(0) - outside - first_mm).abs());
                worst_mm = inside.map_or(worst_mm, |depth| worst_mm.max((at(1) - depth).abs()));
            }
            println!("{name}: {:.2e} mm off", worst_mm);
            assert!(worst_mm < 1e-4, "{name}: {worst_mm} mm");
        }
    }
}

#[test]
fn the_shell_is_nowhere_thinner_than_2_mm() {
    // Along any line a wall is at least as thick as along its normal.
    let design = uvdtact(&[]);
    let body = body(&design, "shell");
    for i in 1..300 {
        let polar = 1.5 * f64::from(i) / 300.0;
        for centre_z in [14.0, 8.0, 2.0] {
            let direction = Vector3::new(polar.sin(), 0.0, polar.cos());
            let ray = Ray { origin: Point3::new(0.0, 0.0, centre_z), direction };
            let mut ahead = body.crossings(&ray).into_iter().map(|c| c.t).filter(|t| *t > 0.0);
            let (inside, outside) = (ahead.next().unwrap(), ahead.next().unwrap());
            assert!(outside - inside >= 2.0 - 1e-4, "{polar} {centre_z}: {inside} {outside}");
        }
    }
}

#[test]
fn markers_are_even_and_whole() {
    for (count, slots) in [("85", 85), ("43", 43)] {
        let design = uvdtact(&[&format!("markers.count={count}")]);
        let negative = design.sensor.body("negative-cup-inner").unwrap();
        let points: Vec<_> = negative.landmarks.iter().map(|l| l.point).collect();
        assert_eq!(points.len(), slots);
        let nearest = |p: &Point3<f64>| {
            let others = points.iter().filter(|q| *q != p);
            others.map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min)
        };
        let distances: Vec<f64> = points.iter().map(nearest).collect();
        let (least, most) = distances
            .iter()
            .fold((f64::INFINITY, 0.0f64), |(low, high), d| (low.min(*d), high.max(*d)));
        println!("{count} markers: nearest neighbours {least:.2} to {most:.2} mm");
        // Chords on a curved surface: the tip's first ring is the nearest.
        assert!(most / least < 1.45, "{least} {most}");
        // Half a ring's spacing above the base circle, less the slot's radius.
        assert!(points.iter().all(|p| p.z > 1.0));
    }
}

#[test]
fn slots_take_what_pegs_fill() {
    // 84 more cylinders of 0.5 x 0.5 mm and hemispheres, less what the dome's curvature takes off the
    // mouths: at most the cap of the flattest and of the sharpest curvature.
    let (with, without) = (uvdtact(&[]), uvdtact(&["markers.count=0"]));
    let volume = |design: &Design, name| {
        let estimate = ray_volume(&body(design, name), 100_000).unwrap();
        println!("{name}: {} +- {} mm3", estimate.value_mm3, estimate.error_mm3);
        estimate
    };
    let (slotted, pegged) = (volume(&with, "inner-elastomer"), volume(&with, "outer-elastomer"));
    // Without markers both are one, as large as both together; its outside is that of the outer one.
    let whole = volume(&without, "inner-elastomer");
    let sum = slotted.value_mm3 + pegged.value_mm3;
    let error = slotted.error_mm3 + pegged.error_mm3 + whole.error_mm3;
    assert!((sum - whole.value_mm3).abs() < error, "{sum} {whole:?}");
    // With one marker there are two layers, one slot and one peg.
    let one = uvdtact(&["markers.count=1"]);
    let (plain, smooth) = (volume(&one, "inner-elastomer"), volume(&one, "outer-elastomer"));
    let pi = std::f64::consts::PI;
    let slot = pi * 0.25 * 0.5 + 2.0 / 3.0 * pi * 0.125;
    // Mean sagitta over a disc of r 0.5: r^2/4 times the mean curvature, here at most 1/2.475.
    let mouth = pi * 0.25 * 0.25 / 4.0 / 2.475;
    let taken = plain.value_mm3 - slotted.value_mm3;
    let filled = pegged.value_mm3 - smooth.value_mm3;
    let error = plain.error_mm3 + slotted.error_mm3 + pegged.error_mm3 + smooth.error_mm3;
    assert!(taken < 84.0 * slot + error && taken > 84.0 * (slot - mouth) - error, "{taken}");
    assert!((taken - filled).abs() < error, "{taken} {filled}");
}

#[test]
fn the_negative_of_the_negative_is_the_layer() {
    let design = uvdtact(&[]);
    // A region around the dome and the keys that shares no face with any of them.
    let region = Solid::cylinder(16.0, 28.0).at(0.0, 0.0, 0.5);
    let region_mm3 = std::f64::consts::PI * 256.0 * 28.0;
    let region = CompiledSolid::new(&region).unwrap();
    let within =
        |name: &str| overlap_volume(&region, &body(&design, name), 100_000).unwrap().volume;
    let (cup, negative) = (within("silicone-cup-inner"), within("negative-cup-inner"));
    let (core, layer) = (within("silicone-core"), within("inner-elastomer"));
    let error = cup.error_mm3 + negative.error_mm3 + core.error_mm3 + layer.error_mm3;
    // What the silicone leaves free is what was printed, and what core and elastomer fill.
    let free_mm3 = region_mm3 - cup.value_mm3;
    let filled_mm3 = core.value_mm3 + layer.value_mm3;
    println!("printed {negative:?}, free {free_mm3}, filled {filled_mm3} mm3");
    assert!(error < 1e-3 * free_mm3, "{error}");
    assert!((free_mm3 - negative.value_mm3).abs() < error, "{free_mm3} {negative:?}");
    assert!((free_mm3 - filled_mm3).abs() < error, "{free_mm3} {filled_mm3}");
    // And each fits its neighbours without overlap.
    let [cup, negative, core, layer] =
        ["silicone-cup-inner", "negative-cup-inner", "silicone-core", "inner-elastomer"]
            .map(|name| body(&design, name));
    for (a, b) in [(&cup, &negative), (&cup, &core), (&cup, &layer), (&core, &layer)] {
        assert_eq!(overlap_volume(a, b, 20_000).unwrap().volume.value_mm3, 0.0);
    }
}

#[test]
fn the_chain_pours_every_layer_once() {
    let sensor = uvdtact(&[]).sensor;
    let mut poured: Vec<&str> = sensor
        .chain
        .iter()
        .filter_map(|step| match &step.action {
            Action::Pour(pour) => Some(pour.layer.as_str()),
            _ => None,
        })
        .collect();
    let mut layers: Vec<&str> = sensor.layers().map(|l| l.name.as_str()).collect();
    poured.sort_unstable();
    layers.sort_unstable();
    assert_eq!(poured, layers);
}

#[test]
fn what_cannot_be_built_is_refused_with_the_limit() {
    for (set, path, said) in [
        ("markers.straight_depth=1.2mm", "markers.straight_depth", "at most 0.8 mm"),
        ("markers.radius=1.4mm", "markers.straight_depth", "no value works"),
        ("markers.count=600", "markers.count", "write at most"),
        ("leds.diameter=3.7mm leds.circle_radius=4.8mm", "leds.diameter", "at most 3.5"),
        ("leds.circle_radius=4mm", "leds.diameter", "at most 2.9"),
        (
            "leds.circle_radius=5.5mm holder.outer_diameter=18mm",
            "leds.circle_radius",
            "at most 4.8",
        ),
        ("leds.pairs=5 leds.circle_radius=4.8mm", "leds.diameter", "at most"),
        ("inner_elastomer.thickness=2.5mm", "inner_elastomer.thickness", "at most 2.175 mm"),
        ("shell.thickness=6mm", "shell.thickness", "at most 5.1 mm"),
        ("surface.height=10mm", "surface.height", "at least 10.8 mm"),
        ("black_gel.material=honey", "black_gel.material", "declare your own"),
        ("camera.front_depth=6mm shell.foot_height=3mm", "camera.front_depth", "at most 3.9 mm"),
        ("holder.skirt=0.8mm", "holder.skirt", "at least 1.2"),
        ("holder.outer_diameter=13mm", "holder.outer_diameter", "at least 14.2 mm"),
        (
            "tooling.silicone_diameter=30mm tooling.key_diameter=4mm",
            "tooling.silicone_diameter",
            "at least 34.4 mm",
        ),
        ("tooling.vent_diameter=1.5mm", "tooling.vent_diameter", "at most 1.4 mm"),
        ("tooling.core_flange=4mm", "tooling.core_flange", "at least 4.5 mm"),
        ("tooling.vents=40", "tooling.vents", "write fewer"),
        ("base.mount_radius=3mm", "base.mount_radius", "write a larger radius"),
        ("base.mount_radius=2mm base.mount_holes=6", "base.mount_radius", "walls between"),
        ("base.bolts=6 base.mount_holes=3", "base.mount_holes", "write 6"),
        ("camera.length=9mm", "camera.length", "at most"),
    ] {
        let problems = try_uvdtact(&set.split(' ').collect::<Vec<_>>()).err().unwrap_or_default();
        let found = problems.iter().any(|p| p.starts_with(&format!("{path}:")) && p.contains(said));
        assert!(found, "{set}: {problems:#?}");
    }
}
