// Recordings: the list, the views, uploads, jobs.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { address, assertAccessible, base, drawn, folder, link, newPage, picture, pictures, program, root, scratch, test } from "./harness.mjs";

/// A rate table run: rest, turning, rest; with a spike, a gap and missing samples.
function recordingText(samples) {
  const lines = ["time[s],gyro.x[deg/s],gyro.z[deg/s],acc.z[m/s^2],temperature[degC],segment"];
  let random = 1;
  const noise = () => {
    let sum = 0;
    for (let i = 0; i < 6; ++i) sum += (random = (random * 16807) % 2147483647) / 2147483647 - 0.5;
    return sum;
  };
  for (let i = 0; i < samples; ++i) {
    const part = Math.floor((3 * i) / samples), time = i / 200 + (i > 0.8 * samples ? 0.4 : 0);
    const rate = part === 1 ? 30 * Math.sin((2 * Math.PI * (3 * i - samples)) / samples) : 0;
    const spike = i === Math.floor(0.2 * samples) ? 4 : 0;
    const missing = i % 5000 < 4 && i > 100;
    lines.push([time.toFixed(4), missing ? "" : (0.02 * noise() + spike).toFixed(6), (rate + 0.02 * noise()).toFixed(6),
      (9.8 + 0.001 * noise()).toFixed(7), (20 + i / samples + 0.01 * noise()).toFixed(4), ["rest", "turning", "rest again"][part]].join(","));
  }
  return lines.join("\n") + "\n";
}

writeFileSync(join(scratch, "table.csv"), recordingText(60000));
execFileSync(program, ["--quiet", "convert", join(scratch, "table.csv"), "-o", join(folder, "table run.h5"), "--set", "segment_column=segment"]);
copyFileSync(join(root, "examples/data/mpu6050_static.csv"), join(folder, "mpu6050_static.csv"));
writeFileSync(join(scratch, "no rate.csv"), "gyro[deg/h]\n" + Array.from({ length: 2000 }, (_, i) => (i * 7919) % 101).join("\n") + "\n");
const plan = execFileSync(program, ["list", "methods"], { encoding: "utf8" });
assert.match(plan, /allan_noise/);

async function openRecording(page, name, query = "") {
  await page.goto(`${base}/?file=${encodeURIComponent(name)}${query}`);
  await page.locator(".row .u-over").first().waitFor();
  await drawn(page);
}

const span = (page) => address(page).get("span")?.split(",").map(Number);

/// Parts of the canvas of a row that have the colour of the curve.
async function curveColumns(page, row) {
  return page.locator(".row canvas").nth(row).evaluate((canvas) => {
    const { width, height } = canvas, pixels = canvas.getContext("2d").getImageData(0, 0, width, height).data;
    let columns = 0;
    for (let x = 0; x < width; ++x)
      for (let y = 0; y < height; ++y) {
        const at = 4 * (y * width + x);
        if (pixels[at + 3] > 200 && pixels[at + 2] > pixels[at] + 60) {
          ++columns;
          break;
        }
      }
    return columns / width;
  });
}

test("without the link nothing is shown", async () => {
  const page = await newPage({}, false);
  await page.goto(base);
  await page.getByText("Open the workbench by the link", { exact: false }).first().waitFor();
  assert.equal(await page.getByRole("table").count(), 0);
  await assertAccessible(page, "closed");
});

test("the token leaves the address and no script can read it", async () => {
  const page = await newPage();
  assert.equal(page.url(), base + "/");
  assert.equal(await page.evaluate(() => document.cookie), "");
  const cookies = await page.context().cookies();
  assert.equal(cookies.length, 1);
  assert.ok(cookies[0].httpOnly && cookies[0].sameSite === "Strict");
});

test("the list says what is in each recording", async () => {
  const page = await newPage();
  const row = page.getByRole("row").filter({ hasText: "table run.h5" });
  await row.getByText("findings:").waitFor();
  assert.match(await row.innerText(), /gyro\.x, gyro\.z, acc\.z, temperature/);
  assert.match(await row.innerText(), /5 min 0 s/);
  assert.match(await row.innerText(), /60,000/);
  await page.getByLabel("Search").fill("mpu");
  assert.equal(await page.getByRole("row").count(), 2);
  await page.getByLabel("Search").fill("");
  await assertAccessible(page, "list");
  await picture(page, "list");
  assert.deepEqual(await page.getByRole("navigation").getByRole("link").allInnerTexts(), ["Recordings", "Plans", "Results", "Station", "Archive"]);
});

