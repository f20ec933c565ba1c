// Plans: the list, form and text of one plan, its problems, its picture, its prediction, saving.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { address, assertAccessible, base, browser, drawn, folder, newPage, picture, pictures, program, test } from "./harness.mjs";

const ready = (name) => execFileSync(program, ["init", name], { encoding: "utf8" });
const tumblePlan = ready("accelerometer_tumble");
writeFileSync(join(folder, "tumble.toml"), tumblePlan);

async function openPlan(page, query) {
  await page.goto(`${base}/plans?${query}`);
  await page.getByRole("region", { name: "Rig and instrument in motion" }).waitFor().catch(() => undefined);
  await page.locator(".stage .state").first().waitFor();
  await drawn(page);
}

const textOf = (page) => page.locator(".code textarea").inputValue();
const predicted = (page) => page.locator('[data-testid="predicted"][data-state="ready"] tbody tr').first();
const cell = (page, parameter, column) => page.locator(`tr[data-parameter="${parameter}"] td`).nth(column).innerText();

/// How many pixels of the picture are of the rig, and how many colours they have.
async function pixels(page) {
  return page.getByTestId("scene-webgl").evaluate((canvas) => {
    const copy = document.createElement("canvas");
    copy.width = canvas.width;
    copy.height = canvas.height;
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0);
    const bytes = context.getImageData(0, 0, copy.width, copy.height).data;
    const colours = new Set();
    let painted = 0;
    for (let i = 0; i < bytes.length; i += 4)
      if (bytes[i + 3] > 128) {
        ++painted;
        colours.add((bytes[i] >> 5) * 64 + (bytes[i + 1] >> 5) * 8 + (bytes[i + 2] >> 5));
      }
    return { share: painted / (bytes.length / 4), colours: colours.size };
  });
}

test("plans: the list has those of the folder and those to begin with", async () => {
  const page = await newPage();
  await page.getByRole("navigation").getByRole("link", { name: "Plans" }).click();
  await page.getByTestId("plans").getByRole("link", { name: "tumble.toml" }).waitFor();
  assert.equal(new URL(page.url()).pathname, "/plans");
  assert.ok((await page.getByTestId("templates").getByRole("listitem").count()) > 20);
  await assertAccessible(page, "plans");
  await picture(page, "plans");
  await page.getByLabel("Search").fill("three-axis");
  await page.getByTestId("templates").getByRole("link").first().click();
  await page.locator(".stage .state").waitFor();
  assert.equal(address(page).get("template"), "imu_turntable");
  await page.goBack();
  await page.getByTestId("templates").first().waitFor();
});

test("plans: an edit of the form changes the text and keeps its comments", async () => {
  const page = await newPage();
  await openPlan(page, "file=tumble.toml");
  const before = await textOf(page);
  assert.equal(before, tumblePlan);
  await page.getByLabel("Title", { exact: true }).fill("摆式加速度计 \"A\"");
  await page.getByLabel("Title", { exact: true }).press("Tab");
  await page.waitForFunction(() => document.querySelector(".code textarea").value.includes("摆式"));
  assert.equal(await textOf(page), before.replace("Multi-position tumble of a pendulous accelerometer", "摆式加速度计 \\\"A\\\""));
  await page.getByLabel("Duration of mount 1, 60 deg").fill("80"); // the unit is that of the field
  await page.getByLabel("Duration of mount 1, 60 deg").press("Enter");
  await page.waitForFunction(() => document.querySelector(".code textarea").value.includes('"80 s"'));
  await page.locator('tr[data-segment="1"]').getByRole("button", { name: "Copy" }).click();
  await page.waitForFunction(() => (document.querySelector(".code textarea").value.match(/"80 s"/g) ?? []).length === 2);
  const after = await textOf(page);
  for (const line of before.split("\n").filter((one) => one.includes("#"))) assert.ok(after.includes(line.slice(line.indexOf("#"))), line);
  assert.match(await page.getByTestId("plan-state").innerText(), /not saved/);
  for (let i = 0; i < 3; ++i) await page.getByRole("button", { name: "Undo" }).click();
  assert.equal(await textOf(page), before);
  assert.match(await page.getByTestId("plan-state").innerText(), /^saved/);
});

