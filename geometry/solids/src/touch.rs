//! Sensing surface of a sensor, and the rigid grip that fixtures hold.

use nalgebra::{Point3, Vector3};

use crate::{CUT_OVERLAP_MM, EllipsoidOffset, Landmark, Path, Pose, Solid};

/// Sensing surface. Code that does not match on the shape works with every sensor.
#[derive(Clone, Debug, PartialEq)]
pub enum TouchSurface {
    /// Round, in one of the shapes listed at [`DomeSurface`].
    Dome(DomeSurface),
    /// Flat pad.
    Plane(PlaneSurface),
}

/// Flat pad: a plane across z that ends at an outline.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneSurface {
    /// Outline seen along z, counter-clockwise, sensor frame, mm.
    pub outline: Path,
    /// Height of the plane in the sensor frame, mm.
    pub top_z_mm: f64,
    /// Height of the lower end of the pad's free sides, mm.
    pub foot_z_mm: f64,
    /// Largest indentation, mm: the thickness of the material that yields measurably.
    pub max_indentation_mm: f64,
    /// Rigid part that fixtures hold.
    pub grip: FixtureGrip,
}

/// Dome around z, with a straight wall below its centre.
///
/// Examples are a hemisphere on a wall (R-Tac0), a half ellipsoid or a surface parallel to one (UVDtact), and a cap
/// whose centre lies below its foot (ShadowTac).
#[derive(Clone, Debug, PartialEq)]
pub struct DomeSurface {
    /// Dome around its own centre; a sphere has two equal half axes and no offset.
    pub dome: EllipsoidOffset,
    /// Height of the dome's centre in the sensor frame, mm.
    pub centre_z_mm: f64,
    /// Height of the lower end of the surface in the sensor frame, mm.
    pub foot_z_mm: f64,
    /// Largest indentation, mm: the thickness of the material that yields measurably.
    pub max_indentation_mm: f64,
    /// Rigid part that fixtures hold.
    pub grip: FixtureGrip,
}

/// Rigid part of a sensor below its surface.
#[derive(Clone, Debug, PartialEq)]
pub struct FixtureGrip {
    /// Outline seen along z, the same at every height between `bottom_z_mm` and `top_z_mm` except for an upper edge
    /// that may be rounded. Fixtures hold the part below the edge and stand on the lower end.
    pub outline: Path,
    /// Upper end of the outline, at most the surface's foot, mm.
    pub top_z_mm: f64,
    /// Lower end of the outline, mm.
    pub bottom_z_mm: f64,
    /// Radius of the circle around z outside of which a fixture can stop against a flat face at `bottom_z_mm`, mm.
    /// Inside it are cable, plug and lower parts of the sensor.
    pub clear_radius_mm: f64,
    /// Pose of a unique feature at the outside of the grip that keeps a fixture from being put on rotated; its z axis
    /// points out of the sensor. `None`: the user marks one.
    pub key: Option<Pose>,
    /// Threaded holes in the bottom: position, and the axis out of the sensor.
    pub threads: Vec<Landmark>,
}

impl TouchSurface {
    /// Returns the dome; `None` if the surface is flat.
    pub fn dome(&self) -> Option<&DomeSurface> {
        match self {
            Self::Dome(dome) => Some(dome),
            Self::Plane(_) => None,
        }
    }

    /// Returns the flat pad; `None` if the surface is round.
    pub fn plane(&self) -> Option<&PlaneSurface> {
        match self {
            Self::Dome(_) => None,
            Self::Plane(plane) => Some(plane),
        }
    }

    /// Returns the rigid part that fixtures hold.
    pub fn grip(&self) -> &FixtureGrip {
        match self {
            Self::Dome(dome) => &dome.grip,
            Self::Plane(plane) => &plane.grip,
        }
    }

    /// Returns the largest indentation, mm.
    pub fn max_indentation_mm(&self) -> f64 {
        match self {
            Self::Dome(dome) => dome.max_indentation_mm,
            Self::Plane(plane) => plane.max_indentation_mm,
        }
    }

    /// Returns the height of the lower end of the surface in the sensor frame, mm.
    pub fn foot_z_mm(&self) -> f64 {
        match self {
            Self::Dome(dome) => dome.foot_z_mm,
            Self::Plane(plane) => plane.foot_z_mm,
        }
    }

    /// Returns the height of its highest points in the sensor frame, mm.
    pub fn apex_z_mm(&self) -> f64 {
        match self {
            Self::Dome(dome) => dome.apex_z_mm(),
            Self::Plane(plane) => plane.top_z_mm,
        }
    }

