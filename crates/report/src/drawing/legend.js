// The legend of the scene, drawn by the functions that draw the scene.

/** A legend entry: a small drawing and words. */
function entry(words, draw) {
  const canvas = document.createElement("canvas");
  canvas.setAttribute("aria-hidden", "true");
  draw(sized(canvas, 22, 18));
  return element("li", [canvas, words]);
}

// Names of missed items, in the order of a report's reasons.
const MISSED_WORDS = {
  passed_over: "missed: passed over",
  busy: "missed: robots busy",
  grasp_failed: "missed: grasp failed",
  not_found: "missed: not found",
  no_result: "missed: no result",
  unseen: "missed: unseen",
  robot_down: "missed: robot down",
  unreachable: "missed: unreachable",
};

/** The entries for a station whose first robot has this colour. `reasons`: why items can be
 * missed; `leaves`: some are left on purpose; `faults`: robots can be out of service; `camera`:
 * there is a camera. */
function sceneLegend(colour, theme, reasons, leaves, faults, camera) {
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
  const base = (words, down) =>
    entry(words, (ctx) => drawBase(ctx, 11, 9, colour, down, theme));
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
  const looks = entry("where the camera looks", (ctx) => {
    ctx.strokeStyle = theme.ink;
    ctx.lineWidth = 2;
    ctx.setLineDash([2, 4]);
    line(ctx, 11, 1, 11, 17);
  });
  return [
    item("waiting", "waiting"),
    item("claimed, in the robot's colour", "claimed"),
    carried,
    ...reasons.map((reason) => item(MISSED_WORDS[reason], "missed", reason)),
    ...(leaves ? [item("left on the belt on purpose", "left")] : []),
    base("base of a robot", false),
    ...(faults ? [base("robot out of service", true)] : []),
    bin,
    meet,
    workspace,
    ...(camera ? [looks] : []),
  ];
}
