//! Section on calibration: fixtures, commands, and the pins for each capture.

use std::fmt::Write;

use fabkit_report::escape;

use super::{name, table, word};
use crate::{Calibration, Guide};

impl Guide {
    /// Appends the section on calibration, if there is one.
    pub(super) fn calibrating(&self, body: &mut String) {
        let Some(calibration) = &self.calibration else { return };
        *body += "<h2 id=\"calibrate\">Calibrate it</h2>\n";
        if !calibration.fixtures.is_empty() {
            let rows = calibration.fixtures.iter();
            let rows = rows.map(|fixture| name(&fixture.name) + &word(&fixture.summary));
            *body += &table(&["fixture", "purpose"], 2, rows);
        }
        if !calibration.commands.is_empty() {
            *body += "<p>In this order, in an empty folder:</p>\n<ol class=\"typed\">\n";
            for typed in &calibration.commands {
                let _ = writeln!(
                    body,
                    "<li><label><input type=\"checkbox\">{}</label><pre><code>{}</code></pre></li>",
                    escape(&typed.what),
                    escape(&typed.line)
                );
            }
            *body += "</ol>\n";
        }
        sheet(body, calibration);
    }
}

/// Appends the sheet of pins and holes for the captures.
fn sheet(body: &mut String, calibration: &Calibration) {
    if calibration.captures.is_empty() {
        return;
    }
    let _ = writeln!(
        body,
        "<h3>Sheet for {}</h3>\n<p>First one image without pins: <code>ref.png</code>. Then, for each row, push these pins home \
         in these holes (the numbers are engraved beside them), take the image, pull them out. A pin is home when its head \
         stands on its seat.</p>",
        escape(&calibration.pins_in)
    );
    let rows = calibration.captures.iter().map(|capture| {
        let holes: Vec<String> = capture.holes.iter().map(u32::to_string).collect();
        format!(
            "<th scope=\"row\"><label><input type=\"checkbox\">{}</label></th>{}{}",
            escape(&capture.file),
            word(&capture.pins),
            word(&holes.join(", "))
        )
    });
    *body += &table(&["picture", "pins", "holes"], 3, rows);
    let _ = writeln!(
        body,
        "<details><summary>The same as captures.csv, for the folder of the images</summary><pre>{}</pre></details>",
        escape(&calibration.captures_csv())
    );
}
