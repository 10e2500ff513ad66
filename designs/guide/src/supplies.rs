//! Stock that parts are made from, consumables, tools, and the total cost.

use std::collections::BTreeMap;

use fabkit_geometry::{BodyKind, QuantityUnit, Sensor};
use serde::Serialize;

use crate::shop::{Purchase, Shop, SupplyKind};
use crate::{BoughtPiece, LiquidComponent, MadePart, StepMix};

/// Fraction of a sheet that parts cover; chosen: gaps, edges and offcuts are the rest.
const SHEET_USED: f64 = 0.75;

/// Temperature above which a cure counts as warm, degrees Celsius.
const WARM_CELSIUS: f64 = 30.0;

const MM3_PER_CM3: f64 = 1e3;

/// Stock that parts are made from.
#[derive(Clone, Debug, Serialize)]
pub struct Stock {
    /// Material, and thickness for sheets.
    pub name: String,
    /// Process: `fdm`, `sla`, `polyjet`, `laser`, `pcb` or `cnc`.
    pub process: String,
    /// Names of the parts made from it.
    pub parts: Vec<String>,
    /// Amount in the parts, solid and without support, in `unit`.
    pub amount: f64,
    /// Unit of the amount: `g`, `ml`, `pieces` or `cm2`.
    pub unit: &'static str,
    /// Article and packs to order.
    pub order: Purchase,
}

/// Consumable or tool.
#[derive(Clone, Debug, Serialize)]
pub struct Supply {
    /// Name with size.
    pub name: String,
    /// Distinction between consumable and tool.
    pub used: SupplyKind,
    /// Numbers of the steps that need it; empty if the making of a part does.
    pub steps: Vec<usize>,
    /// Article and packs to order.
    pub order: Purchase,
}

/// Total cost of everything that is bought.
#[derive(Clone, Debug, Serialize)]
pub struct Costs {
    /// Sum for whole packs, EUR.
    pub total_eur: f64,
    /// Names of articles whose price is not known.
    pub unknown: Vec<String>,
    /// Costs that the sum leaves out.
    pub leaves_out: &'static str,
}

/// Costs that the sum leaves out.
const LEAVES_OUT: &str = "tools, shipping, and the hours of people and machines";

/// Parts made from the same stock.
#[derive(Default)]
struct StockGroup<'a> {
    parts: Vec<&'a MadePart>,
}

/// Groups parts by the stock they are made from.
pub(crate) fn stock(made: &[MadePart], shop: &dyn Shop) -> Vec<Stock> {
    // Boards and machined parts are ordered one by one; sheets are grouped by thickness, in tenths of a millimetre.
    let mut piles: BTreeMap<(String, String, String), StockGroup> = BTreeMap::new();
    for part in made {
        // The smallest dimension of a sheet part is its thickness.
        let tenths = (10.0 * part.size_mm.iter().copied().fold(f64::INFINITY, f64::min)).round();
        let more = match &*part.process {
            "laser" => format!("{} mm thick", tenths / 10.0),
            "pcb" | "cnc" => part.name.clone(),
            _ => String::new(),
        };
        let key = (part.process.clone(), part.material.clone(), more);
        piles.entry(key).or_default().parts.push(part);
    }
    piles.into_iter().map(|(key, pile)| stock_of_group(key, &pile, shop)).collect()
}

/// Returns the stock of a group of parts.
fn stock_of_group(
    (process, material, more): (String, String, String),
    StockGroup { parts }: &StockGroup,
    shop: &dyn Shop,
) -> Stock {
    let mut order = shop.stock(&process, &material);
    if process == "laser" {
        order.size = [&*order.size, &*more].join(", ");
    }
    let sum = |of: &dyn Fn(&MadePart) -> f64| -> f64 {
        parts.iter().map(|part| f64::from(part.quantity) * of(part)).sum()
    };
    let volume_ml = sum(&|part| part.volume_mm3 / MM3_PER_CM3);
    let (amount, unit, needed) = match (order.pack.unit, order.sheet_mm) {
        (QuantityUnit::Piece, Some([x, y])) => {
            let area_mm2 = sum(&|part| {
                let mut sizes = part.size_mm;
                sizes.sort_by(f64::total_cmp);
                // The two largest dimensions span the rectangle that the part takes from a sheet.
                sizes[1] * sizes[2]
            });
            (area_mm2 / 100.0, "cm2", area_mm2 / (SHEET_USED * x * y))
        }
        (QuantityUnit::Gram, _) if parts.iter().all(|part| part.mass_g.is_some()) => {
            let mass_g = sum(&|part| part.mass_g.unwrap_or_default());
            (mass_g, "g", mass_g)
        }
        (QuantityUnit::Millilitre, _) => (volume_ml, "ml", volume_ml),
        // Without a density, one pack is assumed to be enough.
        (QuantityUnit::Gram, _) => (volume_ml, "ml", order.pack.amount),
        _ => (sum(&|_| 1.0), "pieces", sum(&|_| 1.0)),
    };
    let name = match &*more {
        "" => material,
        more => format!("{material}, {more}"),
    };
    let parts = parts.iter().map(|part| part.name.clone()).collect();
    let order = Purchase::new(&order, needed);
    Stock { name, process, parts, amount, unit, order }
}

