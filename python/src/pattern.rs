//! Patterns.

use crate::arrays::{array, numbers, optional_names, optional_numbers};
use crate::frame;
use crate::scalars;
use crate::station::Station;
use crate::work;
use numpy::PyArray1;
use pickline::Item;
use pickline::error::{counted, rounded};
use pickline::pattern::{
    self, Attributes, ClassShares, Feed, FeedParameters, PatternSource, Recipe,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

/// The items of one run, furthest downstream first; it cannot be changed.
///
/// Columns are arrays or lists of one dimension with a value for every item, in any order; in lists
/// ``None`` is an unknown value.
///
/// Args:
///     x: Position along the travel at time 0 [m], at most 0.
///     y: Position across the belt from its centre line [m].
///     id: Unique names; "1", "2", ... if not given.
///     area_cm2: Area seen from above [cm^2].
///     p_detection: Probability that the detection is a real item.
///     p_grasp: Probability that a grasp succeeds.
///     weight: Explicit reward r, instead of the one computed from the three columns before.
///     item_class: The class that the item is reported as.
///     true_class: The class that the item is of.
///
/// Raises:
///     TypeError: A column that does not hold numbers, or texts.
///     ValueError: Another shape, or a value that the model does not allow, such as NaN.
#[pyclass(frozen, module = "pickline", eq)]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pattern {
    pub(crate) inner: Arc<pickline::Pattern>,
}

impl From<pickline::Pattern> for Pattern {
    fn from(pattern: pickline::Pattern) -> Self {
        Self {
            inner: Arc::new(pattern),
        }
    }
}

impl Pattern {
    /// What it is, in words.
    pub(crate) fn in_words(&self) -> String {
        let from = self.inner.items().last().map_or(0.0, |item| item.x0);
        let items = counted(self.inner.len(), "item");
        format!("{items}, x from {} m", rounded(from, 3))
    }
}

/// Checks that the column `name` has a value for every item.
fn check_length<T>(name: &str, values: Option<&Vec<T>>, items: usize) -> PyResult<()> {
    match values.map(Vec::len) {
        Some(length) if length != items => Err(PyValueError::new_err(format!(
            "{name}: {length} values for {items} items\n  cure: give one for every x"
        ))),
        _ => Ok(()),
    }
}

/// The belt width [m] of `given`, a number or a station.
fn width_of(given: &Bound<'_, PyAny>) -> PyResult<f64> {
    match given.cast::<Station>() {
        Ok(station) => Ok(station.get().inner.belt().width),
        Err(_) => given.extract().map_err(|_| {
            PyTypeError::new_err(format!(
                "width: a {} is not a width\n  cure: give metres, or a station",
                given.get_type()
            ))
        }),
    }
}

/// The error of a generator that is called directly: the number of items is its argument `items`.
fn of_items(error: pickline::Error) -> pickline::Error {
    error.spell_settings(|name| match name {
        "count" => "`items`".into(),
        other => format!("'{other}'"),
    })
}

