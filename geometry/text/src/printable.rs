//! Safe printing of foreign text on a terminal.

use std::borrow::Cow;

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
        push_escaped(&mut safe, c);
    }
    safe
}

/// Returns text of any length as it may be printed on a terminal, with its lines and tabs.
///
/// ```
/// use fabkit_text::escape_steering;
///
/// assert_eq!(escape_steering("two\tlines:\na \u{1b}[31m"), "two\tlines:\na \\u{1b}[31m");
/// assert_eq!(escape_steering("a\u{202e}b"), "a\\u{202e}b");
/// ```
pub fn escape_steering(text: &str) -> Cow<'_, str> {
    let is_kept = |c: char| matches!(c, '\n' | '\t') || !is_steering(c);
    if text.chars().all(is_kept) {
        return Cow::Borrowed(text);
    }
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        if is_kept(c) { safe.push(c) } else { push_escaped(&mut safe, c) }
    }
    Cow::Owned(safe)
}

/// Returns whether a character steers a terminal, or the direction in which it writes: it could make the terminal display
/// a different text from the one that is there.
///
/// ```
/// use fabkit_text::is_steering;
///
/// assert!(is_steering('\u{1b}') && is_steering('\u{9b}') && is_steering('\u{202e}'));
/// assert!(!is_steering('ü'));
/// ```
pub fn is_steering(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{61c}'
                | '\u{200e}'
                | '\u{200f}'
                | '\u{2028}'
                | '\u{2029}'
                | '\u{202a}'..='\u{202e}'
                | '\u{2066}'..='\u{2069}'
        )
}

/// Appends a character, escaped if it steers a terminal.
fn push_escaped(safe: &mut String, c: char) {
    if c.is_control() {
        safe.extend(c.escape_default());
    } else if is_steering(c) {
        safe.extend(c.escape_unicode());
    } else {
        safe.push(c);
    }
}
