//! Section on the parts to make.

use fabkit_report::escape;

use super::{PageImages, image, name, of, table, word};
use crate::{Guide, MadePart};

impl Guide {
    /// Appends the table of the parts to make.
    pub(super) fn parts(&self, body: &mut String, images: &PageImages) {
        *body += "<h2 id=\"make\">What to make</h2>\n";
        let row = |part: &MadePart| {
            let picture = images.parts.get(&part.name);
            let picture = picture.map_or(String::new(), |png| {
                image(png, &format!("{} as it lies on the bed", part.name))
            });
            let [x, y, z] = part.size_mm;
            let mass =
                part.mass_g.map_or("not known".to_owned(), |mass_g| format!("{mass_g:.1} g"));
            let notes = part.notes.iter().map(|note| escape(note)).collect::<Vec<_>>().join("<br>");
            format!(
                "{}<td class=\"word\">{picture}</td>{}{}<td>{}</td><td class=\"as-one\">{x:.1} × {y:.1} × {z:.1} mm</td><td>{mass}</td>\
                 <td class=\"word long\">{}{}{notes}</td>",
                name(&part.name),
                word(&format!("{}, {}", part.process, part.material)),
                of(part.of),
                part.quantity,
                escape(&part.summary),
                if notes.is_empty() { "" } else { "<br>" },
            )
        };
        let heads = [
            "part",
            "on the bed",
            "made",
            "for",
            "n",
            "size",
            "mass, solid",
            "description and notes",
        ];
        *body += &table(&heads, 4, self.made.iter().map(row));
        *body += "<p>Sizes as it lies on the bed. Masses are those of solid parts in fabkit's model; a slicer accounts for infill.</p>\n";
    }
}
