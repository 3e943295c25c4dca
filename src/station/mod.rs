//! The station: a belt and the robots along it.
//!
//! A [`Station`] is always valid; code that receives one need not check it again.

mod arm_keys;
mod belt;
mod builtin;
mod check;
mod class;
mod edit;
mod file;
mod geometry;
mod line;
mod load;
mod naming;
mod plausible;
mod robot;
mod sorting;
mod written;

pub use belt::Belt;
pub use builtin::{BUILT_INS, BuiltIn, built_in};
pub use class::ItemClass;
pub use edit::edited;
pub use file::{Overrides, SavedStrategy, commented_example, parse, parse_with_strategy};
pub use geometry::Station;
pub use line::{Line, LineBins};
pub use load::{file_text, is_file, load, load_built_in, load_with_strategy};
pub(crate) use naming::robot_called;
pub use robot::{Bin, Robot};
pub use sorting::ClassId;
pub use written::{station_hash, to_toml};
