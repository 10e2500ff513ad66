//! The guide as one page: no network, no script, on screen and on paper.

use std::collections::BTreeMap;
use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fabkit_report::{Svg, escape, page_with_style};

use crate::{Guide, GuideStep, Made, Mixed, Need, Timeline, Tool};

/// PNG files for the page.
#[derive(Clone, Debug, Default)]
pub struct Pictures {
    /// The finished sensor or fixture.
    pub cover: Option<Vec<u8>>,
    /// What stands together, cut open, by the assembly's name.
    pub assemblies: BTreeMap<String, Vec<u8>>,
    /// Each part as it lies on the bed, by its name.
    pub parts: BTreeMap<String, Vec<u8>>,
}

/// Beside the report's: words to the left, steps with their pictures, one row or step never cut by paper's edge.
const STYLE: &str = "
td.word, th.word { text-align: left; } td.as-one { white-space: nowrap; } td.long { min-width: 15rem; } td img { width: 6rem; height: auto; display: block; }
.cover { display: flex; flex-wrap: wrap; gap: 1.5rem; align-items: center; } .cover img { max-width: 100%; height: auto; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .2rem 1rem; margin: .4rem 0; } dt { color: var(--quiet); } dd { margin: 0; }
.step { border: 1px solid var(--line); border-radius: 6px; padding: .2rem 1rem .6rem; margin: 1rem 0; break-inside: avoid; }
.step h3 { margin: .5rem 0; font-size: 1.05rem; } .step img { max-width: 100%; height: auto; } .step input { transform: scale(1.3); margin-right: .6rem; }
img { background: #fff; border-radius: 4px; } nav a { margin-right: 1rem; } a { color: inherit; }
@media print { nav { display: none; } .step { border-color: #999; } }
";

/// Letters of the design's hash that tell it from others at a glance.
const HASH_SHOWN: usize = 12;

impl Guide {
    /// The page.
    pub fn to_html(&self, pictures: &Pictures) -> String {
        let mut body = String::new();
        self.purchases(&mut body);
        self.parts(&mut body, pictures);
        self.mixtures(&mut body);
        self.times(&mut body);
        self.matrix(&mut body);
        if !self.steps.is_empty() {
            body += "<h2 id=\"steps\">Steps</h2>\n";
        }
        let mut shown = Vec::new();
        for step in &self.steps {
            self.step(&mut body, step, pictures, &mut shown);
        }
        let page = self.cover(&body, pictures) + &body;
        page_with_style(&format!("Building {}", self.title), STYLE, &page)
    }

    /// The cover, with jumps to those parts of the page that there are.
    fn cover(&self, page: &str, pictures: &Pictures) -> String {
        let mut body = "<nav aria-label=\"contents\">".to_owned();
        for jump in ["Buy", "Make", "Mix", "Time", "Steps"] {
            let id = jump.to_lowercase();
            if page.contains(&format!("id=\"{id}\"")) {
                let _ = write!(body, "<a href=\"#{id}\">{jump}</a>");
            }
        }
        body += "</nav>\n<div class=\"cover\">\n";
        if let Some(png) = &pictures.cover {
            body += &image(png, &format!("{} as it is drawn", self.title));
        }
        let rows = [
            (
                "Design",
                format!(
                    "{} ({})",
                    self.name,
                    &self.design_hash[..HASH_SHOWN.min(self.design_hash.len())]
                ),
            ),
            ("After", self.reference.clone()),
            ("For", format!("{} {}", self.units, if self.units == 1 { "unit" } else { "units" })),
            ("Parts to make", self.made.iter().map(|part| part.quantity).sum::<u32>().to_string()),
            (
                "Pieces to buy",
                self.bought.iter().map(|piece| piece.quantity).sum::<u32>().to_string(),
            ),
            ("Steps", self.steps.len().to_string()),
            (
                "From parts to a cured unit",
                format!("{:.0} h: {} days", self.timeline.total_h, self.timeline.days),
            ),
        ];
        body += "<dl>";
        for (term, text) in rows.iter().filter(|(_, text)| !text.is_empty()) {
            let _ = write!(body, "<dt>{term}</dt><dd>{}</dd>", escape(text));
        }
        body + "</dl>\n</div>\n"
    }

    fn purchases(&self, body: &mut String) {
        *body += "<h2 id=\"buy\">What to buy</h2>\n";
        if self.bought.is_empty() && self.liquids.is_empty() {
            *body += "<p>Nothing: all of it is printed.</p>\n";
            return;
        }
        if !self.bought.is_empty() {
            let rows = self.bought.iter().map(|piece| {
                let cells = [name(&piece.name), word(&piece.what), of(piece.of).to_owned()];
                format!(
                    "{}<td>{}</td><td>{}</td>",
                    cells.concat(),
                    piece.quantity,
                    steps(&piece.steps)
                )
            });
            *body += &table(&["piece", "what to order", "for", "n", "steps"], 3, rows);
        }
        if !self.liquids.is_empty() {
            *body += "<p>What is mixed, with the waste of cups and vents; packs are larger.</p>\n";
            let rows = self.liquids.iter().map(|liquid| {
                format!(
                    "{}<td>{:.2} g</td><td>{}</td>",
                    name(&liquid.name),
                    liquid.mass_g,
                    steps(&liquid.steps)
                )
            });
            *body += &table(&["component", "mass", "steps"], 1, rows);
        }
    }

    fn parts(&self, body: &mut String, pictures: &Pictures) {
        *body += "<h2 id=\"make\">What to make</h2>\n";
        let row = |part: &Made| {
            let picture = pictures.parts.get(&part.name);
            let picture = picture.map_or(String::new(), |png| {
                image(png, &format!("{} as it lies on the bed", part.name))
            });
            let [x, y, z] = part.size_mm;
            let mass =
                part.mass_g.map_or("not known".to_owned(), |mass_g| format!("{mass_g:.1} g"));
            let notes = part.notes.iter().map(|note| escape(note)).collect::<Vec<_>>().join("<br>");
            format!(
                "{}<td class=\"word\">{picture}</td>{}{}<td>{}</td><td class=\"as-one\">{x:.1} × {y:.1} × {z:.1} mm</td><td>{mass}</td>\
                 <td class=\"word long\">{}{}{notes}</td>",
                name(&part.name),
                word(&format!("{}, {}", part.process, part.material)),
                of(part.of),
                part.quantity,
                escape(&part.summary),
                if notes.is_empty() { "" } else { "<br>" },
            )
        };
        let heads = [
            "part",
            "on the bed",
            "made",
            "for",
            "n",
            "size",
            "mass, solid",
            "what it is, and what to mind",
        ];
        *body += &table(&heads, 4, self.made.iter().map(row));
        *body += "<p>Sizes as it lies on the bed. Masses are of solid parts, by fabkit's model; a slicer knows what infill saves.</p>\n";
    }

    fn mixtures(&self, body: &mut String) {
        if self.mixes.is_empty() {
            return;
        }
        *body += "<h2 id=\"mix\">What to mix</h2>\n";
        let row = |mix: &Mixed| {
            let components = mix.components.iter();
            let weighed = components.map(|c| format!("{:.2} g {}", c.mass_g, escape(&c.name)));
            let degas = if mix.degas { "degas" } else { "" };
            let cure = match mix.cure_h {
                0.0 => "with what follows".to_owned(),
                hours => format!("{hours} h at {} °C", mix.cure_celsius),
            };
            format!(
                "<td><a href=\"#step-{0}\">{0}</a></td><td class=\"word\">{1}</td><td class=\"word as-one\">{2}</td><td>{3}</td>\
                 <td>{4:.2} cm3 + {5:.0} %</td><td class=\"word\">{degas}</td><td>{cure}</td>",
                mix.step,
                escape(&mix.layer),
                weighed.collect::<Vec<_>>().join("<br>"),
                mix.batches,
                mix.volume_mm3 / 1e3,
                100.0 * mix.waste,
            )
        };
        let heads = ["step", "becomes", "one batch", "batches", "volume + waste", "air", "cure"];
        *body += &table(&heads, 3, self.mixes.iter().map(row));
    }

    fn times(&self, body: &mut String) {
        if self.timeline.stretches.is_empty() {
            return;
        }
        let _ = write!(
            body,
            "<h2 id=\"time\">When</h2>\n<figure>{}<figcaption>One unit, {:.0} h from the first step: hands dark, cures \
             light; framed is what the whole build waits for. Hands-on times are {}.</figcaption></figure>\n",
            self.chart(),
            self.timeline.total_h,
            escape(self.timeline.hands_on),
        );
    }

    /// Pours and cures along time.
    fn chart(&self) -> String {
        const ROW: f64 = 18.0;
        const LEFT: f64 = 230.0;
        const WIDTH: f64 = 880.0;
        let Timeline { stretches, total_h, .. } = &self.timeline;
        let timed: Vec<_> = stretches.iter().filter(|s| s.end_h > s.start_h).collect();
        let height = ROW * (timed.len() as f64 + 1.5);
        let mut svg = Svg::new(WIDTH, height);
        let scale = (WIDTH - LEFT - 10.0) / total_h.max(1.0);
        let days = (total_h / 24.0).floor() as u32;
        for day in 0..=days {
            let x = LEFT + f64::from(day) * 24.0 * scale;
            svg.line([x, 0.0], [x, height - ROW], "stroke=\"#e3e3e3\"");
            svg.text([x, height - 4.0], "middle", &format!("day {}", day + 1));
        }
        for (row, stretch) in timed.iter().enumerate() {
            let y = row as f64 * ROW;
            let step = &self.steps[stretch.step - 1];
            svg.text([LEFT - 8.0, y + 13.0], "end", &format!("{} {}", step.number, step.name));
            let x = |h: f64| LEFT + h * scale;
            let frame =
                if stretch.is_critical { "stroke=\"#c0392b\" stroke-width=\"1.5\"" } else { "" };
            let bar = |from: f64, to: f64| [(x(to) - x(from)).max(2.0), ROW - 5.0];
            svg.rect(
                [x(stretch.start_h), y + 3.0],
                bar(stretch.start_h, stretch.end_h),
                &format!("fill=\"#9db8d6\" {frame}"),
            );
            svg.rect(
                [x(stretch.start_h), y + 3.0],
                bar(stretch.start_h, stretch.hands_end_h),
                "fill=\"#1f4e79\"",
            );
        }
        svg.finish("the steps along time")
    }

    /// Which part is needed in which step.
    fn matrix(&self, body: &mut String) {
        if self.steps.is_empty() {
            return;
        }
        *body += "<h2>Which piece in which step</h2>\n";
        let rows = self.made.iter().map(|part| (&part.name, &part.steps));
        let rows = rows.chain(self.bought.iter().map(|piece| (&piece.name, &piece.steps)));
        let row = |(piece, needed): (&String, &Vec<usize>)| {
            let cells = self.steps.iter().map(|step| match needed.contains(&step.number) {
                true => format!("<td>{}</td>", step.number),
                false => "<td></td>".to_owned(),
            });
            name(piece) + &cells.collect::<String>()
        };
        let numbers: Vec<String> = self.steps.iter().map(|step| step.number.to_string()).collect();
        let heads: Vec<&str> =
            std::iter::once("piece").chain(numbers.iter().map(String::as_str)).collect();
        *body += &table(&heads, 1, rows.map(row));
    }

    fn step<'a>(
        &'a self,
        body: &mut String,
        step: &'a GuideStep,
        pictures: &Pictures,
        shown: &mut Vec<&'a str>,
    ) {
        let _ = write!(
            body,
            "<section class=\"step\" id=\"step-{0}\"><h3><label><input type=\"checkbox\">{0}. {1}</label></h3>\n<p>{2}</p>\n",
            step.number,
            escape(&step.name),
            escape(&sentence(&step.instruction)),
        );
        if let Some(assembly) = step.assembly.as_deref() {
            match pictures.assemblies.get(assembly) {
                // Once is enough: what stands there is drawn as it is when all is in its place.
                Some(png) if !shown.contains(&assembly) => {
                    shown.push(assembly);
                    *body +=
                        &image(png, &format!("{assembly}, cut open, with everything in its place"));
                }
                _ => {}
            }
        }
        let mix = self.mixes.iter().find(|mix| mix.step == step.number).map(|mix| {
            let parts = mix.components.iter().map(|c| format!("{:.2} g {}", c.mass_g, c.name));
            let degas = if mix.degas { ", then draw the air out" } else { "" };
            format!("{}{degas}", parts.collect::<Vec<_>>().join(" + "))
        });
        let stretch = &self.timeline.stretches[step.number - 1];
        let cures = stretch.end_h - stretch.hands_end_h;
        let rows = [
            ("Together in", step.assembly.clone().unwrap_or_default()),
            ("Takes", step.needs.iter().map(needed).collect::<Vec<_>>().join(", ")),
            ("Mix", mix.unwrap_or_default()),
            ("Take off", step.removed.join(", ")),
            ("Set right", step.adjusted.join(", ")),
            (
                "Meanwhile",
                step.during.map_or(String::new(), |number| format!("step {number} cures")),
            ),
            ("Then wait", if cures > 0.0 { format!("{cures} h") } else { String::new() }),
            ("Source", step.source.clone()),
        ];
        *body += "<dl>";
        for (term, text) in rows.iter().filter(|(_, text)| !text.is_empty()) {
            let _ = write!(body, "<dt>{term}</dt><dd>{}</dd>", escape(text));
        }
        *body += "</dl></section>\n";
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

fn needed(need: &Need) -> String {
    match need.count {
        1 => need.name.clone(),
        count => format!("{count} × {}", need.name),
    }
}

/// With a capital and a full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    let text = first.unwrap_or_default() + letters.as_str();
    if text.ends_with(['.', '!', '?']) { text } else { text + "." }
}
