//! Steps many environments in parallel, into the caller's buffers.

use super::environment::{DispatchEnvironment, Step, check_scenes};
use super::reward::Reward;
use crate::decision::observation::Layout;
use crate::error::{Error, Result};
use crate::sim::Scene;
use rayon::prelude::*;
use std::ops::Range;

/// Environments that a thread steps together; smaller portions cost more to distribute than to
/// step.
const AT_ONCE: usize = 16;

/// An environment with its action, observation and mask.
type Row<'r, 'a> = (
    ((&'r mut DispatchEnvironment<'a>, &'r usize), &'r mut [f32]),
    &'r mut [bool],
);

/// Environments 0, 1, ... under one seed. Each has its own random numbers, so that no result
/// depends on the number of threads.
#[derive(Debug)]
pub struct Batch<'a> {
    layout: Layout,
    /// The number of the first environment, for messages.
    first: usize,
    environments: Vec<DispatchEnvironment<'a>>,
}

impl<'a> Batch<'a> {
    /// `count` environments on the same scenes.
    ///
    /// # Errors
    /// As for [`DispatchEnvironment::new`].
    pub fn new(
        scenes: &'a [Scene<'a>],
        layout: Layout,
        reward: Reward,
        count: usize,
        seed: u64,
    ) -> Result<Self> {
        Self::part(scenes, layout, reward, 0..count, seed)
    }

    /// Environments `range` of those of [`Batch::new`]. What happens in them does not depend on how they
    /// are divided.
    ///
    /// # Errors
    /// As for [`DispatchEnvironment::new`].
    pub fn part(
        scenes: &'a [Scene<'a>],
        layout: Layout,
        reward: Reward,
        range: Range<usize>,
        seed: u64,
    ) -> Result<Self> {
        let first = range.start;
        let streams: Vec<_> = range.map(|index| (seed, index as u64)).collect();
        let batch = Self::with_streams(scenes, layout, reward, &streams)?;
        Ok(Self { first, ..batch })
    }

    /// Like [`Batch::new`], with one environment for each seed and index in `streams`.
    ///
    /// # Errors
    /// As for [`DispatchEnvironment::new`].
    pub fn with_streams(
        scenes: &'a [Scene<'a>],
        layout: Layout,
        reward: Reward,
        streams: &[(u64, u64)],
    ) -> Result<Self> {
        check_scenes(scenes)?;
        let make = |stream: &_| DispatchEnvironment::on_checked(scenes, layout, reward, *stream);
        Ok(Self {
            layout,
            first: 0,
            environments: streams.iter().map(make).collect(),
        })
    }

    /// The shape of observations and actions.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// The environments, for a caller that needs one of them.
    pub fn environments(&mut self) -> &mut [DispatchEnvironment<'a>] {
        &mut self.environments
    }

    /// Begins an episode in every environment. `observations` [count, observation], `masks`
    /// [count, actions].
    ///
    /// # Panics
    /// The slices have other lengths.
    pub fn reset(&mut self, observations: &mut [f32], masks: &mut [bool]) {
        let (size, actions) = (self.layout.observation(), self.layout.actions());
        assert_eq!(observations.len(), self.environments.len() * size);
        assert_eq!(masks.len(), self.environments.len() * actions);
        self.environments
            .par_iter_mut()
            .with_min_len(AT_ONCE)
            .zip(observations.par_chunks_exact_mut(size))
            .zip(masks.par_chunks_exact_mut(actions))
            .for_each(|((environment, observation), mask)| environment.reset(observation, mask));
    }

    /// Like [`Batch::reset`], but only in the environments of `chosen` [count]; the rows of the others
    /// do not change.
    ///
    /// # Panics
    /// The slices have other lengths.
    pub fn reset_chosen(&mut self, chosen: &[bool], observations: &mut [f32], masks: &mut [bool]) {
        let (size, actions) = (self.layout.observation(), self.layout.actions());
        assert_eq!(chosen.len(), self.environments.len());
        assert_eq!(observations.len(), self.environments.len() * size);
        assert_eq!(masks.len(), self.environments.len() * actions);
        let rows = observations.chunks_exact_mut(size);
        let rows = rows.zip(masks.chunks_exact_mut(actions));
        let all = self.environments.iter_mut().zip(rows).zip(chosen);
        for ((environment, (observation, mask)), _) in all.filter(|(_, chosen)| **chosen) {
            environment.reset(observation, mask);
        }
    }

    /// Checks that [`Batch::step`] would take all of `actions`, so that a caller can refuse them as a
    /// whole.
    ///
    /// # Errors
    /// The first illegal action, or environments in which no episode has begun.
    pub fn check_actions(&mut self, actions: &[usize]) -> Result<()> {
        for (index, (environment, action)) in self.environments.iter_mut().zip(actions).enumerate()
        {
            environment.check_action(*action).map_err(|error| {
                let place = format!("environment {}", self.first + index);
                Error::usage(place, error.problem(), error.cure())
            })?;
        }
        Ok(())
    }

    /// Takes one action in every environment. `actions` and `steps` [count], the others as for
    /// [`Batch::reset`].
    ///
    /// # Errors
    /// The first illegal action. The other actions have been taken.
    ///
    /// # Panics
    /// The slices have other lengths.
    pub fn step(
        &mut self,
        actions: &[usize],
        observations: &mut [f32],
        masks: &mut [bool],
        steps: &mut [Step],
    ) -> Result<()> {
        let (size, wide) = (self.layout.observation(), self.layout.actions());
        let count = self.environments.len();
        assert_eq!((actions.len(), steps.len()), (count, count));
        assert_eq!(observations.len(), count * size);
        assert_eq!(masks.len(), count * wide);
        let one = |(place, ((((environment, action), observation), mask), step)): (
            usize,
            (Row<'_, 'a>, &mut Step),
        )| match environment.step(*action, observation, mask) {
            Ok(done) => {
                *step = done;
                None
            }
            Err(error) => Some((place, error)),
        };
        let wrong = if count <= AT_ONCE {
            let rows = self.environments.iter_mut().zip(actions);
            let rows = rows.zip(observations.chunks_exact_mut(size));
            let rows = rows.zip(masks.chunks_exact_mut(wide)).zip(steps);
            let wrong = rows.enumerate().filter_map(one);
            wrong.min_by_key(|(place, _)| *place)
        } else {
            let rows = self.environments.par_iter_mut().with_min_len(AT_ONCE);
            let rows = rows.zip(actions);
            let rows = rows.zip(observations.par_chunks_exact_mut(size));
            let rows = rows.zip(masks.par_chunks_exact_mut(wide)).zip(steps);
            let wrong = rows.enumerate().filter_map(one);
            wrong.min_by_key(|(place, _)| *place)
        };
        wrong.map_or(Ok(()), |(_, error)| Err(error))
    }
}
