//! What to buy.

use super::{name, of, steps, table, word};
use crate::Guide;

impl Guide {
    pub(super) fn purchases(&self, body: &mut String) {
        *body += "<h2 id=\"buy\">What to buy</h2>\n";
        if self.bought.is_empty() && self.liquids.is_empty() {
            *body += "<p>Nothing: all of it is printed.</p>\n";
            return;
        }
        if !self.bought.is_empty() {
            let rows = self.bought.iter().map(|piece| {
                let cells = [name(&piece.name), word(&piece.what), of(piece.of).to_owned()];
                format!(
                    "{}<td>{}</td><td>{}</td>",
                    cells.concat(),
                    piece.quantity,
                    steps(&piece.steps)
                )
            });
            *body += &table(&["piece", "what to order", "for", "n", "steps"], 3, rows);
        }
        if !self.liquids.is_empty() {
            *body += "<p>What is mixed, with the waste of cups and vents; packs are larger.</p>\n";
            let rows = self.liquids.iter().map(|liquid| {
                format!(
                    "{}<td>{:.2} g</td><td>{}</td>",
                    name(&liquid.name),
                    liquid.mass_g,
                    steps(&liquid.steps)
                )
            });
            *body += &table(&["component", "mass", "steps"], 1, rows);
        }
    }
}
