// What is seen of the recordings, and its address: file, span, selection, cursors, channels, units.
import { batch, computed, effect, signal } from "@preact/signals";
import { go, onArrival, path, show } from "../route";

/// The path of this room.
export const RECORDINGS = "/";

export interface Span {
  from: number;
  to: number;
}

export const file = signal<string | null>(null);
export const span = signal<Span | null>(null);
export const selection = signal<Span | null>(null);
export const cursors = signal<{ a?: number; b?: number }>({});
export const hidden = signal<string[]>([]);
export const units = signal<Record<string, string>>({});
export const sets = signal<string[]>([]);

function numbers(text: string | null): number[] {
  return (text ?? "").split(",").filter(Boolean).map(Number).filter(Number.isFinite);
}

function spanOf(text: string | null): Span | null {
  const [from, to] = numbers(text);
  return from !== undefined && to !== undefined && to > from ? { from, to } : null;
}

function readView(query: URLSearchParams): void {
  batch(() => {
    file.value = query.get("file");
    span.value = spanOf(query.get("span"));
    selection.value = spanOf(query.get("selection"));
    const a = numbers(query.get("a"))[0], b = numbers(query.get("b"))[0];
    cursors.value = { ...(a !== undefined && { a }), ...(b !== undefined && { b }) };
    hidden.value = query.getAll("hide");
    sets.value = query.getAll("set");
    units.value = Object.fromEntries(
      query.getAll("unit").map((text) => {
        const at = text.lastIndexOf("~");
        return [text.slice(0, at), text.slice(at + 1)];
      }),
    );
  });
}

/// Nine digits are more than any screen shows.
function digits(value: number): string {
  return String(Number(value.toPrecision(12)));
}

const query = computed(() => {
  const made = new URLSearchParams();
  if (file.value === null) return made;
  made.set("file", file.value);
  if (span.value) made.set("span", `${digits(span.value.from)},${digits(span.value.to)}`);
  if (selection.value) made.set("selection", `${digits(selection.value.from)},${digits(selection.value.to)}`);
  if (cursors.value.a !== undefined) made.set("a", digits(cursors.value.a));
  if (cursors.value.b !== undefined) made.set("b", digits(cursors.value.b));
  for (const name of hidden.value) made.append("hide", name);
  for (const text of sets.value) made.append("set", text);
  for (const [name, unit] of Object.entries(units.value)) made.append("unit", `${name}~${unit}`);
  return made;
});

/// Another recording, or the list; "back" leads to where one was.
export function openFile(to: string | null, how: string[] = []): void {
  const next = new URLSearchParams();
  if (to !== null) next.set("file", to);
  for (const text of how) next.append("set", text);
  go(RECORDINGS, next);
}

onArrival(RECORDINGS, readView);
effect(() => {
  const now = query.value;
  if (path.peek() === RECORDINGS) show(now);
});
