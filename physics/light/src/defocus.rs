//! Defocus blur: a point out of focus is imaged as a disk.

use rayon::prelude::*;

/// Step of disk radii, in grid points. Its effect is below a thousandth of a brightness step.
const RADIUS_STEP: f64 = 1.0 / 64.0;

/// Number of strips by which the area of a pixel under a disk is summed.
const STRIPS: usize = 32;

/// Computes the diameter of the blur disk of a point for a thin lens, px. It is the cone from the pupil to the point,
/// cut by the plane in focus, as large as the camera images it there.
///
/// `focal_px` is the image length of one radian on the axis, that is, the distance of the chip (not the focal length)
/// divided by the pixel pitch. With the focal length f and the chip distance v = f s / (s - f) for a focus at s, it is
/// v / pitch, and the result equals the usual c = A f |x - s| / (x (s - f)) divided by the pitch.
///
/// ```
/// use fabkit_light::blur_diameter_px;
/// // f/2 of 4 mm, in focus at 50 mm, pixels of 3 um: a point at 25 mm.
/// let (focal_mm, pupil_mm, pitch_mm) = (4.0, 2.0, 0.003);
/// let chip_mm = focal_mm * 50.0 / (50.0 - focal_mm);
/// let usual_mm = pupil_mm * focal_mm * 25.0 / (25.0 * (50.0 - focal_mm));
/// let found = blur_diameter_px(pupil_mm, 50.0, 25.0, chip_mm / pitch_mm);
/// assert!((found - usual_mm / pitch_mm).abs() < 1e-9);
/// assert_eq!(blur_diameter_px(pupil_mm, 50.0, 50.0, 1000.0), 0.0);
/// ```
pub fn blur_diameter_px(pupil_mm: f64, focus_mm: f64, at_mm: f64, focal_px: f64) -> f64 {
    pupil_mm * focal_px * (at_mm.recip() - focus_mm.recip()).abs()
}

/// Blur of an image by disks, one width per point.
///
/// A uniform image stays uniform up to its edge: each value is a mean of the points whose disks reach it, weighted by
/// the disk area that lies there. Where neighbouring disks are equally wide, the total light is kept.
///
/// ```
/// use fabkit_light::Defocus;
///
/// // A bright point in the middle of 9 x 9 pixels, and disks of 3 px everywhere.
/// let mut light = vec![[0.0]; 81];
/// light[40] = [100.0];
/// let defocus = Defocus::new(&[3.0; 81], 9).ok_or("everything is sharp")?;
/// defocus.apply(&mut light);
/// // The middle keeps a pixel's share of the disk: 1 / (pi 1.5^2). No light is lost.
/// assert!((light[40][0] - 100.0 / (2.25 * std::f64::consts::PI)).abs() < 0.1);
/// assert!((light.iter().map(|[grey]| grey).sum::<f64>() - 100.0).abs() < 1e-9);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Debug)]
pub struct Defocus {
    width: usize,
    /// Largest radius of any disk, in grid points.
    reach: usize,
    /// Index of each point's disk.
    disk_indices: Vec<u32>,
    disks: Vec<Disk>,
    /// Reciprocal of the sum of weights at each point.
    shares: Vec<f64>,
}

/// Share of a disk in each pixel around its centre.
#[derive(Clone, Debug)]
struct Disk {
    reach: usize,
    weights: Vec<f64>,
}

impl Disk {
    /// Computes the weights of a disk, which sum to 1.
    fn new(radius: f64) -> Self {
        let reach = (radius - 0.5).ceil().max(0.0) as usize;
        let places = || (0..=2 * reach).map(|k| k as f64 - reach as f64);
        let mut weights: Vec<f64> =
            places().flat_map(|y| places().map(move |x| covered_area(radius, [x, y]))).collect();
        let sum: f64 = weights.iter().sum();
        // A disk of radius zero covers nothing and becomes a single point.
        if sum > 0.0 {
            weights.iter_mut().for_each(|weight| *weight /= sum)
        } else {
            weights = vec![1.0]
        }
        Self { reach, weights }
    }

    /// Returns the number of pixels along a side of the weights.
    fn side(&self) -> usize {
        2 * self.reach + 1
    }
}

/// Computes the area of the unit square around `[x, y]` that is covered by a disk around the origin.
fn covered_area(radius: f64, [x, y]: [f64; 2]) -> f64 {
    let strip = |k: usize| {
        // The strips divide only the disk if it is narrower than the square.
        let [from, to] = [(x - 0.5).max(-radius), (x + 0.5).min(radius)];
        let wide = (to - from).max(0.0) / STRIPS as f64;
        let across = from + (k as f64 + 0.5) * wide;
        let half = (radius * radius - across * across).max(0.0).sqrt();
        wide * ((y + 0.5).min(half) - (y - 0.5).max(-half)).max(0.0)
    };
    (0..STRIPS).map(strip).sum()
}

