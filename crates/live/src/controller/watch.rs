//! The view for the dashboard.

use super::Controller;
use crate::claims::Claim;
use crate::clock::ClockKind;
use crate::fate::Fate;
use crate::items::Tracked;
use crate::robots::RobotInfo;
use crate::trend::TrendView;
use crate::view::{ClaimView, ItemView, LineView};
use pickline::station::Robot;

/// Maximum number of items in a view besides the claimed ones: a screen has no room for more, and
/// the line must not wait for the view.
const MOST_SHOWN: usize = 2000;
/// How far before and after the belt items are shown [m].
const VIEW_MARGIN: f64 = 0.5;

impl Controller {
    /// The present view of the line, without a trend. `queued` is the number of messages waiting to
    /// be sent.
    pub fn view(&self, queued: u64) -> LineView {
        let travel = self.world.motion().travel(self.stamps.now());
        let mut view = LineView {
            status: self.status(false, queued),
            latency: self.latency(),
            decision_times: self.decider.decision_times(),
            steady: self.stamps.clock.kind == ClockKind::System,
            belt_speed: self.world.motion().speed(),
            belt_travel: travel,
            items: Vec::new(),
            left_out: 0,
            claims: self.show_claims(),
            places: self.show_places(),
            trend: TrendView::default(),
        };
        let end = self.station().belt().length + VIEW_MARGIN;
        let near: Vec<_> = self
            .world
            .items()
            .within(-VIEW_MARGIN - travel, end - travel)
            .collect();
        // Selected by number, so that a shown item stays shown while the count is similar.
        let every = near.len().div_ceil(MOST_SHOWN).max(1) as u32;
        for (item, tracked) in near {
            let (fate, reason) = match self.world.fate(tracked, tracked.place + travel) {
                Fate::Picked => continue,
                Fate::Claimed => ("claimed", None),
                Fate::OnBelt => ("waiting", None),
                Fate::Unwanted => ("left", None),
                other => ("missed", other.reason()),
            };
            if fate == "claimed" || item % every == 0 {
                let robot = self.robot_after(tracked);
                view.items.push(ItemView {
                    id: tracked.id.clone(),
                    x: tracked.place + travel,
                    y: tracked.y,
                    weight: tracked.weight,
                    class: tracked.features.class.clone(),
                    fate,
                    reason,
                    robot,
                });
            } else {
                view.left_out += 1;
            }
        }
        view
    }

    fn robot_after(&self, tracked: &Tracked) -> Option<usize> {
        let task = tracked.claimed_by()?;
        self.tasks.get(task).map(|claim| claim.robot)
    }

    /// Where each arm is when it is free [m]; empty if every robot has only one place.
    fn show_places(&self) -> Vec<[f64; 2]> {
        let robots = self.station().robots();
        if robots.iter().all(|robot| robot.places() == 1) {
            return Vec::new();
        }
        let place = |(robot, (_, info)): (&Robot, (usize, &RobotInfo))| {
            let place = robot.place(usize::from(info.place_of(robot)));
            [place.x, place.y]
        };
        robots.iter().zip(self.fleet.iter()).map(place).collect()
    }

