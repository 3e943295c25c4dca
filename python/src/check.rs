//! Checking picks of any origin.

use crate::pattern::Pattern;
use crate::report::Report;
use crate::station::Station;
use crate::work;
use pickline::checker::{Terms, read_picks, violations};
use pickline::files;
use pickline_report::{Provenance, VerificationReport};
use pyo3::prelude::*;
use std::path::PathBuf;

/// The report of a :class:`pickline.Verification` of a file of picks; ``call`` says who made it.
#[pyfunction]
#[pyo3(signature = (station, pattern, picks, *, tolerance, camera_x, update_hz, call))]
#[expect(clippy::too_many_arguments, reason = "the options of the program")]
pub(crate) fn check(
    py: Python<'_>,
    station: &Station,
    pattern: &Pattern,
    picks: PathBuf,
    tolerance: f64,
    camera_x: Option<f64>,
    update_hz: f64,
    call: &str,
) -> PyResult<Report> {
    let (line, items) = (&*station.inner, &*pattern.inner);
    let report = work::parallel(py, || {
        let terms = Terms::default()
            .with_tolerance(tolerance)
            .with_camera_x(camera_x)
            .with_update_hz(update_hz);
        terms.check()?;
        items.check_on(line)?;
        let name = picks.display().to_string();
        let text = files::read_text(&picks)?;
        let picks = read_picks(&text, &name, line, items)?;
        let found = violations(line, items, &picks.attempts, terms);
        let hash = files::fingerprint(&text);
        let scored = format!("{}; picks of {name} (hash {hash})", pattern.in_words());
        let made = Provenance::new(call, &station.name, line, &scored, 0)
            .without_seed()
            .under_facts(terms.describe());
        Ok(VerificationReport::new(
            line, items, &picks, &found, terms, made,
        ))
    })?;
    Ok(Report::whole(report))
}
