//! The results of a training: the learning curve, the network to keep so far, the record.

use super::evaluation::{Trial, TrialName};
use super::plan::{Keep, Plan};
use super::trainer::{Phase, Round, Trainer};
use crate::error::{Error, Result};
use crate::policy::{Metadata, Trained, export};
use crate::stats::mean;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::time::Duration;

/// What happened before the network was evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Judged {
    /// Nothing; it was evaluated at the start of this call.
    Start,
    /// A round of imitation.
    Round(Round),
    /// A phase of reinforcement learning.
    Phase(Phase),
}

/// One evaluation of the network during the training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TrainingEvaluation {
    /// Time since the start of the training [s].
    pub seconds: f64,
    /// What the network had learned from since the previous evaluation.
    pub after: Judged,
    /// Mean weighted rate on each trial [1/min].
    pub rates: Vec<f64>,
}

/// A mean weighted rate as a share of greedy GT's (game theory).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShareOfGreedy(pub f64);

impl fmt::Display for ShareOfGreedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.1} % of greedy GT (game theory)", 100.0 * self.0)
    }
}

/// The best network so far, or the last one if the plan says so.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct BestNetwork {
    /// Mean over trials of the rate as a multiple of greedy GT's rate (game theory).
    score: f64,
    steps: u64,
    parameters: Vec<f32>,
    rates: Vec<f64>,
}

/// How the weighted rate of the network developed over the training.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Curve {
    /// What the network is evaluated on.
    pub trials: Vec<TrialName>,
    /// The evaluations, in the order of learning, each with a rate for every one of `trials`.
    pub evaluations: Vec<TrainingEvaluation>,
    /// The stations of the evaluation, as the user wrote them.
    pub stations: Vec<String>,
    /// The weighted rate of [SPT; FIFO] on each station, as a share of greedy GT's (game
    /// theory).
    pub robust: Vec<f64>,
    /// The evaluations by station.
    pub points: Vec<CurvePoint>,
}

/// The quality of the network at one time.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct CurvePoint {
    /// Decisions learned from: the expert's answers and the network's own steps.
    pub decisions: u64,
    /// Mean weighted rate on each station's cases, as a share of greedy GT's.
    pub shares: Vec<f64>,
}

/// The state of a score that is stored between two calls.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    rows: Vec<TrainingEvaluation>,
    best: Option<BestNetwork>,
}

/// The results of a training; see the module.
#[derive(Debug)]
pub struct TrainingResults<'a> {
    trials: Vec<Trial<'a>>,
    kept: Kept,
    /// Duration of earlier calls [s].
    before: f64,
}

/// The record of a training, for reproducing it.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Record {
    /// The command that started the training.
    pub command: String,
    /// The version of pickline.
    pub version: String,
    /// The stations used in turn for training.
    pub stations: Vec<String>,
    /// Master seed of the training.
    pub seed: u64,
    /// Number of decisions learned from.
    pub steps: u64,
    /// Number of decisions that the exported network had learned from.
    pub best_steps: u64,
    /// Wall time of this call [s].
    pub wall_time_s: f64,
    /// All settings but the seed and the stations.
    pub plan: Plan,
    /// Weighted rates of the exported network on each trial.
    pub trials: Vec<TrialRecord>,
}

/// A trial's figures [1/min].
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct TrialRecord {
    /// Station and case, as in tables.
    pub name: String,
    /// Mean weighted rate of [SPT; FIFO].
    pub robust: f64,
    /// Mean weighted rate of greedy GT.
    pub greedy: f64,
    /// Mean weighted rate of the exported network.
    pub policy: f64,
}

impl<'a> TrainingResults<'a> {
    /// Continues from what was `kept` (empty at the start) for the training of `trainer`.
    ///
    /// # Errors
    /// `kept` belongs to another training.
    pub fn new(trials: Vec<Trial<'a>>, kept: Kept, trainer: &Trainer) -> Result<Self> {
        let rates = kept.rows.iter().map(|row| &row.rates);
        let mut rates = rates.chain(kept.best.iter().map(|best| &best.rates));
        let parameters = kept.best.as_ref().map(|best| best.parameters.len());
        if rates.any(|rates| rates.len() != trials.len())
            || parameters.is_some_and(|count| count != trainer.parameters().len())
        {
            return Err(Error::input(
                "the checkpoint",
                "its learning curve belongs to another training",
                "use an unmodified checkpoint",
            ));
        }
        Ok(Self {
            before: kept.rows.last().map_or(0.0, |row| row.seconds),
            trials,
            kept,
        })
    }

    /// What a checkpoint has to store, so that the results go on after it.
    pub fn kept(&self) -> &Kept {
        &self.kept
    }

