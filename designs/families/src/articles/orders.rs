//! Filling of orders from the list of articles, and checks of the user's articles against the bodies that are bought.

use fabkit_geometry::{Body, BodyKind, Order, QuantityUnit, Sensor};
use fabkit_text::{LocatedProblem, join, to_printable};

use super::article_file::ListedArticle;
use super::{ArticleRole, Articles, BUYING};
use crate::user_catalogue::named_sections::{similar_names, unknown_hint};

/// Maximum number of names that a hint lists.
const MOST_LISTED: usize = 12;

impl Articles {
    /// Returns the order, filled with all properties stated for its article, for that size of it, and for the body of
    /// that name.
    ///
    /// ```
    /// use fabkit_designs::{Screw, articles::Articles};
    /// let order = Screw::M3X16.order();
    /// assert_eq!(order.price_eur, None);
    /// let filled = Articles::builtin().fill_order(&order, "screw-m3x16");
    /// assert!(filled.price_eur.is_some() && !filled.price_source.is_empty());
    /// ```
    pub fn fill_order(&self, order: &Order, body: &str) -> Order {
        let mut filled = order.clone();
        for known in self.entries_for(order, body) {
            merge_entry(&mut filled, known);
        }
        if let Some(what) =
            self.entries_for(order, body).filter_map(|k| k.article.what.clone()).last()
        {
            filled.figures.insert(0, ("what matters".into(), what));
        }
        filled
    }

    /// Finds the entries for an order, from the general to the special, so that the special ones override.
    fn entries_for<'a>(
        &'a self,
        order: &Order,
        body: &str,
    ) -> impl Iterator<Item = &'a ListedArticle> {
        let sized =
            (!order.size.is_empty()).then(|| self.find(&order.article_and_size())).flatten();
        [self.find(&order.article), sized, self.find(body)].into_iter().flatten()
    }
}

/// Merges the properties of an entry into an order.
fn merge_entry(order: &mut Order, known: &ListedArticle) {
    let article = &known.article;
    let text = |to: &mut String, from: &Option<String>| {
        if let Some(from) = from {
            to.clone_from(from);
        }
    };
    text(&mut order.maker, &article.maker);
    text(&mut order.number, &article.number);
    text(&mut order.substitutes, &article.substitutes);
    order.standard = article.standard.clone().or(order.standard.take());
    order.kit = article.kit.clone().or(order.kit.take());
    if let (Some(length), Some(width)) = (article.length, article.width) {
        order.sheet_mm = Some([length.mm(), width.mm()]);
    }
    if let Some(pack) = article.pack {
        order.pack = pack.0;
    }
    // A figure that the new entry states replaces the older one of the same name.
    order.figures.retain(|(name, _)| known.figures.iter().all(|(other, _)| other != name));
    order.figures.extend(known.figures.iter().cloned());
    let source = match (&article.source, &known.own) {
        (Some(source), _) => source.clone(),
        (None, Some(place)) => place.file.to_string(),
        (None, None) => "fabkit's list".to_owned(),
    };
    order.source = source;
    if let Some(price) = article.price {
        order.price_eur = Some(price.0);
        order.price_source.clone_from(&known.price_source);
    }
}

/// Fills the orders of all bought bodies.
pub(crate) fn fill_all(sensor: &mut Sensor, articles: &Articles) {
    for body in sensor.bodies.iter_mut().filter(|body| body.kind == BodyKind::Bought) {
        let order = body.order.take().unwrap_or_else(|| Order::new(body.summary.clone(), ""));
        body.order = Some(if order.is_sensor_itself {
            order
        } else {
            articles.fill_order(&order, &body.name)
        });
    }
}

/// Fills the orders of all bought bodies, and reports articles of the user's that the sensor does not need or that are
/// counted in the wrong unit. `components` are those of all mixes that the sensor may have.
pub(crate) fn fill_and_check(
    sensor: &mut Sensor,
    articles: &Articles,
    components: &[&str],
    found: &mut Vec<LocatedProblem>,
) {
    fill_all(sensor, articles);
    let bought: Vec<&Body> = sensor.components().collect();
    for known in articles.by_key.values() {
        let Some(place) = &known.own else { continue };
        let path = join(BUYING.key, &to_printable(&known.name));
        let is_named = |order: &Order| {
            [&order.article, &order.article_and_size()]
                .into_iter()
                .any(|name| same(name, &known.name))
        };
        let bodies = bought.iter().filter(|body| {
            same(&body.name, &known.name) || body.order.as_ref().is_some_and(is_named)
        });
        let bodies: Vec<&&Body> = bodies.collect();
        let is_component = components.iter().any(|name| same(name, &known.name));
        let unit = known.article.pack.map_or(QuantityUnit::Piece, |pack| pack.0.unit);
        // Mixes are weighed; bodies are counted or, where their order has a length, measured.
        let wants = match () {
            () if is_component => matches!(unit, QuantityUnit::Gram | QuantityUnit::Piece),
            () => bodies.iter().all(|body| match unit {
                QuantityUnit::Piece => true,
                QuantityUnit::Millimetre => {
                    body.order.as_ref().is_some_and(|o| o.length_mm.is_some())
                }
                QuantityUnit::Gram | QuantityUnit::Millilitre => false,
            }),
        };
        if !wants {
            let right = if is_component { "g" } else { "pieces" };
            let message = format!(
                "{} is counted in {right}, not in {}",
                to_printable(&known.name),
                unit.word()
            );
            let hint = format!("write how many {right} a pack holds");
            let path = join(&path, "pack");
            found.push(place.problem(&path, unit.word(), message).hint(hint));
            continue;
        }
        // Not needed by this sensor, but no mistake either: the built-in list or another entry knows the name.
        let is_of_list = Articles::builtin().find(&known.name).is_some();
        let is_new = matches!(
            known.article.role,
            Some(ArticleRole::Stock | ArticleRole::Supply | ArticleRole::Tool)
        );
        let is_base = articles.raws.iter().any(|raw| raw.extends(&known.name));
        // An entry in the file for all sensors need not concern this one.
        let is_for_all = place.layer == fabkit_text::TextLayer::Base;
        if is_component || is_of_list || is_new || is_base || is_for_all || !bodies.is_empty() {
            continue;
        }
        let names: Vec<&str> =
            bought.iter().map(|body| &*body.name).chain(components.iter().copied()).collect();
        let message =
            format!("`{}` is nothing that is bought for this sensor", to_printable(&known.name));
        let close =
            similar_names(&known.name, names.iter().copied().chain(Articles::builtin().names()));
        let listed = &names[..names.len().min(MOST_LISTED)];
        let hint = if close.is_empty() {
            unknown_hint(&known.name, listed)
        } else {
            format!("{} pieces are {}", fabkit_text::did_you_mean(&close), listed.join("; "))
        };
        found.push(place.problem(&path, &to_printable(&known.name), message).hint(hint));
    }
}

/// Returns whether two names are equal except for case and doubled spaces.
fn same(a: &str, b: &str) -> bool {
    crate::user_catalogue::named_sections::key_of(a)
        == crate::user_catalogue::named_sections::key_of(b)
}