#[pymethods]
impl Pattern {
    #[new]
    #[pyo3(signature = (x, y, *, id = None, area_cm2 = None, p_detection = None, p_grasp = None,
        weight = None, item_class = None, true_class = None))]
    #[expect(clippy::too_many_arguments, reason = "one for each column")]
    fn new(
        py: Python<'_>,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        id: Option<&Bound<'_, PyAny>>,
        area_cm2: Option<&Bound<'_, PyAny>>,
        p_detection: Option<&Bound<'_, PyAny>>,
        p_grasp: Option<&Bound<'_, PyAny>>,
        weight: Option<&Bound<'_, PyAny>>,
        item_class: Option<&Bound<'_, PyAny>>,
        true_class: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (x, y) = (numbers("x", x)?, numbers("y", y)?);
        check_length("y", Some(&y), x.len())?;
        let number = |name, given| {
            let values = optional_numbers(name, given)?;
            check_length(name, values.as_ref(), x.len())?;
            Ok::<_, PyErr>(values.unwrap_or_else(|| vec![None; x.len()]))
        };
        let text = |name, given| {
            let values = optional_names(name, given)?;
            check_length(name, values.as_ref(), x.len())?;
            Ok::<_, PyErr>(values.unwrap_or_else(|| vec![None; x.len()]))
        };
        let ids = text("id", id)?;
        let areas = number("area_cm2", area_cm2)?;
        let detections = number("p_detection", p_detection)?;
        let grasps = number("p_grasp", p_grasp)?;
        let weights = number("weight", weight)?;
        let classes = text("item_class", item_class)?;
        let true_classes = text("true_class", true_class)?;
        let item = |i: usize| Item {
            id: ids[i].clone().unwrap_or_else(|| (i + 1).to_string()),
            x0: x[i],
            y: y[i],
            area_cm2: areas[i],
            p_detection: detections[i],
            p_grasp: grasps[i],
            weight: weights[i],
            class: classes[i].clone().filter(|class| !class.is_empty()),
            true_class: true_classes[i].clone().filter(|class| !class.is_empty()),
        };
        let items = (0..x.len()).map(item).collect();
        let pattern = work::quick(py, || pickline::Pattern::new(items))?;
        Ok(pattern.into())
    }

    /// The pattern of a data frame of pandas or polars, with the columns of a pattern file: ``x`` and
    /// ``y``, and any of ``id``, ``area_cm2``, ``p_detection``, ``p_grasp``, ``weight``, ``class`` and
    /// ``true_class``. NaN and null are unknown values. Another column is a ``ValueError``.
    #[staticmethod]
    fn from_frame<'py>(frame: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let class = frame.py().get_type::<Self>();
        class.call((), Some(&frame::arguments(frame)?))
    }

    /// Read a pattern file.
    #[staticmethod]
    fn from_csv(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Ok(work::quick(py, || pattern::load(&path))?.pattern.into())
    }

    /// The pattern of the text of a pattern file, which messages call ``name``.
    #[staticmethod]
    #[pyo3(signature = (text, *, name = "the pattern"))]
    fn from_csv_text(py: Python<'_>, text: &str, name: &str) -> PyResult<Self> {
        Ok(work::quick(py, || pattern::parse(text, name))?.into())
    }

    /// A square lattice with this spacing [m] on a belt of this width [m].
    #[staticmethod]
    fn grid(
        py: Python<'_>,
        width: &Bound<'_, PyAny>,
        spacing: f64,
        #[pyo3(from_py_with = scalars::count::items)] items: usize,
    ) -> PyResult<Self> {
        let width = width_of(width)?;
        let pattern = work::quick(py, || {
            pattern::grid(width, spacing, items).map_err(of_items)
        })?;
        Ok(pattern.into())
    }

    /// Items at random, no two closer than ``radius`` [m], with no room for another.
    #[staticmethod]
    #[pyo3(signature = (width, radius, items, *, seed = 1))]
    fn poisson(
        py: Python<'_>,
        width: &Bound<'_, PyAny>,
        radius: f64,
        #[pyo3(from_py_with = scalars::count::items)] items: usize,
        #[pyo3(from_py_with = scalars::seed)] seed: u64,
    ) -> PyResult<Self> {
        let width = width_of(width)?;
        let mut rng = pattern::random_stream(seed, 0);
        let pattern = work::quick(py, || {
            pattern::poisson_disk(width, radius, items, &mut rng).map_err(of_items)
        })?;
        Ok(pattern.into())
    }

    /// A Poisson process of ``flow`` items per minute [1/min] on the belt of a station.
    #[staticmethod]
    #[pyo3(signature = (station, flow, items, *, seed = 1))]
    fn random(
        py: Python<'_>,
        #[pyo3(from_py_with = Station::read)] station: Station,
        flow: f64,
        #[pyo3(from_py_with = scalars::count::items)] items: usize,
        #[pyo3(from_py_with = scalars::seed)] seed: u64,
    ) -> PyResult<Self> {
        let source = PatternSource::Feed {
            feed: Feed::Random,
            flow: Some(flow),
            count: 1,
        };
        let recipe = Recipe::new(*station.inner.belt(), items, seed);
        let mut set = work::quick(py, || source.build(&recipe).map_err(of_items))?.patterns;
        let missing = || PyValueError::new_err("the feed gives no pattern");
        Ok(set.pop().ok_or_else(missing)?.into())
    }

    /// The pattern as the text of a pattern file; ``from_csv_text`` reads an equal one.
    fn to_csv(&self, py: Python<'_>) -> PyResult<String> {
        work::quick(py, || Ok(pattern::to_csv(&self.inner)))
    }

    /// Positions along the travel at time 0 [m], [items].
    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        array(py, self.inner.items().iter().map(|item| item.x0))
    }

    /// Positions across the belt [m], [items].
    #[getter]
    fn y<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        array(py, self.inner.items().iter().map(|item| item.y))
    }

    /// Rewards r, before the values of classes [items].
    #[getter]
    fn reward<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        array(py, self.inner.items().iter().map(Item::reward))
    }

    /// Names of the items.
    #[getter]
    fn id(&self) -> Vec<String> {
        let items = self.inner.items().iter();
        items.map(|item| item.id.clone()).collect()
    }

    /// The classes that the items are reported as.
    #[getter]
    fn item_class(&self) -> Vec<Option<String>> {
        let items = self.inner.items().iter();
        items.map(|item| item.class.clone()).collect()
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    fn __repr__(&self) -> String {
        format!("<Pattern of {}>", self.in_words())
    }

    fn __copy__(&self) -> Self {
        self.clone()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.clone()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        let read = py.get_type::<Self>().getattr("from_csv_text")?;
        Ok((read, (self.to_csv(py)?,)))
    }
}