test("plans: every problem stands at its line, in the text and at the field", async () => {
  const page = await newPage();
  await openPlan(page, "file=tumble.toml");
  const wrong = tumblePlan.replace('kind = "dividing_head"', 'kind = "dividing_head"\nlevel_sd = "2 s"').replace('duration = "100 s"', 'duration = "100 kg"');
  await page.locator(".code textarea").fill(wrong);
  await page.locator(".code .wrong").nth(1).waitFor();
  const marked = await page.locator(".code .wrong").evaluateAll((all) => all.map((one) => Number(one.dataset.line)));
  const lines = wrong.split("\n");
  assert.deepEqual(marked.map((line) => lines[line - 1]), ['level_sd = "2 s"', 'duration = "100 kg"']);
  const said = await page.getByTestId("plan-problems").innerText();
  assert.match(said, new RegExp(`line ${marked[0]} .*level_sd`));
  assert.match(await page.locator(".field.wrong", { hasText: "level_sd" }).innerText(), /2 s/);
  await page.getByRole("button", { name: `line ${marked[1]}` }).click();
  assert.equal(await page.evaluate(() => getSelection().toString() || document.activeElement.value.slice(document.activeElement.selectionStart, document.activeElement.selectionEnd)), 'duration = "100 kg"');
  await assertAccessible(page, "plan with problems");
  await picture(page, "plan-problems");
  await page.locator(".code textarea").fill("title = \n");
  await page.getByText("cannot be read as TOML").waitFor();
  assert.equal(await page.locator(".plan-form fieldset").evaluate((one) => one.disabled), true);
  await page.getByRole("button", { name: "Undo" }).click();
});

test("plans: a shorter dwell is predicted to be worse at once", async () => {
  const page = await newPage();
  await openPlan(page, "file=tumble.toml");
  await predicted(page).waitFor();
  const begin = Number(await cell(page, "bias", 0));
  assert.ok(begin > 0);
  await page.locator(".code textarea").fill(tumblePlan.replaceAll('"100 s"', '"40 s"'));
  await page.locator('tr.worse[data-parameter="bias"]').waitFor();
  assert.ok(Number(await cell(page, "bias", 0)) > begin);
  assert.equal(Number(await cell(page, "bias", 2)), begin);
  assert.match(await cell(page, "bias", 3), /▲ 1\.\d+× worse/);
  assert.match(await page.getByTestId("predicted").innerText(), /worse than with the saved plan: \d+/);
  await assertAccessible(page, "prediction");
  await picture(page, "plan-worse");
  await page.locator(".code textarea").fill(tumblePlan.replaceAll('"100 s"', '"400 s"'));
  await page.locator('tr.better[data-parameter="bias"]').waitFor();
});

test("plans: the rig is drawn by WebGL and moves as it is scrubbed", async () => {
  const page = await newPage({ viewport: { width: 1600, height: 1000 } });
  await openPlan(page, "template=imu_turntable");
  const drawing = await pixels(page);
  assert.ok(drawing.share > 0.05 && drawing.share < 0.8, `share ${drawing.share}`);
  assert.ok(drawing.colours > 12, `colours ${drawing.colours}`);
  assert.match(await page.getByTestId("scene-labels").textContent(), /gravity.*Earth rate/);
  const first = await page.getByTestId("scene-webgl").evaluate((canvas) => canvas.toDataURL());
  await page.locator(".course .bars button", { hasText: "y up, heading 270" }).click();
  await page.getByTestId("stage-state").getByText("moving").waitFor();
  await page.getByLabel("Time in the test").fill("559.44"); // the nearest step
  await page.getByTestId("stage-state").getByText("inner 90.0 deg").waitFor();
  await page.getByTestId("stage-state").getByText("settled").waitFor();
  await drawn(page);
  assert.notEqual(await page.getByTestId("scene-webgl").evaluate((canvas) => canvas.toDataURL()), first);
  await page.waitForFunction(() => new URLSearchParams(location.search).get("t") === "559.4");
  await predicted(page).waitFor();
  await drawn(page);
  await assertAccessible(page, "plan");
  await picture(page, "plan-webgl");
  await page.getByRole("button", { name: "Play" }).click();
  await page.waitForFunction(() => Number(document.querySelector(".stage").dataset.time) > 563);
  await page.getByRole("button", { name: "Pause" }).click();
  await page.locator(".drawing").focus();
  const turned = await page.getByTestId("scene-webgl").evaluate((canvas) => canvas.toDataURL());
  await page.keyboard.press("ArrowLeft");
  await drawn(page);
  assert.notEqual(await page.getByTestId("scene-webgl").evaluate((canvas) => canvas.toDataURL()), turned);
});

