//! Image of the unrolled surface that shows which parts a camera sees.
//!
//! A dome is drawn in azimuthal equidistant projection around its tip: the distance from the image's middle is the
//! angle from the tip, in degrees, about the dome's centre. A pad is drawn to scale. Shares in the legend are of area.

use fabkit_depth::{RenderError, RenderedImage};
use fabkit_fixtures::SurfacePoints;
use fabkit_geometry::{InvalidSolid, Point3, TouchSurface};
use fabkit_optics::{OUTSIDE_IMAGE, REFRACTION, ViewStacks};
use rayon::prelude::*;

use super::projector::Projector;
use super::{SurfaceCoverage, Viewpoint};
use crate::legend;

/// Number of sampled places along the longer side of the surface, and size of the square that shows each, px.
const PLACES: u32 = 160;
const PLACE_PX: u32 = 4;

/// Margin around the surface, width of the legend and height of its capitals, px.
const MARGIN_PX: u32 = 44;
const LEGEND_PX: u32 = 330;
const LETTER_PX: f64 = 9.0;

const PAPER: [u8; 3] = [255, 255, 255];
const INK: [u8; 3] = [30, 30, 36];
/// Colours of places that are seen, lie beside the image, or are lost by refraction.
const SEEN: [u8; 3] = [246, 239, 214];
const BESIDE: [u8; 3] = [122, 138, 160];
const BENT: [u8; 3] = [176, 40, 168];
/// Colours of blocking bodies, the one with the largest share first.
const HIDDEN: [[u8; 3]; 6] =
    [[228, 108, 10], [204, 32, 44], [36, 98, 204], [134, 84, 40], [0, 146, 164], [150, 140, 0]];

/// A chart of the unrolled surface.
enum Chart {
    /// A dome, with the polar angle of its foot, rad.
    Dome { last_rad: f64 },
    /// A pad, with its smallest and largest x and y, mm.
    Plane { bounds_mm: [[f64; 2]; 2] },
}

impl Chart {
    /// Returns half the width and height of the chart, and its middle, in degrees for a dome and mm for a pad.
    fn half(&self) -> ([f64; 2], [f64; 2]) {
        match self {
            Self::Dome { last_rad } => ([last_rad.to_degrees(); 2], [0.0; 2]),
            Self::Plane { bounds_mm } => (
                bounds_mm.map(|[least, most]| 0.5 * (most - least)),
                bounds_mm.map(|[least, most]| 0.5 * (most + least)),
            ),
        }
    }

    fn point(&self, points: &SurfacePoints, [x, y]: [f64; 2]) -> Option<Point3<f64>> {
        match points {
            SurfacePoints::Dome(dome) => {
                let found = dome.point_in_direction(x.hypot(y).to_radians(), y.atan2(x))?;
                Some(found.0)
            }
            SurfacePoints::Plane(pad) => pad.at([x, y]).map(|(point, _)| point),
        }
    }
}

/// Draws the map. The shares of `coverage` go into the legend.
///
/// # Errors
/// Returns an error if the surface's dimensions make no valid solid.
pub fn draw_coverage_map(
    touch: &TouchSurface,
    viewpoint: &Viewpoint,
    sights: &ViewStacks,
    coverage: &SurfaceCoverage,
) -> Result<RenderedImage, InvalidSolid> {
    let points = SurfacePoints::new(touch)?;
    let chart = match &points {
        SurfacePoints::Dome(dome) => Chart::Dome { last_rad: dome.max_polar_rad() },
        SurfacePoints::Plane(pad) => Chart::Plane { bounds_mm: pad.bounds_mm() },
    };
    let (half, middle) = chart.half();
    let step = 2.0 * half[0].max(half[1]) / f64::from(PLACES);
    let size = half.map(|half| (2.0 * half / step).round() as u32);
    let legend = legend_entries(coverage);
    let color = |word: &str| {
        let entry = legend.iter().find(|(name, ..)| name == word);
        entry.map_or(INK, |(_, color, _)| *color)
    };
    // Each row has a state of its own, so that the result does not depend on the number of threads.
    let rows = (0..size[1]).into_par_iter().map(|row| {
        let mut looking = Projector::new(viewpoint, sights);
        let one = |column: u32| {
            let x = middle[0] - half[0] + (f64::from(column) + 0.5) * step;
            // Image rows run downwards, y runs upwards.
            let y = middle[1] + half[1] - (f64::from(row) + 0.5) * step;
            let point = chart.point(&points, [x, y])?;
            Some(match looking.look(&point) {
                Ok(_) => SEEN,
                Err(lost) => color(lost.label(sights.stack())),
            })
        };
        (0..size[0]).map(one).collect::<Vec<_>>()
    });
    let rows: Vec<Vec<Option<[u8; 3]>>> = rows.collect();
    let canvas = [
        size[0] * PLACE_PX + 2 * MARGIN_PX + LEGEND_PX,
        (size[1] * PLACE_PX).max(200) + 2 * MARGIN_PX,
    ];
    let image = RenderedImage::filled(canvas[0], canvas[1], PAPER);
    let mut image = image.unwrap_or_else(|error: RenderError| unreachable!("{error}"));
    for (row, colors) in rows.iter().enumerate() {
        for (column, color) in colors.iter().enumerate() {
            let at = [column, row].map(|at| i64::from(MARGIN_PX + at as u32 * PLACE_PX));
            let Some(color) = color else { continue };
            image.fill(at, at.map(|at| at + i64::from(PLACE_PX)), *color);
        }
    }
    let place = |x: f64, y: f64| {
        let px = f64::from(PLACE_PX) / step;
        let margin = f64::from(MARGIN_PX);
        [margin + (x - middle[0] + half[0]) * px, margin + (middle[1] + half[1] - y) * px]
    };
    axes(&mut image, &chart, &place);
    let entries: Vec<([u8; 3], String)> =
        legend.into_iter().map(|(_, color, text)| (color, text)).collect();
    let corner = [f64::from(canvas[0] - LEGEND_PX), f64::from(MARGIN_PX)];
    legend::draw_at(&mut image, &entries, corner, LETTER_PX);
    Ok(image)
}

