//! The interface of strategies.

use super::snapshot::Snapshot;
use crate::error::{Error, Result};
use crate::station::Station;

/// The answer to a [`Snapshot`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Pick `snapshot.candidates[i]`.
    Pick(usize),
    /// Do nothing before this time [s], which must be in the future.
    WaitUntil(f64),
    /// Do nothing until the next window of an item opens for this robot.
    WaitForNextWindow,
    /// The strategy has no valid answer; [`Strategy::trouble`] gives the reason. A simulation then
    /// ends with an error; a live line assigns no task and continues.
    NoAnswer,
}

/// Decides which robot picks which item. A rule ranks candidates; a strategy decides.
pub trait Strategy {
    /// Answers one decision.
    fn decide(&mut self, snapshot: &Snapshot) -> Action;

    /// The name of the strategy, in command-line form.
    fn name(&self) -> String;

    /// Whether [`Snapshot::in_view`] must be filled, which costs time per decision.
    fn needs_view(&self) -> bool {
        true
    }

    /// Why the last answer was [`Action::NoAnswer`], with the input that led to it.
    fn trouble(&self) -> Option<String> {
        None
    }

    /// What makes the answers of this strategy valid, after "use another strategy, or".
    fn remedy(&self) -> String {
        "fix this one".into()
    }

    /// Checks that the strategy is for a line of this number of robots. By default it is for any
    /// number.
    ///
    /// # Errors
    /// [`Usage`](crate::error::ErrorKind::Usage): the strategy was made for another number.
    fn check_robots(&self, _robots: usize) -> Result<()> {
        Ok(())
    }

    /// Checks that the strategy is for this station. By default, only the number of robots counts.
    ///
    /// # Errors
    /// [`Usage`](crate::error::ErrorKind::Usage): the strategy was made for another station.
    fn check_station(&self, station: &Station) -> Result<()> {
        self.check_robots(station.robots().len())
    }
}

