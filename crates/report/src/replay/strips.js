// Draws one strip per robot, and the running picking rate below them, over a span of time.
// What does not change with time is drawn once and kept.

const STRIP_TOP = 4;
const RATE_HEIGHT = 84;
const RATE_GAP = 22;
const TIME_AXIS = 38;
// Averaging time of the short-term rate [s].
const RATE_WIDTH = 30;
// Opacity of the robot's colour in each phase.
const PHASE_ALPHA = { out: 0.35, grasp: 1, back: 0.65, release: 1 };

/** Positions on the strips' canvas [px] while `from` to `to` [s] are shown. */
function stripView(run, width, from, to) {
  const robots = run.robots.length;
  const row = Math.max(7, Math.min(24, 240 / robots));
  const left = 108;
  const right = width - 14;
  const rateTop = STRIP_TOP + robots * row + RATE_GAP;
  return {
    width,
    height: rateTop + RATE_HEIGHT + TIME_AXIS,
    from,
    to,
    row,
    left,
    right,
    rateTop,
    x: (time) => left + ((time - from) / (to - from)) * (right - left),
    time: (x) => from + ((x - left) / (right - left)) * (to - from),
  };
}

/** Everything but the cursor. */
function drawStrips(ctx, view, run, theme) {
  ctx.clearRect(0, 0, view.width, view.height);
  run.robots.forEach((robot, i) => drawStrip(ctx, view, robot, i, theme));
  drawRate(ctx, view, run, theme);
  drawTimeAxis(ctx, view, theme);
}

/** The phases of a pick, with their start and end [s]. */
function phases(robot, pick) {
  const back = pick.grasp_s + robot.grasp_time;
  const home = pick.release_s - binOf(robot, pick).release_time;
  return [
    ["out", pick.decide_s, pick.grasp_s],
    ["grasp", pick.grasp_s, back],
    ["back", back, home],
    ["release", home, pick.release_s],
  ];
}

function drawStrip(ctx, view, robot, index, theme) {
  const top = STRIP_TOP + index * view.row;
  const height = view.row - Math.min(4, view.row / 4);
  ctx.fillStyle = theme.belt;
  ctx.fillRect(view.left, top, view.right - view.left, height);
  if (view.row >= 12) {
    ctx.font = SCENE_FONT;
    const name = shortened(ctx, robot.name, view.left - 16);
    text(ctx, name, view.left - 8, top + height / 2, theme.ink, SCENE_FONT, "right");
  }
  ctx.save();
  ctx.beginPath();
  ctx.rect(view.left, top, view.right - view.left, height);
  ctx.clip();
  for (const down of robot.downtimes) {
    const [from, to] = [view.x(down.from_s), view.x(down.to_s)];
    drawDown(ctx, Math.max(from, view.left), top, Math.min(to, view.right), height, theme);
  }
  ctx.fillStyle = robot.colour;
  const first = countUpTo(robot.trips, view.from, (trip) => trip.release_s);
  for (const trip of robot.trips.slice(first)) {
    if (trip.decide_s > view.to) break;
    if (trip.cause === undefined) {
      for (const [phase, from, to] of phases(robot, trip)) {
        ctx.globalAlpha = PHASE_ALPHA[phase];
        ctx.fillRect(view.x(from), top, view.x(to) - view.x(from), height);
      }
    } else {
      const right = view.x(trip.release_s);
      drawFailed(ctx, view.x(trip.decide_s), top, right, height, robot.colour);
    }
    // A seam that separates consecutive trips.
    ctx.globalAlpha = 1;
    ctx.clearRect(view.x(trip.release_s) - 0.5, top, 0.5, height);
  }
  ctx.restore();
}

/** A time in which a robot is down: hatched from edge to edge. */
function drawDown(ctx, left, top, right, height, theme) {
  if (left >= right) return;
  ctx.save();
  ctx.beginPath();
  ctx.rect(left, top, right - left, height);
  ctx.clip();
  ctx.strokeStyle = theme.faint;
  ctx.lineWidth = 1;
  for (let x = left - height; x < right; x += 5) line(ctx, x, top + height, x + height, top);
  ctx.restore();
}

