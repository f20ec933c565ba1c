// Results: the list, one result with its figures, comparisons.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { address, assertAccessible, base, drawn, folder, newPage, picture, pictures, program, root, scratch, test } from "./harness.mjs";

mkdirSync(join(folder, "results"));
/// A result of a ready plan with another seed and serial number, as a laboratory has of its units.
function makeResult(plan, seed, serial, name) {
  const text = readFileSync(join(root, "plans", `${plan}.toml`), "utf8").replace(/serial = "[^"]*"/, `serial = "${serial}"`);
  const made = join(scratch, `${plan}.toml`);
  writeFileSync(made, text);
  execFileSync(program, ["--quiet", "simulate", made, "--seed", String(seed), "-o", join(scratch, "run.h5")]);
  execFileSync(program, ["--quiet", "identify", made, join(scratch, "run.h5"), "-o", join(folder, "results", name)]);
}
makeResult("gyro_scale_factor", 1, "G-1", "unit 1 spring.json");
makeResult("gyro_scale_factor", 2, "G-1", "unit 1 autumn.json");
for (let unit = 2; unit < 6; ++unit) makeResult("gyro_scale_factor", unit + 10, `G-${unit}`, `unit ${unit}.json`);
copyFileSync(join(root, "examples/data/mpu6050_static.csv"), join(scratch, "at rest.csv"));
execFileSync(program, ["--quiet", "identify", "allan_noise", join(scratch, "at rest.csv"), "-o", join(folder, "results/noise.json")]);
writeFileSync(join(folder, "results", "broken.json"), '{"tumble": "0.1.0"');

const at = (name) => "results/" + name;
const addressOf = (names, more = "") => `${base}/results?${names.map((name) => "file=" + encodeURIComponent(at(name))).join("&")}${more}`;

async function openResult(page, name, more = "") {
  await page.goto(addressOf([name], more));
  await page.getByTestId("parameters").waitFor();
  await page.locator(".figure-plot[data-drawn] canvas").waitFor();
  await drawn(page);
}

/// Whether the drawing has pixels of a colour, as "#0072b2".
function hasColour(page, colour) {
  return page.locator(".figure-plot canvas").first().evaluate((canvas, wanted) => {
    const [r, g, b] = [1, 3, 5].map((at) => parseInt(wanted.slice(at, at + 2), 16));
    const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    let count = 0;
    for (let i = 0; i < pixels.length; i += 4)
      if (pixels[i + 3] > 200 && Math.abs(pixels[i] - r) < 12 && Math.abs(pixels[i + 1] - g) < 12 && Math.abs(pixels[i + 2] - b) < 12) ++count;
    return count;
  }, colour);
}

test("results are listed, and one shows values, verdicts and figures", async () => {
  const page = await newPage();
  await page.getByRole("link", { name: "Results" }).click();
  const list = page.getByTestId("results");
  await list.waitFor();
  const ours = list.getByRole("row").filter({ hasText: "results/" });
  assert.equal(await ours.count(), 7); // the damaged file is none
  await page.getByRole("searchbox").fill("noise");
  assert.equal(await ours.count(), 1);
  await page.getByRole("searchbox").fill("");
  await picture(page, "results-list");
  await assertAccessible(page, "list of results");
  await list.getByRole("row").filter({ hasText: "unit 1 spring.json" }).getByRole("link").click();
  await page.getByTestId("parameters").waitFor();
  assert.equal(address(page).get("file"), at("unit 1 spring.json"));
  await page.locator(".figure-plot canvas").waitFor();
  await drawn(page);
  assert.ok((await hasColour(page, "#0072b2")) > 100, "the residuals are drawn");
  const file = JSON.parse(readFileSync(join(folder, at("unit 1 spring.json")), "utf8"));
  const verdict = page.locator("[data-part=verdicts]");
  assert.match(await verdict.innerText(), new RegExp({ pass: "Pass", fail: "Fail", undecided: "Undecided" }[file.verdicts[0].outcome]));
  for (const { name } of file.parameters) assert.ok((await page.getByTestId("parameters").innerText()).includes(name.replaceAll("_", " ")), name);
  await assertAccessible(page, "result");
  await picture(page, "results-one");
});

