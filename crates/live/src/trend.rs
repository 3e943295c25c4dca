//! Recent rates and utilisation, for the dashboard.

use super::Controller;
use serde::Serialize;
use std::collections::VecDeque;

/// Number of seconds per rate of the trend; the past is kept second by second.
const SECONDS_A_RATE: usize = 10;
/// Length of the last minute [s].
const MINUTE: usize = 60;
/// Number of seconds that are kept.
const KEPT: usize = 600;

/// The events of one second.
#[derive(Debug, Clone, Default)]
struct Second {
    picks: u64,
    /// Time for which each robot was busy [s].
    busy: Vec<f64>,
}

/// The recent past of a line, from the first note on.
#[derive(Debug, Clone, Default)]
pub struct Trend {
    /// Times of the first and the last note [s].
    noted: Option<(f64, f64)>,
    /// Picks of each robot, and whether it was busy, at the last note.
    robots: Vec<(u64, bool)>,
    /// The seconds up to the last note, oldest first.
    seconds: VecDeque<Second>,
}

/// The trend for display.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct TrendView {
    /// Picks per minute over the last minute, or since the first note if that is later [1/min].
    pub picks_per_min: f64,
    /// Share of this time for which each robot was busy, upstream first.
    pub utilisation: Vec<f64>,
    /// Length of this time [s].
    pub span_s: f64,
    /// Time covered by each rate of the trend [s].
    pub step_s: f64,
    /// Picks per minute, oldest first, up to now [1/min].
    pub rates_per_min: Vec<f64>,
}

impl Trend {
    /// Notes the present state of the line.
    pub fn note(&mut self, controller: &Controller) {
        let robots: Vec<(u64, bool)> = controller.workload().collect();
        self.note_robots(controller.now(), robots);
    }

    /// Notes the picks of each robot so far, and whether it is busy, at `now` [s].
    fn note_robots(&mut self, now: f64, robots: Vec<(u64, bool)>) {
        let Some((first, last)) = self.noted else {
            self.noted = Some((now, now));
            self.seconds.push_back(Second::default());
            self.robots = robots;
            return;
        };
        if now < last {
            return;
        }
        // Since the last note every robot stayed in its noted state. Times too old to be kept are
        // skipped.
        let mut from = last.max(now - KEPT as f64);
        if from > last {
            self.seconds.clear();
            self.seconds.push_back(Second::default());
        }
        loop {
            let edge = from.floor() + 1.0;
            let end = edge.min(now);
            self.add(end - from);
            if end == edge {
                self.seconds.push_back(Second::default());
            }
            if end >= now {
                break;
            }
            from = end;
        }
        while self.seconds.len() > KEPT {
            self.seconds.pop_front();
        }
        let total = |robots: &[(u64, bool)]| robots.iter().map(|(picked, _)| picked).sum::<u64>();
        let new = total(&robots).saturating_sub(total(&self.robots));
        if let Some(second) = self.seconds.back_mut() {
            second.picks += new;
        }
        self.noted = Some((first, now));
        self.robots = robots;
    }

    fn add(&mut self, time: f64) {
        let Some(second) = self.seconds.back_mut() else {
            return;
        };
        second.busy.resize(self.robots.len(), 0.0);
        for (busy, (_, is_busy)) in second.busy.iter_mut().zip(&self.robots) {
            if *is_busy {
                *busy += time;
            }
        }
    }

    /// The present trend.
    pub fn view(&self) -> TrendView {
        let Some((first, now)) = self.noted else {
            return TrendView::default();
        };
        let latest = || self.seconds.iter().rev().take(MINUTE);
        let begun = now.floor() + 1.0 - latest().count() as f64;
        let span = now - begun.max(first);
        let per_minute = |picks: u64, time: f64| match time > 0.0 {
            true => 60.0 * picks as f64 / time,
            false => 0.0,
        };
        let busy = |robot: usize| -> f64 {
            let times = latest().filter_map(|second| second.busy.get(robot));
            match span > 0.0 {
                // An empty sum of floats is -0.
                true => (times.fold(0.0, |sum, time| sum + time) / span).min(1.0),
                false => 0.0,
            }
        };
        // Whole steps, ending with the last whole second.
        let seconds: Vec<u64> = self.seconds.iter().map(|second| second.picks).collect();
        let whole = &seconds[..seconds.len() - 1];
        let steps = whole.rchunks_exact(SECONDS_A_RATE);
        let mut rates: Vec<f64> = steps
            .map(|step| per_minute(step.iter().sum(), step.len() as f64))
            .collect();
        rates.reverse();
        TrendView {
            picks_per_min: per_minute(latest().map(|second| second.picks).sum(), span),
            utilisation: (0..self.robots.len()).map(busy).collect(),
            span_s: span,
            step_s: SECONDS_A_RATE as f64,
            rates_per_min: rates,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_and_utilisation_are_those_of_the_last_minute() {
        let mut trend = Trend::default();
        assert_eq!(trend.view(), TrendView::default());
        // A pick per second for 100 s, then one every two seconds; the robot is busy half of the
        // time.
        let mut picked = 0;
        for tenth in 0..=2000_u32 {
            let time = f64::from(tenth) / 10.0;
            let every = if time <= 100.0 { 10 } else { 20 };
            picked += u64::from(tenth > 0 && tenth % every == 0);
            trend.note_robots(time, vec![(picked, tenth % 10 < 5), (0, false)]);
        }
        let view = trend.view();
        assert!((view.picks_per_min - 30.0).abs() < 1.5, "{view:?}");
        assert!((view.utilisation[0] - 0.5).abs() < 0.01 && view.utilisation[1] == 0.0);
        assert!((view.span_s - 60.0).abs() < 1.1);
        assert_eq!(view.rates_per_min.len(), 20);
        assert_eq!(
            (view.rates_per_min[2], view.rates_per_min[15]),
            (60.0, 30.0)
        );
        // Time that jumps ahead, and time that goes back.
        trend.note_robots(1e9, vec![(picked + 1, true), (0, false)]);
        trend.note_robots(5.0, vec![(0, true), (0, false)]);
        let view = trend.view();
        assert!(
            view.picks_per_min <= 1.1 && view.rates_per_min.len() <= 60,
            "{view:?}"
        );
    }
}
