//! Export of a small test sensor, and its error cases.

use fabkit_application::designs::Design;
use fabkit_application::export::ExportError;
use fabkit_application::exports::{ExportOptions, ExportRunError, Exported, Format, export};
use fabkit_application::geometry::{
    Angle, Assembly, Body, NominalCamera, Placement, Point3, Pose, PrintGroup, Process, Sensor,
    Shells, Solid,
};

fn part(name: &str, solid: Solid) -> Body {
    Body::made(name, "for tests", Process::Fdm, solid)
        .with_material("PLA")
        .placed([Placement::in_place(Assembly::sensor())])
        .colored([200, 100, 50])
}

fn design(parts: Vec<Body>) -> Design {
    let camera = NominalCamera {
        sensor_from_camera: Pose::identity(),
        width_px: 640,
        height_px: 480,
        field_of_view: Angle::from_deg(160.0).unwrap(),
        lens: Default::default(),
    };
    let sensor = Sensor::new("small", "Small", "", camera, parts);
    Design {
        family: "none",
        sensor,
        parameters: Vec::new(),
        derived: Vec::new(),
        materials: Vec::new(),
        companions: Vec::new(),
        articles: Default::default(),
    }
}

fn run(parts: Vec<Body>) -> Result<Exported, ExportRunError> {
    export(&design(parts), &ExportOptions::default(), &|_| ())
}

fn names(exported: &Exported) -> Vec<&str> {
    exported.files.iter().map(|file| file.name.as_str()).collect()
}

#[test]
fn parts_of_one_piece_keep_their_place_and_share_a_3mf() {
    // A slab of two materials: it lies on its left face, as its first part says.
    let mut soft = part("soft", Solid::cuboid_between([1.0, 2.0, 3.0], [2.0, 4.0, 6.0]));
    soft.bed_from_body = Pose::rotation_y(Angle::from_deg(-90.0).unwrap());
    let hard = part("hard", Solid::cuboid_between([2.0, 2.0, 3.0], [5.0, 4.0, 6.0]));
    let mut design = design(vec![soft, hard, part("alone", Solid::cuboid(1.0, 1.0, 1.0))]);
    let parts = vec!["soft".into(), "hard".into()];
    design.sensor.print_groups.push(PrintGroup { name: "slab".into(), parts });

    let exported = export(&design, &ExportOptions::default(), &|_| ()).unwrap();
    let expected = ["alone.3mf", "alone.stl", "hard.stl", "plate-fdm-pla-1.3mf"];
    assert_eq!(names(&exported)[..4], expected);
    assert_eq!(names(&exported)[4..], ["slab.3mf", "soft.stl", "manifest.json"]);
    let [soft, hard, _] = &exported.manifest.parts[..] else { panic!("three parts") };
    assert_eq!(soft.file_from_part, hard.file_from_part);
    // The common face at x = 2 lies 1 mm above the bed.
    assert_eq!((soft.bounds_in_file_mm.min.z, soft.bounds_in_file_mm.max.z), (0.0, 1.0));
    assert_eq!((hard.bounds_in_file_mm.min.z, hard.bounds_in_file_mm.max.z), (1.0, 4.0));
    // A plate would lay the two parts out separately.
    let plate = exported.manifest.files.iter().find(|file| file.name.starts_with("plate"));
    assert_eq!(plate.unwrap().parts, ["alone"]);

    // One part brings the other with it.
    let options = ExportOptions { parts: vec!["hard".into()], ..ExportOptions::default() };
    let exported = export(&design, &options, &|_| ()).unwrap();
    assert_eq!(names(&exported), ["hard.stl", "slab.3mf", "soft.stl", "manifest.json"]);
}

#[test]
fn a_part_lies_turned_in_the_corner_of_the_positive_octant() {
    let mut bar = part("bar", Solid::cuboid_between([-7.0, 1.0, -2.0], [3.0, 2.0, 5.0]));
    bar.bed_from_body = Pose::rotation_x(Angle::from_deg(90.0).unwrap());
    let exported = run(vec![bar]).unwrap();
    let entry = &exported.manifest.parts[0];
    assert_eq!(entry.bounds_in_file_mm.min, Point3::origin());
    assert_eq!(entry.bounds_in_file_mm.max, Point3::new(10.0, 7.0, 1.0));
    // y is up now, and the former z axis points at the viewer.
    let corner = entry.file_from_part.point(Point3::new(-7.0, 1.0, 5.0));
    assert!((corner - Point3::new(0.0, 0.0, 0.0)).norm() < 1e-12, "{corner}");
    assert!((entry.mesh.volume_mm3 - 70.0).abs() < 1e-9);
}

