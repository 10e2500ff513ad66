//! Placement of the parts that the sensor does not place: resistors near their LEDs, test points where there is room.

use std::f64::consts::{FRAC_PI_2, TAU};

use fabkit_geometry::{
    BoardPlacement, BoardSide, Circuit, CircuitKind, CircuitPart, KeepOut, KeepOutRegion,
};

use crate::layout::{BoardLayout, Drill, MAX_DRILL_MM, Pad, PlacedPart, land_shape, part_outline};
use crate::shapes::{Point, Shape};
use crate::{BoardError, BoardRules, BoardShape};

/// Distance between candidate places, mm.
const STEP_MM: f64 = 0.1;
/// Preferred clearance beside a part, mm, which leaves room for a track.
const PREFERRED_CLEARANCE_MM: f64 = 0.4;
/// Largest number of pins of a net that attracts parts. Larger nets attract only parts with a single land.
const MAX_ATTRACTING_PINS: usize = 3;

/// Places all parts, without tracks.
///
/// # Errors
/// [`BoardError::NoRoom`] if a part other than a test point has no place.
pub(crate) fn place_parts(
    circuit: &Circuit,
    board: &BoardShape,
    rules: &BoardRules,
    with_test_points: bool,
) -> Result<BoardLayout, BoardError> {
    let drills = (0..board.profile.holes.len()).filter_map(|i| board.round_hole(i));
    let drills = drills.filter(|hole| hole.diameter_mm <= MAX_DRILL_MM);
    let mut layout = BoardLayout {
        board: board.clone(),
        nets: circuit.nets.iter().map(|net| net.name.clone()).collect(),
        parts: Vec::new(),
        pads: Vec::new(),
        tracks: Vec::new(),
        vias: Vec::new(),
        drills: drills
            .map(|hole| Drill { at_mm: hole.at_mm, diameter_mm: hole.diameter_mm })
            .collect(),
        openings: Vec::new(),
        silk: Vec::new(),
        unplaced_test_points: Vec::new(),
    };
    for part in &circuit.parts {
        if let Some(place) = part.place {
            add_part(&mut layout, circuit, rules, part, place);
        }
    }
    // Each part takes the best candidate place that is still free, in the circuit's order.
    let tried = candidate_places(board);
    for part in circuit.parts.iter().filter(|part| part.place.is_none()) {
        let is_extra = part.kind == CircuitKind::TestPoint;
        if is_extra && !with_test_points {
            layout.unplaced_test_points.push(part.designator.clone());
            continue;
        }
        // With room for a track beside it if possible, else as close as the rules allow.
        let room = [PREFERRED_CLEARANCE_MM, rules.part_mm];
        let found =
            room.iter().find_map(|room| find_place(&layout, circuit, rules, part, &tried, *room));
        match found {
            Some(place) => add_part(&mut layout, circuit, rules, part, place),
            None if is_extra => layout.unplaced_test_points.push(part.designator.clone()),
            None => {
                return Err(BoardError::NoRoom {
                    board: board.name.clone(),
                    part: part.designator.clone(),
                    package: part.package.clone(),
                    needs_mm: outline_size(part),
                });
            }
        }
    }
    Ok(layout)
}

fn outline_size(part: &CircuitPart) -> [f64; 2] {
    let origin = BoardPlacement { at_mm: [0.0; 2], turn_rad: 0.0, side: BoardSide::Top };
    let [low, high] = part_outline(&origin, part).bounds();
    [high[0] - low[0], high[1] - low[1]]
}

/// Adds a part with its pads and mask openings to the layout.
fn add_part(
    layout: &mut BoardLayout,
    circuit: &Circuit,
    rules: &BoardRules,
    part: &CircuitPart,
    place: BoardPlacement,
) {
    for land in &part.lands {
        let shape = land_shape(&place, land);
        let on = |net: &fabkit_geometry::Net| {
            net.pins.iter().any(|(name, pin)| *name == part.designator && *pin == land.pin)
        };
        layout.openings.push((place.side, shape.enlarged_by(rules.mask_mm)));
        layout.pads.push(Pad {
            part: part.designator.clone(),
            pin: land.pin.clone(),
            side: place.side,
            shape,
            net: circuit.nets.iter().position(on),
        });
    }
    layout.parts.push(PlacedPart {
        designator: part.designator.clone(),
        kind: part.kind,
        value: part.value.clone(),
        package: part.package.clone(),
        outline: part_outline(&place, part),
        place,
    });
}

