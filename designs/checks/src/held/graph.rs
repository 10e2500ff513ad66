//! Bodies of the finished sensor and what is between them.

use std::collections::BTreeSet;

use fabkit_geometry::{Aabb, Adhesion, Assembly, Body, Duty, Kind, PrintGroup, Sensor, Sort};
use rayon::prelude::*;

use crate::contacts::{Faces, WAYS, faces};
use crate::scene::{Assemblies, Placed};

/// Least area that stops a motion, mm2: a corner of a print.
const STOP_MM2: f64 = 0.3;

/// Least area that sticks, mm2.
const STICK_MM2: f64 = 0.5;

/// Least area on which a thread and a screw face each other, seen along all six ways, mm2: less is a screw
/// that ends beside a nut.
const THREAD_MM2: f64 = 1.0;

/// One body in one place.
pub(super) struct Node<'a> {
    pub(super) body: &'a Body,
    pub(super) placed: &'a Placed<'a>,
}

impl Node<'_> {
    fn is_fastener(&self) -> bool {
        matches!(self.body.duty, Duty::Fastens | Duty::Threads)
    }
}

/// What is between two bodies.
pub(super) struct Link<'a> {
    /// The two, as indices of nodes.
    pub(super) ends: [usize; 2],
    /// What the first turns to the second.
    pub(super) faces: Faces,
    /// What sticks them together.
    pub(super) adhesion: Option<&'a Adhesion>,
    /// One is screwed into the other, or they are printed as one.
    pub(super) is_tied: bool,
    /// Pressed into each other.
    pub(super) is_pressed: bool,
}

impl Link<'_> {
    /// Whether the first end cannot move that way without the second.
    fn carries(&self, way: usize) -> bool {
        let sticks = self.adhesion.is_some() && self.faces.bonded_mm2 > STICK_MM2;
        self.is_tied || self.is_pressed || sticks || self.faces.ahead_mm2[way] > STOP_MM2
    }

    fn turned(&self) -> Self {
        Link { ends: [self.ends[1], self.ends[0]], faces: self.faces.turned(), ..*self }
    }
}

/// All of them.
pub(super) struct Graph<'a> {
    pub(super) nodes: Vec<Node<'a>>,
    pub(super) links: Vec<Link<'a>>,
    /// For each node, the housing of what it belongs to.
    pub(super) grounds: Vec<usize>,
    /// Screws without a thread and nuts without a screw, which hold nothing, each with what it meets.
    idle: BTreeSet<[usize; 2]>,
}

impl<'a> Graph<'a> {
    pub(super) fn new(sensor: &'a Sensor, scene: &'a Assemblies<'a>) -> Self {
        let placed = scene.bodies(&Assembly::sensor().0).iter();
        let nodes: Vec<Node> = placed.filter_map(|placed| node(sensor, placed)).collect();
        let pairs: Vec<[usize; 2]> = (0..nodes.len())
            .flat_map(|a| (a + 1..nodes.len()).map(move |b| [a, b]))
            .filter(|[a, b]| nodes[*a].body.name != nodes[*b].body.name)
            .collect();
        let links = pairs.into_par_iter().filter_map(|ends| link(sensor, &nodes, ends));
        let links: Vec<Link> = links.collect();
        let mut graph = Self { nodes, links, grounds: Vec::new(), idle: BTreeSet::new() };
        graph.drop_idle();
        graph.grounds = grounds(&graph.nodes, &graph.links);
        graph
    }

