//! Depth from images: without a network, against the truth that the images were made of, simulated; with one, against
//! what a network says that is small enough to be worked out by hand.

use std::path::Path;
use std::sync::Arc;

use fabkit_application::Error;
use fabkit_application::calibration::image::GreyImage;
use fabkit_application::capturing::{CaptureRequest, LightConstants, find_lighting};
use fabkit_application::fixtures::Project;
use fabkit_application::ground_truth::Viewpoint;
use fabkit_application::network::writer::{ChainLayer, write_chain};
use fabkit_application::press_simulation::{ContactModel, LinearOptions};
use fabkit_application::reconstructing::{CapturedImage, Reconstructor};
use fabkit_application::scene::{Cast, SensorView};
use fabkit_application::source::Source;
use fabkit_tests::fabkit;

/// A sensor whose camera takes its images.
struct Bench {
    project: Arc<Project>,
    scene: SensorView,
    constants: LightConstants,
}

/// An image as the camera sends it, and the truth that it shows.
struct Shown {
    values: Vec<f32>,
    depth_mm: Vec<f64>,
    contact: Vec<bool>,
}

impl Bench {
    fn new(sensor: &str, settings: &[&str]) -> Self {
        let settings: Vec<String> = settings.iter().map(|set| (*set).to_owned()).collect();
        let project = Arc::new(Source::find(sensor).unwrap().load(&settings).unwrap());
        let viewpoint = Viewpoint::new(&project.design.sensor.camera, None, None).unwrap();
        let scene = SensorView::new(Arc::clone(&project), viewpoint).unwrap();
        let constants = LightConstants::for_sensor(&project.design.sensor);
        Self { project, scene, constants }
    }

    fn take(&self, press: Option<&str>) -> Shown {
        let finder = self.project.press_finder();
        let presses: Vec<_> = press.into_iter().map(|id| finder.press(id).unwrap()).collect();
        let cast = Cast {
            presses: &presses,
            samples: 1,
            contact: ContactModel::Linear(LinearOptions::default()),
            shear_mm: [0.0; 2],
            print_sigma_mm: 0.0,
            allow_no_contact: true,
        };
        let lighting = find_lighting(&self.project.design.sensor, None).unwrap();
        let capturing =
            CaptureRequest { cast, lighting, constants: &self.constants, seed: Some(3) };
        let (mut depth_mm, mut contact) = (Vec::new(), Vec::new());
        let captured = capturing
            .render(&self.scene, 0, |seen| {
                depth_mm = seen.map.indentation_mm().collect();
                contact = seen.map.contact().collect();
                Ok::<_, Error>(())
            })
            .unwrap();
        let values = captured.grey.iter().map(|grey| (grey.round() / 255.0) as f32).collect();
        Shown { values, depth_mm, contact }
    }

    fn picture(&self, values: &[f32]) -> CapturedImage {
        let camera = self.scene.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        let channels = values.len() / (size_px[0] * size_px[1]);
        CapturedImage { size_px, channels, values: values.to_vec() }
    }

