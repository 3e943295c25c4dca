//! The offset between the timestamps of a source and the node's time.

/// How far a timestamp may be in the future [s]. No message comes before it is sent, so more means
/// that the source's clock is ahead.
const AHEAD: f64 = 0.02;
/// Up to this [s] it is treated as drift and followed at once.
const DRIFT: f64 = 0.25;
/// A first timestamp at most this far ahead or behind [s] is accepted.
const FIRST_AHEAD: f64 = 5.0;
const FIRST_BEHIND: f64 = crate::clock::OLDEST;
/// Timestamps that go back by more than this [s] may mean that the source's clock was set.
const BACK: f64 = 0.25;
/// This many messages in a row that agree within [`AGREE`] [s], and are [`APART`] [s] apart,
/// confirm that it was.
const CONFIRMED: u32 = 3;
/// More messages are needed if timestamps go back, and over a longer time [s], because some may only
/// be late: a camera sends pictures again after it was cut off, one after the other without a pause.
/// Such a backlog catches up. A clock that was set back stays behind.
const CONFIRMED_BACK: u32 = 5;
const LASTS: f64 = 0.5;
const AGREE: f64 = 0.1;
const APART: f64 = 0.01;
/// After a step of the node's own clock, a source is mapped with the shift that fits its messages
/// better by this much [s].
const BETTER: f64 = 0.03;
const NEAR: f64 = 0.5;
/// After this many fitting messages, other shifts are forgotten.
const SETTLED: u32 = 20;
/// The smallest delay is taken over the last one to two of these windows [s].
const WINDOW: f64 = 15.0;

/// The smallest value over the recent past.
#[derive(Debug, Clone, Copy, Default)]
struct Floor {
    /// Start of the present window [s], its smallest value, and that of the window before.
    began: f64,
    now: Option<f64>,
    before: Option<f64>,
}

impl Floor {
    fn note(&mut self, time: f64, value: f64) {
        if time - self.began > WINDOW {
            let is_old = time - self.began > 2.0 * WINDOW;
            self.before = self.now.take().filter(|_| !is_old);
            self.began = time;
        }
        self.now = Some(self.now.map_or(value, |least| least.min(value)));
    }

    fn least(&self) -> Option<f64> {
        self.now.into_iter().chain(self.before).reduce(f64::min)
    }
}

/// Consecutive messages that agree on another offset.
#[derive(Debug, Clone, Copy)]
struct Pending {
    /// The smallest and the largest shift that they show [s].
    least: f64,
    most: f64,
    /// When the first of them was received [s].
    since: f64,
    stamp: f64,
    received: f64,
    count: u32,
}

/// How a timestamp is judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum StampJudgement {
    /// With the present shift it is plausible or late.
    Fits,
    /// The source's clock was set by this much [s], and the shift has followed.
    Stepped(f64),
    /// The source's clock has been ahead by this much [s] from its first message on, more than
    /// transmission explains, and the shift has followed.
    Off(f64),
    /// It is in the future, or its first one too old, and is not confirmed yet.
    Wild,
}

/// The offset of a source, which added to its timestamps gives the node's time.
///
/// A delay is the arrival time of a message minus its timestamp. It is the sum of clock offset and
/// transmission delay, which cannot be told apart: a camera that needs 150 ms for a picture looks
/// like one whose clock is 150 ms behind. So timestamps are accepted unchanged if they are
/// possible. Only the impossible is mapped: timestamps in the future, and steps. The smallest
/// recent delay is what a status shows.
#[derive(Debug, Clone, Default)]
pub(super) struct Offset {
    shift: f64,
    floor: Floor,
    /// The newest timestamp [s], unmapped.
    newest: Option<f64>,
    /// Shifts from before the node's own clock was set.
    others: Vec<f64>,
    fits: u32,
    pending: Option<Pending>,
}

