//! Judgement of reconstructed depth.

use std::path::Path;

use super::{ImageFault, ImageGate, Judgement};

/// Factor on the depth of the soft layers beyond which depth is not credible. Reconstruction is off by up to 10 % under
/// a ball in simulated units (0.48 to 0.54 mm for 0.5 mm, 1.53 for 1.4 mm).
const DEPTH_MARGIN: f64 = 1.1;
/// Largest share of the surface in contact. Balls and pins touch 10 % at most in simulated and real captures; a plate
/// over the whole pad cannot be told from another exposure.
const MOST_CONTACT: f64 = 0.9;
/// Width of the rim, as a share of the image's columns. Rays that pass displaced gel at a pad's edge lie within it.
const RIM_SHARE: f64 = 0.02;
/// Share of a contact's depth at the rim that its depth inside has if the contact is real: what is pressed in across the
/// border of the image goes on inside, and what rays past displaced gel seem to show ends with the rim.
const LEAST_INSIDE_SHARE: f64 = 0.5;
/// Area of a contact at the rim, as a share of the largest inside, from which it counts. Smaller ones, a few pixels in
/// simulated captures that are right, are left out of the deepest place.
const LEAST_RIM_SHARE: f64 = 0.1;

/// Reconstructed depth of an image, to be judged.
#[derive(Clone, Copy, Debug)]
pub struct DepthFigures<'a> {
    /// Width and height, px.
    pub size_px: [usize; 2],
    /// Depth of each pixel, mm; NaN where no surface is seen.
    pub depth_mm: &'a [f32],
    /// Pixels in contact.
    pub contact: &'a [bool],
}

/// A connected region in contact.
#[derive(Clone, Debug)]
struct Contact {
    area: usize,
    /// Largest depth, mm, after dropping the largest thousandth of its pixels, and a pixel that has it.
    deepest_mm: f32,
    pixel: usize,
    is_at_rim: bool,
    /// Largest depth of its pixels outside the rim, mm; 0 without any.
    inside_mm: f32,
}

impl DepthFigures<'_> {
    /// Returns the largest depth in contact, mm. The largest thousandth of each contact's pixels is dropped, and so are
    /// small contacts in the rim beside larger ones inside: at a pad's edge, rays pass the displaced gel. `None`
    /// without contact.
    ///
    /// ```
    /// use fabkit_capture::plausibility::DepthFigures;
    /// // A wide contact, and one pixel at the border that reads more.
    /// let is_in = |i: usize| (10..30).contains(&(i % 40)) && (10..30).contains(&(i / 40));
    /// let depth_mm: Vec<f32> =
    ///     (0..1600).map(|i| if i == 20 { 3.9 } else if is_in(i) { 1.1 } else { 0.0 }).collect();
    /// let contact: Vec<bool> = depth_mm.iter().map(|mm| *mm > 0.1).collect();
    /// let figures = DepthFigures { size_px: [40, 40], depth_mm: &depth_mm, contact: &contact };
    /// assert_eq!(figures.deepest_mm(), Some(1.1));
    /// ```
    pub fn deepest_mm(&self) -> Option<f32> {
        self.deepest().map(|contact| contact.deepest_mm)
    }

    fn deepest(&self) -> Option<Contact> {
        let contacts = self.contacts();
        let inside = contacts.iter().filter(|contact| !contact.is_at_rim);
        let largest = inside.map(|contact| contact.area).max().unwrap_or(0);
        let counts = |contact: &&Contact| {
            !contact.is_at_rim || contact.area as f64 >= LEAST_RIM_SHARE * largest as f64
        };
        let deepest = contacts.iter().filter(counts);
        deepest.max_by(|a, b| a.deepest_mm.total_cmp(&b.deepest_mm)).cloned()
    }

    /// Finds connected regions in contact.
    fn contacts(&self) -> Vec<Contact> {
        let [width, height] = self.size_px;
        let is_rim = self.rim();
        let mut is_new = self.contact.to_vec();
        let mut contacts = Vec::new();
        for first in 0..is_new.len() {
            if !is_new[first] {
                continue;
            }
            is_new[first] = false;
            let (mut pixels, mut next) = (vec![first], 0);
            while let Some(&i) = pixels.get(next) {
                next += 1;
                let (x, y) = (i % width, i / width);
                let beside = [
                    (x > 0).then(|| i - 1),
                    (x + 1 < width).then_some(i + 1),
                    i.checked_sub(width),
                    (y + 1 < height).then_some(i + width),
                ];
                for j in beside.into_iter().flatten() {
                    if std::mem::take(&mut is_new[j]) {
                        pixels.push(j);
                    }
                }
            }
            let at = pixels.len() - 1 - pixels.len() / 1000;
            let by_depth = |a: &usize, b: &usize| self.depth_mm[*a].total_cmp(&self.depth_mm[*b]);
            let pixel = *pixels.select_nth_unstable_by(at, by_depth).1;
            let inside_mm = pixels.iter().filter(|pixel| !is_rim[**pixel]);
            let inside_mm = inside_mm.map(|pixel| self.depth_mm[*pixel]).fold(0.0, f32::max);
            contacts.push(Contact {
                area: pixels.len(),
                deepest_mm: self.depth_mm[pixel],
                pixel,
                is_at_rim: is_rim[pixel],
                inside_mm,
            });
        }
        contacts
    }

    /// Returns for each pixel whether the image's border, or a pixel that sees no surface, is near.
    fn rim(&self) -> Vec<bool> {
        let [width, height] = self.size_px;
        let rim_px = (RIM_SHARE * width as f64).ceil() as usize;
        // What is near in a square is near along a row of what is near along a column.
        let no_surface: Vec<bool> = self.depth_mm.iter().map(|mm| mm.is_nan()).collect();
        let along_columns = near_along_lines(&no_surface, [width, height], [1, width], rim_px);
        near_along_lines(&along_columns, [height, width], [width, 1], rim_px)
    }

    fn place(&self, pixel: usize) -> [usize; 2] {
        [pixel % self.size_px[0], pixel / self.size_px[0]]
    }
}

