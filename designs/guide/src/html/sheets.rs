//! Section on the sheets to cut.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fabkit_geometry::format_rounded;
use fabkit_report::escape;

use super::{PageImages, name, table, word};
use crate::{Guide, SheetPlan};

const MM_PER_M: f64 = 1e3;

impl Guide {
    /// Appends a row for each stock and a drawing of each sheet; nothing if no sheet is cut.
    pub(super) fn sheets_to_cut(&self, images: &PageImages, body: &mut String) {
        if self.sheets.is_empty() {
            return;
        }
        *body += "<h2 id=\"sheets\">How to cut</h2>\n";
        let row = |plan: &SheetPlan| {
            let pieces = plan.pieces.iter().map(|piece| match piece.count {
                1 => piece.name.clone(),
                count => format!("{count} × {}", piece.name),
            });
            let [width, height] = plan.stock_mm.map(format_rounded);
            format!(
                "{}{}<td>{}</td><td class=\"as-one\">{width} × {height} × {} mm</td><td class=\"as-one\">{:.2} m</td>\
                 <td>{:.0} %</td>{}",
                name(&plan.name),
                word(&plan.material),
                plan.sheets,
                format_rounded(plan.thickness_mm),
                plan.cut_mm / MM_PER_M,
                100.0 * plan.used,
                word(&pieces.collect::<Vec<_>>().join(", ")),
            )
        };
        let heads = ["sheet", "material", "n", "size", "cuts", "used", "pieces"];
        *body += &table(&heads, 2, self.sheets.iter().map(row));
        *body += &format!(
            "<p>For {}. Outlines are already wider by half of the kerf; the DXF and SVG files of these names hold \
             them. Grain and protective film stay on until everything is cut.</p>\n",
            if self.units == 1 { "one unit".to_owned() } else { format!("{} units", self.units) }
        );
        let needs = self.sheets.iter().flat_map(|plan| {
            (1..).zip(&plan.needs_mm).map(|(i, needs)| (format!("{}-{i}", plan.name), needs))
        });
        for (title, [width, height]) in needs {
            let Some(svg) = images.sheets.get(&title) else { continue };
            let [width, height] = [width, height].map(|mm| format_rounded(*mm));
            *body += &format!(
                "<figure class=\"sheet\"><img alt=\"Outlines on {0}\" src=\"data:image/svg+xml;base64,{1}\">\
                 <figcaption>{0}: a piece of {width} × {height} mm is enough.</figcaption></figure>\n",
                escape(&title),
                STANDARD.encode(svg)
            );
        }
    }
}
