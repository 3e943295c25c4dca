// The page of `pickline simulate --html`, in a browser.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { open, pickline, withBrowser } from "./common.mjs";

const seek = (page, time) => page.evaluate((t) => window.pickline.seek(t), time);
const state = (page, time) => page.evaluate((t) => window.pickline.state(t), time);
const timeNow = (page) => page.evaluate(() => window.pickline.state().time);
const pixels = (page, id) => page.evaluate((i) => document.getElementById(i).toDataURL(), id);
const near = (a, b, what) => assert.ok(Math.abs(a - b) < 1e-6, `${what}: ${a} is not ${b}`);

/** The run as JSON and as a page. */
function simulate(folder, name, args) {
  const file = join(folder, `${name}.html`);
  const report = JSON.parse(pickline("simulate", "-q", "--format", "json", "--html", file, ...args));
  return { file, report };
}

/** The figures on the page are those of the report: exact in their values, rounded in
 * their words. */
async function checkFigures(page, report) {
  const data = JSON.parse(await page.locator("#data").textContent());
  assert.deepEqual(data.report, report);
  const shown = await page.locator("data").evaluateAll((all) =>
    all.map((e) => ({ name: e.dataset.name, value: Number(e.value), text: e.textContent })),
  );
  const expected = {
    picked: report.picked,
    items: report.items,
    picked_share: report.picked_share,
    missed: report.missed.length,
    end_s: report.end_s,
    picking_rate_per_min: report.picking_rate_per_min,
  };
  if (report.items_have_attributes) expected.weighted_rate_per_min = report.weighted_rate_per_min;
  if (report.throughput_per_min !== null) {
    expected.throughput_per_min = report.throughput_per_min;
    expected.flow_per_min = report.flow_per_min;
  }
  report.robots.forEach((robot, i) => {
    for (const [name, value] of Object.entries(robot)) {
      const hidden = name === "name" || (name === "weight" && !report.items_have_attributes);
      if (!hidden && value !== null) expected[`robot.${i}.${name}`] = value;
    }
  });
  for (const [name, count] of Object.entries(report.missed_by_reason)) {
    expected[`missed.${name}`] = count;
  }
  for (const name of ["certified_percent", "picks_upper_bound", "picking_rate_upper_bound_per_min"]) {
    const value = report.bound?.[name] ?? null;
    if (value !== null) expected[`bound.${name}`] = value;
  }
  if (data.clearance) {
    for (const name of ["distance_m", "time_s"]) expected[`clearance.${name}`] = data.clearance[name];
  }
  assert.deepEqual(Object.fromEntries(shown.map((s) => [s.name, s.value])), expected);
  for (const { name, value, text } of shown) {
    const percent = /share|utilisation/.test(name) ? 100 : 1;
    assert.ok(Math.abs(Number(text) - percent * value) <= 0.0501, `${name}: ${text}`);
  }
  const foot = await page.locator("#provenance").textContent();
  for (const fact of [report.made.station_hash, report.made.command, report.made.program]) {
    assert.ok(foot.includes(fact), fact);
  }
  return data;
}

/** When the last robot could leave for `item`, by docs/model.md. */
function lastChance(data, speeds, item) {
  const closes = data.robots.map(({ base, bin, reach }, i) => {
    const half = Math.sqrt(reach ** 2 - (item.y - base[1]) ** 2);
    if (Number.isNaN(half)) return -Infinity;
    const last = Math.min(base[0] + half, data.belt.length);
    if (Math.max(base[0] - half, 0) > last) return -Infinity;
    const way = Math.hypot(last - bin[0], item.y - bin[1]);
    return (last - item.x0) / data.belt.speed - way / speeds[i];
  });
  return Math.max(...closes, -item.x0 / data.belt.speed);
}