test("points of the values of a result stand below each other", async () => {
  const page = await newPage({}, true);
  await openResult(page, "noise.json");
  const lefts = await page.locator("td.value .after").evaluateAll((spans) => spans.filter((span) => span.textContent).map((span) => Math.round(span.getBoundingClientRect().left)));
  assert.ok(lefts.length > 2);
  assert.equal(new Set(lefts).size, 1, lefts.join());
});

test("another unit comes from the program, and stays in the address", async () => {
  const page = await newPage({}, true);
  await openResult(page, "unit 1 spring.json");
  const row = page.getByTestId("parameters").getByRole("row").filter({ hasText: "gyro bias" }).or(page.getByTestId("parameters").getByRole("row").filter({ hasText: "bias" })).first();
  const before = await row.locator("td.value").innerText();
  await row.getByRole("combobox").selectOption("deg/s");
  await page.waitForFunction((text) => ![...document.querySelectorAll("td.value")].some((cell) => cell.innerText === text), before);
  assert.match(address(page).get("unit"), /~deg\/s$/);
  const address1 = page.url();
  const other = await page.context().newPage();
  await other.goto(address1);
  await other.getByTestId("parameters").waitFor();
  assert.equal(await other.getByTestId("parameters").innerText(), await page.getByTestId("parameters").innerText());
});

test("a figure zooms, hides a series, and is saved as SVG and CSV", async () => {
  const page = await newPage({}, true);
  await openResult(page, "noise.json");
  const names = await page.locator("[data-part=figures] select option").allInnerTexts();
  assert.match(names[0], /all together/); // x, y and z in one plot come first
  const over = await page.locator(".figure-plot .u-over").boundingBox();
  await page.mouse.move(over.x + 0.3 * over.width, over.y + 50);
  await page.mouse.down();
  await page.mouse.move(over.x + 0.6 * over.width, over.y + 60, { steps: 4 });
  await page.mouse.up();
  await page.waitForFunction(() => location.search.includes("zoom="));
  await page.getByRole("button", { name: "All", exact: true }).click();
  assert.equal(address(page).get("zoom"), null);
  const seen = await hasColour(page, "#0072b2");
  await page.locator(".figure-legend button").first().click();
  await drawn(page);
  assert.equal(address(page).get("hide"), "0");
  assert.ok((await hasColour(page, "#0072b2")) < 0.2 * seen, "hidden");
  const saved = async (name) => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("link", { name, exact: true }).click()]);
    return readFileSync(await download.path(), "utf8");
  };
  const svg = await saved("SVG");
  assert.match(svg, /^<svg [^]*averaging time \[s\]/);
  const csv = (await saved("CSV")).trim().split("\n");
  const figures = await page.evaluate(async (file) => (await fetch(`/api/result/figures?file=${encodeURIComponent(file)}`)).json(), at("noise.json"));
  assert.equal(csv.length, 1 + Math.max(...figures[0].series.map((series) => series.x.length)));
  assert.match(csv[0], /^averaging time\[s\],gyro\.x allan deviation\[deg\/h\]/);
});

test("budget and correlation of a result show their numbers on demand", async () => {
  const page = await newPage({}, true);
  await openResult(page, "unit 1 spring.json");
  const first = page.getByTestId("budget").getByRole("listitem").first();
  await first.getByRole("button").click();
  const shares = (await first.locator("td:last-child").allInnerTexts()).map((text) => (text.startsWith("<") ? 0 : parseInt(text, 10)));
  assert.ok(Math.abs(shares.reduce((sum, share) => sum + share, 0) - 100) <= shares.length, shares.join());
  const cells = page.getByTestId("correlation").locator("td[title]");
  assert.equal(await cells.first().innerText(), "");
  await page.getByRole("button", { name: "Numbers" }).click();
  assert.equal(await cells.first().innerText(), "1.00");
  assert.equal(address(page).get("numbers"), "1");
});

