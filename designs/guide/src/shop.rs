//! Articles in shops, and the number of packs to buy.

use fabkit_geometry::{Order, Pack, QuantityUnit};
use serde::Serialize;

/// List of articles that can be bought.
///
/// ```
/// use fabkit_geometry::{Order, Pack, QuantityUnit};
/// use fabkit_guide::{Guide, Request, Shop, SupplyKind};
///
/// /// Sells everything in packs of 100 g for 8 EUR.
/// struct OnePrice;
///
/// impl Shop for OnePrice {
///     fn article(&self, name: &str) -> Order {
///         let pack = Pack { amount: 100.0, unit: QuantityUnit::Gram };
///         Order { pack, price_eur: Some(8.0), ..Order::new(name, "") }
///     }
///     fn stock(&self, _process: &str, material: &str) -> Order {
///         self.article(material)
///     }
///     fn asked_for(&self, _sentence: &str) -> Vec<(SupplyKind, Order)> {
///         Vec::new()
///     }
/// }
/// # let sensor = fabkit_checks::example::puck();
/// # let stages = fabkit_checks::stages(&sensor)?;
/// # let (density, calibration) = (&|_: &str| None, None);
/// let shop = &OnePrice;
/// let request =
///     Request { design_hash: "00", units: 1, density, shop, stages: &stages, calibration };
/// let guide = Guide::new(&sensor, &request)?;
/// // The puck takes less than a gram of either component: one pack each.
/// let packs: Vec<_> = guide.liquids.iter().map(|one| (&*one.name, one.order.packs)).collect();
/// assert_eq!(packs, [("A", 1), ("B", 1)]);
/// assert_eq!(guide.liquids[0].order.cost_eur, Some(8.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Shop {
    /// Returns an article by its name: a component of a mix, a tool.
    fn article(&self, name: &str) -> Order;
    /// Returns the stock from which a process makes parts of a material.
    fn stock(&self, process: &str, material: &str) -> Order;
    /// Returns the supplies and tools that a sentence requires, ordered by name. `@mix`, `@degas` and `@warm` in it
    /// stand for mixing, degassing, and curing above room temperature.
    fn asked_for(&self, sentence: &str) -> Vec<(SupplyKind, Order)>;
}

/// Shop without articles: anything may be of any maker.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoShop;

impl Shop for NoShop {
    fn article(&self, name: &str) -> Order {
        Order::new(name, "")
    }

    fn stock(&self, _process: &str, material: &str) -> Order {
        Order::new(material, "")
    }

    fn asked_for(&self, _sentence: &str) -> Vec<(SupplyKind, Order)> {
        Vec::new()
    }
}

/// Distinction between consumables and tools.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SupplyKind {
    /// Used up by the work.
    Supply,
    /// Used again, and not part of the costs.
    Tool,
}

/// Text for values that are not known.
const NONE: &str = "none known";

/// Order for a shop: article, number of packs and cost. No text is empty.
#[derive(Clone, Debug, Serialize)]
pub struct Purchase {
    /// Name of the article.
    pub article: String,
    /// Size of the article; `one size` if there is no other.
    pub size: String,
    /// Maker, or `any`.
    pub maker: String,
    /// Name or number that the maker gives it, or `any`.
    pub number: String,
    /// Standard that it follows, or `none`.
    pub standard: String,
    /// Relevant properties, by name.
    pub figures: Vec<ArticleProperty>,
    /// Pack size: `100 pieces`.
    pub pack: String,
    /// Kit in which it is sold together with other articles.
    pub kit: Option<String>,
    /// Number of packs to buy; 0 if it is at hand, or comes with the kit of another line.
    pub packs: u32,
    /// Price of a pack, EUR; `null` if not known.
    pub price_eur: Option<f64>,
    /// Cost of all packs, EUR; `null` if not known.
    pub cost_eur: Option<f64>,
    /// Possible substitutes.
    pub substitutes: String,
    /// Source of the data, except the price.
    pub source: String,
    /// Source of the price.
    pub price_source: String,
}

/// Relevant property of an article.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArticleProperty {
    /// Name of the property.
    pub name: String,
    /// Value with its unit and source.
    pub value: String,
}

