//! The paths of a file: what `use` names, each with the name that it gives, and what code names in full.

use super::tokens::Token;

/// One name that a `use` brings into a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Import {
    /// The module inside the file, from the file's own, in which it stands.
    pub inside: Vec<String>,
    /// The path as written, without `self` at its end.
    pub path: Vec<String>,
    /// The name that it gives; `*` for all.
    pub name: String,
    /// Whether it hands the name on (`pub use`, as far as it may reach).
    pub is_handed_on: bool,
}

/// Everything that a file says of names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    /// What `use` brings.
    pub imports: Vec<Import>,
    /// Modules that lie in files of their own, with the inline modules around them.
    pub files: Vec<Vec<String>>,
    /// Inline modules, from the file's own.
    pub inline: Vec<Vec<String>>,
    /// Items by name, with the module inside the file.
    pub items: Vec<(Vec<String>, String)>,
    /// Macros that `#[macro_export]` puts at the crate's root.
    pub macros: Vec<String>,
    /// Paths in code, `a::b` at least or a single word, with the module inside the file.
    pub mentions: Vec<(Vec<String>, Vec<String>)>,
}

/// What an item begins with; its name follows.
const ITEMS: [&str; 8] = ["fn", "struct", "enum", "trait", "type", "const", "static", "union"];

