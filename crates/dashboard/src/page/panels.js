// The figures and tables around the drawing. Only what has changed is rebuilt.

const filled = new Map();

/** Calls `fill` if `data` has changed since the last call under this name. */
function refresh(name, data, fill) {
  const key = JSON.stringify(data);
  if (filled.get(name) === key) return;
  filled.set(name, key);
  fill();
}

/** The number of missed items, over all reasons. */
function missedInAll(status) {
  return Object.values(status.missed).reduce((sum, count) => sum + count, 0);
}

/** Share of items picked, of the wanted ones that are no longer on the belt or claimed. */
function settledShare(status) {
  const settled = status.seen - status.on_belt - status.claimed - (status.unwanted ?? 0);
  return settled > 0 ? status.picked / settled : 0;
}

function showFigures(view) {
  const { status, latency } = view;
  const unit = (words) => element("small", ` ${words}`);
  const n = (name, digits, factor) => figure(name, status[name], digits, factor);
  const milliseconds = (name) => [figure(`latency.${name}`, latency[name], 3), unit("ms")];
  const decisions = figure("latency.decisions", latency.decisions, 0);
  const refused = Object.values(status.rejected).reduce((sum, count) => sum + count, 0);
  fillList(byName("figures"), [
    ["picked", [n("picked", 0), unit("of "), n("seen", 0)]],
    // Only items whose fate is known count: one on the belt may still be picked.
    ["picked share", [figure("settled_share", settledShare(status), 1, 100), unit("% of finished")]],
    ["rate, last minute", [figure("trend.picks_per_min", view.trend.picks_per_min, 1), unit("/min")]],
    ["rate, since the start", [n("picks_per_min", 2), unit("/min")]],
    ["missed", [figure("missed", missedInAll(status), 0)]],
    ["on the belt", [n("on_belt", 0)]],
    ["claimed", [n("claimed", 0)]],
    ...(status.unwanted === undefined ? [] : [["left on purpose", [n("unwanted", 0)]]]),
    ["belt", [figure("belt_speed", view.belt_speed, 3), unit("m/s")]],
    ["decision, median", [...milliseconds("p50_ms"), unit("of "), decisions]],
    ["decision, 99 %", milliseconds("p99_ms")],
    ["decision, slowest", milliseconds("max_ms")],
    ["messages to send", [n("queued", 0)]],
    ["refused messages", [figure("refused", refused, 0)]],
  ]);
}

const ROBOT_COLUMNS = [
  "robot",
  "state",
  "activity",
  "picked",
  "failed",
  "utilisation, last minute [%]",
];

function showRobots(line, view, state) {
  const claims = newestClaims(line, view);
  const rows = view.status.robots.map((report, i) => {
    const words = doing(report, claims[i], state.arms[i]);
    const use = view.trend.utilisation[i] ?? 0;
    return { report, words, use, colour: line.robots[i].colour };
  });
  refresh("robots", rows, () => {
    const cells = rows.map(({ report, words, use, colour }, i) => {
      const swatch = element("span", "", "swatch");
      swatch.style.background = colour;
      const count = (name) => figure(`robot.${i}.${name}`, report[name], 0);
      const share = figure(`trend.utilisation.${i}`, use, 0, 100);
      return [[swatch, report.name], report.state, words, count("picked"), count("failed"), share];
    });
    fillTable(byName("robots"), ROBOT_COLUMNS, cells);
  });
}

function showClaims(line, view) {
  refresh("claims", view.claims, () => {
    const rows = view.claims.map((claim) => [
      String(claim.task),
      line.robots[claim.robot].name,
      claim.item,
      claim.revision > 0 ? `${claim.stage}, sent ${claim.revision + 1} times` : claim.stage,
      `(${claim.meet[0].toFixed(2)}, ${claim.meet[1].toFixed(2)})`,
    ]);
    fillTable(byName("claims"), ["task", "robot", "item", "stage", "meets at [m]"], orNone(rows));
  });
}

function orNone(rows) {
  return rows.length ? rows : [["none"]];
}

/** A table of counts by name. */
function showCounts(name, header, counts) {
  refresh(name, counts, () => {
    const rows = Object.entries(counts).map(([what, count]) => [
      what.replaceAll("_", " "),
      figure(`${name}.${what}`, count, 0),
    ]);
    fillTable(byName(name), header, orNone(rows));
  });
}

/** Shows `view`; `state` is the state drawn from it. */
function showPanels(line, view, state) {
  const { status } = view;
  const rate = view.trend.picks_per_min;
  refresh("figures", [status, view.latency, view.belt_speed, rate], () => showFigures(view));
  showRobots(line, view, state);
  showClaims(line, view);
  showCounts("missed", ["reason", "items"], status.missed);
  showCounts("rejected", ["reason", "messages"], status.rejected);
  showCounts("noted", ["event", "count"], status.noted);
}
