//! Parser for the Markdown that the book uses: fenced blocks, headings and links.

/// Parsed page.
#[derive(Debug, Default, PartialEq)]
pub struct Page {
    /// Fenced blocks, in order.
    pub blocks: Vec<Block>,
    /// Anchors of headings, as mdBook and GitHub name them.
    pub anchors: Vec<String>,
    /// Links and images.
    pub links: Vec<Link>,
}

/// Fenced block.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Line of its opening fence, from 1.
    pub line: usize,
    /// First word after the fence; empty without one.
    pub language: String,
    /// Other words after the fence: `fails=2`, `needs=torch`, `file=soft.yaml`, `output`.
    pub options: Vec<String>,
    /// Content, with line ends.
    pub text: String,
}

impl Block {
    /// Returns the value of an option `name=value`.
    pub fn option(&self, name: &str) -> Option<&str> {
        self.options.iter().find_map(|option| option.strip_prefix(name)?.strip_prefix('='))
    }

    /// Returns whether an option without a value is given.
    pub fn has(&self, word: &str) -> bool {
        self.options.iter().any(|option| option == word)
    }
}

/// Target of a link.
#[derive(Debug, PartialEq)]
pub struct Link {
    /// Line of the link, from 1.
    pub line: usize,
    /// Target as written.
    pub target: String,
}

/// Parses a page.
///
/// # Errors
/// A fence that is not closed.
pub fn read(text: &str) -> Result<Page, String> {
    let mut page = Page::default();
    let mut open: Option<Block> = None;
    for (line, content) in (1..).zip(text.lines()) {
        match (&mut open, content.strip_prefix("```")) {
            (None, Some(info)) => {
                let mut words = info.split_whitespace().map(str::to_owned);
                let language = words.next().unwrap_or_default();
                open =
                    Some(Block { line, language, options: words.collect(), text: String::new() });
            }
            (Some(_), Some("")) => page.blocks.extend(open.take()),
            (Some(block), _) => {
                block.text += content;
                block.text.push('\n');
            }
            (None, None) => {
                if content.starts_with('#') {
                    page.anchors.push(anchor(content.trim_start_matches('#')));
                }
                page.links.extend(links(content).map(|target| Link { line, target }));
            }
        }
    }
    match open {
        Some(block) => Err(format!("line {}: the block is not closed", block.line)),
        None => Ok(page),
    }
}

/// Derives the anchor of a heading as mdBook and GitHub do: lower case, spaces as hyphens, only letters, digits, `-`
/// and `_`.
pub fn anchor(heading: &str) -> String {
    let kept = |c: char| match c {
        ' ' => Some('-'),
        c if c.is_alphanumeric() || "-_".contains(c) => Some(c),
        _ => None,
    };
    heading.trim().to_lowercase().chars().filter_map(kept).collect()
}

/// Finds the targets of `[words](target)`, `src="target"` and `href="target"` outside of inline code.
fn links(line: &str) -> impl Iterator<Item = String> {
    let prose: String = line.split('`').step_by(2).collect();
    let mut found = Vec::new();
    for (opening, closing) in [("](", ')'), ("src=\"", '"'), ("href=\"", '"')] {
        let targets = prose.split(opening).skip(1).filter_map(|rest| rest.split(closing).next());
        found.extend(targets.map(str::to_owned));
    }
    found.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_keep_their_options_and_lines() {
        let page = read("# One `x`\n\n```console fails=2\n$ a\n```\n\n## Two: words\n").unwrap();
        assert_eq!(page.anchors, ["one-x", "two-words"]);
        let [block] = &page.blocks[..] else { panic!("{page:?}") };
        assert_eq!((block.line, block.language.as_str()), (3, "console"));
        assert_eq!((block.option("fails"), block.option("needs")), (Some("2"), None));
        assert_eq!(block.text, "$ a\n");
    }

    #[test]
    fn links_in_blocks_and_code_are_none() {
        let text = "[a](b.md#c) `[d](e)`\n```text\n[f](g)\n```\n<img src=\"h.png\">\n";
        let targets: Vec<_> =
            read(text).unwrap().links.into_iter().map(|l| (l.line, l.target)).collect();
        assert_eq!(targets, [(1, "b.md#c".to_owned()), (5, "h.png".to_owned())]);
    }

    #[test]
    fn an_open_block_is_named() {
        assert_eq!(read("a\n```yaml\n").unwrap_err(), "line 2: the block is not closed");
    }
}
