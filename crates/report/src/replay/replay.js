// The replay: the time shown, and everything that changes it.

const run = makeRun(JSON.parse(byName("data").textContent));
const canvases = { scene: byName("scene"), strips: byName("strips") };
const slider = byName("time");
const speed = byName("speed");
// The strips without their cursor, kept until their content changes.
const kept = { canvas: document.createElement("canvas"), key: "" };
const dark = window.matchMedia("(prefers-color-scheme: dark)");
const replay = { time: 0, playing: false, last: 0, pointer: null, found: -1 };
// The colours of the page, from its style sheet.
let theme = {};
let sceneFrame = null;
let stripFrame = null;

/** Fits the drawings to the page and the colours to its scheme. */
function layOut() {
  theme = pageTheme();
  fillLegends(run, theme);
  kept.key = "";
  const width = canvases.scene.clientWidth;
  const view = sceneView(run, width, Math.max(300, 0.62 * window.innerHeight));
  sceneFrame = { view, ctx: sized(canvases.scene, view.width, view.height) };
  const strips = stripView(run, width, 0, run.end);
  stripFrame = { ctx: sized(canvases.strips, strips.width, strips.height) };
  draw();
}

/** The span of time that the strips show. It advances page by page, to stay readable. */
function shownSpan() {
  const span = Number(byName("span").value);
  if (span === 0 || span >= run.end) return [0, run.end];
  const page = Math.min(Math.floor(replay.time / span), Math.ceil(run.end / span) - 1);
  return [page * span, (page + 1) * span];
}

function draw() {
  const state = stateAt(run, replay.time);
  const marked = markedItem(state);
  drawScene(sceneFrame.ctx, sceneFrame.view, run, state, theme, marked);
  drawStripsNow();
  slider.value = String(replay.time);
  slider.setAttribute("aria-valuetext", seconds(replay.time));
  byName("clock").textContent = `${replay.time.toFixed(1)} s of ${run.end.toFixed(1)} s`;
  const counts = countFates(state);
  const fates = FATES.filter((fate) => fate !== "left" || run.report.unwanted);
  const words = fates.map((fate) => `${counts[fate]} ${FATE_WORDS[fate]}`).join(", ");
  byName("status").textContent = `${words}; ${rateUntil(run, replay.time).toFixed(1)} picks/min so far`;
  showStory(state, marked);
  if (replay.found >= 0) {
    tell(byName("found"), storyOf(run, run.items[replay.found], state.items[replay.found]));
  }
}

function drawStripsNow() {
  const [from, to] = shownSpan();
  const { width, height } = canvases.strips;
  const view = stripView(run, canvases.strips.clientWidth, from, to);
  const key = `${from} ${width} ${height} ${byName("span").value}`;
  if (kept.key !== key) {
    drawStrips(sized(kept.canvas, view.width, view.height), view, run, theme);
    kept.key = key;
  }
  const { ctx } = stripFrame;
  ctx.clearRect(0, 0, view.width, view.height);
  ctx.drawImage(kept.canvas, 0, 0, view.width, view.height);
  drawCursor(ctx, view, replay.time, theme);
  stripFrame.view = view;
}

/** The item under the pointer, or else the one requested by its id. */
function markedItem(state) {
  const { pointer } = replay;
  if (pointer) {
    const box = pointer.canvas.getBoundingClientRect();
    const [x, y] = [pointer.x - box.left, pointer.y - box.top];
    if (pointer.canvas === canvases.scene) {
      const near = itemNear(sceneFrame.view, state, x, y);
      if (near >= 0) return near;
    } else if (stripFrame.view) {
      const pick = tripUnder(stripFrame.view, run, x, y);
      if (pick) return run.byId.get(pick.item).index;
    }
  }
  return replay.found;
}

function showStory(state, marked) {
  const box = byName("story");
  const item = replay.pointer && marked !== replay.found ? run.items[marked] : undefined;
  box.hidden = !item;
  if (!item) return;
  tell(box, storyOf(run, item, state.items[marked]));
  placeBeside(box, replay.pointer);
}

function seek(time) {
  replay.time = Math.min(Math.max(time, 0), run.end);
  draw();
}

function setPlaying(playing) {
  replay.playing = playing;
  byName("play").textContent = playing ? "Pause" : "Play";
  if (!playing) return;
  if (replay.time >= run.end) replay.time = 0;
  replay.last = performance.now();
  requestAnimationFrame(step);
}

function step(now) {
  if (!replay.playing) return;
  const passed = Math.max(0, now - replay.last) / 1000;
  replay.last = now;
  seek(replay.time + passed * Number(speed.value));
  if (replay.time >= run.end) setPlaying(false);
  else requestAnimationFrame(step);
}

/** Jumps to the decision after (1) or before (-1) the time shown. */
function seekDecision(direction) {
  // Decisions at the time shown, up to rounding, are skipped.
  const after = countUpTo(run.decisions, replay.time + direction * 1e-9);
  const index = direction > 0 ? after : after - 1;
  const time = run.decisions[index];
  seek(time ?? (direction > 0 ? run.end : 0));
}

function changeSpeed(by) {
  const index = speed.selectedIndex + by;
  speed.selectedIndex = Math.min(Math.max(index, 0), speed.options.length - 1);
}

function onKey(event) {
  const { target, key } = event;
  const typing = target.tagName === "SELECT" || target.type === "text";
  if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
  const stride = event.shiftKey ? 10 : 1;
  const actions = {
    " ": () => setPlaying(!replay.playing),
    ArrowLeft: () => seek(replay.time - stride),
    ArrowRight: () => seek(replay.time + stride),
    ",": () => seekDecision(-1),
    ".": () => seekDecision(1),
    Home: () => seek(0),
    End: () => seek(run.end),
    "+": () => changeSpeed(1),
    "-": () => changeSpeed(-1),
  };
  // A focused button already handles Space.
  if (!Object.hasOwn(actions, key) || (key === " " && target.tagName === "BUTTON")) return;
  event.preventDefault();
  actions[key]();
}

function listen() {
  byName("play").addEventListener("click", () => setPlaying(!replay.playing));
  slider.addEventListener("input", () => seek(Number(slider.value)));
  byName("span").addEventListener("change", draw);
  byName("item").addEventListener("input", (event) => {
    const item = run.byId.get(event.target.value);
    replay.found = item ? item.index : -1;
    const words = event.target.value ? ["no item has this id"] : [];
    if (!item) tell(byName("found"), words);
    draw();
  });
  document.addEventListener("keydown", onKey);
  for (const canvas of Object.values(canvases)) {
    const point = (event) => {
      replay.pointer = { canvas, x: event.clientX, y: event.clientY };
      const pressed = event.buttons & 1 || event.type === "pointerdown";
      if (canvas === canvases.strips && pressed) {
        seek(stripFrame.view.time(event.clientX - canvas.getBoundingClientRect().left));
      } else {
        draw();
      }
    };
    canvas.addEventListener("pointermove", point);
    canvas.addEventListener("pointerdown", point);
    canvas.addEventListener("pointerleave", () => {
      replay.pointer = null;
      draw();
    });
  }
  window.addEventListener("resize", layOut);
  dark.addEventListener("change", layOut);
}

slider.max = String(run.end);
fillFigures(run);
fillTables(run);
layOut();
listen();
// For tests, and to control the page from the browser's console.
window.pickline = { seek, state: (time = replay.time) => stateAt(run, time) };