    fn show_claims(&self) -> Vec<ClaimView> {
        let stamp = |time: f64| self.stamp_of(time);
        let claims = self.tasks.holding();
        let robots = self.station().robots();
        let from = |claim: &Claim| {
            let robot = &robots[claim.robot];
            let place = robot.place(usize::from(claim.from));
            (robot.places() > 1).then_some([place.x, place.y])
        };
        let bin = |claim: &Claim| {
            let robot = &robots[claim.robot];
            let bin = &robot.bins[usize::from(claim.bin)];
            (!robot.has_only_bin()).then(|| bin.name.clone())
        };
        let shown = claims.map(|claim| ClaimView {
            task: claim.task,
            revision: claim.revision,
            robot: claim.robot,
            item: self
                .world
                .items()
                .get(claim.item)
                .map(|tracked| tracked.id.clone())
                .unwrap_or_default(),
            stage: claim.stage.name(),
            start: stamp(claim.start),
            meet_at: stamp(claim.meet_at),
            meet: [claim.meet.x, claim.meet.y],
            free_at: stamp(claim.free_at),
            from: from(claim),
            bin: bin(claim),
        });
        shown.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::decode;
    use crate::{ClockKind, Config};
    use pickline::station::built_in;

    fn line() -> Controller {
        let station = built_in("paper").unwrap().station(Some(2)).unwrap();
        let strategy = pickline::strategies::read_alone("SPT,FIFO", 2)
            .unwrap()
            .make();
        let config = Config {
            clock: ClockKind::Messages,
            ..Config::default()
        };
        Controller::new(station, strategy, config).unwrap()
    }

    fn say(line: &mut Controller, fields: &str) {
        let message = decode(format!("{{{fields}}}").as_bytes()).unwrap();
        line.handle(message).unwrap();
    }

    #[test]
    fn items_and_claims_are_shown_as_they_are() {
        let mut line = line();
        say(
            &mut line,
            r#""kind":"robot","stamp":5,"name":"r1","state":"idle""#,
        );
        for (id, x, y) in [("a", 1.0, -0.2), ("b", -0.3, 0.1), ("far", -9.0, 0.0)] {
            let fields = format!(
                r#""kind":"detection","stamp":5,"id":"{id}","x":{x},"y":{y},"class":"<b>""#
            );
            say(&mut line, &fields);
        }
        say(&mut line, r#""kind":"tick","stamp":5.5"#);
        let view = line.view(3);
        assert_eq!(view.status, line.status(false, 3));
        let shown: Vec<_> = view.items.iter().map(|i| (i.id.as_str(), i.fate)).collect();
        assert_eq!(shown, [("a", "claimed"), ("b", "waiting")]);
        assert_eq!(view.items[0].robot, Some(0));
        assert_eq!(view.items[0].class.as_deref(), Some("<b>"));
        assert!((view.items[0].x - 1.025).abs() < 1e-12);
        assert_eq!((view.left_out, view.claims.len()), (0, 1));
        let claim = &view.claims[0];
        assert_eq!((claim.stage, claim.start, claim.robot), ("sent", 5.0, 0));
        assert_eq!(claim.item, "a");
    }

    #[test]
    fn many_items_are_shown_in_part_with_all_claims() {
        let mut line = line();
        say(
            &mut line,
            r#""kind":"robot","stamp":0,"name":"r1","state":"idle""#,
        );
        for i in 0..5000u32 {
            let (x, y) = (
                1.5 - 0.01 * f64::from(i / 50),
                0.01 * f64::from(i % 50) - 0.4,
            );
            say(
                &mut line,
                &format!(r#""kind":"detection","stamp":0,"id":"{i}","x":{x},"y":{y}"#),
            );
        }
        say(&mut line, r#""kind":"tick","stamp":0"#);
        let view = line.view(0);
        assert_eq!(view.items.len() + view.left_out, 5000);
        let (claimed, waiting): (Vec<_>, Vec<_>) =
            view.items.iter().partition(|item| item.fate == "claimed");
        assert_eq!(claimed.len(), 1);
        // 2,000 at most: every third.
        let mut numbers: Vec<u32> = waiting.iter().map(|i| i.id.parse().unwrap()).collect();
        numbers.sort_unstable();
        assert!(numbers.len() >= 1665, "{}", numbers.len());
        assert!(numbers.windows(2).all(|pair| (pair[1] - pair[0]) % 3 == 0));
    }

    #[test]
    fn items_are_shown_half_a_metre_beyond_the_belt() {
        let mut line = line();
        let length = line.station().belt().length;
        let places = [
            ("past", length - 0.4),
            ("last", length - 0.6),
            ("first", -1.4),
            ("before", -1.6),
        ];
        for (id, x) in places {
            let fields = format!(r#""kind":"detection","stamp":0,"id":"{id}","x":{x},"y":0"#);
            say(&mut line, &fields);
        }
        // The belt has moved by 1 m.
        say(&mut line, r#""kind":"tick","stamp":20"#);
        let view = line.view(0);
        let shown: Vec<_> = view.items.iter().map(|i| (i.id.as_str(), i.fate)).collect();
        assert_eq!(shown, [("last", "missed"), ("first", "waiting")]);
    }
}
