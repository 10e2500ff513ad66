//! Sections on mixes and warnings.

use std::fmt::Write;

use fabkit_report::escape;

use super::{steps, table};
use crate::{Guide, StepMix, Warning};

impl Guide {
    /// Appends the table of mixes and the warnings.
    pub(super) fn mixtures(&self, body: &mut String) {
        if !self.mixes.is_empty() {
            *body += "<h2 id=\"mix\">What to mix</h2>\n";
            let heads = [
                "step",
                "becomes",
                "one batch",
                "batches",
                "volume + waste",
                "air",
                "pot life",
                "in hand",
                "cure",
            ];
            *body += &table(&heads, 3, self.mixes.iter().map(row));
            *body += "<p>Weigh to 0.01 g, in the order of the table; stir slowly for as long as the maker says, and scrape the \
                      cup's wall. A batch is mixed anew for each unit. Pot lives and cures are at 23 °C unless a row says \
                      otherwise; below 18 °C both take longer. Times for air to leave are chosen, and at most a third of the \
                      pot life: degas until foam has risen and fallen, in a cup four times as high as the liquid.</p>\n";
        }
        self.mind(body);
    }

    /// Appends the warnings, unsolved ones first.
    fn mind(&self, body: &mut String) {
        if self.warnings.is_empty() {
            return;
        }
        *body += "<h2 id=\"mind\">What to mind</h2>\n";
        let (done, open): (Vec<&Warning>, Vec<&Warning>) =
            self.warnings.iter().partition(|warning| warning.dealt_with_in.is_some());
        for (class, title, list) in [
            ("warnings", "Left to you", open),
            ("dealt-with", "Handled by the steps; do not leave these out", done),
        ] {
            if list.is_empty() {
                continue;
            }
            let _ = write!(body, "<h3>{title}</h3>\n<ul class=\"{class}\">\n");
            list.into_iter().for_each(|warning| write_warning(body, warning));
            *body += "</ul>\n";
        }
    }
}

/// Formats the row of a mix.
fn row(mix: &StepMix) -> String {
    let components = mix.components.iter();
    let weighed = components.map(|c| format!("{:.2} g {}", c.mass_g, escape(&c.name)));
    let air = match (mix.degas, mix.air_h) {
        // Sprays need no time for air to leave.
        (_, 0.0) => String::new(),
        (true, hours) => format!("degas {}", minutes(hours)),
        (false, hours) => format!("let stand {}", minutes(hours)),
    };
    let cure = match mix.cure_h {
        0.0 => "with what follows".to_owned(),
        hours => format!("{hours} h at {} °C", mix.cure_celsius),
    };
    let pot_life = mix.pot_life_h.map_or("not stated".to_owned(), minutes);
    format!(
        "<td><a href=\"#step-{0}\">{0}</a></td><td class=\"word\">{1}</td><td class=\"word as-one\">{2}</td><td>{3}</td>\
         <td>{4:.2} cm3 + {5:.0} %</td><td class=\"word\">{air}</td><td class=\"as-one\">{pot_life}</td>\
         <td class=\"as-one\">{6}</td><td>{cure}</td>",
        mix.step,
        escape(&mix.layer),
        weighed.collect::<Vec<_>>().join("<br>"),
        mix.batches,
        mix.volume_mm3 / 1e3,
        100.0 * mix.waste,
        minutes(mix.in_hand_h),
    )
}

/// Formats a duration: in minutes up to two hours, in hours above.
pub(super) fn minutes(hours: f64) -> String {
    if hours <= 2.0 { format!("{:.0} min", 60.0 * hours) } else { format!("{hours} h") }
}

/// Appends a warning as a list item.
fn write_warning(body: &mut String, warning: &Warning) {
    let _ = writeln!(
        body,
        "<li><strong>{}</strong>{}: {}. <em>{}.</em> <small>{}</small></li>",
        escape(title(warning.rule)),
        if warning.steps.is_empty() {
            String::new()
        } else {
            format!(
                " (step{} {})",
                if warning.steps.len() == 1 { "" } else { "s" },
                steps(&warning.steps)
            )
        },
        escape(&warning.why),
        escape(&warning.do_this),
        escape(&warning.source),
    );
}

/// Returns the title of a rule on the page.
pub(super) fn title(rule: &str) -> &str {
    match rule {
        "inhibition" => "Cure inhibition",
        "gloves" => "Gloves and cups",
        "release" => "Release agent",
        "primer" => "Primer",
        "loose" => "Does not hold",
        "heat" => "Heat",
        "pot-life" => "Pot life",
        "safety" => "Safety",
        other => other,
    }
}