/// Returns consumables, then tools, each ordered by name.
pub(crate) fn supplies(
    sensor: &Sensor,
    (made, mixes): (&[MadePart], &[StepMix]),
    shop: &dyn Shop,
) -> Vec<Supply> {
    let mut all: BTreeMap<(bool, String), Supply> = BTreeMap::new();
    let mut ask = |used: SupplyKind, order: &fabkit_geometry::Order, step: Option<usize>| {
        let name = order.article_and_size();
        let supply =
            all.entry((used == SupplyKind::Tool, name.clone())).or_insert_with(|| Supply {
                name,
                used,
                steps: Vec::new(),
                // A tiny amount makes one pack, whatever its size.
                order: Purchase::new(order, 1e-3),
            });
        // Steps come in order, so comparing with the last one is enough to list each once.
        supply.steps.extend(step.filter(|step| supply.steps.last() != Some(step)));
    };
    for (index, step) in sensor.chain.iter().enumerate() {
        let mut sentence = step.instruction.clone();
        for mix in mixes.iter().filter(|mix| mix.step == index + 1) {
            let warm = mix.cure_celsius > WARM_CELSIUS;
            let tokens = [(true, " @mix"), (mix.degas, " @degas"), (warm, " @warm")];
            tokens.iter().filter(|(is, _)| *is).for_each(|(_, token)| sentence += token);
        }
        for (used, order) in shop.asked_for(&sentence) {
            ask(used, &order, Some(index + 1));
        }
        let bodies = step.bodies.iter().filter_map(|name| sensor.body(name));
        for tool in bodies.filter_map(|body| body.order.as_ref()).flat_map(|order| &order.tools) {
            ask(SupplyKind::Tool, &shop.article(tool), Some(index + 1));
        }
    }
    let bought = sensor.bodies.iter().filter(|body| body.kind == BodyKind::Bought);
    for body in bought {
        for (used, order) in shop.asked_for(&body.summary) {
            ask(used, &order, None);
        }
        // A body that no step names is still mounted somewhere, so its tools are needed.
        let is_named = sensor.chain.iter().any(|step| step.bodies.contains(&body.name));
        for tool in body.order.iter().filter(|_| !is_named).flat_map(|order| &order.tools) {
            ask(SupplyKind::Tool, &shop.article(tool), None);
        }
    }
    for note in made.iter().flat_map(|part| &part.notes) {
        for (used, order) in shop.asked_for(note) {
            ask(used, &order, None);
        }
    }
    all.into_values().collect()
}

/// Sums the costs of everything except tools.
pub(crate) fn costs(
    bought: &[BoughtPiece],
    liquids: &[LiquidComponent],
    stock: &[Stock],
    supplies: &[Supply],
) -> Costs {
    let supplies = supplies.iter().filter(|supply| supply.used == SupplyKind::Supply);
    let bought = bought.iter().map(|piece| (&piece.name, &piece.order));
    let liquids = liquids.iter().map(|liquid| (&liquid.name, &liquid.order));
    let stock = stock.iter().map(|stock| (&stock.name, &stock.order));
    let supplies = supplies.map(|supply| (&supply.name, &supply.order));
    let (mut total_eur, mut unknown) = (0.0, Vec::new());
    for (name, order) in bought.chain(liquids).chain(stock).chain(supplies) {
        match order.cost_eur {
            Some(cost) => total_eur += cost,
            None => unknown.push(name.clone()),
        }
    }
    unknown.sort();
    unknown.dedup();
    Costs { total_eur, unknown, leaves_out: LEAVES_OUT }
}
