//! Tables of the guide for spreadsheets (RFC 4180).

use crate::{BodyUse, Guide, PrintPlan, Purchase, SupplyKind};

/// Column heads of the table of purchases.
pub const BOM_HEADS: &str = "kind,name,quantity,unit,of,what,article,size,maker,number,standard,pack,kit,packs,\
                             price_eur,cost_eur,substitutes,source,price_source,steps";

/// Quotes a cell where its text requires it.
fn quoted(text: &str) -> String {
    if text.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

fn word(of: BodyUse) -> &'static str {
    match of {
        BodyUse::Sensor => "sensor",
        BodyUse::Tool => "tool",
    }
}

/// Formats the cells from the layer height to the source of time and mass.
fn print_cells(print: &PrintPlan) -> String {
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

/// Formats the relevant properties of an article.
fn what(order: &Purchase) -> String {
    let figures = order.figures.iter().map(|figure| match &*figure.name {
        // This figure is a sentence and needs no name.
        "what matters" => figure.value.clone(),
        name => format!("{name}: {}", figure.value),
    });
    match figures.collect::<Vec<_>>().join("; ") {
        nothing if nothing.is_empty() => "any".into(),
        figures => quoted(&figures),
    }
}

/// Formats the cells from `article` to `price_source`.
fn ordered(order: &Purchase) -> String {
    let money = |eur: Option<f64>| eur.map_or("not known".into(), |eur| format!("{eur:.2}"));
    let packs = order.packs.to_string();
    let (price, cost) = (money(order.price_eur), money(order.cost_eur));
    let kit = order.kit.as_deref().unwrap_or("none");
    let texts = [&order.article, &order.size, &order.maker, &order.number, &order.standard];
    let texts = texts.map(String::as_str).into_iter().chain([&*order.pack, kit, &packs, &price]);
    let texts = texts.chain([&*cost, &order.substitutes, &order.source, &order.price_source]);
    texts.map(quoted).collect::<Vec<_>>().join(",")
}

impl Guide {
    /// Returns the table of purchases, with the heads `kind`, `name`, `quantity`, `unit`, `of`, `what`, those of
    /// orders, and `steps`.
    ///
    /// ```
    /// # use fabkit_guide::{Guide, NoShop, Request};
    /// # let sensor = fabkit_checks::example::puck();
    /// # let stages = fabkit_checks::stages(&sensor)?;
    /// # let (density, shop, calibration) = (&|_: &str| None, &NoShop, None);
    /// # let request = Request { design_hash: "00", units: 1, density, shop, stages: &stages, calibration };
    /// let csv = Guide::new(&sensor, &request)?.bom_csv();
    /// // Half of 0.63 g and a tenth more.
    /// assert!(csv.lines().any(|line| line.starts_with("liquid,A,0.35,g,")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn bom_csv(&self) -> String {
        let mut csv = format!("{BOM_HEADS}\n");
        for piece in &self.bought {
            let (name, what) = (quoted(&piece.name), quoted(&piece.what));
            let (of, steps) = (word(piece.of), numbers(&piece.steps));
            let quantity = piece.quantity;
            let order = ordered(&piece.order);
            csv += &format!("component,{name},{quantity},pieces,{of},{what},{order},{steps}\n");
        }
        for liquid in &self.liquids {
            let (name, steps) = (quoted(&liquid.name), numbers(&liquid.steps));
            let (what, order) = (what(&liquid.order), ordered(&liquid.order));
            csv += &format!("liquid,{name},{:.2},g,,{what},{order},{steps}\n", liquid.mass_g);
        }
        for stock in &self.stock {
            let (name, what) = (quoted(&stock.name), what(&stock.order));
            let (amount, unit, order) = (stock.amount, stock.unit, ordered(&stock.order));
            csv += &format!("stock,{name},{amount:.2},{unit},,{what},{order},\n");
        }
        for supply in &self.supplies {
            let kind = if supply.used == SupplyKind::Tool { "tool" } else { "supply" };
            let (name, what) = (quoted(&supply.name), what(&supply.order));
            let (order, steps) = (ordered(&supply.order), numbers(&supply.steps));
            csv += &format!("{kind},{name},1,packs,,{what},{order},{steps}\n");
        }
        csv
    }

    /// Returns the table of parts, with the heads `name,quantity,of,process,material,x_mm,y_mm,z_mm,volume_mm3,mass_g,
    /// layer_mm,perimeters,infill_percent,supports,brim_mm,print_minutes,print_mass_g,print_from,what,notes,steps`.
    pub fn parts_csv(&self) -> String {
        let mut csv = String::from(
            "name,quantity,of,process,material,x_mm,y_mm,z_mm,volume_mm3,mass_g,layer_mm,\
             perimeters,infill_percent,supports,brim_mm,print_minutes,print_mass_g,print_from,what,notes,steps\n",
        );
        for part in &self.made {
            let [x, y, z] = part.size_mm;
            let mass = part.mass_g.map_or(String::new(), |mass_g| format!("{mass_g:.2}"));
            // Empty cells for a part without print settings.
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
