//! Layers that are meshed and ready to be pressed.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use fabkit_geometry::{Point3, Vector3};

use crate::SolverResources;
use crate::compliance::{self, Compliance, LoadSet};
use crate::contact;
use crate::friction::{self, ShearPath};
use crate::indenter::{Indenter, Press};
use crate::mesh::Mesh;
use crate::outcome::PressOutcome;
use crate::patch::{Patch, Workspace};
use crate::rings::Rings;
use crate::{ElasticError, LayeredBody, MeshDensity};

/// Maximum slope between indenter and surface. Where the gap grows faster than this between two points, they face
/// different parts of the indenter.
const MAX_GAP_SLOPE: f64 = 4.0;

/// A meshed body with cached compliances: built once for a design, then pressed any number of times.
///
/// ```
/// use fabkit_elastic::{BallIndenter, ElasticLayer, ElasticMaterial, ElasticStack, LayeredBody};
/// use fabkit_elastic::{MeshDensity, Press};
/// use fabkit_geometry::{Point3, Vector3};
///
/// // Gel so thick that a small press follows Hertz: 4/3 E / (1 - nu^2) sqrt(R) d^1.5.
/// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.1, 0.3)? };
/// let block = LayeredBody::pad(40.0, vec![(gel, 40.0)]);
/// let stack = ElasticStack::new(&block, &MeshDensity::around_pole(0.05, 1.5, 0), 1)?;
/// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 50.0), 4.0)?;
/// let outcome = stack.press(&ball, &Press::along(-Vector3::z(), 0.25)?)?;
/// let hertz_n = 4.0 / 3.0 * 0.1 / (1.0 - 0.3 * 0.3) * 2.0 * 0.125;
/// assert!((-outcome.force_n.z / hertz_n - 1.0).abs() < 0.03);
/// # Ok::<(), fabkit_elastic::ElasticError>(())
/// ```
#[derive(Debug)]
pub struct ElasticStack {
    pub(crate) mesh: Arc<Mesh>,
    pub(crate) rings: Rings,
    /// Volume change of each layer by harmonic 0 of each component and ring, component after component, mm3/MPa.
    pub(crate) dilations: Vec<Vec<f64>>,
    /// Total thickness of the layers at each mesh column, mm.
    thickness_mm: Vec<f64>,
    resources: SolverResources,
    cached: Mutex<Option<CachedCompliances>>,
}

/// Compliances solved so far.
#[derive(Clone, Debug)]
struct CachedCompliances {
    loads: LoadSet,
    /// Compliances by harmonic.
    compliances: Arc<Vec<Compliance>>,
}

impl ElasticStack {
    /// Meshes a body. Compliances are solved on demand with these threads and this memory, and kept. Results depend neither on
    /// the number of threads nor on earlier presses.
    ///
    /// # Errors
    /// An invalid body or division.
    pub fn new(
        body: &LayeredBody,
        division: &MeshDensity,
        resources: impl Into<SolverResources>,
    ) -> Result<Self, ElasticError> {
        let mesh = Mesh::new(body, division)?;
        let rings = Rings::new(&mesh, division.max_harmonic);
        let dilations = compliance::dilations(&mesh, &rings)?;
        let last = mesh.interface_rows.len() - 1;
        let thickness = |column: usize| {
            let [outer, inner] = [0, last].map(|i| mesh.nodes[mesh.interface_node(i, column)]);
            (outer[0] - inner[0]).hypot(outer[1] - inner[1])
        };
        let thickness_mm = (0..mesh.columns).map(thickness).collect();
        let (mesh, answers) = (Arc::new(mesh), Mutex::new(None));
        let resources = resources.into();
        Ok(Self { mesh, rings, dilations, thickness_mm, resources, cached: answers })
    }