test("plans: without WebGL the picture is SVG, and calm where motion is not wanted", async () => {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, locale: "en-GB", reducedMotion: "reduce" });
  await context.addInitScript(() => {
    const real = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
      return kind === "webgl2" ? null : real.call(this, kind, ...rest);
    };
  });
  const page = await context.newPage();
  await page.goto((await import("./harness.mjs")).link);
  await page.getByRole("heading", { level: 1 }).first().waitFor();
  await openPlan(page, "template=dtg_centrifuge&t=900&run=2");
  const scene = page.getByTestId("scene-svg");
  await scene.locator("polygon").first().waitFor();
  assert.ok((await scene.locator("polygon").count()) > 100);
  const inside = await scene.locator("polygon").evaluateAll((all) => all.every((one) => one.getAttribute("points").split(/[ ,]/).every((number) => Math.abs(Number(number)) <= 100)));
  assert.ok(inside, "everything is inside of the picture");
  const before = Number(await page.locator(".stage").getAttribute("data-time"));
  await page.getByRole("button", { name: "Play" }).click();
  await page.waitForFunction((time) => Number(document.querySelector(".stage").dataset.time) > time, before);
  const stops = await page.locator(".stage").getAttribute("data-time");
  await page.getByRole("button", { name: "Pause" }).click();
  assert.ok(Number(stops) - before > 60, "from one segment to the next");
  await assertAccessible(page, "SVG");
  await picture(page, "plan-svg");
});

test("plans: the other rigs are drawn, too", async () => {
  const page = await newPage();
  for (const [name, time] of [["accelerometer_tumble", 160], ["sine_vibration", 5], ["imu_multi_position", 20], ["gyro_scale_factor", 100], ["accelerometer_centrifuge", 300], ["fog_thermal_bias", 100]]) {
    await openPlan(page, `template=${name}&t=${time}&show=text`);
    await page.getByTestId("scene-labels").locator("text").first().waitFor();
    await drawn(page);
    const { share } = await pixels(page);
    assert.ok(share > 0.02, `${name}: ${share}`);
    await page.locator(".drawing").screenshot({ path: join(pictures, `plan-rig-${name}.png`) });
  }
});

test("plans: saving, a file that changed meanwhile, and jobs", async () => {
  const page = await newPage();
  await openPlan(page, "template=accelerometer_four_position");
  await page.getByRole("button", { name: "Save as" }).click();
  await page.getByLabel("File").fill("mine");
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await page.getByRole("heading", { name: "mine.toml" }).waitFor();
  assert.equal(address(page).get("file"), "mine.toml");
  assert.equal(readFileSync(join(folder, "mine.toml"), "utf8"), ready("accelerometer_four_position"));
  await page.getByLabel("Title", { exact: true }).fill("Mine");
  await page.getByLabel("Title", { exact: true }).press("Enter");
  await page.getByTestId("plan-state").getByText("not saved").waitFor();
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await page.getByTestId("plan-state").getByText("saved", { exact: true }).waitFor();
  assert.match(readFileSync(join(folder, "mine.toml"), "utf8"), /title *= "Mine"/);
  await drawn(page); // the page has looked at the file again: what comes now is news
  writeFileSync(join(folder, "mine.toml"), readFileSync(join(folder, "mine.toml"), "utf8") + "# of somebody else\n");
  await page.getByLabel("Title", { exact: true }).fill("Mine again");
  await page.getByLabel("Title", { exact: true }).press("Enter");
  await page.getByTestId("plan-state").getByText("not saved").waitFor();
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await page.getByRole("alert").getByText("changed on the disk").waitFor();
  assert.match(readFileSync(join(folder, "mine.toml"), "utf8"), /of somebody else/);
  await page.getByRole("button", { name: "Save as" }).click();
  await page.getByLabel("File").fill("mine-2.toml");
  await page.getByRole("button", { name: "Save", exact: true }).last().click();
  await page.getByRole("heading", { name: "mine-2.toml" }).waitFor();
  assert.ok(existsSync(join(folder, "mine-2.toml")));
  await page.locator(".stage .state").waitFor();
  await page.getByRole("button", { name: "Simulate and identify" }).click();
  await page.getByTestId("plan-job").getByRole("link", { name: "Open the report" }).waitFor({ timeout: 60000 });
});