test("channels are stacked under each other with one gutter", async () => {
  const page = await newPage();
  await openRecording(page, "table run.h5");
  await page.getByTestId("findings").getByRole("listitem").first().waitFor();
  const boxes = await page.locator(".row .u-over").evaluateAll((all) => all.map((one) => one.getBoundingClientRect().toJSON()));
  assert.equal(boxes.length, 4);
  for (const box of boxes) {
    assert.equal(box.left, boxes[0].left);
    assert.equal(box.width, boxes[0].width);
    assert.ok(box.height > 80);
  }
  for (let i = 1; i < 4; ++i) assert.ok(boxes[i].top >= boxes[i - 1].bottom);
  const above = await page.locator(".overview .u-over").evaluate((one) => one.getBoundingClientRect().toJSON());
  assert.ok(Math.abs(above.left - boxes[0].left) <= 2 && Math.abs(above.width - boxes[0].width) <= 4);
  const segments = await page.locator(".segments button").allInnerTexts();
  assert.deepEqual(segments, ["rest", "turning", "rest again"]);
  const strip = await page.locator(".segments").evaluate((one) => one.getBoundingClientRect().toJSON());
  assert.ok(Math.abs(strip.left - boxes[0].left) <= 2 && Math.abs(strip.width - boxes[0].width) <= 2);
  for (let i = 0; i < 4; ++i) assert.ok((await curveColumns(page, i)) > 0.8, `row ${i} is drawn`);
  assert.match(await page.getByTestId("what-is-drawn").innerText(), /each bar spans/);
  await assertAccessible(page, "recording");
  await picture(page, "recording");
});

test("keys zoom, pan and show all, and the address follows", async () => {
  const page = await newPage();
  await openRecording(page, "table run.h5");
  await page.keyboard.press("+");
  await drawn(page);
  const [from, to] = span(page);
  assert.ok(Math.abs(to - from - 150.2) < 0.5, String(span(page)));
  await page.keyboard.press("ArrowRight");
  assert.ok(Math.abs(span(page)[0] - from - 0.2 * (to - from)) < 1e-6);
  for (let i = 0; i < 9; ++i) await page.keyboard.press("+");
  await drawn(page);
  await page.getByText("every sample is drawn").waitFor();
  const before = page.url();
  await page.reload();
  await page.locator(".row .u-over").first().waitFor();
  assert.equal(page.url(), before);
  await page.keyboard.press("0");
  assert.equal(span(page), undefined);
  await page.locator(".segments button", { hasText: "turning" }).click();
  assert.ok(Math.abs(span(page)[0] - 100) < 0.1 && Math.abs(span(page)[1] - 200) < 0.1, String(span(page)));
});

test("the wheel zooms about the pointer", async () => {
  const page = await newPage();
  await openRecording(page, "table run.h5");
  const box = await page.locator(".row .u-over").first().boundingBox();
  await page.mouse.move(box.x + 0.25 * box.width, box.y + 40);
  await page.mouse.wheel(0, -500);
  await page.waitForFunction(() => location.search.includes("span="));
  await drawn(page);
  const [from, to] = span(page);
  assert.ok(Math.abs(from + 0.25 * (to - from) - 0.25 * 300.4) < 1.0, String(span(page)));
});

