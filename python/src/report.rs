//! Reports: what a call found, with its tables, charts and page.

use crate::arrays::array;
use crate::errors::{exception, spelling};
use crate::work::{self, Worked};
use numpy::PyArray1;
use pickline_report::{AnyReport, Column, ColumnValues, Presentation};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// Another process gets the finished forms of a report: the call that unpickling makes.
type Unpickled<'py> = (
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

/// The whole of a report, with settings as keyword arguments.
const SHOWN: Presentation = Presentation::whole(spelling);

/// How texts of reports are shown.
pub(crate) fn shown() -> &'static Presentation {
    &SHOWN
}

/// The forms in which the program prints and writes what a call found.
pub(crate) trait Forms: Send + Sync {
    /// The text for the terminal.
    fn text(&self) -> pickline::Result<String>;

    /// The main table as CSV.
    fn csv(&self) -> pickline::Result<String>;

    /// All of it as JSON.
    fn json(&self) -> pickline::Result<String>;

    /// The page, if there is one.
    fn page(&self) -> pickline::Result<Option<String>>;

    /// The columns of every CSV file, by the file's name.
    fn tables(&self) -> Vec<(&'static str, Vec<Column>)>;
}

impl<R: AnyReport> Forms for R {
    fn text(&self) -> pickline::Result<String> {
        Ok(self.table(&SHOWN))
    }

    fn csv(&self) -> pickline::Result<String> {
        Ok(AnyReport::csv(self))
    }

    fn json(&self) -> pickline::Result<String> {
        AnyReport::json(self)
    }

    fn page(&self) -> pickline::Result<Option<String>> {
        Ok(AnyReport::page(self, &SHOWN))
    }

    fn tables(&self) -> Vec<(&'static str, Vec<Column>)> {
        AnyReport::tables(self)
    }
}

/// What a call found, in every form in which the program prints and writes it.
#[pyclass(frozen, module = "pickline._pickline")]
pub(crate) struct Report {
    inner: Box<dyn Forms>,
    interrupted: bool,
}

impl Report {
    /// The report of work that Ctrl-C may have ended early.
    pub(crate) fn of(worked: Worked<impl Forms + 'static>) -> Self {
        Self {
            inner: Box::new(worked.value),
            interrupted: worked.interrupted,
        }
    }

    /// The report of work that is done at once.
    pub(crate) fn whole(report: impl Forms + 'static) -> Self {
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
        work::quick(py, || self.inner.text())
    }

    /// The main table as CSV.
    fn csv(&self, py: Python<'_>) -> PyResult<String> {
        work::quick(py, || self.inner.csv())
    }

    /// The whole report as JSON.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        work::quick(py, || self.inner.json())
    }

    /// The page with tables and charts, or the replay of a run; None if there is none.
    fn page(&self, py: Python<'_>) -> PyResult<Option<String>> {
        work::parallel(py, || self.inner.page())
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
        Ok((py.import("pickline.result")?.getattr("KeptReport")?, forms))
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
