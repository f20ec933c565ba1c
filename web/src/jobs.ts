// Jobs of the server, kept up to date by its events. A hidden page closes its stream, since browsers allow few
// connections to one server, and goes on behind the last event when it is seen again.
import { signal } from "@preact/signals";
import { get, inLanguage, Job, post } from "./api";
import { language } from "./texts";

export const jobs = signal<Record<string, Job>>({});
export const connected = signal(true);
/// Grows when files of the folder have changed.
export const listing = signal(0);

let stream: EventSource | null = null;
let last = 0;

async function refresh(): Promise<void> {
  const { body } = await get<{ event: number; jobs: Job[] }>("/api/jobs");
  last = body.event;
  jobs.value = Object.fromEntries(body.jobs.map((job) => [job.id, job]));
}

function close(): void {
  stream?.close();
  stream = null;
}

function open(): void {
  close();
  stream = new EventSource(inLanguage("/api/events?after=" + last));
  stream.onopen = () => (connected.value = true);
  stream.onerror = () => {
    connected.value = false;
    if (stream?.readyState === EventSource.CLOSED) setTimeout(start, 3000);
  };
  stream.addEventListener("job", (event) => {
    last = Number(event.lastEventId);
    const job = JSON.parse(event.data) as Job;
    const before = jobs.value[job.id];
    jobs.value = { ...jobs.value, [job.id]: job };
    if (job.kind === "prepare" && job.state !== before?.state && job.state !== "running") ++listing.value;
  });
  stream.addEventListener("recordings", (event) => {
    last = Number(event.lastEventId);
    ++listing.value;
  });
  stream.addEventListener("reset", (event) => {
    last = Number(event.lastEventId);
    close();
    void start(); // events that come while the jobs are asked for come again
    ++listing.value;
  });
}

export async function start(): Promise<void> {
  try {
    await refresh();
    connected.value = true;
    if (!document.hidden) open();
  } catch {
    connected.value = false;
    setTimeout(start, 3000);
  }
}

let spoken = language.value;
language.subscribe((now) => {
  if (now === spoken) return;
  spoken = now;
  void start();
});

document.addEventListener("visibilitychange", () => {
  if (document.hidden) close();
  else open();
});

export function cancel(id: string): Promise<unknown> {
  return post("/api/jobs/cancel?id=" + encodeURIComponent(id), {});
}

export function fileOfJob(job: Job, name: string): string {
  return `/api/jobs/file?id=${encodeURIComponent(job.id)}&name=${encodeURIComponent(name)}`;
}
