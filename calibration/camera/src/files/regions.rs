//! Parts of ROS's `camera_info` that say how images differ from those of the calibration.

use fabkit_text::YamlNode;

use super::YamlFault;
use super::fields::FieldReader;
use crate::lens::Intrinsics;

/// Applies the region of interest and the binning of a `camera_info`: its matrix belongs to the whole image at full
/// resolution. Returns the size of the images. Says what a rectification would change.
pub(super) fn apply(
    fields: &mut FieldReader,
    root: &YamlNode,
    (mut width, mut height): (u32, u32),
    intrinsics: &mut Intrinsics,
) -> (u32, u32) {
    note_rectification(fields, root);
    if let Some(region) = root.get("roi") {
        let mut side = |key: &str| region.get(key).map_or(0, |node| fields.pixels(node, "roi"));
        let [x, y, columns, rows] = ["x_offset", "y_offset", "width", "height"].map(&mut side);
        let fits = |first: u32, count: u32, all: u32| {
            first.checked_add(count).is_some_and(|end| end <= all)
        };
        // Zeros stand for the whole image.
        if columns > 0 && rows > 0 && [x, y, columns, rows] != [0, 0, width, height] {
            if !(fits(x, columns, width) && fits(y, rows, height)) {
                let message = format!(
                    "{columns} x {rows} px from ({x}, {y}) are no part of {width} x {height} px"
                );
                fields.fault(YamlFault::new(region.position, "roi", message));
                return (width, height);
            }
            (width, height) = (columns, rows);
            intrinsics.cx_px -= f64::from(x);
            intrinsics.cy_px -= f64::from(y);
            fields.note(format!(
                "the camera is that of the region of interest, {width} x {height} px"
            ));
        }
    }
    let mut binning =
        |key: &str| root.get(key).map_or(1, |node| fields.pixels(node, "binning").max(1));
    let [across, down] = [binning("binning_x"), binning("binning_y")];
    if [across, down] != [1, 1] {
        let bin = |focal: &mut f64, centre: &mut f64, by: u32| {
            let by = f64::from(by);
            *focal /= by;
            // The image's corner lies at -0.5, and stays there.
            *centre = (*centre + 0.5) / by - 0.5;
        };
        bin(&mut intrinsics.fx_px, &mut intrinsics.cx_px, across);
        bin(&mut intrinsics.fy_px, &mut intrinsics.cy_px, down);
        (width, height) = (width / across, height / down);
        fields.note(format!("the camera is that of the binned images, {width} x {height} px"));
    }
    (width, height)
}

/// Notes a rectification that is not the identity. Zeros stand for none.
fn note_rectification(fields: &mut FieldReader, root: &YamlNode) {
    let node = ["rectification_matrix", "R", "r"].iter().find_map(|key| root.get(key));
    let Some(node) = node else { return };
    let node = node.get("data").unwrap_or(node);
    let rows = node.items().iter();
    let values =
        rows.flat_map(|row| if row.is_list() { row.items() } else { std::slice::from_ref(row) });
    let values: Option<Vec<f64>> =
        values.map(|value| value.text().and_then(|text| text.parse().ok())).collect();
    let Some(values) = values else { return };
    let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let is_identity = values.len() == 9
        && values
            .iter()
            .zip(identity)
            .all(|(value, wanted): (&f64, f64)| (value - wanted).abs() < 1e-9);
    if !is_identity && values.iter().any(|value| *value != 0.0) {
        fields.note(
            "the rectification matrix is not used: the camera is that of the images before \
             rectification",
        );
    }
}

#[cfg(test)]
mod tests {
    use crate::files::read_file;

    const INFO: &str = "width: 640\nheight: 480\ndistortion_model: plumb_bob\nd: [0, 0, 0, 0, 0]\n\
        k: [500, 0, 319.5, 0, 500, 239.5, 0, 0, 1]\nr: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n\
        binning_x: 0\nbinning_y: 0\nroi: {x_offset: 0, y_offset: 0, height: 0, width: 0}\n";

    #[test]
    fn regions_and_bins_are_applied() {
        let whole = read_file(INFO, None).unwrap();
        assert_eq!(whole.warnings(), Vec::<String>::new());
        let binned = INFO.replace("binning_x: 0\nbinning_y: 0", "binning_x: 2\nbinning_y: 2");
        let binned = read_file(&binned, None).unwrap();
        let expected = whole.estimate.camera().resized([320, 240]).unwrap();
        assert_eq!(*binned.estimate.camera(), expected);
        assert_eq!(binned.warnings().len(), 1);
        let part = INFO.replace("0, height: 0, width: 0", "100, height: 300, width: 500");
        let part = part.replace("x_offset: 0", "x_offset: 90");
        let part = read_file(&part, None).unwrap();
        let expected = whole.estimate.camera().cropped([90, 100], [500, 300]).unwrap();
        assert_eq!(*part.estimate.camera(), expected);
        let beyond = INFO.replace("height: 0, width: 0", "height: 481, width: 500");
        let error = read_file(&beyond, None).unwrap_err().to_string();
        assert!(
            error.contains("roi: 500 x 481 px from (0, 0) are no part of 640 x 480"),
            "{error}"
        );
        let turned = read_file(&INFO.replace("r: [1, 0, 0, 0, 1", "r: [0, 1, 0, 1, 0"), None);
        assert!(turned.unwrap().warnings()[0].starts_with("the rectification matrix"));
    }
}
