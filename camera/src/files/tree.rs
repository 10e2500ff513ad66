//! YAML text to a small tree with line numbers.
//!
//! What camera files need and no more: no anchors, no aliases, one document, and of all tags only
//! `!!opencv-matrix`.

use granit_parser::{Event, Marker, Parser, ScalarStyle};

use super::Fault;

/// Longest text that is looked at, bytes.
const MAX_BYTES: usize = 1 << 20;
/// Most keys and values; a covariance of 17 parameters has 289.
const MAX_NODES: usize = 20_000;
const MAX_DEPTH: usize = 16;

/// One value.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// Counted from 1.
    pub line: usize,
    pub content: Content,
}

#[derive(Clone, Debug)]
pub(super) enum Content {
    /// As written, without quotes; empty if nothing was written.
    Scalar(String),
    List(Vec<Node>),
    Map(Vec<Entry>),
}

/// One `key: value`.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub key: String,
    pub line: usize,
    pub value: Node,
}

impl Node {
    /// The value of a key, if this is a mapping that has it.
    pub(super) fn get(&self, key: &str) -> Option<&Node> {
        self.entries().iter().find(|entry| entry.key == key).map(|entry| &entry.value)
    }

    /// All keys with their values; none if this is no mapping.
    pub(super) fn entries(&self) -> &[Entry] {
        match &self.content {
            Content::Map(entries) => entries,
            _ => &[],
        }
    }
}

/// Reads a text.
pub(super) fn parse(text: &str) -> Result<Node, Fault> {
    if text.len() > MAX_BYTES {
        let message = format!("the file has {} bytes; at most {MAX_BYTES} are read", text.len());
        return Err(Fault::new(None, "", message).hint("a camera file is a few kilobytes"));
    }
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // OpenCV's first line, `%YAML:1.0`, is not YAML.
    let commented = match text.starts_with("%YAML") {
        true => format!("#{}", &text[1..]),
        false => text.to_owned(),
    };
    let options = granit_parser::options! {
        emit_comments: false,
        emit_unresolved_aliases: true,
        disallow_directives: true,
    };
    let mut builder = Builder::default();
    for event in Parser::new_from_str_with_options(&commented, options) {
        let (event, span) = event.map_err(|error| {
            Fault::new(line(error.marker()), "", format!("this is not YAML: {}", error.kind()))
        })?;
        builder.take(event, line(&span.start))?;
    }
    let nothing = || Fault::new(None, "", "the file is empty");
    builder.root.ok_or_else(nothing)
}

fn line(marker: &Marker) -> usize {
    marker.line().max(1)
}

/// A mapping or list that is not closed yet.
struct Open {
    node: Node,
    /// In a mapping: the key that waits for its value.
    key: Option<(String, usize)>,
}

#[derive(Default)]
struct Builder {
    open: Vec<Open>,
    root: Option<Node>,
    nodes: usize,
}

impl Builder {
    fn take(&mut self, event: Event<'_>, line: usize) -> Result<(), Fault> {
        let refuse = |what: &str| Err(Fault::new(line, "", what));
        match event {
            Event::Alias(_) | Event::UnresolvedAlias(_) => {
                return refuse("aliases (`*name`) are not read");
            }
            Event::DocumentStart(..) if self.root.is_some() => {
                return refuse("a second document starts here; one file holds one camera");
            }
            Event::Scalar(text, style, anchor, tag) => {
                refuse_anchor(anchor, line)?;
                if tag.is_some() {
                    return refuse("tags on single values are not read");
                }
                let missing = style == ScalarStyle::Plain && matches!(&*text, "~" | "null");
                let text = if missing { String::new() } else { text.into_owned() };
                self.count(line)?;
                self.place(Node { line, content: Content::Scalar(text) })?;
            }
            Event::SequenceStart(_, anchor, tag) => {
                refuse_anchor(anchor, line)?;
                if tag.is_some() {
                    return refuse("tags on lists are not read");
                }
                self.start(line, Content::List(Vec::new()))?;
            }
            Event::MappingStart(_, anchor, tag) => {
                refuse_anchor(anchor, line)?;
                if tag.is_some_and(|tag| tag.suffix() != "opencv-matrix") {
                    return refuse("of all tags only `!!opencv-matrix` is read");
                }
                self.start(line, Content::Map(Vec::new()))?;
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

    fn count(&mut self, line: usize) -> Result<(), Fault> {
        self.nodes += 1;
        match self.nodes > MAX_NODES {
            true => Err(Fault::new(line, "", format!("more than {MAX_NODES} keys and values"))),
            false => Ok(()),
        }
    }

    fn start(&mut self, line: usize, content: Content) -> Result<(), Fault> {
        self.count(line)?;
        if self.open.len() >= MAX_DEPTH {
            return Err(Fault::new(line, "", format!("nested more than {MAX_DEPTH} deep")));
        }
        self.open.push(Open { node: Node { line, content }, key: None });
        Ok(())
    }

    /// Puts a finished node where it belongs: the root, an item, a key, or a key's value.
    fn place(&mut self, node: Node) -> Result<(), Fault> {
        let Some(open) = self.open.last_mut() else {
            self.root = Some(node);
            return Ok(());
        };
        match (&mut open.node.content, open.key.take()) {
            (Content::List(items), _) => items.push(node),
            (Content::Map(entries), Some((key, line))) => {
                if let Some(first) = entries.iter().find(|entry| entry.key == key) {
                    let message = format!("written twice, first on line {}", first.line);
                    return Err(Fault::new(line, &key, message).hint("keep one of them"));
                }
                entries.push(Entry { key, line, value: node });
            }
            (Content::Map(_), None) => match node.content {
                Content::Scalar(key) => open.key = Some((key, node.line)),
                _ => return Err(Fault::new(node.line, "", "a key must be a single word")),
            },
            // `start` opens nothing else.
            (Content::Scalar(_), _) => {}
        }
        Ok(())
    }
}

fn refuse_anchor(anchor: usize, line: usize) -> Result<(), Fault> {
    match anchor {
        0 => Ok(()),
        _ => Err(Fault::new(line, "", "anchors (`&name`) are not read")),
    }
}
