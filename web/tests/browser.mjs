// The workbench in a real browser: node browser.mjs PROGRAM PICTURES; ONLY=WORDS runs the tests whose names hold them.
import "./recordings.mjs";
import "./live.mjs";
import "./archive.mjs";
import "./station.mjs";
import "./results.mjs";
import "./plans.mjs";
import "./monkey.mjs";
import { runAll } from "./harness.mjs";

await runAll();
