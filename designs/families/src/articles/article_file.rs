//! Reading of articles from files.

use std::collections::BTreeMap;

use fabkit_geometry::QuantityUnit;
use fabkit_text::{LocatedProblem, Setting, SourceKind, TextPlace, join, to_printable};

use super::{Article, BUYING, PRICE_SOURCE, PackSize, is_builtin};
use crate::user_catalogue::named_sections::{LayeredSections, RawSection, read};

/// Article with its origin in the files.
#[derive(Clone, Debug)]
pub(super) struct ListedArticle {
    /// Name as it was first written.
    pub name: String,
    /// Merged properties of the article.
    pub article: Article,
    /// Figures that an order lists: name, and value as text.
    pub figures: Vec<(String, String)>,
    /// Source of the price.
    pub price_source: String,
    /// Place of the last statement on the article, if that is in a file of the user's.
    pub own: Option<TextPlace>,
}

/// Keys of the figures that an order lists, and their names there.
const FIGURES: [(&str, &str); 5] = [
    ("forward_voltage", "forward voltage"),
    ("current", "current"),
    ("wavelength", "wavelength"),
    ("color_temperature", "colour temperature"),
    ("view_angle", "view angle"),
];

/// Reads all articles, by their keys; reports wrong ones and leaves them out.
pub(super) fn by_key(
    raws: &[RawSection],
    found: &mut Vec<LocatedProblem>,
) -> BTreeMap<String, ListedArticle> {
    let layered = LayeredSections::new(raws);
    let known = |(key, said): (&String, &[&RawSection])| {
        Some((key.clone(), read_article(&layered, key, said, found)?))
    };
    layered.iter().filter_map(known).collect()
}

/// Reads one article; returns `None` after reporting its problems.
fn read_article(
    layered: &LayeredSections,
    key: &str,
    said: &[&RawSection],
    found: &mut Vec<LocatedProblem>,
) -> Option<ListedArticle> {
    let (first, last) = (said.first()?, said.last()?);
    let name = first.name.clone();
    let stack = layered.stack(BUYING, key, found)?;
    // A built-in article that a file of the user's changes keeps its unit of sale.
    let builtin: Vec<_> = stack.iter().filter(|(place, _)| is_builtin(place)).cloned().collect();
    let is_changed = builtin.len() < stack.len() && !builtin.is_empty();
    let (article, settings) = read::<Article>(BUYING, &name, &last.place, stack, found)?;
    if is_changed {
        let (usual, _) = read::<Article>(BUYING, &name, &first.place, builtin, &mut Vec::new())?;
        check_same_unit(&name, usual.pack, article.pack, last, found)?;
    }
    // The price's own source or note goes first, then the article's `price_source`, then the file.
    let price_source = match find_setting(&settings, "price") {
        Some(price) if price.source.kind != SourceKind::User || !price.source.note.is_empty() => {
            source_text(price)
        }
        _ => match (&article.price_source, is_builtin(&last.place)) {
            (Some(source), _) => source.clone(),
            (None, true) => PRICE_SOURCE.to_owned(),
            (None, false) => last.place.file.to_string(),
        },
    };
    let figures = FIGURES.iter().filter_map(|(key, name)| {
        let setting = find_setting(&settings, key)?;
        let is_told = setting.source.kind != SourceKind::User;
        let from = if is_told { format!(" ({})", source_text(setting)) } else { String::new() };
        Some(((*name).to_owned(), format!("{}{from}", setting.value)))
    });
    let figures = figures.collect();
    let own = (!is_builtin(&last.place)).then(|| last.place.clone());
    Some(ListedArticle { name, article, figures, price_source, own })
}

/// Finds the setting of a key, the last word of its path.
fn find_setting<'s>(settings: &'s [Setting], key: &str) -> Option<&'s Setting> {
    settings.iter().find(|setting| setting.path.ends_with(&format!(".{key}")))
}

/// Formats the source of a setting with its note.
fn source_text(setting: &Setting) -> String {
    match &*setting.source.note {
        "" => setting.source.kind.word().to_owned(),
        note => format!("{}: {note}", setting.source.kind.word()),
    }
}

/// Checks that a changed article keeps its unit: the bodies that need it count in the unit of the built-in list, so
/// that a piece cannot become a length.
fn check_same_unit(
    name: &str,
    usual: Option<PackSize>,
    pack: Option<PackSize>,
    raw: &RawSection,
    found: &mut Vec<LocatedProblem>,
) -> Option<()> {
    let unit = |pack: Option<PackSize>| pack.map_or(QuantityUnit::Piece, |pack| pack.0.unit);
    let [usual, given] = [usual, pack].map(unit);
    if usual == given {
        return Some(());
    }
    let path = join(&join(BUYING.key, &to_printable(name)), "pack");
    let message =
        format!("{} is counted in {}, not in {}", to_printable(name), usual.word(), given.word());
    let hint = format!("write how many {} a pack holds", usual.word());
    found.push(raw.place.problem(&path, given.word(), message).hint(hint));
    None
}
