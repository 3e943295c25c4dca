//! Allocation: which robot may take which item, decided before any robot chooses among its own.
//! These are the ways in which line software divides the work; `docs/rivals.md` says what each does
//! and where it is documented.

mod every;
mod items;
mod own_rules;
mod round_robin;
mod share;
mod written;
mod zones;

pub use every::Every;
pub use share::Share;
pub use zones::Zones;
