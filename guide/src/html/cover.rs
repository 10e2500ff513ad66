//! What it is, and what it takes.

use std::fmt::Write;

use fabkit_report::escape;

use super::{Pictures, image};
use crate::Guide;

/// Letters of the design's hash that tell it from others at a glance.
const HASH_SHOWN: usize = 12;

impl Guide {
    /// The cover, with jumps to those parts of the page that there are.
    pub(super) fn cover(&self, page: &str, pictures: &Pictures) -> String {
        let mut body = "<nav aria-label=\"contents\">".to_owned();
        for jump in ["Buy", "Make", "Wire", "Mix", "Time", "Steps"] {
            let id = jump.to_lowercase();
            if page.contains(&format!("id=\"{id}\"")) {
                let _ = write!(body, "<a href=\"#{id}\">{jump}</a>");
            }
        }
        body += "</nav>\n<div class=\"cover\">\n";
        if let Some(png) = &pictures.cover {
            body += &image(png, &format!("{} as it is drawn", self.title));
        }
        let rows = [
            (
                "Design",
                format!(
                    "{} ({})",
                    self.name,
                    &self.design_hash[..HASH_SHOWN.min(self.design_hash.len())]
                ),
            ),
            ("After", self.reference.clone()),
            ("For", format!("{} {}", self.units, if self.units == 1 { "unit" } else { "units" })),
            ("Parts to make", self.made.iter().map(|part| part.quantity).sum::<u32>().to_string()),
            (
                "Pieces to buy",
                self.bought.iter().map(|piece| piece.quantity).sum::<u32>().to_string(),
            ),
            ("Steps", self.steps.len().to_string()),
            (
                "From parts to a cured unit",
                format!("{:.0} h: {} days", self.timeline.total_h, self.timeline.days),
            ),
        ];
        body += "<dl>";
        for (term, text) in rows.iter().filter(|(_, text)| !text.is_empty()) {
            let _ = write!(body, "<dt>{term}</dt><dd>{}</dd>", escape(text));
        }
        body + "</dl>\n</div>\n"
    }
}
