// The page around the drawings: figures, tables, legend, provenance. Every figure is a
// <data> element: rounded for people, its exact value in the attribute.

const byName = (id) => document.getElementById(id);

function element(name, content, className) {
  const made = document.createElement(name);
  made.append(...(Array.isArray(content) ? content : [content]));
  if (className) made.className = className;
  return made;
}

/** `value` x `factor`, shown with `digits` behind the point, exact as the data's value. */
function figure(name, value, digits, factor = 1) {
  const data = element("data", (factor * value).toFixed(digits));
  data.value = String(value);
  data.dataset.name = name;
  return data;
}

function fillFigures(run) {
  const { report } = run;
  byName("title").textContent = `Replay of ${report.strategy}`;
  const checked = report.checked ? "; confirmed by the independent checker" : "";
  byName("subtitle").textContent = `${report.made.patterns}; station ${report.made.station}${checked}`;
  document.title = `${report.strategy} - pickline replay`;
  const unit = (words) => element("small", ` ${words}`);
  const n = (name, digits, factor) => figure(name, report[name], digits, factor);
  const missed = figure("missed", report.missed.length, 0);
  const rows = [
    ["picked", [n("picked", 0), unit("of "), n("items", 0)]],
    ["picked share", [n("picked_share", 1, 100), unit("%")]],
    ["missed", [missed]],
    ["end of the run", [n("end_s", 1), unit("s")]],
    ["picking rate", [n("picking_rate_per_min", 2), unit("/min")]],
    ["weighted rate", [n("weighted_rate_per_min", 2), unit("/min")]],
  ];
  const { bound } = report;
  if (bound) {
    const certified = figure("bound.certified_percent", bound.certified_percent, 1);
    const most = figure("bound.picks_upper_bound", bound.picks_upper_bound, 0);
    rows.push(
      ["certified: at least", [certified, unit("% of the best")]],
      ["no strategy picks more than", [most]],
    );
    if (bound.picking_rate_upper_bound_per_min !== null) {
      // Rounded up, so that it stays a bound.
      const rate = bound.picking_rate_upper_bound_per_min;
      const shown = figure("bound.picking_rate_upper_bound_per_min", Math.ceil(100 * rate) / 100, 2);
      shown.value = String(rate);
      rows.push(["no strategy is faster than", [shown, unit("/min")]]);
    }
  }
  byName("figures").replaceChildren(
    ...rows.map(([name, value]) => element("div", [element("dt", name), element("dd", value)])),
  );
}

function fillTable(table, header, rows) {
  const head = header.map((name) => {
    const cell = element("th", name);
    cell.scope = "col";
    return cell;
  });
  const body = rows.map((cells) => element("tr", cells.map((cell) => element("td", cell))));
  table.replaceChildren(element("thead", element("tr", head)), element("tbody", body));
}

function fillTables(run) {
  const { report } = run;
  const robots = report.robots.map((robot, i) => {
    const swatch = element("span", "", "swatch");
    swatch.style.background = run.robots[i].colour;
    const of = (name, digits, factor) => figure(`robot.${i}.${name}`, robot[name], digits, factor);
    return [
      [swatch, robot.name],
      of("picked", 0),
      of("weight", 2),
      of("failed", 0),
      of("busy_s", 1),
      of("utilisation", 1, 100),
    ];
  });
  const header = ["robot", "picked", "weight", "failed", "busy [s]", "utilisation [%]"];
  fillTable(byName("robots"), header, robots);
  const reasons = Object.entries(report.missed_by_reason);
  fillTable(
    byName("missed"),
    ["reason", "items"],
    reasons.map(([name, count]) => [name.replace("_", " "), figure(`missed.${name}`, count, 0)]),
  );
  const { made } = report;
  const facts = [
    ["station", `${made.station} (hash ${made.station_hash})`],
    ["patterns", made.patterns],
    ...(made.conditions ? [["conditions", made.conditions.join("; ")]] : []),
    ["seed", String(made.seed)],
    ["made by", made.program],
    ["command", made.command],
  ];
  byName("provenance").replaceChildren(
    ...facts.flatMap(([name, value]) => [
      element("dt", name),
      element("dd", value, name === "command" ? "code" : undefined),
    ]),
  );
}

/** A legend's entry: a small drawing and words. */
function entry(words, draw) {
  const canvas = document.createElement("canvas");
  canvas.setAttribute("aria-hidden", "true");
  draw(sized(canvas, 22, 18));
  return element("li", [canvas, words]);
}

/** The legends, drawn by what draws the scene. */
function fillLegends(run, theme) {
  const colour = run.robots[0].colour;
  const item = (words, fate, reason) =>
    entry(words, (ctx) =>
      drawItem(ctx, 11, 9, 4, { fate, reason }, fate === "claimed" ? colour : null, theme),
    );
  const carried = entry("carried by it", (ctx) => {
    ctx.strokeStyle = colour;
    ctx.fillStyle = colour;
    ctx.lineWidth = 3;
    line(ctx, 1, 17, 11, 8);
    circle(ctx, 11, 8, 5.5);
    ctx.fill();
  });
  const bin = entry("bin, resting position", (ctx) => {
    ctx.strokeStyle = colour;
    ctx.lineWidth = 2;
    ctx.strokeRect(3, 4, 16, 10);
  });
  const base = entry("base of a robot", (ctx) => {
    circle(ctx, 11, 9, 7);
    ctx.fillStyle = colour;
    ctx.fill();
  });
  const meet = entry("meeting point", (ctx) => {
    ctx.strokeStyle = colour;
    ctx.lineWidth = 1.5;
    line(ctx, 7, 9, 15, 9);
    line(ctx, 11, 5, 11, 13);
  });
  const workspace = entry("workspace", (ctx) => {
    ctx.globalAlpha = 0.13;
    ctx.fillStyle = colour;
    ctx.fillRect(1, 2, 20, 14);
    ctx.globalAlpha = 0.8;
    ctx.strokeStyle = colour;
    ctx.setLineDash([5, 4]);
    ctx.strokeRect(1.5, 2.5, 19, 13);
  });
  byName("legend").replaceChildren(
    item("waiting", "waiting"),
    item("claimed, in the robot's colour", "claimed"),
    carried,
    item("missed: passed over", "missed", "passed_over"),
    item("missed: robots busy", "missed", "busy"),
    ...(run.report.made.conditions
      ? [
          item("missed: grasp failed", "missed", "grasp_failed"),
          item("missed: unseen", "missed", "unseen"),
        ]
      : []),
    item("missed: unreachable", "missed", "unreachable"),
    base,
    bin,
    meet,
    workspace,
  );
  const block = (words, alpha) =>
    entry(words, (ctx) => {
      ctx.globalAlpha = alpha;
      ctx.fillStyle = colour;
      ctx.fillRect(3, 3, 16, 12);
    });
  const failed = entry("attempt that failed", (ctx) => drawFailed(ctx, 3, 3, 19, 12, colour));
  const stroke = (words, shade, width) =>
    entry(words, (ctx) => {
      ctx.strokeStyle = shade;
      ctx.lineWidth = width;
      line(ctx, 1, 9, 21, 9);
    });
  byName("strip-legend").replaceChildren(
    block("on the way out", PHASE_ALPHA.out),
    block("grasp and release", PHASE_ALPHA.grasp),
    block("on the way back", PHASE_ALPHA.back),
    ...(run.report.failures.length ? [failed] : []),
    stroke("picks per minute since the start", theme.ink, 2),
    stroke(`over the last ${RATE_WIDTH} s`, theme.faint, 1),
  );
}
