//! Licence and citation of a package.

use std::fmt::Write as _;

use fabkit_designs::{Design, design_hash};
use serde_json::json;

use super::Terms;

/// Licence with its SPDX identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct License {
    /// SPDX identifier.
    pub id: &'static str,
    /// Address of the licence text.
    pub url: &'static str,
}

/// Licences offered for designs. Identifiers and addresses are from SPDX's list.
pub const LICENSES: [License; 9] = [
    License { id: "CC-BY-4.0", url: "https://creativecommons.org/licenses/by/4.0/legalcode" },
    License { id: "CC-BY-SA-4.0", url: "https://creativecommons.org/licenses/by-sa/4.0/legalcode" },
    License { id: "CC-BY-NC-4.0", url: "https://creativecommons.org/licenses/by-nc/4.0/legalcode" },
    License { id: "CC0-1.0", url: "https://creativecommons.org/publicdomain/zero/1.0/legalcode" },
    License { id: "CERN-OHL-P-2.0", url: "https://spdx.org/licenses/CERN-OHL-P-2.0.html" },
    License { id: "CERN-OHL-S-2.0", url: "https://spdx.org/licenses/CERN-OHL-S-2.0.html" },
    License { id: "CERN-OHL-W-2.0", url: "https://spdx.org/licenses/CERN-OHL-W-2.0.html" },
    License { id: "MIT", url: "https://spdx.org/licenses/MIT.html" },
    License { id: "Apache-2.0", url: "https://www.apache.org/licenses/LICENSE-2.0" },
];

/// Default licence: use, change and sell with attribution. Chosen, because most labs publish drawings under it.
pub const DEFAULT_LICENSE: License = LICENSES[0];

impl License {
    /// Finds a licence by its identifier, ignoring case.
    ///
    /// ```
    /// use fabkit_application::packaging::{DEFAULT_LICENSE, License};
    /// assert_eq!(License::from_id("cc-by-4.0"), Some(DEFAULT_LICENSE));
    /// assert_eq!(License::from_id("all mine"), None);
    /// ```
    pub fn from_id(id: &str) -> Option<Self> {
        LICENSES.into_iter().find(|license| license.id.eq_ignore_ascii_case(id.trim()))
    }
}

impl Terms {
    pub(super) fn license_text(&self, design: &Design) -> String {
        let License { id, url } = self.license;
        let title = &design.sensor.title;
        let by = match &self.authors[..] {
            [] => String::new(),
            authors => format!("Authors: {}\n", authors.join(", ")),
        };
        format!(
            "{title}: build package\n{by}\nSPDX-License-Identifier: {id}\n\nThese files may be used on the terms \
             of {id}, whose text is at\n{url}\n\nThey come without any warranty. The sensor follows a publication \
             that CITATION.cff names;\nwhat others hold in it is not given by these terms.\n"
        )
    }

    /// Writes the citation in the Citation File Format 1.2.0.
    pub(super) fn citation(&self, design: &Design) -> String {
        let sensor = &design.sensor;
        // A JSON string is a valid YAML string.
        let quoted = |text: &str| json!(text).to_string();
        let mut text = String::from("cff-version: 1.2.0\n");
        let mut line = |key: &str, value: &str| {
            let _ = writeln!(text, "{key}: {}", quoted(value));
        };
        line("message", "If you build this sensor, please cite the publication it follows.");
        text += "type: dataset\n";
        // A new closure, because the first one borrowed the text that was extended in between.
        let mut line = |key: &str, value: &str| {
            let _ = writeln!(text, "{key}: {}", quoted(value));
        };
        line("title", &format!("{}: build package", sensor.title));
        line("version", &design_hash(design)[..12]);
        line("license", self.license.id);
        text += "authors:\n";
        if self.authors.is_empty() {
            let _ = writeln!(text, "  - name: {}", quoted(&format!("Makers of {}", sensor.title)));
        }
        for author in citation_authors(&self.authors) {
            let _ = writeln!(text, "  - name: {}", quoted(&author));
        }
        if sensor.reference.is_empty() {
            return text;
        }
        let Reference { authors, title, arxiv } = Reference::parse(&sensor.reference);
        let _ = writeln!(text, "references:\n  - type: article\n    title: {}", quoted(title));
        text += "    authors:\n";
        for author in citation_authors(&authors) {
            let _ = writeln!(text, "      - name: {}", quoted(&author));
        }
        let _ = writeln!(text, "    notes: {}", quoted(&sensor.reference));
        if let Some(arxiv) = arxiv {
            let url = format!("https://arxiv.org/abs/{arxiv}");
            let _ = writeln!(text, "    url: {}", quoted(&url));
        }
        text
    }
}

/// Prepares a list of authors for the format. It forbids equal entries; if two people share a surname, the whole list
/// is therefore written as one entry.
fn citation_authors<S: AsRef<str>>(names: &[S]) -> Vec<String> {
    let mut list: Vec<String> = names.iter().map(|name| name.as_ref().to_owned()).collect();
    let repeats = (1..list.len()).any(|i| list[..i].contains(&list[i]));
    if repeats {
        list = vec![list.join(", ")];
    }
    list
}

/// Parts of a reference text `after A, B et al.: TITLE, JOURNAL YEAR, arXiv NUMBER`.
struct Reference<'a> {
    authors: Vec<&'a str>,
    title: &'a str,
    arxiv: Option<&'a str>,
}

impl<'a> Reference<'a> {
    fn parse(text: &'a str) -> Self {
        let (names, title) = text.split_once(": ").unwrap_or((text, text));
        let names = names.strip_prefix("after ").unwrap_or(names);
        let pieces = names.split(", ").flat_map(|piece| piece.split(" and "));
        let authors = pieces.map(str::trim).filter(|piece| !piece.is_empty()).collect();
        let number = |rest: &'a str| {
            let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
            rest[..end].trim_end_matches('.')
        };
        let arxiv = text.split_once("arXiv ").map(|(_, rest)| number(rest));
        Self { authors, title, arxiv: arxiv.filter(|number| number.contains('.')) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_are_taken_apart() {
        let text = "after Lin, Zhang and Xu: A sensor: small, IEEE RA-L 2023, arXiv 2308.14277";
        let Reference { authors, title, arxiv } = Reference::parse(text);
        assert_eq!(authors, ["Lin", "Zhang", "Xu"]);
        assert_eq!(title, "A sensor: small, IEEE RA-L 2023, arXiv 2308.14277");
        assert_eq!(arxiv, Some("2308.14277"));
        let plain = Reference::parse("our own");
        assert_eq!((plain.authors, plain.title, plain.arxiv), (vec!["our own"], "our own", None));
    }

    #[test]
    fn no_two_authors_are_equal() {
        assert_eq!(citation_authors(&["Lin", "Xu", "Wu"]), ["Lin", "Xu", "Wu"]);
        assert_eq!(citation_authors(&["Lin", "Xu", "Wu", "Xu"]), ["Lin, Xu, Wu, Xu"]);
    }

    #[test]
    fn licences_are_found_in_any_case() {
        assert_eq!(License::from_id(" cc0-1.0"), Some(LICENSES[3]));
        assert_eq!(License::from_id("mine"), None);
        assert_eq!(DEFAULT_LICENSE.id, "CC-BY-4.0");
    }
}
