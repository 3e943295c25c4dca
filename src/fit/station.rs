//! The station with the fitted laws.

use super::line_fit::LineFit;
use crate::error::Result;
use crate::station::{Robot, Station};

/// `station` with the arms and dwell times of `fit`; robots without moves stay as they are.
///
/// # Errors
/// A fitted arm that is slower than the belt somewhere.
pub fn fitted_station(station: &Station, fit: &LineFit) -> Result<Station> {
    let robots = station.robots().iter().zip(&fit.arms);
    let robots = robots.map(|(robot, fitted)| {
        let Some(fitted) = fitted else {
            return robot.clone();
        };
        let mut bins = robot.bins.clone();
        for (bin, release_time) in bins.iter_mut().zip(&fitted.release_times) {
            bin.release_time = *release_time;
        }
        Robot {
            arm: fitted.arm.clone(),
            grasp_time: fitted.grasp_time,
            bins,
            ..robot.clone()
        }
    });
    let fitted = Station::new(*station.belt(), robots.collect())?;
    fitted.with_classes(station.classes().to_vec())
}
