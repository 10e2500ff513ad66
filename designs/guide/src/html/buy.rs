//! Section on purchases.

use std::collections::BTreeMap;
use std::fmt::Write;

use fabkit_report::escape;

use super::{name, of, steps, table, word};
use crate::{Costs, Guide, Purchase, SupplyKind};

impl Guide {
    /// Appends the tables of pieces, mixes, stock, consumables and tools.
    pub(super) fn purchases(&self, body: &mut String) {
        *body += "<h2 id=\"buy\">What to buy</h2>\n";
        if self.bought.is_empty() && self.liquids.is_empty() && self.stock.is_empty() {
            *body += "<p>Nothing.</p>\n";
            return;
        }
        let usual = self.usual_price_source();
        let ordered = |order: &Purchase| ordered(order, usual);
        let _ = writeln!(
            body,
            "<p>{}. Packs are whole. Prices without a source are {}; write better ones into the sensor's file, below <code>buy:</code>.</p>",
            escape(&self.costs.to_sentence()),
            escape(usual),
        );
        if !self.bought.is_empty() {
            let rows = self.bought.iter().map(|piece| {
                let what = format!("{}{}", escape(&piece.what), figures(&piece.order));
                let [by, instead, packs, cost] = ordered(&piece.order);
                let quantity = format!("<td>{}</td>", piece.quantity);
                [name(&piece.name), cell(&what), by, instead, of(piece.of).to_owned(), packs]
                    .concat()
                    + &[quantity, cost, linked(&piece.steps)].concat()
            });
            *body += "<h3>Pieces</h3>\n";
            let heads = [
                "piece",
                "what to order",
                "order by",
                "instead",
                "for",
                "packs",
                "n",
                "EUR",
                "steps",
            ];
            *body += &table(&heads, 6, rows);
        }
        if !self.liquids.is_empty() {
            *body += "<h3>Mixtures</h3>\n<p>Amounts include the waste of cups and vents.</p>\n";
            let rows = self.liquids.iter().map(|liquid| {
                let [by, instead, packs, cost] = ordered(&liquid.order);
                let mass = format!("<td>{:.2} g</td>", liquid.mass_g);
                let cells = [name(&liquid.name), cell(&figures(&liquid.order)), by, instead, packs];
                cells.concat() + &[mass, cost, linked(&liquid.steps)].concat()
            });
            *body += &table(&heads("component", &["mass", "EUR", "steps"]), 5, rows);
        }
        if !self.stock.is_empty() {
            *body += "<h3>Materials of parts</h3>\n<p>Amounts are those of solid parts without supports.</p>\n";
            let rows = self.stock.iter().map(|stock| {
                let what =
                    format!("for {}{}", escape(&in_series(&stock.parts)), figures(&stock.order));
                let [by, instead, packs, cost] = ordered(&stock.order);
                let amount = format!("<td>{:.0} {}</td>", stock.amount.max(1.0), stock.unit);
                [name(&stock.name), cell(&what), by, instead, packs, amount, cost].concat()
            });
            *body += &table(&heads("material", &["amount", "EUR"]), 5, rows);
        }
        for (used, head, note) in [
            (SupplyKind::Supply, "Consumables", "A pack of each is enough for several units."),
            (SupplyKind::Tool, "Tools", "Not in the sum: most labs have them."),
        ] {
            let mut rows = self.supplies.iter().filter(|supply| supply.used == used).peekable();
            if rows.peek().is_none() {
                continue;
            }
            let _ = write!(body, "<h3>{head}</h3>\n<p>{note}</p>\n");
            let rows = rows.map(|supply| {
                let [by, instead, packs, cost] = ordered(&supply.order);
                let cells = [name(&supply.name), cell(&figures(&supply.order)), by, instead, packs];
                cells.concat() + &[cost, linked(&supply.steps)].concat()
            });
            *body += &table(&heads("article", &["EUR", "steps"]), 5, rows);
        }
    }

    /// Returns the most frequent source of prices.
    fn usual_price_source(&self) -> &str {
        let bought = self.bought.iter().map(|piece| &piece.order);
        let liquids = self.liquids.iter().map(|liquid| &liquid.order);
        let stock = self.stock.iter().map(|stock| &stock.order);
        let supplies = self.supplies.iter().map(|supply| &supply.order);
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for order in bought.chain(liquids).chain(stock).chain(supplies) {
            *counts.entry(&order.price_source).or_default() += 1;
        }
        counts.into_iter().max_by_key(|(_, count)| *count).map_or("", |(source, _)| source)
    }
}

