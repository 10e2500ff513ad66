//! Rust as words, signs and texts, without comments: as much of the language as paths need.

/// A piece of code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Token {
    /// A name or keyword.
    Word(String),
    /// The content of a string, a byte string or a character.
    Text(String),
    /// One sign; `::` is two of them.
    Sign(char),
}

impl Token {
    /// Whether it is this word.
    pub fn is(&self, word: &str) -> bool {
        matches!(self, Self::Word(own) if own == word)
    }

    /// Whether it is this sign.
    pub fn is_sign(&self, sign: char) -> bool {
        *self == Self::Sign(sign)
    }

    /// The word that it is, if it is one.
    pub fn word(&self) -> Option<&str> {
        match self {
            Self::Word(word) => Some(word),
            _ => None,
        }
    }
}

/// Splits code into tokens; comments are left out, and so is what `#[cfg(test)]` stands before.
pub fn tokens(code: &str) -> Vec<Token> {
    without_tests(&split(code))
}

fn split(code: &str) -> Vec<Token> {
    let code: Vec<char> = code.chars().collect();
    let mut found = Vec::new();
    let mut at = 0;
    while at < code.len() {
        let next = code.get(at + 1).copied().unwrap_or(' ');
        match code[at] {
            '/' if next == '/' => at += until(&code[at..], &['\n']),
            '/' if next == '*' => at += block_comment(&code[at..]),
            '"' => at += push_text(&code[at..], 0, &mut found),
            '\'' if next == '\\' || code.get(at + 2) == Some(&'\'') => {
                let skipped = if next == '\\' { 3 } else { 2 };
                let length = skipped + until(&code[(at + skipped).min(code.len())..], &['\'']);
                found.push(Token::Text(
                    code[at + 1..(at + length).min(code.len())].iter().collect(),
                ));
                at += length + 1;
            }
            // A lifetime is no name.
            '\'' => at += 1 + word_length(&code[at + 1..]),
            'r' | 'b' | 'c' if raw_hashes(&code[at..]).is_some() => {
                let (prefix, hashes) = raw_hashes(&code[at..]).unwrap();
                at += prefix + push_raw(&code[at + prefix..], hashes, &mut found);
            }
            'b' | 'c' if next == '"' => at += 1 + push_text(&code[at + 1..], 0, &mut found),
            sign if sign.is_alphanumeric() || sign == '_' => {
                let length = word_length(&code[at..]);
                found.push(Token::Word(code[at..at + length].iter().collect()));
                at += length;
            }
            sign => {
                if !sign.is_whitespace() {
                    found.push(Token::Sign(sign));
                }
                at += 1;
            }
        }
    }
    found
}

/// Length up to one of `ends`, or of all.
fn until(code: &[char], ends: &[char]) -> usize {
    code.iter().position(|sign| ends.contains(sign)).unwrap_or(code.len())
}

fn word_length(code: &[char]) -> usize {
    let is_part = |sign: &&char| sign.is_alphanumeric() || **sign == '_';
    code.iter().take_while(is_part).count()
}

/// Length of a block comment, in which others may lie.
fn block_comment(code: &[char]) -> usize {
    let mut depth = 0;
    let mut at = 0;
    while at < code.len() {
        match (code[at], code.get(at + 1)) {
            ('/', Some('*')) => (depth, at) = (depth + 1, at + 2),
            ('*', Some('/')) => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            break;
        }
    }
    at
}

/// Length of `r`, `br` or `cr` and number of the hashes behind it, if a raw string begins here.
fn raw_hashes(code: &[char]) -> Option<(usize, usize)> {
    let prefix = code.iter().position(|sign| *sign == 'r').filter(|at| *at < 2)? + 1;
    let hashes = code[prefix..].iter().take_while(|sign| **sign == '#').count();
    (code.get(prefix + hashes) == Some(&'"')).then_some((prefix, hashes))
}

fn push_raw(code: &[char], hashes: usize, found: &mut Vec<Token>) -> usize {
    let begin = hashes + 1;
    let mut end = begin;
    let closes = |at: usize| {
        code[at] == '"'
            && code[at + 1..].iter().take(hashes).filter(|s| **s == '#').count() == hashes
    };
    while end < code.len() && !closes(end) {
        end += 1;
    }
    found.push(Token::Text(code[begin..end].iter().collect()));
    end + hashes + 1
}

fn push_text(code: &[char], begin: usize, found: &mut Vec<Token>) -> usize {
    let mut end = begin + 1;
    while end < code.len() && code[end] != '"' {
        end += if code[end] == '\\' { 2 } else { 1 };
    }
    found.push(Token::Text(code[begin + 1..end.min(code.len())].iter().collect()));
    end + 1
}

/// Leaves out each item below `#[cfg(test)]`.
fn without_tests(all: &[Token]) -> Vec<Token> {
    let mark = ["#", "[", "cfg", "(", "test", ")", "]"];
    let is_mark = |at: usize| {
        mark.iter().enumerate().all(|(k, piece)| match all.get(at + k) {
            Some(Token::Word(word)) => word == piece,
            Some(Token::Sign(sign)) => piece.starts_with(*sign),
            _ => false,
        })
    };
    let mut found = Vec::new();
    let mut at = 0;
    while at < all.len() {
        if is_mark(at) {
            at += mark.len();
            // An item ends with its first semicolon or brace outside of parentheses.
            at += item_length(&all[at..]);
        } else {
            found.push(all[at].clone());
            at += 1;
        }
    }
    found
}

fn item_length(all: &[Token]) -> usize {
    let mut depth = 0_i32;
    for (at, token) in all.iter().enumerate() {
        let Token::Sign(sign) = token else { continue };
        match sign {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' => depth -= 1,
            '}' => {
                depth -= 1;
                if depth == 0 {
                    return at + 1;
                }
            }
            ';' if depth == 0 => return at + 1,
            _ => {}
        }
    }
    all.len()
}

#[test]
fn comments_texts_and_tests_are_told_from_code() {
    let code = r##"
        //! fs::a
        /* /* fs */ fs::b */ fn f<'a>(x: &'a str) { let c = '\''; let d = 'x'; "fs \" x"; br#"raw"#; }
        #[cfg(test)]
        mod tests { use std::fs; fn g() { } }
        use last;
    "##;
    let found = tokens(code);
    assert!(found.iter().all(|token| !token.is("fs")), "{found:?}");
    let texts: Vec<_> = found.iter().filter(|token| matches!(token, Token::Text(_))).collect();
    assert_eq!(texts.len(), 4, "{texts:?}");
    assert!(found.iter().any(|token| token.is("last")));
}
