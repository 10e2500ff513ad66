//! Rendered images of boards from exact rays, as a truth that is independent of the detector.

use fabkit_calibration::board::{Board, BoardCorner, BoardKind};
use fabkit_calibration::image::GreyImage;
use fabkit_camera::{Camera, Interface, Intrinsics, KannalaBrandt, Lens, Point2, Point3, Vector3};
use fabkit_geometry::{Angle, Pose};

use fabkit_geometry::sequences::SplitMix64;

/// Returns a camera with 640 x 480 px and a little over 160 degrees along the diagonal, which deviates from an
/// equidistant lens as real ones do.
pub fn fisheye() -> Camera {
    let intrinsics = Intrinsics { fx_px: 281.3, fy_px: 280.6, cx_px: 322.7, cy_px: 236.2 };
    let lens = KannalaBrandt::new(intrinsics, [0.021, -0.011, 0.0035, -0.0006]).unwrap();
    Camera::new(640, 480, Lens::KannalaBrandt(lens), Interface::None).unwrap()
}

/// Returns a board with 4 x 4 bit markers that differ in at least three bits in every rotation, as those of OpenCV's
/// DICT_4X4_250 do.
pub fn charuco(squares: [u32; 2], square_mm: f64, marker_mm: f64) -> Board {
    let needed = Board::light_squares(squares).len();
    let mut random = SplitMix64::new(5);
    let mut chosen: Vec<[[u8; 4]; 4]> = Vec::new();
    let turn = |m: &[[u8; 4]; 4]| std::array::from_fn(|r| std::array::from_fn(|c| m[3 - c][r]));
    let distance = |a: &[[u8; 4]; 4], b: &[[u8; 4]; 4]| {
        a.iter().flatten().zip(b.iter().flatten()).filter(|(x, y)| x != y).count()
    };
    while chosen.len() < needed {
        let bits = random.bits();
        let marker =
            std::array::from_fn(|r| std::array::from_fn(|c| (bits >> (4 * r + c) & 1) as u8));
        let mut turned = marker;
        let apart = (0..4).all(|quarters| {
            let far = chosen.iter().all(|other| distance(other, &turned) >= 3);
            let unlike_itself = quarters == 0 || distance(&marker, &turned) >= 3;
            turned = turn(&turned);
            far && unlike_itself
        });
        if apart {
            chosen.push(marker);
        }
    }
    let row = |row: &[u8; 4]| row.iter().map(|bit| char::from(b'0' + bit)).collect();
    let bits: Vec<Vec<String>> = chosen.iter().map(|m| m.iter().map(row).collect()).collect();
    Board::charuco("test", squares, square_mm, marker_mm, "TEST_4X4", &bits).unwrap()
}

/// Degradation of a rendered image.
#[derive(Clone, Copy)]
pub struct Spoil {
    /// Standard deviation of the lens's blur, px.
    pub blur_px: f64,
    /// Standard deviation of the noise, where the full range is 1.
    pub noise: f64,
    /// Ratio of the intensity at the image's corner to that in the middle.
    pub falloff: f64,
}

pub const CLEAN: Spoil = Spoil { blur_px: 0.6, noise: 0.0, falloff: 1.0 };
pub const USUAL: Spoil = Spoil { blur_px: 0.8, noise: 0.01, falloff: 0.4 };

/// Camera with precomputed rays at the corners of all pixels.
pub struct Studio {
    pub camera: Camera,
    corners: Vec<Option<Vector3<f64>>>,
}

/// Number of samples along the side of a pixel.
const SAMPLES: usize = 5;

impl Studio {
    pub fn new(camera: Camera) -> Self {
        let (w, h) = (camera.width_px(), camera.height_px());
        let ray = |x: u32, y: u32| {
            let pixel = Point2::new(f64::from(x) - 0.5, f64::from(y) - 0.5);
            camera.unproject(&pixel).ok().map(|ray| ray.direction)
        };
        let corners = (0..=h).flat_map(|y| (0..=w).map(move |x| (x, y)));
        Self { camera, corners: corners.map(|(x, y)| ray(x, y)).collect() }
    }

