//! What to ask a shop for.

/// What a pack is counted in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Pieces.
    Piece,
    /// Mass, g.
    Gram,
    /// Volume, ml.
    Millilitre,
    /// Length, mm.
    Millimetre,
}

impl Unit {
    /// As people write it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Piece => "pieces",
            Self::Gram => "g",
            Self::Millilitre => "ml",
            Self::Millimetre => "mm",
        }
    }
}

/// The smallest amount that is sold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pack {
    /// How much, in its unit; more than 0.
    pub amount: f64,
    /// Its unit.
    pub unit: Unit,
}

impl Pack {
    /// How many packs hold that much of its unit.
    pub fn count(self, needed: f64) -> u32 {
        // What is computed is not exact: ten pieces of 0.1 are one.
        const ROUNDING: f64 = 1e-9;
        (needed / self.amount - ROUNDING).ceil().max(0.0) as u32
    }
}

/// Nobody knows who makes it, or it does not matter.
pub const ANY: &str = "any";

/// What to ask a shop for: which article, of which size, and what a list of bought pieces knows of it.
///
/// Whoever makes a body says article and size; the rest is filled in in one place from that list.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// The article's name in the list: `pan head screw ISO 7045`.
    pub article: String,
    /// Which of its sizes: `M3x16`; empty where there is one alone.
    pub size: String,
    /// Length that one piece takes of what is sold by length, mm.
    pub length_mm: Option<f64>,
    /// Whether it is there already, because it is the sensor itself.
    pub at_hand: bool,
    /// What it is put in with: `screwdriver PH1`.
    pub tools: Vec<String>,
    /// Who makes it; [`ANY`] where that does not matter.
    pub maker: String,
    /// The maker's name or number for it; [`ANY`] where there is none.
    pub number: String,
    /// The standard that it follows, if one does.
    pub standard: Option<String>,
    /// What matters of it, by name: `forward voltage`, `2.9 V, typical`.
    pub figures: Vec<(String, String)>,
    /// How much is sold at once.
    pub pack: Pack,
    /// Length and width of what is sold as sheets, mm.
    pub sheet_mm: Option<[f64; 2]>,
    /// What several articles are sold as together: both parts of a silicone are one kit, and paid for once.
    pub kit: Option<String>,
    /// What a pack, or the whole kit, costs, EUR; nothing where nobody knows.
    pub price_eur: Option<f64>,
    /// What may be bought in its place; empty where nothing is known.
    pub substitutes: String,
    /// Where that comes from, but the price.
    pub source: String,
    /// Where the price comes from; empty where nobody knows it.
    pub price_source: String,
}

impl Order {
    /// An article in a size, of which nothing more is known yet.
    pub fn of(article: impl Into<String>, size: impl Into<String>) -> Self {
        Self {
            article: article.into(),
            size: size.into(),
            length_mm: None,
            at_hand: false,
            tools: Vec::new(),
            maker: ANY.into(),
            number: ANY.into(),
            standard: None,
            figures: Vec::new(),
            pack: Pack { amount: 1.0, unit: Unit::Piece },
            sheet_mm: None,
            kit: None,
            price_eur: None,
            substitutes: String::new(),
            source: "the design alone".into(),
            price_source: String::new(),
        }
    }

    /// What nobody buys: the sensor that a fixture is made for.
    pub fn at_hand() -> Self {
        Self {
            at_hand: true,
            source: "this design is made for it".into(),
            ..Self::of("the sensor itself", "")
        }
    }

    /// Cut from what is sold by length, mm for each piece.
    #[must_use]
    pub fn cut_to(self, length_mm: f64) -> Self {
        Self { length_mm: Some(length_mm), ..self }
    }

    /// Put in with a tool.
    #[must_use]
    pub fn with_tool(mut self, tool: impl Into<String>) -> Self {
        self.tools.push(tool.into());
        self
    }

    /// Article and size, as one asks for it.
    pub fn asked_for(&self) -> String {
        match &*self.size {
            "" => self.article.clone(),
            size => format!("{} {size}", self.article),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packs_are_whole_and_as_few_as_hold_all() {
        let pack = |amount| Pack { amount, unit: Unit::Piece };
        assert_eq!(pack(100.0).count(0.0), 0);
        assert_eq!(pack(100.0).count(1.0), 1);
        assert_eq!(pack(100.0).count(100.0), 1);
        assert_eq!(pack(100.0).count(101.0), 2);
        // Three tenths are not exactly three times a tenth.
        assert_eq!(pack(0.1).count(0.1 + 0.2), 3);
        assert_eq!(Order::of("screw", "M3x16").asked_for(), "screw M3x16");
        assert_eq!(Order::of("screw", "").asked_for(), "screw");
    }
}
