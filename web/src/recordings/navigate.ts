// Movements along the recording: what keys, wheel and buttons do to the span in view.
import { batch, signal } from "@preact/signals";
import type { Recording } from "../api";
import { cursors, selection, span, Span } from "./view";

/// Where the pointer is [s]; null: not on a plot.
export const pointed = signal<number | null>(null);

export function whole(recording: Recording): Span {
  return recording.last > recording.first
    ? { from: recording.first, to: recording.last }
    : { from: recording.first - 0.5, to: recording.first + 0.5 };
}

export function seen(recording: Recording): Span {
  return span.value ?? whole(recording);
}

/// At least two samples of the fastest channel, within the recording.
export function look(recording: Recording, wanted: Span): void {
  const all = whole(recording);
  const fastest = Math.max(...recording.channels.map((channel) => channel.rate), 1e-9);
  const width = Math.min(Math.max(wanted.to - wanted.from, 2 / fastest), all.to - all.from);
  const middle = 0.5 * (wanted.from + wanted.to);
  const from = Math.min(Math.max(middle - 0.5 * width, all.from), all.to - width);
  span.value = width >= all.to - all.from ? null : { from, to: from + width };
}

export function zoom(recording: Recording, factor: number, about?: number): void {
  const now = seen(recording);
  const centre = about ?? 0.5 * (now.from + now.to);
  look(recording, { from: centre - (centre - now.from) * factor, to: centre + (now.to - centre) * factor });
}

export function pan(recording: Recording, part: number): void {
  const now = seen(recording);
  const by = part * (now.to - now.from);
  look(recording, { from: now.from + by, to: now.to + by });
}

export function setCursor(recording: Recording, letter: "a" | "b", time?: number): void {
  const now = seen(recording);
  cursors.value = { ...cursors.value, [letter]: time ?? pointed.value ?? 0.5 * (now.from + now.to) };
}

export function showPlace(recording: Recording, time: number): void {
  const now = seen(recording), all = whole(recording);
  const width = Math.min(now.to - now.from, 0.1 * (all.to - all.from));
  look(recording, { from: time - 0.5 * width, to: time + 0.5 * width });
}

/// The next or the one before of the findings that have a time.
export function stepFinding(recording: Recording, direction: 1 | -1): void {
  const times = (recording.findings ?? [])
    .map((finding) => (finding.worst ?? finding.first)?.time)
    .filter((time): time is number => time !== undefined)
    .sort((x, y) => x - y);
  if (times.length === 0) return;
  const now = seen(recording), middle = 0.5 * (now.from + now.to), little = 1e-6 * (now.to - now.from);
  const following =
    direction > 0
      ? (times.find((time) => time > middle + little) ?? times[0])
      : ([...times].reverse().find((time) => time < middle - little) ?? times[times.length - 1]);
  showPlace(recording, following);
}

/// True: the key was one of ours.
export function pressKey(recording: Recording, event: KeyboardEvent): boolean {
  if (event.ctrlKey || event.metaKey || event.altKey) return false;
  const step = event.shiftKey ? 0.8 : 0.2;
  switch (event.key) {
    case "ArrowLeft": pan(recording, -step); return true;
    case "ArrowRight": pan(recording, step); return true;
    case "+": case "=": zoom(recording, 0.5, pointed.value ?? undefined); return true;
    case "-": zoom(recording, 2, pointed.value ?? undefined); return true;
    case "0": span.value = null; return true;
    case "a": setCursor(recording, "a"); return true;
    case "b": setCursor(recording, "b"); return true;
    case "n": stepFinding(recording, 1); return true;
    case "p": stepFinding(recording, -1); return true;
    case "z": if (selection.value) look(recording, selection.value); return true;
    case "Escape":
      batch(() => {
        selection.value = null;
        cursors.value = {};
      });
      return true;
    default: return false;
  }
}
