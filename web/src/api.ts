// What the server answers, and how it is asked. No number is made here: values, statistics and texts of numbers come
// from the server.

import { signal } from "@preact/signals";
import { language } from "./texts";

/// Questions that have no answer yet.
export const waiting = signal(0);

export interface Problem {
  status: number;
  problems: string[];
}

export interface ListedRecording {
  name: string;
  bytes: number;
  modified: number;
  instrument?: string;
  channels?: string[];
  samples?: number;
  duration?: number;
  warnings?: number;
  live?: { going_on: boolean };
  job?: string;
  problems?: string[];
}

export interface Channel {
  name: string;
  kind: string;
  unit: string;
  units: string[];
  samples: number;
  first: number;
  last: number;
  rate: number;
  stamped: boolean;
}

export interface Mark {
  label: string;
  begin: number;
  end: number;
  run: number;
}

export interface Place {
  label?: string;
  time?: number;
}

export interface Finding {
  severity: "info" | "warning" | "error";
  code: string;
  message: string;
  where?: string;
  count: number;
  first?: Place;
  worst?: Place;
}

export interface Recording {
  name: string;
  tag: string;
  sha256: string;
  instrument: string;
  first: number;
  last: number;
  channels: Channel[];
  marks: Mark[];
  meta: Record<string, string>;
  findings: Finding[] | null;
  /// Of a recording that is being made: what it becomes, and whether more is there than was read so far.
  live?: { going_on: boolean; behind: boolean; target: string };
  job?: string;
  problems?: string[];
}

export interface StatisticsRow {
  channel: string;
  unit: string;
  samples: number;
  missing: number;
  slope_unit: string;
  text: { mean: string; sd: string; minimum: string; maximum: string; slope: string };
}

export interface ValuesRow {
  channel: string;
  unit: string;
  values: { time: number; text: string }[];
  difference_text?: string;
  time_difference?: number;
}

export interface Job {
  id: string;
  kind: string;
  title: string;
  state: "waiting" | "running" | "done" | "failed" | "cancelled";
  doing: string;
  progress: number;
  begun: number;
  problems: string[];
  files: string[];
}

export interface Plans {
  plans: { name: string; method: string; title: string }[];
  methods: { name: string; summary: string }[];
}

/// The address of a question that is answered in the language of the page.
export function inLanguage(path: string): string {
  if (language.value === "en" || /[?&]language=/.test(path)) return path;
  return `${path}${path.includes("?") ? "&" : "?"}language=${language.value}`;
}

async function refused(response: Response): Promise<Problem> {
  try {
    const body = await response.json();
    return { status: response.status, problems: body.problems ?? [response.statusText] };
  } catch {
    return { status: response.status, problems: [response.statusText || String(response.status)] };
  }
}

async function counted<Answer>(asking: () => Promise<Answer>): Promise<Answer> {
  ++waiting.value;
  try {
    return await asking();
  } finally {
    --waiting.value;
  }
}

export function get<Answer>(path: string, control?: AbortSignal): Promise<{ status: number; body: Answer }> {
  return counted(async () => {
    const response = await fetch(inLanguage(path), { signal: control });
    if (!response.ok) throw await refused(response);
    return { status: response.status, body: (await response.json()) as Answer };
  });
}

export async function post<Answer>(path: string, body: unknown): Promise<Answer> {
  const response = await fetch(inLanguage(path), { method: "POST", body: JSON.stringify(body) });
  if (!response.ok) throw await refused(response);
  return (await response.json()) as Answer;
}

/// Sends a file as it is, and reports how much of it has gone.
export function upload(file: File, progress: (done: number) => void): Promise<{ name: string }> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", inLanguage("/api/uploads?name=" + encodeURIComponent(file.name)));
    request.upload.onprogress = (event) => progress(event.total > 0 ? event.loaded / event.total : 0);
    request.onload = () => {
      let body: { name?: string; problems?: string[] } = {};
      try {
        body = JSON.parse(request.responseText);
      } catch {
        body = { problems: [request.responseText] };
      }
      if (request.status === 201 && body.name) resolve({ name: body.name });
      else reject({ status: request.status, problems: body.problems ?? [request.statusText] });
    };
    request.onerror = () => reject({ status: 0, problems: [] });
    request.send(file);
  });
}

export function problemsOf(error: unknown): string[] {
  const problem = error as Partial<Problem>;
  return problem && problem.problems ? problem.problems : [String(error)];
}

/// A stretch of one channel as it is drawn; docs/workbench.md describes the bytes.
export interface ChannelView {
  samples: boolean;
  block: number;
  times: Float64Array;
  low: (number | null)[];
  high: (number | null)[];
  missing: boolean;
}

const HEAD = 7;

function shown(value: number): number | null {
  return Number.isNaN(value) ? null : value;
}

export function decodeView(bytes: ArrayBuffer): ChannelView[] {
  let place = 0;
  const float64 = (count: number): Float64Array => {
    const numbers = new Float64Array(bytes, place, count);
    place += 8 * count;
    return numbers;
  };
  const padded = (count: number) => {
    place = Math.ceil((place + count) / 8) * 8;
  };
  const channels = float64(1)[0];
  const views: ChannelView[] = [];
  for (let i = 0; i < channels; ++i) {
    const [samples, count, , block, offset, start, step] = float64(HEAD);
    const times = new Float64Array(count);
    if (step === 0) times.set(float64(count));
    else for (let k = 0; k < count; ++k) times[k] = start + k * step;
    if (samples === 1) {
      const values = Array.from(float64(count), shown);
      views.push({ samples: true, block, times, low: values, high: values, missing: values.includes(null) });
      continue;
    }
    const low = new Float32Array(bytes, place, count);
    padded(4 * count);
    const high = new Float32Array(bytes, place, count);
    padded(4 * count);
    const flags = new Uint8Array(bytes, place, count);
    padded(count);
    views.push({
      samples: false,
      block,
      times,
      low: Array.from(low, (value) => shown(offset + value)),
      high: Array.from(high, (value) => shown(offset + value)),
      missing: flags.some((flag) => (flag & 1) !== 0),
    });
  }
  return views;
}

export function getView(query: string, control: AbortSignal): Promise<ChannelView[]> {
  return counted(async () => {
    const response = await fetch(inLanguage("/api/recording/view?" + query), { signal: control });
    if (!response.ok) throw await refused(response);
    return decodeView(await response.arrayBuffer());
  });
}
