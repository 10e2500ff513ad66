//! Simplification of tools beyond the base's box.
//!
//! The result of a cut depends only on which points of the base the tool encloses. So the part of its surface beyond a
//! plane that the base does not reach may be replaced by any other surface there with the same boundary.

use fabkit_geometry::Aabb;

use crate::facets::Facets;
use crate::halfedges::{next, twins};

/// Smallest distance outside the box of triangles that may be removed, mm.
const CLEAR_MM: f64 = 0.5;

/// Smallest number of removable triangles that makes the search worth while.
const MIN_REMOVABLE_TRIANGLES: usize = 400;

/// Removes the triangles beyond one side of the box, the one with most of them; `None` if that is not worth while.
pub(super) fn cull_beyond_base(tool: &Facets, base: &Aabb) -> Option<Facets> {
    if tool.triangles.len() < MIN_REMOVABLE_TRIANGLES {
        return None;
    }
    let sides = [0, 1, 2].into_iter().flat_map(|axis| [(axis, -1.0), (axis, 1.0)]);
    let beyond = |(axis, sign): (usize, f64)| -> Vec<bool> {
        // Along the negative axes coordinates are compared with reversed sign.
        let limit = if sign < 0.0 { -base.min[axis] } else { base.max[axis] } + CLEAR_MM;
        let is_out: Vec<bool> = tool.vertices.iter().map(|v| sign * v[axis] > limit).collect();
        tool.triangles.iter().map(|t| t.iter().all(|&v| is_out[v as usize])).collect()
    };
    let count = |gone: &[bool]| gone.iter().filter(|g| **g).count();
    let gone = sides.map(beyond).max_by_key(|gone| count(gone))?;
    if count(&gone) < MIN_REMOVABLE_TRIANGLES {
        return None;
    }
    let mut rest = Facets { vertices: tool.vertices.clone(), ..Facets::default() };
    for ((&triangle, &face), _) in
        tool.triangles.iter().zip(&tool.faces).zip(&gone).filter(|t| !t.1)
    {
        rest.triangle(triangle, face);
    }
    close(&mut rest, tool, &gone)?;
    Some(without_unused(rest))
}

/// Closes each loop that the missing triangles leave open by a fan of triangles, which lies within the loop's convex
/// hull.
fn close(rest: &mut Facets, tool: &Facets, gone: &[bool]) -> Option<()> {
    let corners = tool.triangles.as_flattened();
    let twins = twins(tool.vertices.len(), corners).ok()?;
    // Edges of missing triangles whose neighbour stays, sorted by start vertex.
    let mut rim: Vec<[u32; 2]> = (0..corners.len())
        .filter(|&edge| gone[edge / 3] && !gone[twins[edge] as usize / 3])
        .map(|edge| [corners[edge], corners[next(edge)]])
        .collect();
    rim.sort_unstable();
    if rim.windows(2).any(|w| w[0][0] == w[1][0]) {
        return None; // Two loops touch.
    }
    let mut used = vec![false; rim.len()];
    for start in 0..rim.len() {
        let mut chain = Vec::new();
        let mut at = start;
        while !used[at] {
            used[at] = true;
            chain.push(rim[at]);
            at = rim.binary_search_by_key(&rim[at][1], |edge| edge[0]).ok()?;
        }
        if chain.is_empty() {
            continue;
        }
        let share = 1.0 / chain.len() as f64;
        let mut centre = [0.0; 3];
        for [from, _] in &chain {
            let point = tool.vertices[*from as usize];
            centre = std::array::from_fn(|i| centre[i] + share * point[i]);
        }
        let centre = rest.vertex(centre);
        for [from, to] in chain {
            // The face number does not matter: these triangles lie outside of the base.
            rest.triangle([from, to, centre], tool.faces[0]);
        }
    }
    Some(())
}

fn without_unused(facets: Facets) -> Facets {
    const UNUSED: u32 = u32::MAX;
    let mut new_index = vec![UNUSED; facets.vertices.len()];
    let mut kept = Facets::default();
    for (triangle, &face) in facets.triangles.iter().zip(&facets.faces) {
        let corners = triangle.map(|v| {
            if new_index[v as usize] == UNUSED {
                new_index[v as usize] = kept.vertex(facets.vertices[v as usize]);
            }
            new_index[v as usize]
        });
        kept.triangle(corners, face);
    }
    kept
}
