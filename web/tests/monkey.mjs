// Recordings that nobody would make, and somebody who presses everything: no page complains, nothing is wider than it.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { assertAccessible, base, complaints, drawn, folder, newPage, test } from "./harness.mjs";

const lines = (head, count, row) => [head, ...Array.from({ length: count }, (_, i) => row(i))].join("\n") + "\n";
const markup = "<img src=x onerror=alert(1)>";
const recordings = {
  "one sample.csv": lines("time[s],gyro.x[deg/h]", 1, () => "0,1"),
  "two samples.csv": lines("time[s],gyro.x[deg/h]", 2, (i) => `${i},${i}`),
  "constant.csv": lines("time[s],gyro.x[deg/h]", 500, (i) => `${i * 0.01},7`),
  "all missing.csv": lines("time[s],gyro.x[deg/h],acc.z[g]", 500, (i) => `${i * 0.01},,${i % 7}`),
  "huge.csv": lines("time[s],gyro.x[deg/h],acc.z[g]", 500, (i) => `${i * 0.01},${i === 250 ? 1e300 : 1},1e-300`),
  "gaps.csv": lines("time[s],gyro.x[deg/h]", 500, (i) => `${i * 0.01 + Math.floor(i / 50) * 1000},${i % 11}`),
  "negative times.csv": lines("time[s],gyro.x[deg/h]", 500, (i) => `${i * 0.01 - 1e6},${i % 11}`),
  "200 channels.csv": lines("time[s]," + Array.from({ length: 200 }, (_, i) => `channel ${i}[V]`).join(","), 200, (i) => `${i * 0.01},` + Array(200).fill(i % 13).join(",")),
  [`${markup.replaceAll("/", "")}.csv`]: lines(`time[s],"${markup}"[deg/h]`, 100, (i) => `${i * 0.01},${i}`),
};
for (const [name, text] of Object.entries(recordings)) writeFileSync(join(folder, name), text);

/// A generator of numbers from 0 to 1, the same in each run (mulberry32).
function chanceOf(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

const fits = async (page, what) => {
  const [whole, seen] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  if (whole > seen + 1) complaints.push(`${what}: ${whole} of ${seen} pixels`);
};

test("recordings that nobody would make are shown", async () => {
  for (const size of [{ width: 1280, height: 900 }, { width: 360, height: 740 }]) {
    const page = await newPage({ viewport: size });
    page.on("dialog", (dialog) => complaints.push(`a dialog: ${dialog.message()}`));
    for (const name of Object.keys(recordings)) {
      await page.goto(`${base}/?file=${encodeURIComponent(name)}`);
      await page.getByRole("heading", { level: 1, name }).waitFor();
      await page.locator(".u-over, .notice").first().waitFor();
      await drawn(page);
      await fits(page, name);
      if (size.width === 360 && name.startsWith("200")) continue; // axe takes a minute for 200 plots
      if (size.width === 360) await assertAccessible(page, name);
      for (const key of ["+", "+", "ArrowRight", "a", "b", "-", "0", "n", "p", "z", "t", "u"]) await page.keyboard.press(key);
      await drawn(page);
    }
    await page.close();
  }
});

const rooms = ["/", "/plans", "/results", "/station", "/archive"];
const odd = ["nan,inf", "1e999,2", "5,1", "-1,-2", "0,0", "1e308,-1e308", "<b>", "%00", "a".repeat(3000), "🙂", ",", "../..", ""];
const keys = ["Tab", "Enter", "Escape", "Space", "ArrowLeft", "ArrowRight", "ArrowUp", "+", "-", "0", "a", "b", "n", "p", "z", "?", "t", "u", "Home", "End", "Delete"];

/// One thing that somebody does.
async function doSomething(page, chance) {
  const pick = (all) => all[Math.floor(chance() * all.length)];
  const kind = chance();
  if (kind < 0.4) {
    const things = page.locator("button:visible, a:visible, select:visible, input:visible, summary:visible, canvas:visible, .u-over:visible");
    const count = await things.count();
    if (count > 0) await things.nth(Math.floor(chance() * count)).click({ timeout: 500, noWaitAfter: true, trial: false }).catch(() => undefined);
  } else if (kind < 0.6) {
    await page.keyboard.press(pick(keys));
  } else if (kind < 0.7) {
    const [x, y] = [chance() * 300, chance() * 700];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + chance() * 200, y + 5);
    await page.mouse.up();
    await page.mouse.wheel(0, (chance() - 0.5) * 2000);
  } else if (kind < 0.8) {
    await page.goBack({ timeout: 1000, waitUntil: "commit" }).catch(() => undefined);
  } else if (kind < 0.85) {
    await page.setViewportSize({ width: pick([320, 360, 700, 1280, 1920]), height: pick([400, 740, 1000]) });
  } else {
    const query = new URLSearchParams();
    for (const name of ["file", "span", "zoom", "figure", "a", "b", "channel", "unit", "compare", "template", "run", "time", "plan"])
      if (chance() < 0.25) query.set(name, name === "file" && chance() < 0.7 ? pick(Object.keys(recordings)) : pick(odd));
    await page.goto(`${base}${pick(rooms)}?${query}`, { waitUntil: "commit" }).catch(() => undefined); // a step back may still be under way
  }
}

test("somebody presses everything", async () => {
  const chance = chanceOf(Number(process.env.SEED ?? 20261127)), page = await newPage();
  page.on("dialog", (dialog) => dialog.dismiss().catch(() => undefined));
  await page.goto(`${base}/?file=${encodeURIComponent("gaps.csv")}`);
  const end = Date.now() + Number(process.env.SECONDS ?? 15) * 1000;
  let before = 0;
  while (Date.now() < end) {
    await doSomething(page, chance);
    if (complaints.length > before) console.log(`     at ${page.url().slice(0, 300)}: ${complaints[complaints.length - 1].slice(0, 200)}`);
    before = complaints.length;
  }
  await page.goto(`${base}/`);
  await page.getByTestId("recordings").waitFor();
  assert.equal(await page.getByRole("heading", { level: 1 }).count(), 1);
});
