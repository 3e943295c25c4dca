//! How often an item is taken for another one, or two for one.

use crate::support::rates::{CAMERAS, cell, play, shown, total};
use pickline_live::Config;

/// The rates of the default tolerance that docs/live.md states, on worlds that are neither of
/// the table nor of those that it was chosen by.
#[test]
fn the_default_tolerance_holds_its_rates() {
    let tolerance = Config::default().tolerance;
    // A camera that sees each item once cannot tell neighbours 20 mm apart from its noise.
    for ((camera, mistakes, name), most_lost) in CAMERAS.into_iter().zip([1.0, 10.0]) {
        let runs =
            [0.02, 0.05, 0.2].map(|apart| play(tolerance, apart, camera, mistakes, 700, 201));
        let all = total(runs.into_iter());
        let (ghosts, lost) = (all.per_thousand(all.ghosts), all.per_thousand(all.lost));
        assert!(ghosts <= 16.0 && lost <= most_lost, "{name}: {all:?}");
    }
}

/// The tables of docs/live.md, which the example `identity_rates` prints, cell by cell of the
/// default tolerance at a distance.
#[test]
fn the_tables_of_the_docs_show_the_rates() {
    let docs = include_str!("../../../docs/live.md").to_lowercase();
    let tolerance = Config::default().tolerance;
    for (camera, mistakes, name) in CAMERAS {
        let table = docs.split_once(&format!("\n{name}:\n")).unwrap().1;
        let row = format!("\n| {:.0} | ", 1e3 * tolerance);
        let row = table.split_once(&row).unwrap().1.lines().next().unwrap();
        // The last column.
        let shown = shown(cell(tolerance, 0.2, camera, mistakes));
        let is_last = row.ends_with(&format!(" | {shown} |"));
        assert!(is_last, "{name}: {shown} is not at the end of {row}");
    }
}
