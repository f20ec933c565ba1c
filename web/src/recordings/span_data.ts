// What is drawn of the span in view, asked from the server: one question at a time, the latest next.
import { signal } from "@preact/signals";
import { ChannelView, getView, problemsOf } from "../api";

export const views = signal<Record<string, ChannelView>>({});
export const overview = signal<ChannelView | null>(null);
export const viewProblems = signal<string[]>([]);
/// [ms] from the question to the answer decoded, of the last one.
export const answered = signal(0);

interface Question {
  query: string;
  channels: string[];
}

let asking: AbortController | null = null;
let next: Question | null = null;
let latest = "";

async function ask(question: Question): Promise<void> {
  asking = new AbortController();
  const begin = performance.now();
  try {
    const found = await getView(question.query, asking.signal);
    views.value = Object.fromEntries(question.channels.map((name, i) => [name, found[i]]));
    viewProblems.value = [];
    answered.value = performance.now() - begin;
  } catch (error) {
    if ((error as Error).name !== "AbortError") viewProblems.value = problemsOf(error);
  }
  asking = null;
  if (next) {
    const following = next;
    next = null;
    void ask(following);
  }
}

export function showSpan(question: Question): void {
  if (question.query === latest) return;
  latest = question.query;
  if (asking) next = question;
  else void ask(question);
}

export function forgetSpan(): void {
  asking?.abort();
  next = null;
  latest = "";
  views.value = {};
  overview.value = null;
  viewProblems.value = [];
}

export async function showOverview(query: string): Promise<void> {
  try {
    overview.value = (await getView(query, new AbortController().signal))[0] ?? null;
  } catch {
    overview.value = null;
  }
}
