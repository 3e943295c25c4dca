//! What an emulated station is put through.
#![allow(dead_code)]

use pickline_live::emulator::InjectedFaults;

/// Everything that can go wrong, and does.
pub const TROUBLE: &str = "--failing-grasps 0.1 --lost-acks 0.02 --duplicates 0.1 --out-of-order 0.05 \
    --jitter-ms 50 --robot-down 1,20,30 --belt-stop 60,20";

/// The same kinds, for a station without a process of its own.
pub fn all_troubles(seed: u64) -> InjectedFaults {
    InjectedFaults::default()
        .with_grasp_failures(0.1)
        .with_lost_acks(0.02)
        .with_duplicates(0.1)
        .with_out_of_order(0.05)
        .with_jitter(0.05)
        .with_robot_down(Some((0, 60.0, 30.0)))
        .with_belt_stop(Some((120.0, 20.0)))
        .with_seed(seed)
}