/// The patterns of a source, as after ``--patterns`` of the program.
///
/// Args:
///     source: ``grid:S``, ``poisson:R:N``, ``balanced:N``, ``FEED:F/min:N``, a file or a folder.
///     station: The station for whose belt they are.
///     items: Items per pattern.
///     flow: Items per minute of a feed that does not say so [1/min].
///     cluster_size: Mean number of items in a cluster of the feed ``clustered``; 5 if not given.
///     cluster_spread: Standard deviation of their offset from its centre [m]; 0.1 if not given.
///     gap_length: Mean length of an empty stretch of belt of the feed ``gaps`` [m]; 1 if not given.
///     gap_share: Share of the belt in empty stretches; 0.3 if not given.
///     classes: Classes and their shares, such as ``"pet:0.6,wood:0.4"``.
///     seed: Seed of everything random.
#[pyfunction]
#[pyo3(signature = (source, station, *, items = 50, flow = None, cluster_size = None,
    cluster_spread = None, gap_length = None, gap_share = None, classes = None, seed = 1))]
#[expect(clippy::too_many_arguments, reason = "the options of the program")]
pub(crate) fn patterns(
    py: Python<'_>,
    source: &str,
    #[pyo3(from_py_with = Station::read)] station: Station,
    #[pyo3(from_py_with = scalars::count::items)] items: usize,
    flow: Option<f64>,
    cluster_size: Option<f64>,
    cluster_spread: Option<f64>,
    gap_length: Option<f64>,
    gap_share: Option<f64>,
    classes: Option<&str>,
    #[pyo3(from_py_with = scalars::seed)] seed: u64,
) -> PyResult<Vec<Pattern>> {
    let parameters = FeedParameters {
        cluster_size,
        cluster_spread,
        gap_length,
        gap_share,
    };
    let set = work::parallel(py, || {
        let source: PatternSource = source.parse()?;
        let feeds: Vec<&Feed> = source.feed().into_iter().collect();
        let shape = parameters.shape(&feeds)?;
        let classes: Option<ClassShares> = classes.map(str::parse).transpose()?;
        let recipe = Recipe::new(*station.inner.belt(), items, seed)
            .with_shape(shape)
            .with_attributes(Attributes::default().with_classes(classes));
        source.with_flow(flow)?.build(&recipe)
    })?;
    Ok(set.patterns.into_iter().map(Pattern::from).collect())
}

/// The patterns on which trainings score a policy while it learns, as ``pickline train`` does, by the
/// names of their cases.
///
/// Args:
///     station: The station for whose belt they are.
///     cases: ``paper``, ``dense``, ``all`` or a TOML file, as for :func:`compare`.
#[pyfunction]
#[pyo3(signature = (station, cases = "all"))]
pub(crate) fn trials<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = Station::read)] station: Station,
    cases: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let list = work::parallel(py, || pickline::study::trials(cases, &station.inner))?;
    let by_name = PyDict::new(py);
    for (name, patterns) in list {
        let patterns: Vec<Pattern> = patterns.into_iter().map(Pattern::from).collect();
        by_name.set_item(name, patterns)?;
    }
    Ok(by_name)
}
