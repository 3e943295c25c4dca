//! What is heard: which messages are believed, and who heeds them.

use super::Controller;
use crate::live::clock::ClockKind;
use crate::live::protocol::{Due, Incoming, Outgoing, Rejected};

impl Controller {
    /// Takes a message.
    ///
    /// # Errors
    /// A message that cannot be heeded; it is counted, and nothing has changed.
    pub fn handle(&mut self, message: Incoming) -> Result<(), Rejected> {
        let result = self.heed(message);
        if let Err(rejected) = &result {
            self.count_rejected(rejected.reason);
        }
        result
    }

    fn heed(&mut self, message: Incoming) -> Result<(), Rejected> {
        let time = self.clock.believe(message.stamp())?;
        if self.clock.kind == ClockKind::Messages && time > self.clock.now {
            // What was due before this came is decided without it.
            self.settle(time, false);
        }
        match message {
            Incoming::Detection(detection) => self.detect(time, detection),
            Incoming::Belt(belt) => {
                self.heed_belt(time, &belt);
                Ok(())
            }
            Incoming::Robot(robot) => self.heed_robot(time, &robot),
            Incoming::Ack(ack) => self.heed_ack(ack.task),
            Incoming::Result(report) => self.heed_result(time, &report),
            Incoming::Tick { stamp } => {
                if self.clock.kind == ClockKind::Messages {
                    self.settle(time, true);
                    let next = self.next_due().map(|time| self.clock.stamp(time));
                    self.output.push(Outgoing::Due(Due { stamp, next }));
                }
                Ok(())
            }
        }
    }
}
