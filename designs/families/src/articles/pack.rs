//! Pack sizes: the amount that is sold at once.

use fabkit_geometry::{Pack, QuantityUnit};
use fabkit_text::{Json, Refusal, Scalar, ValueKind};

use crate::materials::split_number;

/// Units as they may be written, each with its base unit and its size in that.
const UNITS: [(&str, QuantityUnit, f64); 9] = [
    ("pieces", QuantityUnit::Piece, 1.0),
    ("piece", QuantityUnit::Piece, 1.0),
    ("g", QuantityUnit::Gram, 1.0),
    ("kg", QuantityUnit::Gram, 1e3),
    ("ml", QuantityUnit::Millilitre, 1.0),
    ("l", QuantityUnit::Millilitre, 1e3),
    ("mm", QuantityUnit::Millimetre, 1.0),
    ("cm", QuantityUnit::Millimetre, 10.0),
    ("m", QuantityUnit::Millimetre, 1e3),
];

/// Smallest and largest content of a pack, in its base unit.
const LIMITS: std::ops::RangeInclusive<f64> = 1e-3..=1e7;

const EXAMPLE: &str = "write for example `100 pieces`, `0.9 kg`, `500 ml` or `5 m`";

/// Amount sold at once, as written: `100 pieces`, `0.9 kg`.
///
/// ```
/// use fabkit_designs::articles::PackSize;
/// use fabkit_designs::parameters::Scalar;
/// let read = |text| PackSize::parse(text).map_err(|refusal| refusal.says);
/// assert_eq!(read("0.9 kg")?.show(), "900 g");
/// assert_eq!(read("5 m")?.show(), "5000 mm");
/// assert!(read("5 oz").is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackSize(pub Pack);

impl Scalar for PackSize {
    const KIND: ValueKind = ValueKind::Text;
    type Limits = ();

    fn parse(text: &str) -> Result<Self, Refusal> {
        let refuse = |says: &str| Err(Refusal::new(says, EXAMPLE));
        let Some((number, unit)) = split_number(text) else {
            return refuse("is no number with a unit");
        };
        let Some((_, unit, size)) = UNITS.iter().find(|(known, ..)| *known == unit) else {
            return refuse("is in no unit that packs are sold in");
        };
        let amount = number * size;
        if !LIMITS.contains(&amount) {
            return refuse("is more or less than any pack");
        }
        Ok(Self(Pack { amount, unit: *unit }))
    }

    fn is_within(&self, (): &()) -> bool {
        true
    }

    fn nearest(&self, (): &()) -> Option<Self> {
        None
    }

    fn show(&self) -> String {
        format!("{} {}", self.0.amount, self.0.unit.word())
    }

    fn allowed((): &()) -> String {
        "pieces, g, kg, ml, l, mm, cm or m".into()
    }

    fn schema((): &()) -> Json {
        let units: Vec<&str> = UNITS.iter().map(|(unit, ..)| *unit).collect();
        let pattern = format!("^[0-9.]+ *({})$", units.join("|"));
        Json::from_iter([("type", "string"), ("pattern", &pattern)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packs_are_read_in_the_units_that_shops_use() {
        let read = |text| <PackSize as Scalar>::parse(text).map(|p| p.show()).map_err(|e| e.says);
        assert_eq!(read("100 pieces").as_deref(), Ok("100 pieces"));
        assert_eq!(read("0.9 kg").as_deref(), Ok("900 g"));
        assert_eq!(read("5 m").as_deref(), Ok("5000 mm"));
        assert_eq!(read("1 l").as_deref(), Ok("1000 ml"));
        assert_eq!(read("5").unwrap_err(), "is in no unit that packs are sold in");
        assert_eq!(read("5 oz").unwrap_err(), "is in no unit that packs are sold in");
        assert_eq!(read("0 g").unwrap_err(), "is more or less than any pack");
        assert_eq!(read("-4 g").unwrap_err(), "is more or less than any pack");
        assert_eq!(read("many").unwrap_err(), "is no number with a unit");
    }
}