/// Returns for each pixel whether one that is marked, or the end of the line, is at most `most_px` away along its line.
/// `lines` and `length` are the numbers of lines and of pixels in each; `next_line` and `next` the steps to the next one.
fn near_along_lines(
    is_marked: &[bool],
    [lines, length]: [usize; 2],
    [next_line, next]: [usize; 2],
    most_px: usize,
) -> Vec<bool> {
    let mut is_near = vec![false; is_marked.len()];
    for line in 0..lines {
        let at = |step: usize| line * next_line + step * next;
        // The pixel before the first one counts as marked, and so does the one after the last.
        let mut since = 0;
        for step in 0..length {
            since = if is_marked[at(step)] { 0 } else { since + 1 };
            is_near[at(step)] |= since <= most_px;
        }
        since = 0;
        for step in (0..length).rev() {
            since = if is_marked[at(step)] { 0 } else { since + 1 };
            is_near[at(step)] |= since <= most_px;
        }
    }
    is_near
}

impl ImageGate {
    /// Judges the depth that was reconstructed from an image, which was read from `file`: numbers, depth of the soft
    /// layers, share of the surface in contact, rim.
    pub fn judge_depth(&self, file: &Path, depth: &DepthFigures<'_>) -> Judgement {
        let mut judgement = Judgement::default();
        let of = depth.contact.iter().filter(|contact| **contact).count();
        let pressed = depth.depth_mm.iter().zip(depth.contact).filter(|(_, contact)| **contact);
        let count = pressed.filter(|(mm, _)| !mm.is_finite()).count();
        if count > 0 {
            judgement.find(file, ImageFault::NotFinite { count, of });
        }
        let surface = depth.depth_mm.iter().filter(|mm| !mm.is_nan()).count();
        let share = of as f64 / surface.max(1) as f64;
        if share > MOST_CONTACT {
            judgement.find(file, ImageFault::ContactEverywhere { share, most: MOST_CONTACT });
        }
        let Some(deepest) = depth.deepest() else { return judgement };
        let depth_mm = f64::from(deepest.deepest_mm);
        match self.limit_mm(depth, deepest.pixel) {
            Ok(limit_mm) if depth_mm > DEPTH_MARGIN * limit_mm => {
                let at_px = depth.place(deepest.pixel);
                judgement.find(file, ImageFault::TooDeep { depth_mm, limit_mm, at_px });
            }
            Ok(_) => {}
            Err(why) => judgement.leave_open("depth_limit", why),
        }
        let inside_mm = depth
            .contacts()
            .iter()
            .filter(|contact| !contact.is_at_rim)
            .map(|contact| f64::from(contact.deepest_mm))
            .fold(0.0, f64::max);
        let goes_on_inside =
            f64::from(deepest.inside_mm) >= LEAST_INSIDE_SHARE * f64::from(deepest.deepest_mm);
        if deepest.is_at_rim && !goes_on_inside && inside_mm > 0.0 {
            let at_px = depth.place(deepest.pixel);
            let fault = ImageFault::DeepestAtRim { rim_mm: depth_mm, inside_mm, at_px };
            judgement.find(file, fault);
        }
        judgement
    }

