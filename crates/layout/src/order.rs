//! What is wrong with imports: arrows upwards, and circles.

use std::collections::HashSet;

use crate::imports::Import;
use crate::modules::Sources;

impl Sources {
    /// What is wrong with the imports among the files of a folder (`""` for the whole crate), one sentence each.
    ///
    /// `order` lists the folder's own files (without `.rs`) and folders from the bottom up. One may import from
    /// those before it and from itself, but no file may import from itself by way of others. The folder's own
    /// root (`mod`, `lib`, `main`) is above all and is not listed.
    #[must_use]
    pub fn faults(&self, folder: &str, order: &[&str]) -> Vec<String> {
        let mut faults = Vec::new();
        let groups: Vec<Option<&str>> = (self.files.iter())
            .map(|file| group(folder, file))
            .collect();
        let rank = |group: &str| match group {
            "mod" | "lib" | "main" => Some(order.len()),
            group => order.iter().position(|listed| *listed == group),
        };
        let present: HashSet<&str> = groups.iter().flatten().copied().collect();
        let unlisted = present.iter().filter(|group| rank(group).is_none());
        faults.extend(unlisted.map(|group| format!("undeclared: {group} in {folder:?}")));
        let stale = order.iter().filter(|group| !present.contains(*group));
        faults.extend(stale.map(|group| format!("missing: {group} in {folder:?}")));
        let inner: Vec<Import> = (self.imports().into_iter())
            .filter(|import| groups[import.from].is_some() && groups[import.to].is_some())
            .collect();
        for import in &inner {
            let [from, to] = [import.from, import.to].map(|file| groups[file].and_then(rank));
            if let (Some(from), Some(to)) = (from, to)
                && to > from
            {
                faults.push(format!("upwards: {}", self.sentence(import)));
            }
        }
        faults.extend(self.circle(&inner));
        faults.sort();
        faults
    }

    fn sentence(&self, import: &Import) -> String {
        format!(
            "{}:{} imports {} of {}",
            self.files[import.from], import.line, import.path, self.files[import.to]
        )
    }

    /// A circle of files, if there is one.
    fn circle(&self, imports: &[Import]) -> Option<String> {
        let mut left: Vec<&Import> = imports.iter().collect();
        // A file that imports nothing, or that nothing imports, is in no circle.
        loop {
            let from: HashSet<usize> = left.iter().map(|import| import.from).collect();
            let to: HashSet<usize> = left.iter().map(|import| import.to).collect();
            let before = left.len();
            left.retain(|import| to.contains(&import.from) && from.contains(&import.to));
            if left.len() == before {
                break;
            }
        }
        // Every file that is left imports another that is left: some way through them comes back.
        let mut way: Vec<&Import> = vec![left.first()?];
        loop {
            let at = way.last()?.to;
            if let Some(start) = way.iter().position(|import| import.from == at) {
                let steps = way[start..].iter().map(|import| self.sentence(import));
                return Some(format!("circle: {}", steps.collect::<Vec<_>>().join("; ")));
            }
            way.push(left.iter().find(|import| import.from == at)?);
        }
    }
}

/// The part of a folder that a file is in: a file's name without `.rs`, or a folder's; none if the file is
/// elsewhere.
fn group<'a>(folder: &str, file: &'a str) -> Option<&'a str> {
    let inner = match folder {
        "" => file,
        _ => file.strip_prefix(folder)?.strip_prefix('/')?,
    };
    let first = inner.split('/').next()?;
    Some(first.strip_suffix(".rs").unwrap_or(first))
}
