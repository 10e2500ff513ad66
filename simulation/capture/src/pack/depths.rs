//! Tables of depth by intensity for lightings that show thickness, as measured with a ball on a real unit.

use fabkit_export::{NpyValues, npy};
use fabkit_files::Error;
use fabkit_geometry::{Lighting, Scratch, TouchSurface};
use fabkit_scene::SensorView;
use serde_json::json;

use super::super::LightConstants;
use super::super::layers::LayerScene;
use super::super::thickness_change::{BALL_MM, Place, ThicknessChange};
use super::{OpticsPack, array, background_png, file, npz_file, render_at_rest};

/// Gain of intensity over rest at which the table begins.
const MAX_GAIN: i32 = 32;

pub(super) fn depth_pack(
    scene: &SensorView,
    lighting: &Lighting,
    constants: &LightConstants,
) -> Result<OpticsPack, Error> {
    let image = render_at_rest(scene, lighting, constants, |_| Ok(()))?;
    let sensor = &scene.project.design.sensor;
    let layers = LayerScene::new(sensor, lighting, constants)?;
    let touch = scene.touch()?;
    let thins = ThicknessChange::compute(&layers, sensor)?;
    let places = thins.places();
    let curves: Vec<Vec<f64>> =
        places.iter().map(|place| layers.thickness_loss_curve(&place.at)).collect();
    let longest = curves.iter().map(Vec::len).max().unwrap_or(0);
    let grey: Vec<f64> = (0..longest as i32).map(|k| f64::from(k - MAX_GAIN)).collect();
    // Curves end where no layer is left; NaN fills the rest of the rectangular table.
    let at = |curve: &[f64], k: usize| curve.get(k).copied().unwrap_or(f64::NAN);
    let rows = || curves.iter().map(|curve| (0..longest).map(|k| at(curve, k)));
    let thinner_mm: Vec<f64> = rows().flatten().collect();
    // Depth is the loss of thickness divided by the loss per millimetre of indentation.
    let depth_mm =
        rows().zip(places).flat_map(|(row, place)| row.map(move |mm| mm / place.loss_per_mm));
    let depth_mm: Vec<f64> = depth_mm.collect();
    let arrays = [
        array(
            "polar_deg",
            &[places.len()],
            NpyValues::F64(places.iter().map(|place| place.polar_deg).collect()),
        ),
        array("darker_grey", &[longest], NpyValues::F64(grey)),
        array("thinner_mm", &[places.len(), longest], NpyValues::F64(thinner_mm)),
        array("depth_mm", &[places.len(), longest], NpyValues::F64(depth_mm)),
    ];
    let mut files = vec![
        file("background.png", background_png(&image)?),
        npz_file("grey_to_depth.npz", &arrays)?,
    ];
    // 9DTact's own table starts at the intensity at rest and knows a single curve, so it only exists for pads.
    if let (TouchSurface::Plane(_), [curve]) = (touch, &curves[..]) {
        let deeper =
            curve[MAX_GAIN as usize..].iter().map(|mm| mm / places[0].loss_per_mm).collect();
        let table =
            array("Pixel_to_Depth", &[curve.len() - MAX_GAIN as usize], NpyValues::F64(deeper));
        files.push(file("9dtact/Pixel_to_Depth.npy", npy(&table).map_err(Error::bug)?));
    }
    let deepest: Vec<usize> =
        curves.iter().map(|curve| curve.len() - 1 - MAX_GAIN as usize).collect();
    let document = json!({
        "shows": "thickness",
        "width_px": image.size_px[0],
        "height_px": image.size_px[1],
        "polar_deg": places.iter().map(|place| place.polar_deg).collect::<Vec<_>>(),
        "darkest_grey": deepest,
        "ball_radius_mm": BALL_MM,
        "thins_by": places.iter().map(|place| place.loss_per_mm).collect::<Vec<_>>(),
    });
    Ok(OpticsPack { files, document })
}

impl LayerScene<'_> {
    /// Returns the loss of the layers' thickness, mm, by loss of intensity in steps of 1: from [`MAX_GAIN`] above the
    /// intensity at rest down to where no layer is left.
    fn thickness_loss_curve(&self, (point, outward): &Place) -> Vec<f64> {
        let (law, layer_grey) = (self.constants.layer(), self.constants.layer_grey.value);
        let [path_mm, _] = self.scene.paths_mm(point, outward, 0.0);
        let thick_mm =
            self.scene.thickness_mm((point, outward), &mut Scratch::default(), &mut Vec::new());
        let thick_mm = thick_mm.unwrap_or(0.0);
        let all = self.exposure * self.scene.lit.irradiance(point) * layer_grey;
        let thinner_mm = |darker: i32| {
            let back = law.reflectance(path_mm) - f64::from(darker) / all;
            (back >= 0.0).then(|| thick_mm * (1.0 - law.thickness_mm(back) / path_mm))
        };
        (-MAX_GAIN..).map_while(thinner_mm).collect()
    }
}
