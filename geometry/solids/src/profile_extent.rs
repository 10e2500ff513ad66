//! Areas, lengths and bounding boxes of profiles.

use crate::compiled::{Region, path_length, signed_area};
use crate::{Path, Profile};

impl Path {
    /// Computes the enclosed area, mm^2, positive for counter-clockwise paths; exact for lines and arcs (Green's
    /// theorem).
    pub fn signed_area_mm2(&self) -> f64 {
        signed_area(self)
    }
}

impl Profile {
    /// Computes the area of the region, mm^2.
    ///
    /// ```
    /// use fabkit_geometry::{Path, Profile};
    /// let disc = Profile::new(Path::circle([3.0, 4.0], 2.0));
    /// assert!((disc.area_mm2() - 4.0 * std::f64::consts::PI).abs() < 1e-12);
    /// assert_eq!(disc.with_hole(Path::rectangle([3.0, 4.0], [1.0, 1.0], 0.0)).bounds_mm()[1], [5.0, 6.0]);
    /// ```
    pub fn area_mm2(&self) -> f64 {
        let holes: f64 = self.holes.iter().map(|hole| hole.signed_area_mm2().abs()).sum();
        self.outer.signed_area_mm2().abs() - holes
    }

    /// Computes the length of all boundaries, mm. Lines and circular arcs only.
    ///
    /// ```
    /// use fabkit_geometry::{Path, Profile};
    /// let plate = Profile::new(Path::rectangle([0.0, 0.0], [10.0, 6.0], 0.0));
    /// assert_eq!(plate.boundary_mm(), 32.0);
    /// let drilled = plate.with_hole(Path::circle([0.0, 0.0], 1.0));
    /// assert!((drilled.boundary_mm() - (32.0 + 2.0 * std::f64::consts::PI)).abs() < 1e-12);
    /// ```
    pub fn boundary_mm(&self) -> f64 {
        self.paths().map(path_length).sum()
    }

    /// Returns the lower left and upper right corner of the bounding box, mm; exact for arcs.
    pub fn bounds_mm(&self) -> [[f64; 2]; 2] {
        let region = Region::new(self);
        let reach = |x: f64, y: f64| region.support(nalgebra::Vector2::new(x, y));
        [[-reach(-1.0, 0.0), -reach(0.0, -1.0)], [reach(1.0, 0.0), reach(0.0, 1.0)]]
    }
}
