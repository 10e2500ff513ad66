//! Pieces on stock sheets.

use fabkit_export::{Bed, Drawing, NestedSheet, Operation, Piece, nest};
use fabkit_geometry::{Path, Profile};

const STOCK: Bed = Bed { size_mm: [200.0, 100.0], spacing_mm: 3.0 };

type Box2 = [[f64; 2]; 2];

fn outer_boxes(drawing: &Drawing) -> Vec<Box2> {
    let outer = drawing.contours.iter().filter(|(o, _)| *o == Operation::CutOuter);
    outer.map(|(_, path)| Profile::new(path.clone()).bounds_mm()).collect()
}

fn apart(a: &Box2, b: &Box2, gap_mm: f64) -> bool {
    (0..2).any(|i| a[1][i] + gap_mm <= b[0][i] + 1e-9 || b[1][i] + gap_mm <= a[0][i] + 1e-9)
}

fn ring(width: f64, depth: f64) -> Profile {
    Profile::new(Path::rectangle([7.0, -3.0], [width, depth], 1.0))
        .with_hole(Path::circle([7.0, -3.0], 1.0))
}

#[test]
fn pieces_and_labels_lie_in_the_stock_and_apart() {
    let profiles: Vec<(String, Profile)> = (0..14u32)
        .map(|i| {
            let side = |k: f64| 4.0 + (f64::from(i) * k).fract() * 60.0;
            (format!("piece-{i}"), ring(side(0.618_034), side(0.414_214)))
        })
        .collect();
    let pieces: Vec<Piece> = profiles
        .iter()
        .zip(1..)
        .map(|((name, profile), i)| Piece { name, profile, quantity: i % 3 + 1 })
        .collect();
    let sheets = nest(&pieces, STOCK).unwrap();
    assert!(sheets.len() > 1, "the case is meant to need several sheets");

    let mut area_mm2 = 0.0;
    for NestedSheet { drawing, used_size_mm: needs_mm, pieces } in &sheets {
        assert_eq!(drawing.size_mm, STOCK.size_mm);
        let boxes = outer_boxes(drawing);
        assert_eq!(boxes.len(), pieces.len());
        // No more than pieces, labels and the spacing need.
        for i in 0..2 {
            let ends = boxes.iter().map(|[_, end]| end[i]);
            let ends = ends.chain(drawing.strokes.iter().flatten().map(|point| point[i]));
            let least_mm = ends.fold(0.0, f64::max) + 3.0;
            assert!(needs_mm[i] >= least_mm - 1e-9, "{needs_mm:?} {least_mm}");
            assert!(needs_mm[i] <= least_mm + 1e-9, "{needs_mm:?} {least_mm}");
        }
        let strokes = drawing.strokes.iter().flatten().map(|&point| [point, point]);
        for (k, marked) in boxes.iter().copied().chain(strokes).enumerate() {
            for i in 0..2 {
                assert!(marked[0][i] >= 3.0 - 1e-9, "{marked:?}");
                assert!(marked[1][i] <= STOCK.size_mm[i] - 3.0 + 1e-9, "{marked:?}");
            }
            // Pieces keep the spacing to each other; labels keep clear of the pieces.
            let gap_mm = if k < boxes.len() { 3.0 } else { 0.9 };
            let others = boxes.iter().enumerate().filter(|(j, _)| *j != k);
            assert!(others.into_iter().all(|(_, other)| apart(&marked, other, gap_mm)));
        }
        for (operation, path) in &drawing.contours {
            let sign = if *operation == Operation::CutOuter { 1.0 } else { -1.0 };
            area_mm2 += sign * path.signed_area_mm2().abs();
        }
    }
    let wanted: f64 = pieces.iter().map(|p| f64::from(p.quantity) * p.profile.area_mm2()).sum();
    assert!((area_mm2 - wanted).abs() < 1e-9 * wanted, "{area_mm2} of {wanted} mm^2");
    let mut laid: Vec<&String> = sheets.iter().flat_map(|sheet| &sheet.pieces).collect();
    laid.sort();
    let mut names: Vec<&str> =
        pieces.iter().flat_map(|p| std::iter::repeat_n(p.name, p.quantity as usize)).collect();
    names.sort_unstable();
    assert_eq!(laid, names);
}

#[test]
fn long_pieces_are_turned_along_the_stock() {
    let plank = ring(20.0, 150.0);
    let sheets = nest(&[Piece { name: "plank", profile: &plank, quantity: 3 }], STOCK).unwrap();
    assert_eq!(sheets.len(), 1);
    for [min, max] in outer_boxes(&sheets[0].drawing) {
        assert!((max[0] - min[0] - 150.0).abs() < 1e-9 && (max[1] - min[1] - 20.0).abs() < 1e-9);
    }
}

#[test]
fn what_is_larger_than_the_stock_is_refused_by_name_and_size() {
    let slab = ring(95.0, 180.0);
    let error = nest(&[Piece { name: "slab", profile: &slab, quantity: 1 }], STOCK).unwrap_err();
    assert_eq!(
        error.to_string(),
        "slab needs 180.0 x 95.0 mm; a stock sheet of 200 x 100 mm has 194.0 x 94.0 mm"
    );
}

#[test]
fn a_piece_that_just_fits_goes_without_a_label() {
    let tight = ring(194.0, 94.0);
    let sheets = nest(&[Piece { name: "tight", profile: &tight, quantity: 2 }], STOCK).unwrap();
    assert_eq!(sheets.len(), 2);
    assert!(sheets.iter().all(|sheet| sheet.drawing.strokes.is_empty()));
}
