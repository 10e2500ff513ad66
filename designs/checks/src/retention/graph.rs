//! Graph of the bodies of the finished sensor and the connections between them.

use std::collections::BTreeSet;

use fabkit_geometry::{
    Aabb, Adhesion, Assembly, Body, BodyKind, MaterialClass, MechanicalRole, PrintGroup, Sensor,
};
use rayon::prelude::*;

use crate::contacts::{Faces, MOTION_DIRECTIONS, faces};
use crate::material_questions::MaterialQuestions;
use crate::rule::Rule;
use crate::scene::{Assemblies, Placed};

/// Strength of a bought body, and of one whose material's strength is reported as not known, MPa: a filament print
/// across its layers.
const DEFAULT_STRENGTH_MPA: f64 = 15.0;

/// Smallest area that stops a motion, mm2: a corner of a print.
const STOP_MM2: f64 = 0.3;

/// Smallest area that sticks, mm2.
const STICK_MM2: f64 = 0.5;

/// Smallest area on which a thread and a screw face each other, summed over all six directions, mm2. Less is a screw
/// that ends beside a nut.
const THREAD_MM2: f64 = 1.0;

/// A body at one placement.
pub(super) struct Node<'a> {
    pub(super) body: &'a Body,
    pub(super) placed: &'a Placed<'a>,
    /// Stress at which its material fails, MPa.
    pub(super) strength_mpa: f64,
}

impl Node<'_> {
    /// Returns whether the body is a screw, nut or other threaded fastener.
    fn is_fastener(&self) -> bool {
        matches!(self.body.duty, MechanicalRole::Fastener | MechanicalRole::Threaded)
    }
}

/// Connection between two bodies.
pub(super) struct Link<'a> {
    /// Indices of the two nodes.
    pub(super) ends: [usize; 2],
    /// Faces that the first body turns to the second.
    pub(super) faces: Faces,
    /// Bond between the two.
    pub(super) adhesion: Option<&'a Adhesion>,
    /// Whether one is screwed into the other, or both are printed as one.
    pub(super) is_tied: bool,
    /// Whether one is pressed into the other.
    pub(super) is_pressed: bool,
}

impl Link<'_> {
    /// Returns whether the first body cannot move along `way` without the second.
    fn carries(&self, way: usize) -> bool {
        let sticks = self.adhesion.is_some() && self.faces.bonded_mm2 > STICK_MM2;
        self.is_tied || self.is_pressed || sticks || self.faces.ahead_mm2[way] > STOP_MM2
    }

    /// Returns the same link as seen from its second body.
    fn turned(&self) -> Self {
        Link { ends: [self.ends[1], self.ends[0]], faces: self.faces.reversed(), ..*self }
    }
}

/// Graph of all bodies and connections.
pub(super) struct Graph<'a> {
    pub(super) nodes: Vec<Node<'a>>,
    pub(super) links: Vec<Link<'a>>,
    /// Index of the housing for each node; `usize::MAX` if nothing holds the node.
    pub(super) housings: Vec<usize>,
    /// Screws without a thread and nuts without a screw, each paired with a body that it meets.
    idle: BTreeSet<[usize; 2]>,
}

impl<'a> Graph<'a> {
    pub(super) fn new(
        sensor: &'a Sensor,
        scene: &'a Assemblies<'a>,
        questions: &MaterialQuestions,
    ) -> Self {
        let placed = scene.bodies(&Assembly::sensor().0).iter();
        let node = |placed| node(sensor, placed, questions);
        let nodes: Vec<Node> = placed.filter_map(node).collect();
        let pairs: Vec<[usize; 2]> = (0..nodes.len())
            .flat_map(|a| (a + 1..nodes.len()).map(move |b| [a, b]))
            // Copies of one body do not hold each other.
            .filter(|[a, b]| nodes[*a].body.name != nodes[*b].body.name)
            .collect();
        let links = pairs.into_par_iter().filter_map(|ends| link(sensor, &nodes, ends));
        let links: Vec<Link> = links.collect();
        let mut graph = Self { nodes, links, housings: Vec::new(), idle: BTreeSet::new() };
        graph.drop_idle();
        graph.housings = find_housings(&graph.nodes, &graph.links);
        graph
    }

