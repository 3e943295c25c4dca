// Draws the station in one state. Pure: all it knows it is given, so the replay and the
// dashboard draw with it alike.
//
// A state, and all that it needs:
//   { travel, speed, items: [{ x, y, fate, robot, reason }], arms: [{ phase, x, y, meet,
//     dwell, picked, down }] }
// with one arm in the order of the station; travel [m] and speed [m/s] are the belt's.
// Fates:
//   coming   not on the belt yet            waiting  on it, claimed by nobody
//   claimed  a robot is on its way, or      carried  in the robot's gripper
//            fails to grasp it
//   picked   in its bin                     missed   no robot can leave for it any more
// Phases: idle, out, grasp, back, release; what is `down` does not work.
//
// `station` is { belt: { length, width }, robots: [{ name, base, bin, reach,
// colour }] }, in m;
// `theme` the colours { ink, faint, paper, belt, edge, item }.

// Kept free before and after the belt, where items come and go [m].
const ROOM = 0.22;
// For names above and below, and the axis [px].
const NAME_SPACE = 32;
const AXIS_SPACE = 36;

/** Belt frame [m] to canvas [px]: x to the right, y upwards. */
function sceneView(station, width, mostHeight) {
  const { belt, robots } = station;
  const places = robots.flatMap((robot) => [robot.base, robot.bin]);
  const xs = [0, belt.length, ...places.map(([x]) => x)];
  const ys = [-belt.width / 2, belt.width / 2, ...places.map(([, y]) => y)];
  const left = Math.min(...xs) - ROOM;
  const right = Math.max(...xs) + ROOM;
  const bottom = Math.min(...ys);
  const top = Math.max(...ys);
  const others = 2 * NAME_SPACE + AXIS_SPACE;
  const scale = Math.min(width / (right - left), (mostHeight - others) / (top - bottom));
  const margin = (width - scale * (right - left)) / 2;
  return {
    width,
    height: Math.ceil(scale * (top - bottom) + others),
    left,
    right,
    scale,
    radius: Math.min(6, Math.max(2.5, 0.02 * scale)),
    x: (x) => margin + (x - left) * scale,
    y: (y) => NAME_SPACE + (top - y) * scale,
    floor: NAME_SPACE + (top - bottom) * scale + NAME_SPACE,
  };
}

/** Draws `state`; the item with index `marked` gets a ring. */
function drawScene(ctx, view, station, state, theme, marked) {
  ctx.clearRect(0, 0, view.width, view.height);
  drawBelt(ctx, view, station, state, theme);
  station.robots.forEach((robot) => drawWorkspace(ctx, view, station.belt, robot));
  drawAxis(ctx, view, theme);
  drawItems(ctx, view, station, state.items, theme);
  station.robots.forEach((robot, i) => drawArm(ctx, view, robot, state.arms[i], theme));
  drawNames(ctx, view, station, state.arms, theme);
  const item = state.items[marked];
  if (item) {
    ctx.strokeStyle = theme.ink;
    ctx.lineWidth = 1.5;
    circle(ctx, view.x(item.x), view.y(item.y), view.radius + 7);
    ctx.stroke();
  }
}

function beltPath(ctx, view, belt) {
  const y = view.y(belt.width / 2);
  ctx.beginPath();
  ctx.rect(view.x(0), y, belt.length * view.scale, belt.width * view.scale);
}

function drawBelt(ctx, view, station, state, theme) {
  const { belt } = station;
  ctx.save();
  beltPath(ctx, view, belt);
  ctx.fillStyle = theme.belt;
  ctx.fill();
  ctx.clip();
  // Seams that travel with the belt, so that it is seen to move.
  const step = belt.length / Math.min(60, Math.max(2, Math.round(belt.length / 0.5)));
  // Also where the belt has run backwards.
  const shift = ((state.travel % step) + step) % step;
  ctx.strokeStyle = theme.edge;
  ctx.globalAlpha = 0.3;
  ctx.lineWidth = 1;
  for (let x = shift - step; x <= belt.length; x += step) {
    line(ctx, view.x(x), view.y(belt.width / 2), view.x(x), view.y(-belt.width / 2));
  }
  ctx.restore();
  beltPath(ctx, view, belt);
  ctx.strokeStyle = theme.edge;
  ctx.lineWidth = 1;
  ctx.stroke();
  // The direction of travel, beside the belt where no item lies under it.
  const x = view.x(0);
  const y = view.y(belt.width / 2) - 12;
  ctx.strokeStyle = theme.faint;
  ctx.lineWidth = 2;
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.lineTo(x + 36, y);
  ctx.moveTo(x + 28, y - 5);
  ctx.lineTo(x + 36, y);
  ctx.lineTo(x + 28, y + 5);
  ctx.stroke();
  text(ctx, `${Number(state.speed.toPrecision(4))} m/s`, x + 44, y, theme.faint, SMALL_FONT, "left");
}

