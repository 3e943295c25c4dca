//! What pages of results are made of. What the page of a report says is beside the report.
//!
//! | file | what it is |
//! |---|---|
//! | `document.rs`, `report.html`, `report.css` | a page as a whole |
//! | `base.css` | the style that the replay shares |
//! | `table.rs` | tables whose figures name their field of the JSON report |
//! | `html.rs` | text and data inside HTML |

mod document;
mod html;
mod table;

pub use document::BASE_STYLE;

pub(crate) use document::{PageSection, ReportPage, charts};
pub(crate) use html::{escape, fill, inert};
pub(crate) use table::{Cell, PageFigure, PageTable};
