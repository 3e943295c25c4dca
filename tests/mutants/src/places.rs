//! Where in a source file the code stands that a mutant replaces.

use crate::TextPosition;
use proc_macro2::{LineColumn, Span};
use std::collections::BTreeMap;
use std::ops::Range;
use syn::punctuated::Punctuated;
use syn::spanned::Spanned as _;
use syn::visit::{self, Visit};

/// Code that can be replaced, by the position at which cargo-mutants puts its mutants.
#[derive(Default)]
pub struct Places {
    /// Operators with two operands.
    pub binary: BTreeMap<TextPosition, Binary>,
    /// Operators with one: the operator with its operand, and the operand.
    pub unary: BTreeMap<TextPosition, (Range<usize>, Range<usize>)>,
    /// Arms of a match: the guard, or where one can be put.
    pub arms: BTreeMap<TextPosition, Arm>,
    /// Fields of an expression that takes the others from a base.
    pub fields: BTreeMap<TextPosition, Field>,
    /// Code that runs while the program is built, where no variable can be read.
    pub constant: Vec<Range<usize>>,
}

pub struct Binary {
    pub whole: Range<usize>,
    pub left: Range<usize>,
    pub right: Range<usize>,
    /// `if a && let Some(b) = c` is not an expression that can be put into brackets.
    pub has_let: bool,
}

pub enum Arm {
    Guard(Range<usize>),
    /// Where the pattern ends [bytes].
    Unguarded(usize),
}

pub struct Field {
    pub name: String,
    pub shorthand: bool,
    pub value: Range<usize>,
    pub base: Range<usize>,
}

/// Byte offsets of the lines of a text.
pub struct Lines<'a> {
    source: &'a str,
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    pub fn new(source: &'a str) -> Self {
        let starts = source.match_indices('\n').map(|(at, _)| at + 1);
        let starts = std::iter::once(0).chain(starts).collect();
        Self { source, starts }
    }

    /// The offset [bytes] of a position.
    pub fn offset(&self, at: TextPosition) -> usize {
        let start = self.starts[at.line - 1];
        let mut characters = self.source[start..].char_indices();
        let place = characters.nth(at.column - 1);
        place.map_or(self.source.len(), |(offset, _)| start + offset)
    }

    fn range(&self, span: Span) -> Range<usize> {
        self.offset(position(span.start()))..self.offset(position(span.end()))
    }
}

fn position(at: LineColumn) -> TextPosition {
    TextPosition {
        line: at.line,
        column: at.column + 1,
    }
}

/// Finds what can be replaced in `source`.
pub fn find(source: &str) -> syn::Result<Places> {
    let mut finder = Finder {
        lines: Lines::new(source),
        found: Places::default(),
    };
    finder.visit_file(&syn::parse_file(source)?);
    Ok(finder.found)
}

struct Finder<'a> {
    lines: Lines<'a>,
    found: Places,
}

/// Looks for `let` in a condition.
struct LetFinder(bool);

impl<'ast> Visit<'ast> for LetFinder {
    fn visit_expr_let(&mut self, _: &'ast syn::ExprLet) {
        self.0 = true;
    }

    fn visit_block(&mut self, _: &'ast syn::Block) {}

    fn visit_expr_closure(&mut self, _: &'ast syn::ExprClosure) {}
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_expr_binary(&mut self, e: &'ast syn::ExprBinary) {
        let mut finder = LetFinder(false);
        finder.visit_expr_binary(e);
        let binary = Binary {
            whole: self.lines.range(e.span()),
            left: self.lines.range(e.left.span()),
            right: self.lines.range(e.right.span()),
            has_let: finder.0,
        };
        let at = position(e.op.span().start());
        self.found.binary.insert(at, binary);
        visit::visit_expr_binary(self, e);
    }

    fn visit_expr_unary(&mut self, e: &'ast syn::ExprUnary) {
        let whole = self.lines.range(e.span());
        let operand = self.lines.range(e.expr.span());
        let at = position(e.op.span().start());
        self.found.unary.insert(at, (whole, operand));
        visit::visit_expr_unary(self, e);
    }

    fn visit_arm(&mut self, arm: &'ast syn::Arm) {
        let place = match &arm.guard {
            Some((_, guard)) => Arm::Guard(self.lines.range(guard.span())),
            None => Arm::Unguarded(self.lines.range(arm.pat.span()).end),
        };
        self.found.arms.insert(position(arm.span().start()), place);
        visit::visit_arm(self, arm);
    }

    fn visit_expr_struct(&mut self, e: &'ast syn::ExprStruct) {
        if let Some(base) = &e.rest {
            for field in &e.fields {
                let found = Field {
                    name: match &field.member {
                        syn::Member::Named(name) => name.to_string(),
                        syn::Member::Unnamed(place) => place.index.to_string(),
                    },
                    shorthand: field.colon_token.is_none(),
                    value: self.lines.range(field.expr.span()),
                    base: self.lines.range(base.span()),
                };
                let at = position(field.span().start());
                self.found.fields.insert(at, found);
            }
        }
        visit::visit_expr_struct(self, e);
    }

    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        self.found.constant.push(self.lines.range(item.span()));
    }

    fn visit_item_static(&mut self, item: &'ast syn::ItemStatic) {
        self.found.constant.push(self.lines.range(item.span()));
    }

    fn visit_impl_item_const(&mut self, item: &'ast syn::ImplItemConst) {
        self.found.constant.push(self.lines.range(item.span()));
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if item.sig.constness.is_some() {
            self.found.constant.push(self.lines.range(item.span()));
        }
        visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if item.sig.constness.is_some() {
            self.found.constant.push(self.lines.range(item.span()));
        }
        visit::visit_impl_item_fn(self, item);
    }

    // Patterns, too, have operators (`-1`), but nothing there can be replaced.
    fn visit_pat(&mut self, _: &'ast syn::Pat) {}

    /// Arguments of macros such as `vec!` and `assert!`, where they are expressions.
    fn visit_macro(&mut self, called: &'ast syn::Macro) {
        let list = Punctuated::<syn::Expr, syn::Token![,]>::parse_terminated;
        if let Ok(arguments) = called.parse_body_with(list) {
            for argument in &arguments {
                self.visit_expr(argument);
            }
        }
    }
}
