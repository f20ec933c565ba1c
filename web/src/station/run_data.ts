// A run as the server shows it: its state once, then what happens. A hidden page closes its stream; when it is seen
// again it asks for the state, so that nothing is lost.
import { signal } from "@preact/signals";
import { get, inLanguage, problemsOf } from "../api";
import { language } from "../texts";

export interface Facts {
  title: string;
  station: string;
  operator: string;
  rig: string;
  units: Record<string, string>;
  segments: { label: string; duration: number; duration_text: string; rule: string }[];
}

export interface Progress {
  state: "done" | "skipped" | "now" | "next";
  attempts: number;
}

export interface Prompt {
  id: number;
  text: string;
  choices: string[];
  standard: string;
}

export interface View {
  time: number;
  time_text: string;
  phase: string;
  segment: number;
  segments: Progress[];
  label: string;
  recorded: number;
  left_text: string;
  wall_left: number | null;
  acknowledged_text: string;
  frames: number;
  lost: number;
  damaged: number;
  axes: { name: string; demanded: string; position: string; rate: string }[];
  channels: {
    slot: string;
    name: string;
    unit: string;
    mean: string;
    sd: string;
    allan: string;
    low: number | null;
    high: number | null;
  }[];
  estimates: { slot: string; name: string; unit: string; text: string; low: number | null; high: number | null; sd: number | null }[];
  prompt?: Prompt;
}

/// End of the bar, least and greatest of each channel.
export type Bar = [number, (number | null)[], (number | null)[]];
/// Time, estimate less and plus its standard uncertainty, and this uncertainty.
export type Point = [number, number | null, number | null, number | null];

export interface Happened {
  id: number;
  time_text: string;
  kind: string;
  who: string;
  text: string;
  everyday?: boolean;
  step?: string;
  segment?: number;
  attempt?: number;
  ending?: string;
  reason?: string;
}

export interface Run {
  alive: boolean;
  last: number;
  ending: string;
  ending_text: string;
  facts: Facts;
  view: View | null;
  segments?: Progress[];
  curves: { recent: Bar[]; whole: Bar[] } | null;
  estimates: { slot: string; name: string; unit: string; points: Point[] }[];
  events: Happened[];
  recordings: string[];
}

export const run = signal<Run | null>(null);
export const problems = signal<string[]>([]);
/// Since when nothing comes [ms since 1970]; null: it does.
export const lostSince = signal<number | null>(null);

const MOST_BARS = 1200;
let wanted = "";
let stream: EventSource | null = null;
let timer: ReturnType<typeof setTimeout> | undefined;

const address = (path: string) => `${path}?run=${encodeURIComponent(wanted)}`;

function later(work: () => void, milliseconds: number): void {
  clearTimeout(timer);
  timer = setTimeout(work, milliseconds);
}

function close(): void {
  clearTimeout(timer);
  stream?.close();
  stream = null;
}

async function refresh(): Promise<boolean> {
  const asked = wanted;
  try {
    const { body } = await get<Run>(address("/api/station/run"));
    if (asked !== wanted) return false;
    // What the stream has brought since the program made this answer stays.
    const newer = (run.value?.events ?? []).filter((one) => one.id > body.last);
    run.value = { ...body, events: [...body.events, ...newer], last: Math.max(body.last, ...newer.map((one) => one.id)) };
    problems.value = [];
    lostSince.value = null;
    return true;
  } catch (error) {
    if (asked !== wanted) return false;
    problems.value = problemsOf(error);
    lostSince.value ??= Date.now();
    return false;
  }
}

function change(part: Partial<Run>): void {
  if (run.value) run.value = { ...run.value, ...part };
}

function take(view: View): void {
  const before = run.value;
  if (!before) return;
  const bar: Bar = [view.time, view.channels.map((one) => one.low), view.channels.map((one) => one.high)];
  const curves = before.curves ?? { recent: [], whole: [] };
  const newer = curves.recent.length === 0 || curves.recent[curves.recent.length - 1]![0] < view.time;
  const estimates = view.estimates.map((one) => {
    const known = before.estimates.find((other) => other.slot === one.slot && other.name === one.name);
    const points = known?.points ?? [], end = points[points.length - 1];
    const same = end !== undefined && end[1] === one.low && end[2] === one.high;
    const point: Point = [view.time, one.low, one.high, one.sd];
    return { slot: one.slot, name: one.name, unit: one.unit, points: same ? points : [...points, point] };
  });
  change({
    view,
    estimates,
    curves: newer ? { recent: [...curves.recent, bar].slice(-600), whole: [...curves.whole, bar] } : curves,
  });
  if (curves.whole.length > MOST_BARS) void refresh(); // the server has them in fewer bars
}

function listen(): void {
  close();
  if (document.hidden || !run.value?.alive) return;
  let broken = false;
  stream = new EventSource(inLanguage(`${address("/api/station/run/events")}&after=${run.value.last}`));
  const on = (name: string, work: (event: MessageEvent<string>) => void) =>
    stream!.addEventListener(name, (event) => {
      change({ last: Math.max(run.value?.last ?? 0, Number(event.lastEventId)) });
      work(event);
    });
  stream.onopen = () => {
    lostSince.value = null;
    if (broken) void refresh(); // curves of the time in between; events come again by their ids
    broken = false;
  };
  stream.onerror = () => {
    broken = true;
    lostSince.value ??= Date.now();
    if (stream?.readyState === EventSource.CLOSED) later(begin, 2000);
  };
  on("happened", (event) => {
    const happened = JSON.parse(event.data) as Happened;
    const known = happened.id > 0 && run.value?.events.some((one) => one.id === happened.id);
    if (run.value && !known) change({ events: [...run.value.events, happened] });
  });
  on("view", (event) => take(JSON.parse(event.data) as View));
  on("ended", (event) => {
    const { ending, text } = JSON.parse(event.data) as { ending: string; text: string };
    change({ ending, ending_text: text });
  });
  on("reset", () => void refresh());
  on("end", () => {
    close();
    later(begin, 300);
  });
}

/// The state, then what happens. A run that has ended may be carried on by somebody: it is looked at now and then.
async function begin(): Promise<void> {
  close();
  const asked = wanted;
  const good = await refresh();
  if (asked !== wanted || asked === "") return;
  if (good && run.value?.alive) listen();
  else later(() => void begin(), good ? 5000 : 2000);
}

export function watch(name: string): void {
  if (name === wanted) return;
  wanted = name;
  run.value = null;
  problems.value = [];
  lostSince.value = null;
  if (name === "") close();
  else void begin();
}

/// Again, after an order that begins a run anew.
export function again(): void {
  void begin();
}

let spoken = language.value;
language.subscribe((now) => {
  if (now === spoken) return;
  spoken = now;
  if (wanted !== "") void begin();
});

document.addEventListener("visibilitychange", () => {
  if (wanted === "") return;
  if (document.hidden) close();
  else void begin();
});
