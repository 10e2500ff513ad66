//! Purchasable articles: what shops need to know about screws, rings, LEDs, cameras, silicones and consumables.
//!
//! Bodies state article and size ([`Order`]); everything else is in `designs/families/catalogue/*.yaml`, in the form in
//! which users write their own entries below `buy:`, which override the built-in ones name by name. The geometry does
//! not depend on articles, so they do not count for a design's hash.

mod article;
mod article_file;
mod orders;
mod pack;

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use fabkit_geometry::Order;
use fabkit_text::{Dialect, LocatedProblem, TextLayer, TextPlace, read_mapping, take_format};

pub use article::{Article, ArticleRole};
pub(crate) use orders::{fill_all, fill_and_check};
pub use pack::PackSize;

use crate::materials::StockCatalogue;
use crate::user_catalogue::named_sections::{RawSection, SectionKind, key_of, read_sections};
use article_file::ListedArticle;

/// Articles in files: key and dialect.
pub(crate) const BUYING: SectionKind = SectionKind {
    key: "buy",
    dialect: &Dialect::new("list of what to buy", 1, ", then `buy:` and names with sections"),
};

/// Built-in files of `catalogue/`: stem and text.
const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/catalogue.rs"));

/// Suffix of a built-in file's name in messages, after its stem.
const BUILTIN_FILE: &str = ".yaml (built-in)";

/// Returns whether a place is in one of the built-in files.
fn is_builtin(place: &TextPlace) -> bool {
    FILES.iter().any(|(stem, _)| place.file.strip_suffix(BUILTIN_FILE) == Some(stem))
}

/// Source of built-in prices that state none of their own.
const PRICE_SOURCE: &str = "chosen: what shops in Europe asked in 2025, roughly, without shipping";

/// Articles of the built-in files.
static BUILTIN: LazyLock<Articles> = LazyLock::new(|| {
    let mut found = Vec::new();
    let articles = Articles::from_sections(builtin_raws(&mut found), &mut found);
    debug_assert!(found.is_empty(), "{found:#?}");
    articles
});

/// Reads the sections of the built-in files.
fn builtin_raws(found: &mut Vec<LocatedProblem>) -> Vec<RawSection> {
    let mut all = Vec::new();
    for (stem, yaml) in FILES {
        let file = format!("{stem}{BUILTIN_FILE}");
        let place = TextPlace::new(TextLayer::Base, &file, BUYING.dialect);
        let mut entries = read_mapping(yaml, &place, found).unwrap_or_default();
        take_format(&mut entries, &place, found);
        for entry in entries {
            all.extend(read_sections(BUYING, entry, &place, found));
        }
    }
    all
}

/// All purchasable articles, by name.
#[derive(Clone, Debug)]
pub struct Articles {
    raws: Arc<Vec<RawSection>>,
    by_key: Arc<BTreeMap<String, ListedArticle>>,
    /// Materials by which stock is found.
    materials: StockCatalogue,
}

impl Default for Articles {
    fn default() -> Self {
        Self::builtin().clone()
    }
}

