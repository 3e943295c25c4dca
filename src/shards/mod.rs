//! Long work in shards: the same call, made in several processes or on several machines, each of which
//! does a part of it, and a last call that puts the parts together.
//!
//! A study splits its work into *units*, such as all methods on one pattern, and asks a [`Ledger`] for
//! the result of each. In a plain call the ledger makes them all. In a [`Shard`] it makes those that the
//! shard owns and records them; the study then ends with [`Error::sharded`](crate::error::Error::sharded).
//! A ledger of what all shards recorded gives the study every result, so that it goes on as if it had
//! made them: with the same additions in the same order, and so to the same bytes. What a study needs
//! before it can split, such as robust GT (game theory), is *shared* work: each shard makes it, unless the
//! ledger knows it.

mod ledger;
mod shard;

pub(crate) use ledger::none_complete;
pub use ledger::{Ledger, Recorded};
pub use shard::Shard;
