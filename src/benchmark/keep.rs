//! Better solutions and tighter bounds, into the folder of the benchmark.

use super::entrant::Entrant;
use super::instance::{Instance, load_instances, load_manifest};
use super::judge::{Solution, picks_csv};
use super::manifest::{self, Known, MANIFEST};
use super::study::{BenchmarkResult, BenchmarkStudy, Entry};
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

/// Rates that differ by less, relatively, differ by rounding.
const SAME_RATE: f64 = 1e-9;

/// Writes into `folder` what `result` knows better: for each instance the picks of the best solution, if it has
/// more picks than the one that is known, or as many at a higher rate; and bounds, if they are lower. `by` names
/// who found the picks of programs and files.
///
/// # Errors
/// A solution with more picks than a bound, of which one must be wrong; files that cannot be read or written.
pub fn keep(
    folder: &Path,
    study: &BenchmarkStudy,
    result: &BenchmarkResult,
    by: Option<&str>,
) -> Result<Improved> {
    let mut kept = Improved::default();
    let mut rows = load_manifest(folder)?;
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
                && is_better(solution, known)
            {
                known.picked = Some(solution.figures.picked);
                known.rate = Some(solution.figures.picking_rate());
                known.found_by = found_by(entrant, by);
                best = Some(solution);
            }
        }
        if let Some(solution) = best {
            files.push((
                instance.best_file(),
                picks_csv(instance, &solution.attempts),
            ));
            kept.better.push(instance.name.clone());
        }
        if tighten(known, &entries) {
            kept.tighter.push(instance.name.clone());
        }
        if let (Some(picked), Some(bound)) = (known.picked, known.picks_bound)
            && picked > bound
        {
            return Err(Error::refuted(format!(
                "{}: a solution has {picked} picks, but the certified bound is {bound}: please report this",
                instance.name
            )));
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

/// Numbers of robots and of items.
fn sizes(instance: &Instance) -> [usize; 2] {
    [instance.station.robots().len(), instance.pattern.len()]
}

fn is_better(solution: &Solution, known: &Known) -> bool {
    let figures = &solution.figures;
    match known.picked {
        Some(picked) if picked == figures.picked => {
            figures.picking_rate() > known.rate.unwrap_or_default() * (1.0 + SAME_RATE)
        }
        picked => picked.is_none_or(|picked| figures.picked > picked),
    }
}

/// Lowers the bounds of `known` to those that were found; returns whether any was higher.
fn tighten(known: &mut Known, entries: &[&Entry]) -> bool {
    let before = (known.picks_bound, known.rate_bound);
    for found in entries.iter().filter_map(|entry| entry.bound) {
        let picks = known.picks_bound.unwrap_or(usize::MAX);
        known.picks_bound = Some(picks.min(found.picks));
        if let Some(rate) = found.rate {
            known.rate_bound = Some(known.rate_bound.unwrap_or(f64::INFINITY).min(rate));
        }
    }
    before != (known.picks_bound, known.rate_bound)
}

/// How a solution was found, in words.
fn found_by(entrant: &Entrant, by: Option<&str>) -> String {
    match (entrant, by) {
        (Entrant::Strategy(text, track), _) => format!("{text} ({})", track.name()),
        (Entrant::Program(_) | Entrant::Picks(_), Some(by)) => by.to_owned(),
        (entrant, _) => entrant.name(),
    }
}