    /// Evaluates the current network, after the time `elapsed`. Returns the score of the network to
    /// keep so far.
    ///
    /// # Errors
    /// As for [`Trial::rate`].
    pub fn judge(
        &mut self,
        trainer: &Trainer,
        after: Judged,
        elapsed: Duration,
    ) -> Result<ShareOfGreedy> {
        let rate =
            |trial: &Trial| trial.rate(trainer.network(), trainer.parameters(), trainer.layout());
        let rates: Vec<f64> = self.trials.iter().map(rate).collect::<Result<_>>()?;
        let share = |(rate, trial): (&f64, &Trial)| rate / trial.greedy.max(f64::MIN_POSITIVE);
        let shares: Vec<f64> = rates.iter().zip(&self.trials).map(share).collect();
        let score = mean(&shares);
        let best = self.kept.best.as_ref();
        let last = trainer.plan().keep == Keep::Last;
        if last || best.is_none_or(|best| score > best.score) {
            self.kept.best = Some(BestNetwork {
                score,
                steps: trainer.steps(),
                parameters: trainer.parameters().to_vec(),
                rates: rates.clone(),
            });
        }
        self.kept.rows.push(TrainingEvaluation {
            seconds: self.before + elapsed.as_secs_f64(),
            after,
            rates,
        });
        let best = self.kept.best.as_ref();
        Ok(ShareOfGreedy(best.map_or(score, |best| best.score)))
    }

    /// Whether nothing was evaluated yet.
    pub fn is_empty(&self) -> bool {
        self.kept.rows.is_empty()
    }

    /// The learning curve so far.
    pub fn curve(&self) -> Curve {
        let station = |trial: &Trial| trial.name.station.clone();
        let mut stations: Vec<String> = self.trials.iter().map(station).collect();
        stations.dedup();
        let shares = |rates: &[f64]| -> Vec<f64> {
            let mean_of = |name: &String| {
                let trials = self.trials.iter().zip(rates);
                let own = trials.filter(|(trial, _)| trial.name.station == *name);
                let shares = own.map(|(trial, rate)| rate / trial.greedy.max(f64::MIN_POSITIVE));
                mean(&shares.collect::<Vec<_>>())
            };
            stations.iter().map(mean_of).collect()
        };
        let (mut answers, mut steps) = (0, 0);
        let point = |row: &TrainingEvaluation| {
            match row.after {
                Judged::Start => {}
                Judged::Round(round) => answers = round.answers as u64,
                Judged::Phase(phase) => steps = phase.steps,
            }
            CurvePoint {
                decisions: answers + steps,
                shares: shares(&row.rates),
            }
        };
        let robust: Vec<f64> = self.trials.iter().map(|trial| trial.robust).collect();
        Curve {
            trials: self.trials.iter().map(|trial| trial.name.clone()).collect(),
            evaluations: self.kept.rows.clone(),
            points: self.kept.rows.iter().map(point).collect(),
            robust: shares(&robust),
            stations,
        }
    }

    fn figures(&self) -> Vec<TrialRecord> {
        let rates = self.kept.best.iter().flat_map(|best| &best.rates);
        let figures = self.trials.iter().zip(rates);
        let record = |(trial, policy): (&Trial, &f64)| TrialRecord {
            name: trial.name.to_string(),
            robust: trial.robust,
            greedy: trial.greedy,
            policy: *policy,
        };
        figures.map(record).collect()
    }

    /// The settings and results of the training, for a file beside the policy.
    pub fn record(&self, trainer: &Trainer, command: &str, stations: &[String]) -> Record {
        Record {
            command: command.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            stations: stations.to_vec(),
            seed: trainer.seed(),
            steps: trainer.steps(),
            best_steps: self.kept.best.as_ref().map_or(0, |best| best.steps),
            wall_time_s: self.kept.rows.last().map_or(0.0, |row| row.seconds),
            plan: trainer.plan().clone(),
            trials: self.figures(),
        }
    }

    /// The network to keep as the bytes of an ONNX file.
    pub fn export(&self, trainer: &Trainer, stations: &str, record: &str) -> Vec<u8> {
        let layout = trainer.layout();
        let mut metadata = Metadata::new(&layout);
        metadata.set("stations", stations);
        metadata.set("station_hashes", trainer.station_hashes().join(", "));
        metadata.set("robots", trainer.robots());
        metadata.set("training", record);
        let speed = trainer.plan().domain.speed;
        Trained::on(trainer.stations(), speed).write(&mut metadata);
        let best = self.kept.best.as_ref();
        let parameters = best.map_or(trainer.parameters(), |best| &best.parameters);
        export(trainer.network(), parameters, &layout, &metadata)
    }
}
