// The stations of the folder and their runs, or one run.
import "./station.css";
import { effect, signal } from "@preact/signals";
import { go, onArrival } from "../route";
import { RunPage } from "./run";
import { watch } from "./run_data";
import { StationsPage } from "./stations";

/// The path of this room.
export const STATION = "/station";

const seen = signal<string>("");
onArrival(STATION, (query) => (seen.value = query.get("run") ?? ""));
effect(() => watch(seen.value));

export function openRun(run: string): void {
  go(STATION, new URLSearchParams({ run }));
}

export function StationRoom() {
  return seen.value === "" ? <StationsPage onRun={openRun} /> : <RunPage key={seen.value} name={seen.value} />;
}
