//! The model page with its disturbances, written down as directly as possible: every decision
//! looks at every robot and every item.

use pickline::decision::{Action, Miss, MissReason};
use pickline::pattern::Item;
use pickline::sim::Conditions;
use pickline::station::{Robot, Station};

/// A decision: robot, item, when, whether it came to a pick.
pub type Recorded = (usize, usize, f64, bool);

/// Who decides: a rule for each robot, or a list of numbers that says when to wait.
pub enum Decider<'a> {
    Rules(&'a [&'static str]),
    Whim(&'a [usize]),
}

/// What decision number `count` is by the list `choices`, with as many candidates.
pub fn by_whim(choices: &[usize], count: usize, time: f64, candidates: usize) -> Action {
    match choices[count % choices.len()] {
        n if n % 5 == 0 => Action::WaitUntil(time + 0.001 * (n + 1) as f64),
        n if n % 5 == 1 => Action::WaitForNextWindow,
        n => Action::Pick(n % candidates),
    }
}

/// The model page written down as directly as possible; only the draws are the engine's.
pub fn transcribed(
    station: &Station,
    items: &[Item],
    decider: Decider,
    conditions: &Conditions,
) -> (Vec<Recorded>, Vec<Miss>) {
    let belt = station.belt();
    let (v, hz, wrong) = (belt.speed, conditions.update_hz, &conditions.disturbances);
    let reported: Vec<(f64, f64)> = items
        .iter()
        .zip(0..)
        .map(|(item, j)| wrong.reported(j, item, belt.width))
        .collect();
    // What is below the threshold is left, as if it were not there.
    let left = |j: &usize| {
        let p = items[*j].p_detection;
        p.is_some_and(|p| p < conditions.min_detection)
    };
    let all = || (0..items.len()).filter(|j| !left(j));
    let window = |r: &Robot, (x0, y): (f64, f64)| -> Option<(f64, f64)> {
        let departure = |x: f64| {
            (x - x0) / v
                - ((x - r.bins[0].at.x).powi(2) + (y - r.bins[0].at.y).powi(2)).sqrt()
                    / r.arm.constant_speed().unwrap()
        };
        let half2 = r.reach.powi(2) - (y - r.base.y).powi(2);
        if half2 < 0.0 {
            return None;
        }
        let x_in = (r.base.x - half2.sqrt()).max(0.0);
        let x_out = (r.base.x + half2.sqrt()).min(belt.length);
        let close = departure(x_out);
        if x_in > x_out || close < 0.0 {
            return None;
        }
        Some((departure(x_in).max(0.0).min(close), close))
    };
    let known = |r: &Robot, at: (f64, f64)| -> Option<(f64, f64)> {
        let (open, close) = window(r, at)?;
        let open = match conditions.camera_x {
            Some(x) => open.max((x - at.0) / v),
            None => open,
        };
        (open <= close).then_some((open, close))
    };
    let tick = |t: f64| {
        let ticks = t * hz;
        if hz == 0.0 || (ticks - ticks.round()).abs() <= 1e-9 {
            t
        } else {
            (ticks.ceil() / hz).max(t)
        }
    };
    let mut free = vec![0.0f64; station.robots().len()];
    // Who waits for the next window, and which claims have still to end, when.
    let mut waits = vec![false; free.len()];
    let mut ending: Vec<(f64, usize)> = Vec::new();
    let mut decisions = 0;
    // From when on each item is unclaimed, and how often it was tried.
    let mut unclaimed_from = vec![0.0f64; items.len()];
    let mut tried = vec![0u32; items.len()];
    let mut offered = vec![false; items.len()];
    let mut told = Vec::new();
    loop {
        let mut next: Option<(f64, usize, Vec<usize>)> = None;
        for (i, robot) in station.robots().iter().enumerate() {
            let windows: Vec<_> = all()
                .filter_map(|j| Some((j, known(robot, reported[j])?)))
                .collect();
            let mut from = free[i];
            let decision = loop {
                let could = windows
                    .iter()
                    .map(|&(j, (open, close))| (open.max(from).max(unclaimed_from[j]), close));
                let could = could.filter(|(first, close)| first <= close);
                let Some(exact) = could.map(|(first, _)| first).reduce(f64::min) else {
                    break None;
                };
                let d = tick(exact);
                let can: Vec<usize> = windows
                    .iter()
                    .filter(|&&(j, (open, close))| {
                        open <= d && d <= close && unclaimed_from[j] <= d
                    })
                    .map(|(j, _)| *j)
                    .collect();
                if can.is_empty() {
                    from = d;
                } else {
                    break Some((d, i, can));
                }
            };
            if let Some(d) = decision
                && next.as_ref().is_none_or(|n| d.0 < n.0)
            {
                next = Some(d);
            }
        }
        ending.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some(&(ends, item)) = ending.first()
            && next.as_ref().is_none_or(|next| ends <= next.0)
        {
            ending.remove(0);
            for (k, robot) in station
                .robots()
                .iter()
                .enumerate()
                .filter(|(k, _)| waits[*k])
            {
                if let Some((open, close)) = known(robot, reported[item])
                    && ends <= close
                {
                    free[k] = free[k].min(open.max(ends));
                }
            }
            continue;
        }
        let Some((t, i, mut can)) = next else {
            break;
        };
        can.iter().for_each(|&j| offered[j] = true);
        let r = &station.robots()[i];
        let travel = |(x0, y): (f64, f64)| {
            let (dx, dy) = (x0 + v * t - r.bins[0].at.x, y - r.bins[0].at.y);
            let k = r.arm.constant_speed().unwrap() * r.arm.constant_speed().unwrap() - v * v;
            (v * dx + ((v * dx) * (v * dx) + k * (dx * dx + dy * dy)).sqrt()) / k
        };
        let processing = |at| 2.0 * travel(at) + r.grasp_time + r.bins[0].release_time;
        let distance = |(x0, y): (f64, f64)| {
            let (dx, dy) = (x0 + v * t - r.base.x, y - r.base.y);
            (dx * dx + dy * dy).sqrt()
        };
        let key = |rule: &str, j: usize| match rule {
            "FIFO" => -(reported[j].0 + v * t),
            "SPT" => processing(reported[j]),
            "LPT" => -processing(reported[j]),
            "SD" => distance(reported[j]),
            "LD" => -distance(reported[j]),
            "PP" => -items[j].reward(),
            other => panic!("no rule {other}"),
        };
        // Furthest downstream first, then by index.
        can.sort_by(|&a, &b| reported[b].0.total_cmp(&reported[a].0).then(a.cmp(&b)));
        decisions += 1;
        let action = match decider {
            Decider::Rules(rules) => {
                let best = (0..can.len()).reduce(|best, place| {
                    let [old, new] = [best, place].map(|place| key(rules[i], can[place]));
                    if new < old { place } else { best }
                });
                Action::Pick(best.unwrap())
            }
            Decider::Whim(choices) => by_whim(choices, decisions, t, can.len()),
        };
        waits[i] = action == Action::WaitForNextWindow;
        let best = match action {
            Action::Pick(place) => can[place],
            Action::WaitUntil(until) => {
                free[i] = until;
                continue;
            }
            _ => {
                let unclaimed = all().filter(|&j| unclaimed_from[j] <= t);
                let opens = unclaimed.filter_map(|j| Some(known(r, reported[j])?.0));
                free[i] = opens.filter(|open| *open > t).fold(f64::INFINITY, f64::min);
                continue;
            }
        };
        let truth = (items[best].x0, items[best].y);
        let there = window(r, truth).is_some_and(|(open, close)| open <= t && t <= close);
        let lucky = wrong.grasp_succeeds(best as u32, &items[best], tried[best]);
        tried[best] += 1;
        let went_to = if there { truth } else { reported[best] };
        free[i] = t + processing(went_to);
        // Without noise the window is the same, but for rounding.
        let picked = (there || wrong.position_noise == 0.0) && lucky;
        unclaimed_from[best] = if picked {
            f64::INFINITY
        } else {
            let ends = t + travel(went_to) + r.grasp_time;
            ending.push((ends, best));
            ends
        };
        told.push((i, best, t, picked));
    }
    let missed = all().filter(|&j| unclaimed_from[j].is_finite());
    let some = |see: &dyn Fn(&Robot) -> bool| station.robots().iter().any(see);
    let missed = missed.map(|j| {
        let reason = if !some(&|robot| window(robot, (items[j].x0, items[j].y)).is_some()) {
            MissReason::Unreachable
        } else if tried[j] > 0 {
            MissReason::GraspFailed
        } else if offered[j] {
            MissReason::PassedOver
        } else if !some(&|robot| known(robot, reported[j]).is_some()) {
            MissReason::Unseen
        } else {
            MissReason::Busy
        };
        let item = j as u32;
        Miss { item, reason }
    });
    let missed = missed.collect();
    (told, missed)
}
