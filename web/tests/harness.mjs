// The program and a browser, and what tests of all rooms do with them.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const [program, pictures] = process.argv.slice(2).map((path) => resolve(path));
export const root = resolve(dirname(fileURLToPath(import.meta.url)), "../..");
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
/// A folder for files of the tests; the workbench shows `folder` in it.
export const scratch = mkdtempSync(join(tmpdir(), "tumble-browser-"));
export const folder = join(scratch, "measurements");
mkdirSync(folder);
mkdirSync(pictures, { recursive: true });
export const environment = { ...process.env, XDG_CACHE_HOME: join(scratch, "cache"), XDG_STATE_HOME: join(scratch, "state") };

/// A server over a folder, with these options; ended by its own test.
export function startServer(where = folder, ...options) {
  return new Promise((started, failed) => {
    const server = spawn(program, ["serve", where, "--port", "0", ...options], { env: environment });
    let text = "";
    server.stdout.on("data", (bytes) => {
      text += bytes;
      const link = /https?:\S+/.exec(text)?.[0];
      if (link) started({ server, link });
    });
    server.on("exit", () => failed(new Error("the server ended: " + text)));
    server.stderr.on("data", (bytes) => process.stderr.write(bytes));
  });
}

const tests = [];
export const test = (name, run) => tests.push({ name, run });
export const complaints = [];
/// Where the server is, and its link with the token; known when tests run.
export let browser, link, base;

export async function newPage(options = {}, opened = true) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, locale: "en-GB", ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(15000);
  page.on("console", (message) => {
    if (message.type() === "error" && !/status of (4\d\d|202)/.test(message.text())) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error.stack ?? error)));
  if (opened) {
    await page.goto(link);
    await page.getByRole("heading", { level: 1 }).first().waitFor();
  }
  return page;
}

/// Until the page asks nothing more.
export async function drawn(page) {
  await page.waitForTimeout(100); // statistics are asked for when the span has been the same for a moment
  await page.waitForFunction(() => document.querySelector("main")?.getAttribute("aria-busy") !== "true");
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

export const picture = (page, name) => page.screenshot({ path: join(pictures, name + ".png") });
export const address = (page) => new URL(page.url()).searchParams;

export async function assertAccessible(page, what) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  const serious = violations.filter((violation) => ["serious", "critical"].includes(violation.impact));
  assert.deepEqual(serious.map((violation) => `${violation.id}: ${violation.nodes.map((node) => node.html.slice(0, 120)).join(" | ")}`), [], what);
}

/// A test that waits for what never comes fails, and lets the others run.
function withinTime(run) {
  const longest = 90000;
  let timer;
  const late = new Promise((_, refuse) => (timer = setTimeout(() => refuse(new Error(`no end within ${longest / 1000} s`)), longest)));
  return Promise.race([run(), late]).finally(() => clearTimeout(timer));
}

export async function runAll() {
  const { server, link: printed } = await startServer();
  link = printed;
  base = new URL(link).origin;
  const launch = () =>
    chromium.launch({
      executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
      args: process.getuid() === 0 ? ["--no-sandbox"] : [],
    });
  browser = await launch().catch(launch); // on a machine that is short of time the first one may not come up
  const only = process.env.ONLY;
  let failures = 0;
  for (const { name, run } of tests) {
    if (only && !name.includes(only)) continue;
    const begin = Date.now();
    complaints.length = 0;
    try {
      await withinTime(run);
      assert.deepEqual(complaints, [], "the browser complains");
      console.log(`ok   ${name} (${Date.now() - begin} ms)`);
    } catch (error) {
      ++failures;
      console.log(`FAIL ${name}\n${error.stack}`);
      for (const context of browser.contexts())
        for (const page of context.pages()) await page.screenshot({ path: join(pictures, `failed-${failures}.png`) }).catch(() => undefined);
    }
    for (const context of browser.contexts()) await context.close();
  }
  await browser.close();
  server.removeAllListeners("exit");
  server.kill("SIGTERM");
  rmSync(scratch, { recursive: true, force: true });
  console.log(`${tests.length - failures} of ${tests.length} tests passed; pictures in ${pictures}`);
  process.exit(failures === 0 ? 0 : 1);
}
