//! What the parameters must fulfil together so that things fit, hold and can be made.

mod readout;
mod rigid;

use super::cables;
use super::channels::{Channel, Side, left_channels, spoke_radii_mm};
use super::layout::Layout;
use super::parameters::{Arrangement, SheetMold};
use crate::blocks::marks::FlatPattern;
use crate::parameters::{Report, limits};

pub(super) use rigid::check_sheets;

/// Thinnest web that a laser leaves in wood or acrylic, mm.
const CUT_WEB_MM: f64 = 1.0;

/// Least material around a bolt hole, mm.
const BOLT_WEB_MM: f64 = 2.5;

/// Least room around a tube in its channel, for glue, mm per side.
const GLUE_MM: f64 = 0.15;

/// Smallest overlap of the interface and what holds its rim, mm.
const GRIP_MM: f64 = 4.0;

/// Share of the image's half angle that may be used: the rim of an image is dark and soft.
const USED_VIEW: f64 = 0.95;

/// Smallest gap between parts that must not touch, mm.
const APART_MM: f64 = 0.3;

/// Reports every combination that cannot be built.
pub(super) fn check(p: &SheetMold, report: &mut Report) {
    let layout = Layout::new(p);
    channels(p, report);
    markers(p, report);
    rigid::plates(p, &layout, report);
    rigid::housing(p, &layout, report);
    rigid::screws(p, report);
    readout::tubes(p, report);
    readout::display(p, &layout, report);
    readout::cameras(p, &layout, report);
    cables::check(p, &layout, report);
}

/// Thinnest silicone between any two channels.
pub(super) fn thinnest_wall_mm(p: &SheetMold) -> f64 {
    let left = left_channels(p);
    let all: Vec<Channel> = Side::BOTH
        .into_iter()
        .flat_map(|side| left.iter().map(move |channel| channel.entering(side)))
        .collect();
    let pairs = all
        .iter()
        .enumerate()
        .flat_map(|(i, a)| all[i + 1..].iter().map(move |b| a.distance_to(b)));
    pairs.fold(f64::INFINITY, f64::min)
}

fn channels(p: &SheetMold, report: &mut Report) {
    let wall = p.channels.wall.mm();
    let is_grid = p.channels.arrangement == Arrangement::Grid;
    if is_grid {
        limits! { report, p:
            channels.chamber_diameter >= p.channels.width.mm(),
                "a chamber is at least as wide as its channel";
            // Past each chamber runs the channel of its neighbour.
            channels.chamber_diameter <=
                2.0 * (p.channels.pitch.mm() - wall) - p.channels.width.mm(),
                "a chamber must leave a wall to the channel beside it";
        }
    }
    let across = f64::from(p.channels.per_side - 1) * p.channels.pitch.mm();
    let widest = if is_grid { p.channels.chamber_diameter } else { p.channels.width }.mm();
    // Along x: tube, straight piece, and what the arrangement puts behind it.
    let stub = p.tubes.insertion.mm() + p.channels.width.mm() / 2.0;
    let behind = match p.channels.arrangement {
        Arrangement::Straight => p.channels.width.mm() / 2.0 + wall / 2.0,
        // Two columns of chambers, their walls, and half a wall to the middle.
        Arrangement::Grid => 1.5 * (widest + wall),
        Arrangement::Radial => {
            let middle = p.channels.per_side / 2;
            let [start, end] = [middle - 1, middle]
                .map(|k| spoke_radii_mm(p, k))
                .into_iter()
                .fold([0.0_f64; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
            report.at_least(
                "channels.pitch",
                p.channels.pitch,
                p.channels.pitch.mm() * (end + p.channels.width.mm() / 2.0) / start,
                "short spokes must begin outside of where they end",
            );
            start + p.channels.width.mm() / 2.0
        }
    };
    limits! { report, p:
        channels.width <= p.channels.pitch.mm() - wall,
            "channels must leave a wall between each other";
        channel_layer.side >= across + widest + 2.0 * wall,
            "all channels of a side enter beside each other, with a wall outside of the last";
        channel_layer.side >= 2.0 * (stub + behind),
            format!(
                "channels in the arrangement `{}` need their length",
                p.channels.arrangement.word()
            );
    }
    let is_radial = p.channels.arrangement == Arrangement::Radial;
    report.require(
        !is_radial || p.channels.per_side.is_multiple_of(2),
        "channels.per_side",
        || {
            format!(
                "channels.per_side is {}; it must be even, because long and short spokes take \
                 turns all the way round",
                p.channels.per_side
            )
        },
        || format!("write {}, or another arrangement", p.channels.per_side - 1),
    );
    let thinnest = thinnest_wall_mm(p);
    report.require(
        thinnest >= wall - 1e-9,
        "channels.arrangement",
        || {
            format!(
                "channels of the arrangement `{}` come within {:.3} mm of each other; the wall \
                 between them must be at least {} (channels.wall)",
                p.channels.arrangement.word(),
                thinnest,
                p.channels.wall
            )
        },
        || {
            format!(
                "write `straight`, or make `channels.width` at most {:.3} mm",
                (p.channels.width.mm() + thinnest - wall).max(0.0)
            )
        },
    );
}

fn markers(p: &SheetMold, report: &mut Report) {
    let is_listed = p.markers.pattern == FlatPattern::List;
    if is_listed {
        listed(p, report);
    } else {
        limits! { report, p:
            markers.diameter <= p.markers.pitch.mm() - CUT_WEB_MM,
                "the mold keeps 1 mm of wood between two holes";
        }
    }
    limits! { report, p:
        markers.height <= 2.5 * p.markers.diameter.mm(), "slender markers tear off in their mold";
    }
    if !is_listed {
        let field =
            f64::from(p.markers.per_row - 1) * p.markers.pitch.mm() + p.markers.diameter.mm();
        limits! { report, p:
            housing.window >= field + 2.0 * CUT_WEB_MM, "all markers hang in the window";
        }
    }
}

/// Markers that are listed: in the window, and apart from each other.
fn listed(p: &SheetMold, report: &mut Report) {
    let listed = p.markers.listed();
    listed.check_lengths(report);
    let most = (p.housing.window.mm() - p.markers.diameter.mm()) / 2.0 - CUT_WEB_MM;
    let window = ("all markers hang in the window", "`housing.window` or `markers.diameter`");
    for axis in [0, 1] {
        listed.check_within(axis, most, window, report);
    }
    let web = ("the mold keeps 1 mm of wood between two holes", "`markers.diameter`");
    listed.check_apart_on_plane(p.markers.diameter.mm() + CUT_WEB_MM, web, report);
}
