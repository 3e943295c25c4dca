//! `pickline train`.

use super::args::TrainArgs;
use super::flags::flag;
use super::outputs;
use super::progress::Bar;
use super::session::{Session, tell};
use super::settings::{check_threads, on_threads};
use super::warnings::warn;
use pickline::dispatch::RULES;
use pickline::error::{Error, Result};
use pickline::experiment::load_cases;
use pickline::files;
use pickline::optimize::{Environment, Progress as _};
use pickline::rl::domain::{Course, scenes};
use pickline::rl::{
    Checkpoint, Imitation, Judged, Kept, PRESETS, Plan, Round, Trainer, TrainingResults, Trial,
    TrialName,
};
use pickline::station::{self, Overrides, Station};
use pickline::strategies::{Parsed, default_assignment, parse, policy_file};
use pickline_report::{Provenance, curve_chart, json_text};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Number of patterns per random case on which the policy is scored during training.
const TRIALS: usize = 10;
/// The first seed of these patterns, far from the seeds of tables, which start at 1.
const TRIAL_SEED: u64 = 990_000;
/// Maximum number of robots for which greedy GT (game theory) is found in seconds.
const MOST_ROBOTS: usize = 6;
/// Extensions of the files written next to a policy.
const BESIDE: [&str; 4] = ["json", "csv", "svg", "checkpoint.json"];

pub fn run(args: &TrainArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    check_threads(args.threads)?;
    let plan = plan(args)?;
    let resumed = args.resume.as_deref().map(|path| {
        let text = files::read_text(path)?;
        serde_json::from_str::<Saved>(&text).map_err(|error| {
            let cure = "give a checkpoint written by `pickline train`";
            let place = path.display().to_string();
            Error::input(place, error.to_string(), cure).caused_by(error)
        })
    });
    let resumed = resumed.transpose()?;
    let names = resumed
        .as_ref()
        .map_or(&args.station, |saved| &saved.stations);
    check_files(args, &plan, names)?;
    let stations = stations(names, args.strict)?;
    let lines: Vec<Station> = stations
        .iter()
        .map(|(_, station)| station.clone())
        .collect();
    let expert = expert(&plan, &lines)?;
    let text = on_threads(args.threads, || {
        let (trainer, kept) = match resumed {
            Some(saved) => {
                let mut trainer = Trainer::resume(saved.trainer, lines)?;
                if let Some(steps) = args.steps {
                    trainer.up_to(steps);
                }
                (trainer, saved.score)
            }
            None => (Trainer::new(plan, lines, args.seed)?, Kept::default()),
        };
        let courses = trials(&stations)?;
        TrainingRun {
            args,
            session,
            started: Instant::now(),
            trainer,
            stations: stations.iter().map(|(name, _)| name.clone()).collect(),
            expert,
        }
        .run(&courses, kept)
    })?;
    session.print(text.as_bytes())
}

/// Checks that the policy and the files next to it can be written and are not input files. A
/// resumed checkpoint is the exception: the training continues in it.
fn check_files(args: &TrainArgs, plan: &Plan, stations: &[String]) -> Result<()> {
    if args.out.extension().is_none_or(|name| name != "onnx") {
        let problem = format!("{} does not end in .onnx", args.out.display());
        let cure =
            "give NAME.onnx; record, curve and checkpoint have the same name, but other endings";
        return Err(Error::usage("--out", problem, cure));
    }
    let beside = BESIDE.map(|ending| args.out.with_extension(ending));
    let written: Vec<_> = std::iter::once(&args.out)
        .chain(&beside)
        .map(|path| ("--out", Some(path.as_path())))
        .collect();
    let mut read = vec![("--plan", args.plan.as_deref())];
    let stations = stations.iter().map(|text| station_name(text).0);
    read.extend(stations.map(|name| ("--station", Some(Path::new(name)))));
    let expert = plan.imitation.as_ref();
    let expert = expert.and_then(|imitation| policy_file(&imitation.strategy));
    read.push(("--imitate", expert));
    outputs::check("train", args.force, &read, &written)
}

