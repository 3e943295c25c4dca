// Draws the station in one state. Pure: it depends on its arguments only, so the replay and
// the dashboard both use it.
//
// The fields of a state that are used:
//   { travel, speed, items: [{ x, y, fate, robot, reason }], arms: [{ phase, x, y, meet,
//     dwell, picked, down }] }
// with one arm in the order of the station; travel [m] and speed [m/s] are the belt's.
// Fates:
//   coming   not on the belt yet            waiting  on it, not claimed
//   claimed  a robot is on its way, or      carried  in the robot's gripper
//            fails to grasp it
//   picked   in its bin                     missed   no robot can leave for it any longer
// Phases: idle, out, grasp, back, release; a robot that is `down` is out of service.
//
// `station` is { belt: { length, width }, camera, robots: [{ name, base, bin, reach,
// colour }] }, in m; `camera`, if there is one, is the x at which it looks at the belt;
// `theme` the colours { ink, faint, paper, belt, edge, item }.

// Share of the line's length kept free before and after it, where items appear and leave.
const ROOM = 0.05;
// Space left of the line for the y axis, and right of it for the belt's width [px].
const AXIS_LEFT = 62;
const AXIS_RIGHT = 50;
// Space for the x axis below each row [px].
const AXIS_SPACE = 38;
// Height of a robot's name and reach, their distance from the base [px], and the levels for
// robots that stand close to each other.
const LABEL = 30;
const TO_LABEL = 11;
const LEVELS = 3;
// From the belt down to the end of the camera's label [px].
const CAMERA = 24;
// A line lower than this [px] is broken into rows, which overlap by this much.
const LOWEST = 110;
const MOST_ROWS = 6;
const OVERLAP = 36;

/** A length without rounding errors after its sixth decimal. */
const metres = (length) => `${Number(length.toFixed(6))} m`;
const reachWords = (robot) => `reach ${metres(robot.reach)}`;

/** From the belt frame [m] to the canvas [px]: x to the right, y upwards. If the line is broken
 * into rows, `x` and `y` lead to the first row, as long as the whole line; each next row is
 * `shift` further along it and `stride` lower. */
function sceneView(station, width, mostHeight) {
  const { belt, robots } = station;
  const places = robots.flatMap((robot) => [
    robot.base,
    robot.bin,
    ...binsOf(robot).map((bin) => bin.at),
  ]);
  const xs = [0, belt.length, station.camera ?? 0, ...places.map(([x]) => x)];
  const ys = [-belt.width / 2, belt.width / 2, ...places.map(([, y]) => y)];
  const room = ROOM * (Math.max(...xs) - Math.min(...xs));
  const left = Math.min(...xs) - room;
  const right = Math.max(...xs) + room;
  const bottom = Math.min(...ys);
  const top = Math.max(...ys);
  const inside = Math.max(60, width - AXIS_LEFT - AXIS_RIGHT);
  const most = Math.max(LOWEST, mostHeight - 2 * (LABEL + TO_LABEL) - AXIS_SPACE) / (top - bottom);
  const one = Math.min(inside / (right - left), most);
  const low = LOWEST / (one * (top - bottom));
  const rows = inside > 4 * OVERLAP ? Math.min(MOST_ROWS, Math.max(1, Math.ceil(low))) : 1;
  const shift = inside - 2 * OVERLAP;
  const whole = rows > 1 ? (rows - 1) * shift + inside : inside;
  const scale = Math.min(whole / (right - left), most);
  const margin = AXIS_LEFT + (rows > 1 ? 0 : (inside - scale * (right - left)) / 2);
  const x = (value) => margin + (value - left) * scale;
  const { spaces, labels } = placeLabels(robots, x, hasCamera(station));
  const y = (value) => spaces[0] + (top - value) * scale;
  const floor = y(bottom) + spaces[1];
  return {
    width,
    height: Math.ceil(rows * (floor + AXIS_SPACE)),
    left,
    right,
    bottom,
    top,
    scale,
    rows,
    shift,
    stride: floor + AXIS_SPACE,
    inside,
    labels,
    radius: Math.min(6, Math.max(2.5, 0.02 * scale)),
    x,
    y,
    floor,
  };
}

/** Positions of the robots' labels beyond the bases: the side, and the distance from it. */
function placeLabels(robots, x, camera) {
  // Ends of the labels on each level, above and below.
  const ends = [new Array(LEVELS).fill(-Infinity), new Array(LEVELS).fill(-Infinity)];
  // The arrow of travel is always above the belt.
  // The camera's label is below it.
  const spaces = [LABEL, camera ? CAMERA : TO_LABEL];
  const labels = robots.map((robot) => {
    const side = robot.base[1] < 0 ? 1 : 0;
    const half = 0.5 * Math.max(7.3 * (Math.min(20, robot.name.length) + 10), 6 * reachWords(robot).length);
    const middle = x(robot.base[0]);
    const free = ends[side].findIndex((end) => end + 8 < middle - half);
    const level = free < 0 ? LEVELS - 1 : free;
    ends[side][level] = middle + half;
    spaces[side] = Math.max(spaces[side], TO_LABEL + (level + 1) * LABEL);
    return { side, away: TO_LABEL + level * LABEL, half };
  });
  return { spaces, labels };
}

