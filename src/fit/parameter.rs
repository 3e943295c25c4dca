//! One estimated parameter, with what is to be said about it.

use super::intervals::HalfOpen;
use crate::error::rounded;

/// One parameter of a robot, as estimated.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FittedParameter {
    /// Its name: as in a station file, with the bin where there are several.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Its value; `None` if the moves do not determine it.
    pub value: Option<f64>,
    /// Its 95 % interval; without a value, what it is at least.
    pub interval: Option<HalfOpen>,
    /// Why the value or the interval is missing, or what it was taken from; may be empty.
    pub remark: String,
}

/// A parameter with this value.
pub(super) fn known(
    name: &str,
    unit: &'static str,
    value: f64,
    interval: Option<HalfOpen>,
) -> FittedParameter {
    FittedParameter {
        name: name.to_owned(),
        unit,
        value: Some(value),
        interval,
        remark: String::new(),
    }
}

/// The same with the interval around its value.
pub(super) fn with_interval(
    parameter: FittedParameter,
    interval: impl Fn(f64) -> Option<HalfOpen>,
) -> FittedParameter {
    FittedParameter {
        interval: parameter.value.and_then(interval),
        ..parameter
    }
}

/// The same for a parameter that the moves do not determine, for this reason: its value is only one of
/// many.
pub(super) fn doubtful(parameter: FittedParameter, reason: &str) -> FittedParameter {
    let used = match parameter.value.unwrap_or_default() {
        value if value.is_finite() => format!("{} {}", rounded(value, 4), parameter.unit),
        _ => "an unlimited one".to_owned(),
    };
    FittedParameter {
        value: None,
        interval: None,
        remark: format!("{reason}; {used} is used, which fits together with the rest"),
        ..parameter
    }
}