/** At many times, fates and arms are what follows from the report's picks. */
async function checkStates(page, report, data, speed) {
  const picks = new Map(report.picks.map((pick) => [pick.item, pick]));
  const reasons = new Map(report.missed.map((miss) => [miss.item, miss.reason]));
  const speeds = report.robots.map(() => speed);
  const over = (failure) => failure.grasp_s + data.robots[failure.robot].grasp_time;
  const tries = (id) => report.failures.filter((failure) => failure.item === id);
  const lost = data.items.map((item) =>
    Math.max(lastChance(data, speeds, item), ...tries(item.id).map(over)),
  );
  const some = report.picks[Math.floor(report.picks.length / 2)];
  const times = [0, 0.31, 0.52, 0.77, 0.93, 1].map((share) => share * report.end_s);
  if (some) times.push(some.decide_s, some.grasp_s, some.release_s);
  const failed = report.failures[Math.floor(report.failures.length / 2)];
  if (failed) times.push(failed.decide_s, failed.grasp_s, over(failed), failed.release_s);
  const seen = new Set();
  for (const time of times) {
    const now = await state(page, time);
    now.items.forEach((item, i) => {
      const { id, x0, y } = data.items[i];
      const pick = picks.get(id);
      const x = x0 + data.belt.speed * time;
      if (!pick && Math.abs(time - lost[i]) < 1e-6) return;
      let fate = x < 0 ? "coming" : "waiting";
      if (pick && time >= pick.decide_s) {
        fate = time < pick.grasp_s ? "claimed" : time < pick.release_s ? "carried" : "picked";
      } else if (!pick && time >= lost[i]) {
        fate = "missed";
      }
      const failing = tries(id).find((f) => f.decide_s <= time && time < over(f));
      if (failing) fate = "claimed";
      seen.add(fate);
      assert.equal(item.fate, fate, `item ${id} at ${time} s`);
      const claim = failing ?? (pick && time >= pick.decide_s ? pick : null);
      assert.equal(item.robot, claim ? claim.robot : null);
      assert.equal(item.reason, fate === "missed" ? reasons.get(id) : null);
      if (["coming", "waiting", "claimed", "missed"].includes(fate)) near(item.x, x, id);
      if (fate !== "picked" && fate !== "carried") near(item.y, y, id);
    });
    now.arms.forEach((arm, robot) => {
      const own = report.picks.filter((pick) => pick.robot === robot);
      assert.equal(arm.picked, own.filter((pick) => pick.release_s <= time).length);
      const outages = (report.downtimes ?? []).filter((outage) => outage.robot === robot);
      const down = outages.some((outage) => outage.from_s <= time && time < outage.to_s);
      assert.equal(arm.down, down, `robot ${robot} at ${time} s`);
      const trips = [...own, ...report.failures.filter((failure) => failure.robot === robot)];
      const pick = trips.find((p) => p.decide_s <= time && time < p.release_s);
      const [binX, binY] = data.robots[robot].bin;
      const out = Math.hypot(arm.x - binX, arm.y - binY);
      if (!pick) return near(out, 0, "an idle arm");
      const whole = Math.hypot(pick.meet[0] - binX, pick.meet[1] - binY);
      const back = pick.grasp_s + data.robots[robot].grasp_time;
      const way = time < pick.grasp_s ? (time - pick.decide_s) * speed : whole - (time - back) * speed;
      near(out, Math.min(Math.max(way, 0), whole), `arm ${robot} at ${time} s`);
      // On the straight line to the meeting point.
      const cross = (arm.x - binX) * (pick.meet[1] - binY) - (arm.y - binY) * (pick.meet[0] - binX);
      near(cross, 0, "off the line");
      if (time === pick.grasp_s) near(now.items.find((i) => i.id === pick.item).x, arm.x, "grasp");
    });
  }
  return seen;
}

async function checkControls(page, report) {
  const before = await pixels(page, "scene");
  const strips = await pixels(page, "strips");
  await page.locator("#time").fill("30");
  near(await timeNow(page), 30, "the slider's time");
  assert.notEqual(await pixels(page, "scene"), before);
  assert.notEqual(await pixels(page, "strips"), strips);
  assert.match(await page.locator("#clock").textContent(), /^30\.0 s of/);

  await page.locator("#speed").selectOption("10");
  await page.locator("#play").click();
  assert.equal(await page.locator("#play").textContent(), "Pause");
  await page.waitForFunction(() => window.pickline.state().time > 32);
  await page.locator("#play").click();
  const paused = await timeNow(page);
  await page.waitForTimeout(100);
  assert.equal(await timeNow(page), paused);
  // To the end, where it stops by itself.
  await seek(page, report.end_s - 1);
  await page.locator("#play").click();
  await page.waitForFunction(() => document.getElementById("play").textContent === "Play");
  assert.equal(await timeNow(page), report.end_s);
  assert.ok((await page.locator("#status").textContent()).includes(`${report.picked} picked`));

  await page.locator("#title").click();
  const press = async (key, expected) => {
    await page.keyboard.press(key);
    near(await timeNow(page), expected, key);
  };
  await press("Home", 0);
  await press("ArrowRight", 1);
  await press("Shift+ArrowRight", 11);
  await press("ArrowLeft", 10);
  await press("End", report.end_s);
  await press(",", report.picks.at(-1).decide_s);
  await press("Home", 0);
  await press(".", report.picks.map((pick) => pick.decide_s).find((time) => time > 0));
  await page.keyboard.press("Space");
  assert.equal(await page.locator("#play").textContent(), "Pause");
  await page.keyboard.press("Space");
  await page.keyboard.press("+");
  assert.equal(await page.locator("#speed").inputValue(), "20");

  for (const span of ["120", "60", "20", "0"]) {
    const last = await pixels(page, "strips");
    await page.locator("#span").selectOption(span);
    if (span !== "120") assert.notEqual(await pixels(page, "strips"), last, span);
  }
  const box = await page.locator("#strips").boundingBox();
  await page.mouse.click(box.x + box.width - 14, box.y + 10);
  near(await timeNow(page), report.end_s, "a click at a strip's end");
  await page.mouse.move(0, 0);
}