#[test]
fn plates_follow_process_material_and_quantity() {
    let mut clips = part("clip", Solid::cuboid(10.0, 10.0, 2.0));
    clips.quantity = 3;
    let resin = |name: &str, material: &str| {
        part(name, Solid::sphere(4.0)).made_by(Process::Sla).with_material(material)
    };
    let sheet = part("sheet", Solid::cuboid(10.0, 10.0, 2.0)).made_by(Process::Laser);
    // One printer, three resins: two of them differ only in a comma, and "PLA" is also the name of a resin.
    let parts = vec![
        clips,
        resin("lens", "clear resin"),
        resin("cup", "resin, clear"),
        resin("cap", "clear, resin"),
        resin("rim", "PLA"),
        sheet,
    ];
    let exported = run(parts).unwrap();
    let plates: Vec<_> = exported
        .manifest
        .files
        .iter()
        .filter(|f| f.name.starts_with("plate-"))
        .map(|f| {
            let stock = (f.process.as_deref().unwrap(), f.material.as_deref().unwrap());
            (f.name.as_str(), stock, f.parts.clone())
        })
        .collect();
    let expected = [
        ("plate-fdm-pla-1.3mf", ("fdm", "PLA"), vec!["clip"; 3]),
        ("plate-sla-clear-resin-1.3mf", ("sla", "clear resin"), vec!["lens"]),
        ("plate-sla-clear-resin-no2-1.3mf", ("sla", "clear, resin"), vec!["cap"]),
        ("plate-sla-pla-1.3mf", ("sla", "PLA"), vec!["rim"]),
        ("plate-sla-resin-clear-1.3mf", ("sla", "resin, clear"), vec!["cup"]),
    ];
    for (found, (name, stock, parts)) in plates.iter().zip(&expected) {
        assert_eq!((found.0, found.1), (*name, *stock));
        assert_eq!(&found.2, parts);
    }
    assert_eq!(plates.len(), expected.len());
    let cut = exported.manifest.files.iter().find(|f| f.name.starts_with("sheet-")).unwrap();
    assert_eq!((cut.process.as_deref(), cut.material.as_deref()), (Some("laser"), Some("PLA")));
}

#[test]
fn only_what_is_asked_for_is_made() {
    let parts = || vec![part("a", Solid::sphere(2.0)), part("b", Solid::sphere(3.0))];
    let options = |names: &[&str], formats: &[Format]| ExportOptions {
        parts: names.iter().map(|&name| name.into()).collect(),
        formats: formats.to_vec(),
        ..ExportOptions::default()
    };
    let run = |options| export(&design(parts()), &options, &|_| ());
    let exported = run(options(&["b", "a", "b"], &[Format::Stl, Format::Tree])).unwrap();
    assert_eq!(names(&exported), ["a.stl", "a.tree.json", "b.stl", "b.tree.json", "manifest.json"]);
    let exported = run(options(&["b"], &[Format::ThreeMf])).unwrap();
    assert_eq!(names(&exported), ["b.3mf", "manifest.json"]);
    let exported = run(options(&[], &[Format::Stl])).unwrap();
    assert_eq!(names(&exported), ["a.stl", "b.stl", "manifest.json"]);
    assert!(matches!(run(options(&["c"], &[])), Err(ExportRunError::Unknown(_))));
}

/// The light file describes the whole sensor, whichever parts are requested.
#[test]
fn light_is_one_file() {
    // Away from the camera, which must not be inside a part.
    let ball = |radius_mm| Solid::sphere(radius_mm).at(0.0, 0.0, 10.0);
    let parts = || vec![part("a", ball(2.0)), part("b", ball(3.0))];
    let run = |names: &[&str], formats: &[Format]| {
        let parts_asked = names.iter().map(|&name| name.into()).collect();
        let options = ExportOptions {
            parts: parts_asked,
            formats: formats.to_vec(),
            ..ExportOptions::default()
        };
        export(&design(parts()), &options, &|_| ()).unwrap()
    };
    assert_eq!(names(&run(&[], &[Format::Light])), ["light.json", "manifest.json"]);
    let exported = run(&["b"], &[Format::Tree, Format::Light]);
    assert_eq!(names(&exported), ["b.tree.json", "light.json", "manifest.json"]);
    let light = exported.manifest.files.iter().find(|file| file.name == "light.json").unwrap();
    assert_eq!(light.format, "light");
}

