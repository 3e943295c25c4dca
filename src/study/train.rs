//! A policy trained on lines, scored on the built-in cases while it learns.

use super::trials::trials;
use crate::dispatch::RULES;
use crate::error::{Error, Result};
use crate::optimize::Environment;
use crate::rl::domain::{Course, scenes};
use crate::rl::{
    Checkpoint, Curve, Judged, Kept, Plan, Record, Round, ShareOfGreedy, Trainer, TrainingResults,
    Trial, TrialName, check_drawn_classes,
};
use crate::sim::Disturbances;
use crate::station::Station;
use crate::strategies::{self, StrategySpec, default_assignment};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Maximum number of robots for which greedy GT (game theory) is found in seconds.
const MOST_ROBOTS: usize = 6;

/// A line to train on.
#[derive(Debug, Clone)]
pub struct TrainingLine {
    /// How the caller names it in messages and records.
    pub name: String,
    /// The line.
    pub station: Station,
}

/// The settings of a training.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct TrainOptions {
    plan: Plan,
    lines: Vec<TrainingLine>,
    seed: u64,
    steps: Option<u64>,
    resumed: Option<SavedTraining>,
    origin: String,
}

impl TrainOptions {
    /// A training with this plan on these lines in turn, with seed 1.
    pub fn new(plan: Plan, lines: Vec<TrainingLine>) -> Self {
        Self {
            plan,
            lines,
            seed: 1,
            steps: None,
            resumed: None,
            origin: String::new(),
        }
    }

    /// With this master seed.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// With this number of decisions to learn from instead of that of the plan or the checkpoint.
    #[must_use]
    pub fn with_steps(mut self, steps: u64) -> Self {
        self.steps = Some(steps);
        self
    }

    /// With an earlier training on the same lines resumed: its plan and seed, not those given
    /// here.
    #[must_use]
    pub fn with_resumed(mut self, saved: SavedTraining) -> Self {
        self.resumed = Some(saved);
        self
    }

    /// With this text in the training record: how the training was started.
    #[must_use]
    pub fn with_origin(mut self, origin: String) -> Self {
        self.origin = origin;
        self
    }
}

/// The state from which a training resumes, the content of a checkpoint file.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedTraining {
    /// The names of the lines.
    pub stations: Vec<String>,
    /// The state of the trainer.
    pub trainer: Checkpoint,
    /// The learning curve and the best network so far.
    pub score: Kept,
}

/// What happens during a training.
#[derive(Debug)]
#[non_exhaustive]
pub enum TrainingEvent<'a> {
    /// A round of imitation was evaluated.
    Imitated {
        /// What was learned.
        round: Round,
        /// The best network so far.
        best: ShareOfGreedy,
    },
    /// The imitation was stopped before its last round.
    ImitationStopped {
        /// Number of completed rounds.
        done: usize,
        /// Number of planned rounds.
        planned: usize,
    },
    /// The training can be resumed from here.
    Saved {
        /// The state.
        state: &'a SavedTraining,
        /// The learning curve so far.
        curve: &'a Curve,
    },
}

/// A trained policy.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct TrainedPolicy {
    /// The network that the plan keeps, as the bytes of an ONNX file.
    pub onnx: Vec<u8>,
    /// The training record.
    pub record: Record,
    /// The learning curve.
    pub curve: Curve,
    /// Number of steps after which the weights became NaN or infinite, if they did. The policy
    /// is the best before that.
    pub diverged_after: Option<u64>,
}

impl TrainedPolicy {
    /// Checks that the training did not diverge.
    ///
    /// # Errors
    /// The weights became NaN or infinite.
    pub fn check_converged(&self) -> Result<()> {
        let Some(steps) = self.diverged_after else {
            return Ok(());
        };
        Err(Error::usage(
            "the training",
            format!("the weights became NaN or infinite after {steps} steps"),
            "lower 'learning_rate' or the reward weights; the best policy before that is kept",
        ))
    }
}

/// A training whose settings are checked.
#[derive(Debug)]
pub struct TrainStudy {
    lines: Vec<TrainingLine>,
    /// What the policy is scored on.
    trials: Vec<(TrialName, Vec<Course>)>,
    trainer: Trainer,
    kept: Kept,
    /// The strategy to imitate.
    expert: Option<StrategySpec>,
    origin: String,
}