    /// Projects the board's corners; `None` unless the camera sees them all.
    pub fn truth(&self, board: &Board, camera_from_board: &Pose) -> Option<Vec<Point2<f64>>> {
        board.corners.iter().map(|c| self.see(c.in_board_mm, camera_from_board)).collect()
    }

    /// Projects the corners that lie in the image, at least `margin_px` from its border.
    pub fn in_sight(
        &self,
        board: &Board,
        camera_from_board: &Pose,
        margin_px: f64,
    ) -> Vec<Option<Point2<f64>>> {
        let [w, h] = [self.camera.width_px(), self.camera.height_px()].map(f64::from);
        let inside = |p: &Point2<f64>| {
            p.x > margin_px && p.y > margin_px && p.x < w - margin_px && p.y < h - margin_px
        };
        let see = |corner: &BoardCorner| self.see(corner.in_board_mm, camera_from_board);
        board.corners.iter().map(|corner| see(corner).filter(inside)).collect()
    }

    pub fn see(&self, [x, y]: [f64; 2], camera_from_board: &Pose) -> Option<Point2<f64>> {
        self.camera.project(&camera_from_board.point(Point3::new(x, y, 0.0))).ok()
    }

    /// Returns whether the whole board, including outer squares, lies in the image, at least `margin_px` from its
    /// border, with its front to the camera.
    pub fn shows(&self, board: &Board, camera_from_board: &Pose, margin_px: f64) -> bool {
        let [w, h] = board.squares.map(|n| f64::from(n) * board.square_mm);
        let outline = (0..=20).flat_map(|i| {
            let t = f64::from(i) / 20.0;
            [[t * w, 0.0], [t * w, h], [0.0, t * h], [w, t * h]]
        });
        let normal = camera_from_board.vector(Vector3::z());
        let (width, height) =
            (f64::from(self.camera.width_px()), f64::from(self.camera.height_px()));
        outline.clone().all(|[x, y]| {
            let point = camera_from_board.point(Point3::new(x, y, 0.0));
            normal.dot(&point.coords) > 0.0
                && self.camera.project(&point).is_ok_and(|p| {
                    p.x > margin_px
                        && p.y > margin_px
                        && p.x < width - 1.0 - margin_px
                        && p.y < height - 1.0 - margin_px
                })
        })
    }

    /// Renders the image.
    pub fn picture(
        &self,
        board: &Board,
        camera_from_board: &Pose,
        spoil: Spoil,
        random: &mut SplitMix64,
    ) -> GreyImage {
        let (w, h) = (self.camera.width_px() as usize, self.camera.height_px() as usize);
        let board_from_camera = camera_from_board.inverse();
        let eye = board_from_camera.point(Point3::origin());
        let mut values = Vec::with_capacity(w * h);
        for y in 0..h {
            for x in 0..w {
                let corner = |dx: usize, dy: usize| self.corners[(y + dy) * (w + 1) + x + dx];
                let rays = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
                let [Some(a), Some(b), Some(c), Some(d)] = rays else {
                    values.push(0.0);
                    continue;
                };
                let [a, b, c, d] = [a, b, c, d].map(|ray| board_from_camera.vector(ray));
                let mut sum = 0.0;
                for j in 0..SAMPLES {
                    let v = (j as f64 + 0.5) / SAMPLES as f64;
                    let (left, right) = (a * (1.0 - v) + c * v, b * (1.0 - v) + d * v);
                    for i in 0..SAMPLES {
                        let u = (i as f64 + 0.5) / SAMPLES as f64;
                        let ray = left * (1.0 - u) + right * u;
                        let t = -eye.z / ray.z;
                        sum += if t > 0.0 {
                            paint(board, eye.x + t * ray.x, eye.y + t * ray.y)
                        } else {
                            0.3
                        };
                    }
                }
                let (dx, dy) = (x as f64 / w as f64 - 0.5, y as f64 / h as f64 - 0.5);
                let shade = 1.0 - (1.0 - spoil.falloff) * 2.0 * (dx * dx + dy * dy);
                values.push((sum / (SAMPLES * SAMPLES) as f64 * shade) as f32);
            }
        }
        let sharp = GreyImage::new(w as u32, h as u32, values).unwrap();
        let blurred = sharp.blurred(spoil.blur_px as f32);
        let noisy = blurred.values().iter().map(|v| {
            let noise = if spoil.noise > 0.0 { spoil.noise * random.normal() } else { 0.0 };
            ((f64::from(*v) + noise).clamp(0.0, 1.0) * 255.0).round() as f32 / 255.0
        });
        GreyImage::new(w as u32, h as u32, noisy.collect()).unwrap()
    }
}