impl Articles {
    /// Returns the articles that fabkit comes with.
    pub fn builtin() -> &'static Self {
        &BUILTIN
    }

    /// Returns the articles with the entries of files added; later entries override earlier ones. `materials` are those
    /// that stock is of.
    pub(crate) fn with(
        &self,
        own: Vec<RawSection>,
        materials: &StockCatalogue,
        found: &mut Vec<LocatedProblem>,
    ) -> Self {
        let articles = if own.is_empty() {
            self.clone()
        } else {
            Self::from_sections(self.raws.iter().cloned().chain(own).collect(), found)
        };
        Self { materials: materials.clone(), ..articles }
    }

    /// Creates the articles from sections in the order of their layers.
    fn from_sections(raws: Vec<RawSection>, found: &mut Vec<LocatedProblem>) -> Self {
        let by_key = article_file::by_key(&raws, found);
        let materials = StockCatalogue::builtin().clone();
        Self { by_key: Arc::new(by_key), raws: Arc::new(raws), materials }
    }

    /// Returns all names as they are written.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.by_key.values().map(|known| &*known.name)
    }

    /// Finds an article by its exact name, except for case and doubled spaces.
    fn find(&self, name: &str) -> Option<&ListedArticle> {
        self.by_key.get(&key_of(name))
    }

    /// Finds an article by its name, or by the longest leading words that are a name: `hexagon key 4 mm` is a `hexagon
    /// key` of size `4 mm`.
    ///
    /// ```
    /// use fabkit_designs::articles::Articles;
    /// let key = Articles::builtin().article("hexagon key 4 mm");
    /// assert_eq!((&*key.article, &*key.size), ("hexagon key", "4 mm"));
    /// assert_eq!(key.standard.as_deref(), Some("ISO 2936"));
    /// // An order of what no list knows has no price.
    /// assert_eq!(Articles::builtin().article("left-handed hammer").price_eur, None);
    /// ```
    pub fn article(&self, name: &str) -> Order {
        let key = key_of(name);
        // Candidates are all runs of leading words.
        let cuts = key.match_indices(' ').map(|(at, _)| at).chain([key.len()]);
        let begins = cuts.filter(|at| self.by_key.contains_key(&key[..*at])).max();
        match begins {
            Some(at) => {
                let size: Vec<&str> = name.split_whitespace().collect();
                let words = key[..at].split(' ').count();
                self.fill_order(
                    &Order::new(&*self.by_key[&key[..at]].name, size[words..].join(" ")),
                    "",
                )
            }
            None => Order::new(name, ""),
        }
    }

    /// Finds the stock that parts are made from, by process and by the materials that it is of, as the catalogue of
    /// materials knows them; the entry that names none applies to all other materials.
    ///
    /// ```
    /// use fabkit_designs::articles::Articles;
    /// let articles = Articles::builtin();
    /// // Filament is sold by the kilogram, whatever its colour; sheets have a size.
    /// assert_eq!(articles.stock("fdm", "black PLA").pack.amount, 1000.0);
    /// assert_eq!(articles.stock("laser", "birch plywood").sheet_mm, Some([600.0, 400.0]));
    /// ```
    pub fn stock(&self, process: &str, material: &str) -> Order {
        let of_process = self.by_key.values().filter(|known| {
            known.article.role == Some(ArticleRole::Stock)
                && known.article.process.as_deref() == Some(process)
        });
        // The entry with the longest matching name wins.
        let fitting = of_process.filter_map(|known| {
            let length = match &known.article.words {
                // The entry without names fits any material, but any matching name is better.
                None => 0,
                Some(names) => names
                    .split(';')
                    .filter(|name| self.materials.means(name, material))
                    .map(str::len)
                    .max()?,
            };
            Some((length, known))
        });
        match fitting.max_by_key(|(length, _)| *length) {
            Some((_, known)) => self.fill_order(&Order::new(&*known.name, material), ""),
            None => Order::new(material, ""),
        }
    }

    /// Finds the supplies and tools whose words occur in a text.
    ///
    /// ```
    /// use fabkit_designs::articles::{ArticleRole, Articles};
    /// let found = Articles::builtin().find_supplies("solder the LEDs to the board");
    /// let names = |role| {
    ///     let of_role = found.iter().filter(move |(of, _)| *of == role);
    ///     of_role.map(|(_, order)| &*order.article).collect::<Vec<_>>()
    /// };
    /// assert_eq!(names(ArticleRole::Tool), ["soldering iron"]);
    /// assert_eq!(names(ArticleRole::Supply), ["solder"]);
    /// ```
    pub fn find_supplies(&self, text: &str) -> Vec<(ArticleRole, Order)> {
        let asked = |known: &&ListedArticle| {
            let words = known.article.words.as_deref().unwrap_or_default();
            words.split(';').any(|word| contains_words(text, word))
        };
        let of_role = |known: &ListedArticle| {
            let role = known.article.role?;
            let is_it = matches!(role, ArticleRole::Supply | ArticleRole::Tool);
            is_it.then(|| (role, self.fill_order(&Order::new(&*known.name, ""), "")))
        };
        self.by_key.values().filter(asked).filter_map(of_role).collect()
    }
}

/// Returns whether a text contains one or several words, each matched from its beginning: `screw` is in `two screws`.
fn contains_words(text: &str, words: &str) -> bool {
    let plain = |text: &str| {
        // Signs that belong to words, as in `@mix` and hyphenated names.
        let is_letter = |c: char| c.is_alphanumeric() || matches!(c, '@' | '-');
        let parts = text.to_lowercase();
        let parts = parts.split(|c: char| !is_letter(c)).filter(|part| !part.is_empty());
        parts.collect::<Vec<_>>().join(" ")
    };
    let words = plain(words);
    !words.is_empty() && format!(" {}", plain(text)).contains(&format!(" {words}"))
}