#[test]
fn only_files_that_are_compensated_say_so() {
    let mut mold = part("mold", Solid::cuboid(10.0, 10.0, 10.0));
    mold.shrinkage = 0.01;
    let compensation = |formats: &[Format]| {
        let options = ExportOptions { formats: formats.to_vec(), ..ExportOptions::default() };
        let exported = export(&design(vec![mold.clone()]), &options, &|_| ()).unwrap();
        let [mold] = &exported.manifest.parts[..] else { panic!("one part") };
        (mold.compensation.scale, mold.bounds_in_file_mm.max.x, mold.compensation.note.clone())
    };
    for nominal in [&[][..], &[Format::Tree], &[Format::Png, Format::Tree, Format::Samples]] {
        assert_eq!(compensation(nominal), (1.0, 10.0, "none".into()), "{nominal:?}");
    }
    let (scale, size_mm, note) = compensation(&[Format::Stl, Format::Tree]);
    assert!((scale * 0.99 - 1.0).abs() < 1e-12 && (size_mm * 0.99 - 10.0).abs() < 1e-5);
    assert!(note.contains("shrinkage"), "{note}");
}

#[test]
fn a_mesh_that_fails_names_its_part() {
    let empty = Solid::sphere(1.0).minus(Solid::sphere(2.0));
    for (solid, text) in [(empty, "empty"), (Solid::below(1.0), "unbounded")] {
        let error = run(vec![part("good", Solid::sphere(1.0)), part("bad", solid)]).unwrap_err();
        assert!(matches!(&error, ExportRunError::Mesh { part, .. } if part == "bad"), "{error}");
        assert!(error.to_string().contains(text), "{error}");
    }
}

#[test]
fn a_hole_that_the_design_did_not_count_is_refused() {
    let washer = Solid::cylinder(5.0, 1.0).minus(Solid::cylinder(2.0, 3.0).at(0.0, 0.0, -1.0));
    let error = run(vec![part("washer", washer)]).unwrap_err();
    assert!(matches!(error, ExportRunError::Genus { found: 1, counted: 0, .. }), "{error}");
}

#[test]
fn loose_pieces_and_closed_cavities_are_refused_with_place_and_volume() {
    let chip = Solid::cuboid(9.0, 9.0, 9.0).plus(Solid::sphere(0.5).at(7.0, 0.0, 4.5));
    let error = run(vec![part("chipped", chip)]).unwrap_err().to_string();
    // In the file's frame: the box begins at 0.
    assert!(error.contains("2 pieces and 0 closed cavities"), "{error}");
    assert!(error.contains("a piece of 5.1") && error.contains("(11.50, 4.50, 4.50)"), "{error}");

    let hollow = Solid::cuboid(9.0, 9.0, 9.0).minus(Solid::sphere(2.0).at(0.0, 0.0, 4.5));
    let error = run(vec![part("hollow", hollow.clone())]).unwrap_err();
    let ExportRunError::Shells { unexpected, .. } = &error else { panic!("{error}") };
    assert!((unexpected[0].volume_mm3 + 33.5).abs() < 0.3, "{error}");

    let counted = Shells { pieces: 1, voids: 1 };
    run(vec![part("hollow", hollow).with_shells(counted)]).unwrap();
}

#[test]
fn a_wall_thinner_than_the_tolerance_is_meshed_finer() {
    let tube = Solid::cylinder(10.0, 5.0).minus(
        Solid::cylinder(9.7, 7.0).turned_z(Angle::from_deg(11.0).unwrap()).at(0.0, 0.0, -1.0),
    );
    let design = design(vec![part("tube", tube).with_handles(1)]);
    let options = ExportOptions { tolerance_mm: 1.0, ..ExportOptions::default() };
    let exported = export(&design, &options, &|_| ()).unwrap();
    let used_mm = exported.manifest.parts[0].mesh.chord_tolerance_mm;
    assert!(used_mm < 1.0, "{used_mm}");
}

#[test]
fn two_files_of_one_name_are_refused() {
    let twice = || part("a", Solid::sphere(2.0));
    let error = run(vec![twice(), twice()]).unwrap_err();
    assert!(matches!(&error, ExportRunError::DuplicateFile(name) if name == "a.stl"), "{error}");
}

#[test]
fn more_triangles_than_allowed_are_refused_before_they_are_written() {
    let mut many = part("many", Solid::sphere(10.0));
    many.quantity = 10_000;
    let error = run(vec![many]).unwrap_err();
    assert!(matches!(error, ExportRunError::TooManyTriangles { most: 5_000_000 }), "{error}");
}

#[test]
fn what_is_larger_than_the_bed_is_refused_by_name() {
    let error = run(vec![part("slab", Solid::cuboid(300.0, 10.0, 1.0))]).unwrap_err();
    assert!(matches!(&error, ExportRunError::Plate(ExportError::LargerThanBed { .. })), "{error}");
    assert!(error.to_string().starts_with("slab needs 300.0 x 10.0 mm"), "{error}");
}