/// Trains a policy. `report` is called with what happens; a caller that stores each
/// [`TrainingEvent::Saved`] can resume a training that is cut off. On a stop request, the best
/// policy so far is returned.
///
/// # Errors
/// Settings that do not fit, an expert that acts illegally, an error of `report`, or
/// [`Interrupted`](crate::error::ErrorKind::Interrupted) before anything is learned.
pub fn train(
    options: TrainOptions,
    environment: &Environment,
    report: &mut dyn FnMut(TrainingEvent) -> Result<()>,
) -> Result<TrainedPolicy> {
    TrainStudy::new(options)?.run(environment, report)
}

impl TrainStudy {
    /// Checks the settings.
    ///
    /// # Errors
    /// An invalid plan, a checkpoint of other lines, an expert that does not fit a line, or a line
    /// of too many robots.
    pub fn new(options: TrainOptions) -> Result<Self> {
        let TrainOptions { plan, lines, .. } = options;
        lines.iter().try_for_each(check_line)?;
        let stations: Vec<Station> = lines.iter().map(|line| line.station.clone()).collect();
        let expert = expert(&plan, &stations)?;
        let (mut trainer, kept) = match options.resumed {
            Some(saved) => {
                let mut trainer = Trainer::resume(saved.trainer, stations)?;
                if let Some(steps) = options.steps {
                    trainer.up_to(steps);
                }
                (trainer, saved.score)
            }
            None => {
                let steps = options.steps.unwrap_or(plan.steps);
                let plan = Plan { steps, ..plan };
                let trainer = Trainer::new(plan, stations, options.seed)?;
                (trainer, Kept::default())
            }
        };
        let trials = trial_courses(&lines)?;
        let tests = trials.iter().flat_map(|(_, courses)| courses);
        let tests: Vec<_> = tests.map(|course| &course.pattern).collect();
        trainer.leave_out(&tests)?;
        Ok(Self {
            lines,
            trials,
            trainer,
            kept,
            expert,
            origin: options.origin,
        })
    }

    /// The lines that are trained on in turn, one at least.
    pub fn lines(&self) -> &[TrainingLine] {
        &self.lines
    }

    /// Runs the training.
    ///
    /// # Errors
    /// An expert that acts illegally, an error of `report`, or
    /// [`Interrupted`](crate::error::ErrorKind::Interrupted) before anything is learned.
    pub fn run(
        self,
        environment: &Environment,
        report: &mut dyn FnMut(TrainingEvent) -> Result<()>,
    ) -> Result<TrainedPolicy> {
        let started = Instant::now();
        let results = TrainingResults::new(scored_trials(&self.trials)?, self.kept, &self.trainer)?;
        let running = RunningTraining {
            names: self.lines.into_iter().map(|line| line.name).collect(),
            trainer: self.trainer,
            results,
            started,
            environment,
            report,
        };
        running.run(self.expert.as_ref(), &self.origin)
    }
}

/// A training at work.
struct RunningTraining<'a> {
    names: Vec<String>,
    trainer: Trainer,
    results: TrainingResults<'a>,
    started: Instant,
    environment: &'a Environment<'a>,
    report: &'a mut dyn FnMut(TrainingEvent) -> Result<()>,
}

