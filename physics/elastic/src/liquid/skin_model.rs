//! Brick model of a drawn skin: grid lines along its faces, and the contents of bricks from rays cast upwards.

use fabkit_geometry::{
    BodyKind, CompiledSolid, Elasticity, InvalidSolid, LiquidSkin, Point3, Ray, Scratch, Sensor,
    TouchSurface, Vector3,
};

use crate::slab::{BrickContents, Slab};
use crate::{ElasticError, ElasticMaterial, SoftError, SoftLayer};

/// Rays across a brick, along x and along y.
const RAYS: usize = 3;
/// Faces closer than this part of the node spacing share a grid line.
const SAME_LINE: f64 = 0.3;
/// Limits of the node spacing, mm.
const SPACING_LIMITS_MM: [f64; 2] = [0.3, 3.0];

/// A soft body in its place in the sensor.
struct SoftBody {
    name: String,
    material: String,
    elasticity: Elasticity,
    solver: ElasticMaterial,
    solid: CompiledSolid,
}

/// Volume shares of one column of bricks: for each brick, those of each soft body, then of each channel.
type Shares = Vec<Vec<f64>>;

/// Grid lines and contents of a skin's bricks.
pub(super) struct SkinModel {
    pub(super) lines_mm: [Vec<f64>; 3],
    soft: Vec<SoftBody>,
    /// Shares by column of bricks, x fastest.
    columns: Vec<Shares>,
}

impl SkinModel {
    /// Divides a sensor's skin into bricks of about `spacing_mm`.
    pub(super) fn from_sensor(
        sensor: &Sensor,
        skin: &LiquidSkin,
        spacing_mm: f64,
    ) -> Result<Self, SoftError> {
        let [least, most] = SPACING_LIMITS_MM;
        if !(least..=most).contains(&spacing_mm) {
            let hint = "within 0.3 to 3 mm";
            let what = "a distance of nodes";
            return Err(ElasticError::Press { what, value: spacing_mm, hint }.into());
        }
        let soft = find_soft_bodies(sensor, skin)?;
        let channels = skin.channels.iter().map(|channel| CompiledSolid::new(&channel.liquid));
        let channels = channels.collect::<Result<Vec<_>, _>>()?;
        let lines_mm = compute_grid_lines(skin, &channels, spacing_mm)?;
        let mut drawn = Self { lines_mm, soft, columns: Vec::new() };
        let solids: Vec<&CompiledSolid> =
            drawn.soft.iter().map(|soft| &soft.solid).chain(&channels).collect();
        let columns = drawn.compute_shares(&solids);
        drawn.columns = columns;
        Ok(drawn)
    }

    /// Computes the shares of the solids in each brick by vertical rays, a grid of [`RAYS`] x [`RAYS`] per column.
    fn compute_shares(&self, solids: &[&CompiledSolid]) -> Vec<Shares> {
        let [xs, ys, zs] = &self.lines_mm;
        let (mut scratch, mut stretches) = (Scratch::default(), Vec::new());
        let mut columns = Vec::new();
        // Rays start 1 mm below the lowest grid line.
        let below_mm = zs.first().copied().unwrap_or(0.0) - 1.0;
        for y in ys.windows(2) {
            for x in xs.windows(2) {
                let mut shares = vec![vec![0.0; solids.len()]; zs.len() - 1];
                for ray in 0..RAYS * RAYS {
                    let inside = |line: &[f64], n: usize| {
                        line[0] + (line[1] - line[0]) * (n as f64 + 0.5) / RAYS as f64
                    };
                    let origin =
                        Point3::new(inside(x, ray % RAYS), inside(y, ray / RAYS), below_mm);
                    let ray = Ray { origin, direction: Vector3::z() };
                    for (which, solid) in solids.iter().enumerate() {
                        solid.stretches_into(&ray, &mut scratch, &mut stretches);
                        for (shares, z) in shares.iter_mut().zip(zs.windows(2)) {
                            let within = |[from, to]: &[f64; 2]| {
                                (to + below_mm).min(z[1]) - (from + below_mm).max(z[0])
                            };
                            let mm: f64 =
                                stretches.iter().map(|stretch| within(stretch).max(0.0)).sum();
                            shares[which] += mm / (z[1] - z[0]) / (RAYS * RAYS) as f64;
                        }
                    }
                }
                columns.push(shares);
            }
        }
        columns
    }

    /// Returns the shares of a brick: those of the soft bodies, then those of the channels.
    fn shares(&self, [i, j, k]: [usize; 3]) -> (&[f64], &[f64]) {
        self.columns[i + (self.lines_mm[0].len() - 1) * j][k].split_at(self.soft.len())
    }

