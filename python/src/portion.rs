//! Some of the environments of a batch, which one thread at a time steps.

use crate::crew::Crew;
use pickline::Result as Fallible;
use pickline::decision::observation::Layout;
use pickline::rl::{self, DispatchEnvironment, Reward, Step};
use pickline::sim::{Conditions, Scene};
use rayon::prelude::*;
use self_cell::self_cell;
use std::ops::Range;
use std::sync::Arc;

/// A pattern on its line.
pub(crate) struct Course {
    pub(crate) station: Arc<pickline::Station>,
    pub(crate) pattern: Arc<pickline::Pattern>,
    pub(crate) conditions: Conditions,
}

type Scenes<'a> = Vec<Scene<'a>>;

self_cell!(
    /// Courses with the scenes that borrow them.
    struct OwnedScenes {
        owner: Vec<Course>,
        #[covariant]
        dependent: Scenes,
    }
);

type Environments<'a> = rl::Batch<'a>;

self_cell!(
    /// Scenes with the environments that borrow them.
    struct OwnedEnvironments {
        owner: Arc<OwnedScenes>,
        #[covariant]
        dependent: Environments,
    }
);

/// Environments that a thread steps together; fewer cost more to hand out than to step.
pub(crate) const AT_ONCE: usize = 4;

/// Some of the environments, and the buffers of a step.
pub(crate) struct Portion {
    environments: OwnedEnvironments,
    pub(crate) task: Task,
    actions: Vec<usize>,
    pub(crate) observations: Vec<f32>,
    pub(crate) masks: Vec<bool>,
    pub(crate) steps: Vec<Step>,
    pub(crate) outcome: Fallible<()>,
}

/// What is to be done in a portion.
#[derive(Clone)]
pub(crate) enum Task {
    Step,
    /// A new episode in each environment that is marked.
    Reset(Vec<bool>),
}

impl Course {
    fn scene(&self) -> Fallible<Scene<'_>> {
        Scene::under(&self.station, &self.pattern, self.conditions.clone())
    }
}

impl Portion {
    /// Environments `range` on `scenes`.
    fn new(
        scenes: Arc<OwnedScenes>,
        layout: Layout,
        reward: Reward,
        range: Range<usize>,
    ) -> Fallible<Self> {
        let count = range.len();
        let step = Step {
            reward: 0.0,
            ended: None,
        };
        Ok(Self {
            environments: OwnedEnvironments::try_new(scenes, |scenes| {
                rl::Batch::part(scenes.borrow_dependent(), layout, reward, range, 0)
            })?,
            task: Task::Step,
            actions: vec![0; count],
            observations: vec![0.0; count * layout.observation()],
            masks: vec![false; count * layout.actions()],
            steps: vec![step; count],
            outcome: Ok(()),
        })
    }

    /// `count` environments on `courses`, in portions.
    pub(crate) fn all(
        courses: Vec<Course>,
        layout: Layout,
        reward: Reward,
        count: usize,
    ) -> Fallible<Crew<Self>> {
        reward.check()?;
        let scenes = OwnedScenes::try_new(courses, |courses| {
            courses.par_iter().map(Course::scene).collect()
        })?;
        let scenes = Arc::new(scenes);
        let portion = |first| {
            let range = first..count.min(first + AT_ONCE);
            Self::new(Arc::clone(&scenes), layout, reward, range)
        };
        let portions = (0..count).step_by(AT_ONCE).map(portion);
        Ok(Crew::new(portions.collect::<Fallible<_>>()?, Self::work))
    }

    /// Sets the actions of the next step.
    pub(crate) fn choose(&mut self, actions: &[usize]) -> Fallible<()> {
        self.task = Task::Step;
        self.actions.copy_from_slice(actions);
        self.environments
            .with_dependent_mut(|_, batch| batch.check_actions(actions))
    }

    /// Does what is to be done.
    fn work(&mut self) {
        let Self {
            environments,
            task,
            actions,
            observations,
            masks,
            steps,
            outcome,
        } = self;
        *outcome = environments.with_dependent_mut(|_, batch| match task {
            Task::Step => batch.step(actions, observations, masks, steps),
            Task::Reset(chosen) => {
                batch.reset_chosen(chosen, observations, masks);
                Ok(())
            }
        });
    }

    /// Calls `work` with environment `index`.
    pub(crate) fn with<T>(
        &mut self,
        index: usize,
        work: impl FnOnce(&mut DispatchEnvironment) -> T,
    ) -> T {
        self.environments
            .with_dependent_mut(|_, batch| work(&mut batch.environments()[index]))
    }
}

/// Writes rewards and ends, and the counts and values of the episodes that are over.
pub(crate) fn write_steps(
    steps: &[Step],
    (rewards, ended): (&mut [f64], &mut [bool]),
    (counts, values): (&mut [i64], &mut [f64]),
) {
    let rows = counts.chunks_exact_mut(2).zip(values.chunks_exact_mut(4));
    let flags = rewards.iter_mut().zip(ended);
    for ((step, (reward, ended)), (counts, values)) in steps.iter().zip(flags).zip(rows) {
        *reward = step.reward;
        *ended = step.ended.is_some();
        if let Some(figures) = &step.ended {
            counts.copy_from_slice(&[figures.items as i64, figures.picked as i64]);
            let (rate, weighted) = (figures.picking_rate(), figures.weighted_rate());
            values.copy_from_slice(&[figures.weight, figures.end, rate, weighted]);
        } else {
            counts.fill(0);
            values.fill(0.0);
        }
    }
}
