//! What a run of the live node keeps on disk: its journal.

use super::args::{KeptArgs, TransportArgs};
use crate::decision::Strategy;
use crate::error::Result;
use crate::live::journal::{Found, Journal, Owner};
use crate::live::{ClockKind, Config, Controller};
use crate::report::station_hash;
use crate::station::Station;
use std::path::Path;

/// What a run keeps.
#[derive(Debug, Default)]
pub struct Kept {
    journal: Option<Journal>,
}

impl KeptArgs {
    /// The controller of a run, going on where its journal ends if it has one.
    ///
    /// # Errors
    /// As for [`Found::open`] and [`Controller::restore`].
    pub fn open(
        &self,
        station: Station,
        strategy: Box<dyn Strategy>,
        config: Config,
        transport: &TransportArgs,
    ) -> Result<(Controller, Kept)> {
        let Some(path) = &self.journal else {
            return Ok((Controller::new(station, strategy, config), Kept::default()));
        };
        let owner = Owner {
            station: station_hash(&station),
            clock: config.clock,
            program: format!("pickline {}", env!("CARGO_PKG_VERSION")),
        };
        let mut found = Found::open(path, &owner)?;
        let mut controller = match found.reading.take() {
            None => Controller::new(station, strategy, config),
            Some(reading) => {
                let stamp = (config.clock == ClockKind::System).then(super::live::unix_now);
                let restored =
                    Controller::restore(station, strategy, config, reading.state, stamp);
                let controller =
                    restored.map_err(|error| error.inside(&path.display().to_string()))?;
                transport.remark(&resuming(path, reading.torn, &controller));
                controller
            }
        };
        let journal = found.begin(&controller.whole(), self.fsync)?;
        let kept = Kept {
            journal: Some(journal),
        };
        Ok((controller, kept))
    }
}

fn resuming(path: &Path, torn: usize, controller: &Controller) -> String {
    let (items, tasks) = controller.load();
    let name = path.display();
    let mut text = format!("going on from {name}: {items} items, {tasks} open tasks");
    if torn > 0 {
        text += &format!(
            "; its last record, {torn} bytes, was never written to its end and is left out"
        );
    }
    if controller.awaits_belt() {
        text += "; no task is given until the belt has been heard";
    }
    text
}

impl Kept {
    /// Keeps what has changed. To be called before anything that the controller has `said`
    /// leaves.
    ///
    /// # Errors
    /// A journal that cannot be written.
    pub fn keep(&mut self, controller: &mut Controller, said: bool) -> Result<()> {
        let Some(journal) = &mut self.journal else {
            return Ok(());
        };
        let Some(change) = controller.change(said) else {
            return Ok(());
        };
        if journal.append(&change)? {
            journal.compact(&controller.whole())?;
        }
        Ok(())
    }
}
