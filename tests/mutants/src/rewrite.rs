//! Writes mutants beside the code that they replace.

use crate::Mutant;
use crate::places::{self, Arm, Lines, Places};
use serde_json::{Value, json};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::ops::Range;

/// A changed file.
pub struct Rewritten {
    pub text: String,
    /// For each place in the list: `[start, end]` of the mutant and of the code around it in
    /// the changed file [bytes], or why it is not built.
    pub fates: Vec<(usize, Value)>,
}

/// All mutants of the same code.
struct Wrap {
    range: Range<usize>,
    form: Form,
    /// Place in the list, and code.
    mutants: Vec<(usize, String)>,
}

/// How a mutant is chosen.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Form {
    /// Returns a value before the function computes its own.
    Return,
    /// Adds a condition to that of a match arm.
    Beside,
    /// Adds a condition to a match arm without one.
    Condition,
    /// Stands for an expression.
    Instead,
    /// Stands for the value of the named field, which is written without a value.
    Shorthand(String),
}

/// Writes all of `mutants`, each with its place in the list, into `source`.
pub fn rewrite(source: &str, mutants: &[(usize, &Mutant)]) -> syn::Result<Rewritten> {
    let found = places::find(source)?;
    let lines = Lines::new(source);
    let mut fates = Vec::new();
    let mut wraps: BTreeMap<(usize, Reverse<usize>, Form), Vec<(usize, String)>> = BTreeMap::new();
    for &(place, mutant) in mutants {
        match change(source, &lines, &found, mutant) {
            Ok((range, form, code)) => {
                let key = (range.start, Reverse(range.end), form);
                wraps.entry(key).or_default().push((place, code));
            }
            Err(reason) => fates.push((place, json!(reason))),
        }
    }
    // In the order of the keys outer code opens before inner code.
    let wraps = wraps.into_iter().map(|((start, end, form), mutants)| Wrap {
        range: start..end.0,
        form,
        mutants,
    });
    let (text, places) = write(source, &wraps.collect::<Vec<_>>());
    fates.extend(places);
    Ok(Rewritten { text, fates })
}

/// The code that is replaced, how, and by what.
fn change(
    source: &str,
    lines: &Lines,
    found: &Places,
    mutant: &Mutant,
) -> Result<(Range<usize>, Form, String), &'static str> {
    const NOT_FOUND: &str = "not found in the source";
    let start = mutant.span.start;
    let span = lines.offset(start)..lines.offset(mutant.span.end);
    let replacement = mutant.replacement.clone();
    if found
        .constant
        .iter()
        .any(|range| range.contains(&span.start))
    {
        return Err("runs while the program is built");
    }
    match mutant.genre.as_str() {
        "FnValue" => Ok((span, Form::Return, replacement)),
        "MatchArmGuard" => Ok((span, Form::Instead, replacement)),
        "BinaryOperator" => {
            let binary = found.binary.get(&start).ok_or(NOT_FOUND)?;
            if binary.has_let {
                return Err("a condition with `let`");
            }
            let left = &source[binary.left.clone()];
            let right = &source[binary.right.clone()];
            let code = format!("{left} {replacement} {right}");
            Ok((binary.whole.clone(), Form::Instead, code))
        }
        "UnaryOperator" => {
            let (whole, operand) = found.unary.get(&start).ok_or(NOT_FOUND)?;
            let code = source[operand.clone()].to_owned();
            Ok((whole.clone(), Form::Instead, code))
        }
        "MatchArm" => Ok(match found.arms.get(&start).ok_or(NOT_FOUND)? {
            Arm::Guard(range) => (range.clone(), Form::Beside, String::new()),
            Arm::Unguarded(end) => (*end..*end, Form::Condition, String::new()),
        }),
        "StructField" => {
            let field = found.fields.get(&start).ok_or(NOT_FOUND)?;
            let code = format!("({}).{}", &source[field.base.clone()], field.name);
            Ok(match field.shorthand {
                true => (
                    field.value.clone(),
                    Form::Shorthand(field.name.clone()),
                    code,
                ),
                false => (field.value.clone(), Form::Instead, code),
            })
        }
        _ => Err("an unknown kind of mutant"),
    }
}

impl Wrap {
    /// What stands before the code, with the range of each mutant in it, and what after it.
    fn brackets(&self) -> (String, Vec<Range<usize>>, &'static str) {
        let (mut before, after) = match &self.form {
            Form::Return | Form::Condition => (String::new(), ""),
            Form::Beside => (String::new(), ")"),
            Form::Instead => ("(".to_owned(), " })"),
            Form::Shorthand(name) => (format!("{name}: "), " }"),
        };
        let mut ranges = Vec::new();
        for (place, code) in &self.mutants {
            let on = format!("crate::mutant::on({place})");
            before += &match self.form {
                Form::Return => format!("if {on} {{ return "),
                Form::Beside => format!("(!{on}) && ("),
                Form::Condition => format!(" if !{on}"),
                Form::Instead | Form::Shorthand(_) => format!("if {on} {{ "),
            };
            let start = before.len();
            before += code;
            ranges.push(start..before.len());
            before += match self.form {
                Form::Return => "; } ",
                Form::Beside | Form::Condition => "",
                Form::Instead | Form::Shorthand(_) => " } else ",
            };
        }
        if matches!(self.form, Form::Instead | Form::Shorthand(_)) {
            before += "{ ";
        }
        (before, ranges, after)
    }
}

/// What has to be closed.
struct Bracket<'a> {
    wrap: &'a Wrap,
    /// Where it began in the changed file [bytes].
    from: usize,
    /// Where each mutant is, from there [bytes].
    mutants: Vec<Range<usize>>,
    after: &'static str,
}

impl Bracket<'_> {
    fn close(self, text: &mut String, places: &mut Vec<(usize, Value)>) {
        text.push_str(self.after);
        for ((place, _), range) in self.wrap.mutants.iter().zip(self.mutants) {
            let code = [self.from + range.start, self.from + range.end];
            let around = [self.from, text.len()];
            places.push((*place, json!({"code": code, "around": around})));
        }
    }
}

/// Puts the brackets of `wraps` into the source.
fn write(source: &str, wraps: &[Wrap]) -> (String, Vec<(usize, Value)>) {
    let mut text = String::with_capacity(source.len() * 3);
    let mut places = Vec::new();
    let mut open: Vec<Bracket> = Vec::new();
    let mut wraps = wraps.iter().peekable();
    for (at, c) in source.char_indices().chain([(source.len(), '\n')]) {
        // Closed before others open, and after it where nothing is inside.
        let ends = |w: &Bracket| w.wrap.range.end == at;
        while let Some(bracket) = open.pop_if(|w| ends(w)) {
            bracket.close(&mut text, &mut places);
        }
        while let Some(wrap) = wraps.next_if(|w| w.range.start == at) {
            let (before, mutants, after) = wrap.brackets();
            let from = text.len();
            text.push_str(&before);
            open.push(Bracket {
                wrap,
                from,
                mutants,
                after,
            });
            while let Some(bracket) = open.pop_if(|w| ends(w)) {
                bracket.close(&mut text, &mut places);
            }
        }
        text.push(c);
    }
    (text, places)
}
