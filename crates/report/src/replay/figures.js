// The page around the drawings: figures, tables, legend, provenance.

function fillFigures(run) {
  const { report } = run;
  byName("title").textContent = `Replay of station ${run.station}`;
  const checked = report.checked ? "; confirmed by the independent checker" : "";
  byName("subtitle").textContent = `${report.strategy} on ${report.made.patterns}${checked}`;
  document.title = `${run.station} - pickline replay`;
  const unit = (words) => element("small", ` ${words}`);
  const n = (name, digits, factor) => figure(name, report[name], digits, factor);
  const missed = figure("missed", report.missed.length, 0);
  const rows = [
    ...(report.throughput_per_min === null ? [] : [
      ["throughput", [n("throughput_per_min", 1), unit("/min")]],
      ["flow", [n("flow_per_min", 1), unit("/min")]],
    ]),
    ["picked", [n("picked", 0), unit("of "), n("items", 0)]],
    ["picked share", [n("picked_share", 1, 100), unit("%")]],
    ["missed", [missed]],
    ["end of the run", [n("end_s", 1), unit("s")]],
    ["picking rate", [n("picking_rate_per_min", 2), unit("/min")]],
    ...(report.items_have_attributes
      ? [["weighted rate", [n("weighted_rate_per_min", 2), unit("/min")]]]
      : []),
  ];
  const { clearance } = run;
  if (clearance) {
    const distance = figure("clearance.distance_m", clearance.distance_m, 3);
    const time = figure("clearance.time_s", clearance.time_s, 2);
    const show = element("button", "show", "small");
    show.type = "button";
    show.addEventListener("click", () => seek(clearance.time_s));
    const [one, other] = clearance.robots;
    const words = clearance.distance_m > 0 ? "m between" : "m: collision of";
    const where = element("small", [` ${words} ${one} and ${other} at `, time, " s "]);
    rows.push(["smallest distance between arms", [distance, where, show]]);
  }
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
  fillList(byName("figures"), rows);
}

function fillTables(run) {
  const { report } = run;
  const steady = report.throughput_per_min !== null;
  const robots = report.robots.map((robot, i) => {
    const swatch = element("span", "", "swatch");
    swatch.style.background = run.robots[i].colour;
    const of = (name, digits, factor) => figure(`robot.${i}.${name}`, robot[name], digits, factor);
    return [
      [swatch, robot.name],
      of("picked", 0),
      ...(report.items_have_attributes ? [of("weight", 2)] : []),
      of("failed", 0),
      of("busy_s", 1),
      of("utilisation", 1, 100),
      ...(report.downtimes ? [of("down_s", 1)] : []),
      ...(steady ? [of("utilisation_steady", 1, 100)] : []),
    ];
  });
  const weight = report.items_have_attributes ? ["weight"] : [];
  const header = ["robot", "picked", ...weight, "failed", "busy [s]", "utilisation [%]"];
  if (report.downtimes) header.push("down [s]");
  if (steady) header.push("in the steady state [%]");
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

/** The legends, drawn by the functions that draw the scene. */
function fillLegends(run, theme) {
  const colour = run.robots[0].colour;
  const sometimes = run.report.made.conditions ? ["grasp_failed", "unseen"] : [];
  const outages = run.report.downtimes !== undefined;
  const stopped = outages ? ["robot_down"] : [];
  const reasons = ["passed_over", "busy", ...stopped, ...sometimes, "unreachable"];
  const leaves = Boolean(run.report.unwanted);
  const scene = sceneLegend(colour, theme, reasons, leaves, outages, run.camera !== undefined);
  byName("legend").replaceChildren(...scene);
  const block = (words, alpha) =>
    entry(words, (ctx) => {
      ctx.globalAlpha = alpha;
      ctx.fillStyle = colour;
      ctx.fillRect(3, 3, 16, 12);
    });
  const failed = entry("failed attempt", (ctx) => drawFailed(ctx, 3, 3, 19, 12, colour));
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
    ...(outages ? [entry("down", (ctx) => drawDown(ctx, 3, 3, 19, 12, theme))] : []),
    stroke("picks per minute since the start", theme.ink, 2),
    stroke(`over the last ${RATE_WIDTH} s`, theme.faint, 1),
  );
}
