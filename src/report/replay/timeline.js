// The run as a function of time. Nothing here draws or knows of the page.
//
// A state is what scene.js draws, and all that it needs:
//   { time, items: [{ id, x, y, fate, robot, reason }], arms: [{ phase, x, y, meet, item,
//     dwell, picked }] }
// with one item and one arm in the order of the pattern and of the station. Fates:
//   coming   not on the belt yet            waiting  on it, claimed by nobody
//   claimed  a robot is on its way          carried  in the robot's gripper
//   picked   in its bin                     missed   no robot can leave for it any more

const FATES = ["coming", "waiting", "claimed", "carried", "picked", "missed"];

/** The page's data, with what every moment needs found once. */
function makeRun(data) {
  const { report, belt } = data;
  const robots = data.robots.map((robot) => ({ ...robot, picks: [] }));
  const items = data.items.map((item, index) => ({
    ...item,
    index,
    pick: null,
    reason: null,
    lost: Infinity,
  }));
  const byId = new Map(items.map((item) => [item.id, item]));
  for (const pick of report.picks) {
    byId.get(pick.item).pick = pick;
    robots[pick.robot].picks.push(pick);
  }
  for (const miss of report.missed) {
    const item = byId.get(miss.item);
    const enters = -item.x0 / belt.speed;
    item.reason = miss.reason;
    item.lost = item.windows.reduce((last, window) => Math.max(last, window.close), enters);
  }
  const releases = report.picks.map((pick) => pick.release_s).sort((a, b) => a - b);
  const decisions = report.picks.map((pick) => pick.decide_s);
  return { report, belt, robots, items, byId, releases, decisions, end: report.end_s };
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

/** Out along a straight line, grasp, back along the same line, release. */
function armAt(robot, time) {
  const begun = countUpTo(robot.picks, time, (pick) => pick.decide_s);
  const pick = robot.picks[begun - 1];
  const [binX, binY] = robot.bin;
  if (!pick || time >= pick.release_s) {
    return { phase: "idle", x: binX, y: binY, meet: null, item: null, dwell: 0, picked: begun };
  }
  const travel = pick.grasp_s - pick.decide_s;
  const back = pick.grasp_s + robot.grasp_time;
  let phase = "out";
  let way = 0; // share of the way from the bin to the meeting point
  let dwell = 0; // share of the dwell that is over
  if (time < pick.grasp_s) {
    way = (time - pick.decide_s) / travel;
  } else if (time < back) {
    phase = "grasp";
    way = 1;
    dwell = (time - pick.grasp_s) / robot.grasp_time;
  } else if (time < back + travel) {
    phase = "back";
    way = 1 - (time - back) / travel;
  } else {
    phase = "release";
    dwell = Math.min(1, (time - back - travel) / (robot.release_time || 1));
  }
  const [meetX, meetY] = pick.meet;
  return {
    phase,
    x: binX + way * (meetX - binX),
    y: binY + way * (meetY - binY),
    meet: pick.meet,
    item: pick.item,
    dwell,
    picked: begun - 1,
  };
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
  const pick = item.pick;
  if (pick && time >= pick.decide_s) {
    state.robot = pick.robot;
    if (time >= pick.release_s) {
      state.fate = "picked";
      [state.x, state.y] = run.robots[pick.robot].bin;
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
  return { time, items, arms };
}

/** How many items of `state` have which fate. */
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
