//! Directed edges of triangles: edge `3 t + i` of triangle `t` runs from its corner `i` to the next.

pub(crate) fn next(edge: usize) -> usize {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

pub(crate) fn previous(edge: usize) -> usize {
    if edge.is_multiple_of(3) { edge + 2 } else { edge - 1 }
}

/// The twin of each edge, or an edge that has none.
pub(crate) fn twins(vertex_count: usize, corners: &[u32]) -> Result<Vec<u32>, usize> {
    // Edges sorted into buckets by their lower vertex: an edge and its twin share a bucket.
    let ends = |edge: usize| (corners[edge], corners[next(edge)]);
    let mut first = vec![0u32; vertex_count + 1];
    for edge in 0..corners.len() {
        let (a, b) = ends(edge);
        first[a.min(b) as usize + 1] += 1;
    }
    for v in 0..vertex_count {
        first[v + 1] += first[v];
    }
    let mut filled = first.clone();
    let mut sorted = vec![0u32; corners.len()];
    for edge in 0..corners.len() {
        let (a, b) = ends(edge);
        let slot = &mut filled[a.min(b) as usize];
        sorted[*slot as usize] = edge as u32;
        *slot += 1;
    }
    let mut twins = vec![u32::MAX; corners.len()];
    for v in 0..vertex_count {
        let bucket = &sorted[first[v] as usize..first[v + 1] as usize];
        for &edge in bucket {
            let (a, b) = ends(edge as usize);
            let mut same = bucket.iter().filter(|&&e| ends(e as usize) == (a, b));
            let mut opposite = bucket.iter().filter(|&&e| ends(e as usize) == (b, a));
            match (same.nth(1), opposite.next(), opposite.next()) {
                (None, Some(&twin), None) if a != b => twins[edge as usize] = twin,
                _ => return Err(edge as usize),
            }
        }
    }
    Ok(twins)
}
