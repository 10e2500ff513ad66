//! Room for tools and hands at the bodies on which they work.

use std::collections::HashSet;

use fabkit_geometry::{Occasion, ToolAccess};

use super::arrival::Work;
use super::obstruction::Obstruction;
use super::path::{Contact, overlap};
use crate::memo::{Key, Memo};
use crate::rule::Rule;
use crate::scene::{Placed, Tool};

/// Returns the number of tools that work on a body on an occasion.
pub(super) fn count(placed: &Placed, occasion: Occasion) -> usize {
    placed.of.reach.iter().filter(|reach| reach.occasion == occasion).count()
}

/// Pairs of a tool's room and a body that is known to stand in it, by their keys.
pub(super) type Blocked = HashSet<(u128, u128)>;

/// Returns whether each tool that installs a body has room in at least one of its poses.
pub(super) fn has_room(
    placed: &Placed,
    others: &[&Placed],
    memo: &Memo,
    blocked: &mut Blocked,
) -> bool {
    let tools = placed.of.reach.iter().zip(&placed.tools);
    let mut arriving = tools.filter(|(reach, _)| reach.occasion == Occasion::Arrival);
    arriving.all(|(reach, rooms)| {
        // One free room is enough.
        rooms.iter().any(|room| {
            let mut others = others.iter().filter(|other| is_obstacle(reach, placed, other));
            let is_known = |other: &&&Placed| blocked.contains(&(room.key, other.key));
            // A known obstacle saves the exact test.
            if others.clone().any(|other| is_known(&other)) {
                return false;
            }
            let met = others.find(|other| meets(room, other, memo).is_some());
            blocked.extend(met.map(|other| (room.key, other.key)));
            met.is_none()
        })
    })
}

/// Returns whether a body can obstruct a tool.
fn is_obstacle(reach: &ToolAccess, placed: &Placed, other: &Placed) -> bool {
    !(reach.ignores_copies && other.name == placed.name)
}

/// Returns the overlap of a body with a tool's room.
fn meets(room: &Tool, other: &Placed, memo: &Memo) -> Option<Contact> {
    let key = Key::new(6).key(room.key).key(other.key);
    let mut contact = None;
    memo.is_clean(&key, || {
        contact = overlap(&room.room, &other.body, 0.0);
        contact.is_none()
    });
    contact
}

/// Finds the obstacle in the room of one of a body's tools.
pub(super) fn without_room<'a>(
    placed: &'a Placed<'a>,
    occasion: Occasion,
    others: &[&'a Placed<'a>],
    memo: &Memo,
) -> Option<Obstruction<'a>> {
    let tools = placed.of.reach.iter().zip(&placed.tools);
    tools
        .filter(|(reach, _)| reach.occasion == occasion)
        .find_map(|(reach, rooms)| kept_out(placed, reach, rooms, others, memo))
}

/// Finds the obstacle in that room of a tool that is obstructed least; `None` if one room is free.
fn kept_out<'a>(
    placed: &'a Placed<'a>,
    reach: &'a ToolAccess,
    rooms: &[Tool],
    others: &[&'a Placed<'a>],
    memo: &Memo,
) -> Option<Obstruction<'a>> {
    let blocked = |room: &Tool| {
        others.iter().filter(|other| is_obstacle(reach, placed, other)).find_map(|other| {
            meets(room, other, memo).map(|contact| Obstruction {
                rule: Rule::Access,
                body: placed.name,
                obstacle: other.name,
                tool: Some(reach.tool.as_str()),
                along: None,
                contact,
            })
        })
    };
    let mut least: Option<Obstruction> = None;
    for room in rooms {
        // The first free room ends the search.
        let stuck = blocked(room)?;
        if least.as_ref().is_none_or(|least| stuck.contact.depth_mm < least.contact.depth_mm) {
            least = Some(stuck);
        }
    }
    least
}

/// Finds obstacles to the tools of a step that pours, adjusts or demolds. Also returns the number of tools.
pub(super) fn check_work<'a>(work: &Work<'a>, memo: &Memo) -> (Vec<Obstruction<'a>>, usize) {
    // Screws are drawn before anything is taken off.
    let is_there = |other: &&Placed| work.occasion != Occasion::Removal || !other.is_drawn();
    let around: Vec<&Placed> = work.around.iter().copied().filter(is_there).collect();
    let stuck = work.on.iter().filter_map(|on| without_room(on, work.occasion, &around, memo));
    (stuck.collect(), work.on.iter().map(|on| count(on, work.occasion)).sum())
}
