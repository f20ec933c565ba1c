// What the server says of plans. Predictions, attitudes, texts of numbers and the form's fields come from there.
import { inLanguage, Problem, waiting } from "../api";

export interface ListedPlan {
  name: string;
  method: string;
  title: string;
  instrument: string;
  rig: string;
  modified: number;
}

export interface Template {
  name: string;
  method: string;
  title: string;
}

/// A value of the plan as its text has it: a text, a table or a list of tables.
export interface Node {
  line: number;
  text?: string;
  quoted?: boolean;
  table?: Record<string, Node>;
  list?: Node[];
}

export interface PlacedProblem {
  line: number;
  message: string;
}

export interface PlannedSegment {
  label: string;
  begin: number;
  duration: number;
}

export interface PlannedRun {
  run: number;
  duration: number;
  segments: PlannedSegment[];
}

export interface Look {
  problems: PlacedProblem[];
  document: Record<string, Node> | null;
  schedule: { total: number; runs: PlannedRun[] } | null;
}

export interface Option {
  name: string;
  type: "quantity" | "integer" | "word" | "flag" | "integers" | "text";
  unit?: string;
  min?: number;
  max?: number;
  min_excluded?: boolean;
  max_excluded?: boolean;
  default: string | null;
  words?: string[];
  description: string;
}

export interface Axis {
  name: string;
  unit: string;
  motions: string[];
  description: string;
}

export interface Entry {
  name: string;
  summary: string;
  source?: string;
  options: Option[];
  axes?: Axis[];
  roles?: { name: string; unit: string; required: boolean; description: string }[];
}

/// A part of the rig at some instants: nine cosines (its axes in level axes, one after the other) and its place [m].
export interface Part {
  name: string;
  axis: [number, number, number];
  slides: boolean;
  at: number[][];
}

export interface Motion {
  from: number;
  step: number;
  parts: Part[];
  axes: { name: string; values: string[] }[];
  settled: number[];
  earth_rate: [number, number, number];
  gravity: [number, number, number];
}

export interface PredictedRow {
  name: string;
  symbol: string;
  unit: string;
  description: string;
  sd: string;
  saved: string;
  ratio: string;
  change: "none" | "new" | "same" | "worse" | "better";
}

export interface Prediction {
  ready: boolean;
  rows: PredictedRow[];
  lost: string[];
  worse: number;
  better: number;
  findings: { severity: "info" | "warning" | "error"; code: string; message: string }[];
  problems: string[];
}

/// A question with a plan in it, which may be given up.
export async function ask<Answer>(path: string, body: unknown, control?: AbortSignal): Promise<Answer> {
  ++waiting.value;
  try {
    const response = await fetch(inLanguage(path), { method: "POST", body: JSON.stringify(body), signal: control });
    const answer = await response.json().catch(() => null);
    if (response.ok && answer === null) throw { status: 0, problems: [] } as Problem; // the answer was cut off
    if (!response.ok) throw { status: response.status, problems: answer?.problems ?? [response.statusText] } as Problem;
    return answer as Answer;
  } finally {
    --waiting.value;
  }
}