/// The plan from the arguments.
fn plan(args: &TrainArgs) -> Result<Plan> {
    let mut plan = match &args.plan {
        Some(path) => {
            let text = files::read_text(path)?;
            Plan::from_file(&text, &path.display().to_string())?
        }
        None => Plan::preset(args.preset.as_deref().unwrap_or(PRESETS[0].0))?,
    };
    if let Some(steps) = args.steps {
        plan.steps = steps;
    }
    if let Some(rate) = args.learning_rate {
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
    if let Some(weight) = args.entropy {
        if !(weight.is_finite() && weight >= 0.0) {
            let problem = format!("{weight} is not a weight");
            return Err(Error::usage("--entropy", problem, "give 0 or more"));
        }
        plan.ppo.ent_coef = weight;
    }
    if let Some(strategy) = &args.imitate {
        let usual = Imitation::of(strategy);
        for (flag, count) in [
            ("--imitate-rounds", args.imitate_rounds),
            ("--imitate-patterns", args.imitate_patterns),
        ] {
            if count == Some(0) {
                let problem = "0 is not enough to learn from";
                return Err(Error::usage(flag, problem, "give 1 or more"));
            }
        }
        plan.imitation = Some(Imitation {
            rounds: args.imitate_rounds.unwrap_or(usual.rounds),
            courses: args.imitate_patterns.unwrap_or(usual.courses),
            ..usual
        });
        // After imitation, the training need not start with easy patterns.
        plan.domain.curriculum = 0.0;
    }
    Ok(plan)
}

/// The strategy to imitate, checked to work on every one of `lines`.
fn expert(plan: &Plan, lines: &[Station]) -> Result<Option<Parsed>> {
    // The strategy is not the value of a flag `--strategy` here.
    let inside = |error: Error| {
        let spelled = error.spell_settings(|name| match name {
            "strategy" => name.to_owned(),
            other => flag(other),
        });
        spelled.inside("--imitate")
    };
    let expert = plan.imitation.as_ref().map(|i| parse(&i.strategy));
    let expert = expert.transpose();
    let expert = expert.map_err(inside)?;
    for line in lines {
        if let Some(expert) = &expert {
            expert.alone(line.robots().len()).map_err(inside)?;
        }
    }
    Ok(expert)
}

/// A station's name or file, and its number of robots if given.
fn station_name(text: &str) -> (&str, Option<usize>) {
    match text.rsplit_once(':') {
        Some((name, count)) if count.parse::<usize>().is_ok() => (name, count.parse().ok()),
        _ => (text, None),
    }
}

/// The stations, each with its text from the command line.
fn stations(names: &[String], strict: bool) -> Result<Vec<(String, Station)>> {
    let load = |text: &String| {
        let (name, robots) = station_name(text);
        let overrides = Overrides {
            robots,
            belt_speed: None,
        };
        let station = station::load(name, overrides)?;
        warn(strict, station.warnings(name))?;
        let count = station.robots().len();
        if count > MOST_ROBOTS {
            return Err(Error::usage(
                format!("--station {text}"),
                format!(
                    "{count} robots: the comparison with greedy GT (game theory) would try \
                     {}^{count} assignments on every pattern",
                    RULES.len()
                ),
                format!(
                    "train on lines of at most {MOST_ROBOTS} robots; the policy also runs on \
                     longer lines"
                ),
            ));
        }
        Ok((text.clone(), station))
    };
    names.iter().map(load).collect()
}

/// The built-in cases on every station, without duplicates.
fn trials(stations: &[(String, Station)]) -> Result<Vec<(TrialName, Vec<Course>)>> {
    let mut list: Vec<(TrialName, Vec<Course>)> = Vec::new();
    for (name, station) in stations {
        for case in load_cases("all")? {
            let title = TrialName {
                station: name.clone(),
                case: case.name.clone(),
            };
            if list.iter().any(|(known, _)| *known == title) {
                continue;
            }
            let patterns = case.patterns(station.belt(), TRIALS, TRIAL_SEED)?;
            let course = |(_, pattern)| Course {
                station: station.clone(),
                pattern,
            };
            list.push((title, patterns.into_iter().map(course).collect()));
        }
    }
    Ok(list)
}

struct TrainingRun<'a> {
    args: &'a TrainArgs,
    session: &'a Session,
    started: Instant,
    trainer: Trainer,
    /// The stations as given on the command line.
    stations: Vec<String>,
    /// The strategy to imitate.
    expert: Option<Parsed>,
}

/// The content of a checkpoint file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    stations: Vec<String>,
    trainer: Checkpoint,
    score: Kept,
}

