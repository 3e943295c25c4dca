// The run as a function of time: states as scene.js draws them, plus `time` [s], with items in
// the order of the pattern. Nothing here draws or depends on the page.

// "left" is an item that is left on the belt on purpose.
const FATES = ["coming", "waiting", "claimed", "carried", "picked", "missed", "left"];

/** The page's data, with everything precomputed that each moment needs. */
function makeRun(data) {
  const { report, belt, station, camera, clearance } = data;
  // A robot's trips are its picks and failed attempts, in order of time.
  const robots = data.robots.map((robot) => ({ ...robot, picks: [], trips: [], downtimes: [] }));
  for (const down of report.downtimes ?? []) robots[down.robot].downtimes.push(down);
  const items = data.items.map((item, index) => ({
    ...item,
    index,
    pick: null,
    failures: [],
    reason: null,
    lost: Infinity,
  }));
  const byId = new Map(items.map((item) => [item.id, item]));
  for (const pick of report.picks) {
    byId.get(pick.item).pick = pick;
    robots[pick.robot].picks.push(pick);
    robots[pick.robot].trips.push(pick);
  }
  for (const failure of report.failures) {
    byId.get(failure.item).failures.push(failure);
    robots[failure.robot].trips.push(failure);
  }
  for (const robot of robots) {
    robot.trips.sort((a, b) => a.decide_s - b.decide_s);
    robot.trips.forEach((trip, i) => {
      trip.from = i ? binOf(robot, robot.trips[i - 1]).at : robot.bin;
    });
  }
  for (const miss of report.missed) {
    const item = byId.get(miss.item);
    const enters = -item.x0 / belt.speed;
    item.reason = miss.reason;
    const windows = item.windows.map((window) => window.close);
    const tries = item.failures.map((failure) => claimEnds(robots, failure));
    item.lost = [...windows, ...tries].reduce((last, time) => Math.max(last, time), enters);
  }
  for (const left of report.unwanted ?? []) {
    const item = byId.get(left.item);
    item.left = true;
    item.reason = left.reason;
  }
  const releases = report.picks.map((pick) => pick.release_s).sort((a, b) => a - b);
  const attempts = [...report.picks, ...report.failures];
  const decisions = attempts.map((attempt) => attempt.decide_s).sort((a, b) => a - b);
  return { report, clearance, station, camera, belt, robots, items, byId, releases, decisions, end: report.end_s };
}

/** When the failing grasp ends, and with it the claim on the item [s]. */
function claimEnds(robots, failure) {
  return failure.grasp_s + robots[failure.robot].grasp_time;
}

/** How many of the sorted `values` are at most `limit`. */
function countUpTo(values, limit, value = (v) => v) {
  let low = 0;
  let high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (value(values[middle]) <= limit) low = middle + 1;
    else high = middle;
  }
  return low;
}

function armAt(robot, time) {
  const trip = robot.trips[countUpTo(robot.trips, time, (t) => t.decide_s) - 1];
  const picked = countUpTo(robot.picks, time, (pick) => pick.release_s);
  const outage = robot.downtimes[countUpTo(robot.downtimes, time, (down) => down.from_s) - 1];
  const down = outage !== undefined && time < outage.to_s;
  return { ...armOnTrip(robot, trip, time), picked, down };
}

function itemAt(run, item, arms, time) {
  const state = {
    id: item.id,
    x: item.x0 + run.belt.speed * time,
    y: item.y,
    fate: "waiting",
    robot: null,
    reason: null,
  };
  if (item.left) {
    state.fate = state.x < 0 ? "coming" : "left";
    state.reason = item.reason;
    return state;
  }
  const pick = item.pick;
  const failing = item.failures.find(
    (failure) => time >= failure.decide_s && time < claimEnds(run.robots, failure),
  );
  if (failing) {
    state.robot = failing.robot;
    state.fate = "claimed";
  } else if (pick && time >= pick.decide_s) {
    state.robot = pick.robot;
    if (time >= pick.release_s) {
      state.fate = "picked";
      [state.x, state.y] = binOf(run.robots[pick.robot], pick).at;
    } else if (time >= pick.grasp_s) {
      state.fate = "carried";
      state.x = arms[pick.robot].x;
      state.y = arms[pick.robot].y;
    } else {
      state.fate = "claimed";
    }
  } else if (time >= item.lost) {
    state.fate = "missed";
    state.reason = item.reason;
  } else if (state.x < 0) {
    state.fate = "coming";
  }
  return state;
}

/** The state of the whole station at `time` [s]. */
function stateAt(run, time) {
  const arms = run.robots.map((robot) => armAt(robot, time));
  const items = run.items.map((item) => itemAt(run, item, arms, time));
  const { speed } = run.belt;
  return { time, travel: speed * time, speed, items, arms };
}

/** The number of items of `state` with each fate. */
function countFates(state) {
  const counts = Object.fromEntries(FATES.map((fate) => [fate, 0]));
  for (const item of state.items) counts[item.fate] += 1;
  return counts;
}

/** Items in the bins per minute [1/min] from the start to `time` [s]. */
function rateUntil(run, time) {
  return time > 0 ? (60 * countUpTo(run.releases, time)) / time : 0;
}

/** Items in the bins per minute [1/min] over the last `width` seconds before `time`. */
function rateOver(run, time, width) {
  const count = countUpTo(run.releases, time) - countUpTo(run.releases, time - width);
  return (60 * count) / width;
}
