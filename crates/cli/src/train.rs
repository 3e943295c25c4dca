//! `pickline train`.

use super::args::TrainArgs;
use super::outputs::WHOLE;
use super::progress::Bar;
use super::session::{Session, tell};
use super::settings::{check_threads, on_threads};
use super::warnings::warn;
use pickline::error::{Error, Result};
use pickline::files;
use pickline::optimize::Environment;
use pickline::rl::{Imitation, PRESETS, Plan};
use pickline::station::{self, Overrides};
use pickline::strategies::policy_file;
use pickline::study::{SavedTraining, TrainOptions, TrainStudy, TrainingEvent, TrainingLine};
use pickline_report::{
    OutputProtection, TrainingReport, VerbReport as _, json_text, learning_curve_csv,
};
use std::path::{Path, PathBuf};

/// Extension of the learning curve, which is written with every checkpoint.
const CURVE: &str = "csv";
/// Extension of the checkpoint.
const CHECKPOINT: &str = "checkpoint.json";

pub(crate) fn run(args: TrainArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    args.resolve(session)?.run(session)
}

/// A resolved call.
struct TrainPlan {
    options: TrainOptions,
    files: PolicyFiles,
    threads: Option<usize>,
    quiet: bool,
}

impl TrainArgs {
    fn resolve(self, session: &Session) -> Result<TrainPlan> {
        check_threads(self.threads)?;
        let plan = self.plan()?;
        let saved = self.resume.as_deref().map(read_checkpoint).transpose()?;
        let names = saved
            .as_ref()
            .map_or(&self.station, |saved| &saved.stations);
        self.check_files(&plan, names)?;
        let lines = lines(names, self.strict)?;
        let mut options = TrainOptions::new(plan, lines)
            .with_seed(self.seed)
            .with_origin(session.command());
        if let Some(steps) = self.steps {
            options = options.with_steps(steps);
        }
        if let Some(saved) = saved {
            options = options.with_resumed(saved);
        }
        Ok(TrainPlan {
            options,
            files: PolicyFiles { policy: self.out },
            threads: self.threads,
            quiet: self.quiet,
        })
    }

    /// Checks that the policy and the files next to it can be written and are not input files. A
    /// resumed checkpoint is the exception: the training continues in it.
    fn check_files(&self, plan: &Plan, stations: &[String]) -> Result<()> {
        if self.out.extension().is_none_or(|name| name != "onnx") {
            let problem = format!("{} does not end in .onnx", self.out.display());
            let cure = "give NAME.onnx; record, curve and checkpoint have the same name, but \
                        other endings";
            return Err(Error::usage("--out", problem, cure));
        }
        let extensions = TrainingReport::file_names().into_iter();
        let extensions = extensions.chain([CURVE, CHECKPOINT]);
        let beside = extensions.map(|extension| self.out.with_extension(extension));
        let beside: Vec<PathBuf> = beside.collect();
        let written: Vec<_> = std::iter::once(&self.out)
            .chain(&beside)
            .map(|path| ("--out", Some(path.as_path())))
            .collect();
        let mut read = vec![("--plan", self.plan.as_deref())];
        let stations = stations.iter().map(|text| station_name(text).0);
        read.extend(stations.map(|name| ("--station", Some(Path::new(name)))));
        let expert = plan.imitation.as_ref();
        let expert = expert.and_then(|imitation| policy_file(&imitation.strategy));
        read.push(("--imitate", expert));
        OutputProtection::of("train")
            .with_force(self.force)
            .check(&read, &written)
    }

    /// The plan from the arguments.
    fn plan(&self) -> Result<Plan> {
        let mut plan = match &self.plan {
            Some(path) => {
                let text = files::read_text(path)?;
                Plan::from_file(&text, &path.display().to_string())?
            }
            None => Plan::preset(self.preset.as_deref().unwrap_or(PRESETS[0].0))?,
        };
        if let Some(rate) = self.learning_rate {
            if !(rate.is_finite() && rate > 0.0) {
                let problem = format!("{rate} is not a learning rate");
                return Err(Error::usage(
                    "--learning-rate",
                    problem,
                    "give a number above 0",
                ));
            }
            plan.ppo.learning_rate = rate;
        }
        if let Some(weight) = self.entropy {
            if !(weight.is_finite() && weight >= 0.0) {
                let problem = format!("{weight} is not a weight");
                return Err(Error::usage("--entropy", problem, "give 0 or more"));
            }
            plan.ppo.ent_coef = weight;
        }
        if let Some(strategy) = &self.imitate {
            let usual = Imitation::of(strategy);
            for (flag, count) in [
                ("--imitate-rounds", self.imitate_rounds),
                ("--imitate-patterns", self.imitate_patterns),
            ] {
                if count == Some(0) {
                    let problem = "0 is not enough to learn from";
                    return Err(Error::usage(flag, problem, "give 1 or more"));
                }
            }
            let (rounds, courses) = (usual.rounds, usual.courses);
            plan.imitation = Some(
                usual
                    .with_rounds(self.imitate_rounds.unwrap_or(rounds))
                    .with_courses(self.imitate_patterns.unwrap_or(courses)),
            );
            // After imitation, the training need not start with easy patterns.
            plan.domain.curriculum = 0.0;
        }
        Ok(plan)
    }
}

