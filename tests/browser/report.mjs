// The pages of `pickline compare`, `sweep` and `optimize --html`, in a browser.

import assert from "node:assert/strict";
import { join } from "node:path";
import { open, pickline, withBrowser } from "./common.mjs";

/** The value of `report` at `path`, as `cases.0.items`. */
const at = (report, path) => path.split(".").reduce((value, key) => value[key], report);

/** Every figure on the page is the report's: exact in its value, rounded in its words. */
async function checkFigures(page, report) {
  assert.deepEqual(JSON.parse(await page.locator("#data").textContent()), report);
  const figures = await page.locator("data").evaluateAll((all) =>
    all.map((e) => ({ path: e.dataset.name, value: Number(e.value), text: e.textContent })),
  );
  const paths = new Set();
  for (const { path, value, text } of figures) {
    assert.equal(value, at(report, path), path);
    paths.add(path);
    const share = /share|complete_(low|high)$|(purity|recovery)(_low|_high)?$/.test(path) ? 100 : 1;
    const digits = (text.split(".")[1] ?? "").length;
    assert.ok(Math.abs(Number(text) - share * value) <= 0.5001 * 10 ** -digits, `${path}: ${text}`);
  }
  const foot = await page.locator("#provenance").textContent();
  for (const fact of ["program", "command", "station", "station_hash", "patterns"]) {
    assert.ok(foot.includes(report.made[fact]), fact);
  }
  return paths;
}

/** What the bars and points of a chart say when the pointer rests on them. */
const tips = (page, chart) => page.locator(`#chart-${chart} g > title`).allTextContents();

/** No text of a chart leaves it or touches another, unless it is said twice in a place. */
async function checkTexts(page) {
  const clashes = await page.locator("figure svg").evaluateAll((all) =>
    all.flatMap((svg) => {
      const outer = svg.getBoundingClientRect();
      const texts = [...svg.querySelectorAll("text")].map((text) => {
        const { left, right, top, bottom } = text.getBoundingClientRect();
        // Letters do not fill the height of their line.
        const room = 0.2 * Math.min(bottom - top, right - left);
        return { words: text.textContent, left, right, top: top + room, bottom: bottom - room };
      });
      const found = [];
      texts.forEach((a, i) => {
        const out = Math.max(
          outer.left - a.left,
          a.right - outer.right,
          outer.top - a.top,
          a.bottom - outer.bottom,
        );
        if (out > 0.5) found.push(`"${a.words}" leaves the chart by ${out} px`);
        for (const b of texts.slice(i + 1)) {
          const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
          const along = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
          if (across > 0.5 && along > 0.5) found.push(`"${a.words}" touches "${b.words}"`);
        }
      });
      return found;
    }),
  );
  assert.deepEqual(clashes, []);
}

/** The page is no wider than its window, light or dark, and its charts follow. */
async function checkLooks(browser, file) {
  const inks = [];
  for (const [colorScheme, width] of [["light", 1280], ["dark", 800], ["dark", 420]]) {
    const options = { colorScheme, viewport: { width, height: 700 } };
    const { page, check } = await open(browser, file, options);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(wide <= width, `the page is ${wide} px wide in a window of ${width}`);
    inks.push(await page.locator("figure text").first().evaluate((e) => getComputedStyle(e).fill));
    await page.emulateMedia({ media: "print" });
    inks.push(await page.locator("figure text").first().evaluate((e) => getComputedStyle(e).fill));
    check();
    await page.close();
  }
  // Dark letters on light ground, light ones on dark, dark ones on paper.
  const [light, print, dark, ...others] = inks;
  assert.equal(print, light);
  assert.notEqual(dark, light);
  assert.deepEqual(others, [print, dark, print]);
}

function cleanRun(folder, name, args) {
  const file = join(folder, `${name}.html`);
  const report = JSON.parse(pickline(...args, "-q", "--format", "json", "--html", file));
  return { file, report };
}

const all = (list, fields, prefix) =>
  list.flatMap((_, i) => fields.map((field) => `${prefix}.${i}.${field}`));

/** Asserts that `paths` has each of `expected`. */
function has(paths, expected) {
  const missing = expected.filter((path) => !paths.has(path));
  assert.deepEqual(missing, []);
}

async function checkComparison(page, report, paths) {
  const fields = ["picked_share", "end_s", "picking_rate_per_min"];
  const between = ["picked_share_low", "picked_share_high", "picking_rate_low", "picking_rate_high"];
  report.cases.forEach((one, i) => {
    has(paths, all(one.results, fields, `cases.${i}.results`));
    if (one.patterns > 1) has(paths, all(one.results, between, `cases.${i}.results`));
    one.results.slice(1).forEach((_, j) => {
      const against = one.patterns > 1 ? ["diff_low", "diff_high"] : [];
      has(paths, [...against, "benefit_percent"].map((f) => `cases.${i}.results.${j + 1}.${f}`));
    });
  });
  const results = report.cases.flatMap((one) =>
    one.results.map((result, j) => ({ one, result, method: report.methods[j].title })),
  );
  const rates = await tips(page, "rate");
  for (const { one, result, method } of results) {
    const said = `${one.name}, ${method}: ${result.picking_rate_per_min.toFixed(2)}/min`;
    assert.equal(rates.filter((tip) => tip.startsWith(said)).length, 1, said);
  }
  const differences = await tips(page, "difference");
  assert.equal(differences.length, report.cases.length * (report.methods.length - 1));
}

