//! Section on soldering and wiring.

use std::fmt::Write;

use fabkit_report::{Svg, escape};

use super::{BoardArt, PageImages, name, table, word};
use crate::Guide;
use crate::wiring::{WiredPart, Wiring};

/// Maximum number of branches drawn; a note counts the others.
const MOST_BRANCHES: usize = 8;

impl Guide {
    /// Appends the section of each circuit.
    pub(super) fn wires(&self, body: &mut String, images: &PageImages) {
        if self.wiring.is_empty() {
            return;
        }
        *body += "<h2 id=\"wire\">Wire</h2>\n";
        for wiring in &self.wiring {
            let _ = writeln!(body, "<h3>{}</h3>", escape(&wiring.name));
            let current = match wiring.current_a {
                0.0 => String::new(),
                a => format!(", {:.0} mA with all LEDs on", a * 1e3),
            };
            let _ = writeln!(body, "<p>Supply: {} V{current}.</p>", wiring.supply_v);
            if let Some(diagram) = diagram(wiring) {
                let _ = writeln!(
                    body,
                    "<figure class=\"circuit\" tabindex=\"0\">{diagram}<figcaption>The circuit of {}.</figcaption></figure>",
                    escape(&wiring.name)
                );
            }
            artwork(body, &self.name, wiring, images);
            connections(body, wiring);
            resistors(body, wiring);
            soldered(body, wiring);
            if !wiring.notes.is_empty() {
                let notes: String =
                    wiring.notes.iter().map(|note| format!("<li>{}</li>", escape(note))).collect();
                let _ = writeln!(body, "<ul>{notes}</ul>");
            }
        }
    }
}

/// Appends the artwork of a board, or the reason why there is none.
fn artwork(body: &mut String, design: &str, wiring: &Wiring, images: &PageImages) {
    let art = wiring.board.as_ref().and_then(|board| images.boards.get(board));
    let _ = match art {
        Some(BoardArt::Drawn([top, bottom])) => writeln!(
            body,
            "<figure class=\"board\">{}{}<figcaption>Upper side from above, lower side from below: bare \
             copper is gold, covered copper light green. Files to order it: <code>fabkit export {} --format \
             gerber</code>.</figcaption></figure>",
            inline(top),
            inline(bottom),
            escape(design)
        ),
        Some(BoardArt::Refused(why)) => writeln!(
            body,
            "<p>fabkit cannot lay this board out with these sizes: {}.</p>",
            escape(why)
        ),
        None => Ok(()),
    };
}

/// Appends the table of wires and cables.
fn connections(body: &mut String, wiring: &Wiring) {
    let rows = wiring.connections.iter().map(|wire| {
        let drawn = wire.drawn_mm.map_or("-".to_owned(), |mm| format!("{mm:.0} mm"));
        let or_dash = |text: &Option<String>| word(text.as_deref().unwrap_or("-"));
        [
            name(&wire.from),
            word(&wire.to),
            word(&wire.carries),
            or_dash(&wire.color),
            or_dash(&wire.by),
            format!("<td>{drawn}</td>"),
        ]
        .concat()
    });
    *body += &table(&["from", "to", "carries", "color", "piece", "inside the sensor"], 5, rows);
}

/// Appends the table of calculated resistors.
fn resistors(body: &mut String, wiring: &Wiring) {
    if wiring.resistors.is_empty() {
        return;
    }
    let rows = wiring.resistors.iter().map(|one| {
        format!(
            "{}{}<td>{} ohm</td><td>{:.3} W of {} W</td>{}",
            name(&one.designators.join(" ")),
            word(&one.calculation),
            one.ohm,
            one.power_w,
            one.rated_w,
            word(&one.source)
        )
    });
    *body += &table(&["resistor", "calculation", "order", "heat", "from"], 2, rows);
}

/// Appends the table of soldered parts.
fn soldered(body: &mut String, wiring: &Wiring) {
    if wiring.parts.is_empty() {
        return;
    }
    let rows = wiring.parts.iter().map(|part| {
        let pins = part
            .pins
            .iter()
            .map(|pin| format!("{}: {}", pin.pin, pin.net.as_deref().unwrap_or("free")));
        [
            name(&part.designator),
            word(&part.value),
            word(&part.package),
            word(&pins.collect::<Vec<_>>().join(", ")),
        ]
        .concat()
    });
    *body += &table(&["part", "what to order", "package", "pin: net"], 4, rows);
}

