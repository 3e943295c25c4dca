//! `pickline benchmark`.

use super::args::{BenchmarkArgs, Common, TrackArg};
use super::outputs::{Outputs, WHOLE};
use super::progress::Bar;
use super::session::Session;
use pickline::benchmark::{
    BenchmarkOptions, BenchmarkResult, BenchmarkStudy, Foresight, OutsideProgram, check_keep, keep,
};
use pickline::error::{Result, counted};
use pickline::optimize::Environment;
use pickline::strategies::policy_file;
use pickline_report::{BenchmarkReport, Provenance};
use std::path::PathBuf;

pub(crate) fn run(args: BenchmarkArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.resolve()?.run(session)
}

/// A resolved call.
struct BenchmarkPlan {
    common: Common,
    folder: PathBuf,
    options: BenchmarkOptions,
    update: bool,
    /// Who found the picks of programs and files.
    by: Option<String>,
}

impl BenchmarkArgs {
    fn resolve(self) -> Result<BenchmarkPlan> {
        let common = &self.common;
        common.check()?;
        let program = self.program.as_deref();
        let program = program.map(|call| OutsideProgram::new(call, self.timeout));
        let policies = self.strategy.iter();
        let read: Vec<_> = policies.map(|s| ("--strategy", policy_file(s))).collect();
        common.check_outputs::<BenchmarkReport>("benchmark", &read, &[])?;
        let options = BenchmarkOptions::default()
            .with_seed(common.seed)
            .with_update_hz(common.update_hz)
            .with_only(self.only)
            .with_track(match self.track {
                TrackArg::Online => Foresight::Online,
                TrackArg::Clairvoyant => Foresight::Clairvoyant,
            })
            .with_strategies(self.strategy)
            .with_program(program.transpose()?)
            .with_picks(self.picks)
            .with_bounds(self.bounds);
        Ok(BenchmarkPlan {
            common: self.common,
            folder: self.dir,
            options,
            update: self.update,
            by: self.by,
        })
    }
}

impl BenchmarkPlan {
    fn run(&self, session: &Session) -> Result<()> {
        let study = BenchmarkStudy::new(&self.folder, &self.options)?;
        if self.update {
            check_keep(&self.folder)?;
        }
        let bar = Bar::new(self.common.quiet);
        let environment = Environment {
            stop: session.stop(),
            progress: &bar,
            ledger: session.ledger(),
        };
        let result = self.common.on_threads(|| study.run(&environment))?;
        let set = format!(
            "{} in {}",
            counted(study.instances().len(), "instance"),
            self.folder.display()
        );
        let stations = study.instances().iter().map(|instance| &instance.station);
        let made = Provenance::of_stations(&session.command(), &set, stations, self.common.seed);
        let made = made.without(session.missing_shards());
        let made = made.of_parts(result.entries.len(), study.planned(), "runs");
        let report = BenchmarkReport::new(study.instances(), &result, made);
        let delivered = self
            .common
            .deliver(session, &report, &WHOLE, Outputs::default());
        delivered?;
        result.check()?;
        self.keep(&study, &result)
    }

    /// Writes what is known better into the folder, if that is asked for.
    fn keep(&self, study: &BenchmarkStudy, result: &BenchmarkResult) -> Result<()> {
        if !self.update {
            return Ok(());
        }
        let kept = keep(&self.folder, study, result, self.by.as_deref())?;
        self.common.remark(&format!(
            "{}: {}, {}",
            self.folder.display(),
            counted(kept.better.len(), "better solution"),
            counted(kept.tighter.len(), "tighter bound")
        ));
        Ok(())
    }
}