async function checkSweep(page, report, paths) {
  const fields = ["picked_share", "picking_rate_per_min"];
  has(paths, all(report.points, fields, "points"));
  for (const chart of ["picked", "rate"]) {
    const said = await tips(page, chart);
    assert.equal(said.length, report.points.length);
    for (const point of report.points) {
      const words = `${point.title}, ${report.sweep} at ${point.value}: `;
      assert.ok(said.some((tip) => tip.startsWith(words)), words);
    }
  }
  const limits = report.limits.flatMap((limit, j) =>
    ["highest", "first_miss", "lowest"]
      .filter((field) => limit[field] !== null && (report.sweep === "robots") === (field === "lowest"))
      .map((field) => `limits.${j}.${field}`),
  );
  has(paths, limits);
}

async function checkThresholds(page, report, paths) {
  has(paths, all(report.points, ["sorting.purity", "sorting.recovery", "sorting.due"], "points"));
  const chosen = ["threshold", "trained.purity", "fresh.purity", "fresh.recovery_low"];
  has(paths, all(report.thresholds.methods, chosen, "thresholds.methods"));
  const said = await tips(page, "purity");
  assert.equal(said.length, report.points.length);
  for (const { title, value, sorting } of report.points) {
    const words = `${title} at ${value}: purity ${(100 * sorting.purity).toFixed(1)} %`;
    assert.ok(said.some((tip) => tip.startsWith(words)), `${words} in ${said}`);
  }
}

async function checkOptimum(page, report, paths) {
  const top = report.ranking.slice(0, 10);
  has(paths, all(top, ["mean", "picked_share", "worst"], "ranking"));
  has(paths, ["mean", "mean_low", "mean_high", "complete"].map((f) => `validation.${f}`));
  if (report.beside) {
    has(paths, all(report.beside.strategies, ["mean", "picked_share", "worst"], "beside.strategies"));
    has(paths, ["diff_low", "diff_high"].map((f) => `beside.strategies.1.${f}`));
  }
  const said = await tips(page, "difference");
  assert.equal(said.length, Math.min(report.ranking.length, 20));
  for (const line of report.ranking.slice(0, 20)) {
    const below = (report.ranking[0].value - line.value).toFixed(2).replace("-0.00", "0.00");
    const words = `[${line.assignment.join("; ")}]: ${below} below`;
    assert.ok(said.some((tip) => tip.startsWith(words)), `${words} in ${said}`);
  }
}

const robust = ["--robust", "SPT,FIFO"];
const speeds = ["--from", "0.03", "--to", "0.055"];
// Twelve, of which none is given twice.
const many = ["FIFO", "SPT", "LPT", "SD", "LD", "PP"].flatMap((rule) =>
  [`${rule},${rule}`, rule === "LPT" ? "PP,LPT" : `LPT,${rule}`].flatMap((rules) => ["--strategy", rules]),
);
const four = ["--robots", "4", "--robust", "SPT,SPT,SPT,FIFO"];
const small = ["--patterns", "balanced:3", "--items", "20", "--validate", "20"];
const runs = {
  compare: [checkComparison, ["compare", ...robust, "--replicates", "5", "--paper"]],
  "compare all cases": [
    checkComparison,
    ["compare", ...four, "--cases", "all", "--replicates", "2", "--strategy", "SD,SD,LPT,LPT"],
  ],
  sweep: [checkSweep, ["sweep", ...robust, "--greedy"]],
  "sweep many": [checkSweep, ["sweep", ...robust, ...speeds, ...many]],
  "sweep random": [
    checkSweep,
    ["sweep", ...robust, ...speeds, "--greedy", "--patterns", "poisson:0.15:6"],
  ],
  "sweep robots": [
    checkSweep,
    ["sweep", "--sweep", "robots", "--to", "3", "--train-items", "10", "--patterns", "balanced:3"],
  ],
  "sweep thresholds": [
    checkThresholds,
    [
      ...["sweep", "--sweep", "min-detection", "--from", "0.4", "--to", "0.8", "--step", "0.2"],
      ...["--patterns", "poisson:0.2:4", "--items", "40", "--p-detection", "uniform:0.4,1"],
      ...["--purity", "0.75", ...robust, "--strategy", "FIFO,FIFO"],
    ],
  ],
  optimize: [checkOptimum, ["optimize", ...small]],
  "optimize beside strategies": [
    checkOptimum,
    ["optimize", ...small, "--strategy", "onnx", "--strategy", "lookahead:budget=50"],
  ],
  "optimize four robots": [checkOptimum, ["optimize", "--robots", "4", ...small]],
};

await withBrowser(async (folder, browser) => {
  for (const [name, [checkReport, args]] of Object.entries(runs)) {
    const { file, report } = cleanRun(folder, name.replaceAll(" ", "-"), args);
    const { page, check } = await open(browser, file);
    const paths = await checkFigures(page, report);
    await checkReport(page, report, paths);
    await checkTexts(page);
    await page.close();
    await checkLooks(browser, file);
    check();
    console.log(`${name}: ${paths.size} figures, ok`);
  }
});