test("the covariance stands beside the correlation, in the units of the page, and is a file", async () => {
  const page = await newPage({}, true);
  await openResult(page, "unit 1 spring.json");
  await page.locator("[data-part=correlation]").getByRole("button", { name: "Covariance" }).click();
  assert.equal(address(page).get("matrix"), "covariance");
  const cells = page.getByTestId("correlation").locator("td[title]");
  const file = JSON.parse(readFileSync(join(folder, at("unit 1 spring.json")), "utf8"));
  assert.equal(await cells.count(), (file.parameters.length * (file.parameters.length + 1)) / 2);
  for (const text of await cells.allInnerTexts()) assert.match(text, /^(−?[\d.]+( × 10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?|–)$/);
  const [download] = await Promise.all([page.waitForEvent("download"), page.locator("[data-part=correlation]").getByRole("link", { name: "CSV" }).click()]);
  const lines = readFileSync(await download.path(), "utf8").trim().split("\n").map((line) => line.split(","));
  assert.equal(lines.length, file.parameters.length + 1);
  for (const [i, one] of file.parameters.entries()) {
    const sd = Math.sqrt(Number(lines[i + 1][i + 1]));
    assert.ok(Math.abs(sd / one.sd - 1) < 1e-9, `${one.name}: ${sd} ${one.sd}`);
  }
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  await page.getByRole("button", { name: "Copy as CSV" }).click();
  await page.getByText("Copied.").waitFor();
  assert.match(await page.evaluate(() => navigator.clipboard.readText()), /^covariance,/);
});

/// The fibre-optic gyro of the ready plan, with one power-up from each start temperature.
function makeThermal() {
  const text = readFileSync(join(root, "plans/fog_thermal_bias.toml"), "utf8");
  const [head, ...segments] = text.slice(0, text.indexOf("# Second")).split("[[schedule]]");
  const kept = segments.filter((segment) => !segment.includes('"soak')).map((segment) => segment.replace(/run( *)= \[(3\d|40), \d+\]/, "run$1= [$2]"));
  const plan = join(scratch, "thermal.toml"), run = join(folder, "chamber.h5");
  writeFileSync(plan, [head, ...kept].join("[[schedule]]"));
  execFileSync(program, ["--quiet", "simulate", plan, "--seed", "1", "-o", run]);
  execFileSync(program, ["--quiet", "identify", plan, run, "-o", join(folder, "results/thermal.json")]);
}

test("a thermal surface is a map with measured points, and the model is subtracted from a recording", async () => {
  makeThermal();
  const page = await newPage({ viewport: { width: 1150, height: 760 } }, true);
  await openResult(page, "thermal.json");
  const names = await page.locator("[data-part=figures] select option").allInnerTexts();
  const number = names.findIndex((name) => name.includes("drift over temperature and temperature rate")) + 1;
  assert.ok(number > 0, names.join());
  await page.goto(addressOf(["thermal.json"], `&figure=${number}`));
  await page.locator(".figure-scale").waitFor();
  await drawn(page);
  const figures = await page.evaluate(async (file) => (await fetch(`/api/result/figures?file=${encodeURIComponent(file)}`)).json(), at("thermal.json"));
  const { map, z } = figures[number - 1];
  assert.equal(map.values.length, (map.x.length - 1) * (map.y.length - 1));
  // The darkest and the brightest cell have their colours on the page.
  const known = map.values.filter((value) => value !== null);
  for (const value of [Math.min(...known), Math.max(...known)])
    assert.ok((await hasColour(page, z.colours[Math.round((z.colours.length - 1) * (value - z.low) / (z.high - z.low))])) > 50, String(value));
  const over = await page.locator(".figure-plot .u-over").boundingBox();
  await page.mouse.move(over.x + 0.5 * over.width, over.y + 0.5 * over.height);
  await page.getByText(/^temperature −?[\d.]+ degC, temperature rate .* K\/min, drift −?[\d.e−]+ deg\/h$/).waitFor();
  const svg = await page.evaluate(async (path) => (await fetch(path)).text(), `/api/result/figure.svg?file=${encodeURIComponent(at("thermal.json"))}&figure=${number}`);
  assert.match(svg, /crispEdges/);
  await assertAccessible(page, "map");
  await picture(page, "workbench-thermal"); // kept as docs/img/workbench-thermal.png
  await page.setViewportSize({ width: 390, height: 800 });
  await drawn(page);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), "phone");
  await page.screenshot({ path: join(pictures, "results-thermal-phone.png"), fullPage: true });
  await page.setViewportSize({ width: 1150, height: 760 });
  const part = page.locator("[data-part=compensate]");
  await part.locator("select").first().selectOption("chamber.h5");
  await part.getByRole("button", { name: "Compensate" }).click();
  const done = page.getByTestId("compensated");
  await done.locator(".figure-plot[data-drawn] canvas").nth(1).waitFor({ timeout: 60000 });
  assert.match(await done.innerText(), /before and after compensation/);
  await picture(page, "results-compensated");
  await done.getByRole("link", { name: "Show the result" }).click();
  await page.getByRole("heading", { level: 1, name: /chamber.h5 compensated/ }).waitFor();
  await page.locator(".figure-plot[data-drawn] canvas").waitFor();
  await assertAccessible(page, "compensation");
});

