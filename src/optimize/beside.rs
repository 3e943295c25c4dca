//! The bound with which runs are compared, under the stop flag.

use super::environment::Environment;
use crate::error::{Error, Result};
use crate::planning::bound::{Bound, BoundOptions, upper_bound};
use crate::sim::Scene;

/// The bound for a scene on which the best run picks `picked` items.
///
/// # Errors
/// A pattern for which no bound can be computed, or [`Interrupted`](crate::error::ErrorKind), because the
/// progress at a stop depends on the machine.
pub fn bound_beside(scene: &Scene, picked: usize, environment: &Environment) -> Result<Bound> {
    let options = BoundOptions::beside(picked, scene.pattern().len());
    bound_within(scene, &options, environment)
}

/// The same without bounds on end and rate, which take most of the time.
///
/// # Errors
/// As for [`bound_beside`].
pub(super) fn picks_bound_beside(
    scene: &Scene,
    picked: usize,
    environment: &Environment,
) -> Result<Bound> {
    let options = BoundOptions::beside(picked, scene.pattern().len()).with_ends(false);
    bound_within(scene, &options, environment)
}

/// The bound on the picks of the items that `counted` marks, of which the best run picks `picked`.
///
/// # Errors
/// As for [`bound_beside`].
pub(crate) fn part_bound_beside(
    scene: &Scene,
    counted: Vec<bool>,
    picked: usize,
    environment: &Environment,
) -> Result<Bound> {
    let options = BoundOptions::beside(picked, scene.pattern().len());
    let options = options.with_ends(false).with_counted(counted);
    bound_within(scene, &options, environment)
}

fn bound_within(scene: &Scene, options: &BoundOptions, environment: &Environment) -> Result<Bound> {
    let go_on = &mut |_, _| !environment.stopped();
    let bound = upper_bound(scene, options, go_on)?;
    if environment.stopped() {
        return Err(Error::interrupted());
    }
    Ok(bound)
}
