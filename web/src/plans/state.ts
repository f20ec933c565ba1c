// The plan that is open: its text, what is saved of it, what the server says of it, and its address.
import { batch, computed, effect, signal } from "@preact/signals";
import { get, problemsOf } from "../api";
import { go, onArrival, path as place, show } from "../route";
import { language } from "../texts";
import { ask, Entry, Look } from "./ask";

export const PLANS = "/plans";

/// Name of the file; "": a plan that has none yet; null: the list is shown.
export const file = signal<string | null>(null);
export const template = signal<string | null>(null);
/// What of the editor is shown: "form", "text", or "" for what fits.
export const shown = signal("");
export const run = signal(1);
/// [s since power-on] where the picture is.
export const time = signal(0);
/// "svg": without WebGL.
export const draw = signal("");

export const text = signal("");
/// What the file holds; null: it is not there yet.
export const saved = signal<string | null>(null);
export const tag = signal("");
export const look = signal<Look | null>(null);
/// The last one whose text could be read, for the form while the text cannot.
export const lastDocument = signal<Look["document"]>(null);
export const lastSchedule = signal<Look["schedule"]>(null);
export const trouble = signal<string[]>([]);
export const history = signal<string[]>([]);

/// The text is that of the address.
export const loaded = signal(false);
/// It is what was written here before, and not saved.
export const restored = signal(false);

export const unsaved = computed(() => text.value !== (saved.value ?? ""));

function read(query: URLSearchParams): void {
  batch(() => {
    file.value = query.get("file") ?? (query.has("template") ? "" : null);
    template.value = query.get("template");
    shown.value = query.get("show") ?? "";
    run.value = Number(query.get("run") ?? 1) || 1;
    time.value = Math.max(0, Number(query.get("t") ?? 0) || 0);
    draw.value = query.get("draw") ?? "";
  });
}

const query = computed(() => {
  const made = new URLSearchParams();
  if (file.value === null) return made;
  if (file.value !== "") made.set("file", file.value);
  else if (template.value !== null) made.set("template", template.value);
  if (shown.value) made.set("show", shown.value);
  if (run.value !== 1) made.set("run", String(run.value));
  if (time.value > 0) made.set("t", String(Math.round(10 * time.value) / 10));
  if (draw.value) made.set("draw", draw.value);
  return made;
});

export function openPlan(to: { file?: string; template?: string } | null): void {
  const next = new URLSearchParams();
  if (to?.file) next.set("file", to.file);
  if (to?.template) next.set("template", to.template);
  go(PLANS, next);
}

onArrival(PLANS, read);
let shownLast = 0, pending: ReturnType<typeof setTimeout> | undefined;
effect(() => {
  const now = query.value;
  if (place.peek() !== PLANS) return;
  const since = performance.now() - shownLast; // browsers refuse an address that changes at every frame
  clearTimeout(pending);
  pending = setTimeout(() => {
    shownLast = performance.now();
    if (place.peek() === PLANS) show(now);
  }, since > 500 ? 0 : 500);
});
const draftKey = () => `plan ${file.value || ""} ${file.value ? "" : (template.value ?? "")}`;

/// What is written and not saved stays in this tab, whatever is opened meanwhile.
effect(() => {
  if (!loaded.value || file.peek() === null) return;
  if (unsaved.value && history.value.length > 0) sessionStorage.setItem(draftKey(), JSON.stringify({ text: text.value, tag: tag.value }));
  else sessionStorage.removeItem(draftKey());
});

function draft(): { text: string; tag: string } | null {
  try {
    return JSON.parse(sessionStorage.getItem(draftKey()) ?? "null");
  } catch {
    return null;
  }
}

/// Opens what the address says; with what was written before and not saved, unless `anew`.
export async function load(anew = false): Promise<void> {
  const name = file.value, ready = template.value;
  batch(() => {
    loaded.value = false;
    restored.value = false;
    text.value = "";
    saved.value = null;
    history.value = [];
    trouble.value = [];
    look.value = null;
    lastDocument.value = null;
    lastSchedule.value = null;
  });
  const asked = name ? "file=" + encodeURIComponent(name) : "template=" + encodeURIComponent(ready ?? "");
  try {
    const { body } = await get<{ text: string; tag: string }>("/api/plan?" + asked);
    if (file.value !== name || template.value !== ready) return;
    const kept = anew ? null : draft();
    batch(() => {
      text.value = kept?.text ?? body.text;
      saved.value = name ? body.text : null;
      tag.value = kept?.tag ?? body.tag;
      history.value = kept && kept.text !== body.text ? [body.text] : [];
      restored.value = history.value.length > 0;
      loaded.value = true;
    });
  } catch (error) {
    trouble.value = problemsOf(error);
  }
}

/// Another text; the one before can be brought back.
export function write(next: string, remember = true): void {
  if (next === text.value) return;
  batch(() => {
    if (remember) history.value = [...history.value.slice(-99), text.value];
    text.value = next;
  });
}

export function undo(): void {
  const before = history.value[history.value.length - 1];
  if (before === undefined) return;
  batch(() => {
    history.value = history.value.slice(0, -1);
    text.value = before;
  });
}

let edits: Promise<unknown> = Promise.resolve();

/// One change of the form, made in the text by the server; one after the other.
export function change(kind: string, path: (string | number)[], value?: unknown): Promise<void> {
  const next = edits.then(async () => {
    const body = { file: file.value || "plan.toml", text: text.value, change: kind, path: path.map(String), value };
    write((await ask<{ text: string }>("/api/plan/edit", body)).text);
  });
  edits = next.catch(() => undefined);
  return next;
}

const entries = new Map<string, Promise<Entry>>();

/// All that the catalogue says of a method, a model or a rig.
export function entry(kind: string, name: string): Promise<Entry> {
  const key = `${kind}/${name}/${language.value}`;
  const known = entries.get(key);
  if (known) return known;
  const asked = get<Entry>(`/api/catalogue?kind=${kind}&name=${encodeURIComponent(name)}`).then((answer) => answer.body);
  entries.set(key, asked);
  asked.catch(() => entries.delete(key));
  return asked;
}

/// Asks what the text means, when it has been the same for a moment.
export function lookAt(now: string): () => void {
  const control = new AbortController();
  const timer = setTimeout(async () => {
    try {
      const seen = await ask<Look>("/api/plan/look", { file: file.value ?? "", text: now }, control.signal);
      batch(() => {
        look.value = seen;
        trouble.value = [];
        if (seen.document) lastDocument.value = seen.document;
        if (seen.schedule) lastSchedule.value = seen.schedule;
      });
    } catch (error) {
      if (!control.signal.aborted) trouble.value = problemsOf(error);
    }
  }, look.value ? 120 : 0);
  return () => {
    clearTimeout(timer);
    control.abort();
  };
}
