//! Parser from YAML text to a small tree that keeps the position of every node.
//!
//! Only mappings, sequences and scalars are accepted. Anchors, aliases, tags, directives and further documents are
//! refused where they appear. Nothing is ever expanded, so a hostile file costs no more than reading it.

use std::collections::BTreeMap;

use granit_parser::{ErrorKind, Event, Marker, Parser, ScalarStyle, Span};

use crate::tree::{Dialect, Position, YamlContent, YamlEntry, YamlFault, YamlNode};

/// Maximum length of a text, bytes.
pub const MAX_BYTES: usize = 1 << 20;
/// Maximum number of nodes (keys, scalars, mappings, sequences) in one text.
pub const MAX_NODES: usize = 20_000;
/// Maximum nesting of mappings and sequences.
pub const MAX_DEPTH: usize = 64;

/// Tree of a text, and a fault for every key written twice (the first one counts).
pub type Parsed = (YamlNode, Vec<YamlFault>);

/// Parses a whole text.
///
/// # Errors
/// The first fault that makes the text unreadable: what follows it would be guesswork.
///
/// ```
/// use fabkit_text::{Dialect, parse};
///
/// const PINS: &Dialect = &Dialect::new("pin field", 1, "");
/// let (tree, repeated) = parse("rows: 4\nrows: 5\n", PINS)?;
/// assert_eq!(tree.get("rows").and_then(|rows| rows.text()), Some("4"));
/// assert_eq!(repeated.len(), 1);
/// let tab = parse("pins:\n\trows: 4\n", PINS).unwrap_err();
/// assert_eq!(tab.message, "a tab is used for indentation");
/// // What could grow when it is read is refused where it stands.
/// assert!(parse("a: &x 1\nb: *x\n", PINS).is_err());
/// # Ok::<(), fabkit_text::YamlFault>(())
/// ```
pub fn parse(text: &str, dialect: &'static Dialect) -> Result<Parsed, YamlFault> {
    if text.len() > MAX_BYTES {
        let message = format!("the file has {} bytes; at most {MAX_BYTES} are read", text.len());
        let hint = format!("a {} file is a few kilobytes; is this the right file?", dialect.noun);
        return Err(YamlFault::new(None, "", message).hint(hint));
    }
    // Byte order mark, which some editors write.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let options = granit_parser::options! {
        emit_comments: false,
        emit_unresolved_aliases: true,
        disallow_directives: true,
    };
    let mut builder =
        Builder { dialect, open: Vec::new(), root: None, nodes: 0, duplicates: Vec::new() };
    for event in Parser::new_from_str_with_options(text, options) {
        let (event, span) =
            event.map_err(|e| syntax_fault(e.kind(), *e.marker(), text, dialect))?;
        builder.handle_event(event, span)?;
    }
    let empty =
        YamlNode { position: Position { line: 1, column: 1 }, content: YamlContent::Nothing };
    Ok((builder.root.unwrap_or(empty), builder.duplicates))
}

/// Converts a position of the YAML parser, whose columns start at 0.
fn position(marker: Marker) -> Position {
    Position { line: marker.line().max(1), column: marker.col() + 1 }
}

/// Translates a parser error into the words of somebody who edits the file.
fn syntax_fault(kind: &ErrorKind, marker: Marker, text: &str, dialect: &Dialect) -> YamlFault {
    let at = position(marker);
    let tab_indented = text
        .lines()
        .nth(at.line - 1)
        .is_some_and(|line| line.trim_start_matches(' ').starts_with('\t'));
    match kind {
        // YAML parsers report tabs in many ways, so the line itself is examined first.
        _ if tab_indented => {
            YamlFault::at(at, "a tab is used for indentation", "indent with spaces, two per level")
        }
        ErrorKind::RecursionLimitExceeded => too_deep(at, dialect),
        ErrorKind::DirectiveDisallowed => YamlFault::at(
            at,
            format!("directives such as `%YAML` are not used in {} files", dialect.noun),
            "remove the line",
        ),
        _ => YamlFault::at(
            at,
            format!("this is not YAML: {kind}"),
            "check the indentation, the colon and space after each key, and that quotes and \
             brackets are closed",
        ),
    }
}

/// Creates the fault of too deep nesting.
fn too_deep(at: Position, dialect: &Dialect) -> YamlFault {
    let hint = format!("{} files need four levels", dialect.noun);
    YamlFault::at(at, format!("nested more than {MAX_DEPTH} deep"), hint)
}