/// Returns the intensity of the board's plane: the board, its white sheet, and a striped table around it.
fn paint(board: &Board, x_mm: f64, y_mm: f64) -> f64 {
    const DARK: f64 = 0.08;
    const LIGHT: f64 = 0.85;
    let (x, y) = (x_mm / board.square_mm, y_mm / board.square_mm);
    let [columns, rows] = board.squares.map(f64::from);
    if x < -0.8 || y < -0.8 || x > columns + 0.8 || y > rows + 0.8 {
        return if (0.37 * x + 0.61 * y).rem_euclid(2.0) < 0.5 { 0.25 } else { 0.4 };
    }
    if !(0.0..columns).contains(&x) || !(0.0..rows).contains(&y) {
        return LIGHT;
    }
    let (column, row) = (x.floor(), y.floor());
    let square = [column as u32, row as u32];
    let marker = board.markers.iter().find(|m| m.square == square);
    // Without markers the first square is dark; with them, those without one.
    if marker.is_none() && (!board.markers.is_empty() || (column + row) % 2.0 == 0.0) {
        return DARK;
    }
    let Some((marker_mm, marker)) = board.marker_mm.zip(marker) else { return LIGHT };
    let scale = marker_mm / board.square_mm;
    let fields = marker.bits.len() as f64 + 2.0;
    let field = |t: f64| (((t - t.floor()) - 0.5 * (1.0 - scale)) / scale * fields).floor();
    let (u, v) = (field(x), field(y));
    if u < 0.0 || v < 0.0 || u >= fields || v >= fields {
        return LIGHT;
    }
    let inner = 1.0..fields - 1.0;
    let is_light = inner.contains(&u)
        && inner.contains(&v)
        && marker.bits[v as usize - 1].as_bytes()[u as usize - 1] == b'1';
    if is_light { LIGHT } else { DARK }
}

/// Returns the pose of a board in front of the camera: its centre up to `off_axis_deg` off the optical axis, tilted by
/// up to `tilt_deg` against the line of sight, and turned by any angle.
pub fn somewhere(
    board: &Board,
    random: &mut SplitMix64,
    distance_mm: [f64; 2],
    off_axis_deg: f64,
    tilt_deg: f64,
) -> Pose {
    let angle = |rad: f64| Angle::from_rad(rad).unwrap();
    let z = |rad| Pose::rotation_z(angle(rad));
    let turn = |random: &mut SplitMix64| random.between(0.0, std::f64::consts::TAU);
    let [w, h] = board.squares.map(|n| f64::from(n) * board.square_mm);
    let centred = Pose::translation(-0.5 * w, -0.5 * h, 0.0);
    let tilt = Pose::rotation_x(angle(random.between(0.0, tilt_deg).to_radians()));
    let aside = Pose::rotation_x(angle(random.between(0.0, off_axis_deg).to_radians()));
    let away = Pose::translation(0.0, 0.0, random.between(distance_mm[0], distance_mm[1]));
    let parts = [z(turn(random)), aside, away, z(turn(random)), tilt, z(turn(random)), centred];
    parts.iter().fold(Pose::identity(), |all, part| all.then_in(*part))
}

/// Returns the kind of board in words.
pub fn word(board: &Board) -> &'static str {
    match board.kind {
        BoardKind::Checkerboard => "checkerboard",
        BoardKind::Charuco => "charuco",
    }
}

/// Writes an image as PNG, 8 bits.
pub fn save(image: &GreyImage, path: impl AsRef<std::path::Path>) {
    let file = std::fs::File::create(path).unwrap();
    let mut encoder = png::Encoder::new(file, image.width_px() as u32, image.height_px() as u32);
    encoder.set_color(png::ColorType::Grayscale);
    let bytes: Vec<u8> = image.values().iter().map(|v| (v * 255.0).round() as u8).collect();
    encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
}
