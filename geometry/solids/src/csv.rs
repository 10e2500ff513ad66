//! Tables of comma-separated values, for spreadsheets and scripts.
//!
//! All tables that fabkit writes are made here, in the crate that every other uses. Names in them come from files that
//! somebody else may have written, and a spreadsheet runs cells that begin with `=`, `+`, `-` or `@`.

use std::fmt::Write as _;

/// Characters at the beginning of a cell that make a spreadsheet compute it, in their usual and their full width.
const FORMULA_SIGNS: [char; 8] = ['=', '+', '-', '@', '＝', '＋', '－', '＠'];

/// One cell: a number, or text that no spreadsheet takes for a formula.
///
/// ```
/// use fabkit_geometry::csv::CsvCell;
///
/// assert_eq!(CsvCell::text("=1+1").as_str(), "\"'=1+1\"");
/// assert_eq!(CsvCell::text("gel, clear").as_str(), "\"gel, clear\"");
/// assert_eq!(CsvCell::fixed(-0.26, 1).as_str(), "-0.3");
/// // A number that is written as text is no formula.
/// assert_eq!(CsvCell::text("-0.25").as_str(), "-0.25");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CsvCell(String);

impl CsvCell {
    /// Creates a cell of text. It is quoted where that is necessary; an apostrophe in front of what would be a formula
    /// makes it text for spreadsheets (as OWASP advises against CSV injection).
    pub fn text(text: &str) -> Self {
        let is_formula = is_formula(text);
        if is_formula || text.contains([',', '"', '\n', '\r']) {
            Self::quoted(text)
        } else {
            Self(text.to_owned())
        }
    }

    /// Creates a cell of text that is quoted in any case.
    pub fn quoted(text: &str) -> Self {
        let apostrophe = if is_formula(text) { "'" } else { "" };
        Self(format!("\"{apostrophe}{}\"", text.replace('"', "\"\"")))
    }

    /// Creates a cell with a number, in the fewest digits that read back as the same.
    pub fn number(number: f64) -> Self {
        Self(number.to_string())
    }

    /// Creates a cell with a number, rounded to so many decimals.
    pub fn fixed(number: f64, decimals: usize) -> Self {
        Self(format!("{number:.decimals$}"))
    }

    /// Creates a cell with a whole number.
    pub fn count(count: impl TryInto<i128>) -> Self {
        // All whole numbers of the standard library but the largest u128 fit.
        Self(count.try_into().map_or_else(|_| String::new(), |count: i128| count.to_string()))
    }

    /// Creates a cell with nothing in it.
    pub fn empty() -> Self {
        Self(String::new())
    }

    /// Returns the cell as it stands in a file.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl From<&str> for CsvCell {
    fn from(text: &str) -> Self {
        Self::text(text)
    }
}

impl From<&String> for CsvCell {
    fn from(text: &String) -> Self {
        Self::text(text)
    }
}

impl From<f64> for CsvCell {
    fn from(number: f64) -> Self {
        Self::number(number)
    }
}

impl From<usize> for CsvCell {
    fn from(count: usize) -> Self {
        Self::count(count as i128)
    }
}

impl From<u32> for CsvCell {
    fn from(count: u32) -> Self {
        Self::count(count)
    }
}

impl<T: Into<Self>> From<Option<T>> for CsvCell {
    fn from(cell: Option<T>) -> Self {
        cell.map_or_else(Self::empty, Into::into)
    }
}

/// Returns whether a spreadsheet would run the text: what is a number is none. White space in front hides no sign.
fn is_formula(text: &str) -> bool {
    let begins_with_sign = text.trim_start().starts_with(FORMULA_SIGNS);
    let is_steering = text.starts_with(['\t', '\r', '\n']);
    (begins_with_sign || is_steering) && text.parse::<f64>().is_err()
}

/// Table of comma-separated values (RFC 4180, but with Unix line ends).
///
/// ```
/// use fabkit_geometry::csv::{CsvCell, CsvTable};
///
/// let mut table = CsvTable::new("name,depth_mm");
/// table.row([CsvCell::text("+ball"), CsvCell::fixed(1.5, 2)]);
/// table.row(["pin, long".into(), 0.1.into()]);
/// assert_eq!(table.finish(), "name,depth_mm\n\"'+ball\",1.50\n\"pin, long\",0.1\n");
/// ```
#[derive(Clone, Debug)]
pub struct CsvTable {
    text: String,
}

impl CsvTable {
    /// Creates a table from the names of its columns, which have no commas.
    pub fn new(heads: &'static str) -> Self {
        Self { text: format!("{heads}\n") }
    }

    /// Creates a table from names of columns that are not known before.
    pub fn with_heads<'a>(heads: impl IntoIterator<Item = &'a str>) -> Self {
        let mut table = Self { text: String::new() };
        table.row(heads.into_iter().map(CsvCell::text));
        table
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = CsvCell>) {
        for (i, CsvCell(cell)) in cells.into_iter().enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(self.text, "{}{cell}", if i == 0 { "" } else { "," });
        }
        self.text.push('\n');
    }

    /// Returns the table as text, with a final newline.
    pub fn finish(self) -> String {
        self.text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_is_a_formula_and_numbers_stay_numbers() {
        let hostile = [
            "=1+1",
            "+cmd|' /C calc'!A0",
            "-2+3",
            "@SUM(A1)",
            "\t=1",
            " =1",
            "＝1",
            "\r=1",
            "\n=1",
        ];
        for text in hostile {
            for cell in [CsvCell::text(text), CsvCell::quoted(text)] {
                assert!(cell.as_str().starts_with("\"'"), "{text:?}: {cell:?}");
            }
        }
        for text in ["-1.5", "+2", "-1e-9", "pin-dome", "a=b", "3 mm"] {
            assert_eq!(CsvCell::text(text).as_str(), text);
        }
        for cell in [CsvCell::from(-1.5), CsvCell::fixed(-1.5, 1)] {
            assert_eq!(cell.as_str(), "-1.5");
        }
        assert_eq!(CsvCell::from(None::<f64>), CsvCell::empty());
        assert_eq!(CsvCell::from(7_usize).as_str(), "7");
    }

    #[test]
    fn texts_read_back_as_they_were() {
        let quoted = CsvCell::text("a \"b\"\nc");
        assert_eq!(quoted.as_str(), "\"a \"\"b\"\"\nc\"");
    }
}
