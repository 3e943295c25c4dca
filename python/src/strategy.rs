//! Strategies of studies: from text, or callables of the user's own.

use crate::arrays::array;
use crate::errors::exception;
use crate::work::{self, Worked};
use pickline::decision::{Action, BeltItem, Candidate, Snapshot, Strategy};
use pickline::strategies::{self, StrategySpec};
use pickline::{Environment, Error};
use pyo3::exceptions::{PyKeyboardInterrupt, PyTypeError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBool, PyDict, PyString, PyType};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What the callables of one call have in common.
#[derive(Clone, Default)]
pub(crate) struct Callables(Arc<Shared>);

#[derive(Default)]
struct Shared {
    /// Stops the call.
    stop: Arc<AtomicBool>,
    /// The first exception that a callable has raised.
    raised: Mutex<Option<PyErr>>,
    /// The identifiers, in Python, of the threads that are in a callable.
    inside: Mutex<Vec<u64>>,
}

impl Callables {
    /// Long work that calls them: what a callable raises comes out as itself, and Ctrl-C also ends one that
    /// does not return.
    pub(crate) fn long<T: Send>(
        &self,
        py: Python<'_>,
        watcher: Option<&Bound<'_, PyAny>>,
        work: impl FnOnce(&Environment) -> Result<T, Error> + Send,
    ) -> PyResult<Worked<T>> {
        let insist = |py: Python<'_>| {
            for thread in self.inside().iter() {
                // A thread that has left its callable meanwhile is not found.
                let _ = interrupt(py, *thread);
            }
        };
        let done = work::long_until(py, watcher, &self.0.stop, &insist, work);
        match self.raised().take() {
            Some(error) if !self.0.stop.load(Ordering::Relaxed) => Err(error),
            _ => done,
        }
    }

    /// Calls `callable` with what it sees.
    fn call<'py>(
        &self,
        py: Python<'py>,
        callable: &Py<PyAny>,
        snapshot: &Snapshot,
    ) -> PyResult<Bound<'py, PyAny>> {
        let seen = shown(py, snapshot)?;
        let thread = py
            .import("threading")?
            .call_method0("get_ident")?
            .extract()?;
        self.inside().push(thread);
        let answer = work::within(&self.0.stop, || callable.bind(py).call1((seen,)));
        let mut inside = self.inside();
        if let Some(place) = inside.iter().rposition(|other| *other == thread) {
            inside.swap_remove(place);
        }
        answer
    }

    fn inside(&self) -> MutexGuard<'_, Vec<u64>> {
        self.0.inside.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn raised(&self) -> MutexGuard<'_, Option<PyErr>> {
        self.0.raised.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Raises `KeyboardInterrupt` in the thread with this identifier.
fn interrupt(py: Python<'_>, thread: u64) -> PyResult<()> {
    let ctypes = py.import("ctypes")?;
    let raise = ctypes
        .getattr("pythonapi")?
        .getattr("PyThreadState_SetAsyncExc")?;
    let thread = ctypes.call_method1("c_ulong", (thread,))?;
    let kind = ctypes.call_method1("py_object", (py.get_type::<PyKeyboardInterrupt>(),))?;
    raise.call1((thread, kind))?;
    Ok(())
}

/// The strategies `given`: texts as after ``--strategy`` of the program, or callables; and what they have in
/// common.
pub(crate) fn strategies(given: &[Bound<'_, PyAny>]) -> PyResult<(Vec<StrategySpec>, Callables)> {
    let callables = Callables::default();
    let mut specs = Vec::with_capacity(given.len());
    for given in given {
        let spec = strategy_of(given, &callables)?;
        // Functions without names of their own, such as lambdas, are told apart by numbers.
        let is_new = |name: &str| specs.iter().all(|spec: &StrategySpec| spec.text() != name);
        specs.push(
            match given.is_instance_of::<PyString>() || is_new(spec.text()) {
                true => spec,
                false => {
                    let numbered = (2..).map(|number| format!("{} {number}", spec.text()));
                    match numbered.into_iter().find(|name| is_new(name)) {
                        Some(name) => called(given, name, &callables),
                        None => spec,
                    }
                }
            },
        );
    }
    Ok((specs, callables))
}

/// The strategy `given`, one of the `callables` of a call if it is one.
pub(crate) fn strategy_of(
    given: &Bound<'_, PyAny>,
    callables: &Callables,
) -> PyResult<StrategySpec> {
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
    let name = given
        .getattr("__name__")
        .and_then(|name| name.extract::<String>());
    let is_shown = |name: &String| !name.is_empty() && !name.contains(char::is_control);
    let name = match name.ok().filter(is_shown) {
        Some(name) => name,
        None => given.get_type().name()?.to_string(),
    };
    Ok(called(given, name, callables))
}

/// The callable `given` as a strategy of this name.
fn called(given: &Bound<'_, PyAny>, name: String, callables: &Callables) -> StrategySpec {
    let called = Called {
        callable: Arc::new(given.clone().unbind()),
        name: name.clone(),
        callables: callables.clone(),
        trouble: None,
    };
    StrategySpec::custom(name, move || called.clone())
}

/// A callable as a strategy.
#[derive(Clone)]
struct Called {
    callable: Arc<Py<PyAny>>,
    name: String,
    callables: Callables,
    /// What is wrong with the last answer.
    trouble: Option<String>,
}

impl Strategy for Called {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        let answer = Python::attach(|py| {
            let answer = self.callables.call(py, &self.callable, snapshot)?;
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
                self.callables.raised().get_or_insert(error);
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
