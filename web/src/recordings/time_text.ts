// Times of the recording's own clock as people read them.
import { signal } from "@preact/signals";

export type Clock = "s" | "hms" | "clock";
export const clock = signal<Clock>("s");

function two(value: number): string {
  return String(value).padStart(2, "0");
}

function decimals(step: number): number {
  return Math.min(9, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)));
}

/// `start`: date and time of the zero of the recording's clock, where the file says it.
export function timeText(seconds: number, step: number, start?: string): string {
  const digits = decimals(step);
  if (clock.value === "s") return seconds.toFixed(digits);
  if (clock.value === "clock" && start) {
    const date = new Date(Date.parse(start) + 1e3 * seconds);
    if (!Number.isNaN(date.getTime())) return date.toISOString().slice(11, digits > 0 ? 23 : 19);
  }
  const sign = seconds < 0 ? "-" : "";
  const size = Math.abs(seconds);
  const rounded = Number(size.toFixed(digits));
  const hours = Math.floor(rounded / 3600), minutes = Math.floor((rounded % 3600) / 60);
  const rest = (rounded % 60).toFixed(digits);
  return `${sign}${hours}:${two(minutes)}:${rest.padStart(digits > 0 ? digits + 3 : 2, "0")}`;
}
