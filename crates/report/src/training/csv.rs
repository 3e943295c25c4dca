//! A learning curve as CSV.

use crate::csv_rows::CsvRows;
use pickline::rl::{Curve, Judged, Phase, TrainingEvaluation};
use serde::{Serialize, Serializer};

/// A number with this many decimals.
#[derive(Debug, Clone, Copy, Default)]
struct Decimals<const DIGITS: usize>(f64);

impl<const DIGITS: usize> Serialize for Decimals<DIGITS> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("{:.DIGITS$}", self.0))
    }
}

#[derive(Default, Serialize)]
struct LearnedRow {
    steps: u64,
    seconds: Decimals<1>,
    answers: Option<usize>,
    agreement: Option<Decimals<5>>,
    training_rate: Option<Decimals<5>>,
    training_share: Option<Decimals<5>>,
    entropy: Option<Decimals<5>>,
    value_loss: Option<Decimals<5>>,
    divergence: Option<Decimals<5>>,
    clipped: Option<Decimals<5>>,
}

impl LearnedRow {
    fn of(evaluation: &TrainingEvaluation) -> Self {
        let (round, phase) = match evaluation.after {
            Judged::Start => (None, None),
            Judged::Round(round) => (Some(round), None),
            Judged::Phase(phase) => (None, Some(phase)),
        };
        let of = |figure: fn(&Phase) -> f64| phase.as_ref().map(figure).map(Decimals);
        Self {
            steps: phase.map_or(0, |phase| phase.steps),
            seconds: Decimals(evaluation.seconds),
            answers: round.map(|round| round.answers),
            agreement: round.map(|round| Decimals(round.agreement)),
            training_rate: of(|phase| phase.rate),
            training_share: of(|phase| phase.picked_share),
            entropy: of(|phase| phase.entropy),
            value_loss: of(|phase| phase.value_loss),
            divergence: of(|phase| phase.divergence),
            clipped: of(|phase| phase.clipped),
        }
    }
}

/// A column of this kind for every trial; the name of the trial is its header.
#[derive(Default, Serialize)]
struct TrialRateRow {
    trial: Decimals<3>,
}

/// The learning curve `curve` as CSV, without comments: one line per evaluation, the rates of the
/// trials in [1/min]. The file must be the same whether or not the training was resumed, so it
/// does not say where it comes from.
pub fn learning_curve_csv(curve: &Curve) -> String {
    let row = |evaluation: &TrainingEvaluation| {
        let rates = evaluation.rates.iter().map(|rate| TrialRateRow {
            trial: Decimals(*rate),
        });
        (LearnedRow::of(evaluation), rates.collect::<Vec<_>>())
    };
    let rates = curve.trials.iter().map(|_| TrialRateRow::default());
    let template = (LearnedRow::default(), rates.collect());
    let mut trials = curve.trials.iter();
    let name = |column: &str| match column {
        "trial" => trials.next().map_or_else(String::new, ToString::to_string),
        other => other.to_owned(),
    };
    let rows = curve.evaluations.iter().map(row);
    CsvRows::like(&template, rows).renamed(name).plain_text()
}