    /// Returns the contents of a brick. Where several soft bodies share one, the largest share decides its material.
    pub(super) fn cell(&self, at: [usize; 3]) -> BrickContents {
        let (soft, channels) = self.shares(at);
        let all = soft.iter().sum::<f64>().min(1.0);
        let most = soft.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        // Slivers below 5 % of a brick are neglected, and rounding below 0.1 % does not make a full brick partial.
        let solid = most.filter(|_| all > 0.05).map(|(which, _)| (self.soft[which].solver, all));
        let solid = solid.map(|(m, all)| (m, if all > 0.999 { 1.0 } else { all }));
        // Rounding of rays along faces is not liquid; and a brick that counts as all liquid is filled completely.
        let share = |share: f64| if solid.is_none() && share > 0.5 { 1.0 } else { share };
        let reach = channels.iter().map(|s| share(*s)).enumerate().filter(|(_, s)| *s > 1e-6);
        BrickContents { solid, cavities: reach.collect() }
    }

    /// Returns the grid lines (x and y) of the touched surface's nodes: those around bricks that are soft at the top.
    pub(super) fn surface(&self) -> Vec<[usize; 2]> {
        let [nx, ny, nz] = [0, 1, 2].map(|axis: usize| self.lines_mm[axis].len());
        let is_soft = |i: usize, j: usize| self.cell([i, j, nz - 2]).solid.is_some();
        let mut surface = Vec::new();
        for j in 0..ny {
            for i in 0..nx {
                let beside = |n: usize, most: usize| n.saturating_sub(1)..=n.min(most - 2);
                if beside(j, ny).any(|j| beside(i, nx).any(|i| is_soft(i, j))) {
                    surface.push([i, j]);
                }
            }
        }
        surface
    }

    /// Returns pairs of nodes above and below each channel.
    pub(super) fn faces(&self, slab: &Slab, channels: usize) -> Vec<Vec<[usize; 2]>> {
        let [nx, ny, nz] = [0, 1, 2].map(|axis: usize| self.lines_mm[axis].len() - 1);
        let mut faces = vec![Vec::new(); channels];
        for j in 0..ny {
            for i in 0..nx {
                for (channel, faces) in faces.iter_mut().enumerate() {
                    // A brick that is mostly liquid belongs to the channel.
                    let is_in = |k: &usize| self.shares([i, j, *k]).1[channel] > 0.5;
                    let (Some(low), Some(high)) = ((0..nz).find(is_in), (0..nz).rev().find(is_in))
                    else {
                        continue;
                    };
                    for corner in [[i, j], [i + 1, j], [i, j + 1], [i + 1, j + 1]] {
                        let at = |k: usize| slab.node([corner[0], corner[1], k]);
                        faces.push([at(high + 1), at(low)]);
                    }
                }
            }
        }
        for faces in &mut faces {
            faces.sort_unstable();
            faces.dedup();
        }
        faces
    }

    /// Returns the soft bodies with their largest thickness anywhere.
    pub(super) fn layers(&self) -> Vec<SoftLayer> {
        let [nx, ny, nz] = [0, 1, 2].map(|axis: usize| self.lines_mm[axis].len() - 1);
        let thickness = |which: usize, i: usize, j: usize| -> f64 {
            (0..nz)
                .map(|k| {
                    let z = &self.lines_mm[2];
                    self.shares([i, j, k]).0[which] * (z[k + 1] - z[k])
                })
                .sum()
        };
        let columns = || (0..ny).flat_map(|j| (0..nx).map(move |i| [i, j]));
        let thickest =
            |which: usize| columns().map(|[i, j]| thickness(which, i, j)).fold(0.0, f64::max);
        let layers = self.soft.iter().enumerate().map(|(which, soft)| SoftLayer {
            name: soft.name.clone(),
            material: soft.material.clone(),
            thickness_mm: thickest(which),
            elasticity: soft.elasticity.clone(),
        });
        layers.filter(|layer| layer.thickness_mm > 0.0).collect()
    }

    /// Describes the simplifications.
    pub(super) fn describe_simplifications(&self, skin: &LiquidSkin) -> Vec<String> {
        let mut left_out = vec![
            "what the skin does beyond the edge of the window, which is taken to hold it".to_owned(),
            "friction: the indenter slides on the skin".to_owned(),
            "the stretch of tubes, and the liquid's weight and surface tension: columns are moved by squeezed \
             volume and shut-in air alone"
                .to_owned(),
        ];
        let lowest = skin.levels_mm.first().copied().unwrap_or(0.0);
        let hangs = |soft: &SoftBody| lowest - soft.solid.bounds().min.z > 1e-6;
        for soft in self.soft.iter().filter(|soft| hangs(soft)) {
            left_out.push(format!("the stiffness of what {} has below the skin", soft.name));
        }
        left_out
    }
}

