// The archive and who may do what in it: units, history, charts, certificates, signatures.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { address, assertAccessible, drawn, environment, newPage, picture, program, root, scratch, startServer, test } from "./harness.mjs";

const home = join(scratch, "laboratory"), archive = join(scratch, "lab.db"), users = join(scratch, "users.toml");
const plan = join(root, "plans/static_bias.toml");
const call = (input, ...words) => execFileSync(program, ["--quiet", ...words], { input, encoding: "utf8", env: environment, cwd: scratch });
const passwords = { "Li Wei": "correct horse 1", "R. Reader": "correct horse 2", "A. Approver": "correct horse 3" };

/// Five tests of one unit, one of three others; a note on when they are due; users with different roles.
function makeLaboratory() {
  mkdirSync(home);
  call("", "archive", "init", "--archive", archive, "--by", "test");
  for (let seed = 1; seed <= 8; ++seed) {
    const data = join(home, `day ${seed}.h5`), result = join(home, `day ${seed}.json`);
    call("", "simulate", plan, "-o", data, "--seed", String(seed));
    call("", "identify", plan, data, "-o", result);
    const unit = seed <= 5 ? "triad/demo-3" : `triad/demo-${seed}`;
    call("", "archive", "ingest", result, data, plan, "--unit", unit, "--ended", `2026-0${seed}-11T09:00:00Z`, "--archive", archive, "--by", "Li Wei");
  }
  call("", "archive", "note", "triad", "--kind", "interval", "--text", "20 day", "--archive", archive, "--by", "Li Wei");
  copyFileSync(join(root, "examples/lab.toml"), join(home, "lab.toml"));
  copyFileSync(join(root, "examples/logo.svg"), join(home, "logo.svg"));
  writeFileSync(join(home, "poor lab.toml"), '[laboratory]\nname = "Nobody"\n');
  const roles = { "Li Wei": ["operate"], "R. Reader": ["read"], "A. Approver": ["operate", "approve"] };
  for (const [name, of] of Object.entries(roles))
    call(passwords[name] + "\n", "serve", "--users", users, "--add-user", name, ...of.flatMap((role) => ["--role", role]));
}

let running = null;
/// The link of a server of this laboratory; the same for all tests.
async function laboratory() {
  if (!running) {
    makeLaboratory();
    running = await startServer(home, "--archive", archive, "--users", users);
    running.server.removeAllListeners("exit");
    process.on("exit", () => running.server.kill("SIGTERM"));
  }
  return running.link.replace(/\/$/, "");
}

async function signedIn(name, place, options = {}) {
  const page = await newPage(options, false);
  await page.goto((await laboratory()) + place);
  await page.locator("input[name=name]").fill(name);
  await page.locator("input[name=password]").fill(passwords[name]);
  await page.locator("form.ask button").click();
  await page.locator("header.top").waitFor();
  await drawn(page);
  return page;
}

/// The choice of a label that begins so: its name has the words of all choices in it.
const choice = (page, label) => page.locator("label", { hasText: new RegExp(`^${label}`) }).locator("select");

const unitOf = "/archive?unit=" + encodeURIComponent("triad/demo-3");

test("who has not signed in sees nothing, and wrong passwords are counted", async () => {
  const page = await newPage({}, false);
  await page.goto((await laboratory()) + "/archive");
  await page.getByRole("button", { name: "Sign in" }).waitFor();
  assert.equal(await page.getByRole("table").count(), 0);
  await assertAccessible(page, "sign in");
  await page.getByLabel("Name").fill("Li Wei");
  await page.getByLabel("Password").fill("wrong horse");
  await page.getByRole("button", { name: "Sign in" }).click();
  await page.getByText("attempts before a pause: 4").waitFor();
  await picture(page, "archive-sign-in");
  await page.getByLabel("Password").fill(passwords["Li Wei"]);
  await page.getByRole("button", { name: "Sign in" }).click();
  await page.getByText("wrong passwords under this name before: 1").waitFor();
  assert.equal(await page.evaluate(() => document.cookie), "");
  await page.getByRole("button", { name: "Sign out" }).click();
  await page.getByRole("button", { name: "Sign in" }).waitFor();
  const status = await page.evaluate(() => fetch("/api/archive/units").then((response) => response.status));
  assert.equal(status, 401);
});

