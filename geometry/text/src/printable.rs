//! Safe printing of foreign text on a terminal.

/// Returns text from a file as it may be printed on a terminal: one line, no control characters, cut after 60
/// characters of the text.
///
/// ```
/// use fabkit_text::to_printable;
///
/// assert_eq!(to_printable("7 mm\n\u{1b}[31m"), "7 mm\\n\\u{1b}[31m");
/// assert_eq!(to_printable(&"x".repeat(1000)).chars().count(), 61);
/// ```
pub fn to_printable(text: &str) -> String {
    /// Number of characters of the text that are shown.
    const LONGEST: usize = 60;
    let mut safe = String::new();
    for (i, c) in text.chars().enumerate() {
        if i == LONGEST {
            safe.push('…');
            break;
        }
        match c {
            // Direction marks could make the terminal display a different text from the one that was refused.
            '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {
                safe.extend(c.escape_unicode());
            }
            c if c.is_control() => safe.extend(c.escape_default()),
            c => safe.push(c),
        }
    }
    safe
}
