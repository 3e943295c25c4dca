//! Patterns: the items on the belt, generated or recorded.

mod attributes;
mod class_shares;
mod clustered;
mod describe;
mod feed;
mod feeder;
mod file;
mod gaps;
mod grid;
mod item;
mod plausible;
mod poisson;
mod profile;
mod random;
mod recipe;
mod recorded;
mod set;
mod source;
mod source_text;
pub mod tracking;
mod training;

pub use attributes::{Attributes, Distribution};
pub use class_shares::ClassShares;
pub use describe::{Description, describe};
pub(crate) use feed::FEEDS;
pub use feed::{Feed, FeedParameters, FeedShape};
pub use feeder::Feeder;
pub use file::{Loaded, load, parse, read, to_csv};
pub use grid::grid;
pub(crate) use item::MOST_ITEMS;
pub use item::{Item, Pattern};
pub use poisson::poisson_disk;
pub use recipe::Recipe;
pub(crate) use recorded::describe_given;
pub use recorded::is_pattern_name;
pub use set::PatternSet;
pub use source::PatternSource;
pub use training::TrainingSet;
pub(crate) use training::grids_around;

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// The random number generator of draw `index` under `seed`: ChaCha8 with one stream per draw, so
/// that a pattern does not depend on earlier draws or on the thread. ChaCha8 gives the same numbers
/// on every machine and in every release.
pub fn random_stream(seed: u64, index: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(index);
    rng
}
