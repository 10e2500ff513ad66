//! Layout of parts on printer beds.

use crate::ExportError;

/// Size of a printer's bed, and the spacing to keep free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bed {
    /// Width (x) and depth (y), mm.
    pub size_mm: [f64; 2],
    /// Spacing between parts and to the edge, mm.
    pub spacing_mm: f64,
}

impl Default for Bed {
    /// Returns the 250 x 210 mm of a common desktop printer, with 5 mm spacing.
    fn default() -> Self {
        Self { size_mm: [250.0, 210.0], spacing_mm: 5.0 }
    }
}

/// Position of one item.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BedPosition {
    /// Index of the item in the list given to [`pack`].
    pub item: usize,
    /// Index of the plate, from 0.
    pub plate: usize,
    /// Corner of the item nearest to the bed's origin, mm.
    pub corner_mm: [f64; 2],
}

/// Lays rectangles out in rows on few beds: deepest first, left to right, front to back (first-fit-decreasing shelves;
/// Coffman et al., "Performance bounds for level-oriented two-dimensional packing algorithms", SIAM J. Comput. 1980).
///
/// Items are names and footprints (x, y) in mm. They are not turned, because a part's orientation belongs to its
/// design. The result is in the order of the items.
///
/// # Errors
/// [`ExportError::LargerThanBed`] for the first item that fits on no bed.
///
/// ```
/// use fabkit_export::{Bed, pack};
/// let spots = pack(&[("lid", [40.0, 20.0]), ("base", [30.0, 32.0])], Bed::default())?;
/// assert_eq!(spots[1].corner_mm, [5.0, 5.0]); // the deeper one leads the row
/// assert_eq!(spots[0].corner_mm, [40.0, 5.0]);
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
pub fn pack(items: &[(&str, [f64; 2])], bed: Bed) -> Result<Vec<BedPosition>, ExportError> {
    let gap = bed.spacing_mm;
    let usable_mm = bed.size_mm.map(|side| side - 2.0 * gap);
    for &(name, size_mm) in items {
        if size_mm[0] > usable_mm[0] || size_mm[1] > usable_mm[1] {
            return Err(ExportError::LargerThanBed { name: name.into(), size_mm, usable_mm });
        }
    }
    let mut order: Vec<usize> = (0..items.len()).collect();
    // The sort is stable: items of equal depth stay in the given order.
    order.sort_by(|&a, &b| items[b].1[1].total_cmp(&items[a].1[1]));

    struct Shelf {
        plate: usize,
        front_mm: f64,
        next_left_mm: f64,
    }
    let mut shelves: Vec<Shelf> = Vec::new();
    let mut free_front_mm: Vec<f64> = Vec::new(); // per plate, behind its last shelf
    let mut spots = Vec::with_capacity(items.len());
    for item in order {
        let [width_mm, depth_mm] = items[item].1;
        // A shelf is as deep as its first item, and no later item is deeper.
        let fits = |s: &&mut Shelf| s.next_left_mm + width_mm + gap <= bed.size_mm[0];
        if let Some(shelf) = shelves.iter_mut().find(fits) {
            let corner_mm = [shelf.next_left_mm, shelf.front_mm];
            spots.push(BedPosition { item, plate: shelf.plate, corner_mm });
            shelf.next_left_mm += width_mm + gap;
            continue;
        }
        let has_room = |front: &f64| front + depth_mm + gap <= bed.size_mm[1];
        // First plate with room for another shelf, or a new one.
        let plate = free_front_mm.iter().position(has_room).unwrap_or_else(|| {
            free_front_mm.push(gap);
            free_front_mm.len() - 1
        });
        let front_mm = free_front_mm[plate];
        free_front_mm[plate] += depth_mm + gap;
        spots.push(BedPosition { item, plate, corner_mm: [gap, front_mm] });
        shelves.push(Shelf { plate, front_mm, next_left_mm: gap + width_mm + gap });
    }
    spots.sort_by_key(|spot| spot.item);
    Ok(spots)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn overlap_or_touch(a: [f64; 4], b: [f64; 4], gap: f64) -> bool {
        let apart = |i: usize| a[i + 2] + gap <= b[i] + 1e-9 || b[i + 2] + gap <= a[i] + 1e-9;
        !(apart(0) || apart(1))
    }

    #[test]
    fn nothing_overlaps_nothing_sticks_out_nothing_is_lost() {
        let bed = Bed::default();
        // Sizes without a common measure, up to the whole bed.
        let sizes: Vec<[f64; 2]> = (0..120)
            .map(|i| {
                let f = |k: f64| 3.0 + (f64::from(i) * k).fract() * 90.0;
                [f(0.618_034), f(0.414_214)]
            })
            .chain([[240.0, 200.0]])
            .collect();
        let items: Vec<_> = sizes.iter().map(|&size| ("part", size)).collect();
        let spots = pack(&items, bed).unwrap();
        let rectangles: Vec<(usize, [f64; 4])> = spots
            .iter()
            .enumerate()
            .map(|(i, spot)| {
                assert_eq!(spot.item, i);
                let ([x, y], [w, d]) = (spot.corner_mm, sizes[i]);
                assert!(x >= 5.0 && y >= 5.0 && x + w <= 245.0 && y + d <= 205.0, "{spot:?}");
                (spot.plate, [x, y, x + w, y + d])
            })
            .collect();
        for (i, (plate, a)) in rectangles.iter().enumerate() {
            for (other_plate, b) in &rectangles[..i] {
                assert!(plate != other_plate || !overlap_or_touch(*a, *b, 5.0), "{a:?} {b:?}");
            }
        }
        let area: f64 = sizes.iter().map(|[w, d]| w * d).sum();
        let plates = rectangles.iter().map(|(plate, _)| plate + 1).max().unwrap();
        assert!((plates as f64) < 2.0 * area / (250.0 * 210.0) + 2.0, "{plates} plates");
    }

    #[test]
    fn what_is_larger_than_the_bed_is_refused_by_name() {
        let error = pack(&[("small", [10.0, 10.0]), ("slab", [10.0, 201.0])], Bed::default());
        let message = error.unwrap_err().to_string();
        assert_eq!(message, "slab needs 10.0 x 201.0 mm of the bed; 240 x 200 mm are usable");
    }
}
