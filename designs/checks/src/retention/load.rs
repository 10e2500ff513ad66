//! Force that the touched body bears before a connection gives way.

use std::collections::VecDeque;

use fabkit_geometry::{Point3, Ray, Sensor, Vector3};

use super::graph::{Graph, Link};
use crate::contacts::{MOTION_DIRECTIONS, opposite};
use crate::finding::{Finding, Severity};
use crate::rule::Rule;
use crate::sampling_lines::Caster;

/// Friction of a press fit per area, MPa: a pressure of 0.5 MPa, which creeping plastics keep, times a coefficient of
/// 0.2 (chosen).
const FRICTION_MPA: f64 = 0.1;

/// Capacity that stands for infinity, N; more than anything here bears.
const UNLIMITED_N: f64 = 1e6;

/// Force above which messages say only "more than", N.
const MAX_REPORTED_N: f64 = 1e3;

/// Position (x, y) of the ray that finds the touched body, mm: slightly off the axis, on which vents and screws lie.
const BESIDE_MM: [f64; 2] = [0.013, 0.007];

/// Directions in which the touched body is dragged (+x, -x, +y, -y).
const SHEAR: std::ops::Range<usize> = 0..4;
/// Direction in which the touched body is pulled off, +z.
const PULL: usize = 4;

/// Smallest force at which a connection gives way.
struct MinimumCut {
    newtons: f64,
    /// Strongest link of the cut: its two bodies, the leaving one first, and the kind of connection.
    at: Option<([usize; 2], String)>,
}

/// Compares the force that the touched body bears, in shear and in tension, with the stated load.
pub(super) fn examine(sensor: &Sensor, graph: &Graph) -> Vec<Finding> {
    let Some(load_n) = sensor.required_load_n else { return Vec::new() };
    let Some(touched) = touched(sensor, graph) else { return Vec::new() };
    let ground = graph.housings[touched];
    // The rule of retention has already reported a body without a housing.
    if ground == usize::MAX || ground == touched {
        return Vec::new();
    }
    let shears = SHEAR.map(|way| minimum_cut(graph, touched, ground, way));
    let Some(shear) = shears.min_by(|a, b| a.newtons.total_cmp(&b.newtons)) else {
        return Vec::new();
    };
    let pull = minimum_cut(graph, touched, ground, PULL);
    let mut findings = Vec::new();
    for (word, weakest) in [("pull", &pull), ("shear", &shear)] {
        if weakest.newtons < load_n {
            findings.push(gives_way(graph, touched, word, weakest, load_n));
        }
    }
    if findings.is_empty() {
        let name = graph.nodes[touched].placed.name;
        let message = format!(
            "{name} withstands a pull of {} and a shear of {} before it comes off (lower strengths)",
            newtons(&pull),
            newtons(&shear)
        );
        let fix = format!("nothing to do: `loads.touch` requires {load_n} N");
        let note = Finding::error(Rule::Retention, message, fix).with_severity(Severity::Note);
        let least = pull.newtons.min(shear.newtons).min(MAX_REPORTED_N);
        findings.push(note.about_bodies([name]).with_measurement(least, load_n, "N"));
    }
    findings
}

/// Formats a force.
fn newtons(weakest: &MinimumCut) -> String {
    match weakest.newtons {
        n if n >= MAX_REPORTED_N => format!("more than {MAX_REPORTED_N} N"),
        n if n < 10.0 => format!("{n:.1} N"),
        n => format!("{n:.0} N"),
    }
}

/// Reports a load that tears a connection.
fn gives_way(
    graph: &Graph,
    touched: usize,
    word: &str,
    weakest: &MinimumCut,
    load_n: f64,
) -> Finding {
    let name = |node: usize| graph.nodes[node].placed.name;
    let message = match &weakest.at {
        Some(([leaves, stays], how)) => format!(
            "a {word} at {} tears {} off {} at {} ({how})",
            name(touched),
            name(*leaves),
            name(*stays),
            newtons(weakest)
        ),
        None => format!("nothing holds {} against a {word}", name(touched)),
    };
    let fix = "take a larger face, a primer, a glue, or a shoulder that holds by its shape; or lower `loads.touch`";
    let bodies = match &weakest.at {
        Some((ends, _)) => ends.map(name).to_vec(),
        None => vec![name(touched)],
    };
    let finding = Finding::error(Rule::Retention, message, fix).about_bodies(bodies);
    finding.with_measurement(weakest.newtons, load_n, "N")
}