test("a drag selects a span whose statistics follow, in the unit that is chosen", async () => {
  const page = await newPage();
  await openRecording(page, "table run.h5");
  const box = await page.locator(".row .u-over").nth(1).boundingBox();
  await page.mouse.move(box.x + 0.4 * box.width, box.y + 30);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 40, { steps: 5 });
  await page.mouse.up();
  await page.getByText("Statistics of the selection").first().waitFor();
  await drawn(page);
  const [from, to] = address(page).get("selection").split(",").map(Number);
  assert.ok(Math.abs(from - 0.4 * 300.4) < 1 && Math.abs(to - 0.5 * 300.4) < 1);
  const row = page.getByTestId("statistics").getByRole("row").filter({ hasText: "gyro.z" });
  const asked = await page.evaluate(async ([begin, end]) => {
    const answer = await fetch(`/api/recording/statistics?file=table%20run.h5&channel=gyro.z&unit=deg/s&from=${begin}&to=${end}`);
    return (await answer.json()).rows[0];
  }, [from, to]);
  const cells = await row.getByRole("cell").allInnerTexts();
  assert.equal(cells[5].replace(/\D/g, ""), String(asked.samples));
  assert.equal(cells[0], asked.text.mean);
  await page.getByLabel("Unit of gyro.z").selectOption("rad/s");
  await drawn(page);
  await row.getByText("rad/s", { exact: true }).waitFor();
  const radians = Number((await row.getByRole("cell").allInnerTexts())[0]);
  assert.ok(Math.abs(radians - (Number(asked.text.mean) * Math.PI) / 180) < 1e-4 * Math.abs(radians) + 1e-6);
  assert.deepEqual(address(page).getAll("unit"), ["gyro.z~rad/s"]);
  const [file] = await Promise.all([page.waitForEvent("download"), page.getByRole("link", { name: "Save these samples" }).click()]);
  const rows = readFileSync(await file.path(), "utf8").trim().split("\n");
  assert.equal(rows[0], "time[s],gyro.x[deg/s],gyro.z[rad/s],acc.z[m/s^2],temperature[degC]");
  assert.equal(rows.length - 1, asked.samples);
  await page.keyboard.press("z");
  assert.ok(Math.abs(span(page)[0] - from) < 1e-6);
});

test("two cursors show values and differences", async () => {
  const page = await newPage();
  await openRecording(page, "table run.h5");
  const box = await page.locator(".row .u-over").first().boundingBox();
  await page.mouse.click(box.x + 0.2 * box.width, box.y + 30);
  await page.mouse.move(box.x + 0.6 * box.width, box.y + 30);
  await page.keyboard.press("b");
  const table = page.getByTestId("cursors");
  await table.getByText("B − A").waitFor();
  const times = (await table.getByRole("row").nth(1).getByRole("cell").allInnerTexts()).map(Number);
  assert.ok(Math.abs(times[2] - (times[1] - times[0])) < 1e-6 && Math.abs(times[2] - 0.4 * 300.4) < 1);
  await picture(page, "cursors");
  await page.keyboard.press("Escape");
  assert.equal(address(page).get("a"), null);
});

test("a finding leads to its place", async () => {
  const page = await newPage();
  await openRecording(page, "table run.h5");
  const list = page.getByTestId("findings");
  await list.getByText(/gap of/).first().waitFor();
  await list.getByRole("listitem").filter({ hasText: "gap" }).first().getByRole("button").click();
  await drawn(page);
  const [from, to] = span(page);
  assert.ok(from < 240.1 && to > 240, String(span(page)));
  await page.keyboard.press("0");
  await page.keyboard.press("n");
  assert.ok(span(page));
});

test("a file is uploaded and opened; what it does not say can be said", async () => {
  const page = await newPage();
  await page.getByTestId("upload").setInputFiles(join(scratch, "no rate.csv"));
  await page.getByText("cannot be read as it is").waitFor();
  assert.match(await page.getByRole("alert").innerText(), /rate/);
  await picture(page, "refused");
  await assertAccessible(page, "refused");
  await page.getByLabel("What the file does not say").fill("rate=100");
  await page.getByRole("button", { name: "Read again" }).click();
  await page.locator(".row .u-over").first().waitFor();
  assert.deepEqual(address(page).getAll("set"), ["rate=100"]);
  assert.ok(existsSync(join(folder, "uploads", "no rate.csv")));
  await page.goto(base);
  const carried = await page.evaluateHandle(() => {
    const carrier = new DataTransfer();
    carrier.items.add(new File(["time[s],x[deg/h]\n" + Array.from({ length: 300 }, (_, i) => `${i / 100},${i % 5}`).join("\n")], "dropped.csv"));
    return carrier;
  });
  await page.locator("section.recordings").dispatchEvent("drop", { dataTransfer: carried });
  await page.getByRole("heading", { name: "uploads/dropped.csv" }).waitFor();
});

