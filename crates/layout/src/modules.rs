//! The modules of a crate: what each defines, what it gets by `use`, and which paths it names.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::{Path as FilePath, PathBuf};
use std::str::FromStr;

use proc_macro2::{Delimiter, TokenStream, TokenTree};

use crate::paths::{NamedPath, end_of_item, is_punct, is_test_attribute, is_visibility, paths};

/// All modules of a crate.
pub struct Sources {
    /// The files, as they are named in faults: relative to the folder of the root file.
    pub(crate) files: Vec<String>,
    pub(crate) modules: Vec<Module>,
    /// Macros that every module can call, by the file that defines them.
    pub(crate) macros: HashMap<String, usize>,
    /// The files that define functions and methods of a name.
    pub(crate) functions: HashMap<String, HashSet<usize>>,
}

/// A module: a file, or a part of one.
#[derive(Default)]
pub(crate) struct Module {
    pub file: usize,
    pub parent: Option<usize>,
    pub children: HashMap<String, usize>,
    pub definitions: HashSet<String>,
    /// The paths of `use`.
    pub uses: Vec<NamedPath>,
    /// All other paths.
    pub paths: Vec<NamedPath>,
    /// The methods of types: the path of a type, and a method's name.
    pub methods: Vec<(Vec<String>, String)>,
}

/// Why the sources could not be read.
#[derive(Debug)]
pub struct ReadError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong with it.
    pub reason: String,
}

impl std::fmt::Display for ReadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.file.display(), self.reason)
    }
}

impl std::error::Error for ReadError {}

impl Sources {
    /// Reads a crate from its root file, `lib.rs` or `main.rs`.
    ///
    /// # Errors
    /// If a file is missing or is no Rust.
    pub fn read(root: impl AsRef<FilePath>) -> Result<Self, ReadError> {
        let root = root.as_ref();
        let mut reader = Reader {
            root: root.parent().unwrap_or(FilePath::new(".")).to_owned(),
            sources: Self {
                files: Vec::new(),
                modules: Vec::new(),
                macros: HashMap::new(),
                functions: HashMap::new(),
            },
        };
        reader.read_file(root, None)?;
        Ok(reader.sources)
    }

    /// The files that were read, relative to the folder of the root file.
    #[must_use]
    pub fn files(&self) -> &[String] {
        &self.files
    }
}

struct Reader {
    root: PathBuf,
    sources: Sources,
}

impl Reader {
    /// Reads a file as a module, and gives the module's number.
    fn read_file(&mut self, file: &FilePath, parent: Option<usize>) -> Result<usize, ReadError> {
        let error = |reason: String| ReadError {
            file: file.to_owned(),
            reason,
        };
        let text = fs::read_to_string(file).map_err(|e| error(e.to_string()))?;
        let tokens = TokenStream::from_str(&text).map_err(|e| error(e.to_string()))?;
        let name = file.strip_prefix(&self.root).unwrap_or(file);
        let name = name.to_string_lossy().replace('\\', "/");
        self.sources.files.push(name);
        let number = self.sources.files.len() - 1;
        let stem = file.file_stem().unwrap_or_default();
        let mut folder = file.parent().unwrap_or(FilePath::new(".")).to_owned();
        if parent.is_some() && stem != "mod" {
            folder.push(stem);
        }
        self.read_module(tokens, number, parent, &folder)
    }

    /// Reads a module whose child modules' files are in `folder`.
    fn read_module(
        &mut self,
        tokens: TokenStream,
        file: usize,
        parent: Option<usize>,
        folder: &FilePath,
    ) -> Result<usize, ReadError> {
        let number = self.sources.modules.len();
        self.sources.modules.push(Module {
            file,
            parent,
            ..Module::default()
        });
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        while at < tokens.len() {
            let start = at;
            let (mut for_tests, mut exported) = (false, false);
            while let Some(behind) = behind_attribute(&tokens, at) {
                for_tests |= is_test_attribute(&tokens[at..]);
                exported |= tokens[at + 1].to_string().contains("macro_export");
                at = behind;
            }
            let item = Item::new(&tokens[at..]);
            let end = at + item.length;
            if !for_tests {
                self.add_item(number, &item, &tokens[at..end], exported, folder)?;
                // What attributes name counts as well, as `derive` does.
                let attributes = tokens[start..at].iter().cloned().collect();
                self.sources.modules[number].paths.extend(paths(attributes));
            }
            at = end.max(start + 1);
        }
        Ok(number)
    }

    fn add_item(
        &mut self,
        module: usize,
        item: &Item,
        tokens: &[TokenTree],
        exported: bool,
        folder: &FilePath,
    ) -> Result<(), ReadError> {
        let file = self.sources.modules[module].file;
        if let Some(name) = &item.name {
            let definitions = &mut self.sources.modules[module].definitions;
            match item.keyword.as_str() {
                "mod" => return self.add_child(module, name, tokens, folder),
                "macro_rules" => {
                    self.sources.macros.insert(name.clone(), file);
                    definitions.insert(name.clone());
                    if exported {
                        self.sources.modules[0].definitions.insert(name.clone());
                    }
                }
                _ => {
                    definitions.insert(name.clone());
                }
            }
        }
        let functions = functions(tokens);
        if item.keyword == "impl"
            && let Some(implemented) = inherent_type(tokens)
        {
            let methods = functions.iter().cloned();
            let methods = methods.map(|method| (implemented.clone(), method));
            self.sources.modules[module].methods.extend(methods);
        }
        for function in functions {
            let files = self.sources.functions.entry(function).or_default();
            files.insert(file);
        }
        let mut found = paths(tokens.iter().cloned().collect());
        let public = matches!(tokens, [TokenTree::Ident(word), ..] if word == "pub");
        found.iter_mut().for_each(|path| path.public = public);
        let module = &mut self.sources.modules[module];
        if item.keyword == "use" {
            module.uses.extend(found.into_iter().filter(|path| {
                let first = path.segments[0].as_str();
                !(path.segments.len() == 1 && ["use", "pub"].contains(&first))
            }));
        } else {
            module.paths.extend(found);
        }
        Ok(())
    }

