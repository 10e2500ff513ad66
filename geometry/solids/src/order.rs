//! Orders of bought bodies.

/// Unit of quantity of a pack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuantityUnit {
    /// Pieces.
    Piece,
    /// Mass, g.
    Gram,
    /// Volume, ml.
    Millilitre,
    /// Length, mm.
    Millimetre,
}

impl QuantityUnit {
    /// Returns the symbol or word for texts.
    pub fn word(self) -> &'static str {
        match self {
            Self::Piece => "pieces",
            Self::Gram => "g",
            Self::Millilitre => "ml",
            Self::Millimetre => "mm",
        }
    }
}

/// Smallest quantity that is sold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pack {
    /// Quantity, in `unit`; more than 0.
    pub amount: f64,
    /// Unit of quantity.
    pub unit: QuantityUnit,
}

impl Pack {
    /// Computes the number of packs that contain the needed quantity, in the pack's unit.
    ///
    /// ```
    /// use fabkit_geometry::{Pack, QuantityUnit};
    /// let screws = Pack { amount: 100.0, unit: QuantityUnit::Piece };
    /// assert_eq!([0.0, 1.0, 100.0, 101.0].map(|needed| screws.count(needed)), [0, 1, 1, 2]);
    /// ```
    pub fn count(self, needed: f64) -> u32 {
        // Computed quantities carry rounding errors: ten times 0.1 must fit a pack of 1.
        const ROUNDING: f64 = 1e-9;
        (needed / self.amount - ROUNDING).ceil().max(0.0) as u32
    }
}

/// Placeholder for a manufacturer or part number that is unknown or does not matter.
pub const UNSPECIFIED: &str = "any";

/// Order of a bought body: article, size, and its data from the catalogue.
///
/// The designer of a body gives article and size; one place fills in the rest from the catalogue.
///
/// ```
/// use fabkit_geometry::{Order, UNSPECIFIED};
/// let screw = Order::new("pan head screw ISO 7045", "M3x16").with_tool("screwdriver PH1");
/// assert_eq!(screw.article_and_size(), "pan head screw ISO 7045 M3x16");
/// assert_eq!((&*screw.maker, screw.price_eur), (UNSPECIFIED, None)); // the catalogue says more
/// let tube = Order::new("silicone tube", "2x4").cut_to(35.0);
/// assert_eq!(tube.length_mm, Some(35.0));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// Article name in the catalogue: `pan head screw ISO 7045`.
    pub article: String,
    /// Size: `M3x16`; empty if there is only one.
    pub size: String,
    /// Length taken by one piece of an article that is sold by length, mm.
    pub length_mm: Option<f64>,
    /// True if nothing has to be bought because it is the sensor itself.
    pub is_sensor_itself: bool,
    /// Tools needed to install it: `screwdriver PH1`.
    pub tools: Vec<String>,
    /// Manufacturer; [`UNSPECIFIED`] where that does not matter.
    pub maker: String,
    /// Manufacturer's name or number of the article; [`UNSPECIFIED`] if there is none.
    pub number: String,
    /// Standard that the article follows, if any.
    pub standard: Option<String>,
    /// Relevant data by name: `forward voltage`, `2.9 V, typical`.
    pub figures: Vec<(String, String)>,
    /// Smallest quantity that is sold.
    pub pack: Pack,
    /// Length and width of an article that is sold as sheets, mm.
    pub sheet_mm: Option<[f64; 2]>,
    /// Name of the kit that several articles are sold in together: both components of a silicone are one kit and paid
    /// for once.
    pub kit: Option<String>,
    /// Price of a pack, or of the whole kit, EUR; `None` if unknown.
    pub price_eur: Option<f64>,
    /// Possible substitutes; empty if none are known.
    pub substitutes: String,
    /// Source of the data except the price.
    pub source: String,
    /// Source of the price; empty if the price is unknown.
    pub price_source: String,
}

impl Order {
    /// Creates the order of an article in a size, without catalogue data.
    pub fn new(article: impl Into<String>, size: impl Into<String>) -> Self {
        Self {
            article: article.into(),
            size: size.into(),
            length_mm: None,
            is_sensor_itself: false,
            tools: Vec::new(),
            maker: UNSPECIFIED.into(),
            number: UNSPECIFIED.into(),
            standard: None,
            figures: Vec::new(),
            pack: Pack { amount: 1.0, unit: QuantityUnit::Piece },
            sheet_mm: None,
            kit: None,
            price_eur: None,
            substitutes: String::new(),
            source: "the design alone".into(),
            price_source: String::new(),
        }
    }

    /// Creates the order entry of the sensor itself that a fixture is made for; it is not bought.
    pub fn for_sensor_itself() -> Self {
        Self {
            is_sensor_itself: true,
            source: "this design is made for it".into(),
            ..Self::new("the sensor itself", "")
        }
    }

    /// Sets the length of each piece that is cut from an article sold by length, mm.
    #[must_use]
    pub fn cut_to(self, length_mm: f64) -> Self {
        Self { length_mm: Some(length_mm), ..self }
    }

    /// Adds a tool needed to install it.
    #[must_use]
    pub fn with_tool(mut self, tool: impl Into<String>) -> Self {
        self.tools.push(tool.into());
        self
    }

    /// Returns article and size in one string.
    pub fn article_and_size(&self) -> String {
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
        let pack = |amount| Pack { amount, unit: QuantityUnit::Piece };
        assert_eq!(pack(100.0).count(0.0), 0);
        assert_eq!(pack(100.0).count(1.0), 1);
        assert_eq!(pack(100.0).count(100.0), 1);
        assert_eq!(pack(100.0).count(101.0), 2);
        // Three tenths are not exactly three times a tenth.
        assert_eq!(pack(0.1).count(0.1 + 0.2), 3);
        assert_eq!(Order::new("screw", "M3x16").article_and_size(), "screw M3x16");
        assert_eq!(Order::new("screw", "").article_and_size(), "screw");
    }
}
