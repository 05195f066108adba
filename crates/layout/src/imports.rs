//! From paths to the files that define what they name.

use std::collections::{BTreeSet, HashMap};

use crate::modules::{Module, Sources};
use crate::paths::{NamedPath, PathKind};

/// Re-exports are followed no further than this: by then they run in a circle of their own.
const MOST_STEPS: usize = 32;

/// A file that uses something of another file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Import {
    /// The file that uses it, by its number among the files.
    pub from: usize,
    /// The file that defines it.
    pub to: usize,
    /// Where it is used.
    pub line: usize,
    /// How it is named there.
    pub path: String,
}

impl Sources {
    /// All imports of one file of the crate from another, each file's in the order of the lines.
    #[must_use]
    pub fn imports(&self) -> Vec<Import> {
        let methods = self.methods();
        let mut imports = BTreeSet::new();
        for (number, module) in self.modules.iter().enumerate() {
            for path in module.uses.iter().chain(&module.paths) {
                let mut targets = self.targets(number, module, path);
                let is_call = path.kind == PathKind::Method || path.segments.len() > 1;
                let last = path.segments.last();
                let method = last.and_then(|name| methods.get(name.as_str()));
                targets.extend(method.filter(|_| is_call));
                targets.remove(&module.file);
                imports.extend(targets.into_iter().map(|to| Import {
                    from: module.file,
                    to,
                    line: path.line,
                    path: path.segments.join("::"),
                }));
            }
        }
        imports.into_iter().collect()
    }

    /// The methods that stand in another file than their type, by name, with that file: nothing but their
    /// calls says that they are used. A name that several files define does not tell which is called, and is
    /// left out.
    fn methods(&self) -> HashMap<&str, usize> {
        let mut methods = HashMap::new();
        for (number, module) in self.modules.iter().enumerate() {
            for (implemented, method) in &module.methods {
                let defined = self.resolve(number, implemented, MOST_STEPS);
                let unique = self.functions[method].len() == 1;
                if unique && !defined.is_empty() && !defined.contains(&module.file) {
                    methods.insert(method.as_str(), module.file);
                }
            }
        }
        methods
    }

    /// The files that a path leads to: one, or all that a glob re-exports.
    fn targets(&self, number: usize, module: &Module, path: &NamedPath) -> BTreeSet<usize> {
        match (path.kind, &path.segments[..]) {
            (PathKind::Macro, [name]) if module.uses.iter().all(|used| used.name != *name) => {
                self.macros.get(name).copied().into_iter().collect()
            }
            (PathKind::Glob, _) => self.glob_targets(number, &path.segments, MOST_STEPS),
            // A single name has its own `use`.
            (PathKind::Method, _) | (_, [_]) => BTreeSet::new(),
            _ => self.resolve(number, &path.segments, MOST_STEPS),
        }
    }

    /// The files of all that `use path::*` brings.
    fn glob_targets(&self, number: usize, segments: &[String], steps: usize) -> BTreeSet<usize> {
        let Some(number) = self.module_at(number, segments) else {
            return BTreeSet::new();
        };
        let module = &self.modules[number];
        let mut targets = BTreeSet::from([module.file]);
        if steps > 0 {
            for reexport in module.uses.iter().filter(|used| used.public) {
                targets.extend(if reexport.kind == PathKind::Glob {
                    self.glob_targets(number, &reexport.segments, steps - 1)
                } else {
                    self.resolve(number, &reexport.segments, steps - 1)
                });
            }
        }
        targets
    }

    /// The module that a path leads to, if it is one of this crate.
    fn module_at(&self, number: usize, segments: &[String]) -> Option<usize> {
        let (mut number, rest) = self.start(number, segments)?;
        for segment in rest {
            let module = &self.modules[number];
            number = match module.children.get(segment) {
                Some(&child) => child,
                None => {
                    let used = module.uses.iter().find(|used| used.name == *segment)?;
                    self.module_at(number, &used.segments)?
                }
            };
        }
        Some(number)
    }

    /// Where a path begins and what is left of it; none if it leads to another crate.
    fn start<'a>(&self, number: usize, segments: &'a [String]) -> Option<(usize, &'a [String])> {
        let mut number = number;
        let mut rest = segments;
        match rest.first()?.as_str() {
            "" => return None,
            "crate" => {
                number = 0;
                rest = &rest[1..];
            }
            "self" => rest = &rest[1..],
            "super" => {}
            first => {
                let module = &self.modules[number];
                let known = module.children.contains_key(first)
                    || module.definitions.contains(first)
                    || module.uses.iter().any(|used| used.name == first);
                return known.then_some((number, rest));
            }
        }
        while rest.first().is_some_and(|first| first == "super") {
            number = self.modules[number].parent?;
            rest = &rest[1..];
        }
        Some((number, rest))
    }

    /// The files that define what a path names. There are two only where a module and an item have one name.
    fn resolve(&self, number: usize, segments: &[String], steps: usize) -> BTreeSet<usize> {
        let Some((mut number, rest)) = self.start(number, segments) else {
            return BTreeSet::new();
        };
        if steps == 0 {
            return BTreeSet::from([self.modules[number].file]);
        }
        for (n, segment) in rest.iter().enumerate() {
            let module = &self.modules[number];
            let last = n + 1 == rest.len();
            let child = module.children.get(segment);
            if let Some(&child) = child
                && !last
            {
                number = child;
                continue;
            }
            let mut targets: BTreeSet<usize> = child
                .map(|&child| self.modules[child].file)
                .into_iter()
                .collect();
            if module.definitions.contains(segment) {
                targets.insert(module.file);
                return targets;
            }
            for used in module.uses.iter().filter(|used| used.name == *segment) {
                let path = [&used.segments, &rest[n + 1..]].concat();
                if path != segments {
                    return &targets | &self.resolve(number, &path, steps - 1);
                }
            }
            for glob in module
                .uses
                .iter()
                .filter(|used| used.kind == PathKind::Glob)
            {
                let Some(inner) = self.module_at(number, &glob.segments) else {
                    continue;
                };
                if self.has(inner, segment, steps) {
                    let path = [&["self".to_owned()], &rest[n..]].concat();
                    return &targets | &self.resolve(inner, &path, steps - 1);
                }
            }
            if targets.is_empty() {
                targets.insert(module.file); // made by a macro
            }
            return targets;
        }
        BTreeSet::from([self.modules[number].file])
    }

    /// Whether a module has something of this name, its own or re-exported.
    fn has(&self, number: usize, name: &str, steps: usize) -> bool {
        let module = &self.modules[number];
        let by_glob = |used: &&NamedPath| {
            used.kind == PathKind::Glob
                && self
                    .module_at(number, &used.segments)
                    .is_some_and(|inner| steps > 0 && self.has(inner, name, steps - 1))
        };
        module.children.contains_key(name)
            || module.definitions.contains(name)
            || module.uses.iter().any(|used| used.name == name)
            || module.uses.iter().any(|used| by_glob(&used))
    }
}
