//! XML as OpenCV's `FileStorage` writes it, to the tree of the same content in YAML.
//!
//! Elements, texts, comments and the five named entities are read. Declarations of types, which could expand without
//! end, are refused.

use fabkit_text::{
    MAX_DEPTH, MAX_NODES, Position, YamlContent, YamlEntry, YamlFault, YamlNode, to_printable,
};

/// Name of the outermost element.
const ROOT: &str = "opencv_storage";

/// Parses a text. The faults are those of elements written twice.
pub(super) fn parse(text: &str) -> Result<(YamlNode, Vec<YamlFault>), YamlFault> {
    let mut parser = Parser { rest: text, line: 1, nodes: 0, twice: Vec::new() };
    parser.skip_insignificant()?;
    let (name, value) = parser.element(0)?;
    if name != ROOT {
        let message = format!("the outermost element is `{}`", to_printable(name));
        let hint = format!("camera files in XML are those of OpenCV's FileStorage, <{ROOT}>");
        return Err(YamlFault::new(value.position, "", message).hint(hint));
    }
    parser.skip_insignificant()?;
    if parser.rest.is_empty() {
        Ok((value, parser.twice))
    } else {
        Err(parser.fault(format!("text follows </{ROOT}>")))
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
        YamlFault::new(self.position(), "", message).hint("was the file cut off or edited?")
    }

    /// Skips `count` bytes and counts their lines.
    fn skip(&mut self, count: usize) -> &'a str {
        let (skipped, rest) = self.rest.split_at(count);
        self.line += skipped.bytes().filter(|byte| *byte == b'\n').count();
        self.rest = rest;
        skipped
    }

    /// Skips all up to `end`, and that too. Returns what lies before.
    fn skip_past(&mut self, end: &str) -> Result<&'a str, YamlFault> {
        match self.rest.find(end) {
            Some(at) => {
                let before = self.skip(at);
                self.skip(end.len());
                Ok(before)
            }
            None => Err(self.fault(format!("`{end}` is missing behind this line"))),
        }
    }

    /// Skips spaces, comments and the first line, `<?xml ... ?>`.
    fn skip_insignificant(&mut self) -> Result<(), YamlFault> {
        loop {
            self.skip(self.rest.len() - self.rest.trim_start().len());
            if self.rest.starts_with("<!--") {
                self.skip_past("-->")?;
            } else if self.rest.starts_with("<?") {
                self.skip_past("?>")?;
            } else if self.rest.starts_with("<!") {
                return Err(self.fault("declarations such as `<!DOCTYPE` are not read"));
            } else {
                return Ok(());
            }
        }
    }

    /// Reads one element with all that it holds.
    fn element(&mut self, depth: usize) -> Result<(&'a str, YamlNode), YamlFault> {
        let position = self.position();
        self.count(depth)?;
        if !self.rest.starts_with('<') {
            return Err(self.fault("an element `<name>` is expected here"));
        }
        self.skip(1);
        let tag = self.skip_past(">")?;
        let (tag, is_empty) = tag.strip_suffix('/').map_or((tag, false), |tag| (tag, true));
        // Attributes give types, which the reader of a value knows.
        let name = tag.split_whitespace().next().unwrap_or_default();
        if name.is_empty() || name.contains(['<', '/', '"']) {
            return Err(self.fault("an element without a name"));
        }
        if is_empty {
            return Ok((name, YamlNode { position, content: YamlContent::Nothing }));
        }
        let mut text = String::new();
        let mut children: Vec<YamlEntry> = Vec::new();
        loop {
            let until = self.rest.find('<').unwrap_or(self.rest.len());
            text += self.skip(until);
            self.skip_insignificant()?;
            if self.rest.is_empty() {
                return Err(self.fault(format!("`</{}>` is missing", to_printable(name))));
            }
            if let Some(closing) = self.rest.strip_prefix("</") {
                let closes = closing.split('>').next().map(str::trim) == Some(name);
                if !closes || !closing.contains('>') {
                    let name = to_printable(name);
                    let begin = position.line;
                    return Err(self.fault(format!("`</{name}>` of line {begin} is expected here")));
                }
                self.skip_past(">")?;
                break;
            }
            // Comments may stand before a text.
            if self.rest.starts_with('<') {
                let key_position = self.position();
                let (key, value) = self.element(depth + 1)?;
                children.push(YamlEntry { key: key.to_owned(), key_position, value });
            }
        }
        let content = self.content(name, &text, children)?;
        Ok((name, YamlNode { position, content }))
    }

    /// Counts a node and refuses more than [`MAX_NODES`], or too deep ones.
    fn count(&mut self, depth: usize) -> Result<(), YamlFault> {
        self.nodes += 1;
        if self.nodes > MAX_NODES || depth > MAX_DEPTH {
            let message =
                format!("more than {MAX_NODES} values, or nested more than {MAX_DEPTH} deep");
            return Err(self.fault(message));
        }
        Ok(())
    }

    /// Returns the content of an element: a mapping of its children, the list of those called `_`, or its text.
    fn content(
        &mut self,
        name: &str,
        text: &str,
        children: Vec<YamlEntry>,
    ) -> Result<YamlContent, YamlFault> {
        if !children.is_empty() {
            if children.iter().all(|child| child.key == "_") {
                return Ok(YamlContent::List(children.into_iter().map(|c| c.value).collect()));
            }
            let mut entries: Vec<YamlEntry> = Vec::new();
            for child in children {
                if entries.iter().any(|entry| entry.key == child.key) {
                    let message = format!("`{}` is written twice", to_printable(&child.key));
                    let fault = YamlFault::new(child.key_position, "", message);
                    self.twice.push(fault.hint("keep one of them"));
                } else {
                    entries.push(child);
                }
            }
            return Ok(YamlContent::Map(entries));
        }
        let text = text.trim();
        let words: Vec<&str> = text.split_whitespace().collect();
        let are_numbers = words.len() > 1 && words.iter().all(|word| word.parse::<f64>().is_ok());
        // The numbers of a matrix are a list, even one or none.
        if name == "data" || are_numbers {
            let position = self.position();
            let mut items = Vec::with_capacity(words.len());
            for word in words {
                self.count(0)?;
                items.push(YamlNode { position, content: YamlContent::Scalar(word.to_owned()) });
            }
            return Ok(YamlContent::List(items));
        }
        if text.is_empty() {
            return Ok(YamlContent::Nothing);
        }
        let quoted = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
        Ok(YamlContent::Scalar(unescape(quoted.unwrap_or(text))))
    }
}