    fn add_child(
        &mut self,
        module: usize,
        name: &str,
        tokens: &[TokenTree],
        folder: &FilePath,
    ) -> Result<(), ReadError> {
        let file = self.sources.modules[module].file;
        let child = match tokens.last() {
            Some(TokenTree::Group(body)) => {
                self.read_module(body.stream(), file, Some(module), &folder.join(name))?
            }
            _ => {
                let (flat, nested) = (
                    folder.join(format!("{name}.rs")),
                    folder.join(name).join("mod.rs"),
                );
                let path = if flat.exists() { flat } else { nested };
                self.read_file(&path, Some(module))?
            }
        };
        let children = &mut self.sources.modules[module].children;
        children.insert(name.to_owned(), child);
        Ok(())
    }
}

/// The place behind the attribute at `at`, if there is one.
fn behind_attribute(tokens: &[TokenTree], at: usize) -> Option<usize> {
    if !is_punct(tokens.get(at)?, '#') {
        return None;
    }
    let inner = is_punct(tokens.get(at + 1)?, '!');
    Some(at + 2 + usize::from(inner))
}

/// An item of a module.
struct Item {
    /// As `fn`, or empty for a call of a macro.
    keyword: String,
    /// What it defines.
    name: Option<String>,
    /// In tokens.
    length: usize,
}

const DEFINING: [&str; 11] = [
    "fn",
    "struct",
    "enum",
    "union",
    "trait",
    "type",
    "const",
    "static",
    "mod",
    "macro_rules",
    "macro",
];

impl Item {
    /// The item that tokens without attributes begin with.
    fn new(tokens: &[TokenTree]) -> Self {
        let mut at = 0;
        while let Some(TokenTree::Ident(word)) = tokens.get(at) {
            let word = word.to_string();
            let next = tokens.get(at + 1).map(ToString::to_string);
            let next = next.unwrap_or_default();
            let is_qualifier = match word.as_str() {
                "pub" | "unsafe" | "async" | "default" | "auto" => true,
                "extern" => next != "crate" && !next.starts_with('{'),
                "const" => ["fn", "unsafe", "async", "extern"].contains(&next.as_str()),
                _ => false,
            };
            if !is_qualifier {
                return Self::of(tokens, at, word);
            }
            at += 1;
            if is_visibility(tokens.get(at))
                || matches!(tokens.get(at), Some(TokenTree::Literal(_)))
            {
                at += 1;
            }
        }
        Self::of(tokens, at, String::new())
    }

    fn of(tokens: &[TokenTree], at: usize, keyword: String) -> Self {
        let to_semicolon = ["use", "const", "static", "type"].contains(&keyword.as_str());
        let length = if to_semicolon {
            let semicolon = tokens.iter().position(|token| is_punct(token, ';'));
            semicolon.map_or(tokens.len(), |place| place + 1)
        } else {
            end_of_braces(tokens)
        };
        let names = DEFINING.contains(&keyword.as_str());
        let name = names.then(|| {
            let behind = tokens.iter().skip(at + 1);
            let mut idents = behind.filter_map(|token| match token {
                TokenTree::Ident(ident) => Some(ident.to_string()),
                _ => None,
            });
            let name = idents.find(|name| name != "mut");
            name.map(|name| name.trim_start_matches("r#").to_owned())
        });
        Self {
            keyword,
            name: name.flatten(),
            length,
        }
    }
}

/// How many tokens there are to the end of the first braces, or to the first semicolon.
fn end_of_braces(tokens: &[TokenTree]) -> usize {
    let end = tokens.iter().position(|token| match token {
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        token => is_punct(token, ';'),
    });
    end.map_or(tokens.len(), |place| place + 1)
}

/// The names of all functions in tokens, but for those of tests alone.
fn functions(tokens: &[TokenTree]) -> Vec<String> {
    let mut names = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if is_test_attribute(&tokens[at..]) {
            at = end_of_item(tokens, at + 2);
            continue;
        }
        match &tokens[at..] {
            [TokenTree::Ident(word), TokenTree::Ident(name), ..] if word == "fn" => {
                names.push(name.to_string());
            }
            [TokenTree::Group(group), ..] => {
                let inner: Vec<_> = group.stream().into_iter().collect();
                names.extend(functions(&inner));
            }
            _ => {}
        }
        at += 1;
    }
    names
}

/// The path of the type that an `impl` without a trait is of.
fn inherent_type(tokens: &[TokenTree]) -> Option<Vec<String>> {
    let mut depth = 0;
    let mut segments = Vec::new();
    let mut has_ended = false;
    for (n, token) in tokens.iter().enumerate().skip(1) {
        match token {
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => break,
            token if is_punct(token, '<') => {
                depth += 1;
                has_ended = !segments.is_empty();
            }
            // not the arrow of `Fn() -> T`
            token if is_punct(token, '>') && !is_punct(&tokens[n - 1], '-') => depth -= 1,
            TokenTree::Ident(word) if depth == 0 => match word.to_string().as_str() {
                "for" => return None,
                "where" => break,
                segment if !has_ended => segments.push(segment.to_owned()),
                _ => {}
            },
            _ => {}
        }
    }
    (!segments.is_empty()).then_some(segments)
}
