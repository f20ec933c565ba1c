// What the server says of results. Every text of a value is its work.
import { useEffect, useState } from "preact/hooks";
import { Finding, get, problemsOf } from "../api";

export interface ListedResult {
  name: string;
  method: string;
  method_name: string;
  title: string;
  model: string;
  serial: string;
  date: string;
  modified: number;
  passed: number;
  failed: number;
  undecided: number;
  errors: number;
}

/// "-4" and ".12"; the row has the power of ten of all its numbers.
export type Split = [string, string];

export interface ParameterRow {
  name: string;
  readable: string;
  symbol: string;
  description: string;
  unit: string;
  units: string[];
  value: Split;
  sd: Split;
  power: string;
  lower: Split;
  upper: Split;
  degrees_of_freedom: string;
  budget: { sd: string; percent: string; share: number | null }[];
}

export interface Verdict {
  parameter: string;
  readable: string;
  outcome: "pass" | "fail" | "undecided";
  limit: string;
  measured: string;
  sd: string;
}

export interface Result {
  name: string;
  method: string;
  method_name: string;
  title: string;
  model: string;
  serial: string;
  fit: { observations: number; degrees_of_freedom: string; chi_square: string } | null;
  verdicts: Verdict[];
  sources: string[];
  parameters: ParameterRow[];
  with_prior?: ParameterRow[];
  findings: Finding[];
  figures: string[];
  correlation: (number | null)[][] | null;
  covariance: (string | null)[][] | null;
  compensates: boolean;
  provenance: {
    inputs: { file: string; sha256: string }[];
    plans: { file: string; sha256: string; text: string }[];
    settings: Record<string, string>;
    command_line: Record<string, string>;
    seed: number | null;
  };
}

export interface Axis {
  name: string;
  unit: string;
  logarithmic: boolean;
}

export interface Series {
  name: string;
  points: boolean;
  colour: string;
  dark: string;
  dashes: string;
  x: (number | null)[];
  y: (number | null)[];
  band?: string;
  lower?: (number | null)[];
  upper?: (number | null)[];
  /// On the axis z of the figure: shown by the colour of each point.
  z?: (number | null)[];
  /// Where each point leads; null: nowhere.
  links?: (Link | null)[];
}

export interface Link {
  unit: string;
  result: string;
}

/// What colours mean: from `low` to `high`, with ticks at 0 to 1.
export interface Scale extends Axis {
  title: string;
  low: number;
  high: number;
  colours: string[];
  ticks: { at: number; label: string }[];
}

export interface Figure {
  name: string;
  x: Axis;
  y: Axis;
  series: Series[];
  notes: string[];
  z?: Scale;
  /// Edges of columns and rows, and the value of each cell, row after row.
  map?: { x: number[]; y: number[]; values: (number | null)[] };
}

export interface Compared {
  results: { name: string; method: string; model: string; serial: string }[];
  pairs: {
    earlier: number;
    later: number;
    together: string;
    differences: { parameter: string; readable: string; unit: string; earlier: string; later: string; difference: string; e_n: string; significant: boolean }[];
  }[];
  figures: Figure[];
  values: { value: string; sd: string }[][];
  findings: Finding[];
}

/// The answer at an address; the earlier one stays until the next is there.
export function useAnswer<Answer>(address: string | null, again: unknown = 0): { answer: Answer | null; problems: string[] } {
  const [answer, setAnswer] = useState<Answer | null>(null);
  const [problems, setProblems] = useState<string[]>([]);
  useEffect(() => {
    if (address === null) return;
    const control = new AbortController();
    get<Answer>(address, control.signal).then(
      ({ body }) => {
        setAnswer(body);
        setProblems([]);
      },
      (error) => {
        if ((error as Error).name !== "AbortError") setProblems(problemsOf(error));
      },
    );
    return () => control.abort();
  }, [address, again]);
  return { answer, problems };
}
