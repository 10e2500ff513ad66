//! What shops know of what is bought, and how many packs that makes.

use fabkit_geometry::{Order, Pack, Unit};
use serde::Serialize;

/// A list of what may be bought.
pub trait Shop {
    /// An article by its name: a component of a mix, a tool.
    fn article(&self, name: &str) -> Order;
    /// What parts of a material are made from by a process.
    fn stock(&self, process: &str, material: &str) -> Order;
    /// Supplies and tools that a sentence asks for, in the order of their names. `@mix`, `@degas` and `@warm` in
    /// it stand for work that mixes, draws air out, and cures above room temperature.
    fn asked_for(&self, sentence: &str) -> Vec<(Use, Order)>;
}

/// Knows no article: whatever is asked for may be of any maker.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoShop;

impl Shop for NoShop {
    fn article(&self, name: &str) -> Order {
        Order::of(name, "")
    }

    fn stock(&self, _process: &str, material: &str) -> Order {
        Order::of(material, "")
    }

    fn asked_for(&self, _sentence: &str) -> Vec<(Use, Order)> {
        Vec::new()
    }
}

/// Whether work uses something up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Use {
    /// It is used up.
    Supply,
    /// It is used again, and no part of the costs.
    Tool,
}

/// Nothing is known.
const NONE: &str = "none known";

/// What to ask a shop for, how much of it, and what that costs. No text is empty.
#[derive(Clone, Debug, Serialize)]
pub struct Purchase {
    /// The article.
    pub article: String,
    /// Which of its sizes; `one size` where there is no other.
    pub size: String,
    /// Who makes it, or `any`.
    pub maker: String,
    /// The maker's name or number for it, or `any`.
    pub number: String,
    /// The standard that it follows, or `none`.
    pub standard: String,
    /// What matters of it, by name.
    pub figures: Vec<Figure>,
    /// What is sold at once: `100 pieces`.
    pub pack: String,
    /// What it is sold as together with others.
    pub kit: Option<String>,
    /// How many packs to buy; 0 where it is there, or comes with the kit of another line.
    pub packs: u32,
    /// Of a pack, EUR; `null` where nobody knows.
    pub price_eur: Option<f64>,
    /// Of all packs, EUR; `null` where nobody knows.
    pub cost_eur: Option<f64>,
    /// What may be bought in its place.
    pub substitutes: String,
    /// Where that comes from, but the price.
    pub source: String,
    /// Where the price comes from.
    pub price_source: String,
}

/// What matters of an article.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// What it is.
    pub name: String,
    /// With its unit, and where it comes from.
    pub value: String,
}

impl Purchase {
    /// As many packs as hold what is needed, in the pack's unit.
    pub(crate) fn of(order: &Order, needed: f64) -> Self {
        let or = |text: &str, other: &str| if text.is_empty() { other } else { text }.to_owned();
        let figures = order.figures.iter();
        let mut purchase = Self {
            article: order.article.clone(),
            size: or(&order.size, "one size"),
            maker: order.maker.clone(),
            number: order.number.clone(),
            standard: order.standard.clone().unwrap_or_else(|| "none".into()),
            figures: figures
                .map(|(name, value)| Figure { name: name.clone(), value: value.clone() })
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
        match order.at_hand {
            true => {
                (purchase.pack, purchase.price_eur, purchase.cost_eur) =
                    ("at hand".into(), Some(0.0), Some(0.0))
            }
            false => purchase.take(order.pack.count(needed)),
        }
        purchase
    }

    /// That many packs.
    pub(crate) fn take(&mut self, packs: u32) {
        self.packs = packs;
        self.cost_eur = self.price_eur.map(|price| price * f64::from(packs));
    }

    /// The standard, or who makes it and what they call it, or that any will do.
    pub fn ordered_by(&self) -> String {
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

/// As people write it.
fn packed(Pack { amount, unit }: Pack) -> String {
    match unit {
        Unit::Piece if amount == 1.0 => "1 piece".into(),
        Unit::Gram if amount >= 1e3 => format!("{} kg", amount / 1e3),
        Unit::Millilitre if amount >= 1e3 => format!("{} l", amount / 1e3),
        Unit::Millimetre if amount >= 1e3 => format!("{} m", amount / 1e3),
        _ => format!("{amount} {}", unit.word()),
    }
}

/// What is sold as one kit is bought once: as often as the component needs it that needs most.
pub(crate) fn share_kits<'p>(purchases: impl Iterator<Item = &'p mut Purchase>) {
    let mut paying: Vec<&mut Purchase> = Vec::new();
    for purchase in purchases {
        let same = |other: &&mut &mut Purchase| purchase.kit.is_some() && other.kit == purchase.kit;
        if let Some(first) = paying.iter_mut().find(same) {
            let packs = first.packs.max(purchase.packs);
            first.take(packs);
            purchase.take(0);
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
            pack: Pack { amount, unit: Unit::Gram },
            ..Order::of("A", "")
        }
    }

    #[test]
    fn a_kit_is_paid_for_once_and_as_often_as_its_scarcest_part_asks() {
        let kit = || order(Some("kit"), 450.0);
        let mut bought = [
            Purchase::of(&kit(), 10.0),
            Purchase::of(&order(None, 100.0), 250.0),
            Purchase::of(&order(Some("kit"), 50.0), 120.0),
        ];
        share_kits(bought.iter_mut());
        assert_eq!(bought.each_ref().map(|one| one.packs), [3, 3, 0]);
        assert_eq!(bought.each_ref().map(|one| one.cost_eur), [Some(30.0), Some(30.0), Some(0.0)]);
        assert_eq!(bought[0].pack, "450 g");
    }

    #[test]
    fn no_text_is_empty() {
        let purchase = Purchase::of(&Order::of("thing", ""), 3.0);
        let texts = [&purchase.size, &purchase.substitutes, &purchase.standard, &purchase.source];
        assert!(texts.iter().all(|text| !text.is_empty()), "{purchase:?}");
        assert_eq!((purchase.packs, purchase.cost_eur), (3, None));
        assert_eq!(purchase.ordered_by(), "any");
        assert_eq!(Purchase::of(&Order::at_hand(), 1.0).cost_eur, Some(0.0));
    }
}
