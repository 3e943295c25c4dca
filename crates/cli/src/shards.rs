//! `--shard` of the verbs that can be split, and `pickline merge`.

use super::args::{Cli, MergeArgs, ShardArgs};
use super::session::Session;
use clap::Parser as _;
use pickline::error::{Error, ErrorKind, Result, counted, listed};
use pickline::files;
use pickline::shards::{Ledger, Recorded, Shard};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What the file of a shard says it is.
const FORMAT: &str = "pickline-shard";
/// The version of that format.
const VERSION: u32 = 1;
/// The verbs that can be split.
const VERBS: [&str; 4] = ["optimize", "compare", "sweep", "benchmark"];

/// The file of a shard.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ShardFile {
    /// [`FORMAT`].
    format: String,
    /// [`VERSION`].
    version: u32,
    /// Name and version of the program.
    program: String,
    /// The call, without what cannot change its result.
    command: String,
    /// The arguments of the call, without those that make it a shard.
    arguments: Vec<String>,
    /// The number of the shard; 0 for the shared work only.
    shard: usize,
    /// The number of shards.
    shards: usize,
    recorded: Recorded,
    /// A hash of all of this with an empty hash.
    hash: String,
}

/// Name and version of the program.
fn program() -> String {
    format!("pickline {}", env!("CARGO_PKG_VERSION"))
}

impl ShardFile {
    /// The file at `path`.
    ///
    /// # Errors
    /// A file that cannot be read or is not one of this version of the program.
    fn read(path: &Path) -> Result<Self> {
        let text = files::read_text(path)?;
        let wrong = |problem: String| {
            let cure = "name files that --shard wrote, or the folder with them";
            Error::input(path.display().to_string(), problem, cure)
        };
        let file: Self = serde_json::from_str(&text)
            .map_err(|error| wrong(format!("is not the file of a shard: {error}")))?;
        if file.format != FORMAT {
            return Err(wrong("is not the file of a shard".into()));
        }
        let verb = file.arguments.first();
        if !verb.is_some_and(|verb| VERBS.contains(&verb.as_str())) {
            return Err(wrong("is not of a verb that can be split".into()));
        }
        let other = |written: String, read: String| {
            let problem = format!("was written by {written}, and this is {read}");
            let cure = "run all shards and the merge with one version of the program";
            Err(Error::input(path.display().to_string(), problem, cure))
        };
        if file.program != program() {
            return other(file.program, program());
        }
        if file.version != VERSION {
            let format = |version| format!("version {version} of the format");
            return other(format(file.version), format(VERSION));
        }
        Shard::new(file.shard, file.shards).map_err(|error| wrong(error.problem()))?;
        let hash = file.hash.clone();
        let file = file.hashed()?;
        if file.hash != hash {
            return Err(Error::input(
                path.display().to_string(),
                "is damaged: its content does not have the hash that it says",
                "run this shard again",
            ));
        }
        Ok(file)
    }

    /// The same with the hash of its content.
    ///
    /// # Errors
    /// None, as what is recorded can be written.
    fn hashed(self) -> Result<Self> {
        let whole = Self {
            hash: String::new(),
            ..self
        };
        let hash = files::fingerprint(whole.text()?);
        Ok(Self { hash, ..whole })
    }

    /// Its content as a text.
    ///
    /// # Errors
    /// None, as what is recorded can be written.
    fn text(&self) -> Result<String> {
        serde_json::to_string(self)
            .map_err(|error| Error::internal(format!("a shard cannot be written: {error}")))
    }
}

/// The file of `shard` in `folder`.
fn file_of(folder: &Path, shard: Shard) -> PathBuf {
    folder.join(format!("{}-of-{}.json", shard.index(), shard.count()))
}

/// Runs `work`, a verb that can be split: all of it, or the shard that `args` ask for, whose file is then
/// written.
///
/// # Errors
/// As for `work`; a folder that cannot be written, or has shards of another call.
pub(crate) fn run(
    args: &ShardArgs,
    (force, quiet): (bool, bool),
    session: &Session,
    work: impl FnOnce() -> Result<()>,
) -> Result<()> {
    let Some(shard) = &args.shard else {
        return work();
    };
    let shard: Shard = shard.parse()?;
    let folder = &args.shard_dir;
    files::check_folder(folder)?;
    let target = file_of(folder, shard);
    let others = shard_names(folder)?;
    if let Some((_, count, other)) = others.iter().find(|(_, count, _)| *count != shard.count()) {
        return Err(Error::path(
            "--shard-dir",
            format!(
                "{} is one of {count} shards, not {}",
                other.display(),
                shard.count()
            ),
            "name another folder for another number of shards, or delete those",
        ));
    }
    let command = session.command();
    let common = file_of(folder, Shard::new(0, shard.count())?);
    let mut known = Recorded::default();
    // One of the others stands for all of them.
    let other = others.into_iter().map(|(_, _, file)| file);
    let other = other
        .filter(|file| ![&target, &common].contains(&file))
        .take(1);
    for path in [target.clone(), common.clone()].into_iter().chain(other) {
        if !path.exists() || (force && path == target) {
            continue;
        }
        let file = ShardFile::read(&path)?;
        if file.command != command {
            return Err(Error::path(
                "--shard-dir",
                format!(
                    "{} is a shard of another call: {}",
                    path.display(),
                    file.command
                ),
                "name another folder for the shards of this call",
            ));
        }
        if path == common && shard.index() > 0 {
            known = file.recorded;
        }
    }
    session.set_ledger(Ledger::of_shard(shard, known))?;
    match work() {
        Err(error) if error.kind() == ErrorKind::Sharded => {}
        Err(error) => return Err(error),
        Ok(()) => return Err(Error::internal("a shard has a result of the whole")),
    }
    let file = ShardFile {
        format: FORMAT.to_owned(),
        version: VERSION,
        program: program(),
        command,
        arguments: session.arguments_without_shard(),
        shard: shard.index(),
        shards: shard.count(),
        recorded: session.ledger().recorded(),
        hash: String::new(),
    };
    let file = file.hashed()?;
    let text = file.text()?;
    files::make_folder(folder)?;
    files::write_whole(&target, text.as_bytes())?;
    if !quiet {
        super::session::tell(&format!(
            "shard {shard}: {} in {}",
            counted(file.recorded.units(), "unit"),
            target.display()
        ));
    }
    Ok(())
}

