//! Tables of the guide for spreadsheets (RFC 4180).

use fabkit_geometry::csv::{CsvCell, CsvTable};

use crate::{BodyUse, Guide, PrintPlan, Purchase, SupplyKind};

/// Column heads of the table of purchases.
pub const BOM_HEADS: &str = "kind,name,quantity,unit,of,what,article,size,maker,number,standard,pack,kit,packs,\
                             price_eur,cost_eur,substitutes,source,price_source,steps";

fn word(of: BodyUse) -> &'static str {
    match of {
        BodyUse::Sensor => "sensor",
        BodyUse::Tool => "tool",
    }
}

/// Returns the cells from the layer height to the source of time and mass.
fn print_cells(print: &PrintPlan) -> Vec<CsvCell> {
    vec![
        print.layer_mm.into(),
        print.perimeters.into(),
        print.infill_percent.into(),
        CsvCell::text(if print.supports { "yes" } else { "no" }),
        print.brim_mm.into(),
        CsvCell::fixed(print.minutes, 0),
        print.mass_g.map(|mass_g| CsvCell::fixed(mass_g, 2)).into(),
        CsvCell::text(&print.from),
    ]
}

fn numbers(steps: &[usize]) -> CsvCell {
    let steps: Vec<String> = steps.iter().map(usize::to_string).collect();
    CsvCell::text(&steps.join(" "))
}

/// Returns the relevant properties of an article.
fn what(order: &Purchase) -> CsvCell {
    let figures = order.figures.iter().map(|figure| match &*figure.name {
        // This figure is a sentence and needs no name.
        "what matters" => figure.value.clone(),
        name => format!("{name}: {}", figure.value),
    });
    match figures.collect::<Vec<_>>().join("; ") {
        nothing if nothing.is_empty() => CsvCell::text("any"),
        figures => CsvCell::text(&figures),
    }
}

/// Returns the cells from `article` to `price_source`.
fn ordered(order: &Purchase) -> Vec<CsvCell> {
    let money = |eur: Option<f64>| {
        eur.map_or_else(|| CsvCell::text("not known"), |eur| CsvCell::fixed(eur, 2))
    };
    let texts = [&order.article, &order.size, &order.maker, &order.number, &order.standard];
    let mut cells: Vec<CsvCell> = texts.into_iter().map(CsvCell::from).collect();
    cells.extend([
        CsvCell::text(&order.pack),
        CsvCell::text(order.kit.as_deref().unwrap_or("none")),
        order.packs.into(),
        money(order.price_eur),
        money(order.cost_eur),
    ]);
    let texts = [&order.substitutes, &order.source, &order.price_source];
    cells.extend(texts.into_iter().map(CsvCell::from));
    cells
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
        let mut table = CsvTable::new(BOM_HEADS);
        let mut add = |kind: &str, name: &str, amount: [CsvCell; 4], order, steps| {
            let [quantity, unit, of, what] = amount;
            let first = [CsvCell::text(kind), CsvCell::text(name), quantity, unit, of, what];
            table.row(first.into_iter().chain(ordered(order)).chain([steps]));
        };
        for piece in &self.bought {
            let of = CsvCell::text(word(piece.of));
            let amount = [piece.quantity.into(), "pieces".into(), of, (&piece.what).into()];
            add("component", &piece.name, amount, &piece.order, numbers(&piece.steps));
        }
        for liquid in &self.liquids {
            let mass = CsvCell::fixed(liquid.mass_g, 2);
            let amount = [mass, "g".into(), CsvCell::empty(), what(&liquid.order)];
            add("liquid", &liquid.name, amount, &liquid.order, numbers(&liquid.steps));
        }
        for stock in &self.stock {
            let amount = CsvCell::fixed(stock.amount, 2);
            let amount = [amount, stock.unit.into(), CsvCell::empty(), what(&stock.order)];
            add("stock", &stock.name, amount, &stock.order, CsvCell::empty());
        }
        for supply in &self.supplies {
            let kind = if supply.used == SupplyKind::Tool { "tool" } else { "supply" };
            let amount = [1_u32.into(), "packs".into(), CsvCell::empty(), what(&supply.order)];
            add(kind, &supply.name, amount, &supply.order, numbers(&supply.steps));
        }
        table.finish()
    }

    /// Returns the table of parts, with the heads `name,quantity,of,process,material,x_mm,y_mm,z_mm,volume_mm3,mass_g,
    /// layer_mm,perimeters,infill_percent,supports,brim_mm,print_minutes,print_mass_g,print_from,what,notes,steps`.
    pub fn parts_csv(&self) -> String {
        let mut table = CsvTable::new(
            "name,quantity,of,process,material,x_mm,y_mm,z_mm,volume_mm3,mass_g,layer_mm,\
             perimeters,infill_percent,supports,brim_mm,print_minutes,print_mass_g,print_from,what,notes,steps",
        );
        for part in &self.made {
            let mut cells = vec![
                CsvCell::text(&part.name),
                part.quantity.into(),
                CsvCell::text(word(part.of)),
                CsvCell::text(&part.process),
                CsvCell::text(&part.material),
            ];
            cells.extend(part.size_mm.map(|mm| CsvCell::fixed(mm, 2)));
            cells.push(CsvCell::fixed(part.volume_mm3, 1));
            cells.push(part.mass_g.map(|mass_g| CsvCell::fixed(mass_g, 2)).into());
            // Empty cells for a part without print settings.
            let print = part.print.as_ref().map(print_cells);
            cells.extend(print.unwrap_or_else(|| vec![CsvCell::empty(); 8]));
            cells.push(CsvCell::text(&part.summary));
            cells.push(CsvCell::text(&part.notes.join("; ")));
            cells.push(numbers(&part.steps));
            table.row(cells);
        }
        table.finish()
    }
}
