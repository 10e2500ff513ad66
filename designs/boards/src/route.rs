//! Routing of tracks: for each net, the cheapest path over the grid of both sides from connected pins to unconnected
//! ones.
//!
//! A net without a free path takes one through other nets' tracks. It prefers few tracks, and nets that have rarely
//! been moved; those nets are then routed again (rip-up and reroute). Only the order of the circuit matters, so the
//! same board results on every machine. Clearances hold for whole pieces between points, not only at the points.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap, VecDeque};

use fabkit_geometry::Circuit;

use crate::grid::Grid;
use crate::layout::{BoardLayout, SIDES, Track, Via};
use crate::rules::min_track_width_mm;
use crate::shapes::{Point, Shape};
use crate::{BoardError, BoardRules};

/// Maximum number of routing attempts, as a multiple of the number of nets.
const MAX_TRIES_PER_NET: usize = 25;
/// Cost of a point on another net's track, in um of track length. It grows with the square of the number of times
/// that this net has been moved.
const RIP_UP_COST_UM: u64 = 400;
/// Cost of a via, as a length of track, um.
const VIA_COST: u64 = 1_500;
/// Minimum distance between a via and an opening of the mask, mm.
const VIA_TO_OPENING_MM: f64 = 0.05;

/// Grid of a board, with the rules to keep on it.
struct Router<'a> {
    grid: Grid,
    /// Distance of each point from the nearest edge, mm.
    inside_mm: Vec<f64>,
    rules: &'a BoardRules,
}

/// Routes all nets with tracks `usual_mm` wide, or wider if the net's current needs it.
pub(crate) fn route(
    layout: &mut BoardLayout,
    circuit: &Circuit,
    rules: &BoardRules,
    usual_mm: f64,
) -> Result<(), BoardError> {
    let grid = Grid::new(&layout.board);
    let inside_mm = grid.points.iter().map(|p| layout.board.point_edge_distance_mm(*p)).collect();
    // The distance from the edge is the same for all nets, so it is computed once.
    let router = Router { grid, inside_mm, rules };
    let width = |net: usize| usual_mm.max(min_track_width_mm(circuit.nets[net].current_a, rules));
    let pins = |net: &usize| layout.pads.iter().filter(|pad| pad.net == Some(*net)).count();
    layout.tracks.clear();
    layout.vias.clear();
    let mut order: Vec<usize> = (0..layout.nets.len()).filter(|net| pins(net) > 1).collect();
    // Nets with few pins first, because they have the fewest alternatives.
    order.sort_by_key(|net| (pins(net), *net));
    let mut moved = vec![0; layout.nets.len()];
    let mut queue: VecDeque<usize> = order.iter().copied().collect();
    for _ in 0..MAX_TRIES_PER_NET * order.len() {
        let Some(net) = queue.pop_front() else { return Ok(()) };
        // First a path that clears all other nets, then one through their tracks.
        let free = router.route_net(layout, net, width(net), None);
        let (tracks, vias) = match free {
            Ok(laid) => laid,
            Err(_) => {
                let laid = router.route_net(layout, net, width(net), Some(&moved));
                let no_way = |from| BoardError::NoRoute {
                    board: layout.board.name.clone(),
                    net: layout.nets[net].clone(),
                    from,
                    width_mm: width(net),
                    clearance_mm: rules.clearance_mm,
                };
                laid.map_err(no_way)?
            }
        };
        // Nets in the way lose all their tracks and are routed again later.
        for other in router.conflicting_nets(layout, net, &tracks, &vias) {
            moved[other] += 1;
            layout.tracks.retain(|track| track.net != other);
            layout.vias.retain(|via| via.net != other);
            queue.push_back(other);
        }
        layout.tracks.extend(tracks);
        layout.vias.extend(vias);
    }
    let Some(net) = queue.front().copied() else { return Ok(()) };
    // The attempts are used up: the nets still in the queue displace each other.
    let alone = layout.pads.iter().find(|pad| pad.net == Some(net));
    Err(BoardError::NoRoute {
        board: layout.board.name.clone(),
        net: layout.nets[net].clone(),
        from: alone.map_or(String::new(), |pad| format!("{} pin {}", pad.part, pad.pin)),
        width_mm: width(net),
        clearance_mm: rules.clearance_mm,
    })
}

/// Points that a net may not use, because copper of other nets or an edge is near.
struct BlockedPoints {
    /// Points that tracks may not use, by side.
    track: [Vec<bool>; 2],
    /// Points that vias may not use.
    via: Vec<bool>,
    /// Additional cost of points, um, by side.
    extra_cost_um: [Vec<u64>; 2],
}

