// Every view is its address: file, span, selection, cursors, channels, units.
import { batch, computed, signal } from "@preact/signals";

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

export function readAddress(): void {
  const query = new URLSearchParams(location.search);
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

export const address = computed(() => {
  const query = new URLSearchParams();
  if (file.value === null) return "/";
  query.set("file", file.value);
  if (span.value) query.set("span", `${digits(span.value.from)},${digits(span.value.to)}`);
  if (selection.value) query.set("selection", `${digits(selection.value.from)},${digits(selection.value.to)}`);
  if (cursors.value.a !== undefined) query.set("a", digits(cursors.value.a));
  if (cursors.value.b !== undefined) query.set("b", digits(cursors.value.b));
  for (const name of hidden.value) query.append("hide", name);
  for (const text of sets.value) query.append("set", text);
  for (const [name, unit] of Object.entries(units.value)) query.append("unit", `${name}~${unit}`);
  return "/?" + query.toString();
});

/// Another recording, or the list; "back" leads to where one was.
export function go(to: string | null, how: string[] = []): void {
  batch(() => {
    file.value = to;
    span.value = selection.value = null;
    cursors.value = {};
    hidden.value = [];
    units.value = {};
    sets.value = how;
  });
  history.pushState(null, "", address.value);
}