test("units of the archive, their history and what is due", async () => {
  const page = await signedIn("R. Reader", "/archive");
  const row = page.getByTestId("units").getByRole("row").filter({ hasText: "demo-3" });
  await row.getByText("overdue 2026-05-31").waitFor();
  assert.match(await row.innerText(), /5/);
  await assertAccessible(page, "units");
  await row.getByRole("link").click();
  await page.getByTestId("results").waitFor();
  assert.equal(new URL(page.url()).searchParams.get("unit"), "triad/demo-3");
  assert.equal(await page.getByTestId("results").getByRole("row").count(), 6);
  assert.ok((await page.getByTestId("events").innerText()).includes("Li Wei"));
  await assertAccessible(page, "unit");
  await picture(page, "archive-unit");
  await page.getByRole("link", { name: "Due dates" }).click();
  const first = page.getByTestId("due").locator("tbody tr").first();
  await first.getByText("overdue").waitFor();
  assert.match(await first.innerText(), /demo-3/);
});

test("charts of a unit and of a model are those of the command line", async () => {
  const page = await signedIn("R. Reader", unitOf);
  await page.getByRole("link", { name: "bias", exact: true }).click();
  await page.getByTestId("history").waitFor();
  const told = JSON.parse(call("", "archive", "history", "demo-3", "--parameter", "bias", "--json", "--archive", archive));
  assert.equal(await page.getByTestId("history").locator("tbody tr").count(), told.tables.find((table) => table.name === "history").rows.length);
  await page.locator(".figure-plot[data-drawn] canvas").first().waitFor();
  await choice(page, "View").selectOption("chart");
  await page.getByTestId("points").waitFor();
  await drawn(page);
  assert.match(await page.getByTestId("numbers").innerText(), /bias_expected/);
  await assertAccessible(page, "chart");
  await page.screenshot({ path: join(root, "build/browser/archive-chart.png"), fullPage: true });
  // A point of the chart is its result: by the mouse, and by the keyboard from point to point.
  const points = page.getByRole("list", { name: "Points of the figure" }).first().getByRole("link");
  assert.equal(await points.count(), told.results?.length ?? 5);
  await points.first().focus();
  await page.keyboard.press("ArrowRight");
  const name = await page.evaluate(() => document.activeElement.getAttribute("aria-label"));
  assert.equal(name, await points.nth(1).getAttribute("aria-label"));
  const held = await points.evaluateAll((all) => all.filter((one) => one.tabIndex === 0).length);
  assert.equal(held, 1, "one stop of the keyboard for all points");
  const box = await points.nth(1).boundingBox(), plot = await page.locator(".figure-plot .u-over").first().boundingBox();
  assert.ok(box.x + 10 >= plot.x - 1 && box.x + 10 <= plot.x + plot.width + 1 && box.y + 10 >= plot.y - 1 && box.y + 10 <= plot.y + plot.height + 1);
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => location.search.includes("kept="));
  assert.ok(told.tables.find((table) => table.name === "history").rows[1].some((cell) => typeof cell === "string" && address(page).get("kept").startsWith(cell)));
  await page.goto((await laboratory()) + "/archive?model=triad&parameter=bias&kind=summary");
  await page.getByTestId("components").waitFor();
  await page.getByRole("list", { name: "Points of the figure" }).getByRole("link", { name: "triad/demo-3" }).waitFor();
  await page.getByLabel("Upper limit").fill("20 m");
  await page.getByRole("button", { name: "Apply" }).click();
  await page.getByRole("alert").filter({ hasText: "deg/h" }).or(page.getByRole("alert").filter({ hasText: "m" })).first().waitFor();
});

test("a reader can neither start nor sign, and the server refuses it too", async () => {
  const page = await signedIn("R. Reader", "/archive");
  await page.getByTestId("units").waitFor();
  assert.equal(await page.getByRole("button", { name: "Verify" }).count(), 0);
  const told = JSON.parse(call("", "archive", "history", "demo-3", "--json", "--archive", archive));
  const sha256 = told.results[0].sha256;
  const statuses = await page.evaluate(async ({ sha256, password }) => {
    const post = (path, body) => fetch(path, { method: "POST", body: JSON.stringify(body) }).then((response) => response.status);
    return [
      await post("/api/archive/verify", {}),
      await post("/api/archive/results", { result: "day 1.json" }),
      await post("/api/archive/sign", { sha256, meaning: "approved", reason: "x", password }),
      await post("/api/archive/certificate", { result: "day 1.json", lab: "lab.toml" }),
      await post("/api/uploads?name=x.csv", {}),
    ];
  }, { sha256, password: passwords["R. Reader"] });
  assert.deepEqual(statuses, [403, 403, 403, 403, 403]);
  await page.goto((await laboratory()) + `/archive?kept=${sha256}&unit=${encodeURIComponent("triad/demo-3")}`);
  await page.getByText("Only users with the role approve may sign").waitFor();
});