/// Finds the body that a finger meets first: the first one below the apex of the touch surface.
fn touched(sensor: &Sensor, graph: &Graph) -> Option<usize> {
    let touch = sensor.touch.as_ref()?;
    let [x, y] = BESIDE_MM;
    // The ray starts 1 mm above the apex.
    let above = touch.apex_z_mm() + 1.0;
    let ray = Ray { origin: Point3::new(x, y, above), direction: -Vector3::z() };
    let mut caster = Caster::default();
    let mut first: Option<(f64, usize)> = None;
    for (index, node) in graph.nodes.iter().enumerate() {
        let Some(stretch) = caster.stretches(&node.placed.body, &ray).next() else { continue };
        if stretch.enter.t > 0.0 && first.is_none_or(|(t, _)| stretch.enter.t < t) {
            first = Some((stretch.enter.t, index));
        }
    }
    first.map(|(_, index)| index)
}

/// Computes the force that the first body of a link passes to the second when it moves along `way`, N.
fn capacity_n(graph: &Graph, link: &Link, is_turned: bool, way: usize) -> f64 {
    if link.is_tied {
        return UNLIMITED_N;
    }
    let faces = if is_turned { link.faces.reversed() } else { link.faces };
    // The weaker of the two materials gives way.
    let tears = link.ends.map(|end| graph.nodes[end].strength_mpa);
    let stops = faces.ahead_mm2[way] * tears[0].min(tears[1]);
    // Friction acts on faces in all directions.
    let area_mm2: f64 = faces.ahead_mm2.iter().sum::<f64>();
    let rubs = if link.is_pressed { area_mm2 * FRICTION_MPA } else { 0.0 };
    let sticks = link.adhesion.map_or(0.0, |one| {
        // Faces that move away are in tension, faces parallel to the motion in shear.
        faces.across_mm2[opposite(way)] * one.pull_mpa + faces.beside_mm2[way / 2] * one.shear_mpa
    });
    (stops + rubs + sticks).min(UNLIMITED_N)
}

/// Computes the minimum cut between the touched body and its housing (Edmonds and Karp, 1972).
fn minimum_cut(graph: &Graph, from: usize, to: usize, way: usize) -> MinimumCut {
    debug_assert!(way < MOTION_DIRECTIONS);
    let count = graph.nodes.len();
    let mut rest = vec![vec![0.0; count]; count];
    for link in &graph.links {
        let [a, b] = link.ends;
        rest[a][b] += capacity_n(graph, link, false, way);
        rest[b][a] += capacity_n(graph, link, true, way);
    }
    let all = rest.clone();
    let mut newtons = 0.0;
    loop {
        let before = search(&rest, from);
        // No path is left, or the connection is practically unbreakable.
        if before[to].is_none() || newtons >= UNLIMITED_N {
            let is_near = |node: usize| node == from || before[node].is_some();
            // The nodes that can still be reached are one side of the minimum cut.
            let at = if newtons >= UNLIMITED_N { None } else { cut(graph, &all, is_near) };
            return MinimumCut { newtons, at };
        }
        let mut path = vec![to];
        while let Some(last) = before[path[path.len() - 1]] {
            path.push(last);
        }
        let least =
            path.windows(2).map(|ends| rest[ends[1]][ends[0]]).fold(f64::INFINITY, f64::min);
        for ends in path.windows(2) {
            // Paths run from the end to the start.
            rest[ends[1]][ends[0]] -= least;
            rest[ends[0]][ends[1]] += least;
        }
        newtons += least;
    }
}

/// Searches the residual graph breadth first. Returns the predecessor of each node that can be reached.
fn search(rest: &[Vec<f64>], from: usize) -> Vec<Option<usize>> {
    /// Residual capacity below which an edge is saturated up to rounding, N.
    const NOTHING_N: f64 = 1e-9;
    let mut before = vec![None; rest.len()];
    let mut next = VecDeque::from([from]);
    while let Some(node) = next.pop_front() {
        for other in 0..rest.len() {
            if other != from && before[other].is_none() && rest[node][other] > NOTHING_N {
                before[other] = Some(node);
                next.push_back(other);
            }
        }
    }
    before
}

/// Finds the strongest of the links across the cut.
fn cut(
    graph: &Graph,
    all: &[Vec<f64>],
    is_near: impl Fn(usize) -> bool,
) -> Option<([usize; 2], String)> {
    let crossing = graph.links.iter().filter_map(|link| {
        let [a, b] = link.ends;
        let ends = match (is_near(a), is_near(b)) {
            (true, false) => [a, b],
            (false, true) => [b, a],
            _ => return None,
        };
        Some((all[ends[0]][ends[1]], ends, link))
    });
    let (_, ends, link) = crossing.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let how = match link.adhesion.filter(|_| link.faces.bonded_mm2 > 0.0) {
        Some(one) => format!("{}, {:.0} mm2", one.by, link.faces.bonded_mm2),
        None => "they only touch".to_owned(),
    };
    Some((ends, how))
}