/// Collects the soft bodies between the skin's faces, the topmost first.
fn find_soft_bodies(sensor: &Sensor, skin: &LiquidSkin) -> Result<Vec<SoftBody>, SoftError> {
    let mut soft = Vec::new();
    let [low, high] =
        [skin.levels_mm.first(), skin.levels_mm.last()].map(|z| z.copied().unwrap_or(0.0));
    for body in
        sensor.bodies.iter().filter(|body| body.kind == BodyKind::Cast || body.is_deformable)
    {
        let Some(elasticity) = &body.substance.elasticity else { continue };
        let in_sensor = |place: &&fabkit_geometry::Placement| {
            place.assembly == fabkit_geometry::Assembly::sensor()
        };
        for place in body.placements.iter().filter(in_sensor) {
            let solid = CompiledSolid::new(&body.solid.clone().placed(place.assembly_from_body))?;
            let bounds = solid.bounds();
            // Bodies above or below the skin are not part of it.
            if bounds.max.z <= low + 1e-6 || bounds.min.z >= high - 1e-6 {
                continue;
            }
            soft.push(SoftBody {
                name: body.name.clone(),
                material: body.material.clone(),
                solver: ElasticMaterial::new(elasticity.young_mpa, elasticity.poissons_ratio)?,
                elasticity: elasticity.clone(),
                solid,
            });
        }
    }
    soft.sort_by(|a, b| b.solid.bounds().max.z.total_cmp(&a.solid.bounds().max.z));
    Ok(soft)
}

/// Computes grid lines through the faces of the skin and of its channels, with even spacing between them.
fn compute_grid_lines(
    skin: &LiquidSkin,
    channels: &[CompiledSolid],
    spacing_mm: f64,
) -> Result<[Vec<f64>; 3], InvalidSolid> {
    let mut faces = [0, 1].map(|axis: usize| {
        let half = skin.window_mm[axis] / 2.0;
        vec![-half, half]
    });
    if let TouchSurface::Plane(plane) = &skin.touch {
        let bounds = fabkit_geometry::Profile::new(plane.outline.clone()).bounds_mm();
        for (faces, [min, max]) in faces.iter_mut().zip(transposed(bounds)) {
            // Edge of the sensing surface.
            faces.extend([min, max]);
        }
    }
    for channel in channels {
        let bounds = channel.bounds();
        for (axis, faces) in faces.iter_mut().enumerate() {
            faces.extend([bounds.min[axis], bounds.max[axis]]);
        }
    }
    let [x, y] = faces.map(|faces| divide_between_faces(faces, spacing_mm));
    Ok([x, y, divide_between_faces(skin.levels_mm.clone(), spacing_mm)])
}

fn transposed([[x0, y0], [x1, y1]]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [[x0, x1], [y0, y1]]
}

/// Returns lines through all faces, with nearly coincident faces merged, and evenly spaced lines between them. The
/// outermost faces are kept.
fn divide_between_faces(mut faces_mm: Vec<f64>, spacing_mm: f64) -> Vec<f64> {
    faces_mm.sort_by(f64::total_cmp);
    let last = faces_mm.last().copied().unwrap_or(0.0);
    let near_mm = SAME_LINE * spacing_mm;
    let mut kept: Vec<f64> = Vec::new();
    for mm in faces_mm {
        if kept.last().is_none_or(|before| mm - before > near_mm) && last - mm > near_mm {
            kept.push(mm);
        }
    }
    kept.push(last);
    let mut lines = vec![kept[0]];
    for pair in kept.windows(2) {
        // Rounding must not add a line where the spacing fits exactly.
        let count = ((pair[1] - pair[0]) / spacing_mm - 1e-9).ceil().max(1.0);
        let step = |n: u32| pair[0] + (pair[1] - pair[0]) * f64::from(n) / count;
        lines.extend((1..count as u32).map(step));
        lines.push(pair[1]);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_go_through_faces_and_evenly_between() {
        assert_eq!(
            divide_between_faces(vec![3.0, 0.0, 3.0, 4.0, 3.1], 1.0),
            [0.0, 1.0, 2.0, 3.0, 4.0]
        );
        assert_eq!(divide_between_faces(vec![0.0, 2.5], 1.0), [0.0, 2.5 / 3.0, 5.0 / 3.0, 2.5]);
        // The outermost face stays, whatever lies before it.
        assert_eq!(divide_between_faces(vec![0.0, 0.9, 1.0], 1.0), [0.0, 1.0]);
    }
}
