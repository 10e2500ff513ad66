//! Section on the schedule.

use std::fmt::Write;

use fabkit_report::{Svg, escape};

use crate::{Guide, Timeline};

impl Guide {
    /// Appends the schedule as a chart and in words.
    pub(super) fn times(&self, body: &mut String) {
        if self.timeline.stretches.is_empty() {
            return;
        }
        let _ = write!(
            body,
            "<h2 id=\"time\">Time</h2>\n<figure>{}<figcaption>One unit, {:.0} h from the first step: hands dark, cures light; the whole build waits for framed steps. Hands-on times are {}.</figcaption></figure>\n",
            self.chart(),
            self.timeline.total_h,
            escape(self.timeline.hands_on),
        );
        *body += "<dl>";
        for (term, text) in self.when() {
            let _ = write!(body, "<dt>{term}</dt><dd>{text}</dd>");
        }
        *body += "</dl>\n";
    }

    /// Returns the chart in words, as HTML.
    fn when(&self) -> Vec<(&'static str, String)> {
        let timeline = &self.timeline;
        let link = |number: &usize| {
            let name = escape(&self.steps[number - 1].name);
            format!("<a href=\"#step-{number}\">{number} {name}</a>")
        };
        let cured = |number: &usize| {
            let stretch = &timeline.stretches[number - 1];
            match stretch.end_h - stretch.hands_end_h {
                0.0 => link(number),
                hours => format!("{} ({hours} h)", link(number)),
            }
        };
        let list = |numbers: &[usize], of: &dyn Fn(&usize) -> String| {
            numbers.iter().map(of).collect::<Vec<_>>().join(", ")
        };
        let waits = |number: &usize| {
            let stretch = &timeline.stretches[number - 1];
            stretch.end_h > stretch.hands_end_h
        };
        let curing: Vec<usize> = timeline.critical.iter().copied().filter(waits).collect();
        let mut said = Vec::new();
        if !curing.is_empty() {
            said.push(("The build waits for", list(&curing, &cured)));
        }
        for meanwhile in &timeline.meanwhile {
            let steps = list(&meanwhile.steps, &link);
            said.push((
                "Side by side",
                format!("while {} cures: {steps}", link(&meanwhile.during)),
            ));
        }
        said.push(("Hands", format!("about {} h for one unit", timeline.hands_h)));
        let series = &timeline.units;
        let next = match &series.waits_for {
            Some(tool) => format!(
                "{:.1} h after the one before, when {} is free again",
                series.apart_h,
                escape(tool)
            ),
            None => format!(
                "{:.1} h after the one before, when the hands are free again",
                series.apart_h
            ),
        };
        said.push(("A further unit ends", next));
        if series.count > 1 {
            let all = format!(
                "{:.0} h with one set of molds and tools, about {} h of it by hand",
                series.total_h, series.hands_h
            );
            said.push(("All units", format!("{}: {all}", series.count)));
        }
        said
    }

    /// Draws the hands-on work and cures of the steps over time.
    pub(super) fn chart(&self) -> String {
        const ROW: f64 = 18.0;
        const LEFT: f64 = 230.0;
        const WIDTH: f64 = 880.0;
        let Timeline { stretches, total_h, .. } = &self.timeline;
        // Steps without duration get no row.
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
            // At least 2 px wide, so that short steps stay visible.
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
}
