//! Cover: overview of the design and of the effort to build it.

use std::fmt::Write;

use fabkit_report::escape;

use super::{PageImages, image};
use crate::{Guide, OverallSize};

/// Number of characters of the design's hash that are shown.
const HASH_SHOWN: usize = 12;

impl Guide {
    /// Returns the cover, with links to the sections that the page has.
    pub(super) fn cover(&self, page: &str, images: &PageImages) -> String {
        let mut body = "<nav aria-label=\"contents\">".to_owned();
        for jump in ["Buy", "Make", "Print", "Wire", "Mix", "Mind", "Time", "Steps", "Calibrate"] {
            let id = jump.to_lowercase();
            // Sections without content are left out of the page.
            if page.contains(&format!("id=\"{id}\"")) {
                let _ = write!(body, "<a href=\"#{id}\">{jump}</a>");
            }
        }
        body += "</nav>\n";
        self.failed_checks(&mut body);
        body += "<div class=\"cover\">\n";
        if let Some(png) = &images.cover {
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
            ("Size", self.outer.as_ref().map_or(String::new(), size)),
            ("Mass", self.outer.as_ref().map_or(String::new(), mass)),
            ("Parts to make", self.made.iter().map(|part| part.quantity).sum::<u32>().to_string()),
            (
                "Pieces to buy",
                self.bought.iter().map(|piece| piece.quantity).sum::<u32>().to_string(),
            ),
            ("Costs", self.costs.to_sentence()),
            ("Steps", self.steps.len().to_string()),
            ("From parts to a cured unit", self.working_time()),
            ("Hands", self.hands()),
        ];
        body += "<dl>";
        for (term, text) in rows.iter().filter(|(_, text)| !text.is_empty()) {
            let _ = write!(body, "<dt>{term}</dt><dd>{}</dd>", escape(text));
        }
        body += "</dl>\n</div>\n";
        body + "<p class=\"sources\">Sizes, volumes and counts are those of the drawn bodies. Densities, pot lives and cures are \
                those of makers' data sheets, mixing ratios of the design or its paper; hands-on times are chosen. Each step names \
                its source, and <code>fabkit show</code> the source of every parameter.</p>\n"
    }

    /// Says before everything else that the design does not pass `check`, with the errors.
    fn failed_checks(&self, body: &mut String) {
        /// Number of errors that are shown; `fabkit check` lists all.
        const MOST: usize = 20;
        if self.check_errors.is_empty() {
            return;
        }
        *body += "<section class=\"failed\"><h2>Not to be built as it is</h2>\n<p>This design does not pass \
                  <code>fabkit check</code>:</p>\n<ul>";
        for message in self.check_errors.iter().take(MOST) {
            let _ = write!(body, "<li>{}</li>", escape(message));
        }
        *body += "</ul>\n";
        if let Some(more @ 1..) = self.check_errors.len().checked_sub(MOST) {
            let _ = writeln!(body, "<p>and {more} more</p>");
        }
        *body += "</section>\n";
    }

    /// Formats the duration of the build; empty without steps.
    fn working_time(&self) -> String {
        let timeline = &self.timeline;
        if timeline.total_h == 0.0 {
            return String::new();
        }
        let one = format!("{:.0} h: {}", timeline.total_h, days(timeline.total_h));
        match self.units {
            1 => one,
            units => {
                let all_h = timeline.units.total_h;
                format!("{one}; for {units} units {all_h:.0} h: {}", days(all_h))
            }
        }
    }

    /// Formats the hands-on time; empty without steps.
    fn hands(&self) -> String {
        match (self.timeline.hands_h, self.units) {
            (0.0, _) => String::new(),
            (hours, 1) => format!("about {hours} h of it"),
            (hours, units) => {
                format!("about {hours} h; for {units} units {} h", self.timeline.units.hands_h)
            }
        }
    }
}

fn days(hours: f64) -> String {
    match (hours / 24.0).ceil() {
        1.0 => "1 day".to_owned(),
        days => format!("{days} days"),
    }
}

fn size(outer: &OverallSize) -> String {
    let [x, y, z] = outer.size_mm;
    format!("{x:.1} × {y:.1} × {z:.1} mm (x, y, z of the assembly `{}`)", outer.assembly)
}

fn mass(outer: &OverallSize) -> String {
    let known = format!("{:.1} g of solid parts and layers", outer.mass_g);
    match outer.unweighed.len() {
        0 => known,
        _ => format!("{known}, without {}", outer.unweighed.join(", ")),
    }
}
