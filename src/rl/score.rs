//! The results of a training: the learning curve, the best network so far, the record.

use super::evaluation::Trial;
use super::export::export;
use super::plan::Plan;
use super::trainer::{Phase, Round, Trainer};
use crate::error::{Error, Result};
use crate::files::csv_text;
use crate::policy::{Metadata, Trained};
use crate::stats::mean;
use serde::{Deserialize, Serialize};
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

/// One line of the curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct CurveRow {
    seconds: f64,
    after: Judged,
    /// Mean picking rate on each trial [1/min].
    rates: Vec<f64>,
}

/// The best network so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct BestNetwork {
    /// Mean over trials of the rate as a multiple of greedy GT's rate (game theory).
    score: f64,
    steps: u64,
    parameters: Vec<f32>,
    rates: Vec<f64>,
}

/// How the picking rate of the network developed over the training.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Curve {
    /// The stations of the evaluation, as the user wrote them.
    pub stations: Vec<String>,
    /// The picking rate of [SPT; FIFO] on each station, as a share of greedy GT's (game
    /// theory).
    pub robust: Vec<f64>,
    /// The points, in the order of learning.
    pub points: Vec<CurvePoint>,
}

/// The quality of the network at one time.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct CurvePoint {
    /// Decisions learned from: the expert's answers and the network's own steps.
    pub decisions: u64,
    /// Mean picking rate on each station's cases, as a share of greedy GT's.
    pub shares: Vec<f64>,
}

/// The state of a score that is stored between two calls.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    rows: Vec<CurveRow>,
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
    /// Picking rates of the best network on each trial.
    pub trials: Vec<TrialRecord>,
}

/// A trial's figures [1/min].
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct TrialRecord {
    /// Station and case, as in tables.
    pub name: String,
    /// Mean picking rate of [SPT; FIFO].
    pub robust: f64,
    /// Mean picking rate of greedy GT.
    pub greedy: f64,
    /// Mean picking rate of the exported network.
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

    /// Evaluates the current network, after the time `elapsed`.
    ///
    /// # Errors
    /// As for [`Trial::rate`].
    pub fn judge(&mut self, trainer: &Trainer, after: Judged, elapsed: Duration) -> Result<()> {
        let rate =
            |trial: &Trial| trial.rate(trainer.network(), trainer.parameters(), trainer.layout());
        let rates: Vec<f64> = self.trials.iter().map(rate).collect::<Result<_>>()?;
        let share = |(rate, trial): (&f64, &Trial)| rate / trial.greedy.max(f64::MIN_POSITIVE);
        let shares: Vec<f64> = rates.iter().zip(&self.trials).map(share).collect();
        let score = mean(&shares);
        if self
            .kept
            .best
            .as_ref()
            .is_none_or(|best| score > best.score)
        {
            self.kept.best = Some(BestNetwork {
                score,
                steps: trainer.steps(),
                parameters: trainer.parameters().to_vec(),
                rates: rates.clone(),
            });
        }
        self.kept.rows.push(CurveRow {
            seconds: self.before + elapsed.as_secs_f64(),
            after,
            rates,
        });
        Ok(())
    }

    /// Whether nothing was evaluated yet.
    pub fn is_empty(&self) -> bool {
        self.kept.rows.is_empty()
    }

    /// A short description of the best network so far.
    pub fn summary(&self) -> String {
        match &self.kept.best {
            Some(best) => format!("{:.1} % of greedy GT (game theory)", 100.0 * best.score),
            None => "none".into(),
        }
    }

    /// The learning curve: one line per evaluation, rates in [1/min].
    pub fn to_csv(&self) -> String {
        let fixed = [
            "steps",
            "seconds",
            "answers",
            "agreement",
            "training_rate",
            "training_share",
            "entropy",
            "value_loss",
            "divergence",
            "clipped",
        ];
        let mut lines = vec![fixed.map(str::to_owned).to_vec()];
        lines[0].extend(self.trials.iter().map(|trial| trial.name.to_string()));
        for row in &self.kept.rows {
            let (round, phase) = match row.after {
                Judged::Start => (None, None),
                Judged::Round(round) => (Some(round), None),
                Judged::Phase(phase) => (None, Some(phase)),
            };
            let cell = |of: fn(&Phase) -> f64| phase.as_ref().map(of).map(|v| format!("{v:.5}"));
            let mut line = vec![
                phase.map_or(0, |phase| phase.steps).to_string(),
                format!("{:.1}", row.seconds),
            ];
            let cells = [
                round.map(|round| round.answers.to_string()),
                round.map(|round| format!("{:.5}", round.agreement)),
                cell(|p| p.rate),
                cell(|p| p.picked_share),
                cell(|p| p.entropy),
                cell(|p| p.value_loss),
                cell(|p| p.divergence),
                cell(|p| p.clipped),
            ];
            line.extend(cells.map(Option::unwrap_or_default));
            line.extend(row.rates.iter().map(|rate| format!("{rate:.3}")));
            lines.push(line);
        }
        csv_text(lines)
    }

    /// The learning curve as shares of greedy GT, for each station.
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
        let point = |row: &CurveRow| {
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

    /// The best network as the bytes of an ONNX file.
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

    /// The final results, for people.
    pub fn to_table(&self) -> String {
        let mut text = String::from(
            "picking rates [1/min]: [SPT; FIFO], greedy GT (game theory), the policy\n",
        );
        for trial in self.figures() {
            text += &format!(
                "{:<40}{:>7.1}{:>7.1}{:>7.1}\n",
                trial.name, trial.robust, trial.greedy, trial.policy
            );
        }
        text
    }
}
