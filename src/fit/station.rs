//! The station with the fitted laws.

use super::line_fit::LineFit;
use super::model::NO_LIMIT;
use crate::error::{Error, Result};
use crate::station::{Robot, Station};

/// `station` with the arms and dwell times of `fit`; robots without moves stay as they are.
///
/// # Errors
/// A fitted arm that is slower than the belt somewhere, or times that tell no speed.
pub fn fitted_station(station: &Station, fit: &LineFit) -> Result<Station> {
    let robots = station.robots().iter().zip(&fit.arms);
    let robots = robots.map(|(robot, fitted)| {
        let Some(fitted) = fitted else {
            return Ok(robot.clone());
        };
        if fitted.arm.law.top_speed() >= Some(NO_LIMIT) {
            return Err(Error::input(
                format!("robot `{}`", robot.name),
                "its times do not grow with the length of the way, so they tell no speed",
                "record ways of more lengths, or fit 'law' table, which needs the times of the grasps",
            ));
        }
        let mut bins = robot.bins.clone();
        for (bin, release_time) in bins.iter_mut().zip(&fitted.release_times) {
            bin.release_time = *release_time;
        }
        Ok(Robot {
            arm: fitted.arm.clone(),
            grasp_time: fitted.grasp_time,
            bins,
            ..robot.clone()
        })
    });
    let fitted = Station::new(*station.belt(), robots.collect::<Result<_>>()?)?;
    fitted.with_classes(station.classes().to_vec())
}