/** Moves the pointer over the scene until an item tells its story. */
async function hover(page) {
  const box = await page.locator("#scene").boundingBox();
  for (let y = box.y + 40; y < box.y + box.height - 40; y += 11) {
    for (let x = box.x + 20; x < box.x + box.width - 20; x += 11) {
      await page.mouse.move(x, y);
      if (await page.locator("#story").isVisible()) return page.locator("#story").innerText();
    }
  }
  return assert.fail("no item tells its story");
}

function checkStory(story, id, report) {
  const pick = report.picks.find((p) => p.item === id);
  const miss = report.missed.find((m) => m.item === id);
  assert.ok(story.includes(`item ${id}`) && story.includes("weight"), story);
  if (pick) {
    assert.ok(story.includes(`claimed by ${report.robots[pick.robot].name}`), story);
    for (const time of [pick.decide_s, pick.grasp_s, pick.release_s]) {
      assert.ok(story.includes(`${time.toFixed(2)} s`), story);
    }
  } else {
    for (const { decide_s: time } of report.failures.filter((f) => f.item === id).slice(0, 3)) {
      assert.ok(story.includes(`at ${time.toFixed(2)} s: the grasp failed`), story);
    }
    assert.ok(story.includes(`missed, ${miss.reason.replace("_", " ")}`), story);
  }
}

async function checkStories(page, report) {
  await seek(page, 30);
  const story = await hover(page);
  checkStory(story, /^item (.*)$/m.exec(story)[1], report);
  await page.mouse.move(0, 0);
  assert.ok(!(await page.locator("#story").isVisible()));
  const failed = report.missed.find((miss) => miss.reason === "grasp_failed");
  for (const id of [report.picks[0]?.item, report.missed[0]?.item, failed?.item]) {
    if (id === undefined) continue;
    await page.locator("#item").fill(id);
    checkStory(await page.locator("#found").innerText(), id, report);
  }
  await page.locator("#item").fill("none of these");
  assert.match(await page.locator("#found").innerText(), /no item/);
}

/** Two robots that face each other with exchanged bins: the page says that and when their
 * arms collide, and shows it. */
async function checkFacing(folder, browser) {
  const station = join(folder, "facing line.toml");
  const robot = (name, x, y, bin) =>
    `[[robot]]\nname = "${name}"\nbase = [${x}, ${y}]\nbin = [${x}, ${bin}]\nreach = 0.9\n` +
    "speed = 1.5\ngrasp_time = 0.2\nrelease_time = 0.1\n";
  const belt = "[belt]\nspeed = 0.1\nlength = 3.0\nwidth = 0.8\n";
  writeFileSync(station, belt + robot("front", 1.2, -0.6, 0.5) + robot("back", 1.6, 0.6, -0.5));
  const { file, report } = simulate(folder, "facing", ["--station", station, "--camera-x", "-0.3", "--check"]);
  const { page, check } = await open(browser, file);
  await checkFigures(page, report);
  assert.equal(report.clearance.distance_m, 0);
  assert.equal(await page.locator("#title").textContent(), "Replay of station facing line");
  await page.locator("#figures button").click();
  near(await timeNow(page), report.clearance.time_s, "the time of the collision");
  assert.match(await page.locator("#legend").innerText(), /where the camera looks/);
  check();
  await page.close();
}