/// Branch from the supply to ground.
struct Branch {
    boxes: Vec<String>,
    leds: Vec<String>,
}

/// Draws the circuit: supply on top, ground at the bottom, a branch for each resistor.
fn diagram(wiring: &Wiring) -> Option<String> {
    let branches = branches(wiring);
    if branches.is_empty() {
        return None;
    }
    let shown = branches.len().min(MOST_BRANCHES);
    let (step, left) = (96.0, 60.0);
    let width = left + step * shown as f64 + 20.0;
    let tallest = branches.iter().map(|branch| branch.boxes.len()).max().unwrap_or(0) as f64;
    let (top, box_height, pitch) = (18.0, 24.0, 40.0);
    let led_y = top + 14.0 + tallest * pitch;
    let bottom = led_y + 54.0;
    let mut svg = Svg::new(width, bottom + 24.0);
    let line = "stroke=\"#1f4e79\" stroke-width=\"1.6\"";
    svg.line([left, top], [width - 10.0, top], line);
    svg.line([left, bottom], [width - 10.0, bottom], line);
    svg.text([left - 8.0, top + 4.0], "end", "V+");
    svg.text([left - 8.0, bottom + 4.0], "end", "GND");
    for (index, branch) in branches.iter().take(shown).enumerate() {
        let x = left + step * (index as f64 + 0.5);
        svg.line([x, top], [x, led_y], line);
        for (row, text) in branch.boxes.iter().enumerate() {
            let y = top + 14.0 + row as f64 * pitch;
            svg.rect([x - 40.0, y], [80.0, box_height], &format!("fill=\"#fafafa\" {line}"));
            svg.text([x, y + 16.0], "middle", text);
        }
        // LED symbol: a triangle towards ground, and the bar of the cathode.
        let (y, half) = (led_y, 10.0);
        for (from, to) in [
            ([x - half, y], [x + half, y]),
            ([x - half, y], [x, y + 16.0]),
            ([x + half, y], [x, y + 16.0]),
            ([x - half, y + 16.0], [x + half, y + 16.0]),
            ([x, y + 16.0], [x, bottom]),
        ] {
            svg.line(from, to, line);
        }
        let leds = match &branch.leds[..] {
            [one] => one.clone(),
            [first, .., last] => format!("{first} to {last}"),
            [] => String::new(),
        };
        svg.text([x + 14.0, y + 14.0], "start", &leds);
    }
    if branches.len() > shown {
        let more = format!("and {} more like these", branches.len() - shown);
        svg.text([width - 12.0, bottom + 18.0], "end", &more);
    }
    Some(svg.finish(&format!("circuit of {}", wiring.name)))
}

/// Finds the branch of each resistor: the LEDs behind it, directly or through a switch.
fn branches(wiring: &Wiring) -> Vec<Branch> {
    let net = |part: &WiredPart, pin: &str| {
        part.pins.iter().find(|one| one.pin == pin).and_then(|one| one.net.clone())
    };
    let of_kind = |kind: &'static str| wiring.parts.iter().filter(move |part| part.kind == kind);
    let lit = |from: &Option<String>| -> Vec<String> {
        let on = of_kind("led").filter(|led| from.is_some() && net(led, "A") == *from);
        on.map(|led| led.designator.clone()).collect()
    };
    let branch = |resistor: &WiredPart| {
        let mut boxes = vec![format!("{} {}", resistor.designator, resistor.value)];
        let after = net(resistor, "2");
        let mut leds = lit(&after);
        if leds.is_empty() {
            // The resistor may feed a switch: follow its channel from the common to the normally open contact.
            for switch in of_kind("switch") {
                for (common, open) in [("2", "1"), ("6", "5")] {
                    if after.is_some() && net(switch, common) == after {
                        boxes.push(format!("{} {common} to {open}", switch.designator));
                        leds = lit(&net(switch, open));
                    }
                }
            }
        }
        Branch { boxes, leds }
    };
    of_kind("resistor").map(branch).collect()
}

/// Removes the namespace, which an SVG within a page does not need: a page without addresses cannot make requests.
fn inline(svg: &str) -> String {
    svg.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", "", 1)
}