    /// Computes the smallest radius of curvature, mm; infinite if the surface is flat.
    ///
    /// ```
    /// use fabkit_geometry::{DomeSurface, EllipsoidOffset, FixtureGrip, Path, TouchSurface};
    /// let grip = FixtureGrip {
    ///     outline: Path::circle([0.0, 0.0], 12.0),
    ///     top_z_mm: 0.0,
    ///     bottom_z_mm: -20.0,
    ///     clear_radius_mm: 10.0,
    ///     key: None,
    ///     threads: Vec::new(),
    /// };
    /// let dome = EllipsoidOffset { equatorial_mm: 12.0, polar_mm: 16.0, offset_mm: 0.0 };
    /// let dome = DomeSurface { dome, centre_z_mm: 0.0, foot_z_mm: 0.0, max_indentation_mm: 1.5, grip };
    /// assert_eq!(TouchSurface::from(dome).least_curvature_radius_mm(), 9.0); // 12^2 / 16, at the tip
    /// ```
    pub fn least_curvature_radius_mm(&self) -> f64 {
        match self {
            Self::Dome(DomeSurface { dome, .. }) => {
                let (a, b) = (dome.equatorial_mm, dome.polar_mm);
                // Principal radii of an ellipsoid of revolution at its poles and equator, plus the offset.
                (a * a / b).min(b * b / a).min(a) + dome.offset_mm
            }
            Self::Plane(_) => f64::INFINITY,
        }
    }

    /// Computes the depth of a point below the surface, mm (negative outside), and the outward unit normal at the
    /// nearest point of the surface: see [`DomeSurface::depth_mm`], [`PlaneSurface::depth_mm`].
    pub fn depth_mm(&self, point: &Point3<f64>) -> (f64, Vector3<f64>) {
        match self {
            Self::Dome(dome) => dome.depth_mm(point),
            Self::Plane(plane) => plane.depth_mm(point),
        }
    }

    /// Returns the filled solid inside the surface, offset outwards by `by_mm`, from the height `from_z_mm` upwards:
    /// see [`DomeSurface::solid`], [`PlaneSurface::solid`].
    pub fn solid(&self, by_mm: f64, from_z_mm: f64) -> Solid {
        match self {
            Self::Dome(dome) => dome.solid(by_mm, from_z_mm),
            Self::Plane(plane) => plane.solid(by_mm, from_z_mm),
        }
    }
}

impl From<DomeSurface> for TouchSurface {
    fn from(dome: DomeSurface) -> Self {
        Self::Dome(dome)
    }
}

impl From<PlaneSurface> for TouchSurface {
    fn from(plane: PlaneSurface) -> Self {
        Self::Plane(plane)
    }
}

impl PlaneSurface {
    /// Computes the depth of a point below the plane, mm (negative above), and the plane's normal, +z; sensor frame.
    /// The edge is ignored: the plane continues beyond its outline.
    pub fn depth_mm(&self, point: &Point3<f64>) -> (f64, Vector3<f64>) {
        (self.top_z_mm - point.z, Vector3::z())
    }

    /// Returns the filled solid below the plane and inside its outline, offset outwards by `by_mm`, from the height
    /// `from_z_mm` upwards; sensor frame. The upper edge stays sharp, so that the solid contains all points within
    /// `by_mm`.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, FixtureGrip, Path, PlaneSurface, Point3};
    /// let outline = Path::rectangle([0.0; 2], [20.0, 25.0], 0.0);
    /// let grip = FixtureGrip {
    ///     outline: outline.offset_outwards(3.0),
    ///     top_z_mm: -1.0,
    ///     bottom_z_mm: -20.0,
    ///     clear_radius_mm: 8.0,
    ///     key: None,
    ///     threads: Vec::new(),
    /// };
    /// let pad = PlaneSurface { outline, top_z_mm: 3.0, foot_z_mm: 0.0, max_indentation_mm: 3.0, grip };
    /// let solid = CompiledSolid::new(&pad.solid(0.0, pad.foot_z_mm))?;
    /// assert!(solid.contains(&Point3::new(9.9, 12.4, 2.9)));
    /// assert!(!solid.contains(&Point3::new(0.0, 0.0, 3.1)));
    /// assert_eq!(pad.depth_mm(&Point3::new(0.0, 0.0, 2.0)).0, 1.0);
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn solid(&self, by_mm: f64, from_z_mm: f64) -> Solid {
        let height_mm = self.top_z_mm + by_mm - from_z_mm;
        Solid::extrusion(self.outline.offset_outwards(by_mm), height_mm).at_z(from_z_mm)
    }
}

impl DomeSurface {
    /// Returns half the largest width, mm.
    pub fn equator_radius_mm(&self) -> f64 {
        self.dome.equatorial_mm + self.dome.offset_mm
    }

    /// Returns the height of the apex in the sensor frame, mm.
    pub fn apex_z_mm(&self) -> f64 {
        self.centre_z_mm + self.dome.polar_mm + self.dome.offset_mm
    }

