//! The paths that tokens name.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

/// A path that the code names, as `crate::a::B`.
#[derive(Clone, Debug)]
pub struct NamedPath {
    /// Its parts; a first part that is empty stands for a leading `::`.
    pub segments: Vec<String>,
    /// The name it gets in the module, by `use` alone: its last part, or what follows `as`.
    pub name: String,
    pub kind: PathKind,
    /// Whether it is a `use` that others see, too.
    pub public: bool,
    /// Where it is.
    pub line: usize,
}

/// What a path stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathKind {
    /// An item or a module.
    Item,
    /// All items of a module, by `*`.
    Glob,
    /// A macro that is called.
    Macro,
    /// A method that is called, as `.method()`: the path is its name.
    Method,
}

/// All paths in tokens, also within groups of any kind. Items for tests alone are left out.
pub fn paths(tokens: TokenStream) -> Vec<NamedPath> {
    let mut found = Vec::new();
    add_paths(&tokens.into_iter().collect::<Vec<_>>(), &mut found);
    found
}

fn add_paths(tokens: &[TokenTree], found: &mut Vec<NamedPath>) {
    let mut at = 0;
    while at < tokens.len() {
        if is_test_attribute(&tokens[at..]) {
            at = end_of_item(tokens, at + 2);
            continue;
        }
        match &tokens[at] {
            TokenTree::Ident(word) if word == "pub" && is_visibility(tokens.get(at + 1)) => at += 1,
            TokenTree::Group(group) => {
                let inner: Vec<_> = group.stream().into_iter().collect();
                add_paths(&inner, found);
            }
            TokenTree::Punct(_) if is_colons(&tokens[at..]) && !continues(tokens, at) => {
                at = add_path(tokens, at + 2, vec![String::new()], found);
                continue;
            }
            TokenTree::Ident(_) if !continues(tokens, at) => {
                at = add_path(tokens, at, Vec::new(), found);
                continue;
            }
            TokenTree::Ident(method) if is_method_call(tokens, at) => found.push(NamedPath {
                segments: vec![method.to_string()],
                name: String::new(),
                kind: PathKind::Method,
                public: false,
                line: method.span().start().line,
            }),
            _ => {}
        }
        at += 1;
    }
}

/// Whether a token goes on with what is before it: a method, a lifetime, or the rest of `<T>::Item`.
fn continues(tokens: &[TokenTree], at: usize) -> bool {
    let before = |n: usize| at.checked_sub(n).map(|at| &tokens[at]);
    let is = |n: usize, mark: char| before(n).is_some_and(|token| is_punct(token, mark));
    if is_colons(&tokens[at..]) {
        return is(1, '>');
    }
    is(1, '\'') || (is(1, '.') && !is(2, '.')) || at >= 2 && is_colons(&tokens[at - 2..])
}

/// Whether a token is the name in `.method(...)` or `.method::<T>(...)`.
fn is_method_call(tokens: &[TokenTree], at: usize) -> bool {
    let is_called = match tokens.get(at + 1) {
        Some(TokenTree::Group(group)) => group.delimiter() == Delimiter::Parenthesis,
        _ => is_colons(&tokens[at + 1..]),
    };
    is_called && at > 0 && is_punct(&tokens[at - 1], '.')
}

/// Adds the path that begins with the token at `at`, or the paths of a tree of them; gives the place behind.
fn add_path(
    tokens: &[TokenTree],
    mut at: usize,
    mut segments: Vec<String>,
    found: &mut Vec<NamedPath>,
) -> usize {
    loop {
        match tokens.get(at) {
            Some(TokenTree::Ident(ident)) => {
                segments.push(ident.to_string().trim_start_matches("r#").to_owned());
                let line = ident.span().start().line;
                if is_colons(&tokens[at + 1..]) && is_segment(tokens.get(at + 3)) {
                    at += 3;
                    continue;
                }
                let calls_macro = tokens.get(at + 1).is_some_and(|t| is_punct(t, '!'))
                    && !tokens.get(at + 2).is_some_and(|t| is_punct(t, '='));
                let kind = if calls_macro {
                    PathKind::Macro
                } else {
                    PathKind::Item
                };
                let alias = alias(&tokens[at + 1..]);
                let behind = at + 1 + if alias.is_some() { 2 } else { 0 };
                found.push(named(segments, alias, kind, line));
                return behind;
            }
            Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
                let inner: Vec<_> = group.stream().into_iter().collect();
                for tree in inner.split(|token| is_punct(token, ',')) {
                    if !tree.is_empty() {
                        add_path(tree, 0, segments.clone(), found);
                    }
                }
                return at + 1;
            }
            Some(TokenTree::Punct(punct)) if punct.as_char() == '*' => {
                found.push(NamedPath {
                    segments,
                    name: String::new(),
                    kind: PathKind::Glob,
                    public: false,
                    line: punct.span().start().line,
                });
                return at + 1;
            }
            _ => return at,
        }
    }
}