impl Purchase {
    /// Creates the purchase of enough packs for an amount in the pack's unit.
    pub(crate) fn new(order: &Order, needed: f64) -> Self {
        let or = |text: &str, other: &str| if text.is_empty() { other } else { text }.to_owned();
        let figures = order.figures.iter();
        let mut purchase = Self {
            article: order.article.clone(),
            size: or(&order.size, "one size"),
            maker: order.maker.clone(),
            number: order.number.clone(),
            standard: order.standard.clone().unwrap_or_else(|| "none".into()),
            figures: figures
                .map(|(name, value)| ArticleProperty { name: name.clone(), value: value.clone() })
                .collect(),
            pack: packed(order.pack),
            kit: order.kit.clone(),
            packs: 0,
            price_eur: order.price_eur,
            cost_eur: None,
            substitutes: or(&order.substitutes, NONE),
            source: order.source.clone(),
            price_source: or(&order.price_source, NONE),
        };
        if order.is_sensor_itself {
            (purchase.pack, purchase.price_eur, purchase.cost_eur) =
                ("at hand".into(), Some(0.0), Some(0.0))
        } else {
            purchase.set_packs(order.pack.count(needed))
        }
        purchase
    }

    /// Sets the number of packs and the cost.
    pub(crate) fn set_packs(&mut self, packs: u32) {
        self.packs = packs;
        self.cost_eur = self.price_eur.map(|price| price * f64::from(packs));
    }

    /// Returns the text to order by: the standard, or maker and number, or `any`.
    pub fn order_text(&self) -> String {
        let made = match (&*self.maker, &*self.number) {
            ("any", "any") => "any".to_owned(),
            (maker, "any") => maker.to_owned(),
            ("any", number) => number.to_owned(),
            (maker, number) => format!("{maker} {number}"),
        };
        match (&*self.standard, &*made) {
            ("none", _) => made,
            (standard, "any") => standard.to_owned(),
            (standard, _) => format!("{standard}; {made}"),
        }
    }
}

/// Formats a pack size for people.
fn packed(Pack { amount, unit }: Pack) -> String {
    match unit {
        QuantityUnit::Piece if amount == 1.0 => "1 piece".into(),
        QuantityUnit::Gram if amount >= 1e3 => format!("{} kg", amount / 1e3),
        QuantityUnit::Millilitre if amount >= 1e3 => format!("{} l", amount / 1e3),
        QuantityUnit::Millimetre if amount >= 1e3 => format!("{} m", amount / 1e3),
        _ => format!("{amount} {}", unit.word()),
    }
}

/// Charges a kit once: for as many packs as the component needs that needs most.
pub(crate) fn share_kits<'p>(purchases: impl Iterator<Item = &'p mut Purchase>) {
    let mut paying: Vec<&mut Purchase> = Vec::new();
    for purchase in purchases {
        let same = |other: &&mut &mut Purchase| purchase.kit.is_some() && other.kit == purchase.kit;
        if let Some(first) = paying.iter_mut().find(same) {
            let packs = first.packs.max(purchase.packs);
            first.set_packs(packs);
            // It comes with the kit of the first line.
            purchase.set_packs(0);
        } else {
            paying.push(purchase);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(kit: Option<&str>, amount: f64) -> Order {
        Order {
            kit: kit.map(str::to_owned),
            price_eur: Some(10.0),
            pack: Pack { amount, unit: QuantityUnit::Gram },
            ..Order::new("A", "")
        }
    }

    #[test]
    fn kit_is_charged_once_for_the_largest_need() {
        let kit = || order(Some("kit"), 450.0);
        let mut bought = [
            Purchase::new(&kit(), 10.0),
            Purchase::new(&order(None, 100.0), 250.0),
            Purchase::new(&order(Some("kit"), 50.0), 120.0),
        ];
        share_kits(bought.iter_mut());
        assert_eq!(bought.each_ref().map(|one| one.packs), [3, 3, 0]);
        assert_eq!(bought.each_ref().map(|one| one.cost_eur), [Some(30.0), Some(30.0), Some(0.0)]);
        assert_eq!(bought[0].pack, "450 g");
    }

    #[test]
    fn no_text_is_empty() {
        let purchase = Purchase::new(&Order::new("thing", ""), 3.0);
        let texts = [&purchase.size, &purchase.substitutes, &purchase.standard, &purchase.source];
        assert!(texts.iter().all(|text| !text.is_empty()), "{purchase:?}");
        assert_eq!((purchase.packs, purchase.cost_eur), (3, None));
        assert_eq!(purchase.order_text(), "any");
        assert_eq!(Purchase::new(&Order::for_sensor_itself(), 1.0).cost_eur, Some(0.0));
    }
}