impl Costs {
    /// Returns the costs as a sentence without its full stop.
    pub(super) fn to_sentence(&self) -> String {
        let mut told = format!("About {:.0} EUR, without {}", self.total_eur, self.leaves_out);
        if !self.unknown.is_empty() {
            let _ =
                write!(told, ", and without {}, whose price is not known", self.unknown.join(", "));
        }
        told
    }
}

/// Returns the heads that these tables share, with their own first and last columns.
fn heads<'a>(first: &'a str, last: &[&'a str]) -> Vec<&'a str> {
    let words = [first, "what matters", "order by", "instead", "packs"];
    words.into_iter().chain(last.iter().copied()).collect()
}

fn cell(html: &str) -> String {
    format!("<td class=\"word\">{html}</td>")
}

/// Formats the cell with links to steps; `any` without steps.
fn linked(numbers: &[usize]) -> String {
    match numbers {
        [] => "<td>any</td>".into(),
        numbers => format!("<td>{}</td>", steps(numbers)),
    }
}

/// Formats the relevant properties of an article, one per line.
fn figures(order: &Purchase) -> String {
    let line = |figure: &crate::ArticleProperty| match &*figure.name {
        // This figure is a sentence and needs no name.
        "what matters" => escape(&figure.value),
        name => format!("{}: {}", escape(name), escape(&figure.value)),
    };
    let lines: Vec<String> = order.figures.iter().map(line).collect();
    match &lines[..] {
        [] => "<span class=\"known\">any</span>".to_owned(),
        lines => format!("<span class=\"known\">{}</span>", lines.join("<br>")),
    }
}

/// Formats four cells: text to order by, substitutes, packs, and cost. The source of the price is added where it is not
/// the usual one.
fn ordered(order: &Purchase, usual: &str) -> [String; 4] {
    let priced = match &*order.price_source {
        other if other != usual && order.cost_eur != Some(0.0) => format!("; price: {other}"),
        _ => String::new(),
    };
    let by = format!(
        "{}<span class=\"known\">source: {}</span>",
        escape(&order.order_text()),
        escape(&format!("{}{priced}", order.source))
    );
    let packs = match (order.packs, &order.kit) {
        (0, Some(kit)) => format!("with {kit}"),
        (0, None) => order.pack.clone(),
        (packs, Some(kit)) => format!("{packs} × {kit}"),
        (packs, None) => format!("{packs} × {}", order.pack),
    };
    let cost = match order.cost_eur {
        None => "not known".to_owned(),
        Some(cost) if cost.fract() == 0.0 => format!("{cost:.0}"),
        Some(cost) => format!("{cost:.2}"),
    };
    [cell(&by), word(&order.substitutes), word(&packs), format!("<td>{cost}</td>")]
}

/// Joins names; three or more consecutive numbers are abbreviated as a range, since a hundred names would fill a page.
fn in_series(names: &[String]) -> String {
    let counted = |name: &str| {
        let digits = name.chars().rev().take_while(char::is_ascii_digit).count();
        let (stem, number) = name.split_at(name.len() - digits);
        Some((stem.to_owned(), digits, number.parse::<u64>().ok()?))
    };
    let follows = |a: &str, b: &str| match (counted(a), counted(b)) {
        (Some((stem, digits, number)), Some((other, also, next))) => {
            stem == other
                && number.checked_add(1) == Some(next)
                // Counting from 9 to 10 adds a digit.
                && (digits == also || next % 10 == 0)
        }
        _ => false,
    };
    let mut said: Vec<String> = Vec::new();
    let mut rest = names;
    while let [first, ..] = rest {
        let more = rest.windows(2).take_while(|pair| follows(&pair[0], &pair[1])).count();
        match more {
            0 | 1 => said.extend(rest[..=more].iter().cloned()),
            _ => said.push(format!("{first} to {}", rest[more])),
        }
        rest = &rest[more + 1..];
    }
    said.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consecutive_names_become_a_range() {
        let said =
            |names: &[&str]| in_series(&names.iter().map(ToString::to_string).collect::<Vec<_>>());
        assert_eq!(
            said(&["lid", "half-008", "half-009", "half-010", "pin"]),
            "lid, half-008 to half-010, pin"
        );
        assert_eq!(said(&["pin-8", "pin-9", "pin-10"]), "pin-8 to pin-10");
        assert_eq!(said(&["pin-1", "pin-2", "pin-4"]), "pin-1, pin-2, pin-4");
        assert_eq!(said(&["base", "a-1", "b-2", "7"]), "base, a-1, b-2, 7");
        assert_eq!(said(&[]), "");
    }
}