impl TrainingRun<'_> {
    fn run(mut self, courses: &[(TrialName, Vec<Course>)], kept: Kept) -> Result<String> {
        let bar = Bar::new(self.args.quiet);
        let environment = Environment {
            stop: self.session.stop(),
            progress: &bar,
        };
        let mut score = TrainingResults::new(judges(courses)?, kept, &self.trainer)?;
        self.imitate(&mut score, &environment)?;
        if score.is_empty() {
            score.judge(&self.trainer, Judged::Start, self.started.elapsed())?;
        }
        self.save(&score)?;
        let finite = self.learn(&mut score, &bar, &environment)?;
        self.write(&score)?;
        if !finite {
            return Err(Error::usage(
                "the training",
                format!(
                    "the weights became NaN or infinite after {} steps",
                    self.trainer.steps()
                ),
                "lower --learning-rate or the reward weights; the best policy before that is kept",
            ));
        }
        Ok(score.to_table())
    }

    /// Imitates the expert, if there is one.
    fn imitate(&mut self, score: &mut TrainingResults, environment: &Environment) -> Result<()> {
        let Some(expert) = &self.expert else {
            return Ok(());
        };
        let (quiet, started) = (self.args.quiet, self.started);
        let judge = |trainer: &Trainer, round: Round| {
            score.judge(trainer, Judged::Round(round), started.elapsed())?;
            let text = format!(
                "{} answers, {:.0} % matched, best so far {}",
                round.answers,
                100.0 * round.agreement,
                score.summary()
            );
            remark(quiet, &text);
            Ok(())
        };
        let expert = |robots| expert.alone(robots);
        self.trainer.imitate(&expert, environment, judge)?;
        let imitation = self.trainer.plan().imitation.as_ref();
        let planned = imitation.map_or(0, |imitation| imitation.rounds);
        let done = self.trainer.rounds();
        if done >= planned {
            return Ok(());
        }
        if done == 0 {
            // Nothing has been learned yet.
            return Err(Error::interrupted());
        }
        let text = format!(
            "stopped after {done} of {planned} rounds; the best policy so far is kept, but an \
             imitation cannot be resumed"
        );
        remark(quiet, &text);
        Ok(())
    }

    /// Learns from the decisions of the policy itself. Returns whether the weights are finite.
    fn learn(
        &mut self,
        score: &mut TrainingResults,
        bar: &Bar,
        environment: &Environment,
    ) -> Result<bool> {
        let planned = self.trainer.plan().steps;
        let left = planned.saturating_sub(self.trainer.steps());
        bar.begin("training", left, "steps");
        let mut finite = true;
        while !self.trainer.done() && !environment.stopped() {
            let phase = self.trainer.phase(environment)?;
            finite = self.trainer.is_finite();
            if !finite {
                break;
            }
            score.judge(&self.trainer, Judged::Phase(phase), self.started.elapsed())?;
            bar.incumbent(&score.summary());
            // An interrupted phase is not resumed, but played again.
            if self.trainer.done() || !environment.stopped() {
                self.save(score)?;
            }
        }
        bar.end();
        Ok(finite)
    }

    /// Writes the policy, its record and its learning curve.
    fn write(&self, score: &TrainingResults) -> Result<()> {
        let record = score.record(&self.trainer, &self.session.command(), &self.stations);
        let stations = self.stations.join(", ");
        let bytes = score.export(
            &self.trainer,
            &stations,
            &serde_json::to_string(&record).unwrap_or_default(),
        );
        files::write_whole(&self.args.out, &bytes)?;
        files::write_whole(&self.beside("json"), json_text(&record)?.as_bytes())?;
        // The recorded command names the other stations.
        let made = Provenance::new(
            &self.session.command(),
            &self.stations[0],
            &self.trainer.stations()[0],
            "the built-in cases",
            self.trainer.seed(),
        );
        let chart = curve_chart(&score.curve(), &made);
        files::write_whole(&self.beside("svg"), chart.as_bytes())
    }

    /// Writes the checkpoint and the learning curve so far.
    fn save(&self, score: &TrainingResults) -> Result<()> {
        let checkpoint = json_text(&Saved {
            stations: self.stations.clone(),
            trainer: self.trainer.checkpoint(),
            score: score.kept().clone(),
        })?;
        files::write_whole(&self.beside("checkpoint.json"), checkpoint.as_bytes())?;
        files::write_whole(&self.beside("csv"), score.to_csv().as_bytes())
    }

    /// The policy's path with another extension.
    fn beside(&self, extension: &str) -> PathBuf {
        self.args.out.with_extension(extension)
    }
}

/// The trials that score the policy, with the results of rules on them.
fn judges(courses: &[(TrialName, Vec<Course>)]) -> Result<Vec<Trial<'_>>> {
    let mut list = Vec::with_capacity(courses.len());
    for (name, courses) in courses {
        let robots = courses
            .first()
            .map_or(1, |course| course.station.robots().len());
        let robust = default_assignment(robots);
        list.push(Trial::new(name.clone(), scenes(courses)?, &robust)?);
    }
    Ok(list)
}

/// A remark for the user, unless quiet.
fn remark(quiet: bool, text: &str) {
    if !quiet {
        tell(text);
    }
}