impl TrainPlan {
    fn run(self, session: &Session) -> Result<()> {
        let Self {
            options,
            files,
            threads,
            quiet,
        } = self;
        let bar = Bar::new(quiet);
        let environment = Environment {
            stop: session.stop(),
            progress: &bar,
            ..Environment::QUIET
        };
        let (first, trained) = on_threads(threads, || {
            let study = TrainStudy::new(options)?;
            // A training has at least one line.
            let first = study.lines()[0].clone();
            let report = &mut |event: TrainingEvent| files.handle(&event, quiet);
            Ok((first, study.run(&environment, report)?))
        })?;
        let report = TrainingReport::new(&trained, &first);
        files.write(&trained.onnx, &report)?;
        trained.check_converged()?;
        session.print(report.to_table(&WHOLE).as_bytes())
    }
}

/// The policy, and the files next to it.
struct PolicyFiles {
    policy: PathBuf,
}

impl PolicyFiles {
    /// Writes the checkpoint and the learning curve so far, and says what happens.
    fn handle(&self, event: &TrainingEvent, quiet: bool) -> Result<()> {
        let text = match event {
            TrainingEvent::Imitated { round, best } => format!(
                "{} answers, {:.0} % matched, best so far {best}",
                round.answers,
                100.0 * round.agreement
            ),
            TrainingEvent::ImitationStopped { done, planned } => format!(
                "stopped after {done} of {planned} rounds; the best policy so far is kept, but an \
                 imitation cannot be resumed"
            ),
            TrainingEvent::Saved { state, curve } => {
                let state = json_text(state)?;
                files::write_whole(&self.beside(CHECKPOINT), state.as_bytes())?;
                let curve = learning_curve_csv(curve);
                return files::write_whole(&self.beside(CURVE), curve.as_bytes());
            }
            _ => return Ok(()),
        };
        if !quiet {
            tell(&text);
        }
        Ok(())
    }

    /// Writes the policy, the bytes of an ONNX file, and the files of its report.
    fn write(&self, onnx: &[u8], report: &TrainingReport) -> Result<()> {
        files::write_whole(&self.policy, onnx)?;
        for (extension, content) in report.files()? {
            files::write_whole(&self.beside(extension), content.as_bytes())?;
        }
        Ok(())
    }

    /// The policy's path with another extension.
    fn beside(&self, extension: &str) -> PathBuf {
        self.policy.with_extension(extension)
    }
}

/// The training that the checkpoint in `path` describes.
fn read_checkpoint(path: &Path) -> Result<SavedTraining> {
    let text = files::read_text(path)?;
    serde_json::from_str(&text).map_err(|error| {
        let cure = "give a checkpoint written by `pickline train`";
        let place = path.display().to_string();
        Error::input(place, error.to_string(), cure).caused_by(error)
    })
}

/// A station's name or file, and its number of robots if given.
fn station_name(text: &str) -> (&str, Option<usize>) {
    match text.rsplit_once(':') {
        Some((name, count)) if count.parse::<usize>().is_ok() => (name, count.parse().ok()),
        _ => (text, None),
    }
}

/// The lines to train on, each with its text from the command line.
fn lines(names: &[String], strict: bool) -> Result<Vec<TrainingLine>> {
    let load = |text: &String| {
        let (name, robots) = station_name(text);
        let overrides = Overrides::default().with_robots(robots);
        let station = station::load(name, overrides)?;
        warn(strict, station.warnings(name))?;
        Ok(TrainingLine {
            name: text.clone(),
            station,
        })
    };
    names.iter().map(load).collect()
}
