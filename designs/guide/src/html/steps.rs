//! Sections of the steps, and the table of pieces by step.

use std::fmt::Write;

use fabkit_report::escape;

use super::mix::{minutes, title};
use super::{PageImages, StepImages, image, name, table};
use crate::{Guide, GuideStep, NeededBody};

impl Guide {
    /// Appends the table of the steps in which each piece is needed.
    pub(super) fn matrix(&self, body: &mut String) {
        if self.steps.is_empty() {
            return;
        }
        *body += "<h2>Pieces by step</h2>\n";
        let rows = self.made.iter().map(|part| (&part.name, &part.steps));
        let rows = rows.chain(self.bought.iter().map(|piece| (&piece.name, &piece.steps)));
        let row = |(piece, needed): (&String, &Vec<usize>)| {
            let cells = self.steps.iter().map(|step| {
                if needed.contains(&step.number) {
                    format!("<td>{}</td>", step.number)
                } else {
                    "<td></td>".to_owned()
                }
            });
            name(piece) + &cells.collect::<String>()
        };
        let numbers: Vec<String> = self.steps.iter().map(|step| step.number.to_string()).collect();
        let heads: Vec<&str> =
            std::iter::once("piece").chain(numbers.iter().map(String::as_str)).collect();
        *body += &table(&heads, 1, rows.map(row));
    }

    /// Appends the section of a step.
    pub(super) fn step(&self, body: &mut String, step: &GuideStep, images: &PageImages) {
        let _ = write!(
            body,
            "<section class=\"step\" id=\"step-{0}\"><h3><label><input type=\"checkbox\">{0}. {1}</label></h3>\n<p>{2}</p>\n",
            step.number,
            escape(&step.name),
            escape(&sentence(&step.instruction)),
        );
        if let Some(shots) = images.steps.get(&step.number) {
            self.shots(body, step, shots);
        }
        let mix = self.mixes.iter().find(|mix| mix.step == step.number).map(|mix| {
            let parts = mix.components.iter().map(|c| format!("{:.2} g {}", c.mass_g, c.name));
            let degas = if mix.degas { ", then draw the air out" } else { "" };
            let pot_life = mix.pot_life_h.map_or(String::new(), |pot_life_h| {
                format!(
                    "; pot life {}, work with it takes {}",
                    minutes(pot_life_h),
                    minutes(mix.in_hand_h)
                )
            });
            format!("{}{degas}{pot_life}", parts.collect::<Vec<_>>().join(" + "))
        });
        let stretch = &self.timeline.stretches[step.number - 1];
        let cures = stretch.end_h - stretch.hands_end_h;
        let hands = match stretch.hands_end_h - stretch.start_h {
            0.0 => String::new(),
            hours => format!("about {}", minutes(hours)),
        };
        // Numbers start at 1, so the number of a step is the index of the next one.
        let following = self.timeline.stretches.get(step.number);
        let next = following.map_or(String::new(), |next| {
            format!("step {} from {} on", next.step, clock(next.start_h))
        });
        let rows = [
            ("Together in", step.assembly.clone().unwrap_or_default()),
            ("Takes", step.needs.iter().map(needed).collect::<Vec<_>>().join(", ")),
            ("Tools", step.tools.join(", ")),
            ("Mix", mix.unwrap_or_default()),
            ("Take off", step.removed.join(", ")),
            ("Set right", step.adjusted.join(", ")),
            (
                "Meanwhile",
                step.during.map_or(String::new(), |number| format!("step {number} cures")),
            ),
            ("Hands", hands),
            ("Then wait", if cures > 0.0 { format!("{cures} h") } else { String::new() }),
            ("Next", next),
            ("Source", step.source.clone()),
        ];
        *body += "<dl>";
        for (term, text) in rows.iter().filter(|(_, text)| !text.is_empty()) {
            let _ = write!(body, "<dt>{term}</dt><dd>{}</dd>", escape(text));
        }
        if !step.checks.is_empty() {
            let checks = step.checks.iter().map(|check| {
                format!("<li><label><input type=\"checkbox\">{}</label></li>", escape(check))
            });
            let _ = write!(body, "<dt>Check</dt><dd><ul>{}</ul></dd>", checks.collect::<String>());
        }
        let minded = self.warnings.iter().filter(|w| w.steps.contains(&step.number));
        let mut minded: Vec<&str> = minded.map(|warning| title(warning.rule)).collect();
        minded.dedup();
        if !minded.is_empty() {
            let _ = write!(
                body,
                "<dt>Mind</dt><dd><a href=\"#mind\">{}</a></dd>",
                escape(&minded.join(", ").to_lowercase())
            );
        }
        *body += "</dl></section>\n";
    }

    /// Appends the images before and after a step.
    fn shots(&self, body: &mut String, step: &GuideStep, shots: &StepImages) {
        let place = step.assembly.as_deref().unwrap_or_default();
        let come = |is_coming: bool| {
            let ways = step.ways.iter().filter(|way| way.is_coming == is_coming);
            let mut names: Vec<&str> =
                ways.flat_map(|way| &way.bodies).map(String::as_str).collect();
            let mut seen = std::collections::BTreeSet::new();
            names.retain(|name| seen.insert(*name));
            names.join(", ")
        };
        let before = match (come(true), come(false)) {
            (coming, going) if coming.is_empty() && going.is_empty() => "before".to_owned(),
            (coming, going) if going.is_empty() => format!("added: {coming}"),
            (_, going) => format!("removed: {going}"),
        };
        let figure = |png: &Option<Vec<u8>>, words: &str| {
            png.as_ref().map_or(String::new(), |png| {
                let alt = format!("step {} in {place}, {words}", step.number);
                format!(
                    "<figure>{}<figcaption>{}</figcaption></figure>",
                    image(png, &alt),
                    escape(words)
                )
            })
        };
        let both = figure(&shots.before, &before) + &figure(&shots.after, "afterwards, cut open");
        if !both.is_empty() {
            let _ = writeln!(body, "<div class=\"shots\">{both}</div>");
        }
    }
}

fn needed(need: &NeededBody) -> String {
    match need.count {
        1 => need.name.clone(),
        count => format!("{count} × {}", need.name),
    }
}

/// Adds a capital letter and a full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    let text = first.unwrap_or_default() + letters.as_str();
    if text.ends_with(['.', '!', '?']) { text } else { text + "." }
}

/// Formats a time after the first step, counting days like the chart.
fn clock(hours: f64) -> String {
    let day = (hours / 24.0).floor();
    format!("day {}, hour {:.1}", day + 1.0, hours - 24.0 * day)
}
