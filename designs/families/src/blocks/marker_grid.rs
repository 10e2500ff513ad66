//! Dots that are printed on a flat face through a stencil: a grid around the middle, or listed positions.

use fabkit_geometry::{
    Body, CUT_OVERLAP_MM, Length, Marker, MarkerCarrier, Path, Pose, Process, Profile, Shells,
    Solid,
};

use super::listed_markers::{FlatPattern, ListedMarkers};
use super::{Rect, copies, upright};
use crate::chain_builder::STEEL;
use crate::materials::Castable;
use crate::parameters;
use crate::parameters::{RuleReport, limits};

parameters! {
    /// Dots printed on the gel, under the coat: a grid around the middle, or a list.
    pub struct Markers {
        /// Pattern of the dots: a `grid` of `columns` and `rows`, or a `list` of positions `x` and `y`.
        pattern: FlatPattern,
        /// For a list: x of each dot.
        x: Vec<Length> = (1..=1000, -60.0..=60.0),
        /// For a list: y of each dot.
        y: Vec<Length> = (1..=1000, -60.0..=60.0),
        /// Number of dots along x; 0 for none.
        columns: u32 = 0..=60,
        /// Number of dots along y; 0 for none.
        rows: u32 = 0..=60,
        /// Distance between neighbouring dots.
        spacing: Length = 0.2..=20.0,
        /// Diameter of a dot.
        diameter: Length = 0.1..=5.0,
        /// Thickness of the ink.
        thickness: Length = 0.005..=0.5,
        /// Trade name of the ink.
        material: Castable,
    }
}

crate::bodies! {
    /// Ink of the dots.
    pub MARKERS "markers" "dots on the gel";
    /// Stencil that the ink is dabbed through.
    pub STENCIL "marker-stencil" "film that ink is dabbed through";
}

/// Thickness of the stencil, mm.
const STENCIL_MM: f64 = 0.1;

/// Smallest web of film between two holes, mm.
const WEB_MM: f64 = 0.2;

impl Markers {
    /// Returns whether there are any dots.
    pub fn has_dots(&self) -> bool {
        self.pattern == FlatPattern::List || self.columns > 0 && self.rows > 0
    }

    /// Returns the poses of the dots on a face at height `z`, z axis up: row by row from below, or as listed.
    pub fn poses(&self, z: f64) -> Vec<Pose> {
        if self.pattern == FlatPattern::List {
            return self.listed().points_mm().into_iter().map(|place| upright(place, z)).collect();
        }
        let at = |i: u32, of: u32| self.spacing.mm() * (f64::from(i) - f64::from(of - 1) / 2.0);
        let row = |row| (0..self.columns).map(move |c| [at(c, self.columns), at(row, self.rows)]);
        (0..self.rows).flat_map(row).map(|place| upright(place, z)).collect()
    }

    /// Returns the listed dots.
    fn listed(&self) -> ListedMarkers<'_, Length> {
        ListedMarkers::new("dot", ("markers.x", &self.x), ("markers.y", &self.y))
    }

    /// Returns the dots as discs on the face.
    fn dots(&self, z: f64, bottom: f64) -> Vec<Solid> {
        let dot = Solid::rod(self.diameter.mm() / 2.0, [bottom, self.thickness.mm()]);
        copies("marker", &self.poses(z), &dot)
    }

    /// Returns the volumes that the dots take from the layer that covers the face; they extend below the face.
    pub fn tools(&self, z: f64) -> Vec<Solid> {
        self.dots(z, -CUT_OVERLAP_MM)
    }

    /// Returns the ink; `None` without dots.
    pub fn ink(&self, z: f64) -> Option<Body> {
        let dots = self.dots(z, 0.0);
        let pieces = Shells::pieces(dots.len());
        self.has_dots().then(|| {
            MARKERS
                .cast(Solid::union(dots))
                .as_deformable()
                .with_material(&self.material)
                .colored([40, 40, 44])
                .with_shells(pieces)
        })
    }

    /// Returns the dots as markers that the camera tracks.
    pub fn marks(&self, z: f64) -> Vec<Marker> {
        let radius_mm = self.diameter.mm() / 2.0;
        Marker::place_below_poses("dot", &self.poses(z), 0.0, radius_mm, |_| MarkerCarrier::Gel)
    }

    /// Returns the stencil that lies on the face edge on edge; `None` without dots.
    pub fn stencil(&self, face: Rect, z: f64) -> Option<Body> {
        let poses = self.poses(z);
        let profile = poses.iter().fold(Profile::new(face.path()), |profile, pose| {
            let at = pose.translation_mm();
            profile.with_hole(Path::circle([at.x, at.y], self.diameter.mm() / 2.0))
        });
        let film = Solid::prism(profile, [z, z + STENCIL_MM]);
        self.has_dots().then(|| {
            STENCIL
                .made(Process::Laser, film)
                .with_material("PET film")
                .colored(STEEL)
                .with_handles(poses.len() as i32)
        })
    }

    /// Reports dots that overlap, or lie where the camera does not see them: `seen` is the visible half width and half
    /// height, `face` the flat area. The section must be called `markers`.
    pub fn check(&self, face: Rect, seen: [f64; 2], report: &mut RuleReport) {
        if !self.has_dots() {
            return;
        }
        let markers = self;
        let room = [0, 1].map(|i| 2.0 * seen[i].min(face.half[i] - WEB_MM));
        let most = room.map(|mm| ((mm - self.diameter.mm()) / self.spacing.mm()).max(0.0) + 1.0);
        if self.pattern == FlatPattern::List {
            let listed = self.listed();
            listed.check_lengths(report);
            let seen = ("dots lie whole on what the camera sees", "`markers.diameter`");
            for (axis, mm) in room.into_iter().enumerate() {
                listed.check_within(axis, (mm - self.diameter.mm()) / 2.0, seen, report);
            }
            let web = ("the stencil needs 0.2 mm between them", "`markers.diameter`");
            return listed.check_apart_on_plane(self.diameter.mm() + WEB_MM, web, report);
        }
        let [x, y] =
            room.map(|mm| format!("dots lie whole on the {mm:.2} mm that the camera sees"));
        limits! { report:
            markers.diameter <= self.spacing.mm() - WEB_MM,
                "the stencil needs 0.2 mm between neighbours";
            markers.columns <= most[0], x;
            markers.rows <= most[1], y;
        }
    }
}
