// The line now: turns a view, which the node sends (crates/live/src/view.rs), into a state for
// scene.js to draw, at the moment shown.

// How far a view is extrapolated at most [s] if the clock runs by itself. Beyond that, nothing
// is made up.
const CARRIED_ON = 1;

/** The timestamp [s] to show `passed` seconds after `view` came. */
function stampNow(view, passed) {
  return view.status.stamp + (view.steady ? Math.min(Math.max(passed, 0), CARRIED_ON) : 0);
}

/** The task that each robot is on: its newest one that is not being cancelled. */
function newestClaims(line, view) {
  const newest = line.robots.map(() => null);
  for (const claim of view.claims) {
    if (claim.stage !== "cancelling" && claim.robot < newest.length) newest[claim.robot] = claim;
  }
  return newest;
}

/** The arm of `robot`; `place` is where it is when it is free, if that is not always its only bin. */
function armNow(robot, claim, report, place, now) {
  const down = report.state === "fault";
  const picked = report.picked;
  const trip = claim && {
    decide_s: claim.start,
    grasp_s: claim.meet_at,
    release_s: claim.free_at,
    meet: claim.meet,
    item: claim.item,
    from: claim.from,
    bin: claim.bin,
  };
  // A task is known before the robot leaves for it.
  const [x, y] = trip?.from ?? place ?? robot.bin;
  const resting = { ...armOnTrip(robot, null, now), x, y };
  if (!trip || down) return { ...resting, picked, down };
  // The robot has not acknowledged the task, but its destination is known.
  if (claim.stage === "sent") return { ...resting, meet: trip.meet, picked, down };
  return { ...armOnTrip(robot, trip, now), picked, down };
}

/** The state `passed` seconds after `view` came. */
function stateNow(line, view, passed) {
  const now = stampNow(view, passed);
  const moved = view.belt_speed * (now - view.status.stamp);
  const claims = newestClaims(line, view);
  const arms = line.robots.map((robot, i) =>
    armNow(robot, claims[i], view.status.robots[i], view.places?.[i], now),
  );
  const items = view.items.map((item) => {
    const state = { ...item, x: item.x + moved, robot: item.robot ?? null };
    const arm = arms[state.robot];
    if (item.fate === "waiting" && state.x < 0) state.fate = "coming";
    if (item.fate === "claimed" && arm && arm.item === item.id && arm.phase !== "out") {
      Object.assign(state, { fate: "carried", x: arm.x, y: arm.y });
    }
    return state;
  });
  return { travel: view.belt_travel + moved, speed: view.belt_speed, items, arms };
}

/** What a robot is doing, in words. */
function doing(report, claim, arm) {
  const item = claim ? `item ${claim.item}` : "";
  if (report.state === "fault") return "is out of service";
  if (report.state === "unknown") return "has not been heard yet";
  if (report.state === "silent") return "has not reported its result";
  if (!claim) return report.state === "busy" ? "is busy" : "is waiting";
  if (claim.stage === "sent") return `has been sent to ${item}`;
  const words = {
    out: "is on its way to",
    grasp: "is grasping",
    back: "is bringing back",
    release: "is releasing",
    idle: "has yet to report on",
  };
  return `${words[arm.phase]} ${item}`;
}

/** The lines of text about an item; the first is its name. */
function storyNow(line, item) {
  const kind = item.class === undefined ? "" : `, ${item.class}`;
  const lines = [
    `item ${item.id}`,
    `weight ${Number(item.weight.toPrecision(4))}${kind}`,
    `at (${item.x.toFixed(3)}, ${item.y.toFixed(3)}) m`,
  ];
  if (item.fate === "missed") lines.push(MISSED_WORDS[item.reason] ?? `missed: ${item.reason}`);
  else if (item.fate === "left") lines.push("left on the belt on purpose");
  else lines.push(item.robot === null ? item.fate : `${item.fate} by ${line.robots[item.robot].name}`);
  return lines;
}