impl RunningTraining<'_> {
    fn run(mut self, expert: Option<&StrategySpec>, origin: &str) -> Result<TrainedPolicy> {
        if let Some(expert) = expert {
            self.imitate(expert)?;
        }
        if self.results.is_empty() {
            self.judge(Judged::Start)?;
        }
        self.save()?;
        let finite = self.learn()?;
        let record = self.results.record(&self.trainer, origin, &self.names);
        let text = serde_json::to_string(&record).unwrap_or_default();
        let names = self.names.join(", ");
        Ok(TrainedPolicy {
            onnx: self.results.export(&self.trainer, &names, &text),
            record,
            curve: self.results.curve(),
            diverged_after: (!finite).then(|| self.trainer.steps()),
        })
    }

    fn judge(&mut self, after: Judged) -> Result<ShareOfGreedy> {
        let elapsed = self.started.elapsed();
        self.results.judge(&self.trainer, after, elapsed)
    }

    /// Learns from the decisions of the expert.
    fn imitate(&mut self, expert: &StrategySpec) -> Result<()> {
        let (results, report, started) = (&mut self.results, &mut self.report, self.started);
        let judge = |trainer: &Trainer, round: Round| {
            let best = results.judge(trainer, Judged::Round(round), started.elapsed())?;
            report(TrainingEvent::Imitated { round, best })
        };
        let expert = |robots| expert.alone(robots);
        self.trainer.imitate(&expert, self.environment, judge)?;
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
        (self.report)(TrainingEvent::ImitationStopped { done, planned })
    }

    /// Learns from the decisions of the policy itself. Returns whether the weights are finite.
    fn learn(&mut self) -> Result<bool> {
        let (environment, progress) = (self.environment, self.environment.progress);
        let planned = self.trainer.plan().steps;
        let left = planned.saturating_sub(self.trainer.steps());
        progress.begin("training", left, "steps");
        let mut finite = true;
        while !self.trainer.done() && !environment.stopped() {
            let phase = self.trainer.phase(environment)?;
            finite = self.trainer.is_finite();
            if !finite {
                break;
            }
            let best = self.judge(Judged::Phase(phase))?;
            progress.incumbent(&best.to_string());
            // An interrupted phase is not resumed, but played again.
            if self.trainer.done() || !environment.stopped() {
                self.save()?;
            }
        }
        progress.end();
        Ok(finite)
    }

    /// Reports the state from which the training resumes.
    fn save(&mut self) -> Result<()> {
        let state = SavedTraining {
            stations: self.names.clone(),
            trainer: self.trainer.checkpoint(),
            score: self.results.kept().clone(),
        };
        (self.report)(TrainingEvent::Saved {
            state: &state,
            curve: &self.results.curve(),
        })
    }
}

/// Checks that there is something to learn on a line, and that greedy GT (game theory) can be found.
fn check_line(line: &TrainingLine) -> Result<()> {
    let named = |error: Error| error.inside(&format!("'station' {}", line.name));
    check_drawn_classes(&line.station).map_err(named)?;
    let count = line.station.robots().len();
    if count <= MOST_ROBOTS {
        return Ok(());
    }
    Err(Error::usage(
        format!("'station' {}", line.name),
        format!(
            "{count} robots: the comparison with greedy GT (game theory) would try \
             {}^{count} assignments on every pattern",
            RULES.len()
        ),
        format!(
            "train on lines of at most {MOST_ROBOTS} robots; the policy also runs on longer lines"
        ),
    ))
}

/// The strategy to imitate, checked to work on every one of `stations`.
fn expert(plan: &Plan, stations: &[Station]) -> Result<Option<StrategySpec>> {
    let Some(imitation) = &plan.imitation else {
        return Ok(None);
    };
    // The strategy is not the value of the setting 'strategy' here.
    let inside = |error: Error| {
        let spelled = error.spell_settings(|name| match name {
            "strategy" => name.to_owned(),
            other => format!("'{other}'"),
        });
        spelled.inside("'imitate'")
    };
    let expert = strategies::parse(&imitation.strategy).map_err(inside)?;
    for station in stations {
        expert.check_on(station).map_err(inside)?;
    }
    Ok(Some(expert))
}

/// The built-in cases on every line, without duplicates.
fn trial_courses(lines: &[TrainingLine]) -> Result<Vec<(TrialName, Vec<Course>)>> {
    let mut list: Vec<(TrialName, Vec<Course>)> = Vec::new();
    for TrainingLine { name, station } in lines {
        for (case, patterns) in trials("all", station)? {
            let title = TrialName {
                station: name.clone(),
                case,
            };
            if list.iter().any(|(known, _)| *known == title) {
                continue;
            }
            let course = |pattern| Course {
                station: station.clone(),
                pattern,
                disturbances: Disturbances::default(),
            };
            list.push((title, patterns.into_iter().map(course).collect()));
        }
    }
    Ok(list)
}

/// The trials that score the policy, with the results of rules on them.
fn scored_trials(courses: &[(TrialName, Vec<Course>)]) -> Result<Vec<Trial<'_>>> {
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