test("a recording is identified, and its report opens", async () => {
  const page = await newPage();
  await openRecording(page, "mpu6050_static.csv");
  await page.getByLabel("Plan or method").selectOption("method:allan_noise");
  await page.getByRole("button", { name: "Identify", exact: true }).click();
  await page.getByTestId("identified").waitFor({ timeout: 60000 });
  const [report] = await Promise.all([page.context().waitForEvent("page"), page.getByTestId("identified").getByRole("link").first().click()]);
  await report.waitForLoadState();
  assert.match(await report.title(), /allan|noise/i);
  assert.ok((await report.locator("table").count()) > 0);
  assert.equal(await report.evaluate(() => { try { return document.cookie; } catch { return ""; } }), "");
  await report.screenshot({ path: join(pictures, "report.png") });
});

test("spectrum and Allan deviation of the span come as a job", async () => {
  const page = await newPage();
  await openRecording(page, "mpu6050_static.csv");
  await page.keyboard.press("+");
  await page.locator("[data-section=noise] select").selectOption({ index: 1 });
  await page.getByRole("button", { name: "Analyse the span" }).click();
  const figure = page.getByTestId("noise-figures").getByRole("img").first();
  await figure.waitFor({ timeout: 60000 });
  await page.waitForFunction(() => document.querySelector("[data-testid=noise-figures] img").naturalWidth > 100);
  await figure.scrollIntoViewIfNeeded();
  await picture(page, "noise");
});

test("a job can be cancelled", async () => {
  const page = await newPage();
  const long = join(scratch, "long.csv");
  let random = 7;
  writeFileSync(long, "gyro.x[deg/h]\n" + Array.from({ length: 2000000 }, () => ((random = (random * 16807) % 2147483647) % 1000)).join("\n"));
  execFileSync(program, ["--quiet", "convert", long, "-o", join(folder, "long.h5"), "--set", "rate=100"]);
  writeFileSync(join(folder, "every tau.toml"), 'title = "Every tau"\nmethod = "allan_noise"\n[settings]\ntaus = "all"\ndeviations = "all"\n');
  await openRecording(page, "long.h5");
  await page.getByLabel("Plan or method").selectOption("plan:every tau.toml"); // some 10 s
  await page.getByRole("button", { name: "Identify", exact: true }).click();
  const job = page.locator(".tray .job", { hasText: "long.h5" });
  await job.getByText("running").waitFor();
  await job.getByRole("button", { name: "Cancel" }).click();
  await job.waitFor({ state: "detached" });
  await page.locator(".tray button").first().click();
  await page.locator(".tray .job.cancelled", { hasText: "long.h5" }).getByText("cancelled").waitFor();
  await assertAccessible(page, "tray");
});

test("everything is in Chinese, and no key is without a text", async () => {
  const page = await newPage({ locale: "zh-CN" });
  await page.getByRole("heading", { name: "数据记录" }).waitFor();
  await page.getByRole("row").filter({ hasText: "table run.h5" }).getByText("诊断信息").waitFor();
  await picture(page, "list-zh");
  await openRecording(page, "table run.h5", "&a=20&b=60");
  await page.getByTestId("findings").getByRole("listitem").first().waitFor();
  await page.keyboard.press("?");
  await page.getByRole("dialog").getByText("按键").first().waitFor();
  await page.getByRole("dialog").getByRole("button").click();
  assert.equal(await page.getAttribute("html", "lang"), "zh-CN");
  const keys = await page.evaluate(async () => Object.keys(await (await fetch("/api/texts?language=en")).json()).filter((key) => key.includes("_")));
  const text = await page.locator("body").innerText();
  for (const key of keys) assert.ok(!text.includes(key), `the key ${key} is shown as it is`);
  const english = await page.evaluate(async () => Object.values(await (await fetch("/api/texts?language=en")).json()));
  for (const sentence of english) if (sentence.length > 12 && !sentence.includes("{")) assert.ok(!text.includes(sentence), `"${sentence}" is English`);
  await assertAccessible(page, "Chinese");
  await picture(page, "recording-zh");
  const items = page.getByTestId("findings").getByRole("listitem");
  for (const said of await items.allInnerTexts()) assert.match(said, /[\u4e00-\u9fff]{4}/);
  await page.getByRole("combobox", { name: "语言", exact: true }).selectOption("en");
  await page.waitForFunction(() => !/[\u4e00-\u9fff]/.test(document.querySelector("[data-testid=findings]").textContent));
});

