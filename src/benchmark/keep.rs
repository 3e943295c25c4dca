//! Better solutions and tighter bounds, into the folder of the benchmark.

use super::entrant::Entrant;
use super::instance::{Instance, load_instances, load_manifest};
use super::judge::{judge, picks_csv, read};
use super::manifest::{self, MANIFEST, ManifestRow};
use super::study::{BenchmarkResult, BenchmarkStudy, Entry};
use crate::checker::Terms;
use crate::error::{Error, Result};
use crate::files;
use std::collections::HashMap;
use std::path::Path;

/// What became of a benchmark.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Improved {
    /// Instances with a better solution than before.
    pub better: Vec<String>,
    /// Instances with a tighter bound than before.
    pub tighter: Vec<String>,
}

/// Checks that [`keep`] can write the list in `folder` again without losing anything.
///
/// # Errors
/// A list that cannot be read, a comment in it, or a column that is not one of a list.
pub fn check_keep(folder: &Path) -> Result<()> {
    load_rewritable(folder).map(drop)
}

/// The list in `folder`, if it can be written again without losing anything.
fn load_rewritable(folder: &Path) -> Result<Vec<ManifestRow>> {
    let rows = load_manifest(folder)?;
    let file = folder.join(MANIFEST);
    manifest::check_rewritable(&files::read_text(&file)?, &file.display().to_string())?;
    Ok(rows)
}

/// Writes into `folder` what `result` knows better: for each instance the picks of the best solution, if it has
/// more picks than the one that is known, or as many at a higher rate; and bounds, if they are lower. `by` names
/// who found the picks of programs and files.
///
/// # Errors
/// A solution with more picks or a higher rate than a bound, of which one must be wrong; what [`check_keep`]
/// refuses; files that cannot be read or written.
pub fn keep(
    folder: &Path,
    study: &BenchmarkStudy,
    result: &BenchmarkResult,
    by: Option<&str>,
) -> Result<Improved> {
    let mut kept = Improved::default();
    let mut rows = load_rewritable(folder)?;
    let mut files = Vec::new();
    for (place, instance) in study.instances().iter().enumerate() {
        let entries = result.entries.iter();
        let entries: Vec<&Entry> = entries.filter(|entry| entry.instance == place).collect();
        let Some(row) = rows.iter_mut().find(|row| row.name == instance.name) else {
            continue;
        };
        let known = &mut row.known;
        let mut best = None;
        for entry in &entries {
            let entrant = &result.entrants[entry.entrant];
            if let Ok(solution) = &entry.solved
                && *entrant != Entrant::Best
                && known.is_beaten_by(&solution.figures)
            {
                known.picked = Some(solution.figures.picked);
                known.rate = Some(solution.figures.picking_rate());
                known.found_by = found_by(entrant, by);
                best = Some(solution);
            }
        }
        if let Some(solution) = best {
            check_listed(instance)?;
            files.push((
                instance.best_file(),
                picks_csv(instance, &solution.attempts),
            ));
            kept.better.push(instance.name.clone());
        }
        let before = (known.picks_bound, known.rate_bound);
        for found in entries.iter().filter_map(|entry| entry.bound) {
            known.tighten(found);
        }
        if before != (known.picks_bound, known.rate_bound) {
            kept.tighter.push(instance.name.clone());
        }
        let solved = entries
            .iter()
            .filter_map(|entry| entry.solved.as_ref().ok());
        let mut higher = solved.filter_map(|solution| known.excess(&solution.figures));
        if let Some(problem) = higher.next() {
            return Err(above(instance, problem));
        }
        if let (Some(picked), Some(bound)) = (known.picked, known.picks_bound)
            && picked > bound
        {
            let problem = format!("{picked} picks are known, but the certified bound is {bound}");
            return Err(above(instance, problem));
        }
    }
    if files.is_empty() && kept.tighter.is_empty() {
        return Ok(kept);
    }
    files::make_folder(&folder.join("best"))?;
    for (file, text) in files {
        files::write_whole(&file, text.as_bytes())?;
    }
    // The list comes last: it names no solution that is not there.
    let all = load_instances(folder, &[])?;
    let sizes = all
        .iter()
        .map(|instance| (instance.name.as_str(), sizes(instance)));
    let sizes: HashMap<&str, [usize; 2]> = sizes.collect();
    let rows: Vec<_> = rows
        .iter()
        .map(|row| (row, sizes[row.name.as_str()]))
        .collect();
    files::write_whole(&folder.join(MANIFEST), manifest::text(&rows).as_bytes())?;
    Ok(kept)
}

/// A solution above a bound.
fn above(instance: &Instance, problem: String) -> Error {
    let cure = "report this: either the bound or the checker is wrong";
    Error::contradiction(&instance.name, problem, cure)
}

/// Checks that the file of the best known solution of `instance`, which is to be replaced, is no better than the
/// list says.
///
/// # Errors
/// It has other figures than the list, and is possible.
fn check_listed(instance: &Instance) -> Result<()> {
    let file = instance.best_file();
    let Ok(text) = files::read_text(&file) else {
        return Ok(());
    };
    let name = file.display().to_string();
    let attempts = read(instance, &text, &name);
    let Ok(solution) = attempts.and_then(|found| judge(instance, found, Terms::default())) else {
        return Ok(());
    };
    let mistake = instance.known.mistake(&solution.figures);
    mistake.map_or(Ok(()), |problem| {
        let cure = "correct the list, or remove the file; then update";
        Err(Error::input(name, problem, cure))
    })
}

/// Numbers of robots and of items.
fn sizes(instance: &Instance) -> [usize; 2] {
    [instance.station.robots().len(), instance.pattern.len()]
}

/// How a solution was found, in words on one line.
fn found_by(entrant: &Entrant, by: Option<&str>) -> String {
    let text = match (entrant, by) {
        (Entrant::Strategy(text, track), _) => format!("{text} ({})", track.name()),
        (Entrant::Program(_) | Entrant::Picks(_), Some(by)) => by.to_owned(),
        (entrant, _) => entrant.name(),
    };
    // The list has one line for each instance.
    let in_line = |c: char| if c.is_control() { ' ' } else { c };
    text.chars()
        .map(in_line)
        .collect::<String>()
        .trim()
        .to_owned()
}
