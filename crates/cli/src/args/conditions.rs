//! The arguments for the conditions under which strategies run.

use clap::Args;

/// What the camera sees and what can go wrong, for every verb that runs strategies.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Conditions")]
pub(crate) struct ConditionArgs {
    /// Only items that have passed this position are known [m], negative upstream of the
    /// belt's start; a robot cannot set out for others [default: all are known]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub camera_x: Option<f64>,
    /// Grasps may fail: each succeeds with the item's p_grasp or, if it has none, with
    /// probability P, so 0.9 means that one in ten fails [default P: 1]
    #[arg(
        long,
        value_name = "P",
        num_args = 0..=1,
        default_missing_value = "1",
        allow_negative_numbers = true
    )]
    pub grasp_success: Option<f64>,
    /// The old name of the flag above; rejected, as it said the opposite of the number
    #[arg(
        long,
        hide = true,
        num_args = 0..=1,
        default_missing_value = "",
        allow_hyphen_values = true
    )]
    pub grasp_failures: Option<String>,
    /// Standard deviation of the normal error in each reported position [m]
    #[arg(
        long,
        value_name = "SD",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub position_noise: f64,
    /// Leave items with a p_detection below P on the belt; those without one count as certain
    /// [default: 0, all are picked]
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.0,
        hide_default_value = true,
        allow_negative_numbers = true
    )]
    pub min_detection: f64,
}

/// Whether detections may be wrong, for the verbs that say what went into the bins.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Conditions")]
pub(crate) struct DetectionArgs {
    /// Detections may be wrong: each item is what it is reported as with its p_detection, or
    /// what its true_class says; purity and recovery are reported, in total and for each bin
    #[arg(long)]
    pub misdetections: bool,
}
