//! How deep a grey value is, where light shows how thick layers are: as with a ball on a real unit.

use fabkit_depth::truth::Yielding as _;
use fabkit_export::{Values, npy};
use fabkit_fixtures::PressBody;
use fabkit_geometry::{
    Lighting, Point3, Pose, Scratch, Solid, SurfacePoints, TouchSurface, Vector3,
};
use serde_json::json;

use super::super::LightConstants;
use super::super::layers::LayerScene;
use super::super::scene::middle_of;
use super::{OpticsPack, array, at_rest, background_png, file, npz_file};
use crate::Error;
use crate::pressing::{Ready, threads};
use crate::scene::SensorView;

/// Polar angles of the table on a dome, deg.
const POLAR_DEG: [f64; 8] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0];
/// So much brighter than at rest the table begins, grey.
const BRIGHTER: i32 = 32;
/// The ball that is pressed in, and how far, as a part of what is soft.
const BALL_MM: f64 = 2.5;
const PRESSED: f64 = 0.4;

type Place = (Point3<f64>, Vector3<f64>);

pub(super) fn pack(
    scene: &SensorView,
    lighting: &Lighting,
    constants: &LightConstants,
) -> Result<OpticsPack, Error> {
    let picture = at_rest(scene, lighting, constants, |_| Ok(()))?;
    let sensor = &scene.project.design.sensor;
    let layers = LayerScene::of(sensor, lighting, constants)?;
    let touch = scene.touch()?;
    let points = SurfacePoints::new(touch).map_err(Error::bug)?;
    let places: Vec<(f64, Place)> = match &points {
        SurfacePoints::Dome(dome) => {
            let place = |deg: f64| Some((deg, dome.towards(deg.to_radians(), 0.0)?));
            POLAR_DEG.into_iter().filter_map(place).collect()
        }
        SurfacePoints::Plane(_) => middle_of(touch).map(|place| (0.0, place)).into_iter().collect(),
    };
    let ready = Ready::for_all(sensor, None, threads())?;
    let thins = places.iter().map(|(_, place)| layers.thins(touch, &ready, place));
    let thins = thins.collect::<Result<Vec<f64>, Error>>()?;
    let curves: Vec<Vec<f64>> = places.iter().map(|(_, place)| layers.thinner_mm(place)).collect();
    let longest = curves.iter().map(Vec::len).max().unwrap_or(0);
    let grey: Vec<f64> = (0..longest as i32).map(|k| f64::from(k - BRIGHTER)).collect();
    let at = |curve: &[f64], k: usize| curve.get(k).copied().unwrap_or(f64::NAN);
    let rows = || curves.iter().map(|curve| (0..longest).map(|k| at(curve, k)));
    let thinner_mm: Vec<f64> = rows().flatten().collect();
    let depth_mm = rows().zip(&thins).flat_map(|(row, thins)| row.map(move |mm| mm / thins));
    let depth_mm: Vec<f64> = depth_mm.collect();
    let arrays = [
        array(
            "polar_deg",
            &[places.len()],
            Values::F64(places.iter().map(|(deg, _)| *deg).collect()),
        ),
        array("darker_grey", &[longest], Values::F64(grey)),
        array("thinner_mm", &[places.len(), longest], Values::F64(thinner_mm)),
        array("depth_mm", &[places.len(), longest], Values::F64(depth_mm)),
    ];
    let mut files = vec![
        file("background.png", background_png(&picture)?),
        npz_file("grey_to_depth.npz", &arrays)?,
    ];
    if let (SurfacePoints::Plane(_), [curve]) = (&points, &curves[..]) {
        let deeper = curve[BRIGHTER as usize..].iter().map(|mm| mm / thins[0]).collect();
        let table =
            array("Pixel_to_Depth", &[curve.len() - BRIGHTER as usize], Values::F64(deeper));
        files.push(file("9dtact/Pixel_to_Depth.npy", npy(&table).map_err(Error::bug)?));
    }
    let deepest: Vec<usize> =
        curves.iter().map(|curve| curve.len() - 1 - BRIGHTER as usize).collect();
    let document = json!({
        "shows": "thickness",
        "width_px": picture.size_px[0],
        "height_px": picture.size_px[1],
        "polar_deg": places.iter().map(|(deg, _)| *deg).collect::<Vec<_>>(),
        "darkest_grey": deepest,
        "ball_radius_mm": BALL_MM,
        "thins_by": thins,
    });
    Ok(OpticsPack { files, document })
}

impl LayerScene<'_> {
    /// By how much thinner layers are, mm, where they are [`BRIGHTER`] grey brighter than at rest, one less, and so on, to
    /// where nothing is left of them.
    fn thinner_mm(&self, (point, outward): &Place) -> Vec<f64> {
        let (law, layer_grey) = (self.constants.layer(), self.constants.layer_grey.value);
        let [path_mm, _] = self.scene.paths_mm(point, outward, 0.0);
        let thick_mm =
            self.scene.thickness_mm((point, outward), &mut Scratch::default(), &mut Vec::new());
        let thick_mm = thick_mm.unwrap_or(0.0);
        let all = self.exposure * self.scene.lit.at(point) * layer_grey;
        let thinner_mm = |darker: i32| {
            let back = law.reflectance(path_mm) - f64::from(darker) / all;
            (back >= 0.0).then(|| thick_mm * (1.0 - law.thickness_mm(back) / path_mm))
        };
        (-BRIGHTER..).map_while(thinner_mm).collect()
    }

    /// By how much thinner layers become for each millimetre that a ball is pressed in: what lies below them gives way, too.
    fn thins(
        &self,
        touch: &TouchSurface,
        ready: &Ready,
        (point, outward): &Place,
    ) -> Result<f64, Error> {
        let depth_mm = PRESSED * touch.soft_mm();
        let centre = point + (BALL_MM - depth_mm) * outward;
        let ball = PressBody {
            name: "ball".to_owned(),
            solid: Solid::sphere(BALL_MM),
            sensor_from_body: Pose::z_to(*outward, centre),
        };
        let answer = ready.answer(touch, &[ball], [0.0; 2], None)?;
        let outwards_mm = answer.outwards_mm(point, outward);
        let lower = answer.lower_face(self.scene.innermost());
        let lower_mm = lower.map_or(0.0, |lower| lower.outwards_mm(point));
        Ok(1.0 - lower_mm / outwards_mm)
    }
}