test("two results are compared as on the command line", async () => {
  const page = await newPage();
  await page.goto(base + "/results");
  for (const name of ["unit 1 spring.json", "unit 1 autumn.json"]) await page.getByLabel(`Choose ${at(name)}`).check();
  await page.getByRole("button", { name: "Compare (2)" }).click();
  await page.getByTestId("pair").waitFor();
  const files = address(page).getAll("file");
  const printed = JSON.parse(execFileSync(program, ["compare", "--json", ...files.map((file) => join(folder, file))], { encoding: "utf8" }));
  const rows = page.getByTestId("pair").locator("tbody tr");
  assert.equal(await rows.count(), printed.pairs[0].differences.length);
  for (const [i, one] of printed.pairs[0].differences.entries())
    assert.ok((await rows.nth(i).innerText()).includes(one.e_n.toFixed(2).replace("-", "−")), `${one.parameter}: ${one.e_n}`);
  await page.locator(".figure-plot[data-drawn]").waitFor();
  await drawn(page);
  await assertAccessible(page, "comparison");
  await picture(page, "results-compare");
});

test("a parameter is drawn over many units", async () => {
  const page = await newPage();
  await page.goto(addressOf(["unit 1 autumn.json", "unit 2.json", "unit 3.json", "unit 4.json", "unit 5.json", "noise.json"]));
  const units = page.getByTestId("units");
  await units.waitFor();
  assert.equal(await units.locator("tbody tr").count(), 6);
  assert.match(await units.locator("tbody tr").last().innerText(), /not determined/);
  assert.equal(await page.getByTestId("pair").count(), 0); // six instruments: no change is asked for
  assert.ok((await hasColour(page, "#0072b2")) > 50);
  await picture(page, "results-units");
});

test("a logarithmic axis may begin and end anywhere", async () => {
  const page = await newPage();
  // Spans at which the ticks of uPlot go on without end; less than a decade; as short as numbers go; far from all points.
  for (const span of ["0.00973158485,25.6970069", "0.00973158485,0.0115214117", "1.1,1.3", "1.2345,1.2345000001", "1e-30,1e-29", "1e-300,1e300", "0.011,1e9"]) {
    await openResult(page, "noise.json", `&zoom=${encodeURIComponent(span)}`);
    await picture(page, `results-log-${span}`);
  }
});

test("a long name beside the comparison fits on a phone", async () => {
  copyFileSync(join(folder, at("unit 2.json")), join(folder, at("unit 2 measured again after the repair of its second electronic board.json")));
  const page = await newPage({ viewport: { width: 360, height: 740 } });
  await openResult(page, "unit 2.json");
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 360);
});

