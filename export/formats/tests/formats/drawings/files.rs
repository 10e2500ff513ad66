//! DXF and SVG files contain the drawing.

use std::collections::BTreeSet;

use fabkit_export::{Bed, DocumentInfo, Drawing, ExportError, Operation, Piece, dxf, nest, svg};
use fabkit_geometry::{Angle, Path, Profile};

use super::readers::{Read, area_mm2, groups, read_dxf, read_svg};

const DOCUMENT: DocumentInfo =
    DocumentInfo { title: "Test: <plate> & \u{b5}", design_hash: "0123abcd" };

/// Lines, arcs of both directions, an arc of more than half a circle, a slot, whole circles.
fn plate() -> Profile {
    let degrees = |d| Angle::from_deg(d).unwrap();
    let keyhole = Path::from([-0.5, -0.2]).line([-0.5, -2.0]).line([0.5, -2.0]);
    let keyhole = keyhole.line([0.5, -0.2]).arc([-0.5, -0.2], [0.0, 0.5], true);
    Profile::new(Path::rectangle([0.0, 0.0], [60.0, 40.0], 4.0))
        .with_hole(Path::circle([-20.0, 10.0], 1.0 / 3.0))
        .with_hole(Path::slot([10.0, 10.0], [20.0, 13.0], 2.0))
        .with_hole(Path::ring_sector(8.0, 12.0, degrees(200.0), degrees(320.0)))
        .with_hole(keyhole)
}

fn enclosed_mm2(read: &Read) -> f64 {
    let signed = |layer: &str| match layer {
        "CUT_OUTER" => 1.0,
        "CUT_INNER" => -1.0,
        _ => 0.0,
    };
    read.iter().map(|(layer, _, curve)| signed(layer) * area_mm2(curve)).sum()
}

#[test]
fn both_files_enclose_the_area_of_the_profile() {
    let drawing = Drawing::from_piece(&plate());
    for read in
        [read_dxf(&dxf(DOCUMENT, &drawing).unwrap()), read_svg(&svg(DOCUMENT, &drawing).unwrap())]
    {
        let layers: Vec<&str> = read.iter().map(|(layer, ..)| layer.as_str()).collect();
        assert_eq!(layers, ["CUT_INNER", "CUT_INNER", "CUT_INNER", "CUT_INNER", "CUT_OUTER"]);
        assert!(read.iter().all(|(_, is_closed, _)| *is_closed));
        let (area, expected) = (enclosed_mm2(&read), plate().area_mm2());
        // SVG gives arcs by radius and end: half circles lose half of an f64's digits.
        assert!((area - expected).abs() < 1e-7 * expected, "{area} for {expected} mm^2");
        for [x, y] in read.iter().flat_map(|(_, _, curve)| curve.iter().map(|(p, _)| *p)) {
            assert!((-1e-9..=60.0 + 1e-9).contains(&x) && (-1e-9..=40.0 + 1e-9).contains(&y));
        }
    }
}

#[test]
fn a_dxf_file_reads_back_bit_for_bit() {
    let drawing = Drawing::from_piece(&plate());
    let bytes = dxf(DOCUMENT, &drawing).unwrap();
    assert_eq!(bytes, dxf(DOCUMENT, &drawing).unwrap());
    let (_, _, slot) = &read_dxf(&bytes)[1];
    let (_, path) = &drawing.contours[1];
    let mut points = vec![path.start];
    points.extend(path.segments.iter().map(|segment| segment.to()));
    points.pop();
    assert_eq!(slot.iter().map(|(point, _)| *point).collect::<Vec<_>>(), points);

    let groups = groups(&bytes);
    let after = |name| groups[groups.iter().position(|g| *g == (9, name)).unwrap() + 1];
    assert_eq!((after("$ACADVER"), after("$INSUNITS")), ((1, "AC1015"), (70, "4")));
    // Handles connect the file's objects; group 5 in the header is the next free one.
    let handles: Vec<u64> = groups
        .iter()
        .filter(|g| g.0 == 5 || g.0 == 105)
        .map(|g| u64::from_str_radix(g.1, 16).unwrap())
        .collect();
    let (seed, rest) = handles.split_first().unwrap();
    assert!(rest.iter().all(|handle| handle < seed));
    assert_eq!(rest.iter().collect::<BTreeSet<_>>().len(), rest.len());
    assert!(bytes.is_ascii() && groups.last() == Some(&(0, "EOF")));
}

#[test]
fn stock_sheets_carry_labels_on_their_own_layer() {
    let profile = plate();
    let piece = Piece { name: "plate-2", profile: &profile, quantity: 3 };
    let stock = Bed { size_mm: [300.0, 200.0], spacing_mm: 3.0 };
    let sheets = nest(&[piece], stock).unwrap();
    let drawing = &sheets[0].drawing;
    for read in
        [read_dxf(&dxf(DOCUMENT, drawing).unwrap()), read_svg(&svg(DOCUMENT, drawing).unwrap())]
    {
        let labels: Vec<_> = read.iter().filter(|(layer, ..)| layer == "LABEL").collect();
        assert_eq!(labels.len(), drawing.strokes.len());
        assert!(!labels.is_empty() && labels.iter().all(|(_, is_closed, _)| !is_closed));
        let expected = 3.0 * profile.area_mm2();
        assert!((enclosed_mm2(&read) - expected).abs() < 1e-7 * expected);
    }
}

#[test]
fn an_svg_file_escapes_its_title_and_colours_its_operations() {
    let text = String::from_utf8(svg(DOCUMENT, &Drawing::from_piece(&plate())).unwrap()).unwrap();
    assert!(text.contains("<title>Test: &lt;plate&gt; &amp; \u{b5}</title>"));
    assert!(text.contains("width=\"60mm\" height=\"40mm\" viewBox=\"0 0 60 40\""));
    let strokes: Vec<&str> = text.split(" stroke=\"").skip(1).map(|rest| &rest[..7]).collect();
    assert_eq!(strokes, ["#0000ff", "#ff0000"]);
}

#[test]
fn nothing_and_ellipses_are_refused() {
    let empty = Drawing::default();
    assert!(matches!(dxf(DOCUMENT, &empty), Err(ExportError::Nothing)));
    assert!(matches!(svg(DOCUMENT, &empty), Err(ExportError::Nothing)));
    let half = Path::from([-2.0, 0.0]).elliptic_arc([2.0, 0.0], [0.0; 2], [2.0, 1.0], true).close();
    let oval = Drawing { contours: vec![(Operation::CutOuter, half)], ..empty };
    assert!(matches!(dxf(DOCUMENT, &oval), Err(ExportError::NotCuttable)));
    assert!(matches!(svg(DOCUMENT, &oval), Err(ExportError::NotCuttable)));
}
