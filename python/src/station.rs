//! Stations.

use crate::scalars;
use crate::work;
use pickline::error::counted;
use pickline::station::{self, BUILT_INS, Overrides};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// A belt and the robots along it; it cannot be changed.
///
/// Args:
///     name: The name of a built-in station (``Station.built_in()``), or a station file. A file with
///         that name comes first.
///     robots: Number of identical robots on the line; as many as the station has if not given.
///     belt_speed: Speed of the belt [m/s]; the station's if not given.
///
/// Raises:
///     ValueError: An unknown name, or a value that the model does not allow.
///     OSError: A file that cannot be read.
#[pyclass(frozen, module = "pickline", eq)]
#[derive(Debug, Clone)]
pub(crate) struct Station {
    pub(crate) inner: Arc<pickline::Station>,
    /// What results call it.
    pub(crate) name: String,
    pub(crate) source: Source,
}

impl PartialEq for Station {
    fn eq(&self, other: &Self) -> bool {
        self.inner == other.inner
    }
}

/// What a station was made from, and with which belt speed [m/s] instead of its own: the same line with
/// another number of robots is made from it again.
#[derive(Debug, Clone)]
pub(crate) struct Source {
    /// The name of a built-in station, or of the text in messages.
    name: String,
    /// The text of a station file; `None` for a built-in station.
    text: Option<String>,
    belt_speed: Option<f64>,
}

/// What another process makes a station of: its text with every value, its name, the text of its file and
/// its own belt speed.
type Parts = (String, String, Option<String>, Option<f64>);

impl Source {
    /// The station with this number of robots, or as many as its source has.
    pub(crate) fn station(&self, robots: Option<usize>) -> pickline::Result<pickline::Station> {
        let overrides = Overrides::default()
            .with_robots(robots)
            .with_belt_speed(self.belt_speed);
        match &self.text {
            Some(text) => station::parse(text, &self.name, overrides),
            None => station::load_built_in(&self.name, overrides),
        }
    }
}

/// The name of a built-in station, or a file.
fn station_name(given: &Bound<'_, PyAny>) -> PyResult<PathBuf> {
    given.extract().map_err(|_| {
        PyTypeError::new_err(format!(
            "name: {given:?} is not the name of a station\n  cure: give that of a built-in one, or of a file"
        ))
    })
}

impl Station {
    /// Reads the argument `station`: one, the name of a built-in one, or a station file.
    pub(crate) fn read(given: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(station) = given.cast::<Self>() {
            return Ok(station.get().clone());
        }
        let name = given.extract::<PathBuf>().map_err(|_| {
            PyTypeError::new_err(format!(
                "station: {given:?} is not a station\n  cure: give a Station, the name of a built-in one, or a \
                 station file"
            ))
        })?;
        Self::new(given.py(), name, None, None)
    }

    fn made(py: Python<'_>, source: Source, robots: Option<usize>) -> PyResult<Self> {
        let station = work::quick(py, || source.station(robots))?;
        Ok(Self::of(station, source))
    }

    fn of(station: pickline::Station, source: Source) -> Self {
        Self {
            inner: Arc::new(station),
            name: source.name.clone(),
            source,
        }
    }
}

#[pymethods]
impl Station {
    #[new]
    #[pyo3(signature = (name = PathBuf::from("paper"), *, robots = None, belt_speed = None))]
    fn new(
        py: Python<'_>,
        #[pyo3(from_py_with = station_name)] name: PathBuf,
        #[pyo3(from_py_with = scalars::optional_count::robots)] robots: Option<usize>,
        belt_speed: Option<f64>,
    ) -> PyResult<Self> {
        let name = name.to_string_lossy().into_owned();
        // A sweep of robots makes the line again, from what the file says now.
        let text = work::quick(py, || station::file_text(&name))?;
        let source = Source {
            name,
            text,
            belt_speed,
        };
        Self::made(py, source, robots)
    }

    /// The station of the text of a station file, which messages call ``name``.
    #[staticmethod]
    #[pyo3(signature = (text, *, name = "the station", robots = None, belt_speed = None))]
    fn from_toml(
        py: Python<'_>,
        text: &str,
        name: &str,
        #[pyo3(from_py_with = scalars::optional_count::robots)] robots: Option<usize>,
        belt_speed: Option<f64>,
    ) -> PyResult<Self> {
        let source = Source {
            name: name.to_owned(),
            text: Some(text.to_owned()),
            belt_speed,
        };
        Self::made(py, source, robots)
    }

    /// The names of the built-in stations, the default first.
    #[staticmethod]
    fn built_in() -> Vec<&'static str> {
        BUILT_INS.iter().map(|station| station.name).collect()
    }

    /// The station as the text of a station file; ``from_toml`` reads an equal one.
    fn to_toml(&self, py: Python<'_>) -> PyResult<String> {
        work::quick(py, || Ok(station::to_toml(&self.inner)))
    }

    /// The hash by which results name the station.
    #[getter]
    fn hash(&self, py: Python<'_>) -> PyResult<String> {
        work::quick(py, || Ok(station::station_hash(&self.inner)))
    }

    /// The names of the robots, upstream first.
    #[getter]
    fn robots(&self) -> Vec<String> {
        let robots = self.inner.robots().iter();
        robots.map(|robot| robot.name.clone()).collect()
    }

    /// The names of the classes of items.
    #[getter]
    fn classes(&self) -> Vec<String> {
        self.inner.class_names().to_vec()
    }

    /// Speed of the belt [m/s].
    #[getter]
    fn belt_speed(&self) -> f64 {
        self.inner.belt().speed
    }

    /// Length of the belt [m].
    #[getter]
    fn belt_length(&self) -> f64 {
        self.inner.belt().length
    }

    /// Width of the belt [m].
    #[getter]
    fn belt_width(&self) -> f64 {
        self.inner.belt().width
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (belt, robots) = (self.inner.belt(), self.inner.robots().len());
        Ok(format!(
            "<Station of {}, belt {} m x {} m at {} m/s, hash {}>",
            counted(robots, "robot"),
            belt.length,
            belt.width,
            belt.speed,
            self.hash(py)?
        ))
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<u64> {
        // Equal stations have equal hashes; any number would do for one that is no number.
        Ok(u64::from_str_radix(&self.hash(py)?, 16).unwrap_or_default())
    }

    fn __copy__(&self) -> Self {
        self.clone()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.clone()
    }

    /// The station of a pickle.
    #[staticmethod]
    fn _of_parts(
        py: Python<'_>,
        whole: &str,
        name: String,
        text: Option<String>,
        belt_speed: Option<f64>,
    ) -> PyResult<Self> {
        let station = work::quick(py, || station::parse(whole, &name, Overrides::default()))?;
        let source = Source {
            name,
            text,
            belt_speed,
        };
        Ok(Self::of(station, source))
    }

    /// By its text: where it is unpickled, a file may not be there, or not be the same. With what it was
    /// made from, so that the line can have other numbers of robots there, too.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Parts)> {
        let read = py.get_type::<Self>().getattr("_of_parts")?;
        let Source {
            name,
            text,
            belt_speed,
        } = self.source.clone();
        Ok((read, (self.to_toml(py)?, name, text, belt_speed)))
    }
}