/** Draws `state`; the item with index `marked` gets a ring. */
function drawScene(ctx, view, station, state, theme, marked) {
  ctx.clearRect(0, 0, view.width, view.height);
  for (let row = 0; row < view.rows; row += 1) {
    ctx.save();
    ctx.translate(-row * view.shift, row * view.stride);
    if (view.rows > 1) {
      const ends = view.inside + (row === view.rows - 1 ? AXIS_RIGHT : 0);
      ctx.beginPath();
      ctx.rect(AXIS_LEFT + row * view.shift, 0, ends, view.floor);
      ctx.clip();
    }
    drawLine(ctx, view, station, state, theme, marked);
    drawNames(ctx, view, station, state.arms, theme, row);
    ctx.restore();
    drawAxes(ctx, view, row, theme);
  }
}

function drawLine(ctx, view, station, state, theme, marked) {
  drawBelt(ctx, view, station, state, theme);
  station.robots.forEach((robot) => drawWorkspace(ctx, view, station.belt, robot));
  drawItems(ctx, view, station, state.items, theme);
  drawCamera(ctx, view, station, theme);
  station.robots.forEach((robot, i) => drawArm(ctx, view, robot, state.arms[i], theme));
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
  // Seams that travel with the belt, to make its motion visible.
  const step = belt.length / Math.min(60, Math.max(2, Math.round(belt.length / 0.5)));
  // Also if the belt has run backwards.
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
  // The direction of travel, beside the belt where no item is below it.
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
  // The belt's width, after its end.
  const end = view.x(belt.length) + 9;
  const [upper, lower] = [view.y(belt.width / 2), view.y(-belt.width / 2)];
  ctx.strokeStyle = theme.faint;
  ctx.lineWidth = 1;
  line(ctx, end, upper, end, lower);
  line(ctx, end - 4, upper, end + 4, upper);
  line(ctx, end - 4, lower, end + 4, lower);
  const middle = (upper + lower) / 2;
  text(ctx, metres(belt.width), end + 6, middle, theme.faint, SMALL_FONT, "left");
}

/** Whether a camera looks at the belt at a known position. */
const hasCamera = ({ camera }) => camera !== undefined && camera !== null;

/** Where the camera looks at the belt. */
function drawCamera(ctx, view, station, theme) {
  if (!hasCamera(station)) return;
  const { camera, belt } = station;
  const x = view.x(camera);
  const [upper, lower] = [view.y(belt.width / 2) - 5, view.y(-belt.width / 2) + 5];
  ctx.strokeStyle = theme.ink;
  ctx.lineWidth = 2;
  ctx.setLineDash([2, 4]);
  line(ctx, x, upper, x, lower);
  ctx.setLineDash([]);
  text(ctx, "camera", x, lower + 8, theme.faint, SMALL_FONT, "center");
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
    // Items in a bin are counted beside it.
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
  const isLeft = item.fate === "left";
  circle(ctx, x, y, isLeft ? 0.55 * radius : radius);
  ctx.fillStyle = colour ?? (isLeft ? theme.faint : theme.item);
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
  } else if (reason === "not_found") {
    ctx.moveTo(x - 1.3 * r, y);
    ctx.lineTo(x + 1.3 * r, y);
    ctx.moveTo(x, y - 1.3 * r);
    ctx.lineTo(x, y + 1.3 * r);
  } else if (reason === "no_result") {
    ctx.moveTo(x, y + r);
    ctx.lineTo(x + r, y - r);
    ctx.lineTo(x - r, y - r);
    ctx.closePath();
  } else if (reason === "robot_down") {
    ctx.moveTo(x, y - 1.2 * r);
    ctx.lineTo(x, y + r);
    ctx.moveTo(x - r, y + r);
    ctx.lineTo(x + r, y + r);
  } else if (reason === "unseen") {
    ctx.arc(x, y, r, 0, 2 * Math.PI);
  } else {
    ctx.rect(x - r, y - r, 2 * r, 2 * r);
  }
  ctx.stroke();
}