    /// Removes the links of screws without a thread and of nuts without a screw, which hold nothing.
    fn drop_idle(&mut self) {
        let is_idle = |node: usize| {
            let Node { body, placed, .. } = &self.nodes[node];
            // A fastener that no tool drives needs no thread.
            let needs_thread = body.duty == MechanicalRole::Threaded
                || body.duty == MechanicalRole::Fastener && placed.is_drawn();
            needs_thread && !self.links.iter().any(|link| link.is_tied && link.ends.contains(&node))
        };
        let idle: BTreeSet<usize> = (0..self.nodes.len()).filter(|&node| is_idle(node)).collect();
        let (dropped, kept): (Vec<Link>, Vec<Link>) = std::mem::take(&mut self.links)
            .into_iter()
            .partition(|link| link.ends.iter().any(|end| idle.contains(end)));
        self.links = kept;
        let met = dropped.iter().flat_map(|link| [link.ends, [link.ends[1], link.ends[0]]]);
        self.idle.extend(met.filter(|[node, _]| idle.contains(node)));
    }

    /// Returns the pairs of nodes of which the first carries the second along when it moves along `way`.
    fn carrying(&self, way: usize) -> Vec<[usize; 2]> {
        // Each link works in both directions, with its faces seen from the other body.
        let turned: Vec<Link> = self.links.iter().map(Link::turned).collect();
        let all = self.links.iter().chain(&turned);
        all.filter(|link| link.carries(way)).map(|link| link.ends).collect()
    }

    /// Finds the nodes that can leave along `way`.
    fn unheld(&self, way: usize) -> BTreeSet<usize> {
        let count = self.nodes.len();
        let mut is_held: Vec<bool> = (0..count).map(|node| self.housings[node] == node).collect();
        let carrying = self.carrying(way);
        // Spreads from the housings until nothing changes: a node is held if it cannot move without a held one.
        loop {
            let before = is_held.clone();
            for [from, to] in &carrying {
                is_held[*from] |= is_held[*to];
            }
            if is_held == before {
                return (0..count).filter(|node| !is_held[*node]).collect();
            }
        }
    }

    /// Returns the names of the bodies that can leave along `way`, grouped by contact.
    pub(super) fn free_groups(&self, way: usize) -> Vec<Vec<&'a str>> {
        let (unheld, carrying) = (self.unheld(way), self.carrying(way));
        let together = components(self.nodes.len(), |a, b| {
            let both_free = unheld.contains(&a) && unheld.contains(&b);
            both_free && carrying.iter().any(|ends| *ends == [a, b] || *ends == [b, a])
        });
        let mut groups = Vec::new();
        for group in together {
            // An idle screw is reported with the bodies that it should hold, not by itself.
            let free = |node: &usize| unheld.contains(node) && !self.nodes[*node].is_fastener();
            let bodies = group.into_iter().filter(free);
            let mut names: Vec<&str> = bodies.map(|node| self.nodes[node].placed.name).collect();
            names.dedup();
            if !names.is_empty() {
                groups.push(names);
            }
        }
        groups
    }

    /// Returns the names of idle screws and nuts that meet one of these bodies.
    pub(super) fn idle_at(&self, bodies: &[&str]) -> BTreeSet<&'a str> {
        let name = |node: usize| self.nodes[node].placed.name;
        let at = self.idle.iter().filter(|[_, other]| bodies.contains(&name(*other)));
        at.map(|[idle, _]| name(*idle)).collect()
    }
}

/// Returns the node of a placed body. Liquids, limp bodies, and small ones that are soldered or glued on have none.
fn node<'a>(
    sensor: &'a Sensor,
    placed: &'a Placed<'a>,
    questions: &MaterialQuestions,
) -> Option<Node<'a>> {
    let body = sensor.body(placed.name)?;
    let is_small = body.duty == MechanicalRole::Attached;
    // Rings and cables hold nothing; they are held by what they go around or are plugged into.
    let is_fastener = matches!(body.duty, MechanicalRole::Fastener | MechanicalRole::Threaded);
    let is_limp =
        body.kind == BodyKind::Bought && !is_fastener && body.assembly_compliance_mm > 0.0;
    let is_liquid = body.kind == BodyKind::Cast
        && questions.class(Rule::Retention, body) == Some(MaterialClass::Liquid);
    if is_small || is_limp || is_liquid {
        return None;
    }
    // What a bought body bears is its maker's concern, and no less than a print does.
    let strength_mpa = match body.kind {
        BodyKind::Bought if body.stock.is_none() => None,
        _ => questions.strength_mpa(Rule::Retention, body),
    };
    Some(Node { body, placed, strength_mpa: strength_mpa.unwrap_or(DEFAULT_STRENGTH_MPA) })
}

