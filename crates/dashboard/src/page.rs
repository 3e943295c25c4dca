//! The page that shows a live line. Its sources are in `page/`. Its scripts share one scope with
//! those of `drawing/`, which are loaded first. The order is:
//!
//! | file | what it is |
//! |---|---|
//! | `now.js` | turns a view into the state to draw |
//! | `trend.js` | the graph of the picking rate over the last minutes |
//! | `panels.js` | the figures and tables around the drawing |
//! | `dashboard.js` | the stream of views, the pointer, drawing |

use pickline::station::Station;
use pickline_report::drawing::{self, RobotData, robots_data};
use serde::Serialize;

/// The page. It requests `dashboard.css`, `dashboard.js` and the stream `events`.
pub const DASHBOARD_PAGE: &str = include_str!("page/page.html");

const STYLE: &str = include_str!("page/style.css");
const SCRIPTS: [&str; 4] = [
    include_str!("page/now.js"),
    include_str!("page/trend.js"),
    include_str!("page/panels.js"),
    include_str!("page/dashboard.js"),
];

/// The style sheet of the page.
pub fn dashboard_style() -> String {
    [drawing::BASE_STYLE, drawing::STYLE, STYLE].concat()
}

/// The scripts of the page, joined into one.
pub fn dashboard_script() -> String {
    let scripts = [drawing::SCRIPTS.concat(), SCRIPTS.concat()].concat();
    format!("(() => {{\n\"use strict\";\n{scripts}}})();\n")
}

/// What the page needs to know about the line once: the event `line`, as JSON.
#[derive(Serialize)]
struct LineData<'a> {
    program: String,
    station: &'a str,
    strategy: &'a str,
    belt: DashboardBelt,
    robots: Vec<RobotData<'a>>,
}

#[derive(Serialize)]
struct DashboardBelt {
    length: f64,
    width: f64,
}

/// The JSON of the event `line`, for `station` (`named` as the user wrote it) under the strategy
/// called `strategy`.
pub fn dashboard_line(station: &Station, named: &str, strategy: &str) -> String {
    let belt = station.belt();
    let line = LineData {
        program: format!("pickline {}", env!("CARGO_PKG_VERSION")),
        station: named,
        strategy,
        belt: DashboardBelt {
            length: belt.length,
            width: belt.width,
        },
        robots: robots_data(station),
    };
    // Text and finite numbers always convert to JSON.
    serde_json::to_string(&line).unwrap_or_default()
}