    fn knows(&self) -> Reconstructor {
        let rest = self.picture(&self.take(None).values);
        let light = find_lighting(&self.project.design.sensor, None).unwrap();
        let rest = (Path::new("ref.png"), &rest);
        Reconstructor::new(&self.scene, light, &self.constants, rest).unwrap().accept().unwrap()
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values.filter(|value| value.is_finite()) {
        sum += value;
        count += 1.0;
    }
    sum / count
}

#[test]
fn depth_is_what_the_images_were_made_of() {
    // A quarter of the pixels shows as much, in a quarter of the time.
    let fewer = ["camera.width_px=320", "camera.height_px=240"];
    for (sensor, press, pitch) in [
        ("rtac0", "hemisphere@30deg,120deg,1.2mm", None),
        ("9dtact", "hemisphere@2mm,-3mm,1mm", Some("camera.pixel_pitch=0.1mm")),
        ("digit-like", "ball@3mm,2mm,0.6mm", Some("camera.pixel_pitch=0.06mm")),
    ] {
        let bench = Bench::new(sensor, &[&fewer[..], pitch.as_slice()].concat());
        let known = bench.knows();
        let shown = bench.take(Some(press));
        let found =
            known.reconstruct(Path::new("pressed.png"), bench.picture(&shown.values)).unwrap();
        let found = found.accept().unwrap();
        let of = |wanted: bool, value: &dyn Fn(usize) -> f64| {
            mean((0..shown.depth_mm.len()).filter(|i| shown.contact[*i] == wanted).map(value))
        };
        let miss = |i: usize| (f64::from(found.depth_mm[i]) - shown.depth_mm[i]).abs();
        let (contact_mm, beside_mm) = (of(true, &miss), of(false, &miss));
        let nothing_mm = of(true, &|i| shown.depth_mm[i]);
        let told = of(true, &|i| f64::from(u8::from(found.contact[i])));
        println!(
            "{sensor}, {press}: {contact_mm:.3} mm off where something presses, of {nothing_mm:.3} mm; {beside_mm:.3} mm elsewhere; \
             {:.0} % of the contact is found",
            100.0 * told
        );
        assert!(contact_mm < 0.25 * nothing_mm && beside_mm < 0.05, "{contact_mm} {beside_mm}");
        assert!(told > 0.95, "{told}");
        assert!((found.relative_brightness - 1.0).abs() < 0.01, "{}", found.relative_brightness);
        // An image that is brighter as a whole is the same press.
        let brighter: Vec<f32> = shown.values.iter().map(|value| (1.05 * value).min(1.0)).collect();
        let again = known.reconstruct(Path::new("brighter.png"), bench.picture(&brighter)).unwrap();
        let again = again.accept().unwrap();
        assert!(
            (again.relative_brightness / found.relative_brightness - 1.05).abs() < 0.005,
            "{}",
            again.relative_brightness
        );
        let off = found.depth_mm.iter().zip(&again.depth_mm);
        assert!(mean(off.map(|(a, b)| f64::from((a - b).abs()))) < 0.02);
    }
}

fn grey_png([width, height]: [u32; 2], value: f32) -> Vec<u8> {
    GreyImage::new(width, height, vec![value; (width * height) as usize]).unwrap().to_png()
}

/// An image of R-Tac0's size, grey, and darker in a square of 40 px.
fn pressed(grey: f32, darker: f32) -> Vec<u8> {
    let square = |i: usize| (220..260).contains(&(i / 640)) && (300..340).contains(&(i % 640));
    let value = |i| (grey - if square(i) { darker } else { 0.0 }) / 255.0;
    GreyImage::new(640, 480, (0..640 * 480).map(value).collect()).unwrap().to_png()
}

#[test]
fn a_network_says_what_it_was_trained_to_say() {
    let root = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(root.path().join(name), bytes).unwrap();
    write("rest.png", &pressed(120.0, 0.0));
    write("pressed.png", &pressed(120.0, 26.0));
    // Darker as a whole by a twentieth.
    write("darker.png", &pressed(114.0, 26.0));
    let double = ChainLayer::convolution([1, 1, 1, 1], 1, &[2.0], &[0.0]);
    write("net.onnx", &write_chain(&[double.clone(), ChainLayer::operator("Relu")]));
    let words = ["reconstruct", "rtac0", "--network", "net.onnx", "--reference", "rest.png"];
    let run = |more: &[&str]| fabkit(root.path(), &[&words, more, &["-o", "out"]].concat());
    let is_near = |found: &serde_json::Value, wanted: f64| {
        let found = found.as_f64().unwrap();
        assert!((found - wanted).abs() < 1e-4, "{found} {wanted}");
    };
    // Without a card it takes what R-Tac0's published network takes: less 3, over 47, twice that, times 2 mm.
    let text = run(&["pressed.png"]).ok().stdout;
    assert!(text.contains("net.onnx has no card") && !text.contains("warning"), "{text}");
    let json = run(&["pressed.png", "--json"]).ok().json();
    is_near(&json["files"][0]["deepest_mm"], 2.0 * 2.0 * 23.0 / 47.0);
    // The blur carries the square's edges outwards.
    let contact_px = json["files"][0]["contact_px"].as_u64().unwrap();
    assert!((40 * 40..44 * 44).contains(&contact_px), "{contact_px}");
    assert_eq!(json["network"]["parameters"], 2);
    assert_eq!(json["constants"], serde_json::json!([]));
    // Nothing of marks, and that is said.
    assert!(json["marks"].is_null() && json["files"][0]["marks_seen"].is_null());
    assert_eq!(json["left_out"], serde_json::json!(["`rtac0` has no markers to track"]));
    assert!(!text.contains("no markers to track"), "{text}");
    // A card says something else.
    let card = |more: serde_json::Value| {
        let mut card = serde_json::json!({
            "format": "fabkit-network-card", "version": 1, "sensor": "rtac0",
            "design_hash": "0", "training": "nothing", "output_mm": 1.0,
            "input": { "blur_px": 1, "blur_sigma_px": 1.0, "offset_grey": 1.0, "maximum_grey": 50.0 },
        });
        card.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        write("net.json", card.to_string().as_bytes());
    };
    card(serde_json::json!({}));
    let text = run(&["pressed.png"]).ok().stdout;
    assert!(text.contains("warning: net.onnx was trained for another design"), "{text}");
    assert!(text.contains("net.onnx was trained for rtac0 on nothing"), "{text}");
    // All of the darker image counts as contact without a comparison: that is said.
    let found = run(&["pressed.png", "darker.png", "--force", "--json"]);
    assert_eq!(found.code, Some(0), "{}", found.stderr);
    let json = found.json();
    assert_eq!(json["plausibility"]["findings"][0]["code"], "contact_everywhere");
    is_near(&json["files"][0]["deepest_mm"], 2.0 * 25.0 / 50.0);
    assert_eq!(json["files"][0]["contact_px"], 1600);
    assert_eq!(json["files"][1]["contact_px"], 640 * 480);
    card(serde_json::json!({ "mask": { "center_px": [319.5, 239.5], "radius_px": 10.0 } }));
    let json = run(&["pressed.png", "--json"]).ok().json();
    assert_eq!(json["files"][0]["contact_px"], 316);
    let input = serde_json::json!({
        "blur_px": 1, "blur_sigma_px": 1.0, "offset_grey": 1.0, "maximum_grey": 50.0, "as_bright_as_rest": true,
    });
    card(serde_json::json!({ "input": input }));
    let json = run(&["darker.png", "--json"]).ok().json();
    assert_eq!(json["files"][0]["contact_px"], 1600);
    is_near(&json["files"][0]["brighter"], 0.95);
    // What is none.
    for (file, bytes, told) in [
        ("net.json", &b"{}"[..], "net.json is not of the format fabkit-network-card 1"),
        ("net.json", b"[", "net.json is no JSON"),
        ("net.onnx", b"none", "net.onnx: this is no ONNX file"),
    ] {
        write(file, bytes);
        let failed = run(&["pressed.png", "--json"]);
        assert_eq!(failed.code, Some(2));
        let problem = &failed.json()["problems"][0];
        assert_eq!(problem["code"], "bad_network");
        assert!(problem["message"].as_str().unwrap().contains(told), "{problem}");
    }
    let strided = double.with_attribute("strides", &[2, 2]);
    write("net.onnx", &write_chain(&[strided]));
    assert!(run(&["pressed.png"]).stderr.contains("node 1 `n0`: Conv with strides [2, 2]"));
}

#[test]
fn what_cannot_be_reconstructed_is_refused_by_name() {
    let root = tempfile::tempdir().unwrap();
    let small = grey_png([100, 80], 0.5);
    let dark = grey_png([640, 480], 0.0);
    std::fs::write(root.path().join("small.png"), small).unwrap();
    std::fs::write(root.path().join("dark.png"), dark).unwrap();
    std::fs::write(root.path().join("square.png"), grey_png([400, 400], 0.5)).unwrap();
    std::fs::create_dir(root.path().join("other")).unwrap();
    std::fs::copy(root.path().join("dark.png"), root.path().join("other/dark.png")).unwrap();
    for (words, told) in [
        (
            &["rtac0", "dark.png", "--reference", "small.png"][..],
            "100 x 80 px; the camera takes 640 x 480 px",
        ),
        (&["rtac0", "small.png", "--reference", "dark.png"], "no image of the lit surface at rest"),
        (&["uvdtact", "dark.png", "--reference", "small.png"], "the camera takes 400 x 400 px"),
        (
            &["uvdtact", "square.png", "--reference", "square.png", "--light", "uv"],
            "this image has no colours, which tell light sources and layers apart",
        ),
        (&["digit-like", "dark.png", "--reference", "dark.png"], "this image has no colours"),
        (
            &["rtac0", "dark.png", "other/dark.png", "--reference", "dark.png"],
            "would both be written as dark.npz",
        ),
    ] {
        let run = fabkit(root.path(), &[&["reconstruct"], words, &["-o", "out"]].concat());
        assert_ne!(run.code, Some(0));
        assert!(run.stderr.contains(told), "{}", run.stderr);
    }
    assert!(!root.path().join("out").exists());
}
