//! Environments that are stepped together.

use crate::arrays::array;
use crate::conditions::ConditionArguments;
use crate::crew::Crew;
use crate::errors::exception;
use crate::pattern::Pattern;
use crate::portion::{AT_ONCE, Course, Portion, Task, write_steps};
use crate::scalars;
use crate::simulate::{figures_by_name, pick_columns};
use crate::station::Station;
use crate::work;
use numpy::ndarray::Dimension;
use numpy::{
    Element, PyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadwriteArray,
    PyUntypedArrayMethods,
};
use pickline::Result as Fallible;
use pickline::decision::observation::{Layout, View};
use pickline::rl::{DispatchEnvironment, Reward};
use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::mem;
use std::sync::{Arc, Mutex, MutexGuard};

/// The environments behind ``SortingEnv`` and ``SortingVectorEnv``.
#[pyclass(frozen, module = "pickline._pickline")]
pub(crate) struct Batch {
    layout: Layout,
    count: usize,
    /// `None` after a panic.
    state: Mutex<Option<Crew<Portion>>>,
}

/// More environments take more memory than machines have.
const MOST_ENVIRONMENTS: usize = 100_000;

/// The arrays that a step writes: observations [count, observation], masks [count, actions], rewards
/// and ends [count], items and items picked [count, 2], weight, end, picking rate and weighted rate of
/// the episodes that are over [count, 4], zero where one goes on.
type Written<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<bool>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray2<i64>>,
    Bound<'py, PyArray2<f64>>,
);

/// The least and the greatest values of observations [observation].
type Bounds<'py> = (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f32>>);

/// An array from Python for writing. Only who holds the state of the batch may ask for it, because
/// Python hands over the same arrays at every step.
fn borrowed<'py, T: Element, D: Dimension>(
    array: &Bound<'py, PyArray<T, D>>,
) -> PyResult<PyReadwriteArray<'py, T, D>> {
    array.try_readwrite().map_err(|error| {
        PyRuntimeError::new_err(format!(
            "a buffer of the environment: {error}\n  cure: give writable arrays that nothing else uses"
        ))
    })
}

/// The values of an array from Python, row by row.
fn rows<'a, T: Element, D: Dimension>(
    array: &'a mut PyReadwriteArray<'_, T, D>,
) -> PyResult<&'a mut [T]> {
    let problem = match array.is_c_contiguous() {
        true => match array.as_slice_mut() {
            Ok(values) => return Ok(values),
            Err(error) => error.to_string(),
        },
        false => "its values are not row by row".into(),
    };
    Err(PyValueError::new_err(format!(
        "a buffer of the environment: {problem}\n  cure: give a C-contiguous array"
    )))
}

/// The state of a batch, which nobody else has meanwhile.
struct Held<'a>(MutexGuard<'a, Option<Crew<Portion>>>);

impl Held<'_> {
    /// Calls `work` on this thread, without the GIL.
    fn without_gil<T: Send>(
        self,
        py: Python<'_>,
        work: impl FnOnce(&mut Crew<Portion>) -> Fallible<T> + Send,
    ) -> PyResult<T> {
        self.with(|crew, whole| work::quick(py, || Ok(guarded(whole, || work(crew)))))
    }

    /// Calls `work` with environment `index`, one of `count`.
    fn on_one<T: Send>(
        self,
        py: Python<'_>,
        (index, count): (usize, usize),
        work: impl FnOnce(&mut DispatchEnvironment) -> Fallible<T> + Send,
    ) -> PyResult<T> {
        if index >= count {
            return Err(PyValueError::new_err(format!(
                "index: {index} of {count} environments\n  cure: give a smaller one"
            )));
        }
        self.without_gil(py, |crew| {
            crew.portion(index / AT_ONCE).with(index % AT_ONCE, work)
        })
    }

    /// Calls `work` with the state and whether it is whole; it is gone afterwards if it is not.
    fn with<T>(
        mut self,
        work: impl FnOnce(&mut Crew<Portion>, &mut bool) -> PyResult<Fallible<T>>,
    ) -> PyResult<T> {
        let Some(mut state) = self.0.take() else {
            return Err(PyRuntimeError::new_err(
                "the environment is unusable after a defect of the library\n  cure: make a new \
                 environment",
            ));
        };
        let mut whole = true;
        let done = work(&mut state, &mut whole);
        if whole {
            *self.0 = Some(state);
        }
        done?.map_err(exception)
    }
}

