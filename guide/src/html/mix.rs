//! What to mix.

use fabkit_report::escape;

use super::table;
use crate::{Guide, Mixed};

impl Guide {
    pub(super) fn mixtures(&self, body: &mut String) {
        if self.mixes.is_empty() {
            return;
        }
        *body += "<h2 id=\"mix\">What to mix</h2>\n";
        let row = |mix: &Mixed| {
            let components = mix.components.iter();
            let weighed = components.map(|c| format!("{:.2} g {}", c.mass_g, escape(&c.name)));
            let degas = if mix.degas { "degas" } else { "" };
            let cure = match mix.cure_h {
                0.0 => "with what follows".to_owned(),
                hours => format!("{hours} h at {} °C", mix.cure_celsius),
            };
            format!(
                "<td><a href=\"#step-{0}\">{0}</a></td><td class=\"word\">{1}</td><td class=\"word as-one\">{2}</td><td>{3}</td>\
                 <td>{4:.2} cm3 + {5:.0} %</td><td class=\"word\">{degas}</td><td>{cure}</td>",
                mix.step,
                escape(&mix.layer),
                weighed.collect::<Vec<_>>().join("<br>"),
                mix.batches,
                mix.volume_mm3 / 1e3,
                100.0 * mix.waste,
            )
        };
        let heads = ["step", "becomes", "one batch", "batches", "volume + waste", "air", "cure"];
        *body += &table(&heads, 3, self.mixes.iter().map(row));
    }
}