/// Lists all candidate places on the upper side: rings about the axis on an annular board, else rows and columns.
fn candidate_places(board: &BoardShape) -> Vec<BoardPlacement> {
    let mut places = Vec::new();
    let side = BoardSide::Top;
    if let Some([inner, outer]) = board.annulus_mm() {
        let rings = ((outer - inner) / STEP_MM) as usize;
        for ring in 1..=rings {
            let radius = inner + STEP_MM * ring as f64;
            for degree in 0..360 {
                let angle = f64::from(degree).to_radians();
                let at_mm = [radius * angle.cos(), radius * angle.sin()];
                for quarter in 0..4 {
                    let turn_rad = (angle + f64::from(quarter) * FRAC_PI_2) % TAU;
                    places.push(BoardPlacement { at_mm, turn_rad, side });
                }
            }
        }
        return places;
    }
    let [low, high] = Shape::polygon(board.edge.clone()).bounds();
    let step = 2.5 * STEP_MM;
    let middle = [0, 1].map(|axis| (low[axis] + high[axis]) / 2.0);
    let count = [0, 1].map(|axis| ((high[axis] - low[axis]) / 2.0 / step) as i32);
    for i in -count[0]..=count[0] {
        for j in -count[1]..=count[1] {
            let at_mm = [middle[0] + step * f64::from(i), middle[1] + step * f64::from(j)];
            for quarter in 0..4 {
                places.push(BoardPlacement {
                    at_mm,
                    turn_rad: f64::from(quarter) * FRAC_PI_2,
                    side,
                });
            }
        }
    }
    places
}

/// Finds the free place with the shortest connections to pads that are already placed, with `room_mm` of clearance to
/// all other parts.
fn find_place(
    layout: &BoardLayout,
    circuit: &Circuit,
    rules: &BoardRules,
    part: &CircuitPart,
    places: &[BoardPlacement],
    room_mm: f64,
) -> Option<BoardPlacement> {
    // For each pin, the pads of its net that are already placed.
    let mut pulls: Vec<(Point, Vec<Point>)> = Vec::new();
    for land in &part.lands {
        let Some(net) = circuit.net_of(&part.designator, &land.pin) else { continue };
        let index = layout.nets.iter().position(|name| *name == net.name);
        let there = layout.pads.iter().filter(|pad| pad.net == index);
        let there: Vec<Point> = there.map(|pad| pad.shape.centre()).collect();
        let is_drawn = net.pins.len() <= MAX_ATTRACTING_PINS || part.lands.len() == 1;
        if !there.is_empty() && is_drawn {
            pulls.push((land.at_mm, there));
        }
    }
    let cost = |place: &BoardPlacement| {
        let far = pulls.iter().map(|(at, there)| {
            let at = place.point(*at);
            there.iter().map(|to| (at[0] - to[0]).hypot(at[1] - to[1])).fold(f64::MAX, f64::min)
        });
        // Rounded to whole micrometres, so that equal places stay equal on every machine.
        (far.sum::<f64>() * 1e3).round() as u64
    };
    // The index decides between places of equal cost, so the result does not depend on the sort.
    let mut ranked: Vec<(u64, usize)> =
        places.iter().enumerate().map(|(i, place)| (cost(place), i)).collect();
    ranked.sort_unstable();
    let is_free =
        |place: &BoardPlacement| is_place_free(layout, circuit, rules, part, place, room_mm);
    ranked.into_iter().map(|(_, i)| places[i]).find(is_free)
}

/// Returns whether a part fits at a place: clear of other parts and keep-out regions, and with its lands inside the
/// edge.
fn is_place_free(
    layout: &BoardLayout,
    circuit: &Circuit,
    rules: &BoardRules,
    part: &CircuitPart,
    place: &BoardPlacement,
    room_mm: f64,
) -> bool {
    let outline = part_outline(place, part);
    let beside = |other: &PlacedPart| {
        other.place.side != place.side || other.outline.distance(&outline) >= room_mm
    };
    layout.parts.iter().all(beside)
        && !circuit
            .keep_outs
            .iter()
            .any(|keep| keep.side == place.side && overlaps_keep_out(keep, &outline))
        && part
            .lands
            .iter()
            .all(|land| layout.board.edge_distance_mm(&land_shape(place, land)) >= rules.edge_mm)
        && layout.board.edge_distance_mm(&outline) >= 0.0
}

/// Returns whether a part reaches into a region. Points of its outline, 0.1 mm apart, are tested.
pub(crate) fn overlaps_keep_out(keep: &KeepOut, outline: &Shape) -> bool {
    let corners = outline.corners();
    let n = corners.len();
    (0..n).any(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % n]);
        let count = ((b[0] - a[0]).hypot(b[1] - a[1]) / 0.1).ceil().max(1.0) as usize;
        (0..count).any(|k| {
            let t = k as f64 / count as f64;
            region_contains(&keep.region, [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])])
        })
    })
}

fn region_contains(region: &KeepOutRegion, [x, y]: Point) -> bool {
    match *region {
        KeepOutRegion::Sector { inner_mm, outer_mm, middle_rad, half_rad } => {
            let radius = x.hypot(y);
            // Difference of two angles, wrapped to -pi to pi.
            let off = (y.atan2(x) - middle_rad + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
            radius > inner_mm && radius < outer_mm && off.abs() < half_rad + 1e-12
        }
        KeepOutRegion::BeyondRect { half_mm } => x.abs() > half_mm[0] || y.abs() > half_mm[1],
    }
}
