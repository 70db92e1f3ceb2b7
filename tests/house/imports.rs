//! What may import what.

use std::collections::{BTreeMap, BTreeSet};

use crate::none;
use crate::source::{Source, identifiers, matched, sources};

/// A module's path in its crate, without `crate`: none for the root.
type Module = Vec<String>;

/// The submodules of every module in the order of their declarations, and what every module refers to.
struct Crate {
    order: BTreeMap<Module, Vec<String>>,
    references: BTreeMap<Module, BTreeSet<Module>>,
}

impl Crate {
    /// The crate whose root is the file `root`, its modules in the folder of that file.
    fn read(all: &[Source], root: &str) -> Self {
        let folder = &root[..=root.rfind('/').unwrap()];
        let nested = format!("{folder}bin/");
        let mut read = Self { order: BTreeMap::new(), references: BTreeMap::new() };
        for file in all.iter().filter(|file| file.path.starts_with(folder) && !file.path.starts_with(&nested)) {
            if file.is_tests() {
                continue;
            }
            let inner = file.path[folder.len()..].trim_end_matches(".rs");
            let inner = inner.trim_end_matches("/mod");
            let module: Module = match inner {
                "lib" | "main" => Vec::new(),
                _ => inner.split('/').map(str::to_owned).collect(),
            };
            let code = file.shipped();
            read.order.insert(module.clone(), declared(&code));
            read.references.insert(module.clone(), referred(&code, &module));
        }
        read
    }

    /// Every reference that does not look upward, as a sentence.
    fn offences(&self) -> Vec<String> {
        let mut offences = Vec::new();
        for (module, references) in &self.references {
            for reference in references {
                let shared = module.iter().zip(reference).take_while(|(own, other)| own == other).count();
                let submodules = &self.order[&module[..shared]];
                let place = |path: &Module| path.get(shared).and_then(|name| submodules.iter().position(|s| s == name));
                let offends = match (place(module), place(reference)) {
                    // Siblings, or modules within siblings: declared above.
                    (Some(own), Some(other)) => other >= own,
                    // A parent may use what is in its submodules, and they what it holds itself.
                    _ => false,
                };
                if offends {
                    offences.push(format!("{} refers to {}", module.join("::"), reference.join("::")));
                }
            }
        }
        offences
    }
}

/// Names after `mod` that stand in files of their own.
fn declared(code: &str) -> Vec<String> {
    let words: Vec<(usize, &str)> = identifiers(code).collect();
    let file = |pair: &[(usize, &str)]| pair[0].1 == "mod" && code[pair[1].0 + pair[1].1.len()..].starts_with(';');
    words.windows(2).filter(|pair| file(pair)).map(|pair| pair[1].1.to_owned()).collect()
}

/// Every path in `code` that begins with `crate`, `super`, `self` or a submodule that is used by name.
fn referred(code: &str, module: &Module) -> BTreeSet<Module> {
    let submodules = declared(code);
    let mut found = BTreeSet::new();
    for (at, word) in identifiers(code) {
        let is_start = !code[..at].ends_with("::") && code[at + word.len()..].starts_with("::");
        let base = match word {
            "crate" => Vec::new(),
            "self" => module.clone(),
            "super" => module[..module.len().saturating_sub(1)].to_vec(),
            name if submodules.iter().any(|submodule| submodule == name) => [&module[..], &[name.to_owned()]].concat(),
            _ => continue,
        };
        if is_start {
            expand(&code[at + word.len() + 2..], base, &mut found);
        }
    }
    found
}

/// Adds the paths that `rest` of a path leads to from `base`: names and lists of names in braces.
fn expand(rest: &str, mut base: Module, found: &mut BTreeSet<Module>) {
    if rest.starts_with('{') {
        let list = &rest[1..matched(rest) - 1];
        let mut from = 0;
        while from < list.len() {
            let item = list[from..].trim_start();
            let start = list.len() - item.len();
            let mut end = start;
            while end < list.len() && !list[end..].starts_with(',') {
                end += if list[end..].starts_with('{') { matched(&list[end..]) } else { 1 };
            }
            if !item.is_empty() {
                expand(item, base.clone(), found);
            }
            from = end + 1;
        }
        return;
    }
    let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
    match &rest[..length] {
        "" | "self" => {}
        "super" => drop(base.pop()),
        name => base.push(name.to_owned()),
    }
    match rest[length..].strip_prefix("::") {
        Some(rest) => expand(rest, base, found),
        None => drop(found.insert(base)),
    }
}

#[test]
fn modules_of_the_library_import_only_from_modules_above_them() {
    let library = Crate::read(&sources(), "src/lib.rs");
    assert!(library.order[&Vec::new()].len() >= 19, "{:?}", library.order[&Vec::new()]);
    let offences = library.offences();
    none(offences);
}

#[test]
fn modules_of_the_program_import_only_from_modules_above_them() {
    let offences = Crate::read(&sources(), "src/bin/facetmill/main.rs").offences();
    none(offences);
}

#[test]
fn an_import_from_below_is_found_however_it_is_spelled() {
    let library = |b: &str| {
        let source = |path: &str, code: &str| Source { path: path.into(), text: code.into(), code: code.into() };
        let all = [
            source("src/lib.rs", "pub mod a; pub mod b; pub mod c;"),
            source("src/a.rs", "pub fn f() {}"),
            source("src/b/mod.rs", "pub mod d; pub mod e; pub struct Own;"),
            source("src/b/d.rs", b),
            source("src/b/e.rs", "use super::d::x; use super::Own; fn f() { crate::a::f() }"),
            source("src/c.rs", "use crate::{a, b::{d, e::y}};"),
        ];
        Crate::read(&all, "src/lib.rs").offences()
    };
    assert_eq!(library("use crate::a::f; use super::Own; #[cfg(test)] mod tests { use crate::c::z; }"), [""; 0]);
    for code in [
        "use crate::c::z;",
        "use crate::{a::f, c};",
        "fn f() { crate::c::z() }",
        "use super::e::y;",
        "use super::{e::{self, y}};",
        "use super::super::c;",
    ] {
        assert_eq!(library(code).len(), 1 + usize::from(code.contains("self")), "{code}: {:?}", library(code));
    }
}
