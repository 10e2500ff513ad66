//! Section on printing filament parts.

use fabkit_geometry::format_rounded;
use fabkit_report::escape;

use super::{name, table, word};
use crate::{Guide, MadePart, PrintPlan};

impl Guide {
    /// Appends a row for each filament part; nothing if there is none.
    pub(super) fn prints(&self, body: &mut String) {
        let printed: Vec<(&MadePart, &PrintPlan)> =
            self.made.iter().filter_map(|part| Some((part, part.print.as_ref()?))).collect();
        if printed.is_empty() {
            return;
        }
        *body += "<h2 id=\"print\">How to print</h2>\n";
        let row = |(part, print): &(&MadePart, &PrintPlan)| {
            let brim = match print.brim_mm {
                0.0 => "none".to_owned(),
                mm => format!("{} mm", format_rounded(mm)),
            };
            let supports = if print.supports { "yes" } else { "no" };
            let mass = print.mass_g.map_or("not known".to_owned(), |g| format!("{g:.1} g"));
            let time = duration(print.minutes);
            format!(
                "{}{}{}<td>{}</td><td>{} mm</td><td>{}</td><td>{} %</td><td>{supports}</td><td>{brim}</td>\
                 <td class=\"as-one\">{time}</td><td>{mass}</td>",
                name(&part.name),
                word(&part.material),
                word(&print.from),
                part.quantity,
                format_rounded(print.layer_mm),
                print.perimeters,
                print.infill_percent,
            )
        };
        let heads = [
            "part",
            "material",
            "time from",
            "n",
            "layers",
            "perimeters",
            "infill",
            "supports",
            "brim",
            "time",
            "filament",
        ];
        *body += &table(&heads, 3, printed.iter().map(row));
        *body += &because(&printed);
        let sum = |of: &dyn Fn(&PrintPlan) -> f64| -> f64 {
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

/// Formats the reasons for each setting, with the parts they apply to.
fn because(printed: &[(&MadePart, &PrintPlan)]) -> String {
    let names = ["layers", "perimeters", "solid layers", "infill", "supports", "brim"];
    let mut text = String::from("<dl>\n");
    for (i, setting) in names.into_iter().enumerate() {
        let mut whys: Vec<(&str, Vec<&str>)> = Vec::new();
        for (part, print) in printed {
            let why = print.reasons[i].as_str();
            match whys.iter_mut().find(|(known, _)| *known == why) {
                Some((_, parts)) => parts.push(&part.name),
                None => whys.push((why, vec![&part.name])),
            }
        }
        // A reason shared by all parts needs no list of them.
        let said = whys.iter().map(|(why, parts)| {
            if parts.len() == printed.len() {
                escape(why)
            } else {
                format!(
                    "{}: {}",
                    parts.iter().map(|p| escape(p)).collect::<Vec<_>>().join(", "),
                    escape(why)
                )
            }
        });
        let said: Vec<String> = said.collect();
        text += &format!("<dt>{setting}</dt><dd>{}</dd>\n", said.join("<br>"));
    }
    text + "</dl>\n"
}

/// Formats a duration such as `1 h 05 min`.
fn duration(minutes: f64) -> String {
    let minutes = minutes.round().max(1.0) as u64;
    match (minutes / 60, minutes % 60) {
        (0, minutes) => format!("{minutes} min"),
        (hours, minutes) => format!("{hours} h {minutes:02} min"),
    }
}
