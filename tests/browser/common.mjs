// What browser tests share: the program, the browser, and pages that are watched for
// errors and for requests to anywhere.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
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

/** Opens `file`; `check` asserts that nothing went wrong and nothing else was asked for. */
export async function open(browser, file, options = {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 }, ...options });
  const address = pathToFileURL(file).href;
  const troubles = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) troubles.push(message.text());
  });
  page.on("pageerror", (error) => troubles.push(String(error)));
  page.on("request", (request) => {
    if (request.url() !== address) troubles.push(`requests ${request.url()}`);
  });
  await page.goto(address);
  const check = () => assert.deepEqual(troubles, []);
  return { page, check };
}
