//! The guide's tables for spreadsheets (RFC 4180).

use crate::{Guide, Printing, Tool};

fn quoted(text: &str) -> String {
    match text.contains(['"', ',', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

fn word(of: Tool) -> &'static str {
    match of {
        Tool::Sensor => "sensor",
        Tool::Tool => "tool",
    }
}

/// From the layers' height to where time and mass are from.
fn print_cells(print: &Printing) -> String {
    let supports = if print.supports { "yes" } else { "no" };
    let mass = print.mass_g.map_or(String::new(), |mass_g| format!("{mass_g:.2}"));
    format!(
        "{},{},{},{supports},{},{:.0},{mass},{}",
        print.layer_mm,
        print.perimeters,
        print.infill_percent,
        print.brim_mm,
        print.minutes,
        quoted(&print.from)
    )
}

fn numbers(steps: &[usize]) -> String {
    steps.iter().map(usize::to_string).collect::<Vec<_>>().join(" ")
}

impl Guide {
    /// What to buy: `kind,name,quantity,unit,of,what,steps`.
    pub fn bom_csv(&self) -> String {
        let mut csv = String::from("kind,name,quantity,unit,of,what,steps\n");
        for piece in &self.bought {
            let (name, what) = (quoted(&piece.name), quoted(&piece.what));
            let (of, steps) = (word(piece.of), numbers(&piece.steps));
            csv += &format!("component,{name},{},pieces,{of},{what},{steps}\n", piece.quantity);
        }
        for liquid in &self.liquids {
            let (name, steps) = (quoted(&liquid.name), numbers(&liquid.steps));
            csv += &format!("liquid,{name},{:.2},g,,,{steps}\n", liquid.mass_g);
        }
        csv
    }

    /// What to make: `name,quantity,of,process,material,x_mm,y_mm,z_mm,volume_mm3,mass_g,
    /// layer_mm,perimeters,infill_percent,supports,brim_mm,print_minutes,print_mass_g,print_from,what,notes,steps`.
    pub fn parts_csv(&self) -> String {
        let mut csv = String::from(
            "name,quantity,of,process,material,x_mm,y_mm,z_mm,volume_mm3,mass_g,layer_mm,\
             perimeters,infill_percent,supports,brim_mm,print_minutes,print_mass_g,print_from,what,notes,steps\n",
        );
        for part in &self.made {
            let [x, y, z] = part.size_mm;
            let mass = part.mass_g.map_or(String::new(), |mass_g| format!("{mass_g:.2}"));
            let print = part.print.as_ref().map_or(",".repeat(7), print_cells);
            let texts =
                [&part.name, &part.process, &part.material, &part.summary].map(|t| quoted(t));
            let [name, process, material, what] = texts;
            csv += &format!(
                "{name},{},{},{process},{material},{x:.2},{y:.2},{z:.2},{:.1},{mass},{print},{what},{},{}\n",
                part.quantity,
                word(part.of),
                part.volume_mm3,
                quoted(&part.notes.join("; ")),
                numbers(&part.steps),
            );
        }
        csv
    }
}
