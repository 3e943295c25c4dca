//! What is known of the units of a call.

use super::shard::Shard;
use crate::error::{Error, Result, shown};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What shards recorded: figures to the last bit.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recorded {
    /// What the call was made on, by name: equal in all its shards.
    inputs: BTreeMap<String, String>,
    /// The results of shared work, by its name.
    shared: BTreeMap<String, Value>,
    /// The results of units, by the name of the work and the number of the unit.
    units: BTreeMap<String, BTreeMap<usize, Value>>,
}

impl Recorded {
    /// Number of units.
    pub fn units(&self) -> usize {
        self.units.values().map(BTreeMap::len).sum()
    }

    /// Adds what another shard of the same call recorded.
    ///
    /// # Errors
    /// Other inputs, or another result of the same work: the problem alone, for a message that says whose.
    pub fn add(&mut self, other: Self) -> std::result::Result<(), String> {
        for (name, input) in other.inputs {
            let known = self.inputs.entry(name.clone()).or_insert(input.clone());
            if *known != input {
                return Err(format!(
                    "{name} changed between the shards before it and this one"
                ));
            }
        }
        for (name, result) in other.shared {
            let known = self.shared.entry(name.clone()).or_insert(result.clone());
            if *known != result {
                return Err(format!(
                    "{name} differs from what the shards before it found"
                ));
            }
        }
        for (work, results) in other.units {
            let known = self.units.entry(work.clone()).or_default();
            for (unit, result) in results {
                if known.insert(unit, result).is_some() {
                    return Err(format!("{work}, unit {unit} is also in a shard before it"));
                }
            }
        }
        Ok(())
    }
}

/// What a ledger is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// A plain call: nothing is known, nothing recorded.
    Plain,
    /// A part of a call.
    Shard(Shard),
    /// Parts of a call are put together; whether some may be missing.
    Merge { partial: bool },
}

/// Gives studies the results of their units of work, and records those that are made in a shard.
#[derive(Debug)]
pub struct Ledger {
    role: Role,
    recorded: Mutex<Recorded>,
}

impl Ledger {
    /// The ledger of a plain call.
    pub const PLAIN: &'static Self = {
        static PLAIN: Ledger = Ledger {
            role: Role::Plain,
            recorded: Mutex::new(Recorded {
                inputs: BTreeMap::new(),
                shared: BTreeMap::new(),
                units: BTreeMap::new(),
            }),
        };
        &PLAIN
    };

    fn of(role: Role, recorded: Recorded) -> Self {
        let recorded = Mutex::new(recorded);
        Self { role, recorded }
    }

    /// The ledger of one shard, with what is known already, such as from shard 0.
    pub fn of_shard(shard: Shard, known: Recorded) -> Self {
        Self::of(Role::Shard(shard), known)
    }

    /// The ledger that puts together what all shards recorded; if `partial`, some may be missing, whose
    /// units are then left out.
    pub fn of_merge(recorded: Recorded, partial: bool) -> Self {
        Self::of(Role::Merge { partial }, recorded)
    }

    /// The shard whose units are made; `None` if all are.
    pub fn shard(&self) -> Option<Shard> {
        match self.role {
            Role::Shard(shard) => Some(shard),
            _ => None,
        }
    }

    /// Whether unit `unit` is for this call: a shard makes its own units, any other call all of them.
    pub fn owns(&self, unit: usize) -> bool {
        self.shard().is_none_or(|shard| shard.owns(unit))
    }

    /// Whether some units may be missing.
    pub fn is_partial(&self) -> bool {
        self.role == Role::Merge { partial: true }
    }

    /// A copy of what it has recorded.
    pub fn recorded(&self) -> Recorded {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, Recorded> {
        // A panic elsewhere leaves whole entries.
        self.recorded.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records that the call is made on `input`, which messages call `name`; `input` identifies it, such
    /// as a hash.
    ///
    /// # Errors
    /// As for `input`; the shards were made on another one.
    pub fn check_input(&self, name: &str, input: impl FnOnce() -> Result<String>) -> Result<()> {
        if self.role == Role::Plain {
            return Ok(());
        }
        let input = input()?;
        let mut recorded = self.lock();
        match recorded.inputs.get(name) {
            Some(known) if *known != input => Err(Error::input(
                name,
                "changed since other shards of this call were made",
                "run all shards again, with the same files",
            )),
            Some(_) => Ok(()),
            None => {
                recorded.inputs.insert(name.to_owned(), input);
                Ok(())
            }
        }
    }

    /// The result of shared work, known or made by `make`.
    ///
    /// # Errors
    /// As for `make`; a known result that is not one of this work.
    pub fn shared<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        make: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        if self.role == Role::Plain {
            return make();
        }
        let known = self.lock().shared.get(name).cloned();
        if let Some(known) = known {
            return decoded(known, name);
        }
        let made = make()?;
        let value = encoded::<T>(&made, name)?;
        self.lock().shared.insert(name.to_owned(), value);
        Ok(made)
    }

    /// Whether [`Ledger::unit`] would make unit `unit` of the work called `name`.
    pub fn makes(&self, name: &str, unit: usize) -> bool {
        let recorded = self.lock();
        let of_work = recorded.units.get(name);
        !self.is_partial() && !of_work.is_some_and(|units| units.contains_key(&unit))
    }

    /// The result of unit `unit` of the work called `name`, known or made by `make`; `None` if it is
    /// missing and may be. The caller asks only for units that the shard owns.
    ///
    /// # Errors
    /// As for [`Ledger::shared`].
    pub fn unit<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        unit: usize,
        make: impl FnOnce() -> Result<T>,
    ) -> Result<Option<T>> {
        if self.role == Role::Plain {
            return make().map(Some);
        }
        let known = {
            let recorded = self.lock();
            let of_work = recorded.units.get(name);
            of_work.and_then(|units| units.get(&unit)).cloned()
        };
        if let Some(known) = known {
            return decoded(known, name).map(Some);
        }
        if self.is_partial() {
            return Ok(None);
        }
        let made = make()?;
        let value = encoded::<T>(&made, name)?;
        let mut recorded = self.lock();
        let of_work = recorded.units.entry(name.to_owned()).or_default();
        of_work.insert(unit, value);
        Ok(Some(made))
    }

    /// Like [`Ledger::unit`], and also `None` for a unit that the shard does not own.
    ///
    /// # Errors
    /// As for [`Ledger::shared`].
    pub fn own_unit<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        unit: usize,
        make: impl FnOnce() -> Result<T>,
    ) -> Result<Option<T>> {
        match self.owns(unit) {
            true => self.unit(name, unit, make),
            false => Ok(None),
        }
    }
}

