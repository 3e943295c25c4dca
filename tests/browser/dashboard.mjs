// The page of `pickline run --dashboard`, in a browser, against lines that are played by
// this test or by `pickline emulate`.

import assert from "node:assert/strict";
import { get, request } from "node:http";
import { connect } from "node:net";
import { start, withBrowser, watched } from "./common.mjs";

const HOSTILE = "</script><img src=x onerror=alert(1)><b>\"'&";

/** Waits until `ready`. */
async function wait(ready) {
  for (let i = 0; !ready(); i += 1) {
    assert.ok(i < 3000, `in vain: ${ready}`);
    await new Promise((wake) => setTimeout(wake, 20));
  }
}

/** Waits for a line of remarks that matches; what it captures. */
async function remark(program, pattern) {
  await wait(() => pattern.test(program.errors()) || program.child.exitCode !== null);
  const found = pattern.exec(program.errors());
  assert.ok(found, program.errors());
  return found[1];
}

/** Starts a node with a dashboard; its address too. */
async function startNode(...args) {
  const node = start("run", "--dashboard", "127.0.0.1:0", ...args);
  const address = await remark(node, /dashboard at (http:\S+)/);
  return { node, address };
}

const view = (page) => page.evaluate(() => window.pickline.view());
const state = (page) => page.evaluate(() => window.pickline.state());
const link = (page) => page.locator("#link").getAttribute("data-link");
const hasView = (page, stamp) =>
  page.waitForFunction((s) => window.pickline?.view()?.status.stamp === s, stamp);

/** Every figure on the page, by name, exact and as it is shown; and the view it is of. */
function figures(page) {
  return page.evaluate(() => {
    const all = [...document.querySelectorAll("data")];
    const shown = all.map((e) => [e.dataset.name, { value: Number(e.value), text: e.textContent }]);
    return { shown: Object.fromEntries(shown), view: window.pickline.view() };
  });
}

/** The figures on the page are those of the node's status message. */
async function checkFigures(page, status) {
  const { shown } = await figures(page);
  checkShown(shown, status);
}

function checkShown(shown, status) {
  const settled = status.seen - status.on_belt - status.claimed;
  const expected = {
    settled_share: settled > 0 ? status.picked / settled : 0,
    missed: Object.values(status.missed).reduce((sum, count) => sum + count, 0),
    refused: Object.values(status.rejected).reduce((sum, count) => sum + count, 0),
  };
  for (const name of ["picked", "seen", "picks_per_min", "on_belt", "claimed"]) {
    expected[name] = status[name];
  }
  for (const table of ["missed", "rejected", "noted"]) {
    for (const [name, count] of Object.entries(status[table])) expected[`${table}.${name}`] = count;
  }
  status.robots.forEach((robot, i) => {
    expected[`robot.${i}.picked`] = robot.picked;
    expected[`robot.${i}.failed`] = robot.failed;
  });
  if (status.latency) {
    for (const [name, value] of Object.entries(status.latency)) expected[`latency.${name}`] = value;
  }
  for (const [name, value] of Object.entries(expected)) {
    assert.equal(shown[name]?.value, value, name);
    const percent = name.endsWith("share") ? 100 : 1;
    assert.ok(Math.abs(Number(shown[name].text) - percent * value) <= 0.0501, name);
  }
  // Nothing is shown that no message says.
  const known = [...Object.keys(expected), "belt_speed", "queued"];
  const others = /^(latency|trend)\./;
  const extra = Object.keys(shown).filter((n) => !known.includes(n) && !others.test(n));
  assert.deepEqual(extra, []);
}