    /// Computes the depth of a point below the surface, mm (negative outside), and the outward unit normal at the
    /// nearest point of the surface; sensor frame. The foot is ignored: below the dome's centre the wall continues.
    ///
    /// ```
    /// use fabkit_geometry::{DomeSurface, EllipsoidOffset, FixtureGrip, Path, Point3, Vector3};
    /// let grip = FixtureGrip {
    ///     outline: Path::circle([0.0, 0.0], 15.0),
    ///     top_z_mm: 0.0,
    ///     bottom_z_mm: -20.0,
    ///     clear_radius_mm: 13.0,
    ///     key: None,
    ///     threads: Vec::new(),
    /// };
    /// let dome = EllipsoidOffset { equatorial_mm: 15.0, polar_mm: 15.0, offset_mm: 0.0 };
    /// let touch = DomeSurface { dome, centre_z_mm: 6.0, foot_z_mm: 0.0, max_indentation_mm: 1.5, grip };
    /// let (depth_mm, normal) = touch.depth_mm(&Point3::new(0.0, 0.0, 20.0));
    /// assert!((depth_mm - 1.0).abs() < 1e-12 && normal == Vector3::z());
    /// let (depth_mm, normal) = touch.depth_mm(&Point3::new(16.0, 0.0, 3.0));
    /// assert!((depth_mm + 1.0).abs() < 1e-12 && normal == Vector3::x());
    /// ```
    pub fn depth_mm(&self, point: &Point3<f64>) -> (f64, Vector3<f64>) {
        let from_centre = point - Point3::new(0.0, 0.0, self.centre_z_mm);
        if from_centre.z >= 0.0 {
            let (distance_mm, normal) = self.dome.distance(&from_centre);
            return (-distance_mm, normal);
        }
        let radius_mm = from_centre.x.hypot(from_centre.y);
        // On the axis all directions are equally near.
        let out = if radius_mm > 0.0 { from_centre.xy() / radius_mm } else { Vector3::x().xy() };
        (self.equator_radius_mm() - radius_mm, Vector3::new(out.x, out.y, 0.0))
    }

    /// Returns the filled solid inside the surface, offset along its normals by `by_mm`, from the height `from_z_mm`
    /// upwards; sensor frame.
    ///
    /// A positive offset gives the surface's clearance; a negative one gives the material that lies at least that deep.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, DomeSurface, EllipsoidOffset, FixtureGrip, Path};
    /// let grip = FixtureGrip {
    ///     outline: Path::circle([0.0, 0.0], 15.0),
    ///     top_z_mm: 0.0,
    ///     bottom_z_mm: -20.0,
    ///     clear_radius_mm: 13.0,
    ///     key: None,
    ///     threads: Vec::new(),
    /// };
    /// let dome = EllipsoidOffset { equatorial_mm: 15.0, polar_mm: 15.0, offset_mm: 0.0 };
    /// let dome = DomeSurface { dome, centre_z_mm: 6.0, foot_z_mm: 0.0, max_indentation_mm: 1.5, grip };
    /// assert_eq!(CompiledSolid::new(&dome.solid(0.5, 0.0))?.bounds().max.z, 6.0 + 15.0 + 0.5);
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn solid(&self, by_mm: f64, from_z_mm: f64) -> Solid {
        let EllipsoidOffset { equatorial_mm, polar_mm, offset_mm } = self.dome;
        let offset_mm = offset_mm + by_mm;
        let (radius_mm, height_mm) = (equatorial_mm + offset_mm, polar_mm + offset_mm);
        let wall_mm = self.centre_z_mm - from_z_mm;
        // The parallel surface of a sphere is a sphere; that of an ellipsoid is not an ellipsoid.
        if equatorial_mm != polar_mm && offset_mm != 0.0 {
            let dome = Solid::ellipsoid_offset(equatorial_mm, polar_mm, offset_mm);
            let dome = dome.at(0.0, 0.0, self.centre_z_mm);
            // The wall ends at the equator, where the dome is as wide and as steep as the wall.
            let wall = (wall_mm > 0.0).then(|| {
                Solid::cylinder(radius_mm, wall_mm + CUT_OVERLAP_MM).at(
                    0.0,
                    0.0,
                    from_z_mm - CUT_OVERLAP_MM,
                )
            });
            return wall.into_iter().fold(dome, Solid::plus).minus(Solid::below(from_z_mm));
        }
        let apex = [0.0, self.centre_z_mm + height_mm];
        let centre = [0.0, self.centre_z_mm];
        let start = if wall_mm > 0.0 {
            [radius_mm, self.centre_z_mm]
        } else {
            // Point of the arc at the height of the cut.
            let rise = (wall_mm / height_mm).max(-1.0);
            [radius_mm * (1.0 - rise * rise).sqrt(), from_z_mm]
        };
        let path = if wall_mm > 0.0 {
            Path::from([0.0, from_z_mm]).line([radius_mm, from_z_mm]).line(start)
        } else {
            Path::from([0.0, from_z_mm]).line(start)
        };
        let path = if radius_mm == height_mm {
            path.arc(apex, centre, true)
        } else {
            path.elliptic_arc(apex, centre, [radius_mm, height_mm], true)
        };
        Solid::revolution(path.close())
    }
}
