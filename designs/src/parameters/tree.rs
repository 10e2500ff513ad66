//! YAML text to a small tree that knows where everything stands.
//!
//! Only what a sensor file needs is accepted: mappings, sequences and scalars. Anchors, aliases,
//! tags, directives and further documents are refused where they appear, so nothing is ever
//! expanded and a hostile file costs no more than reading it.

use std::collections::BTreeMap;

use granit_parser::{ErrorKind, Event, Marker, Parser, ScalarStyle, Span};

/// Longest text that is looked at, bytes.
pub const MAX_BYTES: usize = 1 << 20;
/// Most nodes (keys, scalars, mappings, sequences) in one text.
pub const MAX_NODES: usize = 20_000;
/// Deepest nesting of mappings and sequences.
pub const MAX_DEPTH: usize = 64;

/// A place in a text; both counts start at 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// Of the file.
    pub line: usize,
    /// In characters.
    pub column: usize,
}

/// One YAML value.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Where it begins.
    pub position: Position,
    /// What it is.
    pub content: Content,
}

/// What a YAML value is.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// Nothing was written, as in `radius:` or `radius: null`.
    Nothing,
    /// One value, as text.
    Scalar(String),
    /// `[a, b]`, or lines that begin with `-`.
    List(Vec<Node>),
    /// `key: value`, in the order of the file.
    Map(Vec<Entry>),
}

/// One `key: value`.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its name.
    pub key: String,
    /// Where the name stands.
    pub key_position: Position,
    /// What stands behind it.
    pub value: Node,
}

/// Why a text cannot be read.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Where, if it is one place.
    pub position: Option<Position>,
    /// Dotted path of the key at fault, where there is one.
    pub path: String,
    /// What stands there.
    pub written: String,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub hint: Option<String>,
}

impl Fault {
    /// The same as a problem of a file.
    pub fn in_file(self, file: &str) -> super::Problem {
        super::Problem {
            file: file.into(),
            line: self.position.map(|at| at.line),
            column: self.position.map(|at| at.column),
            path: self.path,
            value: self.written,
            message: self.message,
            hint: self.hint,
        }
    }

    fn at(position: Position, message: impl Into<String>, hint: &str) -> Self {
        Self {
            position: Some(position),
            path: String::new(),
            written: String::new(),
            message: message.into(),
            hint: (!hint.is_empty()).then(|| hint.to_owned()),
        }
    }
}

/// The tree of a text, and keys that were written twice (the first one counts).
pub type Parsed = (Node, Vec<Fault>);

/// Reads a whole text.
///
/// # Errors
/// The first thing that makes the text unreadable: what follows it would be guesswork.
pub fn parse(text: &str) -> Result<Parsed, Fault> {
    if text.len() > MAX_BYTES {
        return Err(Fault {
            position: None,
            path: String::new(),
            written: String::new(),
            message: format!("the file has {} bytes; at most {MAX_BYTES} are read", text.len()),
            hint: Some("a sensor file is a few kilobytes; is this the right file?".into()),
        });
    }
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let options = granit_parser::options! {
        emit_comments: false,
        emit_unresolved_aliases: true,
        disallow_directives: true,
    };
    let mut builder = Builder::default();
    for event in Parser::new_from_str_with_options(text, options) {
        let (event, span) = event.map_err(|e| syntax_fault(e.kind(), *e.marker(), text))?;
        builder.take(event, span)?;
    }
    let empty = Node { position: Position { line: 1, column: 1 }, content: Content::Nothing };
    Ok((builder.root.unwrap_or(empty), builder.duplicates))
}

fn position(marker: Marker) -> Position {
    Position { line: marker.line().max(1), column: marker.col() + 1 }
}

/// Says what the parser found, in the words of someone who is editing a sensor file.
fn syntax_fault(kind: &ErrorKind, marker: Marker, text: &str) -> Fault {
    let at = position(marker);
    let tab_indented = text
        .lines()
        .nth(at.line - 1)
        .is_some_and(|line| line.trim_start_matches(' ').starts_with('\t'));
    match kind {
        _ if tab_indented => {
            Fault::at(at, "a tab is used for indentation", "indent with spaces, two per level")
        }
        ErrorKind::RecursionLimitExceeded => too_deep(at),
        ErrorKind::DirectiveDisallowed => Fault::at(
            at,
            "directives such as `%YAML` are not used in sensor files",
            "remove the line",
        ),
        _ => Fault::at(
            at,
            format!("this is not YAML: {kind}"),
            "check the indentation, the colon and space after each key, and that quotes and \
             brackets are closed",
        ),
    }
}

fn too_deep(at: Position) -> Fault {
    Fault::at(at, format!("nested more than {MAX_DEPTH} deep"), "sensor files need four levels")
}

/// A mapping or sequence that is not closed yet.
struct Open {
    node: Node,
    /// In a mapping: the key that waits for its value.
    key: Option<(String, Position)>,
    /// In a mapping: where each key was first seen.
    seen: BTreeMap<String, Position>,
}