    /// Takes out screws without a thread, and nuts without a screw.
    fn drop_idle(&mut self) {
        let is_idle = |node: usize| {
            let Node { body, placed } = &self.nodes[node];
            let needs_thread =
                body.duty == Duty::Threads || body.duty == Duty::Fastens && placed.is_drawn();
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

    /// Which bodies carry which along a way.
    fn carrying(&self, way: usize) -> Vec<[usize; 2]> {
        let turned: Vec<Link> = self.links.iter().map(Link::turned).collect();
        let all = self.links.iter().chain(&turned);
        all.filter(|link| link.carries(way)).map(|link| link.ends).collect()
    }

    /// What nothing keeps from leaving along a way.
    fn unheld(&self, way: usize) -> BTreeSet<usize> {
        let count = self.nodes.len();
        let mut is_held: Vec<bool> = (0..count).map(|node| self.grounds[node] == node).collect();
        let carrying = self.carrying(way);
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

    /// The bodies that can leave along a way, those together that meet each other.
    pub(super) fn free(&self, way: usize) -> Vec<Vec<&'a str>> {
        let (unheld, carrying) = (self.unheld(way), self.carrying(way));
        let together = components(self.nodes.len(), |a, b| {
            let both_free = unheld.contains(&a) && unheld.contains(&b);
            both_free && carrying.iter().any(|ends| *ends == [a, b] || *ends == [b, a])
        });
        let mut groups = Vec::new();
        for group in together {
            // A screw that holds nothing is told by what it should hold.
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

    /// Screws without a thread and nuts without a screw that meet one of these bodies.
    pub(super) fn idle_at(&self, bodies: &[&str]) -> BTreeSet<&'a str> {
        let name = |node: usize| self.nodes[node].placed.name;
        let at = self.idle.iter().filter(|[_, other]| bodies.contains(&name(*other)));
        at.map(|[idle, _]| name(*idle)).collect()
    }
}

/// What of the sensor takes part; liquids, limp things, and small ones that are soldered or stuck on, do not.
fn node<'a>(sensor: &'a Sensor, placed: &'a Placed<'a>) -> Option<Node<'a>> {
    let body = sensor.body(placed.name)?;
    let is_small = body.duty == Duty::Sticks;
    // Rings and cables hold nothing, and are held by what they go around or are plugged into.
    let is_fastener = matches!(body.duty, Duty::Fastens | Duty::Threads);
    let is_limp = body.kind == Kind::Bought && !is_fastener && body.gives_mm > 0.0;
    let is_liquid = body.substance.sort == Some(Sort::Liquid);
    (!is_small && !is_limp && !is_liquid).then_some(Node { body, placed })
}

fn link<'a>(sensor: &'a Sensor, nodes: &[Node], ends: [usize; 2]) -> Option<Link<'a>> {
    let [a, b] = ends.map(|end| &nodes[end]);
    let is_pair = |x: &str, y: &str| {
        (x == a.body.name && y == b.body.name) || (x == b.body.name && y == a.body.name)
    };
    let adhesions = sensor.adhesions.iter().filter(|one| is_pair(&one.bodies[0], &one.bodies[1]));
    let adhesion = adhesions.max_by(|x, y| x.shear_mpa.total_cmp(&y.shear_mpa));
    let faces = faces([a.placed, b.placed], adhesion.map(|one| one.reach_mm))?;
    let is_pressed = sensor.press_fits.iter().any(|fit| is_pair(&fit.inner, &fit.outer));
    let is_of = |group: &PrintGroup| [a, b].iter().all(|n| group.parts.contains(&n.body.name));
    let is_tied = is_screwed([a, b], &faces, is_pressed) || sensor.print_groups.iter().any(is_of);
    let meets = faces.meet();
    meets.then_some(Link { ends, faces, adhesion, is_tied, is_pressed })
}

/// Whether one is a screw and the other what its thread holds in, or both hold the same thread.
fn is_screwed([a, b]: [&Node; 2], faces: &Faces, is_pressed: bool) -> bool {
    let is_one = |duty| [a, b].iter().any(|node| node.body.duty == duty);
    let is_pair = is_one(Duty::Fastens) && is_one(Duty::Threads);
    let in_thread = is_pair && faces.ahead_mm2.iter().sum::<f64>() > THREAD_MM2;
    in_thread || is_pressed && (a.is_fastener() || b.is_fastener())
}

/// Sets of nodes that are joined, directly or by others.
fn components(count: usize, joined: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut group: Vec<usize> = (0..count).collect();
    for a in 0..count {
        for b in a + 1..count {
            if group[a] != group[b] && joined(a, b) {
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

/// What stands by itself is held by the largest part of it, be it on a table or on a robot.
///
/// A body that meets nothing is held by nothing, unless it is the largest of all; so is what hovers over
/// something else.
fn grounds(nodes: &[Node], links: &[Link]) -> Vec<usize> {
    let joined = |a: usize, b: usize| {
        links.iter().any(|link| {
            let meets = (0..WAYS).any(|way| link.carries(way) || link.turned().carries(way));
            meets && (link.ends == [a, b] || link.ends == [b, a])
        })
    };
    let size = |node: &usize| nodes[*node].placed.body.bounds().size_mm().iter().product::<f64>();
    let largest = |group: &[usize]| {
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
        let ground = ground.filter(|node| of_all == Some(*node) || group.len() > 1 && !hovers());
        group.iter().for_each(|node| grounds[*node] = ground.unwrap_or(usize::MAX));
    }
    grounds
}

/// Whether all of some bodies is above all of others, and some of it straight above them.
fn lies_over(nodes: &[Node], upper: &[usize], lower: &[usize]) -> bool {
    let hull = |of: &[usize]| {
        let bounds = of.iter().map(|node| nodes[*node].placed.body.bounds());
        bounds.fold(Aabb::nothing(), |hull, bounds| hull.hull(&bounds))
    };
    let (upper, lower) = (hull(upper), hull(lower));
    let meets = |axis| upper.min[axis] < lower.max[axis] && lower.min[axis] < upper.max[axis];
    upper.min.z >= lower.max.z && meets(0) && meets(1)
}
