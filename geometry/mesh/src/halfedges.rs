//! Directed edges of triangles: edge `3 t + i` of triangle `t` runs from its corner `i` to the next.

pub(crate) fn next(edge: usize) -> usize {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

pub(crate) fn previous(edge: usize) -> usize {
    if edge.is_multiple_of(3) { edge + 2 } else { edge - 1 }
}

/// Returns the twin of each edge.
///
/// # Errors
/// An edge that has no twin.
pub(crate) fn twins(vertex_count: usize, corners: &[u32]) -> Result<Vec<u32>, usize> {
    // Bucket sort by the lower vertex: an edge and its twin share a bucket.
    let ends = |edge: usize| (corners[edge], corners[next(edge)]);
    let mut first = vec![0u32; vertex_count + 1];
    for edge in 0..corners.len() {
        let (a, b) = ends(edge);
        first[a.min(b) as usize + 1] += 1;
    }
    for v in 0..vertex_count {
        first[v + 1] += first[v];
    }
    // Within a bucket the order is by higher vertex, then by direction: twins become neighbours.
    let mut filled = first.clone();
    let mut sorted = vec![0u64; corners.len()];
    for edge in 0..corners.len() {
        let (a, b) = ends(edge);
        let slot = &mut filled[a.min(b) as usize];
        sorted[*slot as usize] = u64::from(a.max(b)) << 33 | u64::from(a > b) << 32 | edge as u64;
        *slot += 1;
    }
    let mut twins = vec![u32::MAX; corners.len()];
    for v in 0..vertex_count {
        let bucket = &mut sorted[first[v] as usize..first[v + 1] as usize];
        bucket.sort_unstable();
        let mut before = v as u64; // An edge from a vertex to itself has no twin.
        for pair in bucket.chunks(2) {
            let edge = pair[0] as u32;
            let &[one, other] = pair else { return Err(edge as usize) };
            let (higher, directions) = (one >> 33, [one, other].map(|key| key >> 32 & 1));
            if higher == before || higher != other >> 33 || directions != [0, 1] {
                return Err(edge as usize);
            }
            twins[edge as usize] = other as u32;
            twins[other as u32 as usize] = edge;
            before = higher;
        }
    }
    Ok(twins)
}