function drawArm(ctx, view, robot, arm, theme) {
  const [baseX, baseY] = [view.x(robot.base[0]), view.y(robot.base[1])];
  const [x, y] = [view.x(arm.x), view.y(arm.y)];
  ctx.strokeStyle = robot.colour;
  if (arm.meet) {
    const [meetX, meetY] = [view.x(arm.meet[0]), view.y(arm.meet[1])];
    const ends = [arm.from ?? robot.bin];
    if (arm.bin && String(arm.bin) !== String(ends[0])) ends.push(arm.bin);
    ctx.lineWidth = 1.5;
    ctx.setLineDash([2, 3]);
    for (const [endX, endY] of ends) line(ctx, view.x(endX), view.y(endY), meetX, meetY);
    ctx.setLineDash([]);
    line(ctx, meetX - 4, meetY, meetX + 4, meetY);
    line(ctx, meetX, meetY - 4, meetX, meetY + 4);
  }
  ctx.lineWidth = 2;
  ctx.fillStyle = theme.paper;
  for (const bin of binsOf(robot)) {
    ctx.beginPath();
    ctx.rect(view.x(bin.at[0]) - 8, view.y(bin.at[1]) - 5, 16, 10);
    ctx.fill();
    ctx.stroke();
  }
  ctx.lineWidth = 3;
  line(ctx, baseX, baseY, x, y);
  drawBase(ctx, baseX, baseY, robot.colour, arm.down, theme);
  // The gripper: filled while it carries, with a clock around it while it dwells.
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

/** Names, picks so far and reach of the robots for which this row is the first with room. */
function drawNames(ctx, view, station, arms, theme, row) {
  const [upper, lower] = [view.y(view.top), view.y(view.bottom)];
  station.robots.forEach((robot, i) => {
    const { side, away } = view.labels[i];
    ctx.font = SCENE_FONT;
    const name = shortened(ctx, robot.name, 160);
    const label = `${name}: ${arms[i].picked} picked`;
    const half = ctx.measureText(label).width / 2;
    const x = Math.max(view.x(robot.base[0]), half);
    const past = x + half - AXIS_LEFT - view.inside;
    const own = Math.min(view.rows - 1, Math.max(0, Math.ceil(past / view.shift)));
    if (view.rows > 1 && row !== own) return;
    const y = side === 0 ? upper - away - LABEL + 8 : lower + away + 8;
    text(ctx, label, x, y, theme.ink, SCENE_FONT, "center");
    text(ctx, reachWords(robot), x, y + 13, theme.faint, SMALL_FONT, "center");
  });
}

/** The axes of a row: x below it, y to the left. */
function drawAxes(ctx, view, row, theme) {
  ctx.strokeStyle = theme.faint;
  ctx.lineWidth = 1;
  const down = row * view.stride;
  const y = view.floor + down + 0.5;
  const across = (x) => view.x(x) - row * view.shift;
  const from = Math.max(view.left, view.left + (row * view.shift) / view.scale);
  const to = view.rows > 1 ? Math.min(view.right, from + view.inside / view.scale) : view.right;
  line(ctx, across(from), y, across(to), y);
  const count = Math.min(12, ((to - from) * view.scale) / 60);
  for (const { value, label } of ticks(from, to, count)) {
    line(ctx, across(value), y, across(value), y + 4);
    text(ctx, label, across(value), y + 12, theme.faint, SMALL_FONT, "center");
  }
  text(ctx, "x along the travel [m]", across((from + to) / 2), y + 27, theme.faint, SMALL_FONT, "center");
  const edge = Math.round(across(from)) - 8.5;
  const [upper, lower] = [view.y(view.top) + down, view.y(view.bottom) + down];
  line(ctx, edge, upper, edge, lower);
  for (const { value, label } of ticks(view.bottom, view.top, Math.min(8, (lower - upper) / 24))) {
    line(ctx, edge - 4, view.y(value) + down, edge, view.y(value) + down);
    text(ctx, label, edge - 7, view.y(value) + down, theme.faint, SMALL_FONT, "right");
  }
  ctx.save();
  ctx.translate(edge - 46, (upper + lower) / 2);
  ctx.rotate(-Math.PI / 2);
  text(ctx, "y across [m]", 0, 0, theme.faint, SMALL_FONT, "center");
  ctx.restore();
}

/** The index of the item of `state` nearest to (`x`, `y`) [px], or -1. */
function itemNear(view, state, x, y) {
  let best = -1;
  let least = (view.radius + 8) ** 2;
  const row = Math.min(view.rows - 1, Math.floor(y / view.stride));
  const [along, across] = [x + row * view.shift, y - row * view.stride];
  state.items.forEach((item, index) => {
    if (item.fate === "picked") return;
    const distance = (view.x(item.x) - along) ** 2 + (view.y(item.y) - across) ** 2;
    if (distance < least) [best, least] = [index, distance];
  });
  return best;
}
