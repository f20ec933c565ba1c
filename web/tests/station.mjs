// The station: a run on a virtual rig, over real links, begun, watched, answered and stopped in the browser.
import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { cpSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { join } from "node:path";
import { assertAccessible, browser, complaints, drawn, environment, picture, program, root, scratch, test } from "./harness.mjs";

const bench = join(scratch, "bench");
mkdirSync(bench);

/// Below the ports that a system gives to connections: none of those takes it before the program listens.
async function freePort() {
  for (;;) {
    const port = 20000 + Math.floor(12000 * Math.random());
    const door = createServer();
    const free = await new Promise((tell) => door.once("error", () => tell(false)).listen(port, "127.0.0.1", () => tell(true)));
    if (free) return new Promise((closed) => door.close(() => closed(port)));
  }
}

let server, port, origin;
/// A station at free ports, and a plan with many segments, of which the first asks for the unit to be mounted.
async function prepare() {
  if (port) return;
  port = await freePort();
  origin = `http://127.0.0.1:${port}`;
  cpSync(join(root, "stations/frames"), join(bench, "frames"), { recursive: true });
  let text = readFileSync(join(root, "stations/gyro_scale_factor.toml"), "utf8");
  for (const port of ["21151", "21152", "21153"]) text = text.replace(port, String(await freePort()));
  writeFileSync(join(bench, "rate table.toml"), text.replaceAll('"3 s"', '"1 s"'));
  const plan = readFileSync(join(root, "plans/gyro_scale_factor.toml"), "utf8");
  writeFileSync(join(bench, "scale.toml"), plan.replaceAll('"62 s"', '"30 s"'));
  writeFileSync(join(bench, "broken station.toml"), '[station]\nname = "x"\n[[device]]\nname = "a"\ncontroler = "y"\n');
}

/// A server of this room: it is killed in the middle of a run.
async function serve() {
  if (server?.exitCode === null && server.signalCode === null) await kill(); // of a test that has failed
  server = spawn(program, ["serve", bench, "--port", String(port), "--no-token"], { env: environment });
  for (;;) {
    try {
      await fetch(origin + "/api/workbench");
      return;
    } catch {
      await new Promise((later) => setTimeout(later, 50));
    }
  }
}
const kill = () => new Promise((ended) => {
  server.once("exit", ended);
  server.kill("SIGKILL");
});

let run = "";
process.on("exit", () => {
  server?.kill("SIGKILL");
  if (run) spawnSync(program, ["answer", join(bench, run), "abort", "--operator", "the end of the tests"]);
});

/// The process that does this to a run, by its command line.
function processOf(verb, folder) {
  const found = readdirSync("/proc").filter((name) => /^\d+$/.test(name)).find((name) => {
    try {
      const words = readFileSync(`/proc/${name}/cmdline`, "utf8").split("\0");
      return words[1] === verb && words.includes(folder);
    } catch {
      return false;
    }
  });
  return Number(found);
}

const stateOf = async () => (await fetch(`${origin}/api/station/run?run=${encodeURIComponent(run)}`)).json();
async function until(holds, what) {
  for (let i = 0; i < 150; ++i) {
    const state = await stateOf();
    if (holds(state)) return state;
    await new Promise((later) => setTimeout(later, 100));
  }
  assert.fail(what);
}

async function open(path, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, locale: "en-GB", ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(15000);
  page.on("pageerror", (error) => complaints.push(String(error.stack ?? error)));
  await page.goto(origin + path);
  await page.getByRole("heading", { level: 1 }).first().waitFor();
  return page;
}
/// A field of the form, by the beginning of its label.
const field = (page, label) => page.locator("label").filter({ hasText: new RegExp("^" + label) }).locator("select, input");
const openRun = (options) => open("/station?run=" + encodeURIComponent(run), options);
const idsOn = (page) => page.getByTestId("log").locator("li").evaluateAll((all) => all.map((one) => Number(one.dataset.id)).reverse());

test("station: all problems of a run are shown before anything moves", async () => {
  await prepare();
  await serve();
  const page = await open("/station");
  await page.getByText("unknown key 'controler'", { exact: false }).waitFor();
  await field(page, "Plan").selectOption("scale.toml");
  await field(page, "How").selectOption("virtual");
  await field(page, "Station").selectOption("rate table.toml");
  await page.getByRole("button", { name: "Check without moving" }).click();
  await page.getByText("problems: 2").waitFor();
  await page.getByText("the operator is missing", { exact: false }).waitFor();
  await page.getByText("slot 'unit': the unit has no serial number", { exact: false }).waitFor();
  assert.ok(await page.getByRole("button", { name: "Begin", exact: true }).isDisabled());
  await field(page, "Serial number in slot unit").fill("0173");
  await field(page, "Operator").fill("Li Wei");
  await page.getByRole("button", { name: "Check without moving" }).click();
  await page.getByText("nothing speaks against it").waitFor();
  await page.getByText("0:13:00 in 26 segments", { exact: false }).waitFor();
  await assertAccessible(page, "station");
  await picture(page, "station");
  // Nobody is at the links: the check of the devices says so.
  await page.getByRole("button", { name: "Check the devices" }).click();
  await page.getByText("Connection refused", { exact: false }).first().waitFor();
});

test("station: a run on a virtual rig asks, is answered, and moves", async () => {
  const page = await open("/station");
  await field(page, "Plan").selectOption("scale.toml");
  await field(page, "How").selectOption("virtual");
  await field(page, "Station").selectOption("rate table.toml");
  await field(page, "Serial number in slot unit").fill("0173");
  await field(page, "Operator").fill("Li Wei");
  await field(page, "Speed of the clock").fill("10");
  await page.getByRole("button", { name: "Begin", exact: true }).click();
  await page.getByRole("heading", { name: "For you" }).waitFor();
  run = new URL(page.url()).searchParams.get("run");
  assert.match(run, /^runs\/scale-\d{8}-\d{6}$/);
  await page.getByText("virtual rig", { exact: true }).waitFor();
  await page.getByRole("button", { name: "done", exact: true }).click();
  await page.getByText("Li Wei: 'done' to question 1").waitFor();
  await page.getByTestId("state").filter({ hasText: "recording" }).waitFor();
  assert.match(await page.getByTestId("axes").innerText(), /table\s+-120 deg\/s.*-1(19\.9|20)/s, "demanded and actual");
  await until((state) => (state.curves?.recent.length ?? 0) > 6, "curves grow");
  await drawn(page);
  assert.ok((await page.locator(".live-row canvas").count()) >= 1);
  assert.ok((await page.locator(".timeline li.now progress").count()) === 1, "how far the segment is");
  await assertAccessible(page, "run");
});

test("station: reload and a killed server lose nothing, and the run goes on", async () => {
  const page = await openRun();
  await page.getByLabel("every step").check();
  await until((state) => state.view.segments[0].state === "done", "a segment is done");
  await page.reload();
  await page.getByTestId("log").waitFor();
  await page.getByLabel("every step").check();
  const before = await idsOn(page);
  assert.ok(before.length > 5);
  await kill();
  await page.getByText("No connection to the program since", { exact: false }).waitFor();
  await new Promise((later) => setTimeout(later, 1500));
  await serve();
  await page.getByText("No connection to the program since", { exact: false }).waitFor({ state: "hidden" });
  const state = await until((now) => now.view.segments[1].state === "done", "it went on");
  await page.waitForFunction((last) => [...document.querySelectorAll("[data-testid=log] li")].some((one) => Number(one.dataset.id) >= last), state.events.at(-1).id);
  const shown = await idsOn(page), all = (await stateOf()).events.map((event) => event.id);
  assert.deepEqual(shown, all.slice(0, shown.length), "every event once, in order");
  assert.deepEqual(before, shown.slice(0, before.length));
  assert.equal(state.view.lost + state.view.damaged, 0, "the recorder lost nothing");
  // A program that names the last number gets what is behind it, and nothing twice.
  const answer = await fetch(`${origin}/api/station/run/events?run=${encodeURIComponent(run)}`, { headers: { "Last-Event-ID": String(before.at(-1)) } });
  const first = new TextDecoder().decode((await answer.body.getReader().read()).value);
  assert.ok(Number(/^id: (\d+)/.exec(first)[1]) > before.at(-1), first);
  await picture(page, "station-run");
});

test("station: on a phone the way to stop is always on the screen, also in Chinese", async () => {
  const page = await openRun({ viewport: { width: 390, height: 800 }, locale: "zh-CN", hasTouch: true });
  await page.getByRole("button", { name: "停止" }).waitFor();
  const width = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.ok(width[0] <= width[1], `no sideways scroll: ${width}`);
  for (const place of [0, 100000]) {
    await page.evaluate((top) => scrollTo(0, top), place);
    const box = await page.getByRole("button", { name: "停止" }).boundingBox();
    assert.ok(box.y >= 0 && box.y + box.height <= 800 && box.height >= 44 && box.width >= 100, JSON.stringify(box));
  }
  await page.evaluate(() => scrollTo(0, 0));
  await page.getByText("采集中").or(page.getByText("稳定中")).or(page.getByText("运动中")).first().waitFor();
  await assertAccessible(page, "phone, Chinese");
  await picture(page, "station-phone");
});

test("station: one press stops the run, the rig is safe, and the run can be carried on", async () => {
  const page = await openRun();
  // What the method makes of everything so far, beside the uncertainty that the plan will have reached at its end.
  const running = await until((now) => now.estimates.some((one) => one.points.length > 2), "estimates converge");
  const predicted = await (await fetch(`${origin}/api/station/run/predicted?run=${encodeURIComponent(run)}`)).json();
  const of = predicted.rows.find((row) => running.estimates.some((one) => one.name === row.name && one.unit === row.unit));
  const row = page.getByTestId("estimates").locator("tbody tr").filter({ has: page.getByRole("button", { name: of.name, exact: true }) });
  await row.getByText(of.text, { exact: true }).waitFor();
  await row.getByRole("button").click();
  await page.getByTestId("convergence").locator("canvas").waitFor();
  assert.match(await page.getByTestId("convergence").innerText(), /estimate so far[^]*predicted u/);
  await page.screenshot({ path: join(root, "build/browser/station-converging.png"), fullPage: true });
  await page.getByRole("button", { name: "STOP" }).click();
  await page.getByTestId("state").filter({ hasText: "stopped, the rig is safe" }).waitFor();
  await page.getByRole("button", { name: "Carry the run on" }).waitFor();
  const state = await stateOf();
  assert.equal(state.alive, false);
  assert.ok(state.events.some((event) => event.kind === "end" && event.text === "stopped"));
  assert.equal(await page.getByRole("button", { name: "STOP" }).count(), 0);
  await assertAccessible(page, "run that has ended");
  await field(page, "Your name").fill("Zhang Min");
  await field(page, "Speed of the clock").fill("10");
  await page.getByRole("button", { name: "Carry the run on" }).click();
  await page.getByRole("button", { name: "STOP" }).waitFor();
  await until((now) => now.alive && now.view !== null, "it prepares");
  // Nobody knows what a rig does whose run was killed: that is said loudly.
  process.kill(processOf("resume", join(bench, run)), "SIGKILL");
  await page.getByRole("alert").filter({ hasText: "interrupted: nobody knows the state of the rig. Go to the rig" }).waitFor();
  assert.match(await page.title(), /^⚠ interrupted/);
  await assertAccessible(page, "interrupted");
  await picture(page, "station-alarm");
  await page.getByRole("link", { name: "Station" }).click();
  await page.getByTestId("runs").getByText("has ended").waitFor();
  run = "";
  await kill();
});

test("station: a rehearsal needs no station, and its recording opens", async () => {
  await prepare();
  await serve();
  writeFileSync(join(bench, "short.toml"), readFileSync(join(bench, "scale.toml"), "utf8").split('[[schedule]]\nlabel    = "up -60')[0]);
  const page = await open("/station");
  await field(page, "Plan").selectOption("short.toml");
  await page.getByRole("button", { name: "Begin", exact: true }).click();
  await page.getByTestId("state").filter({ hasText: "complete" }).waitFor();
  await page.getByRole("link", { name: /Open runs\/short-.*\.h5/ }).waitFor();
  await kill();
});