test("a phone shows all of it without a sideways scroll", async () => {
  const page = await newPage({ viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true });
  const fits = () => page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth);
  await page.getByRole("row").filter({ hasText: "table run.h5" }).getByText("findings").waitFor();
  assert.ok(await fits(), "list");
  await picture(page, "list-phone");
  await openRecording(page, "table run.h5");
  await page.getByTestId("statistics").waitFor();
  assert.ok(await fits(), "recording");
  assert.ok((await curveColumns(page, 0)) > 0.5);
  await assertAccessible(page, "phone");
  await page.screenshot({ path: join(pictures, "recording-phone.png"), fullPage: true });
});

test("the picture of the documentation", async () => {
  const page = await newPage({ viewport: { width: 1200, height: 800 } });
  await openRecording(page, "table run.h5", "&selection=110,140&a=150&b=175");
  await page.getByTestId("findings").getByRole("listitem").first().waitFor();
  await page.getByTestId("cursors").getByText("B − A").waitFor();
  await drawn(page);
  await picture(page, "workbench"); // kept as docs/img/workbench.png
});

test("dark, and printed", async () => {
  const page = await newPage({ colorScheme: "dark" });
  await openRecording(page, "table run.h5", "&selection=50,90&a=20&b=60");
  await page.getByTestId("findings").getByRole("listitem").first().waitFor();
  await assertAccessible(page, "dark");
  await picture(page, "recording-dark");
  await page.emulateMedia({ media: "print", colorScheme: "light" });
  await drawn(page);
  assert.equal(await page.locator(".toolbar").isVisible(), false);
  await page.screenshot({ path: join(pictures, "recording-print.png"), fullPage: true });
});

test("a keyboard reaches everything, and help names the keys", async () => {
  const page = await newPage();
  await openRecording(page, "table run.h5");
  await page.keyboard.press("?");
  const help = page.getByRole("dialog");
  await help.getByText("zoom to the selection").waitFor();
  await picture(page, "help");
  await page.keyboard.press("Escape");
  await help.waitFor({ state: "detached" });
  const reached = new Set();
  for (let i = 0; i < 60; ++i) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => document.activeElement?.textContent?.trim().slice(0, 30) || document.activeElement?.getAttribute("aria-label")));
  }
  for (const name of ["Recordings", "Zoom to selection", "Analyse the span"]) {
    const disabled = name === "Zoom to selection";
    assert.ok(disabled || [...reached].some((text) => text?.includes(name)), `${name} in ${[...reached].join(" | ")}`);
  }
});

test("the page weighs little, and zooming is quick", async () => {
  const page = await newPage();
  let weight = 0;
  for (const path of ["/", "/app.js", "/app.css", "/api/texts?language=en"]) {
    const answer = await page.context().request.get(base + path, { headers: { "Accept-Encoding": "identity" } });
    const { gzipSync } = await import("node:zlib");
    weight += gzipSync(await answer.body(), { level: 9 }).length;
  }
  assert.ok(weight < 300_000, `${weight} bytes`);
  await openRecording(page, "table run.h5");
  const times = [];
  for (let i = 0; i < 40; ++i) {
    await page.keyboard.press(i % 10 < 5 ? "+" : "-");
    await drawn(page);
    times.push(Number(await page.locator(".recording").getAttribute("data-answered")));
  }
  times.sort((x, y) => x - y);
  console.log(`     page ${(weight / 1000).toFixed(1)} kB compressed; a zoom is answered within ${times[20].toFixed(1)} ms (median), ${times[38].toFixed(1)} ms (95 %)`);
});