    /// Solves for presses anywhere at once. Otherwise each press that touches new rings solves again.
    ///
    /// # Errors
    /// Matrices that exceed the memory limit.
    ///
    /// ```
    /// use fabkit_elastic::{BallIndenter, ElasticLayer, ElasticMaterial, ElasticStack, LayeredBody};
    /// use fabkit_elastic::{MeshDensity, Press};
    /// use fabkit_geometry::{Point3, Vector3};
    ///
    /// // It costs time once, and changes no result.
    /// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
    /// let pad = LayeredBody::pad(10.0, vec![(gel, 2.0)]);
    /// let density = MeshDensity::around_pole(0.2, 2.0, 0);
    /// let stack = ElasticStack::new(&pad, &density, 1)?;
    /// let solved = ElasticStack::new(&pad, &density, 1)?.solve_everywhere(false)?;
    /// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 9.0), 3.0)?;
    /// let press = Press::along(-Vector3::z(), 0.3)?;
    /// let [first, second] = [stack.press(&ball, &press)?, solved.press(&ball, &press)?];
    /// assert!((first.force_n.z - second.force_n.z).abs() < 1e-12);
    /// # Ok::<(), fabkit_elastic::ElasticError>(())
    /// ```
    pub fn solve_everywhere(self, is_dragged: bool) -> Result<Self, ElasticError> {
        self.compliances(&(0..self.rings.rings.len()), is_dragged)?;
        Ok(self)
    }

    /// Returns the compliances by harmonic for tractions on `rings`, from the cache if they are in it.
    fn compliances(
        &self,
        rings: &Range<usize>,
        is_dragged: bool,
    ) -> Result<Arc<Vec<Compliance>>, ElasticError> {
        let mut loads = LoadSet::new(rings, is_dragged, self.rings.rings.len());
        let kept = self.cached.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Some(kept) = kept {
            if kept.loads.contains(&loads) {
                return Ok(kept.compliances);
            }
            loads = loads.union(&kept.loads);
        }
        // Without the lock: a thread pool that shares out work under a lock may be handed work that waits for the same
        // lock.
        let solved = compliance::solve_all(&self.mesh, &self.rings, &loads, self.resources)?;
        let compliances = Arc::new(solved);
        let answers = CachedCompliances { loads, compliances: Arc::clone(&compliances) };
        *self.cached.lock().unwrap_or_else(PoisonError::into_inner) = Some(answers);
        Ok(compliances)
    }

    /// Number of nodes of the touched surface.
    pub fn surface_nodes(&self) -> usize {
        self.rings.nodes
    }

    /// Returns the number of unknown displacements of one harmonic, and the highest harmonic.
    ///
    /// ```
    /// use fabkit_elastic::{ElasticLayer, ElasticMaterial, ElasticStack, LayeredBody, MeshDensity};
    ///
    /// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
    /// let pad = LayeredBody::pad(10.0, vec![(gel, 2.0)]);
    /// let unknowns = |spacing_mm| {
    ///     let stack = ElasticStack::new(&pad, &MeshDensity::uniform(spacing_mm, 8), 1)?;
    ///     Ok(stack.unknowns_and_max_harmonic())
    /// };
    /// // Two elements through the gel: four rows of nodes that move, with three displacements each, above the floor.
    /// assert_eq!(unknowns(1.0)?, [3 * 4 * 11, 8]);
    /// assert_eq!(unknowns(0.5)?, [3 * 4 * 21, 8]);
    /// # Ok::<(), fabkit_elastic::ElasticError>(())
    /// ```
    pub fn unknowns_and_max_harmonic(&self) -> [usize; 2] {
        let free = self.mesh.is_fixed.iter().filter(|is_fixed| !**is_fixed).count();
        [3 * free, self.rings.harmonics()]
    }

    /// Returns a point of the undeformed touched surface and its outward normal, for a mesh column and an azimuth.
    pub(crate) fn place(&self, column: usize, azimuth: f64) -> (Point3<f64>, Vector3<f64>) {
        let [r, z] = self.mesh.nodes[column * self.mesh.rows];
        let [n_r, n_z] = self.mesh.frames[column].normal;
        let (sin, cos) = azimuth.sin_cos();
        (Point3::new(r * cos, r * sin, z), Vector3::new(n_r * cos, n_r * sin, n_z))
    }

