//! Findings about cameras that no lens maker could have built: units, sizes and lens models that were mistaken.
//!
//! A camera can be valid by its numbers and still be none: a matrix in metres, a calibration at another image size, a
//! polynomial that folds back inside the image. [`plausibility`] compares the parameters with the image. Camera files
//! go through it when they are read ([`crate::files`]).

use std::fmt;

use nalgebra::{Point2, Vector3};

use crate::camera::Camera;
use crate::lens::{Intrinsics, Lens};

/// Largest ratio of half the image's short side to the focal length of a pinhole: tan 85 degrees. The widest rectilinear
/// lenses on sale have 65 degrees over the diagonal.
const MAX_PINHOLE_RATIO: f64 = 11.43;
/// Ratio above which a pinhole is unusual: tan 70 degrees.
const UNUSUAL_PINHOLE_RATIO: f64 = 2.75;
/// Largest ratio for models that reach behind the lens. There the circle of a 180 degree lens, of radius pi / 2 focal
/// lengths, has a fifth of the image's height, less than any fisheye on its sensor.
const MAX_FISHEYE_RATIO: f64 = 8.0;
/// Smallest ratio of half the image's diagonal to the focal length: tan 1 degree, a field of view of two degrees.
const MIN_DIAGONAL_RATIO: f64 = 0.017_455;
/// Ratio of `fx` and `fy` above which pixels are unusual; pixels binned in one direction reach 2.
const UNUSUAL_ASPECT: f64 = 1.5;
/// Largest ratio of `fx` and `fy`.
const MAX_ASPECT: f64 = 4.0;
/// Distance of the principal point from the centre, in image sizes, above which it is unusual. A calibration at half
/// the size puts it at 0.25, real lenses and their mounts at up to 0.1.
const UNUSUAL_OFFSET: f64 = 0.2;
/// Distance in both directions above which the principal point lies in a corner. At twice the size it is at 0.5.
const CORNER_OFFSET: f64 = 0.4;
/// Distance in one direction above which the principal point lies on the border, as for calibrations at twice the width
/// and another aspect ratio.
const BORDER_OFFSET: f64 = 0.45;
/// Incidence angle, radians, from which a lens may have a round image smaller than the picture: 80 degrees.
const FISHEYE_RAD: f64 = 1.396;
/// Largest deviation, as a ratio, of two scales that count as one.
const SAME_SCALE: f64 = 0.1;
/// Number of rows and columns of the grid on which pixels without ray are counted: shares to about 1 %.
const GRID: u32 = 100;

/// Finding about a camera's parameters in relation to its image.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CameraFinding {
    /// The focal length is too short for the image: the lens would see more than its model can.
    FocalTooShort {
        /// Focal lengths and principal point.
        intrinsics: Intrinsics,
        /// Half of the image's short side in focal lengths.
        ratio: f64,
        /// Largest possible ratio.
        max_ratio: f64,
        /// Image size, px.
        size_px: [u32; 2],
    },
    /// The focal length is too long: the field of view is narrower than that of a telescope.
    FieldTooNarrow {
        /// Focal length on the axis, px.
        focal_px: f64,
        /// Field of view over the diagonal, radians.
        field_rad: f64,
    },
    /// A pinhole with an unusually wide field of view.
    WidePinhole {
        /// Focal length on the axis, px.
        focal_px: f64,
        /// Field of view over the short side without distortion, radians.
        field_rad: f64,
    },
    /// The focal lengths of columns and rows differ more than those of square pixels.
    UnevenFocal {
        /// Focal length of columns, px.
        fx_px: f64,
        /// Focal length of rows, px.
        fy_px: f64,
    },
    /// The principal point lies outside the image, in a corner, or far from the centre.
    OffCentre {
        /// Focal lengths and principal point.
        intrinsics: Intrinsics,
        /// Image size, px.
        size_px: [u32; 2],
    },
    /// The radius stops growing with the angle inside the image: pixels beyond have no ray.
    FoldsBack {
        /// Distance from the principal point at which the radius stops growing, px.
        radius_px: f64,
        /// Incidence angle there, radians.
        angle_rad: f64,
        /// Share of the image's pixels that lie beyond.
        lost: f64,
        /// Half of the image's short side, px.
        half_side_px: f64,
    },
}

