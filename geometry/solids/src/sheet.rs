//! Flat parts that a laser or a router can cut from a sheet.

use crate::{Path, Pose, Profile, Solid};

/// Solid that is one outline through the thickness of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Outline, viewed against the z axis of the sheet's frame.
    pub profile: Profile,
    /// Thickness: height of the extrusion, mm.
    pub thickness_mm: f64,
    /// Pose that maps the sheet's frame (outline in xy, thickness from z = 0 upwards) to the solid's.
    pub solid_from_sheet: Pose,
}

/// Error of a solid that cannot be cut from a sheet.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "it is {found}; what is cut from a sheet is one extrusion, cylinder or box, placed and named"
)]
pub struct NotASheet {
    /// Kind of the node that prevents it, with its article.
    pub found: &'static str,
}

impl Solid {
    /// Returns outline, thickness and pose of a solid that is one extrusion, cylinder or box under any number of
    /// placements and names.
    ///
    /// Booleans are refused even where their result is flat: holes belong into the profile, where their edges are
    /// exact.
    ///
    /// ```
    /// use fabkit_geometry::{Path, Profile, Solid};
    /// let ring = Profile::new(Path::circle([0.0, 0.0], 5.0)).with_hole(Path::circle([0.0, 0.0], 2.0));
    /// let sheet = Solid::extrusion(ring.clone(), 3.0).at(0.0, 0.0, 7.0).named("ring").as_sheet()?;
    /// assert_eq!((sheet.thickness_mm, sheet.profile), (3.0, ring));
    /// # Ok::<(), fabkit_geometry::NotASheet>(())
    /// ```
    ///
    /// # Errors
    /// [`NotASheet`] with what was found instead.
    pub fn as_sheet(&self) -> Result<Sheet, NotASheet> {
        let flat = |profile, thickness_mm| {
            Ok(Sheet { profile, thickness_mm, solid_from_sheet: Pose::identity() })
        };
        let no = |found| Err(NotASheet { found });
        match self {
            Self::Extrusion(extrusion) => flat(extrusion.profile.clone(), extrusion.height_mm),
            Self::Cylinder(c) => flat(Path::circle([0.0; 2], c.radius_mm).into(), c.height_mm),
            Self::Cuboid(cuboid) => {
                let [x_mm, y_mm, z_mm] = cuboid.size_mm;
                flat(Path::rectangle([0.0; 2], [x_mm, y_mm], 0.0).into(), z_mm)
            }
            Self::Placed { pose, of } => {
                let sheet = of.as_sheet()?;
                Ok(Sheet { solid_from_sheet: pose.then_in(sheet.solid_from_sheet), ..sheet })
            }
            Self::Feature { of, .. } => of.as_sheet(),
            Self::Union(_) => no("a union"),
            Self::Intersection(_) => no("an intersection"),
            Self::Difference { .. } => no("a difference"),
            Self::Revolution(_) => no("a revolution"),
            Self::Cone(_) => no("a cone"),
            Self::HalfSpace(_) => no("a half space"),
            Self::Sphere(_) | Self::Ellipsoid(_) | Self::Torus(_) | Self::EllipsoidOffset(_) => {
                no("a curved solid")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Angle, Point3};

    #[test]
    fn poses_add_up_and_names_do_not_matter() {
        let quarter = Angle::from_deg(90.0).unwrap();
        let solid = Solid::cuboid(4.0, 2.0, 1.0).named("a").at(1.0, 2.0, 3.0).turned_x(quarter);
        let sheet = solid.named("b").at(0.0, 0.0, 10.0).as_sheet().unwrap();
        assert_eq!(sheet.thickness_mm, 1.0);
        assert_eq!(sheet.profile.area_mm2(), 8.0);
        // (0, 0, 1) -> (1, 2, 4) -> (1, -4, 2) -> (1, -4, 12)
        let top = sheet.solid_from_sheet.point(Point3::new(0.0, 0.0, 1.0));
        assert_eq!(top, Point3::new(1.0, -4.0, 12.0));
    }

    #[test]
    fn what_is_not_flat_by_construction_is_refused() {
        let plate = Solid::cuboid(4.0, 2.0, 1.0);
        let drilled = plate.minus(Solid::cylinder(0.5, 3.0).at(0.0, 0.0, -1.0)).named("x");
        let error = drilled.as_sheet().unwrap_err();
        assert_eq!(error, NotASheet { found: "a difference" });
        assert!(error.to_string().starts_with("it is a difference; what is cut from a sheet"));
        assert!(Solid::sphere(1.0).at(0.0, 0.0, 1.0).as_sheet().is_err());
    }
}