impl Defocus {
    /// Builds the blur of an image with `width` columns from the disk diameter of each point, row by row, in grid
    /// points. Returns `None` if everything is sharp.
    ///
    /// ```
    /// use fabkit_light::Defocus;
    ///
    /// // A disk within its pixel blurs nothing.
    /// assert!(Defocus::new(&[0.0, 0.5, 1.0, 0.5], 2).is_none());
    /// assert!(Defocus::new(&[0.0, 0.5, 2.0, 0.5], 2).is_some());
    /// ```
    pub fn new(diameters: &[f64], width: usize) -> Option<Self> {
        let step_of = |diameter: &f64| (diameter / 2.0 / RADIUS_STEP).round().max(0.0) as u32;
        let steps: Vec<u32> = diameters.iter().map(step_of).collect();
        // Only distinct radii need a disk.
        let mut known = steps.clone();
        known.sort_unstable();
        known.dedup();
        let disks: Vec<Disk> =
            known.par_iter().map(|step| Disk::new(f64::from(*step) * RADIUS_STEP)).collect();
        let reach = disks.iter().map(|disk| disk.reach).max().filter(|reach| *reach > 0)?;
        let disk_of = steps.iter().map(|step| known.partition_point(|k| k < step) as u32).collect();
        let mut own = Self { width, reach, disk_indices: disk_of, disks, shares: Vec::new() };
        // Blurring a uniform image yields the sum of weights at each point.
        let sums = own.sum_disks(&vec![[1.0]; steps.len()]);
        own.shares = sums.into_iter().map(|[sum]| sum.recip()).collect();
        Some(own)
    }

    /// Blurs an image in place.
    pub fn apply<const N: usize>(&self, light: &mut [[f64; N]]) {
        let spread = self.sum_disks(light);
        for ((light, spread), share) in light.iter_mut().zip(spread).zip(&self.shares) {
            *light = spread.map(|sum| sum * share);
        }
    }

    /// Sums the parts of all disks at each point, always in the same order.
    fn sum_disks<const N: usize>(&self, light: &[[f64; N]]) -> Vec<[f64; N]> {
        let (width, reach) = (self.width, self.reach);
        let height = light.len() / width.max(1);
        let around = |at: usize, end: usize| at.saturating_sub(reach)..(at + reach + 1).min(end);
        let place = |i: usize| {
            let (row, column) = (i / width, i % width);
            let mut sum = [0.0; N];
            for from_row in around(row, height) {
                for from_column in around(column, width) {
                    let from = from_row * width + from_column;
                    let disk = &self.disks[self.disk_indices[from] as usize];
                    let [down, right] = [row + disk.reach, column + disk.reach];
                    // The subtraction fails where the disk ends above or left of this point.
                    let (Some(down), Some(right)) =
                        (down.checked_sub(from_row), right.checked_sub(from_column))
                    else {
                        continue;
                    };
                    if down >= disk.side() || right >= disk.side() {
                        continue;
                    }
                    let weight = disk.weights[down * disk.side() + right];
                    for (sum, light) in sum.iter_mut().zip(&light[from]) {
                        *sum += weight * light;
                    }
                }
            }
            sum
        };
        (0..light.len()).into_par_iter().map(place).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 41;

    fn point() -> Vec<[f64; 1]> {
        let mut light = vec![[0.0]; WIDTH * WIDTH];
        light[WIDTH * WIDTH / 2] = [100.0];
        light
    }

    #[test]
    fn disks_have_the_stated_width_and_keep_light() {
        for diameter in [0.0, 0.75, 1.25, 4.0, 11.25, 20.5] {
            let mut light = point();
            if let Some(defocus) = Defocus::new(&vec![diameter; WIDTH * WIDTH], WIDTH) {
                defocus.apply(&mut light);
            }
            let sum: f64 = light.iter().map(|[grey]| grey).sum();
            assert!((sum - 100.0).abs() < 1e-9, "{diameter}: {sum}");
            // Columns hold the part of a uniform disk between their edges, in closed form: the half between the centre
            // and a is a sqrt(r^2 - a^2) + r^2 asin(a / r). Strips miss less than a thousandth in all.
            let radius = f64::max(diameter, 1e-9) / 2.0;
            let up_to = |a: f64| {
                let a = a.clamp(-radius, radius);
                a * (radius * radius - a * a).sqrt() + radius * radius * (a / radius).asin()
            };
            let whole = std::f64::consts::PI * radius * radius;
            for column in 0..WIDTH {
                let found: f64 = (0..WIDTH).map(|row| light[row * WIDTH + column][0]).sum();
                let x = column as f64 - (WIDTH / 2) as f64;
                let said = 100.0 * (up_to(x + 0.5) - up_to(x - 0.5)) / whole;
                assert!((found - said).abs() < 0.1, "{diameter}, {x}: {found}, {said}");
            }
        }
    }

    #[test]
    fn images_change_continuously_with_disk_width() {
        let seen = |diameter: f64| {
            let mut light = point();
            if let Some(defocus) = Defocus::new(&vec![diameter; WIDTH * WIDTH], WIDTH) {
                defocus.apply(&mut light);
            }
            light
        };
        // For a point of 100 and steps of 0.1 px: near a diameter of 1, the disk's area changes by a fifth.
        let mut before = seen(0.0);
        for step in 1..100 {
            let now = seen(0.1 * f64::from(step));
            let most =
                now.iter().zip(&before).map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f64::max);
            assert!(most < 20.0, "{step}: {most}");
            before = now;
        }
    }

    #[test]
    fn uniform_images_stay_uniform_for_any_disks() {
        let diameters: Vec<f64> = (0..WIDTH * WIDTH).map(|i| (i % WIDTH) as f64 / 5.0).collect();
        let mut light = vec![[50.0, 7.0, 3.0]; WIDTH * WIDTH];
        Defocus::new(&diameters, WIDTH).unwrap().apply(&mut light);
        for grey in light {
            for (found, said) in grey.iter().zip([50.0, 7.0, 3.0]) {
                assert!((found - said).abs() < 1e-12 * said * 100.0);
            }
        }
    }

    #[test]
    fn images_in_focus_need_no_blur() {
        assert!(Defocus::new(&[0.0; 16], 4).is_none());
        assert!(Defocus::new(&[1.0; 16], 4).is_none());
    }
}