/// Compares a camera's parameters with its image. Returns nothing for an ordinary camera; the most basic finding is
/// first.
///
/// ```
/// use fabkit_camera::{Camera, Interface, Intrinsics, Lens, OpenCv, plausibility};
///
/// // A camera matrix in metres.
/// let intrinsics = Intrinsics { fx_px: 0.0036, fy_px: 0.0036, cx_px: 0.00192, cy_px: 0.00144 };
/// let lens = Lens::OpenCv(OpenCv::new(intrinsics, &[])?);
/// let findings = plausibility(&Camera::new(640, 480, lens, Interface::None)?);
/// assert!(findings[0].is_impossible());
/// assert!(findings[0].hint().contains("6 um give 600 px"));
/// # Ok::<(), fabkit_camera::InvalidCamera>(())
/// ```
pub fn plausibility(camera: &Camera) -> Vec<CameraFinding> {
    let lens = camera.lens();
    let intrinsics = lens.intrinsics();
    let size_px = [camera.width_px(), camera.height_px()];
    let [width, height] = size_px.map(f64::from);
    let half_side_px = 0.5 * width.min(height);
    let focal_px = axial_focal_px(lens);
    let ratio = half_side_px / focal_px;
    let is_pinhole = matches!(lens, Lens::OpenCv(_));
    let max_ratio = if is_pinhole { MAX_PINHOLE_RATIO } else { MAX_FISHEYE_RATIO };
    // Whatever else looks wrong with a matrix in other units follows from the units.
    if ratio > max_ratio {
        return vec![CameraFinding::FocalTooShort { intrinsics, ratio, max_ratio, size_px }];
    }
    let diagonal_ratio = 0.5 * width.hypot(height) / focal_px;
    if diagonal_ratio < MIN_DIAGONAL_RATIO {
        return vec![CameraFinding::FieldTooNarrow {
            focal_px,
            field_rad: 2.0 * diagonal_ratio.atan(),
        }];
    }
    let mut findings = Vec::new();
    if is_pinhole && ratio > UNUSUAL_PINHOLE_RATIO {
        findings.push(CameraFinding::WidePinhole { focal_px, field_rad: 2.0 * ratio.atan() });
    }
    let Intrinsics { fx_px, fy_px, .. } = intrinsics;
    if (fx_px / fy_px).max(fy_px / fx_px) > UNUSUAL_ASPECT {
        findings.push(CameraFinding::UnevenFocal { fx_px, fy_px });
    }
    let offset = offsets(&intrinsics, size_px);
    if offset[0].max(offset[1]) > UNUSUAL_OFFSET || is_exchanged(&intrinsics, size_px) {
        findings.push(CameraFinding::OffCentre { intrinsics, size_px });
    }
    findings.extend(find_fold(lens, size_px, half_side_px));
    findings
}

impl CameraFinding {
    /// Returns whether no camera has these values. Other findings are unusual, but possible.
    pub fn is_impossible(&self) -> bool {
        match self {
            Self::FocalTooShort { .. } | Self::FieldTooNarrow { .. } => true,
            Self::WidePinhole { .. } => false,
            Self::UnevenFocal { fx_px, fy_px } => (fx_px / fy_px).max(fy_px / fx_px) > MAX_ASPECT,
            Self::OffCentre { intrinsics, size_px } => {
                let [across, down] = offsets(intrinsics, *size_px);
                across.max(down) > BORDER_OFFSET || across.min(down) > CORNER_OFFSET
            }
            // The polynomials of wide lenses often fold in the image's corners, and round images of fisheyes leave them
            // dark. A model that ends before it reaches the nearest border describes neither.
            Self::FoldsBack { radius_px, angle_rad, half_side_px, .. } => {
                radius_px < half_side_px && *angle_rad < FISHEYE_RAD
            }
        }
    }

    /// Name of the first parameter at fault, as in [`Camera::parameters`].
    pub fn parameter(&self) -> &'static str {
        match self {
            Self::OffCentre { intrinsics, size_px } => {
                let [across, down] = offsets(intrinsics, *size_px);
                if down > across { "cy_px" } else { "cx_px" }
            }
            Self::FoldsBack { .. } => "k1",
            _ => "fx_px",
        }
    }

    /// Returns what may have gone wrong, and what to do.
    pub fn hint(&self) -> String {
        match self {
            Self::FocalTooShort { intrinsics, size_px, .. } => unit_hint(intrinsics, *size_px),
            Self::FieldTooNarrow { .. } => {
                "is the focal length in micrometres, or the image size that of a part of the image?"
                    .into()
            }
            Self::WidePinhole { .. } => {
                "is the focal length in millimetres? Divide it by the pixel pitch".into()
            }
            Self::UnevenFocal { .. } => "pixels are square on nearly all cameras; are fx and fy \
                                         the first and fifth number of the camera matrix?"
                .into(),
            Self::OffCentre { intrinsics, size_px } => size_hint(intrinsics, *size_px),
            Self::FoldsBack { .. } => "are the coefficients those of this model? Calibrate with \
                                       images that fill the corners"
                .into(),
        }
    }
}

