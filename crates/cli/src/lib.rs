//! The command line: arguments, resolved settings, one file per verb.

mod access;
mod args;
mod benchmark;
mod bound;
mod compare;
mod dashboard;
mod emulate;
mod flags;
mod game;
mod live;
mod live_strategy;
mod log;
mod man;
mod monitor;
#[cfg(feature = "mqtt")]
mod mqtt;
mod notify;
mod optimize;
mod outputs;
mod pattern;
mod pictures;
mod progress;
mod race;
mod remarks;
#[cfg(feature = "mcap")]
mod replay;
#[cfg(feature = "ros2")]
mod ros2;
mod robots_down;
mod run;
mod save;
mod service;
mod session;
mod settings;
mod shards;
mod simulate;
mod station;
mod station_fit;
mod sweep;
mod sweep_files;
#[cfg(feature = "onnx")]
mod train;
mod verification;
mod warnings;

pub use flags::flag;

use args::{Cli, Command};
use clap::{CommandFactory as _, Parser as _};
use pickline::error::{Error, ErrorKind, Result};
use session::Session;
use std::ffi::OsString;
use std::io::Write as _;
use std::process::ExitCode;

/// Exit code: success.
pub const DONE: u8 = 0;
/// Exit code: a failure that the input did not cause.
pub const FAILED: u8 = 1;
/// Exit code: invalid usage, configuration or input.
pub const USAGE: u8 = 2;
/// Exit code: interrupted; the results so far have been printed.
pub const INTERRUPTED: u8 = 130;

/// The clap definition of the command line: every verb with its options.
pub fn command() -> clap::Command {
    Cli::command()
}

/// The whole program with the command line of this process.
pub fn main() -> ExitCode {
    let words: Vec<_> = std::env::args_os().collect();
    ExitCode::from(call(&words, |session| session))
}

/// The whole program as a part of another one, with the command line `words`, of which the first is the
/// name of the program. Returns the exit code. Verbs that can stop early take Ctrl-C and SIGTERM of the
/// process for themselves.
pub fn call_hosted(words: &[OsString]) -> u8 {
    call(words, Session::hosted)
}

/// Runs one shard of a call (`--shard I/N`) as a part of another program: prints nothing, and leaves the
/// signals of the process alone. `words` are as for [`call_hosted`].
///
/// # Errors
/// What the program would have printed as its error.
pub fn make_shard(words: &[OsString]) -> Result<()> {
    let mut cli = Cli::try_parse_from(words).map_err(|error| {
        let problem = error.to_string();
        let problem = problem.trim_start_matches("error: ").trim_end();
        Error::usage("the arguments", problem, "see `pickline --help`")
    })?;
    let mut is_shard = false;
    if let Some((parts, common)) = cli.command.shards() {
        is_shard = parts.shard.is_some();
        common.quiet = true;
    }
    if !is_shard {
        return Err(Error::usage(
            "the arguments",
            "they are not those of a shard",
            "give one of optimize, compare, sweep and benchmark, with --shard",
        ));
    }
    let arguments = words.iter().skip(1);
    let arguments = arguments.map(|word| word.to_string_lossy().into_owned());
    let session = Session::new(arguments.collect()).unattended();
    run(cli.command, &session).map_err(|error| error.spell_settings(flags::flag))
}

/// Parses the command line, runs the verb in the session that `prepare` makes of a new one, and
/// reports an error once.
fn call(words: &[OsString], prepare: impl FnOnce(Session) -> Session) -> u8 {
    let cli = match Cli::try_parse_from(words) {
        Ok(cli) => cli,
        // clap's own message names neither the argument nor a cure.
        Err(error) if error.kind() == clap::error::ErrorKind::InvalidUtf8 => {
            session::tell(&format!("pickline: {}", not_text(words)));
            return USAGE;
        }
        Err(error) => return print_clap(&error),
    };
    // A path need not be Unicode; the recorded command line shows it lossily.
    let arguments = words.iter().skip(1);
    let arguments = arguments.map(|word| word.to_string_lossy().into_owned());
    let session = prepare(Session::new(arguments.collect()));
    match run(cli.command, &session) {
        Ok(()) if session.interrupted() => INTERRUPTED,
        Ok(()) => DONE,
        Err(error) => {
            let code = exit_code(error.kind());
            session.complain(&format!("pickline: {}", error.spell_settings(flags::flag)));
            code
        }
    }
}

/// Prints what clap returns instead of arguments: help and version, which are results, or a usage
/// error with exit code 2.
fn print_clap(error: &clap::Error) -> u8 {
    let printed = error.print().and_then(|()| std::io::stdout().flush());
    match printed.or_else(session::unless_closed) {
        Err(failure) if !error.use_stderr() => {
            session::tell(&format!("pickline: {failure}"));
            FAILED
        }
        _ if error.use_stderr() => USAGE,
        _ => DONE,
    }
}

/// What the failure was: wrong input is for the user to change, anything else is not.
fn exit_code(kind: ErrorKind) -> u8 {
    match kind {
        ErrorKind::Usage | ErrorKind::Input | ErrorKind::Path => USAGE,
        ErrorKind::Interrupted => INTERRUPTED,
        _ => FAILED,
    }
}

/// The error for the first argument that is not valid Unicode.
fn not_text(words: &[OsString]) -> Error {
    let mut numbered = words.iter().cloned().enumerate();
    let found = numbered.find(|(_, word)| word.to_str().is_none());
    let (place, word) = found.unwrap_or_default();
    Error::usage(
        format!("argument {place}"),
        format!("{word:?} is not valid UTF-8, which this argument requires"),
        "rename the file, or give a folder or a link to it with a valid UTF-8 name; a pattern \
         can also be read from stdin (-)",
    )
}

/// Runs the verb, or the shard of it that is asked for.
fn run(mut command: Command, session: &Session) -> Result<()> {
    let Some((parts, common)) = command.shards() else {
        return run_whole(command, session);
    };
    let (parts, force, quiet) = (parts.clone(), common.force, common.quiet);
    shards::run(&parts, (force, quiet), session, || {
        run_whole(command, session)
    })
}

fn run_whole(command: Command, session: &Session) -> Result<()> {
    match command {
        Command::Compare(args) => compare::run(*args, session),
        Command::Sweep(args) => sweep::run(*args, session),
        Command::Optimize(args) => match args.race.race {
            Some(delta) => race::run(*args, delta, session),
            None => optimize::run(*args, session),
        },
        Command::Game(args) => game::run(*args, session),
        Command::Bound(args) => bound::run(*args, session),
        Command::Benchmark(args) => benchmark::run(*args, session),
        Command::Merge(args) => shards::merge(&args, session),
        Command::Simulate(args) => simulate::run(*args, session),
        Command::Check(args) => verification::run(*args, session),
        #[cfg(feature = "onnx")]
        Command::Train(args) => train::run(*args, session),
        Command::Run(args) => run::run(*args, session),
        Command::Emulate(args) => emulate::run(*args, session),
        Command::Pattern(args) => pattern::run(args.command.unwrap_or_default(), session),
        Command::Station(args) => station::run(args.command.unwrap_or_default(), session),
        Command::Service(args) => service::run(args.command.unwrap_or_default(), session),
        Command::Man(args) => man::run(&args.command, session),
        Command::Completions { shell } => {
            let shell = shell
                .or_else(clap_complete::Shell::from_env)
                .unwrap_or(clap_complete::Shell::Bash);
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut self::command(), "pickline", &mut script);
            session.print(&script)
        }
    }
}
