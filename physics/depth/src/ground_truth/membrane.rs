//! Smooth transition around contacts, for gels that do not follow a steep flank.
//!
//! Rigid contact ends where the indenter's surface ends: beside a punch the gel would stand as a wall. A skin under
//! tension instead hangs from the edge and returns to rest at some distance. The transition here is geometric, not
//! mechanical. Around each point of contact the indentation `d` spreads over the surface as `d * fade(s / radius)`,
//! where `s` is the straight distance between points of the undeformed surface. The largest contribution counts, and
//! never less than rigid contact. `fade(x) = (1 - x)^2 (1 + 2 x)` falls from 1 to 0 with zero slope at both ends, so
//! that kinks arise only where two contributions meet.

use std::collections::BTreeMap;

use fabkit_geometry::{Point3, Vector3};
use rayon::prelude::*;

use super::map::DepthMap;

/// Smallest indentation that spreads, mm.
const LEAST_MM: f64 = 1e-6;

type Cell = [i64; 3];

impl DepthMap<'_> {
    /// Adds a transition of `radius_mm` around the contacts of the press.
    ///
    /// Labels and [`DepthMap::contact`] stay those of rigid contact. Normals of displaced pixels are computed from
    /// neighbouring points of the map, since the displaced surface has no closed form. A radius that is not positive
    /// and finite changes nothing.
    ///
    /// ```
    /// # use fabkit_geometry::{DomeSurface, EllipsoidOffset, FixtureGrip, Path};
    /// # let grip = FixtureGrip {
    /// #     outline: Path::circle([0.0, 0.0], 10.0), top_z_mm: 0.0, bottom_z_mm: -20.0, clear_radius_mm: 8.0,
    /// #     key: None, threads: Vec::new(),
    /// # };
    /// # let dome = EllipsoidOffset { equatorial_mm: 10.0, polar_mm: 10.0, offset_mm: 0.0 };
    /// # let touch = DomeSurface { dome, centre_z_mm: 0.0, foot_z_mm: 0.0, max_indentation_mm: 2.0, grip }.into();
    /// use fabkit_camera::Camera;
    /// use fabkit_depth::ground_truth::{PixelRays, PlacedIndenter, ReferenceSurface};
    /// use fabkit_geometry::{Pose, Solid};
    ///
    /// // A dome of radius 10 mm around the camera, and a pin of radius 0.5 mm that reaches in by 1 mm.
    /// let rays = PixelRays::new(&Camera::equidistant(61, 61, 2.0)?, &Pose::identity());
    /// let surface = ReferenceSurface::cast(&touch, &rays)?;
    /// let pin = PlacedIndenter::new("pin", &Solid::cylinder(0.5, 9.0), Pose::translation(0.0, 0.0, 9.0))?;
    /// let rigid = surface.map_with_indenters(&[pin]);
    /// let hanging = rigid.clone().with_membrane(3.0);
    /// let indented = |mm: f64| mm > 1e-6;
    /// // The gel beside the pin comes along, but does not count as contact.
    /// assert!(hanging.indentation_mm().filter(|mm| indented(*mm)).count() > rigid.contact().filter(|is| *is).count());
    /// assert!(hanging.contact().eq(rigid.contact()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_membrane(mut self, radius_mm: f64) -> Self {
        if !(radius_mm > 0.0 && radius_mm.is_finite()) {
            return self;
        }
        let reference = self.surface.map_without_contact();
        let at_rest: Vec<Point3<f64>> = reference.point_in_sensor().collect();
        let rigid_mm: Vec<f64> = self.indentation_mm().collect();
        let cell = |point: &Point3<f64>| -> Cell {
            std::array::from_fn(|axis| (point[axis] / radius_mm).floor() as i64)
        };
        let mut contacts: BTreeMap<Cell, Vec<u32>> = BTreeMap::new();
        for (pixel, &indentation_mm) in rigid_mm.iter().enumerate() {
            if indentation_mm > LEAST_MM {
                contacts.entry(cell(&at_rest[pixel])).or_default().push(pixel as u32);
            }
        }
        let spread = |pixel: usize| -> f64 {
            let point = &at_rest[pixel];
            if !point.x.is_finite() {
                return f64::NAN;
            }
            let [x, y, z] = cell(point);
            let mut largest_mm = rigid_mm[pixel];
            // Cells are as wide as the radius, so the 27 around a point hold all contacts that reach it.
            for near in (0..27).map(|i| [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1]) {
                for &contact in contacts.get(&near).into_iter().flatten() {
                    let contact = contact as usize;
                    // This test is cheaper than the distance, and rejects most contributions.
                    if rigid_mm[contact] <= largest_mm {
                        continue;
                    }
                    let share = (point - at_rest[contact]).norm() / radius_mm;
                    largest_mm = largest_mm.max(rigid_mm[contact] * fade(share));
                }
            }
            largest_mm
        };
        let indentation_mm: Vec<f64> = (0..rigid_mm.len()).into_par_iter().map(spread).collect();
        let moved: Vec<usize> =
            (0..rigid_mm.len()).filter(|&pixel| indentation_mm[pixel] > rigid_mm[pixel]).collect();
        for &pixel in &moved {
            self.range_mm[pixel] = reference.range_mm[pixel] - indentation_mm[pixel];
        }
        let points: Vec<Point3<f64>> = self.point_in_sensor().collect();
        for pixel in moved {
            let normal = self.normal_from_neighbours(&points, pixel);
            self.changed_normals.extend(normal.map(|normal| (pixel as u32, normal)));
        }
        self
    }

    /// Computes a normal out of the gel from differences along row and column; `None` at an isolated pixel.
    fn normal_from_neighbours(&self, points: &[Point3<f64>], pixel: usize) -> Option<Vector3<f64>> {
        let (width, height) = (self.width_px() as usize, self.height_px() as usize);
        let (column, row) = (pixel % width, pixel / width);
        let across = points[pixel - usize::from(column > 0)]
            - points[pixel + usize::from(column + 1 < width)];
        let down = points[pixel - width * usize::from(row > 0)]
            - points[pixel + width * usize::from(row + 1 < height)];
        // NaN neighbours, where no surface is seen, yield no normal.
        let normal = across.cross(&down).try_normalize(0.0).filter(|n| n.x.is_finite())?;
        let ray = self.surface.rays().ray(pixel)?;
        Some(if normal.dot(&ray.direction) < 0.0 { -normal } else { normal })
    }
}

/// Weight of a contribution: 1 at 0, 0 from 1 on, with zero slope at both ends.
fn fade(x: f64) -> f64 {
    if x < 1.0 { (1.0 - x) * (1.0 - x) * (1.0 + 2.0 * x) } else { 0.0 }
}