impl fmt::Display for CameraFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FocalTooShort {
                intrinsics: Intrinsics { fx_px, .. }, ratio, max_ratio, ..
            } => {
                write!(
                    f,
                    "a focal length of {fx_px} px: half of the image's short side is {ratio:.1} \
                     of them; at most {max_ratio} are possible"
                )
            }
            Self::FieldTooNarrow { focal_px, field_rad } => write!(
                f,
                "a focal length of {focal_px:.1} px: a field of view of {:.2} degrees over the \
                 diagonal; at least 2 are expected",
                field_rad.to_degrees()
            ),
            Self::WidePinhole { focal_px, field_rad } => write!(
                f,
                "a focal length of {focal_px:.1} px: a pinhole with a field of view of {:.0} \
                 degrees over the image's short side; at most 140 are usual",
                field_rad.to_degrees()
            ),
            Self::UnevenFocal { fx_px, fy_px } => {
                write!(f, "focal lengths of {fx_px} px along rows and {fy_px} px along columns")
            }
            Self::OffCentre { intrinsics, size_px: [width, height] } => {
                let [across, down] = offsets(intrinsics, [*width, *height]);
                let Intrinsics { cx_px, cy_px, .. } = intrinsics;
                let place = if across.max(down) >= 0.5 {
                    "outside"
                } else if across.min(down) > CORNER_OFFSET {
                    "in a corner of"
                } else if across.max(down) > BORDER_OFFSET {
                    "on the border of"
                } else {
                    "far from the centre of"
                };
                write!(
                    f,
                    "the principal point ({cx_px:.1}, {cy_px:.1}) lies {place} the image, {width} x {height} px"
                )
            }
            Self::FoldsBack { radius_px, angle_rad, lost, .. } => write!(
                f,
                "the lens model's radius grows up to {radius_px:.0} px ({:.1} degrees); {:.1} % of the \
                 image's pixels lie beyond and have no ray",
                angle_rad.to_degrees(),
                (100.0 * lost).max(0.1)
            ),
        }
    }
}

/// Computes the pixels per radian on the axis. In the double sphere model `fx_px` is not that.
fn axial_focal_px(lens: &Lens) -> f64 {
    const STEP: f64 = 1e-5;
    let Intrinsics { fx_px, fy_px, cx_px, cy_px } = lens.intrinsics();
    let at = |x, y| lens.project(&Vector3::new(x, y, 1.0)).ok();
    match (at(STEP, 0.0), at(0.0, STEP)) {
        (Some(right), Some(below)) => {
            (((right.x - cx_px) / STEP) * ((below.y - cy_px) / STEP)).abs().sqrt()
        }
        _ => (fx_px * fy_px).sqrt(),
    }
}

/// Returns the distances of the principal point from the image's centre, in image sizes.
fn offsets(intrinsics: &Intrinsics, size_px: [u32; 2]) -> [f64; 2] {
    let [width, height] = size_px.map(f64::from);
    let offset = |centre_px: f64, size: f64| ((centre_px + 0.5) / size - 0.5).abs();
    [offset(intrinsics.cx_px, width), offset(intrinsics.cy_px, height)]
}

/// Returns whether the principal point is off the centre, and would not be if width and height were exchanged.
fn is_exchanged(intrinsics: &Intrinsics, [width, height]: [u32; 2]) -> bool {
    let least = |of: [f64; 2]| of[0].min(of[1]);
    let most = |of: [f64; 2]| of[0].max(of[1]);
    least(offsets(intrinsics, [width, height])) > 0.08
        && most(offsets(intrinsics, [height, width])) < 0.04
}

