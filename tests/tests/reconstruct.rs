//! Depth from pictures without a network, against the truth that the pictures were made of: simulated.

use std::path::Path;
use std::sync::Arc;

use fabkit_application::Error;
use fabkit_application::calibration::image::GreyImage;
use fabkit_application::capturing::{Capturing, LightConstants, lighting};
use fabkit_application::fixtures::Project;
use fabkit_application::ground_truth::Viewpoint;
use fabkit_application::pressing::{Contact, Linear};
use fabkit_application::reconstructing::{Reconstructor, Taken};
use fabkit_application::scene::{Cast, SensorView};
use fabkit_application::source::Source;
use fabkit_tests::fabkit;

/// A sensor whose camera takes its pictures.
struct Bench {
    project: Arc<Project>,
    scene: SensorView,
    constants: LightConstants,
}

/// A picture as the camera sends it, and the truth that it shows.
struct Shown {
    values: Vec<f32>,
    depth_mm: Vec<f64>,
    contact: Vec<bool>,
}

impl Bench {
    fn new(sensor: &str) -> Self {
        let project = Arc::new(Source::find(sensor).unwrap().load(&[]).unwrap());
        let viewpoint = Viewpoint::new(&project.design.sensor.camera, None, None).unwrap();
        let scene = SensorView::new(Arc::clone(&project), viewpoint).unwrap();
        let constants = LightConstants::of(&project.design.sensor);
        Self { project, scene, constants }
    }

    fn take(&self, press: Option<&str>) -> Shown {
        let finder = self.project.press_finder();
        let presses: Vec<_> = press.into_iter().map(|id| finder.press(id).unwrap()).collect();
        let cast = Cast {
            presses: &presses,
            samples: 1,
            contact: Contact::Linear(Linear::default()),
            shear_mm: [0.0; 2],
            print_sigma_mm: 0.0,
            allow_no_contact: true,
        };
        let lighting = lighting(&self.project.design.sensor, None).unwrap();
        let capturing = Capturing { cast, lighting, constants: &self.constants, seed: Some(3) };
        let (mut depth_mm, mut contact) = (Vec::new(), Vec::new());
        let captured = capturing
            .take(&self.scene, |seen| {
                depth_mm = seen.map.indentation_mm().collect();
                contact = seen.map.contact().collect();
                Ok::<_, Error>(())
            })
            .unwrap();
        let values = captured.grey.iter().map(|grey| (grey.round() / 255.0) as f32).collect();
        Shown { values, depth_mm, contact }
    }

    fn picture(&self, values: &[f32]) -> Taken {
        let camera = self.scene.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        let channels = values.len() / (size_px[0] * size_px[1]);
        Taken { size_px, channels, values: values.to_vec() }
    }

    fn knows(&self) -> Reconstructor {
        let rest = self.picture(&self.take(None).values);
        let light = lighting(&self.project.design.sensor, None).unwrap();
        Reconstructor::new(&self.scene, light, &self.constants, (Path::new("ref.png"), &rest))
            .unwrap()
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
fn depth_is_what_the_pictures_were_made_of() {
    for (sensor, press) in [
        ("rtac0", "hemisphere@30deg,120deg,1.2mm"),
        ("9dtact", "hemisphere@2mm,-3mm,1mm"),
        ("digit-like", "ball@3mm,2mm,0.6mm"),
    ] {
        let bench = Bench::new(sensor);
        let known = bench.knows();
        let shown = bench.take(Some(press));
        let found =
            known.reconstruct(Path::new("pressed.png"), bench.picture(&shown.values)).unwrap();
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
        assert!((found.brighter - 1.0).abs() < 0.01, "{}", found.brighter);
        // A picture that is brighter as a whole is the same press.
        let brighter: Vec<f32> = shown.values.iter().map(|value| (1.05 * value).min(1.0)).collect();
        let again = known.reconstruct(Path::new("brighter.png"), bench.picture(&brighter)).unwrap();
        assert!((again.brighter / found.brighter - 1.05).abs() < 0.005, "{}", again.brighter);
        let off = found.depth_mm.iter().zip(&again.depth_mm);
        assert!(mean(off.map(|(a, b)| f64::from((a - b).abs()))) < 0.02);
    }
}

fn grey_png([width, height]: [u32; 2], value: f32) -> Vec<u8> {
    GreyImage::new(width, height, vec![value; (width * height) as usize]).unwrap().to_png()
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
        (&["rtac0", "small.png", "--reference", "dark.png"], "no picture of it at rest"),
        (&["uvdtact", "dark.png", "--reference", "small.png"], "the camera takes 400 x 400 px"),
        (
            &["uvdtact", "square.png", "--reference", "square.png", "--light", "uv"],
            "shows something else",
        ),
        (&["digit-like", "dark.png", "--reference", "dark.png"], "this picture has no colours"),
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
