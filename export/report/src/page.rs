//! HTML page of a report.

use crate::escape;

/// Style sheet of all reports: light or dark as the reader's system has it, from 400 px to wide screens, and for print.
/// Drawings set their colours in attributes (see `svg.rs`), which these rules override in the dark.
const STYLE: &str = "
:root { color-scheme: light dark; --ink: #222; --paper: #fff; --quiet: #555; --line: #ccc; --chosen: #eef4fb; --warn: #fff6e0; }
body { font: 15px/1.45 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: var(--ink); background: var(--paper); overflow-wrap: break-word; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; border-bottom: 1px solid var(--line); }
.table { overflow-x: auto; margin: .6rem 0; } table { border-collapse: collapse; } th, td { padding: .15rem .7rem; text-align: right; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { text-align: left; padding-left: 0; } tr.chosen { font-weight: 600; background: var(--chosen); }
.warnings li { margin: .3rem 0; } .warnings { background: var(--warn); border-left: 4px solid #d89b00; padding: .4rem 1rem; }
figure { margin: 1rem 0; } figcaption { color: var(--quiet); font-size: .9rem; } .pair { display: flex; flex-wrap: wrap; gap: 1rem; } .pair > * { flex: 1 1 18rem; margin: 0; }
svg { width: 100%; height: auto; } circle:hover { stroke: currentColor; }
@media (max-width: 30rem) { body { margin: 1rem auto; padding: 0 .6rem; } th, td { padding: .15rem .4rem; } svg text { font-size: 20px; } }
@media screen and (prefers-color-scheme: dark) {
:root { --ink: #ddd; --paper: #16181b; --quiet: #aaa; --line: #444; --chosen: #22303f; --warn: #33290f; }
svg text { fill: #bbb; } svg [fill='#fafafa'] { fill: #1f2226; } svg [fill='#fbe9d0'] { fill: #4a3413; } svg [fill='#1f4e79'] { fill: #7db4e6; }
svg [stroke='#e3e3e3'] { stroke: #3a3d41; } svg [stroke='#1f4e79'] { stroke: #7db4e6; } svg [stroke='#c0392b'] { stroke: #ff7b6b; } }
@media print { body { margin: 0; max-width: none; } h2, figure, tr { break-inside: avoid; } h2 { break-after: avoid; } .table { overflow: visible; } }
";

/// Creates a whole page; `title` is plain text, `body` is HTML. Tables that are wider than the screen scroll.
///
/// ```
/// let page = fabkit_report::page("Pins", "<table><tr><td>1</td></tr></table>");
/// assert!(page.contains("width=device-width") && page.contains("<div class=\"table\""));
/// ```
pub fn page(title: &str, body: &str) -> String {
    page_with_style(title, "", body)
}

/// Creates a page with additional style rules after those of all reports.
///
/// ```
/// let html = fabkit_report::page_with_style("Gel & glass", "h1 { color: teal; }", "<p>text</p>\n");
/// assert!(html.contains("h1 { color: teal; }</style>"));
/// assert!(html.contains("<h1>Gel &amp; glass</h1>\n<p>text</p>\n"));
/// ```
pub fn page_with_style(title: &str, style: &str, body: &str) -> String {
    let title = escape(title);
    // For accessibility: scrolling boxes can be focused with the keyboard, and all content is in one landmark for
    // screen readers.
    let body = body
        .replace("<table>", "<div class=\"table\" tabindex=\"0\"><table>")
        .replace("</table>", "</table></div>");
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <title>{title}</title><style>{STYLE}{style}</style></head>\n<body>\n<main>\n<h1>{title}</h1>\n{body}\
         </main></body></html>\n"
    )
}