/// Mapping or sequence that is still open.
struct OpenNode {
    node: YamlNode,
    /// In a mapping: key without a value so far.
    key: Option<(String, Position)>,
    /// In a mapping: position of the first occurrence of each key.
    first_positions: BTreeMap<String, Position>,
}

/// Builder of the tree from the events of the YAML parser.
struct Builder {
    dialect: &'static Dialect,
    open: Vec<OpenNode>,
    root: Option<YamlNode>,
    nodes: usize,
    duplicates: Vec<YamlFault>,
}

impl Builder {
    /// Processes one event of the YAML parser.
    fn handle_event(&mut self, event: Event<'_>, span: Span) -> Result<(), YamlFault> {
        let at = position(span.start);
        let refuse_alias = |at| {
            Err(YamlFault::at(
                at,
                "aliases (`*name`) are not allowed",
                "write the value out in full",
            ))
        };
        match event {
            Event::Alias(_) | Event::UnresolvedAlias(_) => return refuse_alias(at),
            Event::DocumentStart(..) if self.root.is_some() => {
                return Err(YamlFault::at(
                    at,
                    "a second document starts here",
                    format!("one file describes one {}; remove the `---`", self.dialect.noun),
                ));
            }
            Event::Scalar(text, style, anchor, tag) => {
                refuse_anchor(at, anchor)?;
                self.refuse_tag(at, tag.is_some())?;
                self.count_node(at)?;
                // Only unquoted: `"null"` in quotes is a text.
                let missing = style == ScalarStyle::Plain && matches!(&*text, "" | "~" | "null");
                let content = if missing {
                    YamlContent::Nothing
                } else {
                    YamlContent::Scalar(text.into_owned())
                };
                self.attach(YamlNode { position: at, content })?;
            }
            Event::SequenceStart(_, anchor, tag) => {
                refuse_anchor(at, anchor)?;
                self.refuse_tag(at, tag.is_some())?;
                self.open_node(at, YamlContent::List(Vec::new()))?;
            }
            Event::MappingStart(_, anchor, tag) => {
                refuse_anchor(at, anchor)?;
                let is_known = |suffix: &str| self.dialect.tags.contains(&suffix);
                self.refuse_tag(at, tag.is_some_and(|tag| !is_known(tag.suffix())))?;
                self.open_node(at, YamlContent::Map(Vec::new()))?;
            }
            Event::SequenceEnd | Event::MappingEnd => {
                if let Some(closed) = self.open.pop() {
                    self.attach(closed.node)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Counts a node and refuses more than [`MAX_NODES`].
    fn count_node(&mut self, at: Position) -> Result<(), YamlFault> {
        self.nodes += 1;
        if self.nodes > MAX_NODES {
            return Err(YamlFault::at(
                at,
                format!("more than {MAX_NODES} keys and values"),
                format!("a {} file has a few hundred; is this the right file?", self.dialect.noun),
            ));
        }
        Ok(())
    }

    /// Opens a list or mapping.
    fn open_node(&mut self, at: Position, content: YamlContent) -> Result<(), YamlFault> {
        self.count_node(at)?;
        if self.open.len() >= MAX_DEPTH {
            return Err(too_deep(at, self.dialect));
        }
        // A list or mapping in place of a key.
        if let Some(OpenNode {
            node: YamlNode { content: YamlContent::Map(_), .. },
            key: None,
            ..
        }) = self.open.last()
        {
            return Err(not_a_key(at));
        }
        let node = YamlNode { position: at, content };
        self.open.push(OpenNode { node, key: None, first_positions: BTreeMap::new() });
        Ok(())
    }

    /// Attaches a finished node: as the root, an item, a key, or the value of a key.
    fn attach(&mut self, node: YamlNode) -> Result<(), YamlFault> {
        let path = self.path();
        let Some(open) = self.open.last_mut() else {
            self.root = Some(node);
            return Ok(());
        };
        match (&mut open.node.content, open.key.take()) {
            (YamlContent::List(items), _) => items.push(node),
            (YamlContent::Map(entries), Some((key, key_position))) => {
                match open.first_positions.get(&key) {
                    None => {
                        open.first_positions.insert(key.clone(), key_position);
                        entries.push(YamlEntry { key, key_position, value: node });
                    }
                    // Reported only: the first occurrence counts, so that the rest can still be read.
                    Some(first) => self.duplicates.push(YamlFault {
                        position: Some(key_position),
                        message: format!(
                            "`{path}` is written twice: on line {} and on line {}",
                            first.line, key_position.line
                        ),
                        path,
                        written: crate::to_printable(&key),
                        hint: Some("keep one of them".into()),
                    }),
                }
            }
            (YamlContent::Map(_), None) => match node.content {
                YamlContent::Scalar(key) if key == "<<" => {
                    let hint = match self.dialect.base {
                        "" => "write each key where it is used".into(),
                        base => format!("use `extends: NAME` to start from {base}"),
                    };
                    return Err(YamlFault::at(
                        node.position,
                        "merge keys (`<<`) are not allowed",
                        hint,
                    ));
                }
                YamlContent::Scalar(key) => open.key = Some((key, node.position)),
                _ => return Err(not_a_key(node.position)),
            },
            // `start` opens only lists and mappings.
            (YamlContent::Scalar(_) | YamlContent::Nothing, _) => {}
        }
        Ok(())
    }

    /// Refuses a tag that the dialect does not have.
    fn refuse_tag(&self, at: Position, is_foreign: bool) -> Result<(), YamlFault> {
        let message = match self.dialect.tags {
            _ if !is_foreign => return Ok(()),
            [] => "tags (`!name`) are not allowed".into(),
            known => format!("of all tags only `!!{}` is read", known.join("`, `!!")),
        };
        Err(YamlFault::at(at, message, "write the plain value"))
    }

    /// Returns the dotted path of the value that is being attached.
    fn path(&self) -> String {
        let keys = self.open.iter().filter_map(|open| Some(&*open.key.as_ref()?.0));
        crate::to_printable(&keys.collect::<Vec<_>>().join("."))
    }
}

/// Creates the fault of a list or mapping in place of a key.
fn not_a_key(at: Position) -> YamlFault {
    YamlFault::at(at, "this is not a key", "a key is one word, followed by a colon and a space")
}

/// Refuses an anchor; 0 is the parser's number for none.
fn refuse_anchor(at: Position, anchor: usize) -> Result<(), YamlFault> {
    match anchor {
        0 => Ok(()),
        _ => Err(YamlFault::at(
            at,
            "anchors (`&name`) are not allowed",
            "write each value where it is used",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSOR: Dialect = Dialect { base: "a built-in sensor", ..Dialect::new("sensor", 1, "") };
    const CAMERA: Dialect = Dialect { tags: &["matrix"], ..Dialect::new("camera", 1, "") };

    fn fault(text: &str, dialect: &'static Dialect) -> String {
        parse(text, dialect).unwrap_err().to_string()
    }

    #[test]
    fn messages_speak_of_the_kind_of_file() {
        for (dialect, noun) in [(&SENSOR, "sensor"), (&CAMERA, "camera")] {
            for (text, says) in [
                ("a: 1\n---\nb: 2\n", format!("one file describes one {noun}")),
                ("%YAML 1.2\n---\na: 1\n", format!("not used in {noun} files")),
                (&" ".repeat(MAX_BYTES + 1), format!("a {noun} file is a few kilobytes")),
                (&"a: ".repeat(MAX_NODES + 1), "not YAML".into()),
                (&"a: {".repeat(MAX_DEPTH + 2), format!("{noun} files need four levels")),
            ] {
                let found = fault(text, dialect);
                assert!(found.contains(&says), "{found}");
            }
        }
        assert!(fault("<<: {a: 1}\n", &SENSOR).contains("start from a built-in sensor"));
        assert!(fault("<<: {a: 1}\n", &CAMERA).contains("write each key where it is used"));
    }

    #[test]
    fn known_tags_are_ignored_and_others_refused() {
        let (root, twice) = parse("k: !!matrix {rows: 3, rows: 4}\n", &CAMERA).unwrap();
        let rows = root.get("k").and_then(|k| k.get("rows")).and_then(YamlNode::text);
        assert_eq!((rows, twice.len()), (Some("3"), 1));
        let told = "line 1: `k.rows` is written twice: on line 1 and on line 1 (keep one of them)";
        assert_eq!(twice[0].to_string(), told);
        assert!(fault("k: !!other {rows: 3}", &CAMERA).contains("only `!!matrix` is read"));
        assert!(fault("k: !!matrix {rows: 3}", &SENSOR).contains("tags (`!name`) are not allowed"));
    }
}