impl Offset {
    /// The offset of a new source, whose clock is assumed to be ahead like the machine's, by
    /// `ahead` [s].
    pub(super) fn new(ahead: f64) -> Self {
        Self {
            shift: -ahead,
            ..Self::default()
        }
    }

    /// What is added to a timestamp [s].
    pub(super) fn shift(&self) -> f64 {
        self.shift
    }

    /// The smallest recent delay [s], after the shift.
    pub(super) fn delay(&self) -> Option<f64> {
        self.floor.least()
    }

    /// The smallest delay [s] once enough messages have shown it.
    pub(super) fn settled_delay(&self) -> Option<f64> {
        self.floor.least().filter(|_| self.fits >= SETTLED)
    }

    /// The node's own clock was set by `step` [s]. The source is assumed to use the same clock,
    /// unless its next messages show otherwise.
    pub(super) fn follow(&mut self, step: f64) {
        self.others.push(self.shift);
        if self.others.len() > 4 {
            self.others.remove(0);
        }
        self.shift -= step;
        self.newest = self.newest.map(|newest| newest + step);
        (self.fits, self.pending) = (0, None);
    }

    /// Judges a message with the timestamp `stamp` [s] that arrived at `received` [s], in the
    /// node's time.
    pub(super) fn judge(&mut self, stamp: f64, received: f64) -> StampJudgement {
        let delay = received - (stamp + self.shift);
        let Some(floor) = self.floor.least() else {
            return self.judge_first(stamp, received, delay);
        };
        let off = (delay - floor).abs();
        let others = self.others.iter().copied();
        let best = others
            .map(|shift| (shift, (received - (stamp + shift) - floor).abs()))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((shift, other)) = best
            && other < NEAR
            && other + BETTER < off
        {
            return self.step(shift, stamp, received);
        }
        if delay < -DRIFT {
            let found = self.confirm(received - stamp - floor, stamp, received);
            if found.count >= CONFIRMED {
                return self.step(found.least, stamp, received);
            }
            return StampJudgement::Wild;
        }
        let goes_back = self.newest.is_some_and(|newest| stamp < newest - BACK);
        if goes_back && delay > floor + BACK {
            // Either a late message, or the first one after the clock was set back.
            let found = self.confirm(received - stamp - floor, stamp, received);
            if found.count >= CONFIRMED_BACK && received - found.since >= LASTS {
                return self.step(found.least, stamp, received);
            }
            return StampJudgement::Fits;
        }
        self.fit(stamp, received, delay);
        StampJudgement::Fits
    }

    fn judge_first(&mut self, stamp: f64, received: f64, delay: f64) -> StampJudgement {
        if !(-FIRST_AHEAD..=FIRST_BEHIND).contains(&delay) {
            let found = self.confirm(received - stamp, stamp, received);
            if found.count >= CONFIRMED {
                return self.step(found.least, stamp, received);
            }
            return StampJudgement::Wild;
        }
        self.fit(stamp, received, delay);
        StampJudgement::Fits
    }

    fn fit(&mut self, stamp: f64, received: f64, mut delay: f64) {
        if delay < -AHEAD {
            self.shift += delay;
            delay = 0.0;
        }
        self.floor.note(received, delay);
        self.newest = Some(self.newest.map_or(stamp, |newest| newest.max(stamp)));
        self.pending = None;
        self.fits = self.fits.saturating_add(1);
        if self.fits >= SETTLED {
            self.others.clear();
        }
    }

    fn step(&mut self, shift: f64, stamp: f64, received: f64) -> StampJudgement {
        let by = self.shift - shift;
        let is_first = self.newest.is_none();
        self.others.retain(|other| *other != shift);
        self.others.push(self.shift);
        (self.shift, self.newest, self.fits) = (shift, Some(stamp), 0);
        self.fit(stamp, received, received - (stamp + shift));
        if is_first {
            StampJudgement::Off(by)
        } else {
            StampJudgement::Stepped(by)
        }
    }

