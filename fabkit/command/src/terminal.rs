//! The only way to the terminal. Names come from files that somebody else may have written, and characters in them could
//! steer the terminal or show another text than the one that is there; they are escaped here, whatever the text is.

use std::io::{self, Write};

use fabkit_application::text::escape_steering;

/// Writes text to standard output.
pub(crate) fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout();
    out.write_all(escape_steering(text).as_bytes())?;
    out.flush()
}

/// Writes JSON to standard output. Steering characters are written as JSON's own escapes, so that programs read the same.
pub(crate) fn print_json(json: &serde_json::Value) -> io::Result<()> {
    let mut out = io::stdout();
    out.write_all(json_line(json).as_bytes())?;
    out.flush()
}

/// Writes text to standard error. If it is closed, the exit code still tells.
pub(crate) fn tell(text: &str) {
    let _ = io::stderr().write_all(escape_steering(text).as_bytes());
}

/// Formats JSON on several lines, with a final newline.
fn json_line(json: &serde_json::Value) -> String {
    let text = format!("{json:#}\n");
    // Below U+0020 serde escapes them; above, they can only stand in strings, none beyond U+FFFF.
    let is_raw = |c: char| c != '\n' && fabkit_application::text::is_steering(c);
    if !text.contains(is_raw) {
        return text;
    }
    let escaped = text
        .chars()
        .map(|c| if is_raw(c) { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() });
    escaped.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_is_escaped_and_reads_back_as_it_was() {
        let json = serde_json::json!({ "a": "x\u{7f}\u{9b}31m\u{202e}\u{1b}\n\u{2066}y ü" });
        let line = json_line(&json);
        assert!(line.chars().all(|c| c == '\n' || !fabkit_application::text::is_steering(c)));
        assert_eq!(serde_json::from_str::<serde_json::Value>(&line).unwrap(), json);
        assert!(line.contains("ü"));
    }
}
