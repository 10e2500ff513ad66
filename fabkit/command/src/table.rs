//! Tables and paragraphs of text.

use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Table, presets};

/// Alignment of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Alignment of words.
    Left,
    /// Alignment of numbers.
    Right,
}

/// Width that tables fit, in columns of a terminal; the same in files and pipes.
pub const WIDTH: u16 = 100;

/// Formats rows in columns two spaces apart; the first row is the heading. Lines have no trailing blanks.
pub fn table(columns: &[Align], rows: &[Vec<String>]) -> String {
    format_table(Table::new(), columns, rows)
}

/// Formats a table within [`WIDTH`]: long cells are wrapped, except in the first column, by which rows are found.
pub fn wrapped_table(columns: &[Align], rows: &[Vec<String>]) -> String {
    let mut table = Table::new();
    table.set_content_arrangement(ContentArrangement::Dynamic).set_width(WIDTH);
    table.add_rows(rows);
    if let Some(first) = table.column_mut(0) {
        first.set_constraint(ColumnConstraint::ContentWidth);
    }
    format_table(table, columns, &[])
}

fn format_table(mut table: Table, columns: &[Align], rows: &[Vec<String>]) -> String {
    table.load_preset(presets::NOTHING).add_rows(rows);
    for (column, align) in table.column_iter_mut().zip(columns) {
        column.set_padding((0, 2));
        column.set_cell_alignment(match align {
            Align::Left => CellAlignment::Left,
            Align::Right => CellAlignment::Right,
        });
    }
    table.trim_fmt() + "\n"
}

/// Wraps a paragraph at [`WIDTH`]; all lines but the first are indented by `indent` blanks.
pub fn wrap_text(text: &str, indent: usize) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last().map_or(0, |line| line.chars().count());
        // A word longer than a line still gets a line of its own.
        if line > indent && line + 1 + word.chars().count() > WIDTH.into() {
            lines.push(" ".repeat(indent));
        }
        if let Some(line) = lines.last_mut() {
            if !line.trim().is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines.join("\n")
}

/// Formats a number with blanks between groups of three digits.
pub fn group_digits(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// Formats a count with its noun: `1 step`, `2 mixes`.
pub fn format_count(count: usize, noun: &str) -> String {
    let ending = match count {
        1 => "",
        _ if noun.ends_with('x') => "es",
        _ => "s",
    };
    format!("{count} {noun}{ending}")
}

/// Formats a file size for people.
pub fn format_size(bytes: u64) -> String {
    match bytes {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{:.0} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_counted_in_the_singular() {
        let counts = [(0, "file"), (1, "file"), (1, "mix"), (2, "mix")];
        let texts = counts.map(|(count, noun)| format_count(count, noun));
        assert_eq!(texts, ["0 files", "1 file", "1 mix", "2 mixes"]);
    }

    #[test]
    fn numbers_end_and_words_begin_in_line() {
        let row = |a: &str, b: &str| vec![a.to_owned(), b.to_owned()];
        let text = table(&[Align::Left, Align::Right], &[row("part", "n"), row("µ", "12")]);
        assert_eq!(text, "part   n\nµ     12\n");
        // Characters that are two columns wide.
        let text = table(&[Align::Left, Align::Right], &[row("外殻", "1"), row("base", "12")]);
        assert_eq!(text, "外殻   1\nbase  12\n");
    }

    #[test]
    fn what_is_long_goes_on_below_and_names_stay_whole() {
        let row = |a: &str, b: &str| vec![a.to_owned(), b.to_owned()];
        let (name, note) = ("fixtures.pin_dome.captures", "some words of a note ".repeat(9));
        let text = wrapped_table(
            &[Align::Left, Align::Left],
            &[row("parameter", "why"), row(name, &note)],
        );
        assert!(text.lines().all(|line| line.len() <= WIDTH.into()), "{text}");
        assert!(text.lines().count() > 3 && text.contains(name), "{text}");
        let text = wrap_text(&format!("1. {note}"), 3);
        assert!(text.lines().all(|line| line.len() <= WIDTH.into()), "{text}");
        let is_below = |line: &str| line.len() > 3 && line.find(|c| c != ' ') == Some(3);
        assert!(text.lines().count() > 1 && text.lines().skip(1).all(is_below), "{text}");
    }

    #[test]
    fn figures_are_readable() {
        assert_eq!((group_digits(7), group_digits(1_234_567)), ("7".into(), "1 234 567".into()));
        assert_eq!(
            (format_size(999), format_size(34_567), format_size(1_250_000)),
            ("999 B".into(), "35 kB".into(), "1.2 MB".into())
        );
    }
}
