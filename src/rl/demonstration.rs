//! Episodes of any strategy, as the environment would have shown them: data for learning offline.

use super::reward::Reward;
use crate::decision::observation::{Encoder, Layout};
use crate::decision::{Action, Figures, Strategy, answer};
use crate::error::{Error, Result};
use crate::sim::{Run, Scene};

/// One episode of a strategy, with a row for each decision whose answer is an action of the
/// environment.
///
/// A strategy may do what the environment has no action for: take an item that is in no slot, or
/// wait where waiting is no action. It is done, and has no row. Its reward belongs to the row
/// before it, or to the first one, so that the rewards add up to those of the run. A wait of any
/// length is the action to wait.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Demonstration {
    /// Observations [rows + 1, observation]; nobody decides at the end, so the last one is zero.
    pub observations: Vec<f32>,
    /// Masks [rows + 1, actions]; the last one allows nothing.
    pub masks: Vec<bool>,
    /// The strategy's actions [rows].
    pub actions: Vec<usize>,
    /// Rewards [rows].
    pub rewards: Vec<f64>,
    /// Number of decisions that have no row.
    pub left_out: usize,
    /// The figures of the run.
    pub figures: Figures,
}

impl Demonstration {
    /// Plays `strategy` on `scene` to the end, and looks before every decision whether to `go_on`.
    ///
    /// # Errors
    /// The strategy acts illegally, or [`Interrupted`](crate::error::ErrorKind::Interrupted).
    pub fn play(
        scene: &Scene,
        strategy: &mut dyn Strategy,
        (layout, reward): (Layout, Reward),
        go_on: impl Fn() -> bool,
    ) -> Result<Self> {
        let mut encoder = Encoder::new(layout);
        let mut observation = vec![0.0; layout.observation()];
        let mut mask = vec![false; layout.actions()];
        let (mut observations, mut masks) = (Vec::new(), Vec::new());
        let (mut actions, mut rewards) = (Vec::new(), Vec::new());
        let (mut left_out, mut before) = (0, 0.0);
        let mut run = Run::new(scene);
        while let Some(snapshot) = run.next_decision() {
            if !go_on() {
                return Err(Error::interrupted());
            }
            let chosen = answer(strategy, &snapshot)?;
            encoder.encode(&snapshot, &mut observation, &mut mask);
            let index = encoder.index_of(chosen);
            let weight = match chosen {
                Action::Pick(place) => snapshot.candidates[place].weight,
                Action::WaitUntil(_) | Action::WaitForNextWindow | Action::NoAnswer => 0.0,
            };
            let is_picked = run.act(chosen)?.is_some();
            let paid = if is_picked {
                reward.of_pick(weight)
            } else {
                0.0
            };
            if let Some(index) = index {
                observations.extend_from_slice(&observation);
                masks.extend_from_slice(&mask);
                actions.push(index);
                rewards.push(paid + std::mem::take(&mut before));
            } else {
                left_out += 1;
                *rewards.last_mut().unwrap_or(&mut before) += paid;
            }
        }
        let figures = run.figures();
        if let Some(last) = rewards.last_mut() {
            *last += reward.of_end(&figures);
        }
        observations.resize(observations.len() + layout.observation(), 0.0);
        masks.resize(masks.len() + layout.actions(), false);
        Ok(Self {
            observations,
            masks,
            actions,
            rewards,
            left_out,
            figures,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decision::Snapshot;
    use crate::decision::observation::View;
    use crate::dispatch::RuleAssignment;
    use crate::pattern::grid;
    use crate::rl::DispatchEnvironment;
    use crate::sim::{simulate, simulate_rules};
    use crate::station::built_in;
    use crate::strategies::read_alone;

    /// Waits at its first decision, then takes the first or the last candidate, which may be in no slot
    /// if there are few of them.
    struct Hesitant {
        waits: bool,
        takes_last: bool,
    }

    impl Strategy for Hesitant {
        fn decide(&mut self, snapshot: &Snapshot) -> Action {
            if std::mem::take(&mut self.waits) {
                return Action::WaitUntil(snapshot.time + 0.5);
            }
            Action::Pick(if self.takes_last {
                snapshot.candidates.len() - 1
            } else {
                0
            })
        }

        fn name(&self) -> String {
            "hesitant".into()
        }
    }

    /// What rules do are actions of the environment, and the environment answers with the same
    /// observations, masks, rewards and end.
    #[test]
    fn the_environment_shows_the_same_episode() {
        let station = built_in("paper").unwrap().station(Some(2)).unwrap();
        let pattern = grid(station.belt().width, 0.15, 50).unwrap();
        let scenes = [Scene::new(&station, &pattern).unwrap()];
        let rules: RuleAssignment = "SPT,FIFO".parse().unwrap();
        let layout = Layout::new(View::Full, 16, false).unwrap();
        let mut strategy = read_alone("SPT,FIFO", 2).unwrap().make();
        let shown = Demonstration::play(
            &scenes[0],
            strategy.as_mut(),
            (layout, Reward::PAPER),
            || true,
        )
        .unwrap();
        assert_eq!(
            shown.figures,
            simulate_rules(&scenes[0], &rules).unwrap().figures
        );
        assert_eq!(shown.left_out, 0);
        let mut environment =
            DispatchEnvironment::new(&scenes, layout, Reward::PAPER, (1, 0)).unwrap();
        let mut observation = vec![0.0; layout.observation()];
        let mut mask = vec![false; layout.actions()];
        environment.reset(&mut observation, &mut mask);
        let rows = shown.observations.chunks_exact(layout.observation());
        let rows = rows.zip(shown.masks.chunks_exact(layout.actions()));
        let mut rows = rows.map(|(observation, mask)| (observation.to_vec(), mask.to_vec()));
        assert_eq!(rows.next().unwrap(), (observation.clone(), mask.clone()));
        let mut ended = None;
        for (action, reward) in shown.actions.iter().zip(&shown.rewards) {
            assert_eq!(ended, None);
            let step = environment
                .advance(*action, &mut observation, &mut mask)
                .unwrap();
            assert_eq!(step.reward, *reward);
            ended = step.ended;
            assert_eq!(rows.next().unwrap(), (observation.clone(), mask.clone()));
        }
        assert_eq!(ended, Some(shown.figures));
        assert_eq!(rows.next(), None);
    }

    #[test]
    fn what_is_no_action_is_done_and_has_no_row() {
        let station = built_in("paper").unwrap().station(Some(1)).unwrap();
        let pattern = grid(station.belt().width, 0.15, 30).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        let all = Reward {
            pick: 2.0,
            rate: 3.0,
        };
        let mut some_are_beyond = false;
        for (waits, takes_last) in [(false, false), (true, false), (true, true), (false, true)] {
            for (slots, wait) in [(2, false), (2, true), (256, false), (256, true)] {
                let make = || Hesitant { waits, takes_last };
                let layout = Layout::new(View::Full, slots, wait).unwrap();
                let shown =
                    Demonstration::play(&scene, &mut make(), (layout, all), || true).unwrap();
                let outcome = simulate(&scene, &mut make()).unwrap();
                let case = format!("{waits} {takes_last} {slots} {wait}");
                assert_eq!(shown.figures, outcome.figures, "{case}");
                let decisions = outcome.picks.len() + usize::from(waits);
                assert_eq!(shown.actions.len() + shown.left_out, decisions, "{case}");
                assert!(!shown.actions.is_empty(), "{case}");
                let is_left_out = waits && !wait;
                assert!(shown.left_out >= usize::from(is_left_out), "{case}");
                // There is a slot for every item.
                if slots == 256 {
                    assert_eq!(shown.left_out, usize::from(is_left_out), "{case}");
                }
                some_are_beyond |= shown.left_out > 1;
                let sum: f64 = shown.rewards.iter().sum();
                let due = 2.0 * outcome.figures.weight + 3.0 * outcome.figures.weighted_rate();
                assert!((sum - due).abs() < 1e-9 * due, "{case}: {sum} {due}");
                for (row, action) in shown.actions.iter().enumerate() {
                    assert!(shown.masks[row * layout.actions() + action], "{case}");
                }
            }
        }
        assert!(some_are_beyond);
    }
}
