//! Which file of a crate calls methods that another file defines, without naming it.
//!
//! The methods of one type may be in several files, and `self.method()` names none of them. A call
//! counts as a use of the file with the method where the receiver's type is known without type
//! inference: `self`, a parameter, a field of these, and `Type::method`. What is not seen: calls on
//! local variables, on what other calls return and in the arguments of macros, methods of traits,
//! methods of the same name in two `impl` blocks of one type, and types that are named by a path
//! from a module that `use` has brought here.

use super::imports::{attributes, is_test};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use syn::visit::Visit;

/// A type of the crate and the name of its field or method. The names of types are unique.
type Member = (String, String);

/// The files of a crate whose methods each file calls.
pub fn calls<'a>(files: &[&'a Path]) -> BTreeMap<&'a Path, BTreeSet<&'a Path>> {
    let parsed = files.iter().map(|file| {
        let text = std::fs::read_to_string(file).unwrap();
        let parsed = syn::parse_file(&text).unwrap();
        (*file, parsed)
    });
    let parsed: Vec<(&Path, syn::File)> = parsed.collect();
    let mut members = Members::default();
    for &(file, ref content) in &parsed {
        let mut reader = Definitions { file, members };
        reader.visit_file(content);
        members = reader.members;
    }
    let calls = parsed.iter().map(|(file, content)| {
        let mut calls = Calls {
            members: &members,
            own: None,
            parameters: BTreeMap::new(),
            used: BTreeSet::new(),
        };
        calls.visit_file(content);
        calls.used.remove(file);
        (*file, calls.used)
    });
    calls.collect()
}

/// The fields and methods of the types of a crate.
#[derive(Default)]
struct Members<'a> {
    /// The type of each field.
    fields: BTreeMap<Member, String>,
    /// The file that defines each method.
    methods: BTreeMap<Member, &'a Path>,
}

/// Reads what a file defines.
struct Definitions<'a> {
    file: &'a Path,
    members: Members<'a>,
}

impl<'ast> Visit<'ast> for Definitions<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_test(attributes(item)) {
            syn::visit::visit_item(self, item);
        }
    }

    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        for (place, field) in item.fields.iter().enumerate() {
            let name = match &field.ident {
                Some(name) => name.to_string(),
                None => place.to_string(),
            };
            if let Some(its) = type_name(&field.ty) {
                let fields = &mut self.members.fields;
                fields.insert((item.ident.to_string(), name), its);
            }
        }
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        let inherent = item.trait_.is_none();
        let Some(own) = type_name(&item.self_ty).filter(|_| inherent) else {
            return;
        };
        for inner in &item.items {
            if let syn::ImplItem::Fn(method) = inner
                && !is_test(&method.attrs)
            {
                let name = method.sig.ident.to_string();
                self.members.methods.insert((own.clone(), name), self.file);
            }
        }
    }
}

/// Reads what a file calls.
struct Calls<'m, 'a> {
    members: &'m Members<'a>,
    /// The type of `self`.
    own: Option<String>,
    /// The types of the parameters of the function that is being read.
    parameters: BTreeMap<String, String>,
    used: BTreeSet<&'a Path>,
}

impl Calls<'_, '_> {
    fn add(&mut self, its: Option<String>, method: &syn::Ident) {
        let found = its.and_then(|its| self.members.methods.get(&(its, method.to_string())));
        self.used.extend(found);
    }

    /// The type of an expression that is made of `self` or a parameter, and of fields.
    fn type_of(&self, expression: &syn::Expr) -> Option<String> {
        match expression {
            syn::Expr::Path(path) => {
                let name = path.path.get_ident()?.to_string();
                if name == "self" {
                    return self.own.clone();
                }
                self.parameters.get(&name).cloned()
            }
            syn::Expr::Field(field) => {
                let base = self.type_of(&field.base)?;
                let name = match &field.member {
                    syn::Member::Named(name) => name.to_string(),
                    syn::Member::Unnamed(place) => place.index.to_string(),
                };
                self.members.fields.get(&(base, name)).cloned()
            }
            syn::Expr::Reference(inner) => self.type_of(&inner.expr),
            syn::Expr::Paren(inner) => self.type_of(&inner.expr),
            _ => None,
        }
    }

    /// Reads a function with its own parameters.
    fn read(&mut self, signature: &syn::Signature, read: impl FnOnce(&mut Self)) {
        let named = signature.inputs.iter().filter_map(|input| {
            let syn::FnArg::Typed(input) = input else {
                return None;
            };
            let syn::Pat::Ident(name) = &*input.pat else {
                return None;
            };
            Some((name.ident.to_string(), type_name(&input.ty)?))
        });
        let outer = std::mem::replace(&mut self.parameters, named.collect());
        read(self);
        self.parameters = outer;
    }
}