/// Finds out whether the radius stops growing inside the image.
fn find_fold(lens: &Lens, [width, height]: [u32; 2], half_side_px: f64) -> Option<CameraFinding> {
    let is_lost = |x: f64, y: f64| lens.unproject(&Point2::new(x, y)).is_err();
    let [right, bottom] = [width, height].map(|px| f64::from(px) - 1.0);
    let corners = [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)];
    if !corners.iter().any(|(x, y)| is_lost(*x, *y)) {
        return None;
    }
    let [columns, rows] = [width, height].map(|px| px.min(GRID));
    let centre =
        |i: u32, count: u32, px: u32| (f64::from(i) + 0.5) * f64::from(px) / f64::from(count) - 0.5;
    let mut lost = 0u32;
    for row in 0..rows {
        let y = centre(row, rows, height);
        lost += (0..columns).map(|i| u32::from(is_lost(centre(i, columns, width), y))).sum::<u32>();
    }
    let angle_rad = lens.angle_limit_rad();
    // Just inside, where rounding cannot put the direction beyond the limit.
    let (sin, cos) = (angle_rad * (1.0 - 1e-9)).sin_cos();
    let Intrinsics { cx_px, cy_px, .. } = lens.intrinsics();
    let rim = lens.project(&Vector3::new(sin, 0.0, cos)).ok()?;
    let radius_px = (rim.x - cx_px).hypot(rim.y - cy_px);
    let lost = f64::from(lost) / f64::from(columns * rows);
    Some(CameraFinding::FoldsBack { radius_px, angle_rad, lost, half_side_px })
}

/// Suggests the unit of a camera matrix that is not in pixels.
fn unit_hint(intrinsics: &Intrinsics, size_px: [u32; 2]) -> String {
    let [width, height] = size_px.map(f64::from);
    let Intrinsics { fx_px, cx_px, cy_px, .. } = *intrinsics;
    if [cx_px, cy_px].iter().all(|centre| (centre - 0.5).abs() < 0.2) {
        return format!(
            "is the matrix divided by the image's size? Multiply fx and cx by {width}, fy and cy \
             by {height}, and subtract 0.5 from cx and cy"
        );
    }
    // The principal point is near the centre: that gives the pitch in the matrix's unit.
    let pitch = 2.0 * cx_px / width;
    for (unit, per_unit_um, more) in [("metres", 1e6, "m"), ("millimetres", 1e3, "mm")] {
        let pitch_um = pitch * per_unit_um;
        // Pixels of cameras have 0.5 to 20 um.
        if (0.5..=20.0).contains(&pitch_um) {
            let focal_px = fx_px / pitch;
            return format!(
                "is the matrix in {unit}? Divide it by the pixel pitch in {more}: {} um give {} px",
                rounded(pitch_um),
                rounded(focal_px)
            );
        }
    }
    let unit = if fx_px < 0.3 { "metres" } else { "millimetres" };
    format!("is it in {unit}? Divide it by the pixel pitch in {unit}")
}

/// Rounds to four digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// Suggests the image size that a principal point belongs to.
fn size_hint(intrinsics: &Intrinsics, size_px: [u32; 2]) -> String {
    let [width, height] = size_px.map(f64::from);
    let Intrinsics { fx_px, cx_px, cy_px, .. } = *intrinsics;
    let [across, down] = [(2.0 * cx_px + 1.0) / width, (2.0 * cy_px + 1.0) / height];
    if across.abs().max(down.abs()) < SAME_SCALE {
        return format!(
            "is it measured from the image's centre? Add {} to cx and {} to cy",
            0.5 * (width - 1.0),
            0.5 * (height - 1.0)
        );
    }
    if is_exchanged(intrinsics, size_px) {
        return format!(
            "are width and height exchanged? The image would have {height} x {width} px"
        );
    }
    let is_same = |a: f64, b: f64| (a / b - 1.0).abs() < SAME_SCALE;
    let known = [0.125, 0.25, 1.0 / 3.0, 0.5, 2.0, 3.0, 4.0, 8.0];
    let scale = known.into_iter().find(|scale| is_same(across, *scale) && is_same(down, *scale));
    if let Some(scale) = scale {
        return format!(
            "calibrated at {} x {} px? Then fx = {} and cx = (cx + 0.5) * {} - 0.5, fy and cy as \
             well; or state that size",
            (width * scale).round(),
            (height * scale).round(),
            rounded(fx_px / scale),
            rounded(1.0 / scale)
        );
    }
    if across > 0.0 && down > 0.0 {
        return format!(
            "it is the centre of an image of about {:.0} x {:.0} px; calibrated at that size, or \
             is the image a part of a larger one?",
            across * width,
            down * height
        );
    }
    "is the image a part of a larger one, or cx measured from another corner?".into()
}
