//! Page of a difference between two designs.

use std::collections::BTreeMap;
use std::fmt::Write;

use fabkit_report::{escape, page_with_style};

use super::{STYLE, image, name, table, word};
use crate::{BodyChange, ChangeKind, DesignDifference};

/// Images of parts in both designs, PNG, by name.
#[derive(Clone, Debug, Default)]
pub struct PartImagePairs {
    /// Parts of the existing design.
    pub from: BTreeMap<String, Vec<u8>>,
    /// Parts of the wanted design.
    pub to: BTreeMap<String, Vec<u8>>,
}

impl DesignDifference {
    /// Returns the page.
    pub fn to_html(&self, images: &PartImagePairs) -> String {
        let mut body = format!(
            "<dl><dt>There is</dt><dd>{}</dd><dt>Wanted</dt><dd>{}</dd></dl>\n",
            [&self.from.title, &self.from.name, &self.from.design_hash]
                .map(|t| escape(t))
                .join(", "),
            [&self.to.title, &self.to.name, &self.to.design_hash].map(|t| escape(t)).join(", "),
        );
        self.besides(&mut body);
        self.imaged(&mut body, images);
        let same: Vec<&BodyChange> = self.with_change(ChangeKind::Same).collect();
        body += "<h2>Reusable</h2>\n";
        body += &list(&same, "Nothing.");
        let gone: Vec<&BodyChange> = self.with_change(ChangeKind::Removed).collect();
        if !gone.is_empty() {
            body += "<h2>No longer needed</h2>\n";
            body += &list(&gone, "");
        }
        body += "<h2>Parameters that differ</h2>\n";
        if self.parameters.is_empty() {
            body += "<p>None.</p>\n";
        } else {
            let cell = |value: &Option<String>| word(value.as_deref().unwrap_or("-"));
            let rows = self.parameters.iter();
            let rows = rows.map(|p| name(&p.path) + &cell(&p.from) + &cell(&p.to));
            body += &table(&["parameter", "is", "wanted"], 3, rows);
        }
        if !self.steps.is_empty() {
            body += "<h2>Steps that differ</h2>\n";
            let rows = self.steps.iter().map(|s| name(&s.name) + &word(s.change.word()));
            body += &table(&["step", "change"], 2, rows);
        }
        let title = format!("From {} to {}", self.from.name, self.to.name);
        page_with_style(&title, STYLE, &body)
    }

    /// Appends the table of the bodies to make, cast and buy.
    fn besides(&self, body: &mut String) {
        *body += "<h2>To make, cast and buy in addition</h2>\n";
        let rows: Vec<String> = self
            .bodies
            .iter()
            .filter(|one| one.besides > 0)
            .map(|one| {
                format!(
                    "{}{}<td>{}</td>{}",
                    name(&one.name),
                    word(one.kind),
                    one.besides,
                    word(&why(one))
                )
            })
            .collect();
        if rows.is_empty() {
            *body += "<p>Nothing.</p>\n";
        } else {
            *body += &table(&["what", "kind", "n", "why"], 2, rows.into_iter());
        }
    }

    /// Appends the images of parts whose shape differs.
    fn imaged(&self, body: &mut String, images: &PartImagePairs) {
        let changed = self.bodies.iter().filter(|one| one.differs.contains(&"shape"));
        let mut shown = String::new();
        for one in changed {
            let (Some(from), Some(to)) = (images.from.get(&one.name), images.to.get(&one.name))
            else {
                continue;
            };
            let figure = |png: &[u8], words: &str| {
                let alt = format!("{} as it {words}", one.name);
                format!("<figure>{}<figcaption>{words}</figcaption></figure>", image(png, &alt))
            };
            let _ = writeln!(
                shown,
                "<section class=\"step\"><h3>{}</h3><div class=\"shots\">{}{}</div></section>",
                escape(&one.name),
                figure(from, "is"),
                figure(to, "is wanted")
            );
        }
        if !shown.is_empty() {
            *body += "<h2>Parts of another shape</h2>\n";
            *body += &shown;
        }
    }
}

/// Returns the reason why a body has to be made or bought.
fn why(one: &BodyChange) -> String {
    match one.change {
        ChangeKind::Added => "new".to_owned(),
        ChangeKind::Changed => format!("another {}", one.differs.join(", ")),
        // An unchanged body appears in this table only if more pieces are needed.
        ChangeKind::Same | ChangeKind::Removed => {
            format!("{} instead of {}", one.quantity[1], one.quantity[0])
        }
    }
}

/// Formats a table of bodies, or the text `nothing` if there are none.
fn list(bodies: &[&BodyChange], nothing: &str) -> String {
    if bodies.is_empty() {
        return format!("<p>{nothing}</p>\n");
    }
    let rows = bodies.iter().map(|one| {
        let was = one.was.as_ref().map_or(String::new(), |was| format!("was {was}"));
        format!(
            "{}{}<td>{}</td>{}",
            name(&one.name),
            word(one.kind),
            one.quantity[0].max(one.quantity[1]),
            word(&was)
        )
    });
    table(&["what", "kind", "n", ""], 2, rows)
}
