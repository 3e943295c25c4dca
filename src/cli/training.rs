//! What the optimiser finds for a line before a verb's own work: robust GT, and the
//! bases of strategies that look ahead.

use super::args::{Common, TrainingArgs};
use super::session::tell;
use crate::dispatch::RuleAssignment;
use crate::error::{Error, Result, shown_number};
use crate::optimize::{
    Environment, Evaluator, Grasp, Objective, Optimum, Ranked, Risk, Search, SearchKind, SpeedScan,
    optimize,
};
use crate::pattern::{PatternSource, Recipe};
use crate::planning::{Allowance, Budget};
use crate::station::Station;
use crate::strategies::{Blueprint, Parsed, Setup};
use std::cell::OnceCell;

/// How many of the best assignments serve as bases.
const BASES: usize = 4;
/// Grids, and as many Poisson patterns, on which bases are found when there is no other
/// training: they need not be in exact order.
const FEW_PATTERNS: usize = 10;
/// Robots beyond which a line is long: nearly all assignments are then tied on so few
/// patterns, and to tell bases apart by speed limits would take most of the time for an
/// order that no longer matters.
const LONG: usize = 6;
/// Items in each of them.
const ITEMS: usize = 150;

/// A line to find assignments for.
#[derive(Clone, Copy)]
pub struct Line<'a> {
    station: &'a Station,
    seed: u64,
    update_hz: f64,
    quiet: bool,
    environment: &'a Environment<'a>,
}

impl<'a> Line<'a> {
    /// A line under the settings that all verbs have in common.
    pub fn new(common: &Common, station: &'a Station, environment: &'a Environment<'a>) -> Self {
        Self {
            station,
            seed: common.seed,
            update_hz: common.update_hz,
            quiet: common.quiet,
            environment,
        }
    }

    /// The search on `patterns`, ties broken by speed limits under `scan`.
    fn train(
        &self,
        patterns: PatternSource,
        items: usize,
        scan: Option<SpeedScan>,
    ) -> Result<(Optimum, String)> {
        let recipe = Recipe {
            belt: *self.station.belt(),
            items,
            shape: Default::default(),
            attributes: Default::default(),
            seed: self.seed,
        };
        let set = patterns.build(&recipe)?;
        let objective = Objective::PickingRate;
        let evaluator = Evaluator::new(self.station, &set.patterns, objective, self.update_hz)?;
        let search = Search {
            kind: SearchKind::Auto,
            grasp: Grasp {
                seed: self.seed,
                ..Grasp::default()
            },
            risk: Risk::Mean,
            scan,
        };
        let optimum = optimize(&evaluator, &search, self.environment)?;
        if self.environment.stopped() {
            return Err(Error::Interrupted);
        }
        Ok((optimum, set.description))
    }

    /// Robust GT, given or optimised on the balanced set.
    ///
    /// # Errors
    /// Rules that do not fit the line, [`Error::Interrupted`].
    pub fn robust(&self, training: &TrainingArgs) -> Result<Robust> {
        if let Some(text) = &training.robust {
            let rules = text
                .parse::<RuleAssignment>()
                .map_err(|e| e.at("--robust"))?;
            let rules = rules
                .for_robots(self.station.robots().len())
                .map_err(|e| e.at("--robust"))?;
            return Ok(Robust {
                rules,
                note: "robust GT as given (--robust)".into(),
                best_few: OnceCell::new(),
            });
        }
        let cure = "--robust R1,R2,... gives it instead";
        if let Some(text) = slow(self.station, "the search for robust GT", cure)
            && !self.quiet
        {
            tell(&text);
        }
        let (optimum, set) = {
            let (patterns, scan) = ("balanced".parse()?, Some(SpeedScan::default()));
            self.train(patterns, training.train_items, scan)?
        };
        Ok(Robust {
            rules: optimum.ranking.best().assignment.clone(),
            note: format!("robust GT is the best on {set}"),
            best_few: OnceCell::from(best_few(&optimum)),
        })
    }

    /// `strategy` on this line.
    ///
    /// `known` are assignments that a search has found already; `allowance` is what one
    /// decision may cost where the strategy itself does not say.
    ///
    /// # Errors
    /// As for [`Parsed::on`], and [`Error::Interrupted`].
    pub fn put(
        &self,
        strategy: &Parsed,
        known: &OnceCell<Vec<RuleAssignment>>,
        allowance: Allowance,
    ) -> Result<Blueprint> {
        let robots = self.station.robots().len();
        let bases = || {
            if let Some(found) = known.get() {
                return Ok(found.clone());
            }
            let few = PatternSource::Balanced(FEW_PATTERNS);
            let scan = (robots <= LONG).then(SpeedScan::default);
            let found = best_few(&self.train(few, ITEMS, scan)?.0);
            Ok(known.get_or_init(|| found).clone())
        };
        let setup = Setup {
            robots,
            bases: &bases,
            allowance,
        };
        strategy.on(&setup)
    }
}

/// Robust GT and what else its search found.
pub struct Robust {
    pub rules: RuleAssignment,
    /// Where it comes from, for the foot of a report.
    pub note: String,
    /// The best few assignments, once known.
    pub best_few: OnceCell<Vec<RuleAssignment>>,
}

/// The best few that differ in what they pick. FIFO and PP, say, are one rule where all
/// items weigh the same, and a second copy of a base is only a cost.
fn best_few(optimum: &Optimum) -> Vec<RuleAssignment> {
    let mut found: Vec<&Ranked> = Vec::new();
    let same = |a: &Ranked, b: &Ranked| {
        (a.mean, a.worst, a.picked_share) == (b.mean, b.worst, b.picked_share)
    };
    for entry in &optimum.ranking.entries {
        if found.len() < BASES && !found.iter().any(|other| same(other, entry)) {
            found.push(entry);
        }
    }
    found.iter().map(|entry| entry.assignment.clone()).collect()
}

/// What is told before `what` on a long line, with the flags that cut it.
pub fn slow(station: &Station, what: &str, cure: &str) -> Option<String> {
    let robots = station.robots().len();
    (robots > LONG).then(|| format!("{what} on a line of {robots} robots may take minutes; {cure}"))
}

/// The budget that `--budget-ms` gives each decision.
///
/// # Errors
/// A time that is none.
pub fn budget(ms: Option<f64>) -> Result<Option<Budget>> {
    let read = |ms: f64| {
        Budget::milliseconds(ms).ok_or_else(|| {
            let (least, most) = Budget::MILLISECONDS.into_inner();
            Error::input(
                "--budget-ms",
                format!("{} is not a time for a decision", shown_number(ms)),
                format!("give milliseconds, from {least} to {most}"),
            )
        })
    };
    ms.map(read).transpose()
}

/// What a strategy is in full, where its name does not say it.
pub fn full_name(blueprint: &Blueprint) -> Option<String> {
    let full = blueprint.make().name();
    (full != blueprint.name()).then(|| format!("{} is {full}", blueprint.name()))
}
