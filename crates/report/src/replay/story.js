// The story of one item: lines of text, never HTML, because ids may contain anything.

const REASONS = {
  unreachable: "unreachable: no robot can reach it",
  grasp_failed: "grasp failed: every attempt failed",
  passed_over: "passed over: a robot could have taken it but chose otherwise",
  unseen: "unseen: once the camera had located it, no robot could leave for it",
  robot_down: "robot down: a robot that could have taken it was down, and no other was free",
  busy: "busy: whenever a robot could have taken it, that robot was busy",
};
const FATE_WORDS = {
  coming: "not on the belt yet",
  waiting: "waiting",
  claimed: "claimed",
  carried: "carried",
  picked: "picked",
  missed: "missed",
  left: "left on the belt",
};
// Maximum numbers of names and robots to list; the others are only counted.
const MOST_NAMES = 3;
const MOST_WINDOWS = 6;

const seconds = (time) => `${time.toFixed(2)} s`;
const place = (x, y) => `(${x.toFixed(3)}, ${y.toFixed(3)}) m`;

/** The lines about `item`, whose current state is `now`; the first is its name. */
function storyOf(run, item, now) {
  const kind = item.class === undefined ? "" : `, ${item.class}`;
  const where = now.fate === "picked" ? "" : ` at ${place(now.x, now.y)}`;
  const lines = [
    `item ${item.id}`,
    `weight ${Number(item.weight.toPrecision(4))}${kind}`,
    `now ${FATE_WORDS[now.fate]}${where}`,
  ];
  for (const failure of item.failures.slice(0, MOST_NAMES)) lines.push(failureLine(run, failure));
  if (item.failures.length > MOST_NAMES) {
    lines.push(`and ${item.failures.length - MOST_NAMES} more failed attempts`);
  }
  const pick = item.pick;
  if (pick) {
    const name = run.robots[pick.robot].name;
    lines.push(`claimed by ${name} at ${seconds(pick.decide_s)}`);
    lines.push(`grasped at ${seconds(pick.grasp_s)} at ${place(...pick.meet)}`);
    lines.push(`released into the bin at ${seconds(pick.release_s)}`);
  } else {
    lines.push(`missed, ${REASONS[item.reason] ?? item.reason}`);
  }
  const until = pick ? pick.decide_s : Infinity;
  const windows = item.windows.filter((window) => window.open < until);
  for (const window of windows.slice(0, MOST_WINDOWS)) lines.push(windowLine(run, window, until));
  if (windows.length > MOST_WINDOWS) {
    lines.push(`and windows of ${windows.length - MOST_WINDOWS} more robots`);
  }
  return lines;
}

function failureLine(run, failure) {
  const name = run.robots[failure.robot].name;
  const how = failure.cause === "grasp" ? "the grasp failed" : "the item was not there";
  const over = seconds(claimEnds(run.robots, failure));
  return `attempted by ${name} at ${seconds(failure.decide_s)}: ${how}, over at ${over}`;
}

/** When a robot could leave for the item, and what it took instead. */
function windowLine(run, window, until) {
  const robot = run.robots[window.robot];
  const last = Math.min(window.close, until);
  const first = countUpTo(robot.trips, window.open, (trip) => trip.decide_s);
  const others = [];
  for (let i = Math.max(0, first - 1); i < robot.trips.length; i += 1) {
    const { decide_s: time, item } = robot.trips[i];
    if (time > last || time >= until) break;
    if (time >= window.open) others.push(item);
  }
  const names = others.slice(0, MOST_NAMES).join(", ");
  const more = others.length > MOST_NAMES ? ` and ${others.length - MOST_NAMES} more` : "";
  const took = others.length ? `took ${names}${more} instead` : "took nothing else";
  return `${robot.name} could leave for it from ${seconds(window.open)} to ${seconds(last)}, ${took}`;
}
