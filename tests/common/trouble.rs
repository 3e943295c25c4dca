//! What an emulated station is put through.
#![allow(dead_code)]

use pickline_live::emulator::InjectedFaults;

/// Everything that can go wrong, and does.
pub const TROUBLE: &str = "--failing-grasps 0.1 --lost-acks 0.02 --duplicates 0.1 --out-of-order 0.05 \
    --jitter-ms 50 --robot-down 1,20,30 --belt-stop 60,20";

/// The same kinds, for a station without a process of its own.
pub fn all_troubles(seed: u64) -> InjectedFaults {
    InjectedFaults {
        grasp_failures: 0.1,
        lost_acks: 0.02,
        duplicates: 0.1,
        out_of_order: 0.05,
        jitter: 0.05,
        robot_down: Some((0, 60.0, 30.0)),
        belt_stop: Some((120.0, 20.0)),
        seed,
    }
}