/** A line whose time this test makes: what is shown is exact. */
async function checkByMessages(browser) {
  const { node, address } = await startNode("--clock", "messages", "--status-every", "1");
  const { page, check } = await watched(browser, address);
  const say = (message) => node.child.stdin.write(`${JSON.stringify(message)}\n`);
  const robot = (stamp, name, what) => say({ kind: "robot", stamp, name, state: what });
  const item = (stamp, id, x, y) =>
    say({ kind: "detection", stamp, id, x, y, class: HOSTILE, weight: 2.5 });
  robot(0, "r1", "idle");
  robot(0, "r2", "idle");
  item(0, HOSTILE, 1, -0.2);
  item(0, "waits", -0.3, 0.1);
  item(0, "comes", -2, 0.1);
  say({ kind: "nonsense", stamp: 0 });
  say({ kind: "tick", stamp: 0.25 });
  await hasView(page, 0.25);
  const first = await view(page);
  assert.deepEqual(
    first.items.map(({ id, fate, robot: who }) => [id, fate, who]),
    [
      [HOSTILE, "claimed", 0],
      ["waits", "waiting", undefined],
    ],
  );
  const [claim] = first.claims;
  assert.equal(claim.stage, "sent");
  assert.equal((await state(page)).arms[0].phase, "idle");
  // Names from outside are text and nothing else.
  assert.equal(await page.locator("#claims td").nth(2).innerText(), HOSTILE);
  assert.equal(await page.locator("b, img").count(), 0);
  say({ kind: "ack", stamp: 0.3, task: claim.task });
  const middle = (claim.start + claim.meet_at) / 2;
  say({ kind: "tick", stamp: middle });
  await hasView(page, middle);
  const half = await state(page);
  assert.equal(half.arms[0].phase, "out");
  const bin = half.arms[0].meet.map((to, i) => 2 * [half.arms[0].x, half.arms[0].y][i] - to);
  assert.ok(Math.hypot(bin[0] - 1.3, bin[1] + 0.525) < 0.05, `the arm is half way, from ${bin}`);
  assert.match(await page.locator("#robots").innerText(), /on its way to item/);
  say({ kind: "tick", stamp: claim.meet_at + 0.01 });
  await hasView(page, claim.meet_at + 0.01);
  assert.equal((await state(page)).items[0].fate, "carried");
  // Its story, at the pointer.
  const box = await page.locator("#scene").boundingBox();
  const { x } = (await state(page)).items[0];
  const [along] = await page.evaluate((at) => window.pickline.place(at, 0), x);
  const left = box.x + along;
  let story = "";
  for (let y = 20; y < box.height && !story; y += 5) {
    await page.mouse.move(left, box.y + y);
    if (await page.locator("#story").isVisible()) story = await page.locator("#story").innerText();
  }
  assert.ok(story.includes(HOSTILE) && story.includes("2.5"), story);
  await page.mouse.move(0, 0);
  say({ kind: "result", stamp: claim.free_at, task: claim.task, result: "PICKED" });
  robot(claim.free_at, "r2", "fault");
  say({ kind: "belt", stamp: claim.free_at, speed: 0 });
  say({ kind: "tick", stamp: 10 });
  await hasView(page, 10);
  const second = await view(page);
  assert.ok(!second.items.some(({ id }) => id === HOSTILE));
  assert.equal(second.belt_speed, 0);
  const after = await state(page);
  assert.deepEqual([after.arms[0].phase, after.arms[0].picked, after.arms[1].down], ["idle", 1, true]);
  assert.match(await page.locator("#robots").innerText(), /is out of service/);
  const status = node.lines().findLast((line) => line.kind === "status");
  assert.equal(status.stamp, 10);
  await checkFigures(page, status);
  // A belt that goes on carries away what nobody takes.
  robot(10, "r1", "fault");
  say({ kind: "belt", stamp: 10, speed: 0.1 });
  say({ kind: "tick", stamp: 56 });
  await hasView(page, 56);
  const missed = (await state(page)).items.find(({ id }) => id === "waits");
  assert.deepEqual([missed.fate, missed.reason], ["missed", "busy"]);
  await checkFigures(page, node.lines().findLast((line) => line.kind === "status"));
  check();
  await checkServer(address);
  node.child.stdin.end();
  assert.equal(await node.ended, 0, node.errors());
  await page.waitForFunction(() => document.getElementById("link").textContent.includes("ended"));
  assert.equal((await view(page)).status.last, true);
  await page.close();
}

/** What the server gives to whom. */
async function checkServer(address) {
  const { port } = new URL(address);
  const ask = (path, options = {}) =>
    new Promise((tell, fail) => {
      const asked = request({ host: "127.0.0.1", port, path, ...options }, (answer) => {
        answer.resume();
        answer.on("end", () => tell(answer));
      });
      asked.on("error", fail);
      asked.end();
    });
  const page = await ask("/");
  assert.equal(page.statusCode, 200);
  assert.match(page.headers["content-security-policy"], /default-src 'none'; script-src 'self'/);
  assert.equal(page.headers["access-control-allow-origin"], undefined);
  for (const [path, options, code] of [
    ["/nothing", {}, 404],
    ["/", { method: "POST" }, 405],
    ["/events", { method: "DELETE" }, 405],
    ["/", { headers: { Host: "evil.example" } }, 403],
    ["/", { headers: { Host: "localhost:1" } }, 200],
  ]) {
    assert.equal((await ask(path, options)).statusCode, code, path);
  }
  // Only so many watch at a time, and there is room again when they have gone.
  const watch = () =>
    new Promise((tell, fail) => {
      const asked = get({ host: "127.0.0.1", port, path: "/events" }, (answer) => {
        answer.on("error", () => {});
        tell({ code: answer.statusCode, leave: () => asked.destroy() });
        answer.resume();
      });
      asked.on("error", fail);
    });
  const watchers = [];
  let refused = 0;
  while (refused === 0 && watchers.length < 100) {
    const watcher = await watch();
    if (watcher.code === 503) refused += 1;
    watchers.push(watcher);
  }
  assert.equal(refused, 1);
  for (const watcher of watchers) watcher.leave();
  let last = {};
  for (let i = 0; last.code !== 200; i += 1) {
    assert.ok(i < 3000, "nobody is let in any more");
    last = await watch();
    last.leave();
    await new Promise((wake) => setTimeout(wake, 20));
  }
}

