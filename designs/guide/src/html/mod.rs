//! The guide as one page: no network, on screen and on paper; only the model needs script.

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

pub use viewer::{Model, Pressed, Rays, SeenRay};

use crate::{Guide, Tool};

pub use diff::Pairs;

/// PNG files for the page, and the model.
#[derive(Clone, Debug, Default)]
pub struct Pictures {
    /// The finished sensor or fixture.
    pub cover: Option<Vec<u8>>,
    /// Each step that happens in an assembly, by its number.
    pub steps: BTreeMap<usize, StepPictures>,
    /// Each part as it lies on the bed, by its name.
    pub parts: BTreeMap<String, Vec<u8>>,
    /// Each stock sheet as it is cut, SVG by its title.
    pub sheets: BTreeMap<String, Vec<u8>>,
    /// What the reader can turn.
    pub model: Option<Model>,
    /// Each circuit board, by its part's name.
    pub boards: BTreeMap<String, BoardArt>,
}

/// A step.
#[derive(Clone, Debug, Default)]
pub struct StepPictures {
    /// What is on its way, with arrows.
    pub before: Option<Vec<u8>>,
    /// What stands there afterwards.
    pub after: Option<Vec<u8>>,
}

/// A circuit board as it will look.
#[derive(Clone, Debug)]
pub enum BoardArt {
    /// Upper and lower side as SVG.
    Drawn([String; 2]),
    /// Why there is none.
    Refused(String),
}

/// Beside the report's: words to the left, steps with their pictures, one row or step never cut by paper's edge.
const STYLE: &str = "
td.word, th.word { text-align: left; } td.as-one { white-space: nowrap; } td.long { min-width: 15rem; } td img { width: 6rem; height: auto; display: block; }
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
    /// The page.
    pub fn to_html(&self, pictures: &Pictures) -> String {
        let mut body = String::new();
        self.purchases(&mut body);
        self.parts(&mut body, pictures);
        self.prints(&mut body);
        self.sheets_to_cut(pictures, &mut body);
        self.wires(&mut body, pictures);
        self.mixtures(&mut body);
        self.times(&mut body);
        self.matrix(&mut body);
        if !self.steps.is_empty() {
            body += "<h2 id=\"steps\">Steps</h2>\n";
        }
        for step in &self.steps {
            self.step(&mut body, step, pictures);
        }
        self.calibrating(&mut body);
        let cover = self.cover(&body, pictures);
        let section = pictures.model.as_ref().map_or(String::new(), Model::section);
        let script = pictures.model.as_ref().map_or(String::new(), |_| Model::script());
        let style = STYLE.to_owned() + viewer::STYLE;
        let page = cover + &section + &body + &script;
        page_with_style(&format!("Building {}", self.title), &style, &page)
    }
}

/// A table whose first `words` columns are text.
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

fn name(text: &str) -> String {
    format!("<th scope=\"row\">{}</th>", escape(text))
}

fn word(text: &str) -> String {
    format!("<td class=\"word\">{}</td>", escape(text))
}

fn of(tool: Tool) -> &'static str {
    match tool {
        Tool::Sensor => "<td class=\"word as-one\">each unit</td>",
        Tool::Tool => "<td class=\"word as-one\">all units</td>",
    }
}

fn steps(numbers: &[usize]) -> String {
    let links = numbers.iter().map(|number| format!("<a href=\"#step-{number}\">{number}</a>"));
    links.collect::<Vec<_>>().join(" ")
}

fn image(png: &[u8], alt: &str) -> String {
    format!(
        "<img alt=\"{}\" src=\"data:image/png;base64,{}\">\n",
        escape(alt),
        STANDARD.encode(png)
    )
}
