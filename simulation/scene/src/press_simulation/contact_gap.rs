//! Difference between elastic and rigid contact, as the camera sees it.

use fabkit_depth::ground_truth::{DepthMap, SURFACE_LABEL};
use serde_json::{Value, json};

/// Difference below which the surface counts as unmoved, mm.
const MOVED_MM: f64 = 1e-6;

/// Sums of the range differences of a set of pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Differences {
    pixels: usize,
    squares_mm2: f64,
    max_mm: f64,
}

impl Differences {
    fn add(&mut self, off_mm: f64) {
        self.pixels += 1;
        // Sums instead of means, so that bands of an image can be merged exactly.
        self.squares_mm2 += off_mm * off_mm;
        self.max_mm = self.max_mm.max(off_mm.abs());
    }

    fn merge(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.squares_mm2 += other.squares_mm2;
        self.max_mm = self.max_mm.max(other.max_mm);
    }

    fn rms_mm(self) -> f64 {
        (self.squares_mm2 / self.pixels.max(1) as f64).sqrt()
    }

    fn to_json(self) -> Value {
        json!({ "pixels": self.pixels, "rms_mm": self.rms_mm(), "max_mm": self.max_mm })
    }
}

/// Range differences between elastic and rigid contact of the same presses, along each pixel's ray.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactGap {
    /// Pixels that see an indenter's contact in either model.
    touched: Differences,
    /// Pixels outside contact at which the surface moves.
    outside_contact: Differences,
}

impl ContactGap {
    /// Compares a depth map with that of the same presses in rigid contact.
    pub fn compare(elastic: &DepthMap, rigid: &DepthMap) -> Self {
        let mut gap = Self::default();
        let labels = elastic.label().iter().zip(rigid.label());
        let ranges = elastic.range_mm().iter().zip(rigid.range_mm());
        for ((label, rigid_label), (range_mm, rigid_mm)) in labels.zip(ranges) {
            // NaN where no surface is seen. Such pixels have no indenter's label, and NaN exceeds no threshold.
            let off_mm = range_mm - rigid_mm;
            // Labels above the surface's are indenters.
            if *label.max(rigid_label) > SURFACE_LABEL {
                gap.touched.add(off_mm);
            } else if off_mm.abs() > MOVED_MM {
                gap.outside_contact.add(off_mm);
            }
        }
        gap
    }

    /// Adds the differences of other pixels.
    pub fn merge(&mut self, other: &Self) {
        self.touched.merge(&other.touched);
        self.outside_contact.merge(&other.outside_contact);
    }

    /// Returns the root mean square and the maximum difference in contact, mm.
    pub fn touched_mm(&self) -> [f64; 2] {
        [self.touched.rms_mm(), self.touched.max_mm]
    }

    /// Returns the root mean square and the maximum difference outside contact, where the surface moves, mm.
    pub fn outside_contact_mm(&self) -> [f64; 2] {
        [self.outside_contact.rms_mm(), self.outside_contact.max_mm]
    }

    /// Returns `touched` and `beside` as JSON, each with `pixels`, `rms_mm` and `max_mm`.
    pub fn to_json(&self) -> Value {
        json!({ "touched": self.touched.to_json(), "beside": self.outside_contact.to_json() })
    }
}
