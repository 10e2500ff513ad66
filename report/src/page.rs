//! The page around a report.

use crate::escape;

const STYLE: &str = "
body { font: 15px/1.45 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; margin: .6rem 0; } th, td { padding: .15rem .7rem; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; } tr.chosen { font-weight: 600; background: #eef4fb; }
.warnings li { margin: .3rem 0; } .warnings { background: #fff6e0; border-left: 4px solid #d89b00; padding: .4rem 1rem; }
figure { margin: 1rem 0; } figcaption { color: #555; font-size: .9rem; } .pair { display: flex; gap: 1rem; } .pair > * { flex: 0 1 50%; }
svg { width: 100%; height: auto; }
@media print { body { margin: 0; max-width: none; } h2, figure, table { break-inside: avoid; } }
";

/// A whole page; `title` is plain text, `body` is HTML.
pub fn page(title: &str, body: &str) -> String {
    let title = escape(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <title>{title}</title><style>{STYLE}</style></head>\n<body>\n<h1>{title}</h1>\n{body}\
         </body></html>\n"
    )
}