/// Reads the names of a file.
pub fn names(tokens: &[Token]) -> Names {
    let mut found = Names::default();
    let mut inside: Vec<(String, usize)> = Vec::new();
    let (mut depth, mut at) = (0, 0);
    let word = |at: usize| tokens.get(at).and_then(Token::word);
    while at < tokens.len() {
        let here = || inside.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        match &tokens[at] {
            Token::Sign('{') => depth += 1,
            Token::Sign('}') => {
                depth -= 1;
                inside.retain(|(_, begin)| *begin <= depth);
            }
            Token::Word(use_word) if use_word == "use" && !is_capture(tokens, at) => {
                let is_handed_on = is_public(&tokens[..at]);
                let mut read = Vec::new();
                at = use_tree(tokens, at + 1, &[], &mut read);
                found.imports.extend(read.into_iter().map(|(path, name)| Import {
                    inside: here(),
                    path,
                    name,
                    is_handed_on,
                }));
                continue;
            }
            Token::Word(item) if item == "mod" && word(at + 1).is_some() => {
                let mut path = here();
                let name = word(at + 1).unwrap_or_default().to_owned();
                path.push(name.clone());
                if tokens.get(at + 2).is_some_and(|next| next.is_sign(';')) {
                    found.files.push(path);
                } else {
                    found.inline.push(path);
                    inside.push((name, depth + 1));
                }
                at += 2;
                continue;
            }
            Token::Word(item) if item == "macro_rules" && word(at + 2).is_some() => {
                let name = word(at + 2).unwrap_or_default().to_owned();
                let before = &tokens[at.saturating_sub(8)..at];
                if before.iter().any(|token| token.is("macro_export")) {
                    found.macros.push(name.clone());
                }
                found.items.push((here(), name));
                at += 3;
                continue;
            }
            Token::Word(item) if ITEMS.contains(&item.as_str()) && word(at + 1).is_some() => {
                let name = word(at + 1).filter(|name| !ITEMS.contains(name));
                // Methods and local items have no path of their own.
                if depth == inside.last().map_or(0, |(_, begin)| *begin) {
                    found.items.extend(name.map(|name| (here(), name.to_owned())));
                }
            }
            Token::Word(_) if begins_path(tokens, at) => {
                let (path, end) = inline_path(tokens, at);
                found.mentions.push((here(), path));
                at = end;
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    found
}

/// `impl FormatTrait + use<'a>` imports nothing.
fn is_capture(tokens: &[Token], at: usize) -> bool {
    tokens.get(at + 1).is_some_and(|next| next.is_sign('<'))
}

/// Whether `pub` or `pub(..)` stands last.
fn is_public(before: &[Token]) -> bool {
    match before.last() {
        Some(Token::Sign(')')) => {
            let open = before.iter().rposition(|token| token.is_sign('('));
            open.is_some_and(|open| open > 0 && before[open - 1].is("pub"))
        }
        Some(last) => last.is("pub"),
        None => false,
    }
}

/// Whether a path begins here: not a field, a method or a path's later piece, nor the name of an item.
fn begins_path(tokens: &[Token], at: usize) -> bool {
    let Some(before) = at.checked_sub(1).map(|before| &tokens[before]) else { return true };
    let is_range = before.is_sign('.') && at > 1 && tokens[at - 2].is_sign('.');
    let is_root = before.is_sign(':') && at > 1 && tokens[at - 2].is_sign(':');
    (!before.is_sign('.') || is_range) && !is_root
}

/// The path that begins at a token, and where it ends.
fn inline_path(tokens: &[Token], begin: usize) -> (Vec<String>, usize) {
    let mut path = Vec::new();
    let mut at = begin;
    while let Some(word) = tokens.get(at).and_then(Token::word) {
        path.push(word.to_owned());
        at += 1;
        let goes_on = tokens[at..].iter().take(2).filter(|token| token.is_sign(':')).count() == 2;
        if !goes_on || tokens.get(at + 2).and_then(Token::word).is_none() {
            break;
        }
        at += 2;
    }
    (path, at)
}

/// Reads a tree of `use` from a token on; answers where it ends.
fn use_tree(
    tokens: &[Token],
    begin: usize,
    stem: &[String],
    found: &mut Vec<(Vec<String>, String)>,
) -> usize {
    let mut path = stem.to_vec();
    let mut at = begin;
    loop {
        match tokens.get(at) {
            Some(Token::Word(word)) if word == "as" => {
                let name = tokens.get(at + 1).and_then(Token::word).unwrap_or("_").to_owned();
                found.push((without_self(path), name));
                return at + 2;
            }
            Some(Token::Word(word)) => path.push(word.clone()),
            Some(Token::Sign(':')) => {}
            Some(Token::Sign('*')) => {
                found.push((path, "*".to_owned()));
                return at + 1;
            }
            Some(Token::Sign('{')) => {
                at += 1;
                while tokens.get(at).is_some_and(|token| !token.is_sign('}')) {
                    at = use_tree(tokens, at, &path, found);
                    at += usize::from(tokens.get(at).is_some_and(|token| token.is_sign(',')));
                }
                return at + 1;
            }
            _ => {
                path = without_self(path);
                let name = path.last().cloned().unwrap_or_default();
                found.push((path, name));
                return at;
            }
        }
        at += 1;
    }
}

/// `a::self` is `a`.
fn without_self(mut path: Vec<String>) -> Vec<String> {
    if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
        path.pop();
    }
    path
}

/// All paths of a file from their beginning, as far as names tell: what `use` brings, and what code names.
pub fn full_paths(names: &Names) -> Vec<Vec<String>> {
    let mut found: Vec<_> = names.imports.iter().map(|import| import.path.clone()).collect();
    for (inside, path) in &names.mentions {
        let given = names.imports.iter().find(|i| i.inside == *inside && i.name == path[0]);
        let stem = given.map_or(&path[..1], |import| &import.path);
        found.push([stem, &path[1..]].concat());
    }
    found
}

#[test]
fn trees_of_use_and_paths_in_code_are_read() {
    let code = "pub(crate) use a::{b::{self, C as D}, e::*}; mod f; mod g { use super::h; }
        fn i() -> impl X + use<'_> { std::fs::read(crate::j::k(..l::M)) }";
    let names = names(&super::tokens::tokens(code));
    let given: Vec<_> = names.imports.iter().map(|i| (i.path.join("::"), &*i.name)).collect();
    let expected = [("a::b", "b"), ("a::b::C", "D"), ("a::e", "*"), ("super::h", "h")];
    assert_eq!(given, expected.map(|(path, name)| (path.to_owned(), name)));
    assert!(names.imports[0].is_handed_on && !names.imports[3].is_handed_on);
    assert_eq!(
        (&names.imports[3].inside[..], &names.files),
        (&["g".to_owned()][..], &vec![vec!["f".to_owned()]])
    );
    let said: Vec<_> = full_paths(&names).iter().map(|path| path.join("::")).collect();
    for path in ["std::fs::read", "crate::j::k", "l::M"] {
        assert!(said.iter().any(|own| own == path), "{path}: {said:?}");
    }
}
