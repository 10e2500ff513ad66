//! What to buy.

use std::fmt::Write;

use fabkit_report::escape;

use super::{name, of, steps, table, word};
use crate::{Costs, Guide, Purchase, Use};

impl Guide {
    pub(super) fn purchases(&self, body: &mut String) {
        *body += "<h2 id=\"buy\">What to buy</h2>\n";
        if self.bought.is_empty() && self.liquids.is_empty() && self.stock.is_empty() {
            *body += "<p>Nothing.</p>\n";
            return;
        }
        let _ = write!(
            body,
            "<p>{}. Packs are whole. Prices are guesses that tell what is dear from what is cheap; those that you \
             know better go into the sensor's file, below <code>buy:</code>.</p>\n",
            escape(&self.costs.told()),
        );
        if !self.bought.is_empty() {
            let rows = self.bought.iter().map(|piece| {
                let what = format!("{}{}", escape(&piece.what), figures(&piece.order));
                let cells = [name(&piece.name), cell(&what), of(piece.of).to_owned()];
                let quantity = format!("<td>{}</td>", piece.quantity);
                cells.concat() + &quantity + &ordered(&piece.order) + &linked(&piece.steps)
            });
            *body += "<h3>Pieces</h3>\n";
            *body += &table(&heads("piece", &["what to order", "for", "n"]), 3, rows);
        }
        if !self.liquids.is_empty() {
            *body += "<h3>What is mixed</h3>\n<p>With the waste of cups and vents.</p>\n";
            let rows = self.liquids.iter().map(|liquid| {
                let cells = [name(&liquid.name), cell(&figures(&liquid.order))];
                let mass = format!("<td>{:.2} g</td>", liquid.mass_g);
                cells.concat() + &mass + &ordered(&liquid.order) + &linked(&liquid.steps)
            });
            *body += &table(&heads("component", &["what matters", "mass"]), 2, rows);
        }
        if !self.stock.is_empty() {
            *body += "<h3>What parts are made from</h3>\n<p>As much as the parts are, solid and without support.</p>\n";
            let rows = self.stock.iter().map(|stock| {
                let what =
                    format!("for {}{}", escape(&stock.parts.join(", ")), figures(&stock.order));
                let cells = [name(&stock.name), cell(&what)];
                let amount = format!("<td>{:.0} {}</td>", stock.amount.max(1.0), stock.unit);
                cells.concat() + &amount + &ordered(&stock.order)
            });
            let heads = heads("material", &["what matters", "amount"]);
            *body += &table(&heads[..heads.len() - 1], 2, rows);
        }
        for (used, head, note) in [
            (Use::Supply, "What the work uses up", "A pack of each is enough for several units."),
            (Use::Tool, "Tools", "Not in the sum: a lab has them, or buys them once."),
        ] {
            let mut rows = self.supplies.iter().filter(|supply| supply.used == used).peekable();
            if rows.peek().is_none() {
                continue;
            }
            let _ = write!(body, "<h3>{head}</h3>\n<p>{note}</p>\n");
            let rows = rows.map(|supply| {
                let cells = [name(&supply.name), cell(&figures(&supply.order))];
                cells.concat() + &ordered(&supply.order) + &linked(&supply.steps)
            });
            *body += &table(&heads("article", &["what matters"]), 2, rows);
        }
    }
}

impl Costs {
    /// As a sentence without its full stop.
    pub(super) fn told(&self) -> String {
        let mut told = format!("About {:.0} EUR, without {}", self.total_eur, self.leaves_out);
        if !self.unknown.is_empty() {
            let _ =
                write!(told, ", and without {}, whose price is not known", self.unknown.join(", "));
        }
        told
    }
}

/// The first columns of a table, and those that all tables of purchases share.
fn heads<'a>(first: &'a str, then: &[&'a str]) -> Vec<&'a str> {
    let shared = ["order by", "packs", "EUR", "instead", "steps"];
    std::iter::once(first).chain(then.iter().copied()).chain(shared).collect()
}

fn cell(html: &str) -> String {
    format!("<td class=\"word\">{html}</td>")
}

fn linked(numbers: &[usize]) -> String {
    match numbers {
        [] => "<td>any</td>".into(),
        numbers => format!("<td>{}</td>", steps(numbers)),
    }
}

/// What matters of it: one line for each.
fn figures(order: &Purchase) -> String {
    let line = |figure: &crate::Figure| match &*figure.name {
        "what matters" => escape(&figure.value),
        name => format!("{}: {}", escape(name), escape(&figure.value)),
    };
    let lines: Vec<String> = order.figures.iter().map(line).collect();
    match &lines[..] {
        [] => "<span class=\"known\">any</span>".to_owned(),
        lines => format!("<span class=\"known\">{}</span>", lines.join("<br>")),
    }
}

/// By what it is ordered, how many packs, what they cost, what may take its place.
fn ordered(order: &Purchase) -> String {
    let by = format!(
        "{}<span class=\"known\">source: {}</span>",
        escape(&order.ordered_by()),
        escape(&order.source)
    );
    let packs = match (order.packs, &order.kit) {
        (0, Some(kit)) => format!("with {}", escape(kit)),
        (0, None) => escape(&order.pack),
        (packs, Some(kit)) => format!("{packs} × {}", escape(kit)),
        (packs, None) => format!("{packs} × {}", escape(&order.pack)),
    };
    let cost = match order.cost_eur {
        None => "not known".to_owned(),
        Some(_) if order.packs == 0 => "0".to_owned(),
        Some(cost) if cost.fract() == 0.0 => format!("{cost:.0}"),
        Some(cost) => format!("{cost:.2}"),
    };
    [cell(&by), cell(&packs), format!("<td>{cost}</td>"), word(&order.substitutes)].concat()
}
