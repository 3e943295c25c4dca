//! Recordings of cameras: every form of file, and films of which the truth is known.

mod boxes;
mod camera;
mod film;
mod forms;
mod mot;
mod program;

use pickline::pattern::Pattern;
use pickline::pattern::tracking::{ImageAxis, Import, ImportOptions, Recording, import};
use std::path::Path;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/formats/");

/// The film of the files in [`DATA`]: 25 frames a second, 2 mm a pixel, a belt at 0.25 m/s.
fn options() -> ImportOptions {
    ImportOptions::new(25.0, 0.002, ImageAxis::X, 0.25)
}

fn load(name: &str, options: &ImportOptions) -> Result<Import, String> {
    let recording = Recording::load(Path::new(&format!("{DATA}{name}")));
    let recording = recording.map_err(|error| error.to_string())?;
    import(&recording, name, options).map_err(|error| error.to_string())
}

fn read(text: &str, options: &ImportOptions) -> Result<Import, String> {
    import(&Recording::Text(text.to_owned()), "film.txt", options).map_err(|e| e.to_string())
}

/// Places of items by their order along the belt, and the largest distance [m] between those
/// of two patterns; infinite where they differ in number.
fn apart(one: &Pattern, other: &Pattern) -> f64 {
    if one.len() != other.len() {
        return f64::INFINITY;
    }
    let pairs = one.items().iter().zip(other.items());
    let off = |(a, b): (&pickline::pattern::Item, &pickline::pattern::Item)| {
        (a.x0 - b.x0).abs().max((a.y - b.y).abs())
    };
    pairs.map(off).fold(0.0, f64::max)
}

fn classes(pattern: &Pattern) -> Vec<&str> {
    let items = pattern.items().iter();
    items
        .map(|item| item.class.as_deref().unwrap_or(""))
        .collect()
}

/// The rows of supervision.csv: frame, id, class, and the corners [px].
fn rows() -> Vec<(u32, u32, u32, [f64; 4])> {
    let text = std::fs::read_to_string(format!("{DATA}supervision.csv")).unwrap();
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let corner = |place: usize| fields[place].parse::<f64>().unwrap();
        (
            fields[8].parse().unwrap(),
            fields[6].parse().unwrap(),
            fields[4].parse().unwrap(),
            [0, 1, 2, 3].map(corner),
        )
    };
    text.lines().skip(1).map(row).collect()
}

fn warned(import: &Import, words: &str) -> bool {
    import
        .report
        .warnings
        .iter()
        .any(|warning| warning.contains(words))
}