/** Ids and names that would break out of a page that took them for HTML. */
async function checkHostile(folder, browser) {
  const id = "</script><b>\"'&<!--";
  const quoted = `"${id.replaceAll('"', '""')}"`;
  const pattern = join(folder, "hostile.csv");
  writeFileSync(pattern, `id,x,y,class\n${quoted},0,-0.3,${quoted}\nother,-0.3,0.2,\n`);
  const station = join(folder, "hostile.toml");
  const shown = pickline("station", "show");
  writeFileSync(station, shown.replace('"r1"', () => `'''${id}'''`));
  assert.ok(readFileSync(station, "utf8").includes(id));
  const args = ["--pattern", pattern, "--station", station];
  const { file, report } = simulate(folder, "hostile", args);
  const { page, check } = await open(browser, file);
  await checkFigures(page, report);
  await page.locator("#item").fill(id);
  checkStory(await page.locator("#found").innerText(), id, report);
  assert.ok((await page.locator("#robots").innerText()).includes(id));
  assert.equal(await page.locator("b").count(), 0);
  check();
}

/** Prints how long frames take with 1,000 items; what is smooth depends on the machine. */
async function measure(folder, browser) {
  const pattern = join(folder, "1000.csv");
  pickline("pattern", "generate", "grid", "--count", "1000", "--output", pattern);
  const { file, report } = simulate(folder, "1000", ["--robots", "6", "--pattern", pattern]);
  const { page, check } = await open(browser, file);
  await checkFigures(page, report);
  const { drawn, frame } = await page.evaluate(async (end) => {
    const times = Array.from({ length: 200 }, (_, i) => (i / 200) * end);
    const begin = performance.now();
    for (const time of times) window.pickline.seek(time);
    const drawn = (performance.now() - begin) / times.length;
    window.pickline.seek(end / 3);
    document.getElementById("play").click();
    const next = () => new Promise(requestAnimationFrame);
    const first = await next();
    let last = first;
    for (let i = 0; i < 90; i += 1) last = await next();
    return { drawn, frame: (last - first) / 90 };
  }, report.end_s);
  console.log(
    `1,000 items: ${drawn.toFixed(2)} ms to draw a moment, ${frame.toFixed(1)} ms a frame in play`,
  );
  check();
}

await withBrowser(async (folder, browser) => {
  const dense = join(folder, "dense.csv");
  const narrow = join(folder, "narrow.csv");
  const poisson = ["pattern", "generate", "poisson", "--radius", "0.12", "--count", "150"];
  pickline(...poisson, "--output", dense);
  pickline(...poisson, "--station", "paper-narrow", "--output", narrow);
  const seen = new Set();
  const cases = {
    default: ["--check"],
    dense: ["--pattern", dense, "--update-hz", "10"],
    one: ["--robots", "1", "--strategy", "FIFO"],
    failing: ["--pattern", dense, "--grasp-success", "0.5", "--check"],
    stopping: ["--pattern", dense, "--outage", "r1:5..15", "--outage", "r2:10..", "--check"],
    narrow: ["--station", "paper-narrow", "--robots", "3", "--pattern", narrow],
  };
  for (const [name, args] of Object.entries(cases)) {
    const { file, report } = simulate(folder, name, args);
    const { page, check } = await open(browser, file);
    const data = await checkFigures(page, report);
    assert.equal(report.failures.length > 0, name === "failing");
    assert.equal(report.downtimes !== undefined, name === "stopping");
    for (const fate of await checkStates(page, report, data, 0.5)) seen.add(fate);
    if (name === "default") await checkControls(page, report);
    await checkStories(page, report);
    check();
    await page.close();
    console.log(`replay ${name}: ok`);
  }
  assert.equal(seen.size, 6, `only ${[...seen]} were seen`);
  for (const [colorScheme, width] of [["light", 800], ["dark", 400]]) {
    const viewport = { width, height: 700 };
    const { page, check } = await open(browser, join(folder, "dense.html"), { colorScheme, viewport });
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(wide <= width, `the page is ${wide} px wide in ${width} px`);
    check();
    await page.close();
  }
  await checkFacing(folder, browser);
  console.log("replay of arms that collide: ok");
  await checkHostile(folder, browser);
  console.log("replay hostile ids: ok");
  await measure(folder, browser);
});