/// Returns the legend's entries as cause, colour and text. The visible share comes first, with an empty cause.
fn legend_entries(coverage: &SurfaceCoverage) -> Vec<(String, [u8; 3], String)> {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let mut entries = vec![(String::new(), SEEN, format!("seen {}", percent(coverage.area)))];
    let mut hidden = HIDDEN.iter().cycle();
    for (by, share) in &coverage.lost {
        let color = match by.as_str() {
            OUTSIDE_IMAGE => BESIDE,
            REFRACTION => BENT,
            _ => *hidden.next().unwrap_or(&INK),
        };
        entries.push((by.clone(), color, format!("{by} {}", percent(*share))));
    }
    entries
}

/// Draws the axes: rings of equal polar angle on a dome, ticks in millimetres on a pad.
fn axes(image: &mut RenderedImage, chart: &Chart, place: &dyn Fn(f64, f64) -> [f64; 2]) {
    match chart {
        Chart::Dome { last_rad } => {
            let last = last_rad.to_degrees();
            // A ring every 30 degrees, and one at the foot.
            let rings = (1..).map(|ring| 30.0 * f64::from(ring)).take_while(|ring| *ring < last);
            for ring in rings.chain([last]) {
                let at = |step: i32| {
                    let (sin, cos) = f64::from(step).to_radians().sin_cos();
                    place(ring * cos, ring * sin)
                };
                image.draw_line(&(0..=360).map(at).collect::<Vec<_>>(), 1.0, INK);
                let [x, y] = at(90);
                legend::write(image, &format!("{ring:.0}"), [x + 3.0, y - 12.0], LETTER_PX);
            }
            let [x, y] = place(0.0, -last);
            legend::write(image, "deg from the tip", [x - 60.0, y + 14.0], LETTER_PX);
            let [x, y] = place(last, 0.0);
            legend::write(image, "x", [x + 6.0, y - 0.5 * LETTER_PX], LETTER_PX);
            image.draw_line(&[place(last, 0.0), [x - 10.0, y]], 1.5, INK);
        }
        Chart::Plane { bounds_mm: [[x0, x1], [y0, y1]] } => {
            let frame = [[*x0, *y0], [*x1, *y0], [*x1, *y1], [*x0, *y1], [*x0, *y0]];
            image.draw_line(&frame.map(|[x, y]| place(x, y)), 1.0, INK);
            // A tick every 5 mm.
            let ticks = |least: f64, most: f64| {
                let (first, last) = ((least / 5.0).ceil() as i32, (most / 5.0).floor() as i32);
                (first..=last).map(|tick| 5.0 * f64::from(tick))
            };
            for x in ticks(*x0, *x1) {
                let [u, v] = place(x, *y0);
                image.draw_line(&[[u, v], [u, v + 6.0]], 1.0, INK);
                legend::write(image, &format!("{x:.0}"), [u - 4.0, v + 10.0], LETTER_PX);
            }
            for y in ticks(*y0, *y1) {
                let [u, v] = place(*x0, y);
                image.draw_line(&[[u, v], [u - 6.0, v]], 1.0, INK);
                legend::write(image, &format!("{y:.0}"), [u - 34.0, v - 4.0], LETTER_PX);
            }
            let [u, v] = place(0.5 * (x0 + x1), *y0);
            legend::write(image, "x, y in mm", [u - 30.0, v + 26.0], LETTER_PX);
        }
    }
}