impl<'ast> Visit<'ast> for Calls<'_, '_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_test(attributes(item)) {
            syn::visit::visit_item(self, item);
        }
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        let outer = std::mem::replace(&mut self.own, type_name(&item.self_ty));
        syn::visit::visit_item_impl(self, item);
        self.own = outer;
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if !is_test(&item.attrs) {
            self.read(&item.sig, |calls| {
                syn::visit::visit_impl_item_fn(calls, item);
            });
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.read(&item.sig, |calls| syn::visit::visit_item_fn(calls, item));
    }

    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        self.add(self.type_of(&call.receiver), &call.method);
        syn::visit::visit_expr_method_call(self, call);
    }

    /// `Self::method` and `Type::method`.
    fn visit_expr_path(&mut self, path: &'ast syn::ExprPath) {
        let segments: Vec<&syn::PathSegment> = path.path.segments.iter().collect();
        if let Some((method, its)) = segments.split_last() {
            let its = match own_name(its) {
                Some(name) if name == "Self" => self.own.clone(),
                name => name,
            };
            self.add(its, &method.ident);
        }
        syn::visit::visit_expr_path(self, path);
    }
}

/// The name of a type, or of what it refers to.
fn type_name(its: &syn::Type) -> Option<String> {
    match its {
        syn::Type::Path(path) => own_name(&path.path.segments.iter().collect::<Vec<_>>()),
        syn::Type::Reference(inner) => type_name(&inner.elem),
        syn::Type::Paren(inner) => type_name(&inner.elem),
        _ => None,
    }
}

/// The last name of a path into this crate: `io::Error` is another type than `Error`.
fn own_name(path: &[&syn::PathSegment]) -> Option<String> {
    let (last, before) = path.split_last()?;
    let is_own = before.first().is_none_or(|first| {
        let own = ["crate", "self", "super"];
        own.iter().any(|word| first.ident == word)
    });
    is_own.then(|| last.ident.to_string())
}

/// Files of an example, whose uses of each other the test lists.
const EXAMPLE: [(&str, &str); 7] = [
    (
        "parent.rs",
        "pub struct Parent { part: Part, count: u32 }
         impl Parent { fn start(&mut self) { self.finish(); } fn note(&self) {} }",
    ),
    (
        "child.rs",
        "impl Parent { fn finish(&mut self) { self.note(); } }",
    ),
    (
        "part.rs",
        "pub struct Part; impl Part { fn turn(&self) {} fn new() -> Self { Part } }",
    ),
    // Through fields, parameters, and the name of the type.
    (
        "field.rs",
        "impl Parent { fn f(&self) { (&self.part).turn(); } }",
    ),
    (
        "parameter.rs",
        "fn f(parent: &mut Parent) { parent.finish(); }",
    ),
    (
        "path.rs",
        "impl Parent { fn g() { Part::new(); Self::note; } }",
    ),
    // Another type, a trait, a local variable, and a test.
    (
        "unseen.rs",
        "impl Other { fn f(&self, count: u32) { self.finish(); count.note(); } }
         fn h(other: &std::Parent) { other.note(); std::Part::new(); }
         impl Drop for Parent { fn drop(&mut self) { let part = 1; part.turn(); } }
         #[cfg(test)] mod tests { fn f(parent: &Parent) { parent.note(); } }",
    ),
];

/// What counts as a call of which file.
#[test]
fn calls_lead_to_the_file_that_defines_the_method() {
    let folder = tempfile::tempdir().unwrap();
    let paths = EXAMPLE.map(|(name, text)| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    });
    let paths: Vec<&Path> = paths.iter().map(|path| path.as_path()).collect();
    let found = calls(&paths);
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    let found = found.iter().map(|(file, used)| {
        let used: BTreeSet<String> = used.iter().map(|file| name(file)).collect();
        (name(file), used)
    });
    let expected = [
        ("parent.rs", vec!["child.rs"]),
        ("child.rs", vec!["parent.rs"]),
        ("part.rs", vec![]),
        ("field.rs", vec!["part.rs"]),
        ("parameter.rs", vec!["child.rs"]),
        ("path.rs", vec!["parent.rs", "part.rs"]),
        ("unseen.rs", vec![]),
    ];
    let expected = expected.map(|(file, used)| {
        let used = used.into_iter().map(str::to_owned);
        (file.to_owned(), used.collect::<BTreeSet<String>>())
    });
    assert_eq!(BTreeMap::from_iter(found), BTreeMap::from(expected));
}