function drawWorkspace(ctx, view, belt, robot) {
  const place = () =>
    circle(ctx, view.x(robot.base[0]), view.y(robot.base[1]), robot.reach * view.scale);
  ctx.save();
  beltPath(ctx, view, belt);
  ctx.clip();
  place();
  ctx.globalAlpha = 0.13;
  ctx.fillStyle = robot.colour;
  ctx.fill();
  ctx.globalAlpha = 0.8;
  ctx.strokeStyle = robot.colour;
  ctx.lineWidth = 1.2;
  ctx.setLineDash([5, 4]);
  ctx.stroke();
  ctx.restore();
}

function drawItems(ctx, view, station, items, theme) {
  for (const item of items) {
    // What lies in a bin is counted beside it.
    if (item.fate === "picked" || item.x < view.left || item.x > view.right) continue;
    const onBelt = item.x >= 0 && item.x <= station.belt.length;
    ctx.globalAlpha = onBelt || item.fate === "carried" ? 1 : 0.45;
    const colour = item.robot === null ? null : station.robots[item.robot].colour;
    drawItem(ctx, view.x(item.x), view.y(item.y), view.radius, item, colour, theme);
  }
  ctx.globalAlpha = 1;
}

/** One item. Fates differ in shape as well as in colour. */
function drawItem(ctx, x, y, radius, item, colour, theme) {
  if (item.fate === "missed") {
    drawMissed(ctx, x, y, radius, item.reason, theme);
    return;
  }
  circle(ctx, x, y, radius);
  ctx.fillStyle = colour ?? theme.item;
  ctx.fill();
  if (item.fate === "claimed") {
    circle(ctx, x, y, radius + 3);
    ctx.strokeStyle = colour;
    ctx.lineWidth = 1.5;
    ctx.stroke();
  }
}

function drawMissed(ctx, x, y, radius, reason, theme) {
  const r = radius + 0.5;
  ctx.strokeStyle = theme.ink;
  ctx.lineWidth = 1.8;
  ctx.beginPath();
  if (reason === "passed_over") {
    ctx.moveTo(x - r, y - r);
    ctx.lineTo(x + r, y + r);
    ctx.moveTo(x - r, y + r);
    ctx.lineTo(x + r, y - r);
  } else if (reason === "busy") {
    ctx.moveTo(x, y - r);
    ctx.lineTo(x + r, y + r);
    ctx.lineTo(x - r, y + r);
    ctx.closePath();
  } else if (reason === "grasp_failed") {
    ctx.moveTo(x, y - 1.3 * r);
    ctx.lineTo(x + 1.3 * r, y);
    ctx.lineTo(x, y + 1.3 * r);
    ctx.lineTo(x - 1.3 * r, y);
    ctx.closePath();
  } else if (reason === "no_result") {
    ctx.moveTo(x, y + r);
    ctx.lineTo(x + r, y - r);
    ctx.lineTo(x - r, y - r);
    ctx.closePath();
  } else if (reason === "unseen") {
    ctx.arc(x, y, r, 0, 2 * Math.PI);
  } else {
    ctx.rect(x - r, y - r, 2 * r, 2 * r);
  }
  ctx.stroke();
}