/// Creates the connection of two bodies, if they meet.
fn link<'a>(sensor: &'a Sensor, nodes: &[Node], ends: [usize; 2]) -> Option<Link<'a>> {
    let [a, b] = ends.map(|end| &nodes[end]);
    let is_pair = |x: &str, y: &str| {
        (x == a.body.name && y == b.body.name) || (x == b.body.name && y == a.body.name)
    };
    let adhesions = sensor.adhesions.iter().filter(|one| is_pair(&one.bodies[0], &one.bodies[1]));
    // Only the strongest bond counts.
    let adhesion = adhesions.max_by(|x, y| x.shear_mpa.total_cmp(&y.shear_mpa));
    let faces = faces([a.placed, b.placed], adhesion.map(|one| one.reach_mm))?;
    let is_pressed = sensor.press_fits.iter().any(|fit| is_pair(&fit.inner, &fit.outer));
    let is_of = |group: &PrintGroup| [a, b].iter().all(|n| group.parts.contains(&n.body.name));
    let is_tied = is_screwed([a, b], &faces, is_pressed) || sensor.print_groups.iter().any(is_of);
    let meets = faces.meet();
    meets.then_some(Link { ends, faces, adhesion, is_tied, is_pressed })
}

/// Returns whether one is a screw and the other its thread, or one is a fastener that is pressed into the other.
fn is_screwed([a, b]: [&Node; 2], faces: &Faces, is_pressed: bool) -> bool {
    let is_one = |duty| [a, b].iter().any(|node| node.body.duty == duty);
    let is_pair = is_one(MechanicalRole::Fastener) && is_one(MechanicalRole::Threaded);
    // A fastener in its thread faces it all around.
    let in_thread = is_pair && faces.ahead_mm2.iter().sum::<f64>() > THREAD_MM2;
    in_thread || is_pressed && (a.is_fastener() || b.is_fastener())
}

/// Returns the connected components of the nodes.
fn components(count: usize, joined: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut group: Vec<usize> = (0..count).collect();
    for a in 0..count {
        for b in a + 1..count {
            if group[a] != group[b] && joined(a, b) {
                // A group has the number of its first node.
                let [from, to] = [group[b].max(group[a]), group[a].min(group[b])];
                group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
            }
        }
    }
    let firsts: BTreeSet<usize> = group.iter().copied().collect();
    firsts
        .into_iter()
        .map(|first| (0..count).filter(|node| group[*node] == first).collect())
        .collect()
}

/// Finds the housing of each node: the largest made body of its connected component.
///
/// A component that is a single body or that hovers over another component has no housing, unless it contains the
/// largest made body of all.
fn find_housings(nodes: &[Node], links: &[Link]) -> Vec<usize> {
    let joined = |a: usize, b: usize| {
        links.iter().any(|link| {
            let meets =
                (0..MOTION_DIRECTIONS).any(|way| link.carries(way) || link.turned().carries(way));
            meets && (link.ends == [a, b] || link.ends == [b, a])
        })
    };
    let size = |node: &usize| nodes[*node].placed.body.bounds().size_mm().iter().product::<f64>();
    let largest = |group: &[usize]| {
        // Bought bodies are no housing.
        let made = group.iter().copied().filter(|node| nodes[*node].body.is_made());
        made.max_by(|a, b| size(a).total_cmp(&size(b)))
    };
    let all: Vec<usize> = (0..nodes.len()).collect();
    let of_all = largest(&all);
    let mut grounds = vec![usize::MAX; nodes.len()];
    let groups = components(nodes.len(), joined);
    for group in &groups {
        let hovers = || groups.iter().any(|other| other != group && lies_over(nodes, group, other));
        let ground = largest(group);
        // A lone body or one that hovers above others is not supported, unless it is the largest of all.
        let ground = ground.filter(|node| of_all == Some(*node) || group.len() > 1 && !hovers());
        // `usize::MAX` marks nodes without a housing.
        group.iter().for_each(|node| grounds[*node] = ground.unwrap_or(usize::MAX));
    }
    grounds
}

/// Returns whether the bounding box of some bodies is above that of others and overlaps it in x and y.
fn lies_over(nodes: &[Node], upper: &[usize], lower: &[usize]) -> bool {
    let hull = |of: &[usize]| {
        let bounds = of.iter().map(|node| nodes[*node].placed.body.bounds());
        bounds.fold(Aabb::nothing(), |hull, bounds| hull.hull(&bounds))
    };
    let (upper, lower) = (hull(upper), hull(lower));
    let meets = |axis| upper.min[axis] < lower.max[axis] && lower.min[axis] < upper.max[axis];
    upper.min.z >= lower.max.z && meets(0) && meets(1)
}
