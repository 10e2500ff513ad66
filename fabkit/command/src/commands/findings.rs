//! Texts of what is implausible about captures.

use fabkit_application::capturing::plausibility::Judgement;

/// Maximum number of findings that are listed one by one.
const MOST_LISTED: usize = 20;

/// Formats findings, each with what to do, and whether files are written.
pub(super) fn format_findings(judgement: &Judgement, is_forced: bool) -> String {
    let mut text = String::new();
    for finding in judgement.findings.iter().take(MOST_LISTED) {
        text += &format!("implausible: {finding}\n  {}\n", finding.fault.advice());
    }
    let more = judgement.findings.len().saturating_sub(MOST_LISTED);
    if more > 0 {
        text += &format!("and {more} more\n");
    }
    if !judgement.is_plausible() {
        text += if is_forced {
            "written all the same, as --force demands\n"
        } else {
            "nothing is written; --force writes it all the same\n"
        };
    }
    text
}
