//! Which file of a crate uses what another one defines.

use super::methods::calls;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::punctuated::Punctuated;
use syn::visit::Visit;

/// A path inside the crate, from its root: `live::protocol::Incoming`.
type Names = Vec<String>;

/// The source files of a crate, and what each defines and uses.
pub struct Crate {
    modules: BTreeMap<Names, Module>,
}

struct Module {
    file: PathBuf,
    /// What `use` brings into this file, by the name it has here. Other files may reach it too: all
    /// of them what is exported, and the modules inside this one the rest.
    imports: BTreeMap<String, Names>,
    /// Modules of the crate all of whose names `use` brings here.
    globs: Vec<String>,
    /// Every path of the crate that the code names.
    uses: BTreeSet<Names>,
    /// Modules in files of their own that exist only for tests.
    tests: Vec<Names>,
}

impl Crate {
    /// Reads the files in `source`, the folder of lib.rs.
    pub fn read(source: &Path) -> Self {
        let mut files = Vec::new();
        super::sources(source, &mut files);
        let names: BTreeSet<Names> = files.iter().map(|file| module_name(source, file)).collect();
        let modules = files.into_iter().map(|file| {
            let name = module_name(source, &file);
            let text = std::fs::read_to_string(&file).unwrap();
            let parsed = syn::parse_file(&text)
                .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            let mut reader = Reader {
                module: name.clone(),
                all: &names,
                found: Module {
                    file,
                    imports: BTreeMap::new(),
                    globs: Vec::new(),
                    uses: BTreeSet::new(),
                    tests: Vec::new(),
                },
            };
            reader.read_imports(&parsed.items);
            reader.visit_file(&parsed);
            (name, reader.found)
        });
        let mut modules: BTreeMap<Names, Module> = modules.collect();
        let tests: Vec<Names> = modules.values().flat_map(|m| m.tests.clone()).collect();
        modules.retain(|name, _| !tests.iter().any(|test| name.starts_with(test)));
        for module in modules.values() {
            let (file, globs) = (module.file.display(), &module.globs);
            assert!(globs.is_empty(), "{file}: list the names of {globs:?}");
        }
        Self { modules }
    }

    /// The files that each file uses something of: by its name, or by calling a method.
    pub fn edges(&self) -> BTreeMap<&Path, BTreeSet<&Path>> {
        let files: Vec<&Path> = self.modules.values().map(|m| m.file.as_path()).collect();
        let mut edges = calls(&files);
        for module in self.modules.values() {
            let used = module.uses.iter().filter_map(|path| self.file_of(path, 0));
            let others = used.filter(|file| *file != module.file);
            edges.entry(&module.file).or_default().extend(others);
        }
        edges
    }

    /// The file that defines what `path` names; none for a module as such.
    fn file_of(&self, path: &[String], depth: usize) -> Option<&Path> {
        // A re-export that leads back to itself names nothing of this crate.
        if depth > 20 {
            return None;
        }
        let length = (0..=path.len())
            .rev()
            .find(|&n| self.modules.contains_key(&path[..n]))?;
        let module = &self.modules[&path[..length]];
        let (first, rest) = path[length..].split_first()?;
        if let Some(target) = module.imports.get(first) {
            let full: Names = target.iter().chain(rest).cloned().collect();
            return self.file_of(&full, depth + 1);
        }
        Some(&module.file)
    }
}

/// The module of a file: `a/b.rs` and `a/b/mod.rs` are both `a::b`.
fn module_name(source: &Path, file: &Path) -> Names {
    let inside = file.strip_prefix(source).unwrap().with_extension("");
    let mut names: Names = inside
        .components()
        .map(|part| part.as_os_str().to_string_lossy().into_owned())
        .collect();
    if matches!(
        names.last().map(String::as_str),
        Some("mod" | "lib" | "main")
    ) {
        names.pop();
    }
    names
}

struct Reader<'a> {
    /// The module that is being read: the file's, or one inside the file.
    module: Names,
    all: &'a BTreeSet<Names>,
    found: Module,
}

