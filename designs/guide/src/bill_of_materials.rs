//! Lists of parts to make, pieces to buy and liquids to mix, with quantities.

use std::collections::BTreeMap;

use fabkit_geometry::measure::ray_volume;
use fabkit_geometry::{Body, BodyKind, CompiledSolid, Order, QuantityUnit, Sensor};
use serde::Serialize;

use crate::error::GuideError;
use crate::membership::is_in_sensor;
use crate::printing::{PrintPlan, printing};
use crate::shop::{Purchase, Shop, share_kits};
use crate::{Request, StepMix};

/// Number of rays through each part when its volume is measured: accurate to a percent for thin sheets, to some
/// thousandths otherwise.
pub(crate) const LINES: u32 = 20_000;

pub(crate) const MM3_PER_CM3: f64 = 1e3;

/// Use of a body: part of the finished sensor, or tool to build it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BodyUse {
    /// Stays in each unit.
    Sensor,
    /// Is used again for the next unit.
    Tool,
}

/// Part that a lab makes.
#[derive(Clone, Debug, Serialize)]
pub struct MadePart {
    /// Name of the part and of its file.
    pub name: String,
    /// Purpose of the part.
    pub summary: String,
    /// Use: part of the sensor, or tool.
    pub of: BodyUse,
    /// Process: `fdm`, `sla`, `polyjet`, `laser`, `pcb` or `cnc`.
    pub process: String,
    /// Material of the part.
    pub material: String,
    /// Quantity for all units.
    pub quantity: u32,
    /// Outer dimensions of one piece as it lies on the bed, mm.
    pub size_mm: [f64; 3],
    /// Volume of one piece, mm3.
    pub volume_mm3: f64,
    /// Mass of one piece as a solid body, g; `null` if the density of its material is not known.
    pub mass_g: Option<f64>,
    /// Print settings, if it is printed from filament.
    pub print: Option<PrintPlan>,
    /// Notes for whoever makes it.
    pub notes: Vec<String>,
    /// Numbers of the steps that need it.
    pub steps: Vec<usize>,
}

/// Piece to buy.
#[derive(Clone, Debug, Serialize)]
pub struct BoughtPiece {
    /// Name in the design.
    pub name: String,
    /// Specification of the piece.
    pub what: String,
    /// Use: part of the sensor, or tool.
    pub of: BodyUse,
    /// Quantity for all units.
    pub quantity: u32,
    /// Numbers of the steps that need it.
    pub steps: Vec<usize>,
    /// Article and packs to order.
    pub order: Purchase,
}

/// Component of mixes.
#[derive(Clone, Debug, Serialize)]
pub struct LiquidComponent {
    /// Trade name.
    pub name: String,
    /// Mass for all batches, waste included, g.
    pub mass_g: f64,
    /// Numbers of the steps that need it.
    pub steps: Vec<usize>,
    /// Article and packs to order.
    pub order: Purchase,
}

/// Returns the use of a body.
fn body_use(body: &Body) -> BodyUse {
    if is_in_sensor(body) { BodyUse::Sensor } else { BodyUse::Tool }
}

/// Returns the quantity of a body for all units; tools are made once.
fn quantity(body: &Body, units: u32) -> u32 {
    if is_in_sensor(body) { body.quantity.saturating_mul(units) } else { body.quantity }
}

/// Returns the numbers of the steps that need a body.
fn steps_with(sensor: &Sensor, name: &str) -> Vec<usize> {
    let needs = |(_, step): &(usize, &fabkit_geometry::Step)| step.bodies.iter().any(|b| b == name);
    sensor.chain.iter().enumerate().filter(needs).map(|(index, _)| index + 1).collect()
}

/// Lists the parts to make.
pub(crate) fn made(sensor: &Sensor, request: &Request<'_>) -> Result<Vec<MadePart>, GuideError> {
    let made = |part: &Body| {
        let body = || part.name.clone();
        let on_bed = part.solid.clone().placed(part.bed_from_body);
        let on_bed = CompiledSolid::new(&on_bed)
            .map_err(|source| GuideError::Solid { body: body(), source })?;
        let volume = ray_volume(&on_bed, LINES)
            .map_err(|source| GuideError::Volume { body: body(), source })?;
        let (volume_mm3, bounds) = (volume.value_mm3, on_bed.bounds());
        let size = bounds.max - bounds.min;
        let density = (request.density)(&part.material);
        Ok(MadePart {
            name: part.name.clone(),
            summary: part.summary.clone(),
            of: body_use(part),
            process: part.process_word().to_string(),
            material: part.material.clone(),
            quantity: quantity(part, request.units),
            size_mm: [size.x, size.y, size.z],
            volume_mm3,
            mass_g: density.map(|d| d * volume_mm3 / MM3_PER_CM3),
            print: printing(sensor, part, &on_bed, volume_mm3, density)?,
            notes: part.notes.clone(),
            steps: steps_with(sensor, &part.name),
        })
    };
    sensor.parts().map(made).collect()
}

/// Lists the pieces to buy.
pub(crate) fn bought(sensor: &Sensor, units: u32) -> Vec<BoughtPiece> {
    let bought = sensor.bodies.iter().filter(|body| body.kind == BodyKind::Bought);
    let entry = |body: &Body| BoughtPiece {
        name: body.name.clone(),
        what: body.summary.clone(),
        of: body_use(body),
        quantity: quantity(body, units),
        steps: steps_with(sensor, &body.name),
        order: purchase_for(body, quantity(body, units)),
    };
    bought.map(entry).collect()
}

/// Returns the purchase of enough packs for a number of pieces, or for the sum of their lengths.
fn purchase_for(body: &Body, quantity: u32) -> Purchase {
    let unsaid = || Order::new(body.summary.clone(), "");
    let order = body.order.clone().unwrap_or_else(unsaid);
    let each = match (order.pack.unit, order.length_mm) {
        (QuantityUnit::Millimetre, Some(length_mm)) => length_mm,
        (QuantityUnit::Piece, _) => 1.0,
        // Articles sold by mass, volume or unknown length: one pack for each piece.
        _ => order.pack.amount,
    };
    Purchase::new(&order, f64::from(quantity) * each)
}

/// Sums the components of all mixes.
pub(crate) fn liquids(mixes: &[StepMix], shop: &dyn Shop) -> Vec<LiquidComponent> {
    let mut liquids: BTreeMap<&str, LiquidComponent> = BTreeMap::new();
    for mix in mixes {
        for component in &mix.components {
            let liquid = liquids.entry(&component.name).or_insert_with(|| LiquidComponent {
                name: component.name.clone(),
                mass_g: 0.0,
                steps: Vec::new(),
                // The amount is known only after all mixes have been added.
                order: Purchase::new(&shop.article(&component.name), 0.0),
            });
            liquid.mass_g += component.mass_g * f64::from(mix.batches);
            if !liquid.steps.contains(&mix.step) {
                liquid.steps.push(mix.step);
            }
        }
    }
    let mut liquids: Vec<LiquidComponent> = liquids.into_values().collect();
    for liquid in &mut liquids {
        let order = shop.article(&liquid.name);
        // If a component is sold by the piece, one is assumed to be enough.
        let needed = if order.pack.unit == QuantityUnit::Piece { 1.0 } else { liquid.mass_g };
        liquid.order.set_packs(order.pack.count(needed));
    }
    share_kits(liquids.iter_mut().map(|liquid| &mut liquid.order));
    liquids
}