function drawArm(ctx, view, robot, arm, theme) {
  const [baseX, baseY] = [view.x(robot.base[0]), view.y(robot.base[1])];
  const [binX, binY] = [view.x(robot.bin[0]), view.y(robot.bin[1])];
  const [x, y] = [view.x(arm.x), view.y(arm.y)];
  ctx.strokeStyle = robot.colour;
  if (arm.meet) {
    const [meetX, meetY] = [view.x(arm.meet[0]), view.y(arm.meet[1])];
    ctx.lineWidth = 1.5;
    ctx.setLineDash([2, 3]);
    line(ctx, binX, binY, meetX, meetY);
    ctx.setLineDash([]);
    line(ctx, meetX - 4, meetY, meetX + 4, meetY);
    line(ctx, meetX, meetY - 4, meetX, meetY + 4);
  }
  ctx.lineWidth = 2;
  ctx.fillStyle = theme.paper;
  ctx.beginPath();
  ctx.rect(binX - 8, binY - 5, 16, 10);
  ctx.fill();
  ctx.stroke();
  ctx.lineWidth = 3;
  line(ctx, baseX, baseY, x, y);
  drawBase(ctx, baseX, baseY, robot.colour, arm.down, theme);
  // The gripper; full when it carries, with a clock round it while it dwells.
  ctx.strokeStyle = robot.colour;
  circle(ctx, x, y, view.radius + 1.5);
  ctx.fillStyle = arm.phase === "back" || arm.phase === "grasp" ? robot.colour : theme.paper;
  ctx.fill();
  ctx.lineWidth = 2;
  ctx.stroke();
  if (arm.dwell > 0) {
    ctx.strokeStyle = theme.ink;
    ctx.beginPath();
    ctx.arc(x, y, view.radius + 5, -Math.PI / 2, (2 * arm.dwell - 0.5) * Math.PI);
    ctx.stroke();
  }
}

/** The base of a robot; hollow and crossed out while it is out of service. */
function drawBase(ctx, x, y, colour, down, theme) {
  circle(ctx, x, y, 7);
  ctx.fillStyle = down ? theme.paper : colour;
  ctx.fill();
  if (!down) return;
  ctx.strokeStyle = colour;
  ctx.lineWidth = 2;
  ctx.stroke();
  line(ctx, x - 4, y - 4, x + 4, y + 4);
  line(ctx, x - 4, y + 4, x + 4, y - 4);
}

/** Names and picks so far, left out where there is no room for them. */
function drawNames(ctx, view, station, arms, theme) {
  // Middles and half widths of what is written already, the belt's speed first.
  const arrow = view.y(station.belt.width / 2) - 12;
  const taken = [{ x: view.x(0) + 42, y: arrow, half: 42 }];
  ctx.font = SCENE_FONT;
  station.robots.forEach((robot, i) => {
    const below = robot.base[1] < 0;
    const name = shortened(ctx, robot.name, 160);
    const label = `${name}: ${arms[i].picked} picked`;
    const half = ctx.measureText(label).width / 2;
    const x = Math.min(Math.max(view.x(robot.base[0]), half), view.width - half);
    const y = view.y(robot.base[1]) + (below ? 19 : -19);
    const clash = taken.some(
      (other) => Math.abs(other.x - x) < other.half + half + 6 && Math.abs(other.y - y) < 14,
    );
    if (clash) return;
    taken.push({ x, y, half });
    text(ctx, label, x, y, theme.ink, SCENE_FONT, "center");
  });
}

function drawAxis(ctx, view, theme) {
  ctx.strokeStyle = theme.faint;
  ctx.lineWidth = 1;
  const y = view.floor + 0.5;
  line(ctx, view.x(view.left), y, view.x(view.right), y);
  const count = Math.min(12, ((view.right - view.left) * view.scale) / 60);
  for (const { value, label } of ticks(view.left, view.right, count)) {
    line(ctx, view.x(value), y, view.x(value), y + 4);
    text(ctx, label, view.x(value), y + 12, theme.faint, SMALL_FONT, "center");
  }
  const middle = view.x((view.left + view.right) / 2);
  text(ctx, "x along the travel [m]", middle, y + 27, theme.faint, SMALL_FONT, "center");
}

/** The index of the item of `state` nearest to (`x`, `y`) [px], or -1. */
function itemNear(view, state, x, y) {
  let best = -1;
  let least = (view.radius + 8) ** 2;
  state.items.forEach((item, index) => {
    if (item.fate === "picked") return;
    const distance = (view.x(item.x) - x) ** 2 + (view.y(item.y) - y) ** 2;
    if (distance < least) [best, least] = [index, distance];
  });
  return best;
}