impl Reader<'_> {
    /// A path from the crate's root; none for one into another crate.
    fn resolve(&self, path: &[String]) -> Option<Names> {
        let (first, rest) = path.split_first()?;
        let mut names = match first.as_str() {
            "crate" => Vec::new(),
            "self" => self.module.clone(),
            "super" => {
                let mut at = self.module.clone();
                at.pop();
                at
            }
            name => {
                let mut child = self.module.clone();
                child.push(name.to_owned());
                match self.found.imports.get(name) {
                    Some(import) => import.clone(),
                    None if self.all.contains(&child) => child,
                    None => return None,
                }
            }
        };
        for name in rest {
            match name.as_str() {
                "super" => drop(names.pop()),
                "self" => {}
                name => names.push(name.to_owned()),
            }
        }
        Some(names)
    }

    fn read_imports(&mut self, items: &[syn::Item]) {
        for item in items {
            if let syn::Item::Use(item) = item
                && !is_test(&item.attrs)
            {
                let public = !matches!(item.vis, syn::Visibility::Inherited);
                self.read_tree(&item.tree, &mut Vec::new(), public);
            }
        }
    }

    fn read_tree(&mut self, tree: &syn::UseTree, before: &mut Names, public: bool) {
        let (name, here) = match tree {
            syn::UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.read_tree(&path.tree, before, public);
                before.pop();
                return;
            }
            syn::UseTree::Group(group) => {
                for tree in &group.items {
                    self.read_tree(tree, before, public);
                }
                return;
            }
            syn::UseTree::Glob(_) => {
                // A module inside a file may take all names of the file: both count as one.
                let inner = !self.all.contains(&self.module);
                if let Some(path) = self.resolve(before)
                    && !(inner && self.module.starts_with(&path))
                {
                    self.found.globs.push(before.join("::"));
                }
                return;
            }
            syn::UseTree::Name(name) => (name.ident.to_string(), name.ident.to_string()),
            syn::UseTree::Rename(name) => (name.ident.to_string(), name.rename.to_string()),
        };
        let mut path = before.clone();
        let here = if name == "self" {
            path.last().cloned().unwrap_or(here)
        } else {
            path.push(name);
            here
        };
        let Some(full) = self.resolve(&path) else {
            return;
        };
        // A re-export is no use: whoever names it uses the file that defines it.
        if !public {
            self.found.uses.insert(full.clone());
        }
        self.found.imports.insert(here, full);
    }

    fn add(&mut self, path: &[String]) {
        // A name alone is this file's own unless `use` brings it here.
        let full = match path {
            [name] => self.found.imports.get(name).cloned(),
            path => self.resolve(path),
        };
        self.found.uses.extend(full);
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_test(attributes(item)) {
            syn::visit::visit_item(self, item);
        } else if let syn::Item::Mod(module) = item {
            let mut name = self.module.clone();
            name.push(module.ident.to_string());
            self.found.tests.push(name);
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if !is_test(&item.attrs) {
            syn::visit::visit_impl_item_fn(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        self.module.push(item.ident.to_string());
        syn::visit::visit_item_mod(self, item);
        self.module.pop();
    }

    /// Also a `use` inside a function or an inner module.
    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let public = !matches!(item.vis, syn::Visibility::Inherited);
        self.read_tree(&item.tree, &mut Vec::new(), public);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Names = path.segments.iter().map(|s| s.ident.to_string()).collect();
        self.add(&names);
        syn::visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, called: &'ast syn::Macro) {
        // What stands between the brackets of a macro is not parsed.
        let text = called.tokens.to_string();
        let words = text.replace(" :: ", "::");
        for word in words.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')) {
            let names: Names = word.split("::").map(str::to_owned).collect();
            self.add(&names);
        }
    }
}

