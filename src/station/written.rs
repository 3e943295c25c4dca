//! The station as text.

use super::arm_keys;
use super::geometry::Station;
use super::robot::Robot;
use crate::files::fingerprint;
use nalgebra::Point2;
use std::fmt::Write as _;

/// Hash of a station's resolved values, independent of how they were given.
pub fn station_hash(station: &Station) -> String {
    fingerprint(to_toml(station))
}

/// The station as TOML with every value resolved. [`parse`](super::parse) reads it back as an
/// equal station.
pub fn to_toml(station: &Station) -> String {
    let belt = station.belt();
    let mut text = format!(
        "[belt]\nspeed = {:?}\nlength = {:?}\nwidth = {:?}\n",
        belt.speed, belt.length, belt.width
    );
    for robot in station.robots() {
        write_robot(&mut text, robot);
    }
    for class in station.classes() {
        // Writing to a String cannot fail.
        let _ = write!(text, "\n[[class]]\nname = {}\n", quoted(&class.name));
        if class.value != 1.0 {
            let _ = writeln!(text, "value = {:?}", class.value);
        }
        if !class.wanted {
            text += "wanted = false\n";
        }
    }
    text
}

fn quoted(text: &str) -> toml::Value {
    toml::Value::String(text.to_owned())
}

fn write_robot(text: &mut String, robot: &Robot) {
    // Adding 0 makes a negative zero positive.
    let point = |at: Point2<f64>| format!("[{:?}, {:?}]", at.x + 0.0, at.y + 0.0);
    let first = &robot.bins[0];
    let only = robot.has_only_bin();
    let mut line = |key: &str, value: String| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{key} = {value}");
    };
    line("\n[[robot]]\nname", quoted(&robot.name).to_string());
    line("base", point(robot.base));
    if only {
        line("bin", point(first.at));
    }
    line("reach", format!("{:?}", robot.reach));
    for (key, value) in arm_keys::write(&robot.arm) {
        line(key, value);
    }
    line("grasp_time", format!("{:?}", robot.grasp_time));
    line("release_time", format!("{:?}", first.release_time));
    if robot.rest != first.at {
        line("rest", point(robot.rest));
    }
    if only {
        return;
    }
    for bin in &robot.bins {
        line("\n[[robot.bin]]\nname", quoted(&bin.name).to_string());
        line("at", point(bin.at));
        if let Some(classes) = &bin.classes {
            let names: Vec<String> = classes.iter().map(|c| quoted(c).to_string()).collect();
            line("classes", format!("[{}]", names.join(", ")));
        }
        if bin.release_time != first.release_time {
            line("release_time", format!("{:?}", bin.release_time));
        }
    }
}