test("plans: in Chinese, on a phone, in the dark", async () => {
  const page = await newPage({ locale: "zh-CN", viewport: { width: 390, height: 800 }, isMobile: true, hasTouch: true, colorScheme: "dark" });
  await openPlan(page, "template=imu_turntable");
  await predicted(page).waitFor();
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), "sideways");
  const text = await page.locator("body").innerText();
  const table = await page.evaluate(async () => (await (await fetch("/api/texts?language=en")).json()));
  for (const [key, sentence] of Object.entries(table)) {
    if (key.includes("_")) assert.ok(!text.includes(key), `the key ${key} is shown as it is`);
    if (sentence.length > 12 && !sentence.includes("{")) assert.ok(!text.includes(sentence), `"${sentence}" is English`);
  }
  await assertAccessible(page, "phone");
  await page.screenshot({ path: join(pictures, "plan-phone-zh.png"), fullPage: true });
  await page.goto(`${base}/plans`);
  await page.getByTestId("templates").getByRole("listitem").first().waitFor();
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), "sideways, list");
  await picture(page, "plans-phone-zh");
});

const HAN = /[\u4e00-\u9fff]/;

test("plans: options, templates and problems are described in the language of the page", async () => {
  const page = await newPage({ locale: "zh-CN" });
  await page.goto(`${base}/plans`);
  await page.getByTestId("templates").getByRole("listitem").first().waitFor();
  for (const title of await page.getByTestId("templates").getByRole("link").allInnerTexts()) assert.match(title, HAN);
  await openPlan(page, "file=tumble.toml");
  const described = () => page.locator(".plan-form .field", { hasText: "level_sd" }).locator("small").allTextContents();
  await page.waitForFunction(() => document.querySelectorAll(".plan-form .field").length > 30);
  assert.match((await described())[0], HAN);
  for (const text of await page.locator(".plan-form .field small").allTextContents()) if (text && !text.startsWith("[")) assert.match(text, HAN, text);
  await page.locator(".code textarea").fill(tumblePlan.replace('kind = "dividing_head"', 'kind = "dividing_head"\nlevel_ds = "2 s"'));
  await page.getByTestId("plan-problems").getByText("无法识别的键“level_ds”，是否应为“level_sd”？").waitFor();
  await picture(page, "plan-problems-zh");
  await page.getByRole("combobox", { name: "语言" }).selectOption("en");
  await page.getByTestId("plan-problems").getByText("unknown key 'level_ds'; did you mean 'level_sd'?").waitFor();
  assert.doesNotMatch((await described())[0], HAN);
});

test("plans: the picture of the documentation", async () => {
  const page = await newPage({ viewport: { width: 1400, height: 900 }, deviceScaleFactor: 0.75 });
  await openPlan(page, "file=tumble.toml&t=52");
  await page.locator(".code textarea").fill(tumblePlan.replaceAll('"100 s"', '"40 s"'));
  await page.locator("tr.worse").first().waitFor();
  await page.locator(".code").evaluate((one) => one.scrollTo(0, 0));
  await page.evaluate(() => scrollTo(0, 0));
  await drawn(page);
  await picture(page, "workbench-plans"); // kept as docs/img/workbench-plans.png
});
