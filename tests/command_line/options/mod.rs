//! Every option of every verb has its effect: for each there is a row with a test that fails if
//! the option is parsed and then ignored.
//!
//! A row calls the program with the option and without, on inputs so small that the result can
//! be computed by hand. An option that has no row fails `every_option_has_a_row`.

mod benchmark;
mod conditions;
mod elsewhere;
mod emulate;
mod experiments;
mod files;
mod fit;
mod patterns;
mod recordings;
mod rig;
mod run;
mod runs;
mod searches;
mod settings;
mod shards;
mod station;
mod transport;
mod verification;

use clap::{Arg, Command};
use rig::Rig;
pub use rig::STATION;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// An option, as it is typed or `<name>` of an argument without a flag, with the verbs that take
/// it and the test of its effect, which is handed the verb.
struct Row {
    verbs: &'static [&'static str],
    option: &'static str,
    holds: fn(&Rig, &str),
}

const fn row(verbs: &'static [&'static str], option: &'static str, holds: fn(&Rig, &str)) -> Row {
    Row {
        verbs,
        option,
        holds,
    }
}

/// The rows of this folder.
const ROWS: [&[Row]; 15] = [
    settings::ROWS,
    station::ROWS,
    conditions::ROWS,
    patterns::ROWS,
    searches::ROWS,
    experiments::ROWS,
    files::ROWS,
    fit::ROWS,
    recordings::ROWS,
    run::ROWS,
    emulate::ROWS,
    transport::ROWS,
    verification::ROWS,
    benchmark::ROWS,
    shards::ROWS,
];

/// Options that are taken for the sake of others and change nothing: the unit names its place as
/// it will be, wherever the files are staged.
const IDLE: [&str; 1] = ["service show --root"];

/// Runs all `rows` and names every option without its effect. Then each row has to fail on a
/// program that ignores its option, which is why it is here.
fn hold(rows: &[Row]) {
    let command = whole_command();
    let mut failed = Vec::new();
    for row in rows {
        for verb in row.verbs {
            let name = format!("{verb} {}", row.option);
            let holds = |rig: Rig| {
                let holds = AssertUnwindSafe(|| (row.holds)(&rig, verb));
                catch_unwind(holds).is_ok()
            };
            if !holds(Rig::new()) {
                failed.push(format!("{name} has no effect"));
            } else if let Some(ignoring) = Rig::ignoring(&command, verb, row.option)
                && !IDLE.contains(&name.as_str())
                && holds(ignoring)
            {
                failed.push(format!("{name} could be ignored"));
            }
        }
    }
    assert!(failed.is_empty(), "{}", failed.join(", "));
}

fn whole_command() -> Command {
    let mut command = pickline_cli::command().disable_help_subcommand(true);
    command.build();
    command
}

/// Adds the options of `command`, whose verb is `path`, and of the verbs below it.
fn collect(command: &Command, path: &str, found: &mut BTreeSet<String>) {
    let name = |argument: &Arg| match argument.get_long() {
        Some(long) => format!("--{long}"),
        None => format!("<{}>", argument.get_id()),
    };
    let own = command.get_arguments();
    // These are clap's.
    let own = own.filter(|argument| !["help", "version"].contains(&argument.get_id().as_str()));
    found.extend(own.map(|argument| format!("{path} {}", name(argument)).trim().to_owned()));
    for part in command.get_subcommands() {
        collect(part, format!("{path} {}", part.get_name()).trim(), found);
    }
}

#[test]
fn every_option_has_a_row() {
    let mut options = BTreeSet::new();
    collect(&whole_command(), "", &mut options);
    let mut rows = BTreeSet::new();
    let own = ROWS.into_iter().flatten();
    let own = own.map(|row| (row.verbs, row.option));
    for (verbs, option) in own.chain(elsewhere::options()) {
        for verb in verbs {
            let row = format!("{verb} {option}");
            assert!(rows.insert(row.clone()), "two rows for {row}");
        }
    }
    let missing: Vec<_> = options.difference(&rows).collect();
    assert!(missing.is_empty(), "no test of the effect of {missing:?}");
    let unknown: Vec<_> = rows.difference(&options).collect();
    assert!(
        unknown.is_empty(),
        "rows for what is no option: {unknown:?}"
    );
}
