//! A world of its own beside `pickline run`: items on a belt, a camera whose tracker makes
//! mistakes, an encoder and three unlike robots, each on a connection of its own, while the
//! node is killed again and again. It shares no code with `pickline emulate`; it knows what is
//! really on the belt and in the bins, to which the node's figures are held.
//!
//!     cargo test --test live world:: -- --nocapture
//!
//! prints what happened.

mod line;
mod node;
mod robot;
mod truth;

use line::{Line, Pace, Settings};

/// 1,000 items with message time: as fast as it goes, and every moment is decided at exactly.
#[test]
fn a_thousand_items_and_thirty_kills() {
    let settings = Settings {
        pace: Pace::Messages,
        items: 1000,
        kills: 30,
        ..Settings::default()
    };
    let figures = Line::play(settings);
    println!("{figures}");
    figures.check();
    assert!(figures.kills >= 30, "{figures}");
    // Most of what the robots can do is done.
    assert!(figures.picked > 850, "{figures}");
    assert!(figures.beside.len() < figures.tasks / 20, "{figures}");
    let noted = &figures.status.noted;
    for trouble in [
        "doubled",
        "id_reused",
        "late_result",
        "renumbered",
        "result_timeout",
    ] {
        assert!(noted.contains_key(trouble), "{trouble} {figures}");
    }
}

/// The same by the machine's clock, which a busy machine makes late: what is counted has to be
/// right all the same.
#[test]
fn by_the_machines_clock() {
    let settings = Settings {
        pace: Pace::Clock,
        items: 50,
        gap: 0.06,
        kills: 8,
        ..Settings::default()
    };
    let figures = Line::play(settings);
    println!("{figures}");
    figures.check();
    assert!(figures.kills >= 8 && figures.picked > 0, "{figures}");
}