/** A failed attempt: a hollow block with a cross in it. */
function drawFailed(ctx, left, top, right, height, colour) {
  const [x, y] = [left + 1, top + 1];
  const [width, depth] = [Math.max(1, right - left - 2), height - 2];
  ctx.globalAlpha = 1;
  ctx.strokeStyle = colour;
  ctx.lineWidth = 1.5;
  ctx.strokeRect(x, y, width, depth);
  const arm = Math.min(width, depth) / 3;
  const [middle, centre] = [x + width / 2, y + depth / 2];
  line(ctx, middle - arm, centre - arm, middle + arm, centre + arm);
  line(ctx, middle - arm, centre + arm, middle + arm, centre - arm);
}

/** The rates, one per pixel. */
function drawRate(ctx, view, run, theme) {
  const bottom = view.rateTop + RATE_HEIGHT;
  const times = [];
  for (let x = view.left; x <= view.right; x += 1) times.push(view.time(x));
  const settled = times.filter((time) => time >= Math.min(10, run.end / 4));
  const values = settled.map((time) => rateUntil(run, time));
  const recent = times.filter((time) => time >= RATE_WIDTH);
  const recentValues = recent.map((time) => rateOver(run, time, RATE_WIDTH));
  const most = 1.1 * Math.max(1, run.report.picking_rate_per_min, ...values, ...recentValues);
  const y = (rate) => bottom - (rate / most) * RATE_HEIGHT;
  ctx.lineWidth = 1;
  for (const { value, label } of ticks(0, most, 5)) {
    ctx.strokeStyle = theme.belt;
    line(ctx, view.left, y(value), view.right, y(value));
    text(ctx, label, view.left - 8, y(value), theme.faint, SMALL_FONT, "right");
  }
  text(ctx, "picks/min", view.left, view.rateTop - 9, theme.faint, SMALL_FONT, "left");
  const curve = (at, rates, colour, width) => {
    ctx.strokeStyle = colour;
    ctx.lineWidth = width;
    ctx.beginPath();
    rates.forEach((rate, i) => ctx.lineTo(view.x(at[i]), y(rate)));
    ctx.stroke();
  };
  curve(recent, recentValues, theme.faint, 1);
  curve(settled, values, theme.ink, 2);
}

function drawTimeAxis(ctx, view, theme) {
  const y = view.rateTop + RATE_HEIGHT + 0.5;
  ctx.strokeStyle = theme.faint;
  ctx.lineWidth = 1;
  line(ctx, view.left, y, view.right, y);
  const count = Math.min(12, (view.right - view.left) / 70);
  for (const { value, label } of ticks(view.from, view.to, count)) {
    line(ctx, view.x(value), y, view.x(value), y + 4);
    text(ctx, label, view.x(value), y + 12, theme.faint, SMALL_FONT, "center");
  }
  const middle = (view.left + view.right) / 2;
  text(ctx, "time [s]", middle, y + 28, theme.faint, SMALL_FONT, "center");
}

function drawCursor(ctx, view, time, theme) {
  const x = Math.min(Math.max(view.x(time), view.left), view.right);
  ctx.strokeStyle = theme.ink;
  ctx.lineWidth = 1.5;
  line(ctx, x, 0, x, view.rateTop + RATE_HEIGHT);
  ctx.fillStyle = theme.ink;
  circle(ctx, x, view.rateTop + RATE_HEIGHT, 3.5);
  ctx.fill();
}

/** The trip in a strip under (`x`, `y`) [px], if there is one. */
function tripUnder(view, run, x, y) {
  const robot = run.robots[Math.floor((y - STRIP_TOP) / view.row)];
  if (!robot || x < view.left || x > view.right) return undefined;
  const time = view.time(x);
  const trip = robot.trips[countUpTo(robot.trips, time, (t) => t.decide_s) - 1];
  return trip && time < trip.release_s ? trip : undefined;
}