test("a result that is damaged or gone says so", async () => {
  const page = await newPage();
  await page.goto(addressOf(["broken.json"]));
  await page.getByRole("alert").getByText("broken.json").waitFor();
  await page.goto(addressOf(["../../etc/passwd"]));
  await page.getByRole("alert").waitFor();
  await page.goto(addressOf(["unit 2.json"], "&unit=nothing~deg/h"));
  await page.getByRole("alert").getByText("nothing").waitFor();
});

test("results in Chinese, on a phone, in the dark and on paper", async () => {
  const page = await newPage({ locale: "zh-CN", viewport: { width: 390, height: 800 }, isMobile: true, hasTouch: true, colorScheme: "dark" });
  await page.goto(base + "/results");
  await page.getByTestId("results").waitFor();
  const fits = () => page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth);
  assert.ok(await fits(), "list");
  await openResult(page, "unit 1 spring.json", "&parameter=scale_factor_error");
  assert.ok(await fits(), "result");
  const text = await page.locator("body").innerText();
  const { zh, en } = await page.evaluate(async () => ({
    zh: await (await fetch("/api/texts?language=zh")).json(), en: await (await fetch("/api/texts?language=en")).json(),
  }));
  for (const key of Object.keys(zh)) if (key.startsWith("results_")) assert.ok(!text.includes(key), key);
  for (const [key, sentence] of Object.entries(en)) if (key.startsWith("results_") && sentence.length > 12 && !sentence.includes("{")) assert.ok(!text.includes(sentence), sentence);
  assert.ok(!text.includes("±"), "in Chinese this sign would mean an expanded uncertainty");
  const value = await page.locator("td.value").first().boundingBox();
  assert.ok(value.x >= 0 && value.x + value.width <= 390, "the value is on the screen");
  await assertAccessible(page, "phone");
  await page.screenshot({ path: join(pictures, "results-phone.png"), fullPage: true });
  const wide = await newPage({ viewport: { width: 1200, height: 850 } });
  await openResult(wide, "noise.json");
  await picture(wide, "workbench-results"); // kept as docs/img/workbench-results.png
  await wide.emulateMedia({ media: "print" });
  await wide.screenshot({ path: join(pictures, "results-print.png"), fullPage: true });
});

test("figures, parameters and sources of a result are in Chinese, its files in English", async () => {
  const page = await newPage({ locale: "zh-CN", viewport: { width: 1200, height: 850 } }, true);
  await openResult(page, "noise.json");
  const han = /\p{Script=Han}/u, english = /[a-z]{3,} [a-z]{3,}/;
  const figures = page.locator("[data-part=figures]");
  for (const name of await figures.locator("select option").allInnerTexts()) assert.match(name, han);
  assert.match(await figures.locator("figcaption strong").innerText(), /^Allan 标准差（全部）。$/);
  assert.equal(await figures.locator(".figure-plot").getAttribute("aria-label"), (await page.evaluate(async () => (await (await fetch("/api/texts?language=zh")).json()).results_plot_of)).replace("{y}", "Allan 标准差").replace("{x}", "平均时间"));
  for (const name of await figures.locator(".figure-legend button").allInnerTexts()) assert.match(name, /Allan 标准差/);
  const drawing = await page.evaluate(async (address) => (await fetch(address)).text(), await figures.getByRole("link", { name: "SVG" }).getAttribute("href"));
  assert.match(drawing, /lang="zh-CN"[^]*>平均时间 \[s\]</);
  const table = await page.evaluate(async (address) => (await fetch(address)).text(), await figures.getByRole("link", { name: "CSV" }).getAttribute("href"));
  assert.match(table, /^averaging time\[s\],/);
  const rows = page.getByTestId("parameters").locator("tbody th");
  for (const row of await rows.all()) {
    assert.match(await row.locator("small").innerText(), han);
    assert.doesNotMatch((await row.innerText()).replace(await row.locator("code").innerText(), ""), english);
  }
  assert.match(await rows.filter({ hasText: "gyro.x.angle_random_walk" }).innerText(), /gyro\.x 角度随机游走 gyro\.x\.angle_random_walk\s*角速率白噪声/);
  assert.match(await page.getByTestId("budget").innerText(), /输出噪声|gyro\.x 角度随机游走/);
  await picture(page, "results-zh");
});
