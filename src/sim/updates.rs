//! The times at which decisions are made with an update frequency.

/// `time` [s] rounded up to the next multiple of `1 / hz` seconds.
pub(super) fn next_update(time: f64, hz: f64) -> f64 {
    if hz == 0.0 {
        return time;
    }
    let ticks = time * hz;
    if (ticks - ticks.round()).abs() <= 1e-9 {
        time
    } else {
        ticks.ceil() / hz
    }
}

#[cfg(test)]
mod tests {
    use super::next_update;

    #[test]
    fn times_are_rounded_up_to_the_next_update() {
        for (time, hz, expected) in [
            (0.31, 10.0, 0.4),
            (0.39, 10.0, 0.4),
            (0.3, 10.0, 0.3),
            (0.7, 0.5, 2.0),
            // Half a billionth of a tick counts as rounding, two billionths do not.
            (0.3 + 5e-11, 10.0, 0.3 + 5e-11),
            (0.3 - 5e-11, 10.0, 0.3 - 5e-11),
            (0.3 + 2e-10, 10.0, 0.4),
            (0.3 - 2e-10, 10.0, 0.3),
            (f64::INFINITY, 10.0, f64::INFINITY),
            // At 0 Hz a decision may be made at any time.
            (0.31, 0.0, 0.31),
            (f64::INFINITY, 0.0, f64::INFINITY),
        ] {
            assert_eq!(next_update(time, hz), expected, "{time} s at {hz} Hz");
        }
    }

    /// Regardless of the rounding of the product and of the quotient.
    #[test]
    fn no_update_is_in_the_past() {
        for tick in 0..20_000 {
            for hz in [0.3, 7.0, 10.0, 13.7, 60.0, 1e6] {
                let exact = f64::from(tick) / hz;
                for time in [
                    exact,
                    exact.next_up(),
                    exact.next_down().max(0.0),
                    exact + 0.3 / hz,
                ] {
                    let next = next_update(time, hz);
                    assert!(
                        next >= time && next - time < 1.0 / hz,
                        "{time} s at {hz} Hz"
                    );
                }
            }
        }
    }
}
