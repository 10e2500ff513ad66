//! Input files of the disturbed commands.

use std::fmt::Write;

pub const CAMERA: &str = "fabkit_camera: 1\nwidth_px: 96\nheight_px: 72\nlens:\n  \
                      model: kannala-brandt\n  fx_px: 43\n  fy_px: 43\n  cx_px: 47.5\n  \
                      cy_px: 35.5\n  k1: 0\n  k2: 0\n  k3: 0\n  k4: 0\n";
pub const SWEEP: &str = "format: 1\nsensor: rtac0\naxes:\n  camera.depth: {from: 6 mm, to: 8 mm, \
                     steps: 3}\nmetrics: [marker_count]\n";

/// Simulates corners of the exported board, which has 25 corners in a row, 10 mm apart, the first at (10, 10) mm: six
/// views by an equidistant lens with a focal length of 286 px.
pub fn corners() -> String {
    let mut text = String::from("view,corner,x_px,y_px\n");
    for view in 0..6 {
        let (turn, tilt) = (f64::from(view) * 1.1, 0.3 + 0.05 * f64::from(view));
        for (column, row) in (0..28).map(|i| (4 * (i % 7), 5 * (i / 7))) {
            let (x, y) = (f64::from(column) * 10.0 - 120.0, f64::from(row) * 10.0 - 75.0);
            let (u, v) = (x * turn.cos() - y * turn.sin(), x * turn.sin() + y * turn.cos());
            let (y, z) = (v * tilt.cos(), 170.0 + v * tilt.sin());
            let (r, angle) = (u.hypot(y).max(1e-9), u.hypot(y).atan2(z));
            let (px, py) = (319.5 + 286.0 * angle * u / r, 239.5 + 286.0 * angle * y / r);
            let _ = writeln!(text, "view {view},{},{px:.4},{py:.4}", row * 25 + column);
        }
    }
    text
}

/// Formats a camera file of 640 x 480 px with an equidistant lens.
pub fn camera_file(focal_px: f64) -> String {
    format!(
        "fabkit_camera: 1\nwidth_px: 640\nheight_px: 480\nlens:\n  model: kannala-brandt\n  \
         fx_px: {focal_px}\n  fy_px: {focal_px}\n  cx_px: 319.5\n  cy_px: 239.5\n  k1: 0\n  k2: \
         0\n  k3: 0\n  k4: 0\n"
    )
}

/// Simulates captures of 29 pins on a dome: their ends as a JSON map, and a list of marks. The camera is that of
/// [`camera_file`] with 229.18 px, five pins are visible in each of six captures, and marks are off by some tenths of a
/// pixel.
pub fn captures() -> (String, String) {
    let holes = [
        [1, 2, 6, 14, 22],
        [1, 3, 8, 17, 25],
        [1, 5, 12, 20, 28],
        [2, 4, 9, 16, 23],
        [1, 7, 11, 18, 27],
        [3, 10, 13, 15, 24],
    ];
    let mut ends = Vec::new();
    for (polar_deg, count) in [(0.0_f64, 1), (18.0, 4), (36.0, 8), (54.0, 8), (72.0, 8)] {
        for k in 0..count {
            let (s, c) = polar_deg.to_radians().sin_cos();
            let (sa, ca) = (f64::from(k) * std::f64::consts::TAU / f64::from(count)).sin_cos();
            ends.push([14.5 * s * ca, 14.5 * s * sa, 6.0 + 14.5 * c]);
        }
    }
    let entries = ends.iter().enumerate();
    let entries: Vec<String> =
        entries.map(|(i, [x, y, z])| format!("\"{}\": [{x:.4}, {y:.4}, {z:.4}]", i + 1)).collect();
    let mut text = String::from("file,hole,x_px,y_px\n");
    let (turn_s, turn_c) = 91.0_f64.to_radians().sin_cos();
    for (capture, holes) in holes.iter().enumerate() {
        for hole in holes {
            let [x, y, z] = ends[hole - 1];
            let (u, v) = (x * turn_c - y * turn_s + 0.4, x * turn_s + y * turn_c - 0.3);
            let (r, angle) = (u.hypot(v), u.hypot(v).atan2(z + 7.5));
            let phase = 12.9 * *hole as f64 + 78.2 * capture as f64;
            let (px, py) = (319.5 + 229.18 * angle * u / r, 239.5 + 229.18 * angle * v / r);
            let (px, py) = (px + 0.2 * phase.sin(), py + 0.2 * phase.cos());
            let _ = writeln!(text, "{capture}.png,{hole},{px:.3},{py:.3}");
        }
    }
    (format!("{{{}}}", entries.join(", ")), text)
}
