//! A report of any verb behind one type, for a reader who takes all of them alike.

use crate::csv_rows::Column;
use crate::presentation::Presentation;
use crate::verb_report::{VerbReport, json_text};
use pickline::error::Result;

/// The report of some verb; every [`VerbReport`] is one.
pub trait AnyReport: Send + Sync {
    /// As for [`VerbReport::to_table`].
    fn table(&self, shown: &Presentation) -> String;

    /// As for [`VerbReport::to_csv`].
    fn csv(&self) -> String;

    /// As for [`json_text`].
    ///
    /// # Errors
    /// As for [`json_text`].
    fn json(&self) -> Result<String>;

    /// As for [`VerbReport::to_page`].
    fn page(&self, shown: &Presentation) -> Option<String>;

    /// As for [`VerbReport::tables`].
    fn tables(&self) -> Vec<(&'static str, Vec<Column>)>;
}

impl<R: VerbReport + Send + Sync> AnyReport for R {
    fn table(&self, shown: &Presentation) -> String {
        self.to_table(shown)
    }

    fn csv(&self) -> String {
        self.to_csv()
    }

    fn json(&self) -> Result<String> {
        json_text(self)
    }

    fn page(&self, shown: &Presentation) -> Option<String> {
        self.to_page(shown)
    }

    fn tables(&self) -> Vec<(&'static str, Vec<Column>)> {
        VerbReport::tables(self)
    }
}