/// Refuses to make a shard of a call with `option`.
///
/// # Errors
/// A shard is asked for.
pub(crate) fn refuse(args: &ShardArgs, option: &str, why: &str) -> Result<()> {
    match args.shard {
        None => Ok(()),
        Some(_) => Err(Error::usage(
            "--shard",
            format!("does not apply to {option}, {why}"),
            "leave one of the two out",
        )),
    }
}

/// Puts shards together and goes on as the call that they are of.
///
/// # Errors
/// Files that are not shards of one call, missing ones, and what the call itself may return.
pub(crate) fn merge(args: &MergeArgs, session: &Session) -> Result<()> {
    let paths = shard_files(&args.shards)?;
    let mut found: BTreeMap<usize, PathBuf> = BTreeMap::new();
    let mut first: Option<ShardFile> = None;
    let mut all = Recorded::default();
    for path in paths {
        let mut file = ShardFile::read(&path)?;
        let place = path.display().to_string();
        let wrong = |problem: String, cure: &str| Err(Error::input(place, problem, cure));
        if let Some(first) = &first {
            if first.command != file.command {
                let problem = format!("is of the call {}, not {}", file.command, first.command);
                return wrong(problem, "merge the shards of one call");
            }
            if first.shards != file.shards {
                let problem = format!("is one of {} shards, not {}", file.shards, first.shards);
                return wrong(problem, "merge shards of the same number");
            }
        }
        if let Some(other) = found.insert(file.shard, path.clone()) {
            let problem = format!("is the same shard as {}", other.display());
            return wrong(problem, "give each shard once");
        }
        if let Err(problem) = all.add(std::mem::take(&mut file.recorded)) {
            let cure = "run all shards again, with the same files and version of pickline";
            return wrong(problem, cure);
        }
        first.get_or_insert(file);
    }
    let Some(first) = first else {
        let folders: Vec<String> = args
            .shards
            .iter()
            .map(|p| p.display().to_string())
            .collect();
        return Err(Error::path(
            "SHARDS",
            format!("there is no file of a shard in {}", listed(&folders)),
            "run the shards first, for example pickline compare --shard 1/2",
        ));
    };
    let missing = (1..=first.shards).filter(|shard| !found.contains_key(shard));
    let missing: Vec<String> = missing.map(|shard| shard.to_string()).collect();
    let without = (!missing.is_empty()).then(|| in_words(&missing, first.shards));
    if let (Some(without), false) = (&without, args.partial) {
        return Err(Error::input(
            "SHARDS",
            without.as_str(),
            "run them, or add --partial to leave out what is missing",
        ));
    }
    let mut first = first;
    if args.force && !first.arguments.iter().any(|word| word == "--force") {
        first.arguments.push("--force".to_owned());
    }
    let words = std::iter::once("pickline").chain(first.arguments.iter().map(String::as_str));
    let cli = Cli::try_parse_from(words).map_err(|error| {
        let problem = error.to_string();
        let problem = problem.lines().next().unwrap_or_default().to_owned();
        Error::input("SHARDS", problem, "run the shards again")
    })?;
    let whole = session.of_call(first.arguments, without);
    whole.set_ledger(Ledger::of_merge(all, !missing.is_empty()))?;
    super::run(cli.command, &whole)
}

/// Which of `count` shards are missing.
fn in_words(missing: &[String], count: usize) -> String {
    let some: Vec<&String> = missing.iter().take(10).collect();
    let are = if missing.len() == 1 { "is" } else { "are" };
    let list = match missing.len() - some.len() {
        0 => listed(&some),
        more => {
            let some: Vec<&str> = some.iter().map(|shard| shard.as_str()).collect();
            format!("{} and {more} more", some.join(", "))
        }
    };
    format!("of {count} shards, {list} {are} missing")
}

/// The files that `paths` name, and those of shards in the folders among them.
///
/// # Errors
/// A folder that cannot be read.
fn shard_files(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for path in paths {
        if path.exists() && !path.is_dir() {
            found.push(path.clone());
            continue;
        }
        found.extend(shard_names(path)?.into_iter().map(|(_, _, file)| file));
    }
    Ok(found)
}

/// The files in `folder` that are named as shards, each with its number and the number of all, in order;
/// none if there is no folder.
///
/// # Errors
/// A folder that cannot be read.
fn shard_names(folder: &Path) -> Result<Vec<(usize, usize, PathBuf)>> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|error| Error::read(folder, error))? {
        let file = entry.map_err(|error| Error::read(folder, error))?.path();
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let parts = name.strip_suffix(".json");
        let parts = parts.and_then(|name| name.split_once("-of-"));
        let numbers = parts.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        if let Some((index, count)) = numbers {
            found.push((index, count, file.clone()));
        }
    }
    found.sort_by_key(|(index, count, _)| (*count, *index));
    Ok(found)
}
