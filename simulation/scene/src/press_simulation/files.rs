//! Files of a press: its curve as a table and a plot, its displacement field as arrays.

use std::fmt::Write as _;

use fabkit_elastic::StrainTheory;
use fabkit_export::{NpyArray, NpyValues};
use fabkit_geometry::csv::{CsvCell, CsvTable};

use super::force_curve::{PressResult, PressStep};
use super::markers::marks_arrays;

/// Formats the curve as CSV, in mm, N, N mm and mm2, sensor frame.
pub fn curve_csv(pressed: &PressResult) -> String {
    let mut table = CsvTable::new(
        "depth_mm,shear_mm,force_n,force_x_n,force_y_n,force_z_n,moment_x_nmm,moment_y_nmm,moment_z_nmm,contact_radius_mm,\
         contact_area_mm2,max_indentation_mm,bulge_mm",
    );
    for step in &pressed.steps {
        let PressStep { depth_mm, force_n: force, moment_nmm: moment, .. } = step;
        let numbers = [
            *depth_mm,
            step.shear_mm,
            force.norm(),
            force.x,
            force.y,
            force.z,
            moment.x,
            moment.y,
            moment.z,
            step.contact_radius_mm,
            step.contact_area_mm2,
            step.max_indentation_mm,
            step.bulge_mm,
        ];
        table.row(numbers.map(|number| CsvCell::fixed(number, 6)));
    }
    table.finish()
}

/// Width and height of the plot, and its left and lower margin, px.
const PLOT: [f64; 3] = [480.0, 320.0, 56.0];

/// Plots the curve as SVG: force over depth.
pub fn curve_svg(pressed: &PressResult) -> String {
    // States after a displacement along the surface have the same depth and would not be a function of it.
    let straight = pressed.steps.iter().filter(|step| step.shear_mm == 0.0);
    force_svg(&pressed.id, pressed.level, straight.map(|step| [step.depth_mm, step.force_n.norm()]))
}

/// Plots forces, N, over depths, mm, as SVG.
pub(super) fn force_svg(
    id: &str,
    level: StrainTheory,
    steps: impl Iterator<Item = [f64; 2]>,
) -> String {
    let [width, height, margin] = PLOT;
    let points: Vec<[f64; 2]> = std::iter::once([0.0, 0.0]).chain(steps).collect();
    // Forces grow with depth, so the last point sets both scales. The minimum avoids division by 0.
    let most = points.last().copied().unwrap_or([1.0, 1.0]).map(|most| most.max(1e-9));
    let x = |mm: f64| margin + mm / most[0] * (width - margin - 16.0);
    // SVG's y axis points down. 28 px remain above for the label.
    let y = |n: f64| height - margin + n / most[1] * (margin + 28.0 - height);
    let line: Vec<String> =
        points.iter().map(|[mm, n]| format!("{:.2},{:.2}", x(*mm), y(*n))).collect();
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" font-family=\"sans-serif\" font-size=\"12\" role=\"img\">\n\
         <title>Force over depth of {}</title>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n",
        id
    );
    for i in 0..=4 {
        let share = f64::from(i) / 4.0;
        let [mm, n] = most.map(|most| share * most);
        let _ = writeln!(
            svg,
            "<path d=\"M{0:.1} {1:.1}H{2:.1}\" stroke=\"#d8d8d8\"/><text x=\"{3:.1}\" y=\"{4:.1}\" \
             text-anchor=\"end\" fill=\"#333333\">{n:.2}</text><text x=\"{5:.1}\" y=\"{6:.1}\" \
             text-anchor=\"middle\" fill=\"#333333\">{mm:.2}</text>",
            x(0.0),
            y(n),
            x(most[0]),
            margin - 6.0,
            y(n) + 4.0,
            x(mm),
            height - margin + 18.0,
        );
    }
    let _ = write!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"#0b5394\" stroke-width=\"2\"/>\n\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#333333\">depth, mm</text>\n\
         <text x=\"14\" y=\"16\" fill=\"#333333\">force, N (simulated, {})</text>\n</svg>\n",
        line.join(" "),
        width / 2.0,
        height - 12.0,
        level.name(),
    );
    svg
}

/// Returns the field as arrays of 64-bit floats. For N nodes of the surface: `place_mm`, `outward`, `displacement_mm`
/// and `shear_mpa` (N x 3, sensor frame), `pressure_mpa` and `area_mm2` (N). For M markers: `mark_place_mm`,
/// `mark_displacement_mm` (NaN where unknown) and `mark_axis` (M x 3).
pub fn press_arrays(pressed: &PressResult) -> Vec<NpyArray> {
    let pose = pressed.soft.sensor_from_stack;
    let nodes = &pressed.outcome.nodes;
    let count = nodes.len();
    let mut columns: [Vec<f64>; 4] = Default::default();
    for node in nodes {
        columns[0].extend(pose.point(node.place_mm).iter());
        columns[1].extend(pose.vector(node.outward).iter());
        columns[2].extend(pose.vector(node.displacement_mm).iter());
        columns[3].extend(pose.vector(node.shear_mpa).iter());
    }
    let [places, outward, displacement, shear] = columns;
    let array = |name: &str, shape: Vec<usize>, values: Vec<f64>| NpyArray {
        name: name.into(),
        shape,
        values: NpyValues::F64(values),
    };
    let three = |name: &str, values: Vec<f64>| array(name, vec![count, 3], values);
    let [place, moved, axis] = marks_arrays(&pressed.marks);
    vec![
        three("place_mm", places),
        three("outward", outward),
        three("displacement_mm", displacement),
        three("shear_mpa", shear),
        array("pressure_mpa", vec![count], nodes.iter().map(|node| node.pressure_mpa).collect()),
        array("area_mm2", vec![count], nodes.iter().map(|node| node.area_mm2).collect()),
        place,
        moved,
        axis,
    ]
}
