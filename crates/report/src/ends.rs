//! Intervals in JSON: two fields beside the figure, such as `diff_low` and `diff_high`, both null
//! without an interval. For `#[serde(flatten, serialize_with = ...)]`.

use pickline::stats::Interval;
use serde::Serializer;
use serde::ser::SerializeMap as _;

macro_rules! ends {
    ($($name:ident: $low:literal, $high:literal;)*) => {$(
        #[doc = concat!("The fields `", $low, "` and `", $high, "`.")]
        pub(crate) fn $name<I, S>(interval: &I, serializer: S) -> Result<S::Ok, S::Error>
        where
            I: Copy + Into<Option<Interval>>,
            S: Serializer,
        {
            let interval: Option<Interval> = (*interval).into();
            let mut map = serializer.serialize_map(Some(2))?;
            map.serialize_entry($low, &interval.map(|interval| interval.low))?;
            map.serialize_entry($high, &interval.map(|interval| interval.high))?;
            map.end()
        }
    )*};
}

ends! {
    complete: "complete_low", "complete_high";
    difference: "diff_low", "diff_high";
    gain: "gain_low", "gain_high";
    mean: "mean_low", "mean_high";
    picked_share: "picked_share_low", "picked_share_high";
    picking_rate: "picking_rate_low", "picking_rate_high";
    purity: "purity_low", "purity_high";
    recovery: "recovery_low", "recovery_high";
    throughput: "throughput_low", "throughput_high";
}
