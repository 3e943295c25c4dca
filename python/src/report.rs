//! Reports: what a call found, with its tables, charts and page.

use crate::arrays::array;
use crate::errors::{exception, spelling};
use crate::work::{self, Worked};
use numpy::PyArray1;
use pickline_report::{AnyReport, ColumnValues, Presentation};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// Another process gets the finished forms of a report: the call that unpickling makes.
pub(crate) type Unpickled<'py> = (
    Bound<'py, PyAny>,
    (
        String,
        String,
        String,
        Option<String>,
        Bound<'py, PyDict>,
        bool,
    ),
);

/// What makes a report of finished forms: ``pickline.result.KeptReport``.
pub(crate) fn kept(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    py.import("pickline.result")?.getattr("KeptReport")
}

/// The whole of a report, with settings as keyword arguments.
const SHOWN: Presentation = Presentation::whole(spelling);

/// How texts of reports are shown.
pub(crate) fn shown() -> &'static Presentation {
    &SHOWN
}

/// What a call found, in every form in which the program prints and writes it.
#[pyclass(frozen, module = "pickline._pickline")]
pub(crate) struct Report {
    inner: Box<dyn AnyReport>,
    interrupted: bool,
}

impl Report {
    /// The report of work that Ctrl-C may have ended early.
    pub(crate) fn of(worked: Worked<impl AnyReport + 'static>) -> Self {
        Self {
            inner: Box::new(worked.value),
            interrupted: worked.interrupted,
        }
    }

    /// The report of work that is done at once.
    pub(crate) fn whole(report: impl AnyReport + 'static) -> Self {
        Self {
            inner: Box::new(report),
            interrupted: false,
        }
    }
}

#[pymethods]
impl Report {
    /// Whether Ctrl-C ended the work early.
    #[getter]
    fn interrupted(&self) -> bool {
        self.interrupted
    }

    /// The text that the program prints.
    fn text(&self, py: Python<'_>) -> PyResult<String> {
        work::quick(py, || Ok(self.inner.table(&SHOWN)))
    }

    /// The main table as CSV.
    fn csv(&self, py: Python<'_>) -> PyResult<String> {
        work::quick(py, || Ok(self.inner.csv()))
    }

    /// The whole report as JSON.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        work::quick(py, || self.inner.json())
    }

    /// The page with tables and charts, if the report has one.
    fn page(&self, py: Python<'_>) -> PyResult<Option<String>> {
        work::quick(py, || Ok(self.inner.page(&SHOWN)))
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Unpickled<'py>> {
        let forms = (
            self.text(py)?,
            self.csv(py)?,
            self.json(py)?,
            self.page(py)?,
            self.tables(py)?,
            self.interrupted,
        );
        Ok((kept(py)?, forms))
    }

    /// The columns of every CSV file of the report: by the file's name and the field, the name in the
    /// file and the values.
    fn tables<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = work::quick(py, || Ok(self.inner.tables()))?;
        let tables = PyDict::new(py);
        for (name, columns) in found {
            let table = PyDict::new(py);
            for column in columns {
                table.set_item(column.field, (column.name, values(py, column.values)?))?;
            }
            tables.set_item(name, table)?;
        }
        Ok(tables)
    }
}

/// Values of a column: an array, or a list of texts.
fn values(py: Python<'_>, values: ColumnValues) -> PyResult<Bound<'_, PyAny>> {
    Ok(match values {
        ColumnValues::Flags(flags) => array(py, flags.into_iter()).into_any(),
        ColumnValues::Counts(counts) => counted(py, &counts),
        ColumnValues::Numbers(numbers) => array(py, numbers.into_iter()).into_any(),
        ColumnValues::Texts(texts) => PyList::new(py, texts)?.into_any(),
        _ => {
            return Err(exception(pickline::Error::internal(
                "a column of unknown kind",
            )));
        }
    })
}

/// Counts as int64, in which differences can be negative, or uint64 if a seed is too large for it.
fn counted<'py>(py: Python<'py>, counts: &[u64]) -> Bound<'py, PyAny> {
    let signed: Result<Vec<i64>, _> = counts.iter().map(|&count| i64::try_from(count)).collect();
    match signed {
        Ok(counts) => PyArray1::from_vec(py, counts).into_any(),
        Err(_) => PyArray1::from_slice(py, counts).into_any(),
    }
}