/// The answer of `strategy` to `snapshot`, after checking that the model allows it.
///
/// # Errors
/// If the model does not allow it; the error names the strategy, the decision and what it saw.
pub(crate) fn answer(strategy: &mut dyn Strategy, snapshot: &Snapshot) -> Result<Action> {
    let action = strategy.decide(snapshot);
    let problem = match action {
        Action::Pick(place) if place < snapshot.candidates.len() => return Ok(action),
        Action::WaitUntil(until) if until > snapshot.time => return Ok(action),
        Action::WaitForNextWindow => return Ok(action),
        Action::Pick(place) => format!(
            "it picks candidate {place} of {}",
            snapshot.candidates.len()
        ),
        Action::WaitUntil(until) => format!("it waits until {until} s, which is not later"),
        Action::NoAnswer => strategy
            .trouble()
            .unwrap_or_else(|| "it has no answer".into()),
    };
    let robot = &snapshot.station.robots()[snapshot.robot];
    Err(Error::illegal_action(
        (snapshot.time, &robot.name),
        format!(
            "the strategy {}: {problem}\n  seen: {}",
            strategy.name(),
            snapshot.in_words(),
        ),
        format!("use another strategy, or {}", strategy.remedy()),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decision::Candidate;
    use crate::station::built_in;

    /// Returns a preset answer.
    struct Fixed(Action, Option<&'static str>);

    impl Strategy for Fixed {
        fn decide(&mut self, _: &Snapshot) -> Action {
            self.0
        }

        fn name(&self) -> String {
            "fixed".into()
        }

        fn trouble(&self) -> Option<String> {
            self.1.map(str::to_owned)
        }
    }

    /// A strategy that relies on the default methods.
    struct Defaults;

    impl Strategy for Defaults {
        fn decide(&mut self, _: &Snapshot) -> Action {
            Action::NoAnswer
        }

        fn name(&self) -> String {
            "silent".into()
        }
    }

    fn ask(strategy: &mut dyn Strategy, candidates: usize) -> Result<Action> {
        let station = built_in("paper").unwrap().station(None).unwrap();
        let candidate = |item: u32| Candidate {
            item,
            bin: 0,
            class: crate::station::ClassId::OTHER,
            x0: 0.5 - 0.1 * f64::from(item),
            y: 0.25,
            weight: 1.0,
            open: 0.0,
            close: 9.0,
        };
        let candidates: Vec<Candidate> = (0..candidates as u32).map(candidate).collect();
        let snapshot = Snapshot {
            station: &station,
            time: 3.0,
            robot: 1,
            candidates: &candidates,
            free_at: &[0.0, 0.0],
            places: &[0, 0],
            candidate_odds: &[],
            in_view: &[],
        };
        answer(strategy, &snapshot)
    }

    #[test]
    fn answers_that_the_model_allows_are_passed_on() {
        for action in [
            Action::Pick(0),
            Action::Pick(1),
            Action::WaitUntil(3.5),
            Action::WaitForNextWindow,
        ] {
            assert_eq!(ask(&mut Fixed(action, None), 2).unwrap(), action);
        }
    }

    #[test]
    fn other_answers_are_errors_that_say_what_was_seen() {
        for (action, trouble, problem) in [
            (Action::Pick(2), None, "it picks candidate 2 of 2"),
            (
                Action::WaitUntil(3.0),
                None,
                "it waits until 3 s, which is not later",
            ),
            (
                Action::WaitUntil(2.0),
                Some("unasked"),
                "it waits until 2 s, which is not later",
            ),
            (
                Action::WaitUntil(f64::NAN),
                None,
                "it waits until NaN s, which is not later",
            ),
            (Action::NoAnswer, None, "it has no answer"),
            (Action::NoAnswer, Some("no idea"), "no idea"),
        ] {
            let message = ask(&mut Fixed(action, trouble), 2).unwrap_err().to_string();
            // At 0.05 m/s the items have moved 0.15 m.
            for words in [
                "the strategy fixed: ",
                problem,
                "robot `r2` at t = 3 s, 2 candidates: item 0 at (0.6500, 0.2500) m, item 1 at \
                 (0.5500, 0.2500) m\n",
                "cure: ",
            ] {
                assert!(message.contains(words), "{words} not in {message}");
            }
        }
        // If there are many candidates, only the first are named.
        let message = ask(&mut Fixed(Action::Pick(9), None), 9).unwrap_err();
        let message = message.to_string();
        assert!(message.contains("9 candidates: item 0 at "), "{message}");
        assert!(
            message.contains("item 7 at (-0.0500, 0.2500) m, ...\n"),
            "{message}"
        );
        let message = ask(&mut Fixed(Action::Pick(9), None), 8).unwrap_err();
        let message = message.to_string();
        assert!(
            message.contains("item 7 at (-0.0500, 0.2500) m\n"),
            "{message}"
        );
    }

    #[test]
    fn strategies_observe_and_have_no_trouble_by_default() {
        assert!(Defaults.needs_view());
        assert_eq!(Defaults.trouble(), None);
        assert_eq!(Defaults.remedy(), "fix this one");
        assert!((1..4).all(|robots| Defaults.check_robots(robots).is_ok()));
        let message = ask(&mut Defaults, 1).unwrap_err().to_string();
        assert!(message.contains("silent: it has no answer"), "{message}");
    }

    #[test]
    fn an_idle_robot_is_free_at_once() {
        let station = built_in("paper").unwrap().station(None).unwrap();
        let snapshot = Snapshot {
            station: &station,
            time: 3.0,
            robot: 0,
            candidates: &[],
            free_at: &[1.0, 5.5],
            places: &[0, 0],
            candidate_odds: &[],
            in_view: &[],
        };
        assert_eq!(snapshot.time_until_free(0), 0.0);
        assert_eq!(snapshot.time_until_free(1), 2.5);
    }
}