test("an operator verifies the archive and puts a result in, but does not sign", async () => {
  const page = await signedIn("Li Wei", "/archive");
  await page.getByRole("button", { name: "Verify" }).click();
  await page.getByRole("button", { name: /Jobs/ }).press("Enter"); // it moves when a job begins: a click may miss it
  await page.locator(".job.done", { hasText: "Verification" }).getByRole("link", { name: "verify.txt" }).waitFor();
  call("", "simulate", plan, "-o", join(home, "new.h5"), "--seed", "31");
  call("", "identify", plan, join(home, "new.h5"), "-o", join(home, "new.json"));
  await page.goto((await laboratory()) + "/archive?view=put");
  await choice(page, "Result").selectOption("new.json");
  await page.getByRole("button", { name: "Put into the archive" }).click();
  await page.getByText("Archived: 1 results, 1 files").waitFor();
  const told = JSON.parse(call("", "archive", "history", "demo-3", "--json", "--archive", archive));
  assert.equal(told.results.length, 6);
  assert.equal(told.events.at(-1).by, "Li Wei");
});

test("an approver signs with the password again, and a changed file is not the signed one", async () => {
  const page = await signedIn("A. Approver", "/archive");
  const told = () => JSON.parse(call("", "archive", "history", "demo-3", "--json", "--archive", archive));
  const sha256 = told().results[0].sha256;
  await page.goto((await laboratory()) + `/archive?kept=${sha256}&unit=${encodeURIComponent("triad/demo-3")}`);
  const form = page.getByRole("form", { name: "Sign" });
  await form.getByLabel("Reason").fill("all values are within their limits");
  await form.getByLabel("Password").fill("wrong horse");
  await form.getByRole("button").click();
  await page.getByRole("alert").getByText("attempts before a pause: 4").waitFor();
  assert.equal(told().signatures.length, 0);
  await form.getByLabel("Password").fill(passwords["A. Approver"]);
  await form.getByRole("button").click();
  await page.getByTestId("signatures").getByText("all values are within their limits").waitFor();
  const [signature] = told().signatures;
  assert.equal(signature.by, "A. Approver");
  assert.equal(signature.sha256, sha256);
  assert.equal(signature.meaning, "approved");
  writeFileSync(join(home, "changed.json"), readFileSync(join(home, "day 1.json"), "utf8").replace("Bias of a gyro", "Bias of a Gyro"));
  await page.reload();
  await choice(page, "File").selectOption("day 1.json");
  await page.getByTestId("compared").getByText("the same file").waitFor();
  await choice(page, "File").selectOption("changed.json");
  await page.getByTestId("compared").getByText("the signatures are not of it").waitFor();
  await assertAccessible(page, "signed");
  await picture(page, "archive-signed");
  call("", "archive", "verify", "--archive", archive);
});

test("a certificate is shown as it would be issued, and what is missing all at once", async () => {
  const page = await signedIn("A. Approver", "/archive?view=certificate&result=day+1.json&lab=poor+lab.toml");
  const missing = page.getByTestId("missing");
  await missing.getByText("[certificate] number", { exact: false }).waitFor();
  assert.ok((await missing.getByRole("listitem").count()) > 5);
  await choice(page, "Laboratory").selectOption("lab.toml");
  const frame = page.frameLocator("iframe.page");
  await frame.getByText("Specimen", { exact: false }).waitFor();
  await frame.getByText("Example Inertial Laboratory").first().waitFor();
  await frame.getByText("stand in the archive of the laboratory", { exact: false }).waitFor();
  await assertAccessible(page, "certificate");
  await page.screenshot({ path: join(root, "build/browser/archive-certificate.png") });
  await page.getByRole("button", { name: "Issue and archive" }).click();
  await page.getByRole("button", { name: /Jobs/ }).press("Enter"); // it moves when a job begins: a click may miss it
  await page.locator(".job.done", { hasText: "certificate.html" }).waitFor();
  const told = JSON.parse(call("", "archive", "history", "demo-3", "--json", "--archive", archive));
  assert.equal(told.certificates.length, 1);
  await page.goto((await laboratory()) + `/archive?kept=${told.certificates[0].sha256}&unit=${encodeURIComponent("triad/demo-3")}`);
  await page.frameLocator("iframe.page").getByText("Example Inertial Laboratory").first().waitFor();
  await page.getByRole("form", { name: "Sign" }).waitFor();
});

test("the archive speaks Chinese, and fits a phone", async () => {
  const page = await signedIn("R. Reader", unitOf, { viewport: { width: 390, height: 844 }, locale: "zh-CN" });
  await page.getByRole("heading", { name: "事件" }).waitFor();
  const words = await page.locator("main").innerText();
  assert.doesNotMatch(words, /archive_|session_/);
  for (const place of [unitOf, "/archive", "/archive?view=due", "/archive?view=certificate", unitOf + "&parameter=bias&kind=drift"]) {
    await page.goto((await laboratory()) + place);
    await page.getByRole("heading", { level: 1 }).waitFor();
    await drawn(page);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `${place} is ${wide} px too wide`);
  }
  await picture(page, "archive-phone");
});
