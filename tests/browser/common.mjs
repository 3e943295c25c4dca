// What browser tests share: the program, the browser, and pages that are watched for
// errors and for requests to anywhere.

import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

// From run.sh.
const { PICKLINE, MODULES } = process.env;
const { chromium } = createRequire(join(MODULES, "package.json"))("playwright-core");

/** Runs the program; its stdout. */
export function pickline(...args) {
  return execFileSync(PICKLINE, args, { encoding: "utf8", maxBuffer: 1 << 28 });
}

/** Runs `test` with a folder and a browser that are gone afterwards. */
export async function withBrowser(test) {
  const folder = mkdtempSync(join(tmpdir(), "pickline-browser-"));
  const browser = await chromium.launch({
    executablePath: "/usr/bin/chromium",
    args: [
      "--headless",
      "--no-sandbox",
      "--disable-gpu",
      "--disable-quic",
      "--no-first-run",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
    ],
  });
  try {
    await test(folder, browser);
  } finally {
    await browser.close();
    rmSync(folder, { recursive: true });
  }
}

/** Starts the program; what it says on stdout as messages, on stderr as text, and its exit
 * code when it has ended. It does not outlive the test. */
export function start(...args) {
  const child = spawn(PICKLINE, args);
  process.once("exit", () => child.kill("SIGKILL"));
  const said = { out: "", err: "" };
  child.stdout.on("data", (part) => (said.out += part));
  child.stderr.on("data", (part) => (said.err += part));
  // One that has ended hears no more.
  child.stdin.on("error", () => {});
  const whole = () => said.out.slice(0, said.out.lastIndexOf("\n") + 1);
  const lines = () =>
    whole()
      .split("\n")
      .filter(Boolean)
      .map((line) => JSON.parse(line));
  const ended = new Promise((tell) => child.on("close", tell));
  return { child, lines, errors: () => said.err, ended };
}

/** Opens `address`; `check` asserts that nothing went wrong, save what was allowed, and
 * that nothing was asked for anywhere else. */
export async function watched(browser, address, options = {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 }, ...options });
  const troubles = [];
  let allowed = null;
  const trouble = (text) => {
    if (!allowed?.test(text)) troubles.push(text);
  };
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) trouble(message.text());
  });
  page.on("pageerror", (error) => trouble(String(error)));
  page.on("request", (request) => {
    if (!request.url().startsWith(address)) trouble(`requests ${request.url()}`);
  });
  await page.goto(address);
  const check = () => assert.deepEqual(troubles, []);
  const allow = (pattern) => (allowed = pattern);
  return { page, check, allow };
}

/** Opens `file`, which must ask for nothing else. */
export function open(browser, file, options = {}) {
  return watched(browser, pathToFileURL(file).href, options);
}
