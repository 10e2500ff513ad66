//! How parts of filament are printed.

use super::{name, table, word};
use crate::{Guide, Made, Printing};

impl Guide {
    /// One row for each part of filament; nothing where there is none.
    pub(super) fn prints(&self, body: &mut String) {
        let printed: Vec<(&Made, &Printing)> =
            self.made.iter().filter_map(|part| Some((part, part.print.as_ref()?))).collect();
        if printed.is_empty() {
            return;
        }
        *body += "<h2 id=\"print\">How to print</h2>\n";
        let row = |(part, print): &(&Made, &Printing)| {
            let [layers, _, _, _, supports, brim] = &print.reasons;
            let brim_mm = match print.brim_mm {
                0.0 => "none".to_owned(),
                mm => format!("{mm} mm: {brim}"),
            };
            let support = if print.supports { "yes" } else { "no" };
            let mass = print.mass_g.map_or("not known".to_owned(), |g| format!("{g:.1} g"));
            format!(
                "{}{}{}{}{}<td>{}</td><td>{}</td><td>{} %</td><td>{}</td><td>{mass}</td><td>{}</td>",
                name(&part.name),
                word(&part.material),
                word(&format!("{} mm: {layers}", print.layer_mm)),
                word(&format!("{support}: {supports}")),
                word(&brim_mm),
                part.quantity,
                print.perimeters,
                print.infill_percent,
                duration(print.minutes),
                print.from,
            )
        };
        let heads = [
            "part",
            "material",
            "layers",
            "supports",
            "brim",
            "n",
            "perimeters",
            "infill",
            "time",
            "filament",
            "from",
        ];
        *body += &table(&heads, 5, printed.iter().map(row));
        let sum = |of: &dyn Fn(&Printing) -> f64| -> f64 {
            printed.iter().map(|(part, print)| f64::from(part.quantity) * of(print)).sum()
        };
        *body += &format!(
            "<p>Time and filament are of one piece, with its infill, without supports where they are from fabkit's \
             model: printers that move fast take a third of the time. Together {} and {:.0} cm³ of filament. \
             The 3MF files carry these settings; parts lie on the bed as they are to be printed.</p>\n",
            duration(sum(&|print| print.minutes)),
            sum(&|print| print.filament_mm3) / 1000.0,
        );
    }
}

/// `1 h 05 min`.
fn duration(minutes: f64) -> String {
    let minutes = minutes.round().max(1.0) as u64;
    match (minutes / 60, minutes % 60) {
        (0, minutes) => format!("{minutes} min"),
        (hours, minutes) => format!("{hours} h {minutes:02} min"),
    }
}