#[derive(Default)]
struct Builder {
    open: Vec<Open>,
    root: Option<Node>,
    nodes: usize,
    duplicates: Vec<Fault>,
}

impl Builder {
    fn take(&mut self, event: Event<'_>, span: Span) -> Result<(), Fault> {
        let at = position(span.start);
        let refuse_alias = |at| {
            Err(Fault::at(at, "aliases (`*name`) are not allowed", "write the value out in full"))
        };
        match event {
            Event::Alias(_) | Event::UnresolvedAlias(_) => return refuse_alias(at),
            Event::DocumentStart(..) if self.root.is_some() => {
                return Err(Fault::at(
                    at,
                    "a second document starts here",
                    "one file describes one sensor; remove the `---`",
                ));
            }
            Event::Scalar(text, style, anchor, tag) => {
                refuse_properties(at, anchor, tag.is_some())?;
                self.count(at)?;
                let missing = style == ScalarStyle::Plain && matches!(&*text, "" | "~" | "null");
                let content = match missing {
                    true => Content::Nothing,
                    false => Content::Scalar(text.into_owned()),
                };
                self.place(Node { position: at, content })?;
            }
            Event::SequenceStart(_, anchor, tag) => {
                refuse_properties(at, anchor, tag.is_some())?;
                self.start(at, Content::List(Vec::new()))?;
            }
            Event::MappingStart(_, anchor, tag) => {
                refuse_properties(at, anchor, tag.is_some())?;
                self.start(at, Content::Map(Vec::new()))?;
            }
            Event::SequenceEnd | Event::MappingEnd => {
                if let Some(closed) = self.open.pop() {
                    self.place(closed.node)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn count(&mut self, at: Position) -> Result<(), Fault> {
        self.nodes += 1;
        if self.nodes > MAX_NODES {
            return Err(Fault::at(
                at,
                format!("more than {MAX_NODES} keys and values"),
                "a sensor file has a few hundred; is this the right file?",
            ));
        }
        Ok(())
    }

    fn start(&mut self, at: Position, content: Content) -> Result<(), Fault> {
        self.count(at)?;
        if self.open.len() >= MAX_DEPTH {
            return Err(too_deep(at));
        }
        if let Some(Open { node: Node { content: Content::Map(_), .. }, key: None, .. }) =
            self.open.last()
        {
            return Err(key_fault(at));
        }
        let node = Node { position: at, content };
        self.open.push(Open { node, key: None, seen: BTreeMap::new() });
        Ok(())
    }

    /// Puts a finished node where it belongs: the root, an item, a key, or a key's value.
    fn place(&mut self, node: Node) -> Result<(), Fault> {
        let path = self.path();
        let Some(open) = self.open.last_mut() else {
            self.root = Some(node);
            return Ok(());
        };
        match (&mut open.node.content, open.key.take()) {
            (Content::List(items), _) => items.push(node),
            (Content::Map(entries), Some((key, key_position))) => {
                match open.seen.get(&key) {
                    None => {
                        open.seen.insert(key.clone(), key_position);
                        entries.push(Entry { key, key_position, value: node });
                    }
                    // Reported; the first one counts, so that the rest can still be read.
                    Some(first) => self.duplicates.push(Fault {
                        position: Some(key_position),
                        message: format!(
                            "`{path}` is written twice: on line {} and on line {}",
                            first.line, key_position.line
                        ),
                        path,
                        written: super::shown(&key),
                        hint: Some("keep one of them".into()),
                    }),
                }
            }
            (Content::Map(_), None) => match node.content {
                Content::Scalar(key) if key == "<<" => {
                    return Err(Fault::at(
                        node.position,
                        "merge keys (`<<`) are not allowed",
                        "use `extends: NAME` to start from a built-in sensor",
                    ));
                }
                Content::Scalar(key) => open.key = Some((key, node.position)),
                _ => return Err(key_fault(node.position)),
            },
            // `start` opens nothing else.
            (Content::Scalar(_) | Content::Nothing, _) => {}
        }
        Ok(())
    }

    /// Dotted path of the value that is being placed.
    fn path(&self) -> String {
        let keys = self.open.iter().filter_map(|open| Some(&*open.key.as_ref()?.0));
        super::shown(&keys.collect::<Vec<_>>().join("."))
    }
}

fn key_fault(at: Position) -> Fault {
    Fault::at(at, "this is not a key", "a key is one word, followed by a colon and a space")
}

fn refuse_properties(at: Position, anchor: usize, tagged: bool) -> Result<(), Fault> {
    if anchor != 0 {
        return Err(Fault::at(
            at,
            "anchors (`&name`) are not allowed",
            "write each value where it is used",
        ));
    }
    if tagged {
        return Err(Fault::at(at, "tags (`!name`) are not allowed", "write the plain value"));
    }
    Ok(())
}