/** A line that goes by the clock: items move, and a node that comes back is found. */
async function checkByTheClock(browser) {
  const { node, address } = await startNode("--listen", "127.0.0.1:0", "--robots", "6");
  const at = await remark(node, /listening at (\S+)/);
  const play = () => start("emulate", "--connect", at, "--robots", "6", "--jitter-ms", "20");
  const station = play();
  const { page, check, allow } = await watched(browser, address);
  await page.waitForFunction(() => window.pickline?.view()?.status.seen > 10);
  assert.equal(await link(page), "live");
  const [before, then] = [await state(page), Date.now()];
  const pixels = () => page.evaluate(() => document.getElementById("scene").toDataURL());
  const picture = await pixels();
  await page.waitForTimeout(600);
  const [after, passed] = [await state(page), (Date.now() - then) / 1000];
  assert.notEqual(await pixels(), picture);
  const isLoose = ({ fate }) => fate === "coming" || fate === "waiting";
  const moved = before.items
    .map((item) => [item, after.items.find(({ id }) => id === item.id)])
    .filter(([item, later]) => later && isLoose(item) && isLoose(later))
    .map(([item, later]) => later.x - item.x);
  assert.ok(moved.length > 5);
  for (const way of moved) assert.ok(way > 0 && way < 0.05 * (passed + 2), `${way} m`);
  const { trend } = await view(page);
  assert.equal(trend.utilisation.length, 6);
  assert.ok(trend.utilisation.every((share) => share >= 0 && share <= 1));
  assert.ok(trend.span_s > 0 && trend.span_s <= 60);
  await checkLooks(browser, address);
  await checkAgainstStatuses(page, at);
  allow(/ERR_CONNECTION_REFUSED|ERR_INCOMPLETE_CHUNKED_ENCODING|ERR_CONNECTION_RESET/);
  node.child.kill("SIGKILL");
  await page.waitForFunction(() => document.getElementById("link").dataset.link === "lost");
  await node.ended;
  station.child.kill("SIGTERM");
  await station.ended;
  // The next one has its dashboard at the same place, on another line.
  const next = start("run", "--dashboard", new URL(address).host, "--strategy", "LPT,PP");
  await remark(next, /dashboard at (http:\S+)/);
  await page.waitForFunction(() => document.getElementById("subtitle").textContent.includes("LPT,PP"));
  assert.equal(await page.locator("#title").textContent(), "Station paper");
  await page.waitForFunction(() => window.pickline.view()?.status.robots.length === 2);
  assert.equal(await link(page), "live");
  assert.equal((await figures(page)).shown.seen.value, 0);
  check();
  // A port that is taken is told, with the cure.
  const third = start("run", "--dashboard", new URL(address).host);
  assert.equal(await third.ended, 2);
  assert.match(third.errors(), /--dashboard: .*\n.*cure: /);
  next.child.kill("SIGTERM");
  assert.equal(await next.ended, 0, next.errors());
  await page.close();
}

/** While the line runs, what is shown lies between the status messages before and after. */
async function checkAgainstStatuses(page, at) {
  const [host, port] = at.split(":");
  const peer = connect({ host, port });
  let said = "";
  peer.on("data", (part) => (said += part));
  const statuses = () => {
    const lines = said.slice(0, said.lastIndexOf("\n") + 1).split("\n");
    const messages = lines.filter(Boolean).map((line) => JSON.parse(line));
    return messages.filter(({ kind }) => kind === "status");
  };
  await wait(() => statuses().length > 0);
  const before = statuses().at(-1);
  await page.waitForFunction((s) => window.pickline.view().status.stamp > s, before.stamp);
  const { shown, view: now } = await figures(page);
  checkShown(shown, { ...now.status, latency: now.latency });
  await wait(() => statuses().at(-1).stamp > now.status.stamp);
  const after = statuses().find(({ stamp }) => stamp > now.status.stamp);
  for (const name of ["seen", "picked"]) {
    const value = shown[name].value;
    assert.ok(before[name] <= value && value <= after[name], `${name}: ${value}`);
  }
  assert.ok(shown["latency.decisions"].value <= after.latency.decisions);
  assert.deepEqual(now.status.robots.map(({ name }) => name), after.robots.map(({ name }) => name));
  peer.destroy();
}

/** It fits into a small window, and has two looks. */
async function checkLooks(browser, address) {
  const grounds = [];
  for (const colorScheme of ["light", "dark"]) {
    for (const width of [400, 1280]) {
      const viewport = { width, height: 800 };
      const { page, check } = await watched(browser, address, { colorScheme, viewport });
      await page.waitForFunction(() => window.pickline?.view());
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(wide <= width, `the page is ${wide} px wide in ${width} px`);
      grounds.push(await page.evaluate(() => getComputedStyle(document.body).backgroundColor));
      check();
      await page.close();
    }
  }
  assert.equal(new Set(grounds).size, 2);
}

await withBrowser(async (folder, browser) => {
  await checkByMessages(browser);
  console.log("dashboard by messages: ok");
  await checkByTheClock(browser);
  console.log("dashboard by the clock: ok");
});
