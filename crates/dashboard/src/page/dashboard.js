// The stream of views, drawing, and the pointer.

// Time before reconnecting when the stream has ended [ms].
const AGAIN = 1000;
// The page reports silence after this time without news [s].
const SILENCE = 3;

const canvas = byName("scene");
const trend = byName("trend");
const dark = window.matchMedia("(prefers-color-scheme: dark)");
// What is known: the line, the newest view, and when that view came [ms].
const seen = { line: null, view: null, came: 0, connected: false };
let theme = {};
let frame = null;
let trendFrame = null;
let pointer = null;

function fillLine() {
  const { line } = seen;
  byName("title").textContent = `Station ${line.station}`;
  const robots = line.robots.length;
  byName("subtitle").textContent =
    `${robots} robot${robots === 1 ? "" : "s"} under ${line.strategy}; ${line.program}`;
  document.title = `${line.station} - pickline`;
}

const leavesItems = () => seen.view?.status.unwanted !== undefined;

function fillLegend() {
  const reasons = ["passed_over", "busy", "grasp_failed", "not_found", "no_result", "unreachable"];
  const colour = seen.line.robots[0].colour;
  const scene = sceneLegend(colour, theme, reasons, leavesItems(), true, false);
  byName("legend").replaceChildren(...scene);
}

/** Fits the drawing to the page and its colours to the page's colour scheme. */
function layOut() {
  if (!seen.line) return;
  theme = pageTheme();
  const height = Math.max(300, 0.62 * window.innerHeight);
  const view = sceneView(seen.line, canvas.clientWidth, height);
  frame = { view, ctx: sized(canvas, view.width, view.height) };
  trendFrame = { width: trend.clientWidth, ctx: sized(trend, trend.clientWidth, TREND_HEIGHT) };
  if (seen.view) drawTrend(trendFrame.ctx, trendFrame.width, seen.view.trend, theme);
  fillLegend();
  draw();
}

const passed = () => (performance.now() - seen.came) / 1000;
const stateShown = () => stateNow(seen.line, seen.view, passed());

function draw() {
  if (!frame || !seen.view) return;
  const state = stateShown();
  const marked = pointer ? itemNear(frame.view, state, ...pointed()) : -1;
  drawScene(frame.ctx, frame.view, seen.line, state, theme, marked);
  showStory(state.items[marked]);
  return state;
}

/** Draws every frame while time runs by itself. */
function drawOn() {
  if (seen.view?.steady && passed() <= CARRIED_ON) draw();
  requestAnimationFrame(drawOn);
}

function pointed() {
  const box = canvas.getBoundingClientRect();
  return [pointer.x - box.left, pointer.y - box.top];
}

function showStory(item) {
  const box = byName("story");
  box.hidden = !item;
  if (!item) return;
  tell(box, storyNow(seen.line, item));
  placeBeside(box, pointer);
}

function showLink() {
  const { view, connected } = seen;
  const link = byName("link");
  const silence = view ? passed() : 0;
  let state = "live";
  let words = "live";
  if (view?.status.last) {
    [state, words] = ["lost", "the run has ended; waiting for the next one"];
  } else if (!connected) {
    const at = view ? `; this view is ${silence.toFixed(0)} s old` : "";
    [state, words] = ["lost", `no connection to the line${at}`];
  } else if (!view) {
    [state, words] = ["waiting", "connected, waiting for data"];
  } else if (silence > SILENCE) {
    [state, words] = ["silent", `no data for ${silence.toFixed(0)} s`];
  }
  link.dataset.link = state;
  if (link.textContent !== words) link.textContent = words;
}

function showTime(view) {
  const { stamp } = view.status;
  const time = view.steady ? new Date(1000 * stamp).toLocaleTimeString() : `${stamp.toFixed(1)} s`;
  const rest = view.left_out > 0 ? `; ${view.left_out} more items are not drawn` : "";
  byName("status").textContent = `time ${time}${rest}`;
}

function heedLine(event) {
  const line = JSON.parse(event.data);
  // Another version of the program may have another page.
  if (seen.line && seen.line.program !== line.program) {
    window.location.reload();
    return;
  }
  Object.assign(seen, { line, view: null, connected: true });
  fillLine();
  layOut();
  showLink();
}

function heedView(event) {
  const left = leavesItems();
  Object.assign(seen, { view: JSON.parse(event.data), came: performance.now() });
  if (leavesItems() !== left) fillLegend();
  showTime(seen.view);
  showPanels(seen.line, seen.view, draw());
  if (trendFrame) drawTrend(trendFrame.ctx, trendFrame.width, seen.view.trend, theme);
  showLink();
}

function connect() {
  const stream = new EventSource("events");
  stream.addEventListener("line", heedLine);
  stream.addEventListener("view", heedView);
  stream.addEventListener("error", () => {
    // Browsers reconnect by themselves in some cases and not in others.
    stream.close();
    seen.connected = false;
    showLink();
    setTimeout(connect, AGAIN);
  });
}

for (const kind of ["pointermove", "pointerdown"]) {
  canvas.addEventListener(kind, (event) => {
    pointer = { x: event.clientX, y: event.clientY };
    draw();
  });
}
canvas.addEventListener("pointerleave", () => {
  pointer = null;
  draw();
});
window.addEventListener("resize", layOut);
dark.addEventListener("change", layOut);
setInterval(showLink, 1000);
connect();
drawOn();
// For tests and for debugging.
window.pickline = {
  view: () => seen.view,
  state: () => seen.view && stateShown(),
  place: (x, y) => [frame.view.x(x), frame.view.y(y)],
};
