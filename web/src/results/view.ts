// What is seen of the results, and its address: one result with its units, figure, span and marks, or several compared.
import { batch, computed, effect, signal } from "@preact/signals";
import { go, onArrival, path, show } from "../route";

/// The path of this room.
export const RESULTS = "/results";

export interface Zoom {
  from: number;
  to: number;
}

export const files = signal<string[]>([]);
/// Units by name of the parameter.
export const units = signal<Record<string, string>>({});
/// Number of the figure that is shown, from 1.
export const figure = signal(1);
export const zoom = signal<Zoom | null>(null);
/// Numbers of the series that are not drawn.
export const hidden = signal<number[]>([]);
/// Whether the correlations are written as numbers.
export const numbers = signal(false);
/// Which matrix of the parameters is shown.
export const matrix = signal<"correlation" | "covariance">("correlation");
/// The parameter whose budget is open, or that is drawn over units.
export const parameter = signal("");

function readView(query: URLSearchParams): void {
  batch(() => {
    files.value = query.getAll("file");
    units.value = Object.fromEntries(
      query.getAll("unit").map((text) => {
        const at = text.lastIndexOf("~");
        return [text.slice(0, at), text.slice(at + 1)];
      }),
    );
    figure.value = Math.max(1, Math.floor(Number(query.get("figure") ?? 1)) || 1);
    const [from, to] = (query.get("zoom") ?? "").split(",").filter(Boolean).map(Number);
    zoom.value = from !== undefined && to !== undefined && to > from ? { from, to } : null;
    hidden.value = query.getAll("hide").map(Number).filter(Number.isInteger);
    numbers.value = query.get("numbers") === "1";
    matrix.value = query.get("matrix") === "covariance" ? "covariance" : "correlation";
    parameter.value = query.get("parameter") ?? "";
  });
}

function digits(value: number): string {
  return String(Number(value.toPrecision(9)));
}

const query = computed(() => {
  const made = new URLSearchParams();
  for (const name of files.value) made.append("file", name);
  if (files.value.length === 0) return made;
  for (const [name, unit] of Object.entries(units.value)) made.append("unit", `${name}~${unit}`);
  if (figure.value !== 1) made.set("figure", String(figure.value));
  if (zoom.value) made.set("zoom", `${digits(zoom.value.from)},${digits(zoom.value.to)}`);
  for (const series of hidden.value) made.append("hide", String(series));
  if (numbers.value) made.set("numbers", "1");
  if (matrix.value === "covariance") made.set("matrix", "covariance");
  if (parameter.value) made.set("parameter", parameter.value);
  return made;
});

export function queryOf(names: string[]): URLSearchParams {
  return new URLSearchParams(names.map((name) => ["file", name]));
}

/// The list, one result, or several beside each other; "back" leads to where one was.
export function openResults(names: string[]): void {
  go(RESULTS, queryOf(names));
}

export function showFigure(number: number): void {
  batch(() => {
    figure.value = number;
    zoom.value = null;
    hidden.value = [];
  });
}

onArrival(RESULTS, readView);
effect(() => {
  const now = query.value;
  if (path.peek() === RESULTS) show(now);
});
