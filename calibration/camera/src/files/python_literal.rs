//! Python dictionaries of numbers, texts and lists, as mrcal writes them, to the tree of the same content in YAML.

use fabkit_text::{
    MAX_DEPTH, MAX_NODES, Position, YamlContent, YamlEntry, YamlFault, YamlNode, to_printable,
};

/// Parses one dictionary. The faults are those of keys written twice.
pub(super) fn parse(text: &str) -> Result<(YamlNode, Vec<YamlFault>), YamlFault> {
    let mut parser = Parser { rest: text, line: 1, nodes: 0, twice: Vec::new() };
    let root = parser.value(0)?;
    match parser.peek() {
        None => Ok((root, parser.twice)),
        Some(_) => Err(parser.fault("the dictionary ends here, but the file goes on")),
    }
}

/// Rest of the text, and what is known of the part before it.
struct Parser<'a> {
    rest: &'a str,
    line: usize,
    nodes: usize,
    twice: Vec<YamlFault>,
}

impl<'a> Parser<'a> {
    fn position(&self) -> Position {
        Position { line: self.line, column: 1 }
    }

    fn fault(&self, message: impl Into<String>) -> YamlFault {
        YamlFault::new(self.position(), "", message)
            .hint("a camera model of mrcal is one Python dictionary; was the file cut off?")
    }

    /// Skips `count` bytes and counts their lines.
    fn skip(&mut self, count: usize) -> &'a str {
        let (skipped, rest) = self.rest.split_at(count);
        self.line += skipped.bytes().filter(|byte| *byte == b'\n').count();
        self.rest = rest;
        skipped
    }

    /// Skips spaces and comments, and returns the next character.
    fn peek(&mut self) -> Option<char> {
        loop {
            let spaces = self.rest.len() - self.rest.trim_start().len();
            self.skip(spaces);
            if !self.rest.starts_with('#') {
                return self.rest.chars().next();
            }
            self.skip(self.rest.find('\n').unwrap_or(self.rest.len()));
        }
    }

    /// Skips a character if it is the next one.
    fn accept(&mut self, wanted: char) -> bool {
        let is_next = self.peek() == Some(wanted);
        if is_next {
            self.skip(wanted.len_utf8());
        }
        is_next
    }

    fn value(&mut self, depth: usize) -> Result<YamlNode, YamlFault> {
        let next = self.peek();
        let position = self.position();
        self.nodes += 1;
        if self.nodes > MAX_NODES || depth > MAX_DEPTH {
            return Err(self.fault(format!(
                "more than {MAX_NODES} values, or nested more than {MAX_DEPTH} deep"
            )));
        }
        let content = match next {
            Some('{') => self.dictionary(depth)?,
            Some('[') => self.list(']', depth)?,
            Some('(') => self.list(')', depth)?,
            Some(_) => self.scalar()?,
            None => return Err(self.fault("the file ends where a value is expected")),
        };
        Ok(YamlNode { position, content })
    }

    fn dictionary(&mut self, depth: usize) -> Result<YamlContent, YamlFault> {
        self.skip(1);
        let mut entries: Vec<YamlEntry> = Vec::new();
        while !self.accept('}') {
            self.peek();
            let key_position = self.position();
            let YamlContent::Scalar(key) = self.scalar()? else {
                return Err(self.fault("this is not a key"));
            };
            if !self.accept(':') {
                return Err(self.fault(format!("no colon behind `{}`", to_printable(&key))));
            }
            let value = self.value(depth + 1)?;
            if entries.iter().any(|entry| entry.key == key) {
                let message = format!("`{}` is written twice", to_printable(&key));
                self.twice.push(YamlFault::new(key_position, "", message).hint("keep one of them"));
            } else {
                entries.push(YamlEntry { key, key_position, value });
            }
            if !self.accept(',') && self.peek() != Some('}') {
                return Err(self.fault("neither a comma nor the end of the dictionary follows"));
            }
        }
        Ok(YamlContent::Map(entries))
    }

    fn list(&mut self, end: char, depth: usize) -> Result<YamlContent, YamlFault> {
        self.skip(1);
        let mut items = Vec::new();
        while !self.accept(end) {
            items.push(self.value(depth + 1)?);
            if !self.accept(',') && self.peek() != Some(end) {
                return Err(self.fault("neither a comma nor the end of the list follows"));
            }
        }
        Ok(YamlContent::List(items))
    }

    /// Reads a text, a number or a name such as `None`.
    fn scalar(&mut self) -> Result<YamlContent, YamlFault> {
        self.peek();
        // Texts may be bytes, `b'...'`.
        let prefix = self.rest.len() - self.rest.trim_start_matches(['b', 'r', 'u']).len();
        let quote = self.rest[prefix..].chars().next().filter(|next| matches!(next, '\'' | '"'));
        if let Some(quote) = quote {
            let text: &'a str = &self.rest[prefix + 1..];
            let mut is_escaped = false;
            let end = text.char_indices().find(|(_, next)| {
                let is_end = *next == quote && !is_escaped;
                is_escaped = *next == '\\' && !is_escaped;
                is_end
            });
            let Some((end, _)) = end else {
                return Err(self.fault("a text begins here and does not end"));
            };
            self.skip(prefix + 1 + end + 1);
            return Ok(YamlContent::Scalar(text[..end].to_owned()));
        }
        let is_word =
            |next: char| next.is_ascii_alphanumeric() || matches!(next, '+' | '-' | '.' | '_');
        let end = self.rest.find(|next| !is_word(next)).unwrap_or(self.rest.len());
        match self.skip(end) {
            "" => Err(self.fault("a value is expected here")),
            "None" => Ok(YamlContent::Nothing),
            word => Ok(YamlContent::Scalar(word.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dictionaries_become_trees() {
        let text =
            "# text\n{\n 'a': [1, -2.5e-3,],\n \"b\": (1,), 'c': None, 'd': b'x#{}\\'y', }\n";
        let (root, twice) = parse(text).unwrap();
        let words = |key: &str| -> Vec<Option<String>> {
            root.get(key).unwrap().items().iter().map(|i| i.text().map(str::to_owned)).collect()
        };
        assert_eq!(words("a"), [Some("1".into()), Some("-2.5e-3".into())]);
        assert_eq!(words("b"), [Some("1".into())]);
        assert_eq!(root.get("c").unwrap().content, YamlContent::Nothing);
        assert_eq!(root.get("d").unwrap().text(), Some("x#{}\\'y"));
        assert_eq!(root.get("b").unwrap().position.line, 4);
        assert_eq!(twice, []);
    }

    #[test]
    fn texts_that_are_none_are_refused_with_their_line() {
        for (text, expected) in [
            ("{'a': 1", "line 1: neither a comma nor the end"),
            ("{'a': 1}\n{", "line 2: the dictionary ends here"),
            ("{'a'\n 1}", "line 2: no colon behind `a`"),
            ("{'a: 1}", "a text begins here"),
            ("{'a': }", "a value is expected"),
            ("{'a': [1 2]}", "neither a comma nor the end of the list"),
            (&"{'a': ".repeat(100), "deep"),
        ] {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