    /// Computes how far an indenter must move along `direction` to touch the undeformed surface, mm.
    ///
    /// # Errors
    /// An indenter whose path misses the surface, or that starts inside the body.
    ///
    /// ```
    /// use fabkit_elastic::{BallIndenter, ElasticError, ElasticLayer, ElasticMaterial, ElasticStack};
    /// use fabkit_elastic::{LayeredBody, MeshDensity};
    /// use fabkit_geometry::{Point3, Vector3};
    ///
    /// // The pad's face is at z = 2 mm; the lowest point of the ball at 10 mm - 3 mm.
    /// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
    /// let pad = LayeredBody::pad(10.0, vec![(gel, 2.0)]);
    /// let stack = ElasticStack::new(&pad, &MeshDensity::uniform(0.5, 0), 1)?;
    /// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 10.0), 3.0)?;
    /// assert!((stack.touching_mm(&ball, &-Vector3::z())? - 5.0).abs() < 1e-9);
    /// // Upwards there is nothing to touch: the pad lies behind the ball.
    /// assert!(matches!(stack.touching_mm(&ball, &Vector3::z()), Err(ElasticError::StartsInside { .. })));
    /// # Ok::<(), ElasticError>(())
    /// ```
    pub fn touching_mm(
        &self,
        presser: &dyn Indenter,
        direction: &Vector3<f64>,
    ) -> Result<f64, ElasticError> {
        let direction = direction.normalize();
        // Longer than any distance within a sensor: everything ahead counts, and a start inside shows as a negative
        // gap.
        let far_mm = 1e3;
        let way = |place: &Point3<f64>| presser.gap_mm(place, &-direction, far_mm);
        let (mut best_mm, mut best) = (f64::INFINITY, [0.0, 0.0]);
        for (ring, of_ring) in self.rings.rings.iter().enumerate() {
            for node in 0..of_ring.count {
                let azimuth = self.rings.azimuth(ring, node);
                let way_mm = way(&self.place(ring, azimuth).0);
                if way_mm < best_mm {
                    (best_mm, best) = (way_mm, [self.mesh.s[ring], azimuth]);
                }
            }
        }
        if !best_mm.is_finite() {
            return Err(ElasticError::NoContact { gap_mm: best_mm });
        }
        if best_mm < 0.0 {
            return Err(ElasticError::StartsInside { inside_mm: -best_mm });
        }
        // Refinement between nodes: a pattern search along s and the azimuth, with steps that are halved.
        let mut steps = [0.5 / self.rings.rings.len() as f64, 0.1];
        while steps[0] > 1e-9 {
            let mut is_better = false;
            for (k, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
                let mut there = best;
                there[k] += sign * steps[k];
                there[0] = there[0].clamp(0.0, 1.0);
                let way_mm = way(&self.mesh.surface_place(there[0], there[1]));
                if way_mm < best_mm {
                    (best_mm, best, is_better) = (way_mm, there, true);
                }
            }
            if !is_better {
                steps = steps.map(|step| 0.5 * step);
            }
        }
        Ok(best_mm)
    }