    /// The messages in a row that agree on `shift`, this one included.
    fn confirm(&mut self, shift: f64, stamp: f64, received: f64) -> Pending {
        // All of them have to agree with each other. If each had to agree with the one before only,
        // those of a backlog, which are less and less late, would agree on anything.
        let agrees = |pending: &Pending| shift.max(pending.most) - shift.min(pending.least) < AGREE;
        let mut pending = self.pending.filter(agrees).unwrap_or(Pending {
            least: shift,
            most: shift,
            since: received,
            stamp: f64::NEG_INFINITY,
            received: f64::NEG_INFINITY,
            count: 0,
        });
        if stamp > pending.stamp && received >= pending.received + APART {
            (pending.stamp, pending.received) = (stamp, received);
            pending.count += 1;
        }
        // The smallest delay is nearest to the offset.
        (pending.least, pending.most) = (pending.least.min(shift), pending.most.max(shift));
        self.pending = Some(pending);
        pending
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A source that sends every 50 ms, with a delay of 2 to 8 ms.
    struct SimulatedClocks {
        time: f64,
        offset: Offset,
        /// By how much its clock is ahead [s].
        ahead: f64,
    }

    impl SimulatedClocks {
        fn new() -> Self {
            let mut world = Self {
                time: 100.0,
                offset: Offset::new(0.0),
                ahead: 0.0,
            };
            assert_eq!(world.run(40), vec![StampJudgement::Fits; 40]);
            world
        }

        /// Sends a message: how it is judged, and the error of its mapped timestamp [s].
        fn say(&mut self) -> (StampJudgement, f64) {
            self.time += 0.05;
            let way = 0.002 + 0.006 * (self.time * 37.0).fract();
            let stamp = self.time + self.ahead;
            let judged = self.offset.judge(stamp, self.time + way);
            (judged, stamp + self.offset.shift() - self.time)
        }

        fn run(&mut self, messages: usize) -> Vec<StampJudgement> {
            (0..messages).map(|_| self.say().0).collect()
        }
    }

    #[test]
    fn possible_stamps_are_used_unchanged() {
        let world = SimulatedClocks::new();
        assert_eq!(world.offset.shift(), 0.0);
        let delay = world.offset.delay().unwrap();
        assert!((0.002..0.004).contains(&delay), "{delay}");
        // Half a second late, all of them or one: a property of the camera.
        let mut slow = Offset::new(0.0);
        for i in 0..100 {
            let stamp = 0.05 * f64::from(i);
            assert_eq!(slow.judge(stamp, stamp + 0.5), StampJudgement::Fits);
        }
        assert_eq!(slow.shift(), 0.0);
        assert_eq!(slow.judge(2.0, 5.45), StampJudgement::Fits);
        assert!((slow.delay().unwrap() - 0.5).abs() < 1e-9);
    }

    #[test]
    fn with_the_nodes_clock_a_source_steps_at_once() {
        for step in [-5.0, 100.0, 0.2, -0.2] {
            let mut world = SimulatedClocks::new();
            world.offset.follow(step);
            world.ahead += step;
            for _ in 0..50 {
                let (judged, off) = world.say();
                assert!(
                    judged == StampJudgement::Fits && off.abs() < 1e-9,
                    "{judged:?} {off}"
                );
            }
            // A source with another clock does not step, from its first message on.
            let mut other = SimulatedClocks::new();
            other.offset.follow(step);
            let (judged, off) = other.say();
            assert!(
                matches!(judged, StampJudgement::Stepped(_)) && off.abs() < 1e-9,
                "{judged:?}"
            );
            assert_eq!(other.run(50), vec![StampJudgement::Fits; 50]);
            // There and back.
            other.offset.follow(-step);
            let (_, off) = other.say();
            assert!(off.abs() < 1e-9, "{off}");
        }
    }

    #[test]
    fn a_source_that_steps_alone_is_followed_after_some_messages() {
        for step in [-5.0, 7.0, 1000.0] {
            let mut world = SimulatedClocks::new();
            world.ahead += step;
            let judged = world.run(20);
            let stepped = judged
                .iter()
                .position(|j| matches!(j, StampJudgement::Stepped(_)));
            let expected = if step > 0.0 { 2..=2 } else { 10..=11 };
            assert!(
                stepped.is_some_and(|stepped| expected.contains(&stepped)),
                "{step}: {judged:?}"
            );
            let (_, off) = world.say();
            assert!(off.abs() < 0.01, "{off}");
        }
    }

    #[test]
    fn one_wild_stamp_moves_nothing_and_a_burst_is_late() {
        let mut world = SimulatedClocks::new();
        let time = world.time;
        assert_eq!(world.offset.judge(time + 3.0, time), StampJudgement::Wild);
        assert_eq!(world.offset.judge(time - 20.0, time), StampJudgement::Fits);
        assert_eq!(world.run(5), vec![StampJudgement::Fits; 5]);
        // The network delays two seconds of messages.
        let held = world.time;
        for i in 1..=40 {
            let stamp = held + 0.05 * f64::from(i);
            let judged = world.offset.judge(stamp, held + 2.0 + 1e-4 * f64::from(i));
            assert_eq!(judged, StampJudgement::Fits);
        }
        assert_eq!(world.offset.shift(), 0.0);
    }

    /// A camera that was cut off sends its pictures of the last seconds again, as fast as the node,
    /// or the way to it, takes them. Newer ones had arrived before.
    #[test]
    fn pictures_that_are_sent_again_are_late() {
        for apart in [0.02, 0.05, 0.1, 0.2] {
            for faster in [1.5, 3.0, 8.0, 100.0] {
                for cut_off in [0.3, 1.0, 10.0] {
                    let mut world = SimulatedClocks::new();
                    let mut received = world.time + 0.05;
                    let mut stamp = world.time - cut_off;
                    while stamp < received {
                        let judged = world.offset.judge(stamp, received);
                        let case = format!("{apart} {faster} {cut_off}: {}", received - stamp);
                        assert_eq!(judged, StampJudgement::Fits, "{case}");
                        stamp += apart;
                        received += apart / faster;
                    }
                    assert_eq!(world.offset.shift(), 0.0);
                    world.time = received;
                    assert_eq!(world.run(40), vec![StampJudgement::Fits; 40]);
                }
            }
        }
    }

    #[test]
    fn a_clock_that_is_ahead_is_mapped_to_now() {
        let mut offset = Offset::new(0.0);
        assert_eq!(offset.judge(103.0, 100.0), StampJudgement::Fits);
        assert_eq!(offset.shift(), -3.0);
        // A clock that is an hour ahead is mapped after three messages.
        let mut offset = Offset::new(0.0);
        let judged = [0.0, 0.1, 0.2].map(|t| offset.judge(3700.0 + t, 100.0 + t));
        assert_eq!(judged[..2], [StampJudgement::Wild; 2]);
        assert!((offset.shift() + 3600.0).abs() < 1e-9, "{judged:?}");
    }

    /// After a step of the node's clock it is still known which stamp was the newest: a source
    /// that was set back itself is found out, and one that is slow from then on is not.
    #[test]
    fn what_is_late_after_a_step_of_the_nodes_clock() {
        let mut world = SimulatedClocks::new();
        world.offset.follow(100.0);
        world.ahead += 100.0 - 5.0;
        let judged = world.run(20);
        let stepped = judged
            .iter()
            .position(|j| matches!(j, StampJudgement::Stepped(_)));
        assert!(
            stepped.is_some_and(|stepped| (10..=11).contains(&stepped)),
            "{judged:?}"
        );
        let mut world = SimulatedClocks::new();
        world.offset.follow(-100.0);
        for _ in 0..20 {
            world.time += 0.05;
            let judged = world.offset.judge(world.time - 100.0, world.time + 0.5);
            assert_eq!(judged, StampJudgement::Fits);
        }
        assert_eq!(world.offset.shift(), 100.0);
    }
}
