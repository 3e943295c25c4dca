//! What robots report, in any order, over reconnections and restarts: the promises of a live
//! line hold whatever happens.

use crate::support::three::{ROBOTS, Three, check_sums, config, station, strategy};
use pickline_live::protocol::{Incoming, Outgoing};
use pickline_live::{Controller, LineState};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// What may happen, in any order.
#[derive(Debug, Clone)]
enum Op {
    /// An item appears at this slot of the belt.
    Detect(u8),
    Wait(u8),
    /// The robot of a task that was given acknowledges it.
    Ack(u8),
    Report(u8, u8),
    /// A robot says how it is, with a stamp that is so much older.
    Say(u8, u8, u8),
    Belt(u8),
    Reconnect,
    Restart,
}

fn ops() -> impl Strategy<Value = Vec<Op>> {
    let op = prop_oneof![
        3 => any::<u8>().prop_map(Op::Detect),
        6 => any::<u8>().prop_map(Op::Wait),
        4 => any::<u8>().prop_map(Op::Ack),
        5 => (any::<u8>(), any::<u8>()).prop_map(|(task, result)| Op::Report(task, result)),
        4 => (any::<u8>(), any::<u8>(), any::<u8>()).prop_map(|(r, s, age)| Op::Say(r, s, age)),
        1 => any::<u8>().prop_map(Op::Belt),
        1 => Just(Op::Reconnect),
        1 => Just(Op::Restart),
    ];
    proptest::collection::vec(op, 1..60)
}

/// A line in the hands of chance, with what it has promised so far.
struct World {
    controller: Controller,
    state: LineState,
    now: f64,
    speed: f64,
    travel: f64,
    /// Tasks that were given, with their items.
    given: Vec<(u64, String)>,
    picked_items: BTreeSet<String>,
    picked: u64,
}

impl World {
    fn new() -> Self {
        let mut controller = Controller::new(station(), strategy(), config()).unwrap();
        let mut state = LineState::default();
        state.apply(controller.whole());
        let mut world = Self {
            controller,
            state,
            now: 100.0,
            speed: 0.3,
            travel: 0.0,
            given: Vec::new(),
            picked_items: BTreeSet::new(),
            picked: 0,
        };
        world.belt();
        for robot in ROBOTS {
            let fields = format!(r#""kind":"robot","stamp":100,"name":"{robot}","state":"idle""#);
            world.hear(&fields);
        }
        world
    }

    fn belt(&mut self) {
        let (now, speed, travel) = (self.now, self.speed, self.travel);
        self.hear(&format!(
            r#""kind":"belt","stamp":{now},"speed":{speed},"position":{travel}"#
        ));
    }

    /// Whether the message was taken.
    fn hear(&mut self, fields: &str) -> bool {
        let message: Incoming = Three::message(fields);
        let taken = self.controller.handle(message).is_ok();
        self.look();
        taken
    }

    fn look(&mut self) {
        if let Some(change) = self.controller.change(true) {
            let text = serde_json::to_string(&change).unwrap();
            self.state.apply(serde_json::from_str(&text).unwrap());
        }
        for message in self.controller.take_output() {
            if let Outgoing::Task(task) = message {
                assert!(
                    !self.picked_items.contains(&task.item),
                    "offered again: {task:?}"
                );
                if !self.given.iter().any(|(id, _)| *id == task.id) {
                    self.given.push((task.id, task.item));
                }
            }
        }
        let view = self.controller.view(0);
        check_sums(&view.status);
        assert!(view.status.picked >= self.picked, "picked has fallen");
        self.picked = view.status.picked;
        let items: BTreeSet<&str> = view
            .claims
            .iter()
            .map(|claim| claim.item.as_str())
            .collect();
        assert_eq!(items.len(), view.claims.len(), "two claims on one item");
        assert_eq!(view.claims.len() as u64, view.status.claimed);
    }

    fn task(&self, choice: u8) -> Option<(u64, String)> {
        let count = self.given.len();
        // The newest more often than the others.
        let back = usize::from(choice) % count.clamp(1, 8);
        (count > 0).then(|| self.given[count - 1 - back].clone())
    }

    fn happen(&mut self, op: &Op) {
        let now = self.now;
        match *op {
            Op::Detect(slot) => {
                let (column, row) = (slot / 3 % 10, slot % 3);
                let x = 0.2 * f64::from(column) - 0.5 + self.travel.rem_euclid(0.2);
                let y = 0.2 * f64::from(row) - 0.2;
                self.hear(&format!(
                    r#""kind":"detection","stamp":{now},"x":{x},"y":{y}"#
                ));
            }
            Op::Wait(time) => {
                let time = 0.02 * 1.02f64.powi(i32::from(time));
                self.now += time;
                self.travel += self.speed * time;
                self.hear(&format!(r#""kind":"tick","stamp":{}"#, self.now));
            }
            Op::Ack(choice) => {
                if let Some((task, _)) = self.task(choice) {
                    self.hear(&format!(r#""kind":"ack","stamp":{now},"task":{task}"#));
                }
            }
            Op::Report(choice, result) => {
                let results = ["PICKED", "GRASP_FAIL", "MISSED", "REJECTED", "CANCELLED"];
                let result = results[usize::from(result) % results.len()];
                if let Some((task, item)) = self.task(choice) {
                    let fields = format!(
                        r#""kind":"result","stamp":{now},"task":{task},"result":"{result}""#
                    );
                    let message = Three::message(&fields);
                    let taken = self.controller.handle(message).is_ok();
                    if taken && result == "PICKED" {
                        self.picked_items.insert(item);
                    }
                    self.look();
                }
            }
            Op::Say(robot, state, age) => {
                let robot = ROBOTS[usize::from(robot) % ROBOTS.len()];
                let state = ["idle", "busy", "fault", "idle"][usize::from(state) % 4];
                let stamp = now - f64::from(age % 8) * 0.1;
                self.hear(&format!(
                    r#""kind":"robot","stamp":{stamp},"name":"{robot}","state":"{state}""#
                ));
            }
            Op::Belt(speed) => {
                self.speed = [0.0, 0.3, 0.1, 0.3][usize::from(speed) % 4];
                self.belt();
            }
            Op::Reconnect => {
                self.controller.send_again();
                self.look();
            }
            Op::Restart => {
                let state = std::mem::take(&mut self.state);
                let made = Controller::restore(station(), strategy(), config(), state, None);
                self.controller = made.unwrap();
                self.state.apply(self.controller.whole());
                self.controller.send_again();
                self.look();
                self.belt();
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 10_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Acknowledgements, results, faults, timeouts, reconnections and restarts in any
    /// order, for three robots: nothing that a robot reports as picked is offered again,
    /// the picks never fall, an item has one claim at most, and every item is in exactly
    /// one figure.
    #[test]
    fn claims_survive_random_events(ops in ops()) {
        let mut world = World::new();
        for op in &ops {
            world.happen(op);
        }
        // Left alone every task comes to its end.
        world.speed = 0.3;
        world.belt();
        for _ in 0..40 {
            world.happen(&Op::Wait(255));
        }
        let status = world.controller.status(false, 0);
        prop_assert!(status.claimed == 0, "{status:?}");
    }
}