/// The attributes of an item of a kind that can be there for tests only.
pub fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    match item {
        syn::Item::Const(item) => &item.attrs,
        syn::Item::Enum(item) => &item.attrs,
        syn::Item::Fn(item) => &item.attrs,
        syn::Item::Impl(item) => &item.attrs,
        syn::Item::Macro(item) => &item.attrs,
        syn::Item::Mod(item) => &item.attrs,
        syn::Item::Static(item) => &item.attrs,
        syn::Item::Struct(item) => &item.attrs,
        syn::Item::Trait(item) => &item.attrs,
        syn::Item::Type(item) => &item.attrs,
        syn::Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// Whether an item is there for tests only: `cfg(test)`, or `cfg(all(test, ...))`.
pub fn is_test(attributes: &[syn::Attribute]) -> bool {
    let for_tests = |condition: &syn::Meta| -> bool {
        if condition.path().is_ident("test") {
            return true;
        }
        let syn::Meta::List(list) = condition else {
            return false;
        };
        let all = Punctuated::<syn::Meta, syn::Token![,]>::parse_terminated;
        list.path.is_ident("all")
            && list
                .parse_args_with(all)
                .is_ok_and(|all| all.iter().any(|one| one.path().is_ident("test")))
    };
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute
                .parse_args::<syn::Meta>()
                .is_ok_and(|condition| for_tests(&condition))
    })
}

/// The files that use each other in a circle, each circle once.
pub fn circles<'a>(edges: &BTreeMap<&'a Path, BTreeSet<&'a Path>>) -> Vec<Vec<&'a Path>> {
    let reached = |from: &'a Path| {
        let mut seen = BTreeSet::new();
        let mut next = vec![from];
        while let Some(file) = next.pop() {
            for &other in edges.get(file).into_iter().flatten() {
                if seen.insert(other) {
                    next.push(other);
                }
            }
        }
        seen
    };
    let reach: BTreeMap<&Path, BTreeSet<&Path>> =
        edges.keys().map(|&file| (file, reached(file))).collect();
    let mut found: Vec<Vec<&Path>> = Vec::new();
    for (&file, reached) in &reach {
        let known = found.iter().any(|circle| circle.contains(&file));
        if reached.contains(file) && !known {
            let together = reached.iter().filter(|other| reach[*other].contains(file));
            found.push(together.copied().collect());
        }
    }
    found
}

/// What counts as a use of which file, in both directions.
#[test]
fn uses_lead_to_the_file_that_defines_the_name() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    file("lib.rs", "mod a; mod b; mod c; pub mod d; pub use b::B;");
    // By a re-export, inside a function, and in the arguments of a macro.
    file(
        "a.rs",
        "fn f() { use crate::c::C; assert!(crate::B::new(C)); }",
    );
    // For tests only: an item, a file, and a module on one platform.
    file(
        "b.rs",
        "pub struct B; #[cfg(test)] use crate::c::C; #[cfg(test)] mod tests;
         #[cfg(all(test, unix))] mod more { use super::*; use crate::d::D; }",
    );
    file("b/tests.rs", "use super::*; use crate::c::C;");
    // An inner module takes the names of its file.
    file(
        "c.rs",
        "pub struct C; mod inner { use super::*; fn f(_: super::C) {} }",
    );
    // A re-exported name that the file uses itself, and a private import of the parent.
    file(
        "d/mod.rs",
        "mod e; mod f; pub use e::E; use crate::c::C; pub struct D(E);",
    );
    file("d/e.rs", "pub struct E(super::C);");
    file("d/f.rs", "use super::D;");
    let read = Crate::read(folder.path());
    let name = |path: &Path| path.strip_prefix(folder.path()).unwrap().to_owned();
    let edges = read.edges();
    let found: Vec<(PathBuf, Vec<PathBuf>)> = edges
        .iter()
        .map(|(file, used)| (name(file), used.iter().map(|used| name(used)).collect()))
        .collect();
    let expected: [(&str, &[&str]); 7] = [
        ("a.rs", &["b.rs", "c.rs"]),
        ("b.rs", &[]),
        ("c.rs", &[]),
        ("d/e.rs", &["c.rs"]),
        ("d/f.rs", &["d/mod.rs"]),
        ("d/mod.rs", &["c.rs", "d/e.rs"]),
        ("lib.rs", &[]),
    ];
    let expected = expected.map(|(file, used)| {
        let used: Vec<PathBuf> = used.iter().map(PathBuf::from).collect();
        (PathBuf::from(file), used)
    });
    assert_eq!(BTreeMap::from_iter(found), BTreeMap::from(expected),);
}