/// What `work` returns; `whole` stays false if it panics, which leaves half-changed environments behind.
fn guarded<T>(whole: &mut bool, work: impl FnOnce() -> T) -> T {
    *whole = false;
    let done = work();
    *whole = true;
    done
}

impl Batch {
    fn hold(&self) -> PyResult<Held<'_>> {
        match self.state.try_lock() {
            Ok(state) => Ok(Held(state)),
            Err(_) => Err(PyRuntimeError::new_err(
                "the environment is being stepped by another thread\n  cure: give every thread an \
                 environment of its own",
            )),
        }
    }

    /// Checks the lengths of arrays from Python, before the library asserts them.
    fn check(&self, lengths: &[(&str, usize, usize)]) -> PyResult<()> {
        match lengths.iter().find(|(_, found, due)| found != due) {
            None => Ok(()),
            Some((name, found, due)) => Err(PyValueError::new_err(format!(
                "{name}: {found} values, but {due} are needed\n  cure: give {due} values"
            ))),
        }
    }
}

#[pymethods]
impl Batch {
    #[new]
    #[expect(
        clippy::too_many_arguments,
        reason = "keyword arguments of the Python classes"
    )]
    fn new(
        py: Python<'_>,
        station: &Station,
        patterns: Vec<PyRef<'_, Pattern>>,
        #[pyo3(from_py_with = ConditionArguments::read)] conditions: ConditionArguments,
        observation: &str,
        #[pyo3(from_py_with = scalars::count::slots)] slots: usize,
        wait: bool,
        reward: (f64, f64),
        #[pyo3(from_py_with = scalars::count::num_envs)] count: usize,
    ) -> PyResult<Self> {
        let view: View = observation.parse().map_err(exception)?;
        let layout = Layout::new(view, slots, wait).map_err(exception)?;
        if !(1..=MOST_ENVIRONMENTS).contains(&count) {
            return Err(PyValueError::new_err(format!(
                "num_envs: {count}\n  cure: give 1 to {MOST_ENVIRONMENTS}"
            )));
        }
        let (pick, rate) = reward;
        let reward = Reward { pick, rate };
        let conditions = conditions.resolve(0)?;
        let patterns: Vec<_> = patterns.iter().map(|p| Arc::clone(&p.inner)).collect();
        let course = |(place, pattern)| Course {
            station: Arc::clone(&station.inner),
            pattern,
            conditions: conditions.of_place(place),
        };
        let courses: Vec<_> = patterns.into_iter().enumerate().map(course).collect();
        let crew = work::parallel(py, || Portion::all(courses, layout, reward, count))?;
        Ok(Self {
            layout,
            count,
            state: Mutex::new(Some(crew)),
        })
    }

    /// Number of values in an observation.
    #[getter]
    fn observation_size(&self) -> usize {
        self.layout.observation()
    }

    /// The least and the greatest value of each feature of an observation [observation].
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bounds<'py>> {
        let bounds = self
            .hold()?
            .on_one(py, (0, self.count), |environment| Ok(environment.bounds()))?;
        let low = array(py, bounds.iter().map(|bound| bound.0));
        Ok((low, array(py, bounds.iter().map(|bound| bound.1))))
    }

    /// Number of actions.
    #[getter]
    fn actions(&self) -> usize {
        self.layout.actions()
    }

    /// From now on, environment `index` draws its episodes from `seed`.
    fn reseed(&self, py: Python<'_>, index: usize, seed: u64) -> PyResult<()> {
        self.hold()?.on_one(py, (index, self.count), |environment| {
            environment.reseed((seed, 0));
            Ok(())
        })
    }

    /// Begins an episode in the environments of `chosen` [count], or in all.
    #[pyo3(signature = (observations, masks, chosen = None))]
    fn reset(
        &self,
        py: Python<'_>,
        observations: Bound<'_, PyArray2<f32>>,
        masks: Bound<'_, PyArray2<bool>>,
        chosen: Option<PyReadonlyArray1<'_, bool>>,
    ) -> PyResult<()> {
        let held = self.hold()?;
        let mut observations = borrowed(&observations)?;
        let observations = rows(&mut observations)?;
        let mut masks = borrowed(&masks)?;
        let masks = rows(&mut masks)?;
        let (size, actions) = (self.layout.observation(), self.layout.actions());
        self.check(&[
            ("observations", observations.len(), self.count * size),
            ("masks", masks.len(), self.count * actions),
        ])?;
        let chosen: Option<Vec<bool>> = chosen.map(|c| c.as_array().iter().copied().collect());
        if let Some(chosen) = &chosen {
            self.check(&[("reset_mask", chosen.len(), self.count)])?;
        }
        held.without_gil(py, |crew| {
            let chosen = chosen.unwrap_or_else(|| vec![true; self.count]);
            for (mut portion, chosen) in crew.portions().zip(chosen.chunks(AT_ONCE)) {
                portion.task = Task::Reset(chosen.to_vec());
            }
            crew.work()?;
            let rows = observations.chunks_mut(AT_ONCE * size);
            let rows = rows.zip(masks.chunks_mut(AT_ONCE * actions));
            for (portion, (observations, masks)) in crew.portions().zip(rows) {
                observations.copy_from_slice(&portion.observations);
                masks.copy_from_slice(&portion.masks);
            }
            Ok(())
        })
    }

    /// Takes an action in every environment; where the episode is over, the next one begins. Returns
    /// whether some episode is.
    fn step(
        &self,
        py: Python<'_>,
        actions: PyReadonlyArray1<'_, i64>,
        written: Written<'_>,
    ) -> PyResult<bool> {
        let (observations, masks, rewards, ended, counts, values) = written;
        let given = actions.as_array();
        let held = self.hold()?;
        let mut observations = borrowed(&observations)?;
        let observations = rows(&mut observations)?;
        let mut masks = borrowed(&masks)?;
        let masks = rows(&mut masks)?;
        let mut rewards = borrowed(&rewards)?;
        let rewards = rows(&mut rewards)?;
        let mut ended = borrowed(&ended)?;
        let ended = rows(&mut ended)?;
        let mut counts = borrowed(&counts)?;
        let counts = rows(&mut counts)?;
        let mut values = borrowed(&values)?;
        let values = rows(&mut values)?;
        let (size, wide) = (self.layout.observation(), self.layout.actions());
        self.check(&[
            ("actions", given.len(), self.count),
            ("observations", observations.len(), self.count * size),
            ("masks", masks.len(), self.count * wide),
            ("rewards", rewards.len(), self.count),
            ("ends", ended.len(), self.count),
            ("counts", counts.len(), self.count * 2),
            ("values", values.len(), self.count * 4),
        ])?;
        let index = |given: &i64| usize::try_from(*given).unwrap_or(usize::MAX);
        let actions: Vec<usize> = given.iter().map(index).collect();
        if let Some(place) = actions.iter().position(|action| *action >= wide) {
            return Err(PyValueError::new_err(format!(
                "environment {place}: action {} is out of range\n  cure: give 0 to {}",
                given[place],
                wide - 1
            )));
        }
        held.without_gil(py, |crew| {
            for (mut portion, actions) in crew.portions().zip(actions.chunks(AT_ONCE)) {
                portion.choose(actions)?;
            }
            crew.work()?;
            let rows = observations.chunks_mut(AT_ONCE * size);
            let rows = rows.zip(masks.chunks_mut(AT_ONCE * wide));
            let flags = rewards.chunks_mut(AT_ONCE).zip(ended.chunks_mut(AT_ONCE));
            let figures = counts.chunks_mut(AT_ONCE * 2);
            let figures = figures.zip(values.chunks_mut(AT_ONCE * 4));
            let all = crew.portions().zip(rows.zip(flags.zip(figures)));
            for (mut portion, ((observations, masks), (flags, figures))) in all {
                mem::replace(&mut portion.outcome, Ok(()))?;
                observations.copy_from_slice(&portion.observations);
                masks.copy_from_slice(&portion.masks);
                write_steps(&portion.steps, flags, figures);
            }
            Ok(ended.contains(&true))
        })
    }

    /// Takes `action` in the only environment, in which no new episode begins. Returns the reward,
    /// and the figures of the episode if it is over.
    fn advance<'py>(
        &self,
        py: Python<'py>,
        action: i64,
        observation: Bound<'_, PyArray1<f32>>,
        mask: Bound<'_, PyArray1<bool>>,
    ) -> PyResult<(f64, Option<Bound<'py, PyDict>>)> {
        let held = self.hold()?;
        let mut observation = borrowed(&observation)?;
        let observation = rows(&mut observation)?;
        let mut mask = borrowed(&mask)?;
        let mask = rows(&mut mask)?;
        self.check(&[
            ("environments", self.count, 1),
            ("observation", observation.len(), self.layout.observation()),
            ("mask", mask.len(), self.layout.actions()),
        ])?;
        let action = usize::try_from(action).unwrap_or(usize::MAX);
        let step = held.on_one(py, (0, self.count), |environment| {
            environment.advance(action, observation, mask)
        })?;
        let figures = step.ended.map(|figures| figures_by_name(py, &figures));
        Ok((step.reward, figures.transpose()?))
    }

    /// Begins an episode in the only environment.
    fn begin(
        &self,
        py: Python<'_>,
        observation: Bound<'_, PyArray1<f32>>,
        mask: Bound<'_, PyArray1<bool>>,
    ) -> PyResult<()> {
        let held = self.hold()?;
        let mut observation = borrowed(&observation)?;
        let observation = rows(&mut observation)?;
        let mut mask = borrowed(&mask)?;
        let mask = rows(&mut mask)?;
        self.check(&[
            ("observation", observation.len(), self.layout.observation()),
            ("mask", mask.len(), self.layout.actions()),
        ])?;
        held.on_one(py, (0, self.count), |environment| {
            environment.reset(observation, mask);
            Ok(())
        })
    }

    /// The index of the pattern that environment `index` picks, and the picks so far by column.
    fn picks<'py>(&self, py: Python<'py>, index: usize) -> PyResult<(usize, Bound<'py, PyDict>)> {
        let (scene, picks) = self
            .hold()?
            .on_one(py, (index, self.count), |environment| {
                let scene = environment.scene();
                let picks = environment.run().map(|run| run.picks().to_vec());
                Ok((scene, picks.unwrap_or_default()))
            })?;
        Ok((scene, pick_columns(py, &picks)?))
    }

    /// The index of the robot that decides in environment `index`, and when [s]; `None` if the episode
    /// is over.
    fn due(&self, py: Python<'_>, index: usize) -> PyResult<Option<(usize, f64)>> {
        self.hold()?.on_one(py, (index, self.count), |environment| {
            let due = environment.run().and_then(|run| run.next_decision());
            Ok(due.map(|snapshot| (snapshot.robot, snapshot.time)))
        })
    }

    /// The items in the slots of environment `index`, as indices into its pattern.
    fn items(&self, py: Python<'_>, index: usize) -> PyResult<Vec<u32>> {
        self.hold()?.on_one(py, (index, self.count), |environment| {
            Ok(environment.items())
        })
    }

    /// Panics in a step, for the test of what becomes of the environment then.
    #[cfg(debug_assertions)]
    fn _panic(&self, py: Python<'_>) -> PyResult<()> {
        self.hold()?.on_one(py, (0, self.count), |_| {
            crate::defect::panic_with("in a step")
        })
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(PyTypeError::new_err(
            "an environment cannot be pickled or copied\n  cure: make one where it is stepped, from the \
             same arguments; stations, patterns and results can be pickled",
        ))
    }
}
