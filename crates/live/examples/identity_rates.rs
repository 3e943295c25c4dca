//! Prints the tables of docs/live.md on which item a detection is of:
//! `cargo run --release --example identity_rates`.

// The modules belong to a test.
#![allow(unreachable_pub)]

#[path = "../../../tests/live/support/rates.rs"]
mod rates;
#[path = "../../../tests/live/support/tracker.rs"]
mod tracker;

use rates::{CAMERAS, DISTANCES, TOLERANCES, cell, play, shown, total};

/// Prints ghosts and lost items per 1,000, by tolerance and distance, and what the default
/// follows from: the sums over all of it on worlds of other seeds.
fn main() {
    for (camera, mistakes, name) in CAMERAS {
        println!("ghosts + lost per 1,000 items, {name}\n");
        let heads = DISTANCES.map(|apart| format!("{:.0} mm apart", 1e3 * apart));
        println!("| tolerance [mm] | {} |", heads.join(" | "));
        println!("|---|{}", "---|".repeat(DISTANCES.len()));
        for tolerance in TOLERANCES {
            let cells = DISTANCES.map(|apart| shown(cell(tolerance, apart, camera, mistakes)));
            println!("| {:.0} | {} |", 1e3 * tolerance, cells.join(" | "));
        }
        println!();
    }
    println!("ghosts + lost per 1,000 items, over all distances, other seeds\n");
    println!(
        "| tolerance [mm] | {} | {} | both |",
        CAMERAS[0].2, CAMERAS[1].2
    );
    println!("|---|---|---|---|");
    for tolerance in TOLERANCES {
        let sums = CAMERAS.map(|(camera, mistakes, _)| {
            let runs = DISTANCES.into_iter().flat_map(|apart| {
                let runs = 101..=102;
                runs.map(move |seed| play(tolerance, apart, camera, mistakes, 1000, seed))
            });
            total(runs)
        });
        let both = shown(total(sums.into_iter()));
        let [area, once] = sums.map(shown);
        println!("| {:.0} | {area} | {once} | {both} |", 1e3 * tolerance);
    }
}
