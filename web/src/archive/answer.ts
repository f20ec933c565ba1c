// Questions to the archive that a page shows, asked again when their address or the archive changes.
import { useEffect, useState } from "preact/hooks";
import { get, problemsOf } from "../api";
import { listing } from "../jobs";
import { go } from "../route";

export interface Answer<Body> {
  body: Body | null;
  problems: string[];
}

/// `path` null: nothing is asked.
export function useAnswer<Body>(path: string | null): Answer<Body> {
  const [answer, setAnswer] = useState<Answer<Body> & { path: string | null }>({ body: null, problems: [], path: null });
  useEffect(() => {
    if (path === null) return;
    const control = new AbortController();
    get<Body>(path, control.signal).then(
      ({ body }) => setAnswer({ body, problems: [], path }),
      (error) => control.signal.aborted || setAnswer({ body: null, problems: problemsOf(error), path }),
    );
    return () => control.abort();
  }, [path, listing.value]);
  return answer.path === path ? answer : { body: null, problems: [] };
}

export const ROOM = "/archive";

export const addressIn = (seen: Record<string, string>): string => `${ROOM}?${new URLSearchParams(seen)}`;

/// For links within the room: a click shows the view, other ways to open a link stay as they are.
export function enter(event: MouseEvent, seen: Record<string, string>): void {
  if (event.ctrlKey || event.metaKey || event.shiftKey) return;
  event.preventDefault();
  go(ROOM, new URLSearchParams(seen));
}

export interface Unit {
  model: string;
  serial: string;
  results: number;
  first: string;
  last: string;
  due: string;
  overdue: boolean;
}

export interface Signature {
  number: number;
  of: "result" | "certificate";
  sha256: string;
  meaning: "reviewed" | "approved";
  by: string;
  time: string;
  why: string;
  problem: string;
}

export interface UnitRecord {
  model: string;
  serial: string;
  results: {
    sha256: string; method: string; title: string; verdict: string; by: string; ended: string; archived: string;
    simulated: boolean; replaced_by: string; reason: string;
  }[];
  runs: { id: string; title: string; station: string; slot: string; operator: string; started: string; ending: string }[];
  files: { sha256: string; role: string; name: string; bytes: number }[];
  certificates: { number: string; format: string; sha256: string; result: string; issued_by: string; issued: string }[];
  signatures: Signature[];
  events: { number: number; time: string; by: string; what: string; which: string; why: string; detail: string }[];
  parameters: string[];
}

export const nameOf = (unit: { model: string; serial: string }): string => `${unit.model}/${unit.serial}`;
/// "2026-11-20T09:00:00Z" for people: "2026-11-20 09:00".
export const moment = (time: string): string => time.slice(0, 16).replace("T", " ");
export const short = (sha256: string): string => sha256.slice(0, 12);