/// Replaces the five named entities.
fn unescape(text: &str) -> String {
    // `&amp;` last: `&amp;lt;` is `&lt;`.
    [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")]
        .iter()
        .fold(text.to_owned(), |text, (entity, letter)| text.replace(entity, letter))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::read;

    const FILE: &str = "<?xml version=\"1.0\"?>\n<opencv_storage>\n<calibration_time>\"Mon 1 Jan\"\
        </calibration_time>\n<!-- of a test -->\n<image_width>640</image_width>\n<image_height>480\
        </image_height>\n<fisheye_model>0</fisheye_model>\n<camera_matrix type_id=\"opencv-matrix\">\
        \n  <rows>3</rows>\n  <cols>3</cols>\n  <dt>d</dt>\n  <data>\n    5.005e+02 0. 319.5 0.\n    \
        500.25 239.5 0. 0. 1.</data></camera_matrix>\n<distortion_coefficients \
        type_id=\"opencv-matrix\">\n  <rows>5</rows>\n  <cols>1</cols>\n  <dt>d</dt>\n  <data>\n    \
        -0.1 0.02 0.001 -0.002 0.</data></distortion_coefficients>\n</opencv_storage>\n";

    #[test]
    fn matrices_are_those_of_yaml() {
        let camera = *read(FILE).unwrap().camera();
        let intrinsics = camera.lens().intrinsics();
        assert_eq!((intrinsics.fx_px, intrinsics.fy_px), (500.5, 500.25));
        assert_eq!(camera.lens().coefficients(), [-0.1, 0.02, 0.001, -0.002, 0.0]);
        let (root, _) = parse(FILE).unwrap();
        assert_eq!(root.get("calibration_time").unwrap().text(), Some("Mon 1 Jan"));
        assert_eq!(root.get("image_width").unwrap().position.line, 5);
    }

    #[test]
    fn sequences_entities_and_empty_elements_are_read() {
        let text = "<opencv_storage><a><_>1</_><_>2</_></a><b>1 2</b><c/><d>&amp;lt;</d><e></e>\
            </opencv_storage>";
        let (root, twice) = parse(text).unwrap();
        assert_eq!(root.get("a").unwrap().items().len(), 2);
        assert_eq!(root.get("b").unwrap().items().len(), 2);
        assert_eq!(root.get("c").unwrap().content, YamlContent::Nothing);
        assert_eq!(root.get("d").unwrap().text(), Some("&lt;"));
        assert_eq!(root.get("e").unwrap().content, YamlContent::Nothing);
        assert_eq!(twice, []);
    }

    #[test]
    fn faults_are_named_with_their_lines() {
        for (from, to, expected) in [
            ("</opencv_storage>", "", "`</opencv_storage>` is missing"),
            ("</image_width>", "", "line 21: `</image_width>` of line 5 is expected here"),
            ("opencv_storage", "storage", "the outermost element is `storage`"),
            ("<opencv_storage>", "<!DOCTYPE a>\n<opencv_storage>", "line 2: declarations"),
            ("500.25", "nan", "camera_matrix: `nan` is not a finite number"),
            (" 0. 0. 1.", " 0. 0.", "camera_matrix: has 8 numbers; 9 are needed"),
            ("<image_width>640</image_width>", "", "image_width: is missing"),
            ("image_height", "image_width", "line 6: `image_width` is written twice"),
        ] {
            let error = read(&FILE.replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(expected), "{to}: {error}");
        }
        let deep = "<a>".repeat(200);
        assert!(read(&deep).unwrap_err().to_string().contains("deep"));
    }
}
