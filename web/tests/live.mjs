// A run on a virtual rig, looked at in Recordings while it is recorded, up to the file that it becomes.
import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { cpSync, existsSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { join } from "node:path";
import { address, assertAccessible, base, drawn, folder, newPage, picture, program, root, scratch, test } from "./harness.mjs";

const freePort = () => new Promise((found) => {
  const door = createServer();
  door.listen(0, "127.0.0.1", () => {
    const { port } = door.address();
    door.close(() => found(port));
  });
});

const place = join(scratch, "live rig"), run = join(folder, "live run");
let started;
process.on("exit", () => started?.kill("SIGKILL"));

async function begin() {
  cpSync(join(root, "stations/frames"), join(place, "frames"), { recursive: true });
  let station = readFileSync(join(root, "stations/gyro_scale_factor.toml"), "utf8");
  for (const port of ["21151", "21152", "21153"]) station = station.replace(port, String(await freePort()));
  writeFileSync(join(place, "station.toml"), station);
  cpSync(join(root, "plans/gyro_scale_factor.toml"), join(place, "plan.toml"));
  started = spawn(program, ["run", join(place, "plan.toml"), "--station", join(place, "station.toml"), "--unit", "unit=7", "--operator", "Li Wei",
    "-o", run, "--virtual-rig", "--speed", "20"], { stdio: "ignore" });
  for (let i = 0; i < 200 && spawnSync(program, ["answer", run, "done", "--operator", "Li Wei"]).status !== 0; ++i)
    await new Promise((later) => setTimeout(later, 100));
  for (let i = 0; i < 200 && !existsSync(join(run, "live.samples")); ++i) await new Promise((later) => setTimeout(later, 100));
}

const last = (page) => page.getByTestId("live").getAttribute("data-last").then(Number);
const span = (page) => address(page).get("span")?.split(",").map(Number);

/// Every sample of the span, as CSV gives it, lies in the bar that the view gives.
async function assertInside(page, file, from, to) {
  const query = new URLSearchParams({ file, from, to });
  const found = await page.evaluate(async (question) => {
    const bytes = await (await fetch(`/api/recording/view?${question}&pixels=20`)).arrayBuffer();
    const numbers = (at, count) => Array.from(new Float64Array(bytes, at, count));
    const [samples, count, , block, offset] = numbers(8, 7);
    const times = numbers(64, count), low = new Float32Array(bytes, 64 + 8 * count, count);
    const high = new Float32Array(bytes, 64 + 8 * count + 8 * Math.ceil(count / 2), count);
    const text = await (await fetch(`/api/recording/csv?${question}`)).text();
    return { samples, block, offset, times, low: Array.from(low), high: Array.from(high), text };
  }, query.toString());
  assert.equal(found.samples, 0);
  assert.ok(found.block > 1);
  let bar = 0, inside = 0;
  for (const line of found.text.trim().split("\n").slice(1)) {
    const [time, value] = line.split(",").map(Number);
    while (bar + 1 < found.times.length && found.times[bar + 1] <= time) ++bar;
    if (found.times[bar] > time) continue;
    let first = bar; // samples that arrived together have one time, and may be the end of a bar and the begin of the next
    while (first > 0 && found.times[first] === time) --first;
    const least = found.offset + Math.min(...found.low.slice(first, bar + 1)), most = found.offset + Math.max(...found.high.slice(first, bar + 1));
    const little = 1e-9 * Math.max(Math.abs(least), Math.abs(most)); // CSV is in the unit, rounded to its digits
    assert.ok(value >= least - little && value <= most + little, `${time}: ${value} is not in ${least} ... ${most}`);
    ++inside;
  }
  assert.ok(inside > 100, `${inside} samples`);
}

test("a recording that goes on is looked at, follows its end, and leads to its file", async () => {
  await begin();
  const file = "live run/live.samples";
  const page = await newPage();
  await page.getByTestId("recordings").getByText("● is being recorded").waitFor();
  await page.getByRole("link", { name: file }).click();
  await page.locator(".row .u-over").first().waitFor();
  await page.getByText(/Recording, .* so far/).waitFor();
  const before = await last(page);
  await page.waitForFunction((seen) => Number(document.querySelector("[data-testid=live]").dataset.last) > seen + 20, before);
  assert.ok((await page.locator(".row").count()) >= 1);
  await page.keyboard.press("+"); // about the middle: the end is no longer seen
  await page.getByRole("button", { name: "Back to the end" }).click();
  await page.getByText("the view follows the end").waitFor();
  const shown = span(page), width = shown[1] - shown[0];
  await page.waitForFunction((to) => Number(new URL(location.href).searchParams.get("span").split(",")[1]) > to + 10, shown[1]);
  const now = span(page);
  assert.ok(Math.abs(now[1] - now[0] - width) < 1e-6 * width, "the width stays");
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("ArrowLeft");
  await page.getByRole("button", { name: "Back to the end" }).waitFor();
  const stood = span(page), at = await last(page);
  await page.waitForFunction((seen) => Number(document.querySelector("[data-testid=live]").dataset.last) > seen + 20, at);
  assert.deepEqual(span(page), stood, "a view that was moved away from the end stays");
  await drawn(page);
  await assertAccessible(page, "live");
  await assertInside(page, file, 0, await last(page));
  await page.keyboard.press("0");
  await drawn(page);
  await picture(page, "recording-live");
  assert.equal(spawnSync(program, ["stop", run]).status, 0);
  await page.getByText("Its file is not there yet", { exact: false }).waitFor({ timeout: 30000 });
  for (let i = 0; i < 100 && spawnSync(program, ["seal", run]).status !== 0; ++i) await new Promise((later) => setTimeout(later, 100));
  await page.getByText("The recording has ended. Its file:").waitFor({ timeout: 30000 });
  assert.ok(!existsSync(join(run, "live.samples")), "the file that was sealed is looked at from now on");
  await page.getByRole("link", { name: "live run/recording.h5" }).click();
  await page.getByRole("heading", { level: 1, name: "live run/recording.h5" }).waitFor();
  await page.locator(".row .u-over").first().waitFor();
});
