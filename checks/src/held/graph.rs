//! Bodies of the finished sensor and what is between them.

use std::collections::BTreeSet;

use fabkit_geometry::{Adhesion, Assembly, Body, Kind, Sensor, Sort};
use rayon::prelude::*;

use crate::contacts::{Faces, WAYS, faces};
use crate::scene::{Assemblies, Placed};

/// Least area that stops a motion, mm2: a corner of a print.
const STOP_MM2: f64 = 0.3;

/// Least area that sticks, mm2.
const STICK_MM2: f64 = 0.5;

/// Words in the names of what screws, pins and ties.
const FASTENERS: [&str; 6] = ["screw", "bolt", "nut", "spacer", "dowel", "cable-tie"];

/// In the names of threads that are melted in: screws hold on to them, and they hold nothing that only
/// lies against them.
const INSERT: &str = "insert";

/// Bought things of which there are more than that are small and soldered or stuck on.
const MOST_PLACES: usize = 4;

/// One body in one place.
pub(super) struct Node<'a> {
    pub(super) body: &'a Body,
    pub(super) placed: &'a Placed<'a>,
    is_fastener: bool,
}

/// What is between two bodies.
pub(super) struct Link<'a> {
    /// The two, as indices of nodes.
    pub(super) ends: [usize; 2],
    /// What the first turns to the second.
    pub(super) faces: Faces,
    /// What sticks them together.
    pub(super) adhesion: Option<&'a Adhesion>,
    /// Screwed together, or printed as one.
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
        let mut links: Vec<Link> = links.collect();
        tie_fasteners(&nodes, &mut links);
        let grounds = grounds(&nodes, &links);
        Self { nodes, links, grounds }
    }

    /// The bodies that can leave along a way, those together that meet each other.
    pub(super) fn free(&self, way: usize) -> Vec<Vec<&'a str>> {
        let mut is_held: Vec<bool> =
            (0..self.nodes.len()).map(|node| self.grounds[node] == node).collect();
        let turned: Vec<Link> = self.links.iter().map(Link::turned).collect();
        let carrying: Vec<[usize; 2]> = self
            .links
            .iter()
            .chain(&turned)
            .filter(|link| link.carries(way))
            .map(|link| link.ends)
            .collect();
        loop {
            let before = is_held.clone();
            for [from, to] in &carrying {
                is_held[*from] |= is_held[*to];
            }
            if is_held == before {
                break;
            }
        }
        let together = components(self.nodes.len(), |a, b| {
            let both_free = !is_held[a] && !is_held[b];
            both_free && carrying.iter().any(|ends| *ends == [a, b] || *ends == [b, a])
        });
        let mut groups = Vec::new();
        for group in together {
            let free: BTreeSet<usize> = group.into_iter().filter(|node| !is_held[*node]).collect();
            // A screw that holds nothing is told by what it should hold.
            let bodies = free.iter().filter(|node| !self.nodes[**node].is_fastener);
            let mut names: Vec<&str> = bodies.map(|node| self.nodes[*node].placed.name).collect();
            names.dedup();
            if !names.is_empty() {
                groups.push(names);
            }
        }
        groups
    }
}

/// What of the sensor takes part; liquids, limp things, and small ones that are soldered or stuck on, do not.
fn node<'a>(sensor: &'a Sensor, placed: &'a Placed<'a>) -> Option<Node<'a>> {
    let body = sensor.body(placed.name)?;
    let is_fastener =
        body.kind == Kind::Bought && FASTENERS.iter().any(|word| body.name.contains(word));
    let assembly = Assembly::sensor();
    let places = body.placements.iter().filter(|place| place.assembly == assembly).count();
    let is_small = body.kind == Kind::Bought
        && !is_fastener
        && (places > MOST_PLACES || body.name.contains("led"));
    // Rings and cables hold nothing, and are held by what they go around or are plugged into.
    let is_limp = body.kind == Kind::Bought && !is_fastener && body.gives_mm > 0.0;
    let is_liquid = body.substance.sort == Some(Sort::Liquid);
    (!is_small && !is_limp && !is_liquid).then_some(Node { body, placed, is_fastener })
}

fn link<'a>(sensor: &'a Sensor, nodes: &[Node], ends: [usize; 2]) -> Option<Link<'a>> {
    let [a, b] = ends.map(|end| &nodes[end]);
    let is_pair = |x: &str, y: &str| {
        (x == a.body.name && y == b.body.name) || (x == b.body.name && y == a.body.name)
    };
    let adhesions = sensor.adhesions.iter().filter(|one| is_pair(&one.bodies[0], &one.bodies[1]));
    let adhesion = adhesions.max_by(|x, y| x.shear_mpa.total_cmp(&y.shear_mpa));
    let faces = faces([a.placed, b.placed], adhesion.map(|one| one.reach_mm))?;
    let is_tied = sensor
        .print_groups
        .iter()
        .any(|group| [a, b].iter().all(|node| group.parts.contains(&node.body.name)));
    let is_pressed = sensor.press_fits.iter().any(|fit| is_pair(&fit.inner, &fit.outer));
    let meets = faces.meet();
    meets.then_some(Link { ends, faces, adhesion, is_tied, is_pressed })
}

/// A screw that has a thread to hold on to fixes all that it touches; one without holds nothing.
fn tie_fasteners(nodes: &[Node], links: &mut [Link]) {
    let is_fastener = |node: usize| nodes[node].is_fastener;
    let is_thread = |node: usize| {
        let body = nodes[node].body;
        is_fastener(node) || body.kind == Kind::Bought && body.name.contains(INSERT)
    };
    let threads: Vec<bool> = (0..nodes.len())
        .map(|node| {
            let mut own = links.iter().filter(|link| link.ends.contains(&node));
            let grips =
                |link: &Link| link.is_pressed || link.ends.iter().all(|end| is_thread(*end));
            is_fastener(node) && own.any(grips)
        })
        .collect();
    for link in links {
        link.is_tied |= link.ends.iter().any(|end| threads[*end]);
    }
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
/// A body that meets nothing is held by nothing, unless it is the largest of all.
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
    for group in components(nodes.len(), joined) {
        let ground = largest(&group).filter(|node| group.len() > 1 || of_all == Some(*node));
        group.iter().for_each(|node| grounds[*node] = ground.unwrap_or(usize::MAX));
    }
    grounds
}