impl Router<'_> {
    /// Minimum distance of grid points from copper, so that pieces of track between two such points keep `clear_mm`.
    fn point_clearance_mm(&self, clear_mm: f64) -> f64 {
        clear_mm.hypot(self.grid.step_mm / 2.0)
    }

    /// Determines the barred points. If `moved` gives how often each net has been moved, other nets' tracks are not
    /// barred but cost more.
    fn block_points(
        &self,
        layout: &BoardLayout,
        net: usize,
        width_mm: f64,
        moved: Option<&[u64]>,
    ) -> BlockedPoints {
        let rules = self.rules;
        let edge = self.point_clearance_mm(rules.edge_mm + width_mm / 2.0);
        let near_edge: Vec<bool> = self.inside_mm.iter().map(|inside| *inside < edge).collect();
        let via_edge = rules.edge_mm + rules.via_mm / 2.0;
        let mut barred = BlockedPoints {
            track: [near_edge.clone(), near_edge],
            via: self.inside_mm.iter().map(|inside| *inside < via_edge).collect(),
            extra_cost_um: [vec![0; self.grid.points.len()], vec![0; self.grid.points.len()]],
        };
        let track_mm = self.point_clearance_mm(rules.clearance_mm + width_mm / 2.0);
        let via_mm = rules.clearance_mm + rules.via_mm / 2.0;
        let points = &self.grid.points;
        let mut bar = |shape: &Shape, sides: &[usize], is_foreign: bool, via_mm: f64| {
            self.grid.for_each_near(shape, track_mm.max(via_mm), |i| {
                let apart = shape.distance_to_point(points[i]);
                if is_foreign && apart < track_mm {
                    sides.iter().for_each(|side| barred.track[*side][i] = true);
                }
                barred.via[i] |= apart < via_mm;
            });
        };
        for pad in &layout.pads {
            let is_foreign = pad.net != Some(net);
            // A via below an opening of the mask would draw solder away from the pad, whichever net it belongs to.
            let open = rules.via_mm / 2.0 + rules.mask_mm + VIA_TO_OPENING_MM;
            let via_mm = if is_foreign { via_mm.max(open) } else { open };
            bar(&pad.shape, &[side_index(pad.side)], is_foreign, via_mm);
        }
        if let Some(moved) = moved {
            for track in layout.tracks.iter().filter(|track| track.net != net) {
                self.add_cost(
                    &mut barred,
                    &track.shape(),
                    &[side_index(track.side)],
                    track_mm,
                    moved[track.net],
                );
            }
            for via in layout.vias.iter().filter(|via| via.net != net) {
                self.add_cost(&mut barred, &via.shape(), &[0, 1], track_mm, moved[via.net]);
            }
            return barred;
        }
        for track in layout.tracks.iter().filter(|track| track.net != net) {
            bar(&track.shape(), &[side_index(track.side)], true, via_mm);
        }
        // Two vias of the same net may touch, but their drills must stay apart.
        for via in &layout.vias {
            let holes = rules.hole_to_hole_mm + rules.via_drill_mm / 2.0 + via.drill_mm / 2.0
                - via.diameter_mm / 2.0;
            let is_foreign = via.net != net;
            let apart = if is_foreign { via_mm.max(holes) } else { holes };
            bar(&via.shape(), &[0, 1], is_foreign, apart);
        }
        barred
    }

    /// Adds the cost of another net's copper to the points near it.
    fn add_cost(
        &self,
        barred: &mut BlockedPoints,
        shape: &Shape,
        sides: &[usize],
        apart_mm: f64,
        moved: u64,
    ) {
        self.grid.for_each_near(shape, apart_mm, |i| {
            if shape.distance_to_point(self.grid.points[i]) < apart_mm {
                sides.iter().for_each(|side| {
                    barred.extra_cost_um[*side][i] += RIP_UP_COST_UM * (1 + moved).pow(2)
                });
            }
        });
    }

    /// Returns the other nets that new tracks and vias come too near to.
    fn conflicting_nets(
        &self,
        layout: &BoardLayout,
        net: usize,
        tracks: &[Track],
        vias: &[Via],
    ) -> BTreeSet<usize> {
        let rules = self.rules;
        let copper = |tracks: &[Track], vias: &[Via]| -> Vec<(Option<usize>, Shape, usize, f64)> {
            let tracks = tracks
                .iter()
                .map(|track| (Some(side_index(track.side)), track.shape(), track.net, 0.0));
            let vias = vias.iter().map(|via| (None, via.shape(), via.net, via.drill_mm));
            tracks.chain(vias).collect()
        };
        let new = copper(tracks, vias);
        let there = copper(&layout.tracks, &layout.vias);
        let mut near = BTreeSet::new();
        for (side, shape, other, drill_mm) in there.iter().filter(|one| one.2 != net) {
            let meets =
                |(new_side, new_shape, _, new_drill): &(Option<usize>, Shape, usize, f64)| {
                    let is_apart = matches!((side, new_side), (Some(a), Some(b)) if a != b);
                    let ring = |shape: &Shape, drill: f64| shape.radius_mm() - drill / 2.0;
                    let holes = if *drill_mm > 0.0 && *new_drill > 0.0 {
                        // The rule holds between the drills' edges. The distance below is that of the copper,
                        // which is wider than each drill by its ring.
                        rules.hole_to_hole_mm - ring(shape, *drill_mm) - ring(new_shape, *new_drill)
                    } else {
                        0.0
                    };
                    !is_apart && shape.distance(new_shape) < rules.clearance_mm.max(holes)
                };
            if !near.contains(other) && new.iter().any(meets) {
                near.insert(*other);
            }
        }
        near
    }

    /// Routes one net. Returns its tracks and vias, or the pin that stays unconnected if there is no path.
    fn route_net(
        &self,
        layout: &BoardLayout,
        net: usize,
        width_mm: f64,
        moved: Option<&[u64]>,
    ) -> Result<(Vec<Track>, Vec<Via>), String> {
        let mut barred = self.block_points(layout, net, width_mm, moved);
        let count = self.grid.points.len();
        let pads: Vec<_> = layout.pads.iter().filter(|pad| pad.net == Some(net)).collect();
        // Grid points on each pad.
        let mut pad_at: BTreeMap<usize, usize> = BTreeMap::new();
        for (index, pad) in pads.iter().enumerate() {
            let side = side_index(pad.side);
            self.grid.for_each_near(&pad.shape, 0.0, |i| {
                if pad.shape.contains(self.grid.points[i]) && !barred.track[side][i] {
                    pad_at.insert(side * count + i, index);
                }
            });
        }
        let mut is_joined = vec![false; pads.len()];
        is_joined[0] = true;
        // Pads that touch each other would need no track, but no pads do so on purpose.
        let mut tree: Vec<usize> =
            pad_at.iter().filter(|(_, pad)| **pad == 0).map(|(state, _)| *state).collect();
        let (mut tracks, mut vias) = (Vec::new(), Vec::new());
        while let Some(alone) = is_joined.iter().position(|joined| !joined) {
            let way = self.find_path(&barred, &tree, |state| {
                pad_at.get(&state).is_some_and(|pad| !is_joined[*pad])
            });
            // Two vias of this path would be too near to each other: bar the second and search again.
            if let Some(point) = way.as_deref().and_then(|way| self.find_close_via(way)) {
                barred.via[point] = true;
                continue;
            }
            let Some(way) = way else {
                return Err(format!("{} pin {}", pads[alone].part, pads[alone].pin));
            };
            let reached = pad_at[way.last().expect("a way has an end")];
            is_joined[reached] = true;
            // All points of the reached pad, and of the path, are starts for the next path.
            let more = pad_at.iter().filter(|(_, pad)| **pad == reached).map(|(state, _)| *state);
            tree.extend(more.chain(way.iter().copied()));
            tree.sort_unstable();
            tree.dedup();
            let laid = vias.len();
            self.add_path(&way, net, width_mm, &mut tracks, &mut vias);
            // Later paths of this net must not drill too near to the new vias.
            for via in &vias[laid..] {
                let apart = self.rules.hole_to_hole_mm + self.rules.via_drill_mm;
                self.grid.for_each_near(&Shape::disc(via.at_mm, 0.0), apart, |i| {
                    let [x, y] = self.grid.points[i];
                    barred.via[i] |= (x - via.at_mm[0]).hypot(y - via.at_mm[1]) < apart;
                });
            }
        }
        Ok((tracks, vias))
    }

    /// Finds the cheapest path from any state of `tree` to a target (Dijkstra). A state is side x points + point.
    fn find_path(
        &self,
        barred: &BlockedPoints,
        tree: &[usize],
        is_target: impl Fn(usize) -> bool,
    ) -> Option<Vec<usize>> {
        let count = self.grid.points.len();
        let mut cost = vec![u64::MAX; 2 * count];
        let mut from = vec![usize::MAX; 2 * count];
        let mut open = BinaryHeap::new();
        for state in tree {
            cost[*state] = 0;
            open.push(Reverse((0, *state)));
        }
        while let Some(Reverse((so_far, state))) = open.pop() {
            // An outdated entry: the state has been reached more cheaply since.
            if so_far > cost[state] {
                continue;
            }
            if is_target(state) {
                let mut way = vec![state];
                while from[way[way.len() - 1]] != usize::MAX {
                    way.push(from[way[way.len() - 1]]);
                }
                way.reverse();
                return Some(way);
            }
            let (side, point) = (state / count, state % count);
            let mut step = |to: usize, more: u64| {
                if so_far + more < cost[to] {
                    cost[to] = so_far + more;
                    from[to] = state;
                    open.push(Reverse((so_far + more, to)));
                }
            };
            let at = self.grid.points[point];
            for beside in self.grid.neighbours(point).filter(|to| !barred.track[side][*to]) {
                let to = self.grid.points[beside];
                // Whole micrometres, so that costs are exact and ties are the same everywhere.
                let length = ((to[0] - at[0]).hypot(to[1] - at[1]) * 1e3).round() as u64;
                step(side * count + beside, length + barred.extra_cost_um[side][beside]);
            }
            // The other side is reached by a via at the same point.
            if !barred.via[point] && !barred.track[1 - side][point] {
                step((1 - side) * count + point, VIA_COST + barred.extra_cost_um[1 - side][point]);
            }
        }
        None
    }

    /// Returns the second of two vias of a path that are too near to each other.
    fn find_close_via(&self, way: &[usize]) -> Option<usize> {
        let count = self.grid.points.len();
        let changes = way.windows(2).filter(|pair| pair[0] / count != pair[1] / count);
        let vias: Vec<usize> = changes.map(|pair| pair[0] % count).collect();
        let apart = self.rules.hole_to_hole_mm + self.rules.via_drill_mm;
        let is_near = |pair: &&[usize]| {
            let [a, b] = [pair[0], pair[1]].map(|point| self.grid.points[point]);
            (a[0] - b[0]).hypot(a[1] - b[1]) < apart
        };
        vias.windows(2).find(is_near).map(|pair| pair[1])
    }

    /// Turns a path into tracks and vias.
    fn add_path(
        &self,
        way: &[usize],
        net: usize,
        width_mm: f64,
        tracks: &mut Vec<Track>,
        vias: &mut Vec<Via>,
    ) {
        let count = self.grid.points.len();
        let at = |state: usize| self.grid.points[state % count];
        // A run is a part of the path that stays on one side.
        for run in way.chunk_by(|a, b| a / count == b / count) {
            let points: Vec<Point> = run.iter().map(|state| at(*state)).collect();
            let side = SIDES[run[0] / count];
            let ends = merge_collinear(&points);
            tracks.extend(ends.into_iter().map(|ends| Track { side, ends, width_mm, net }));
        }
        for change in way.windows(2).filter(|pair| pair[0] / count != pair[1] / count) {
            let BoardRules { via_drill_mm: drill_mm, via_mm: diameter_mm, .. } = *self.rules;
            vias.push(Via { at_mm: at(change[0]), drill_mm, diameter_mm, net });
        }
    }
}

fn side_index(of: fabkit_geometry::BoardSide) -> usize {
    usize::from(of == SIDES[1])
}

/// Joins points by line segments, and merges successive ones in the same direction.
fn merge_collinear(points: &[Point]) -> Vec<[Point; 2]> {
    let mut lines: Vec<[Point; 2]> = Vec::new();
    for pair in points.windows(2) {
        let is_on = lines.last().is_some_and(|last| {
            let [u, v] = [[last[0], last[1]], [pair[0], pair[1]]]
                .map(|[a, b]: [Point; 2]| [b[0] - a[0], b[1] - a[1]]);
            let cross = u[0] * v[1] - u[1] * v[0];
            // Parallel, and not reversed.
            cross.abs() < 1e-9 * u[0].hypot(u[1]) && u[0] * v[0] + u[1] * v[1] > 0.0
        });
        match lines.last_mut() {
            Some(last) if is_on => last[1] = pair[1],
            _ => lines.push([pair[0], pair[1]]),
        }
    }
    lines
}