/// A path with the name that it gets; `a::self` is `a`.
fn named(
    mut segments: Vec<String>,
    alias: Option<String>,
    kind: PathKind,
    line: usize,
) -> NamedPath {
    if segments.len() > 1 && segments.last().is_some_and(|last| last == "self") {
        segments.pop();
    }
    let last = segments.last().cloned();
    NamedPath {
        name: alias.or(last).unwrap_or_default(),
        segments,
        kind,
        public: false,
        line,
    }
}

fn alias(tokens: &[TokenTree]) -> Option<String> {
    match tokens {
        [TokenTree::Ident(word), TokenTree::Ident(name), ..] if word == "as" => {
            Some(name.to_string())
        }
        _ => None,
    }
}

fn is_segment(token: Option<&TokenTree>) -> bool {
    match token {
        Some(TokenTree::Ident(_)) => true,
        Some(TokenTree::Group(group)) => group.delimiter() == Delimiter::Brace,
        Some(TokenTree::Punct(punct)) => punct.as_char() == '*',
        _ => false,
    }
}

/// Whether tokens begin with `::`.
fn is_colons(tokens: &[TokenTree]) -> bool {
    match tokens {
        [TokenTree::Punct(a), b, ..] => {
            a.as_char() == ':' && a.spacing() == Spacing::Joint && is_punct(b, ':')
        }
        _ => false,
    }
}

/// Whether a token is what may follow `pub`, as `(super)`.
pub fn is_visibility(token: Option<&TokenTree>) -> bool {
    let Some(TokenTree::Group(group)) = token else {
        return false;
    };
    let first = group.stream().into_iter().next();
    let first = first.map(|token| token.to_string()).unwrap_or_default();
    group.delimiter() == Delimiter::Parenthesis
        && ["crate", "in", "self", "super"].contains(&first.as_str())
}

/// Whether a token is this punctuation mark.
pub fn is_punct(token: &TokenTree, mark: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == mark)
}

/// Whether tokens begin with an attribute by which what follows is for tests alone.
pub fn is_test_attribute(tokens: &[TokenTree]) -> bool {
    match tokens {
        [hash, TokenTree::Group(attribute), ..] if is_punct(hash, '#') => {
            let inner: Vec<_> = attribute.stream().into_iter().collect();
            match &inner[..] {
                [TokenTree::Ident(test)] => test == "test",
                [TokenTree::Ident(cfg), TokenTree::Group(condition)] => {
                    cfg == "cfg" && needs_test(condition.stream())
                }
                _ => false,
            }
        }
        _ => false,
    }
}

/// Whether a condition is one that only tests fulfil: `test`, or `all` with it.
fn needs_test(condition: TokenStream) -> bool {
    let tokens: Vec<_> = condition.into_iter().collect();
    match &tokens[..] {
        [TokenTree::Ident(name)] => name == "test",
        [TokenTree::Ident(all), TokenTree::Group(conditions)] if all == "all" => {
            let conditions: Vec<_> = conditions.stream().into_iter().collect();
            let mut each = conditions.split(|token| is_punct(token, ','));
            each.any(|condition| needs_test(condition.iter().cloned().collect()))
        }
        _ => false,
    }
}

/// The place behind what begins at `at`: an item ends with its braces or its semicolon, a field or a variant
/// with its comma.
pub fn end_of_item(tokens: &[TokenTree], at: usize) -> usize {
    let mut is_function = false;
    for (n, token) in tokens.iter().enumerate().skip(at) {
        match token {
            TokenTree::Ident(word) if word == "fn" => is_function = true,
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => return n + 1,
            TokenTree::Punct(punct) if punct.as_char() == ';' => return n + 1,
            TokenTree::Punct(punct) if punct.as_char() == ',' && !is_function => return n + 1,
            _ => {}
        }
    }
    tokens.len()
}
