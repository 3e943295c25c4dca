//! What an emulated station is put through.

/// Everything that can go wrong, and does.
pub const TROUBLE: &str = "--failing-grasps 0.1 --lost-acks 0.02 --duplicates 0.1 --out-of-order 0.05 \
    --jitter-ms 50 --robot-down 1,20,30 --belt-stop 60,20";
