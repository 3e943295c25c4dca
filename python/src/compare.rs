//! Comparing methods.

use crate::conditions::ConditionArguments;
use crate::pattern::Pattern;
use crate::report::{Report, shown};
use crate::scalars;
use crate::scored::unwrapped;
use crate::station::Station;
use crate::strategy::strategies;
use pickline::experiment::{Case, load_cases, with_attributes};
use pickline::pattern::Attributes;
use pickline::study::{CompareOptions, CompareStudy, RobustTraining};
use pickline_report::{ComparisonReport, Provenance};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

/// The name or file of cases, or the patterns of each by its name.
#[derive(FromPyObject)]
pub(crate) enum GivenCases {
    #[pyo3(transparent)]
    Named(String),
    #[pyo3(transparent)]
    Patterns(Vec<(String, Vec<Py<Pattern>>)>),
}

impl GivenCases {
    /// Reads what the Python side makes of the argument `cases`.
    fn read(given: &Bound<'_, PyAny>) -> PyResult<Self> {
        given.extract().map_err(|_| {
            PyTypeError::new_err(
                "cases: neither the name of cases, nor a file, nor patterns\n  cure: give a text such as \
                 dense, a Pattern, a list of them, or a dictionary of them by names",
            )
        })
    }

    fn list(&self) -> pickline::Result<Vec<Case>> {
        match self {
            Self::Named(name) => load_cases(name),
            Self::Patterns(cases) => {
                let cases = cases.iter();
                let case = |(name, patterns): &(String, Vec<Py<Pattern>>)| {
                    Case::given(name, unwrapped(patterns))
                };
                cases.map(case).collect()
            }
        }
    }

    /// What results call the cases, which are `listed`.
    fn in_words(&self, listed: &[Case]) -> String {
        match self {
            Self::Named(name) => name.clone(),
            Self::Patterns(_) => {
                let words: Vec<_> = listed.iter().map(Case::in_words).collect();
                words.join("; ")
            }
        }
    }
}

/// The report of a :class:`pickline.Comparison`; ``call`` is how it says who made it.
#[pyfunction]
#[pyo3(signature = (station, cases, *, strategy, replicates, reference, robust, train_patterns,
    train_items, paper, greedy, policy, bound, tune, area, p_detection, p_grasp, classes, seed,
    conditions, progress, call))]
#[expect(clippy::too_many_arguments, reason = "the options of the program")]
pub(crate) fn compare(
    py: Python<'_>,
    station: &Station,
    #[pyo3(from_py_with = GivenCases::read)] cases: GivenCases,
    strategy: Vec<Bound<'_, PyAny>>,
    #[pyo3(from_py_with = scalars::count::replicates)] replicates: usize,
    reference: &str,
    robust: Option<&str>,
    train_patterns: Option<&str>,
    #[pyo3(from_py_with = scalars::optional_count::train_items)] train_items: Option<usize>,
    paper: bool,
    greedy: bool,
    policy: bool,
    bound: bool,
    tune: bool,
    area: Option<&str>,
    p_detection: Option<&str>,
    p_grasp: Option<&str>,
    classes: Option<&str>,
    #[pyo3(from_py_with = scalars::seed)] seed: u64,
    #[pyo3(from_py_with = ConditionArguments::read)] conditions: ConditionArguments,
    progress: Option<Bound<'_, PyAny>>,
    call: &str,
) -> PyResult<Report> {
    let conditions = conditions.resolve(seed)?;
    let (strategies, callables) = strategies(&strategy)?;
    let line = &*station.inner;
    let worked = callables.long(py, progress.as_ref(), |environment| {
        let attributes = Attributes::named(area, p_detection, p_grasp, classes)?;
        let listed = cases.list()?;
        let cases_name = cases.in_words(&listed);
        // Of patterns that are given, none is drawn.
        let is_drawn = matches!(cases, GivenCases::Named(_)) || conditions.is_random();
        let cases = with_attributes(listed, &attributes)?;
        let training =
            RobustTraining::named(robust, train_patterns, train_items, paper, (line, seed))?;
        let options = CompareOptions::default()
            .with_seed(seed)
            .with_replicates(replicates)
            .with_conditions(conditions.clone())
            .with_training(training)
            .with_greedy(greedy)
            .with_policy(policy)
            .with_bound(bound)
            .with_tune(tune)
            .with_reference(reference);
        let options = strategies
            .into_iter()
            .fold(options, CompareOptions::with_strategy);
        let study = CompareStudy::new(line, &cases, &options)?;
        let compared = study.run(environment)?;
        let scored = match is_drawn {
            false => format!("cases {cases_name}"),
            true => format!(
                "cases {cases_name}, {replicates} patterns of random ones each, under the seeds {} and up",
                study.first_seed()
            ),
        };
        let made = Provenance::new(call, &station.name, line, &scored, seed).under(&conditions);
        let papers = matches!(&*cases_name, "paper" | "all");
        Ok(ComparisonReport::of_study(&compared, papers, paper && papers, shown(), made))
    })?;
    Ok(Report::of(worked))
}
