//! The guide as one HTML page, for screen and paper, without network access; only the 3D model needs scripts.

mod buy;
mod calibrate;
mod cover;
mod diff;
mod make;
mod mix;
mod print;
mod sheets;
mod steps;
mod time;
mod viewer;
mod wiring;

use std::collections::BTreeMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fabkit_report::{escape, page_with_style};

pub use viewer::{CameraRay, CameraRays, PressedSurface, ViewerModel};

use crate::{BodyUse, Guide};

pub use diff::PartImagePairs;

/// Images for the page, and the 3D model.
///
/// ```
/// # use fabkit_guide::{Guide, NoShop, Request};
/// use fabkit_guide::PageImages;
/// # let sensor = fabkit_checks::example::puck();
/// # let stages = fabkit_checks::stages(&sensor)?;
/// # let (density, shop, calibration) = (&|_: &str| None, &NoShop, None);
/// # let request = Request { design_hash: "00", units: 1, density, shop, stages: &stages, calibration };
/// let guide = Guide::new(&sensor, &request)?;
/// // Images become part of the page: "PNG" is UE5H in base64.
/// let images = PageImages { cover: Some(b"PNG".to_vec()), ..PageImages::default() };
/// assert!(guide.to_html(&images).contains("data:image/png;base64,UE5H"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct PageImages {
    /// Image of the finished sensor or fixture, PNG.
    pub cover: Option<Vec<u8>>,
    /// Images of each step that happens in an assembly, by its number.
    pub steps: BTreeMap<usize, StepImages>,
    /// Image of each part as it lies on the bed, PNG, by its name.
    pub parts: BTreeMap<String, Vec<u8>>,
    /// Drawing of each stock sheet as it is cut, SVG, by its title.
    pub sheets: BTreeMap<String, Vec<u8>>,
    /// Interactive 3D model.
    pub model: Option<ViewerModel>,
    /// Artwork of each circuit board, by its part's name.
    pub boards: BTreeMap<String, BoardArt>,
}

/// Images of a step, PNG.
#[derive(Clone, Debug, Default)]
pub struct StepImages {
    /// Image of the bodies that are moving in or out, with arrows.
    pub before: Option<Vec<u8>>,
    /// Image of the assembly afterwards.
    pub after: Option<Vec<u8>>,
}

/// Artwork of a circuit board.
#[derive(Clone, Debug)]
pub enum BoardArt {
    /// Upper and lower side as SVG.
    Drawn([String; 2]),
    /// Reason why the board could not be laid out.
    Refused(String),
}

/// Style rules in addition to those of reports: text columns aligned left, steps with their images, and no page break
/// within a row or step.
const STYLE: &str = "
td.word, th.word { text-align: left; } td.as-one { white-space: nowrap; } td.long { min-width: 15rem; } td img { width: 6rem; height: auto; display: block; }
.failed { border: 2px solid #b00020; border-radius: 6px; padding: .2rem 1rem; margin: 1rem 0; } .failed h2 { margin: .5rem 0; }
.cover { display: flex; flex-wrap: wrap; gap: 1.5rem; align-items: center; } .cover img { max-width: 100%; height: auto; }
dl { display: grid; grid-template-columns: max-content minmax(0, 1fr); gap: .2rem 1rem; margin: .4rem 0; min-width: 0; } dt { color: var(--quiet); } dd { margin: 0; overflow-wrap: anywhere; }
@media (max-width: 30rem) { dl { grid-template-columns: minmax(0, 1fr); gap: 0; } dd { margin: 0 0 .4rem; } }
.step { border: 1px solid var(--line); border-radius: 6px; padding: .2rem 1rem .6rem; margin: 1rem 0; break-inside: avoid; }
.step h3 { margin: .5rem 0; font-size: 1.05rem; } .step img { max-width: 100%; height: auto; } .shots { display: flex; flex-wrap: wrap; gap: .8rem; } .shots figure { margin: .3rem 0; flex: 0 1 21rem; } .typed pre, details pre { white-space: pre-wrap; margin: .2rem 0 .6rem; } .step ul { margin: 0; padding: 0; list-style: none; } .step input { transform: scale(1.3); margin-right: .6rem; }
.known { display: block; color: var(--quiet); font-size: .85em; } td.word { min-width: 6rem; }
.board { display: flex; flex-wrap: wrap; gap: 1rem; } .board svg { width: 22rem; max-width: 100%; height: auto; } .circuit { overflow-x: auto; } .circuit svg { max-width: 40rem; min-width: 36rem; } .circuit svg text { font-size: 12px; }
.sheet img { max-width: 100%; height: auto; }
img { background: #fff; border-radius: 4px; } nav a { margin-right: 1rem; } a { color: inherit; }
@page { margin: 14mm; }
@media print { nav { display: none; } .step { border-color: #999; } .step img { max-height: 60mm; width: auto; } .sheet img { max-height: 200mm; width: auto; } }
";

impl Guide {
    /// Returns the page.
    pub fn to_html(&self, images: &PageImages) -> String {
        let mut body = String::new();
        self.purchases(&mut body);
        self.parts(&mut body, images);
        self.prints(&mut body);
        self.sheets_to_cut(images, &mut body);
        self.wires(&mut body, images);
        self.mixtures(&mut body);
        self.times(&mut body);
        self.matrix(&mut body);
        if !self.steps.is_empty() {
            body += "<h2 id=\"steps\">Steps</h2>\n";
        }
        for step in &self.steps {
            self.step(&mut body, step, images);
        }
        self.calibrating(&mut body);
        // The cover is built last, because it links to the sections that exist.
        let cover = self.cover(&body, images);
        let section = images.model.as_ref().map_or(String::new(), ViewerModel::section);
        let script = images.model.as_ref().map_or(String::new(), |_| ViewerModel::script());
        let style = STYLE.to_owned() + viewer::STYLE;
        let page = cover + &section + &body + &script;
        page_with_style(&format!("Building {}", self.title), &style, &page)
    }
}

/// Formats a table whose first `words` columns are text.
fn table(heads: &[&str], words: usize, rows: impl Iterator<Item = String>) -> String {
    let head = heads.iter().enumerate().map(|(column, head)| {
        let class = if column < words { " class=\"word\"" } else { "" };
        format!("<th scope=\"col\"{class}>{}</th>", escape(head))
    });
    let rows: String = rows.map(|row| format!("<tr>{row}</tr>\n")).collect();
    format!(
        "<table><thead><tr>{}</tr></thead>\n<tbody>{rows}</tbody></table>\n",
        head.collect::<String>()
    )
}

/// Formats the head cell of a row.
fn name(text: &str) -> String {
    format!("<th scope=\"row\">{}</th>", escape(text))
}

/// Formats a text cell.
fn word(text: &str) -> String {
    format!("<td class=\"word\">{}</td>", escape(text))
}

/// Formats the cell that tells whether a piece is needed for each unit or once.
fn of(tool: BodyUse) -> &'static str {
    match tool {
        BodyUse::Sensor => "<td class=\"word as-one\">each unit</td>",
        BodyUse::Tool => "<td class=\"word as-one\">all units</td>",
    }
}

/// Formats links to steps.
fn steps(numbers: &[usize]) -> String {
    let links = numbers.iter().map(|number| format!("<a href=\"#step-{number}\">{number}</a>"));
    links.collect::<Vec<_>>().join(" ")
}

/// Embeds a PNG file as an image.
fn image(png: &[u8], alt: &str) -> String {
    format!(
        "<img alt=\"{}\" src=\"data:image/png;base64,{}\">\n",
        escape(alt),
        STANDARD.encode(png)
    )
}
