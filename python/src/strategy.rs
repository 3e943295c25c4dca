//! Strategies of studies: from text, or callables of the user's own.

use crate::arrays::array;
use crate::errors::exception;
use crate::work::Worked;
use pickline::decision::{Action, BeltItem, Candidate, Snapshot, Strategy};
use pickline::strategies::{self, StrategySpec};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBool, PyDict, PyString, PyType};
use std::sync::{Arc, Mutex, PoisonError};

/// The first exception that a callable has raised.
#[derive(Clone, Default)]
pub(crate) struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// What was `done`, or else the exception that was raised meanwhile.
    pub(crate) fn or<T>(&self, done: PyResult<Worked<T>>) -> PyResult<Worked<T>> {
        let mut raised = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match raised.take() {
            Some(error) => Err(error),
            None => done,
        }
    }

    fn keep(&self, error: PyErr) {
        let mut raised = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        raised.get_or_insert(error);
    }
}

/// The strategies `given`: texts as after ``--strategy`` of the program, or callables; and where what
/// they raise is kept.
pub(crate) fn strategies(given: &[Bound<'_, PyAny>]) -> PyResult<(Vec<StrategySpec>, Raised)> {
    let raised = Raised::default();
    let mut specs = Vec::with_capacity(given.len());
    for given in given {
        let spec = strategy_of(given, &raised)?;
        // Functions without names of their own, such as lambdas, are told apart by numbers.
        let is_new = |name: &str| specs.iter().all(|spec: &StrategySpec| spec.text() != name);
        specs.push(
            match given.is_instance_of::<PyString>() || is_new(spec.text()) {
                true => spec,
                false => {
                    let numbered = (2..).map(|number| format!("{} {number}", spec.text()));
                    match numbered.into_iter().find(|name| is_new(name)) {
                        Some(name) => called(given, name, &raised),
                        None => spec,
                    }
                }
            },
        );
    }
    Ok((specs, raised))
}

/// The strategy `given`; what it raises is kept in `raised`.
pub(crate) fn strategy_of(given: &Bound<'_, PyAny>, raised: &Raised) -> PyResult<StrategySpec> {
    if let Ok(text) = given.cast::<PyString>() {
        return strategies::parse(&text.to_cow()?).map_err(exception);
    }
    if !given.is_callable() {
        return Err(PyTypeError::new_err(format!(
            "strategy: {} is neither a text nor callable\n  cure: give a text such as \"SPT,FIFO\", or a \
             function of a snapshot that returns the number of a candidate",
            given.repr()?
        )));
    }
    let name = match given.getattr("__name__") {
        Ok(name) => name.extract()?,
        Err(_) => given.get_type().name()?.to_string(),
    };
    Ok(called(given, name, raised))
}

/// The callable `given` as a strategy of this name.
fn called(given: &Bound<'_, PyAny>, name: String, raised: &Raised) -> StrategySpec {
    let called = Called {
        callable: Arc::new(given.clone().unbind()),
        name: name.clone(),
        raised: raised.clone(),
        trouble: None,
    };
    StrategySpec::custom(name, move || called.clone())
}

/// A callable as a strategy.
#[derive(Clone)]
struct Called {
    callable: Arc<Py<PyAny>>,
    name: String,
    raised: Raised,
    /// What is wrong with the last answer.
    trouble: Option<String>,
}

impl Strategy for Called {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        let answer = Python::attach(|py| {
            let answer = self.callable.bind(py).call1((shown(py, snapshot)?,))?;
            action(&answer)
        });
        match answer {
            Ok(Ok(action)) => action,
            Ok(Err(trouble)) => {
                self.trouble = Some(trouble);
                Action::NoAnswer
            }
            Err(error) => {
                self.trouble = Some("it raised an exception".into());
                self.raised.keep(error);
                Action::NoAnswer
            }
        }
    }

    fn name(&self) -> String {
        self.name.clone()
    }

    fn trouble(&self) -> Option<String> {
        self.trouble.clone()
    }

    fn remedy(&self) -> String {
        "let this one return the index of a candidate, or a Wait until later than now".into()
    }
}

/// What `answer` means: the number of a candidate or a ``Wait``; or what is wrong with it.
fn action(answer: &Bound<'_, PyAny>) -> PyResult<Result<Action, String>> {
    if answer.is_instance(class(answer.py(), "Wait")?)? {
        let until: Option<f64> = answer.getattr("until")?.extract()?;
        return Ok(Ok(
            until.map_or(Action::WaitForNextWindow, Action::WaitUntil)
        ));
    }
    let index = answer.call_method0("__index__");
    let index = index.ok().filter(|_| !answer.is_instance_of::<PyBool>());
    let place = index.and_then(|index| index.extract::<usize>().ok());
    Ok(place.map(Action::Pick).ok_or_else(|| {
        let answer = answer
            .repr()
            .map_or_else(|_| "something".into(), |text| text.to_string());
        format!("it answers {answer}, which is neither the number of a candidate nor a Wait")
    }))
}

/// The class `name` of ``pickline.strategy``.
fn class<'py>(py: Python<'py>, name: &str) -> PyResult<&'py Bound<'py, PyAny>> {
    static WAIT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    static SNAPSHOT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let kept = if name == "Wait" { &WAIT } else { &SNAPSHOT };
    Ok(kept.import(py, "pickline.strategy", name)?.as_any())
}

/// The ``Snapshot`` that a callable sees.
fn shown<'py>(py: Python<'py>, snapshot: &Snapshot) -> PyResult<Bound<'py, PyAny>> {
    let moment = snapshot.moment();
    let parts = PyDict::new(py);
    parts.set_item("time", snapshot.time)?;
    parts.set_item("robot", snapshot.robot)?;
    parts.set_item("free_at", array(py, snapshot.free_at.iter().copied()))?;
    let candidates = || snapshot.candidates.iter();
    let of = |figure: &dyn Fn(&Candidate) -> f64| array(py, candidates().map(figure));
    parts.set_item("item", array(py, candidates().map(|c| i64::from(c.item))))?;
    parts.set_item("bin", array(py, candidates().map(|c| i64::from(c.bin))))?;
    parts.set_item("x", of(&|c| moment.x(c)))?;
    parts.set_item("y", of(&|c| c.y))?;
    parts.set_item("reward", of(&|c| c.weight))?;
    parts.set_item("open", of(&|c| c.open))?;
    parts.set_item("close", of(&|c| c.close))?;
    parts.set_item("processing_time", of(&|c| moment.processing_time(c)))?;
    parts.set_item("distance_to_base", of(&|c| moment.distance_to_base(c)))?;
    let view = || snapshot.in_view.iter();
    let seen = |figure: fn(&BeltItem) -> f64| array(py, view().map(figure));
    parts.set_item("view_item", array(py, view().map(|i| i64::from(i.item))))?;
    parts.set_item("view_x", seen(|item| item.x))?;
    parts.set_item("view_y", seen(|item| item.y))?;
    parts.set_item("view_reward", seen(|item| item.weight))?;
    class(py, "Snapshot")?.call((), Some(&parts))
}