    /// Presses an indenter into the body.
    ///
    /// # Errors
    /// An indenter that does not touch, goes deeper than the soft layers, or is too small for the nodes; a contact that
    /// does not converge.
    ///
    /// ```
    /// use fabkit_elastic::{BallIndenter, ElasticError, ElasticLayer, ElasticMaterial, ElasticStack};
    /// use fabkit_elastic::{LayeredBody, MeshDensity, Press};
    /// use fabkit_geometry::{Point3, Vector3};
    ///
    /// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
    /// let pad = LayeredBody::pad(10.0, vec![(gel, 2.0)]);
    /// let stack = ElasticStack::new(&pad, &MeshDensity::around_pole(0.1, 2.0, 0), 1)?;
    /// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 9.0), 3.0)?;
    /// let press = |depth_mm| stack.press(&ball, &Press::along(-Vector3::z(), depth_mm)?);
    /// // The gel is pushed down, and what is pressed away bulges beside the ball.
    /// let outcome = press(0.3)?;
    /// assert!(outcome.force_n.z < 0.0 && outcome.bulge_mm > 0.0);
    /// assert!((outcome.max_indentation_mm - 0.3).abs() < 0.003);
    /// assert!(matches!(press(2.5), Err(ElasticError::TooDeep { .. })));
    /// # Ok::<(), ElasticError>(())
    /// ```
    pub fn press(
        &self,
        presser: &dyn Indenter,
        press: &Press,
    ) -> Result<PressOutcome, ElasticError> {
        let shift_mm = match &press.approach {
            Some((direction, depth_mm)) => {
                // Depths count from the first touch.
                (self.touching_mm(presser, direction)? + depth_mm) * direction
            }
            None => Vector3::zeros(),
        };
        let is_sheared = press.shear_mm != Vector3::zeros();
        let (mut rings, depth_mm) = self.find_touched_rings(presser, &shift_mm)?;
        if is_sheared {
            if self.rings.harmonics() == 0 {
                let hint = "0: what is symmetric about the axis has no shear";
                let value = press.shear_mm.norm();
                return Err(ElasticError::Press { what: "a shear without harmonics", value, hint });
            }
            // The patch must hold the contact at the begin and at the end of the shear.
            let (end, _) = self.find_touched_rings(presser, &(shift_mm + press.shear_mm))?;
            rings = rings.start.min(end.start)..rings.end.max(end.end);
        }
        let answers = self.compliances(&rings, is_sheared)?;
        let patch = Patch { stack: self, rings, compliances: answers };
        let gaps = self.gaps(&patch, presser, &shift_mm, depth_mm);
        let mut work = Workspace::default();
        let mut contact = contact::solve(&patch, &gaps, depth_mm, None, &mut work)?;
        if contact.pressures.iter().all(|pressure| *pressure == 0.0) {
            return Err(ElasticError::TooCoarse { depth_mm });
        }
        let mut shear = None;
        if is_sheared {
            let way = ShearPath { presser, press, shift_mm, depth_mm };
            let (sheared, tractions) = friction::solve(&patch, &way, contact, &mut work)?;
            (contact, shear) = (sheared, Some(tractions));
        }
        let outcome =
            PressOutcome::new(&patch, &contact, shear.as_ref(), press, depth_mm, &mut work);
        // Linear elasticity cannot raise a bulge above the depth of the press; such a result is numerical nonsense.
        if outcome.bulge_mm > depth_mm {
            return Err(ElasticError::NoConvergence {
                what: "the bulge around a press, which is higher than the press is deep,",
                iterations: contact.iterations,
                residual: outcome.bulge_mm,
                tolerance: depth_mm,
            });
        }
        Ok(outcome)
    }

    /// Finds the rings that can be touched and the depth of the indenter, mm.
    fn find_touched_rings(
        &self,
        presser: &dyn Indenter,
        shift_mm: &Vector3<f64>,
    ) -> Result<(Range<usize>, f64), ElasticError> {
        let mut least = Vec::with_capacity(self.rings.rings.len());
        for (ring, of_ring) in self.rings.rings.iter().enumerate() {
            let mut least_mm = f64::INFINITY;
            // Parts of the indenter below the soft layers are on the far side of the body.
            let reach_mm = self.thickness_mm[ring];
            for node in 0..of_ring.count {
                let (place, outward) = self.place(ring, self.rings.azimuth(ring, node));
                let gap_mm = presser.gap_mm(&(place - shift_mm), &outward, reach_mm);
                if gap_mm.is_nan() {
                    let hint = "a distance";
                    return Err(ElasticError::Press { what: "a gap", value: gap_mm, hint });
                }
                if gap_mm <= -reach_mm {
                    return Err(ElasticError::TooDeep {
                        depth_mm: -gap_mm,
                        thickness_mm: reach_mm,
                        place_mm: [place.x, place.y, place.z],
                    });
                }
                least_mm = least_mm.min(gap_mm);
            }
            self.check_symmetry(ring, least_mm, presser, shift_mm)?;
            least.push(least_mm);
        }
        let gap_mm = least.iter().copied().fold(f64::INFINITY, f64::min);
        if gap_mm >= 0.0 {
            return Err(ElasticError::NoContact { gap_mm });
        }
        // The surface bulges around a press, but never by more than the press is deep.
        let can_touch = |gap: &f64| *gap <= -gap_mm;
        let first = least.iter().position(can_touch).unwrap_or(0);
        let last = least.iter().rposition(can_touch).unwrap_or(0);
        Ok((first..last + 1, -gap_mm))
    }

