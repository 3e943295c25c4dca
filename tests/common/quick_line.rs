//! A line that is quick enough for a test by the clock.

use std::fs;
use std::path::Path;

/// Writes its `station.toml` into `folder`, and a `pattern.csv` of so many items for it.
pub fn write(folder: &Path, items: u32) {
    let robot = |name: &str, x: f64| {
        format!(
            "[[robot]]\nname = \"{name}\"\nbase = [{x}, 0.6]\nbin = [{x}, 0.7]\nreach = 1.0\n\
             speed = 4.0\ngrasp_time = 0.1\nrelease_time = 0.1\n"
        )
    };
    let belt = "[belt]\nspeed = 0.4\nlength = 4.0\nwidth = 1.0\n";
    let station = [belt, &robot("r1", 1.2), &robot("r2", 2.8)].concat();
    fs::write(folder.join("station.toml"), station).unwrap();
    let mut csv = String::from("id,x,y\n");
    for i in 0..items {
        let (x, y) = (-0.12 * f64::from(i), 0.1 * f64::from(i % 5) - 0.2);
        csv += &format!("i{i},{x},{y}\n");
    }
    fs::write(folder.join("pattern.csv"), csv).unwrap();
}
