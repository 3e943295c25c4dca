//! How a training goes: the learning curve, the best network so far, the record.

use super::evaluation::Trial;
use super::export::export;
use super::plan::Plan;
use super::trainer::{Phase, Trainer};
use crate::error::Result;
use crate::files::csv_text;
use crate::policy::Metadata;
use crate::stats::mean;
use serde::Serialize;
use std::time::Duration;

/// One line of the curve.
#[derive(Debug, Clone, Serialize)]
struct Row {
    seconds: f64,
    phase: Option<Phase>,
    /// Mean picking rate on each trial [1/min].
    rates: Vec<f64>,
}

/// The best so far.
#[derive(Debug, Clone)]
struct Best {
    /// Mean over trials of the rate as a multiple of greedy GT's.
    score: f64,
    steps: u64,
    parameters: Vec<f32>,
    rates: Vec<f64>,
}

/// See the module.
#[derive(Debug)]
pub struct Score<'a> {
    trials: Vec<Trial<'a>>,
    rows: Vec<Row>,
    best: Option<Best>,
}

/// What is kept of a training, so that anyone can do it again.
#[derive(Debug, Clone, Serialize)]
pub struct Record {
    /// The call.
    pub command: String,
    /// The program's version.
    pub version: String,
    /// The stations trained on, in turn.
    pub stations: Vec<String>,
    /// Master seed.
    pub seed: u64,
    /// Decisions learned from.
    pub steps: u64,
    /// Those of the network that was exported.
    pub best_steps: u64,
    /// Wall time of this call [s].
    pub wall_time_s: f64,
    /// Everything else.
    pub plan: Plan,
    /// What it was judged on.
    pub trials: Vec<TrialRecord>,
}

/// A trial's figures [1/min].
#[derive(Debug, Clone, Serialize)]
pub struct TrialRecord {
    /// Its name.
    pub name: String,
    /// Mean picking rate of [SPT; FIFO].
    pub robust: f64,
    /// Of greedy GT.
    pub greedy: f64,
    /// Of the network that was exported.
    pub policy: f64,
}

impl<'a> Score<'a> {
    /// Nothing judged yet.
    pub fn new(trials: Vec<Trial<'a>>) -> Self {
        Self {
            trials,
            rows: Vec::new(),
            best: None,
        }
    }

    /// Judges the network as it is now, after `phase` if there was one.
    ///
    /// # Errors
    /// As for [`Trial::rate`].
    pub fn judge(
        &mut self,
        trainer: &Trainer,
        phase: Option<Phase>,
        after: Duration,
    ) -> Result<()> {
        let rate =
            |trial: &Trial| trial.rate(trainer.network(), trainer.parameters(), trainer.layout());
        let rates: Vec<f64> = self.trials.iter().map(rate).collect::<Result<_>>()?;
        let share = |(rate, trial): (&f64, &Trial)| rate / trial.greedy.max(f64::MIN_POSITIVE);
        let shares: Vec<f64> = rates.iter().zip(&self.trials).map(share).collect();
        let score = mean(&shares);
        if self.best.as_ref().is_none_or(|best| score > best.score) {
            self.best = Some(Best {
                score,
                steps: trainer.steps(),
                parameters: trainer.parameters().to_vec(),
                rates: rates.clone(),
            });
        }
        self.rows.push(Row {
            seconds: after.as_secs_f64(),
            phase,
            rates,
        });
        Ok(())
    }

    /// The best so far in a few words.
    pub fn summary(&self) -> String {
        match &self.best {
            Some(best) => format!("{:.1} % of greedy GT", 100.0 * best.score),
            None => "none".into(),
        }
    }

    /// The learning curve: one line a phase, rates [1/min].
    pub fn to_csv(&self) -> String {
        let fixed = [
            "steps",
            "seconds",
            "training_rate",
            "training_share",
            "entropy",
            "value_loss",
            "divergence",
            "clipped",
        ];
        let mut lines = vec![fixed.map(str::to_owned).to_vec()];
        lines[0].extend(self.trials.iter().map(|trial| trial.name.clone()));
        for row in &self.rows {
            let phase = row.phase;
            let cell = |of: fn(&Phase) -> f64| phase.as_ref().map(of).map(|v| format!("{v:.5}"));
            let mut line = vec![
                phase.map_or(0, |phase| phase.steps).to_string(),
                format!("{:.1}", row.seconds),
            ];
            let cells = [
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

    fn figures(&self) -> Vec<TrialRecord> {
        let rates = self.best.iter().flat_map(|best| &best.rates);
        let figures = self.trials.iter().zip(rates);
        let record = |(trial, policy): (&Trial, &f64)| TrialRecord {
            name: trial.name.clone(),
            robust: trial.robust,
            greedy: trial.greedy,
            policy: *policy,
        };
        figures.map(record).collect()
    }

    /// The training record.
    pub fn record(&self, trainer: &Trainer, command: &str, stations: &[String]) -> Record {
        Record {
            command: command.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            stations: stations.to_vec(),
            seed: trainer.seed(),
            steps: trainer.steps(),
            best_steps: self.best.as_ref().map_or(0, |best| best.steps),
            wall_time_s: self.rows.last().map_or(0.0, |row| row.seconds),
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
        let best = self.best.as_ref();
        let parameters = best.map_or(trainer.parameters(), |best| &best.parameters);
        export(trainer.network(), parameters, &layout, &metadata)
    }

    /// The last word, for people.
    pub fn to_table(&self) -> String {
        let mut text = String::from("picking rates [1/min]: [SPT; FIFO], greedy GT, the policy\n");
        for trial in self.figures() {
            text += &format!(
                "{:<40}{:>7.1}{:>7.1}{:>7.1}\n",
                trial.name, trial.robust, trial.greedy, trial.policy
            );
        }
        text
    }
}