    /// Returns the depth at which the soft layers end along a pixel's ray, mm, or why it is not known.
    fn limit_mm(&self, depth: &DepthFigures<'_>, pixel: usize) -> Result<f64, String> {
        let drawn = self.expected.drawn.as_ref().map_err(Clone::clone)?;
        let [columns, rows] = drawn.cells.size;
        let [width, height] = depth.size_px;
        let [x, y] = depth.place(pixel);
        let limit_mm = drawn.limit_mm[y * rows / height * columns + x * columns / width];
        if limit_mm > 0.0 { Ok(limit_mm) } else { Err("no surface is drawn there".to_owned()) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::cells::Cells;
    use super::super::expected::{DrawnLight, ExpectedLight};
    use super::*;
    use crate::CapturedImage;

    const SIDE: usize = 100;

    /// A gate for a sensor whose soft layers end at 3 mm, straight below each pixel.
    fn gate() -> ImageGate {
        let image = || CapturedImage {
            size_px: [SIDE; 2],
            channels: 1,
            values: (0..SIDE * SIDE).map(|i| 0.4 + 0.2 * (i % SIDE) as f32 / SIDE as f32).collect(),
        };
        let cells = Cells::from_image(&image());
        let count = cells.values.len();
        let drawn = DrawnLight {
            cells,
            is_surface: vec![true; count],
            limit_mm: vec![3.0; count],
            is_colored: false,
        };
        let expected =
            ExpectedLight { size_px: [SIDE; 2], drawn: Ok(drawn), has_moving_markers: false };
        ImageGate::new(expected, Path::new("rest.png"), image()).unwrap().accept().unwrap()
    }

    /// Codes of the findings about depth that is `inside_mm` in a square and `rim_mm` in a strip at the border.
    fn judge(inside_mm: f32, rim_mm: f32, rim_px: usize) -> Vec<&'static str> {
        let depth = |i: usize| {
            let [x, y] = [i % SIDE, i / SIDE];
            let is_inside = (40..60).contains(&x) && (40..60).contains(&y);
            if is_inside {
                inside_mm
            } else if y == 0 && x < rim_px {
                rim_mm
            } else {
                0.0
            }
        };
        let depth_mm: Vec<f32> = (0..SIDE * SIDE).map(depth).collect();
        let contact: Vec<bool> = depth_mm.iter().map(|mm| *mm != 0.0).collect();
        let figures = DepthFigures { size_px: [SIDE; 2], depth_mm: &depth_mm, contact: &contact };
        let judgement = gate().judge_depth(Path::new("pressed.png"), &figures);
        judgement.findings.iter().map(|one| one.fault.code()).collect()
    }

    #[test]
    fn depth_that_cannot_be_is_found() {
        assert!(judge(1.4, 0.0, 0).is_empty());
        // A tenth of 3 mm is allowed.
        assert!(judge(3.29, 0.0, 0).is_empty());
        assert_eq!(judge(3.31, 0.0, 0), ["too_deep"]);
        assert_eq!(judge(f32::NAN, 0.0, 0), ["not_finite"]);
        // The rim counts from a tenth of the area inside: 40 of 400 pixels.
        assert!(judge(1.4, 2.1, 39).is_empty());
        assert_eq!(judge(1.4, 2.1, 40), ["deepest_at_rim"]);
        assert!(judge(1.4, 1.3, 90).is_empty());
    }

    #[test]
    fn a_contact_that_crosses_the_border_is_real() {
        // A cone that is deepest at the border, beside a shallow contact inside; and one that ends with the rim of 2 px.
        for (reach_px, expected) in [(30.0, &[][..]), (2.9, &["deepest_at_rim"])] {
            let depth = |i: usize| {
                let [x, y] = [i % SIDE, i / SIDE].map(|px| px as f32);
                let cone = 2.0 * (1.0 - (x - 50.0).hypot(y) / reach_px);
                let is_inside = (40.0..44.0).contains(&x) && (60.0..64.0).contains(&y);
                if is_inside { 0.4 } else { cone.max(0.0) }
            };
            let depth_mm: Vec<f32> = (0..SIDE * SIDE).map(depth).collect();
            let contact: Vec<bool> = depth_mm.iter().map(|mm| *mm != 0.0).collect();
            let figures =
                DepthFigures { size_px: [SIDE; 2], depth_mm: &depth_mm, contact: &contact };
            let judgement = gate().judge_depth(Path::new("pressed.png"), &figures);
            let codes: Vec<_> = judgement.findings.iter().map(|one| one.fault.code()).collect();
            assert_eq!(codes, expected);
        }
    }

    #[test]
    fn contact_everywhere_is_found() {
        for (rows, expected) in [(90, &[][..]), (91, &["contact_everywhere"])] {
            let contact: Vec<bool> = (0..SIDE * SIDE).map(|i| i < rows * SIDE).collect();
            let depth_mm: Vec<f32> =
                contact.iter().map(|contact| if *contact { 1.0 } else { 0.0 }).collect();
            let figures =
                DepthFigures { size_px: [SIDE; 2], depth_mm: &depth_mm, contact: &contact };
            let judgement = gate().judge_depth(Path::new("pressed.png"), &figures);
            let codes: Vec<_> = judgement.findings.iter().map(|one| one.fault.code()).collect();
            assert_eq!(codes, expected);
        }
    }
}