/// The error of a part of the shards in which not one `thing` is complete.
pub(crate) fn none_complete(thing: &str) -> Error {
    Error::usage(
        "'partial'",
        format!("no {thing} is complete in these shards"),
        "run more of the shards",
    )
}

/// A result as it is recorded.
///
/// # Errors
/// One that would not be read back, such as a figure that is not finite: a defect.
fn encoded<T: Serialize + DeserializeOwned>(made: &T, name: &str) -> Result<Value> {
    let value = serde_json::to_value(made);
    let value = value.map_err(|error| Error::internal(format!("{name}: {error}")))?;
    match T::deserialize(&value) {
        Ok(_) => Ok(value),
        Err(error) => Err(Error::internal(format!("{name}: {error}"))),
    }
}

fn decoded<T: DeserializeOwned>(value: Value, name: &str) -> Result<T> {
    serde_json::from_value(value).map_err(|error| {
        Error::input(
            format!("the shards: {}", shown(name)),
            format!("the recorded result cannot be read: {error}"),
            "run all shards again with this version of pickline",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_shards_record_is_put_together() {
        let shards = (1..=3).map(|index| Shard::new(index, 3).unwrap());
        let make = |unit: usize| unit as f64 / 7.0;
        let mut all = Recorded::default();
        for shard in shards {
            let ledger = Ledger::of_shard(shard, Recorded::default());
            ledger.check_input("the line", || Ok("a".into())).unwrap();
            assert_eq!(ledger.shared("base", || Ok(0.1)).unwrap(), 0.1);
            for unit in 0..7 {
                let made = ledger.own_unit("runs", unit, || Ok(make(unit))).unwrap();
                assert_eq!(made, shard.owns(unit).then(|| make(unit)));
            }
            // As it goes through a file.
            let text = serde_json::to_string(&ledger.recorded()).unwrap();
            all.add(serde_json::from_str(&text).unwrap()).unwrap();
        }
        assert_eq!(all.units(), 7);
        let merged = Ledger::of_merge(all.clone(), false);
        let never = || -> Result<f64> { panic!("it is known") };
        assert_eq!(merged.shared("base", never).unwrap(), 0.1);
        for unit in 0..7 {
            let known = merged.unit("runs", unit, never).unwrap();
            assert_eq!(known.map(f64::to_bits), Some(make(unit).to_bits()));
        }
        let other = merged.check_input("the line", || Ok("b".into()));
        let told = other.unwrap_err().to_string();
        assert!(
            told.contains("the line: changed since other shards"),
            "{told}"
        );
        // What is missing is made, or left out.
        assert_eq!(merged.unit("runs", 9, || Ok(9.0)).unwrap(), Some(9.0));
        let partial = Ledger::of_merge(all.clone(), true);
        assert_eq!(partial.unit("runs", 9, never).unwrap(), None);
        // A unit counts once, and shards of other inputs are refused.
        let twice = all.clone().add(all.clone()).unwrap_err();
        assert!(twice.contains("unit 0 is also in"), "{twice}");
        for (what, words) in [("inputs", "the line changed"), ("shared", "base differs")] {
            let mut changed = serde_json::to_value(&all).unwrap();
            changed["units"] = serde_json::json!({});
            let name = if what == "inputs" { "the line" } else { "base" };
            changed[what][name] = serde_json::json!("x");
            let error = all.clone().add(serde_json::from_value(changed).unwrap());
            assert!(error.unwrap_err().contains(words));
        }
    }

    /// A figure that JSON cannot hold is not recorded as another one.
    #[test]
    fn only_what_can_be_read_back_is_recorded() {
        let ledger = Ledger::of_shard(Shard::new(1, 1).unwrap(), Recorded::default());
        let error = ledger.unit("runs", 0, || Ok(f64::INFINITY)).unwrap_err();
        assert_eq!(error.kind(), crate::error::ErrorKind::Internal);
        assert_eq!(ledger.recorded(), Recorded::default());
    }
}
