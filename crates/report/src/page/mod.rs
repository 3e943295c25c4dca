//! Pages of results: answer, charts, tables, provenance.
//!
//! | file | what it is |
//! |---|---|
//! | `document.rs`, `report.html`, `report.css` | a page as a whole |
//! | `base.css` | the style that the replay shares |
//! | `table.rs` | tables whose figures name their field of the JSON report |
//! | `comparison.rs`, `sweep.rs`, `optimum.rs` | the page of each report |
//! | `html.rs` | text and data inside HTML |

mod comparison;
mod document;
mod html;
mod optimum;
mod sweep;
mod table;

pub use comparison::comparison_page;
pub use optimum::optimum_page;
pub use sweep::sweep_page;

pub use document::BASE_STYLE;
pub(super) use html::{escape, fill, inert};
