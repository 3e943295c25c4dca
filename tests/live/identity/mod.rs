//! Which item a detection is of: by place first, by the tracker's id second.

mod ids;
mod places;
mod rates;
mod restarts;

use crate::support::line::Line;
use pickline_live::protocol::{Detection, Incoming, Status, Task};

/// One picture: ids, where they are at the stamp.
fn picture(line: &mut Line, stamp: f64, shown: &[(Option<&str>, f64, f64)]) {
    for (id, x, y) in shown {
        line.0
            .handle(Incoming::Detection(Detection {
                stamp,
                id: id.map(str::to_owned),
                x: *x,
                y: *y,
                ..Detection::default()
            }))
            .unwrap();
    }
}

fn noted(status: &Status, what: &str) -> u64 {
    status.noted.get(what).copied().unwrap_or(0)
}

/// Has a task acknowledged and done.
fn pick(line: &mut Line, task: &Task) {
    line.ack(task.start, task.id);
    line.result(task.free_at, task.id, "PICKED");
}

/// Items that are shown: name, x at the time now, y.
fn shown(line: &mut Line) -> Vec<(String, f64, f64)> {
    line.0.close_picture();
    let items = line.0.view(0).items.into_iter();
    items.map(|item| (item.id, item.x, item.y)).collect()
}