    /// Checks that the indenter is axisymmetric if the body has no harmonics of the azimuth.
    fn check_symmetry(
        &self,
        ring: usize,
        gap_mm: f64,
        presser: &dyn Indenter,
        shift_mm: &Vector3<f64>,
    ) -> Result<(), ElasticError> {
        if self.rings.rings[ring].count > 1 || ring == 0 {
            return Ok(());
        }
        // Three azimuths without a common symmetry serve as samples.
        for azimuth in [1.0, 2.5, 4.4] {
            let (place, outward) = self.place(ring, azimuth);
            let other_mm = presser.gap_mm(&(place - shift_mm), &outward, self.thickness_mm[ring]);
            if (other_mm - gap_mm).abs() > 1e-6 * (1.0 + gap_mm.abs()) {
                let hint = "0: without harmonics an indenter must be symmetric about the axis";
                let value = other_mm - gap_mm;
                return Err(ElasticError::Press {
                    what: "a difference of gaps around",
                    value,
                    hint,
                });
            }
        }
        Ok(())
    }

    /// Computes the mean gap around each node, mm, weighted as displacements are; infinite where nothing can touch.
    pub(crate) fn gaps(
        &self,
        patch: &Patch<'_>,
        presser: &dyn Indenter,
        shift_mm: &Vector3<f64>,
        depth_mm: f64,
    ) -> Vec<f64> {
        let mut gaps = Vec::with_capacity(patch.nodes());
        for ring in patch.rings.clone() {
            let of_ring = &self.rings.rings[ring];
            for node in 0..of_ring.count {
                let azimuth = self.rings.azimuth(ring, node);
                let gap = |column: usize| {
                    let (place, outward) = self.place(column, azimuth);
                    presser.gap_mm(&(place - shift_mm), &outward, self.thickness_mm[column])
                };
                let own_mm = gap(ring);
                gaps.push(if own_mm <= depth_mm {
                    let share_of = |&(column, share): &(usize, f64)| {
                        let gap_mm = if column == ring { own_mm } else { gap(column) };
                        // A neighbour that much higher faces another part of the indenter, such as a shank or a
                        // holder.
                        let apart_mm = self.apart_mm(ring, column);
                        let is_met = gap_mm - own_mm <= MAX_GAP_SLOPE * apart_mm;
                        share * if is_met { gap_mm } else { f64::INFINITY }
                    };
                    let mean =
                        of_ring.column_weights.iter().map(share_of).sum::<f64>() / of_ring.weight;
                    // Neighbours miss the indenter: the node is at its edge. This also replaces NaN.
                    if mean.is_finite() { mean } else { f64::INFINITY }
                } else {
                    f64::INFINITY
                });
            }
        }
        gaps
    }

    /// Distance of two columns of the touched surface, mm.
    fn apart_mm(&self, one: usize, other: usize) -> f64 {
        let [a, b] = [one, other].map(|column| self.mesh.nodes[column * self.mesh.rows]);
        (a[0] - b[0]).hypot(a[1] - b[1])
    }

    /// Computes the largest violation of reciprocity (action of one node on another against the reverse), relative to
    /// the largest compliance. Only rounding should remain.
    ///
    /// # Errors
    /// Matrices that exceed the memory limit.
    pub fn asymmetry(&self) -> Result<f64, ElasticError> {
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        for block in &*self.compliances(&(0..self.rings.rings.len()), true)? {
            let n = 3 * block.rings;
            let weight = |i: usize| self.rings.rings[block.first + i % block.rings].weight;
            for i in 0..n {
                for j in 0..i {
                    let (a, b) = (
                        block.contact[j * n + i] * weight(i),
                        block.contact[i * n + j] * weight(j),
                    );
                    worst = worst.max((a - b).abs());
                }
                largest = largest.max(block.contact[i * n + i] * weight(i));
            }
        }
        Ok(worst / largest)
    }
}
