// The workbench: the frame of every view, the session, the jobs.
import "./app.css";
import "uplot/dist/uPlot.min.css";
import { render } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { get, Job, post, problemsOf, waiting } from "./api";
import { cancel, connected, fileOfJob, jobs, start } from "./jobs";
import { ROOMS } from "./rooms";
import { loadSession } from "./session/session";
import { Signed, SignIn } from "./session/sign_in";
import { addressOf, arrive, go, path, query } from "./route";
import { language, loadTexts, setLanguage, t } from "./texts";

const KEYS = ["left_right", "plus_minus", "zero", "a_b", "click", "drag", "z", "n_p", "escape"];

function Help({ onClose }: { onClose: () => void }) {
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => dialog.current?.showModal(), []);
  return (
    <dialog ref={dialog} onClose={onClose} aria-labelledby="help-title">
      <h2 id="help-title">{t("keys")}</h2>
      <dl class="keys">
        {KEYS.map((name) => <div key={name}><dt>{t(`key_${name}`)}</dt><dd>{t(`key_${name}_does`)}</dd></div>)}
      </dl>
      <form method="dialog"><button>{t("close")}</button></form>
    </dialog>
  );
}

function JobLine({ job }: { job: Job }) {
  const active = job.state === "waiting" || job.state === "running";
  return (
    <li class={`job ${job.state}`} data-job={job.id}>
      <span class="job-title">{t(`job_${job.kind}`)}: {job.title}</span>
      <span class="job-state">{t(`job_is_${job.state}`)}{job.doing ? `, ${job.doing}` : ""}</span>
      {active && <progress value={job.progress} max={1} aria-label={job.title} />}
      {active && <button class="quiet" onClick={() => void cancel(job.id)}>{t("cancel")}</button>}
      {job.files.filter((name) => name !== "figure.svg").map((name) => (
        <a key={name} href={fileOfJob(job, name)} target="_blank" rel="noopener">{name}</a>
      ))}
      {job.problems.map((problem) => <span class="problem" key={problem}>{problem}</span>)}
    </li>
  );
}

/// What is being done, and on demand what has been.
function JobTray() {
  const [open, setOpen] = useState(false);
  const all = Object.values(jobs.value).sort((x, y) => y.begun - x.begun || y.id.localeCompare(x.id));
  const active = all.filter((job) => job.state === "waiting" || job.state === "running");
  const listed = (open ? all.slice(0, 100) : active.slice(0, 3));
  if (all.length === 0) return null;
  return (
    <section class="tray" aria-label={t("jobs")}>
      <button class="quiet" aria-expanded={open} onClick={() => setOpen(!open)}>
        {t("jobs")}: {active.length > 0 ? t("jobs_active", { count: active.length }) : t("jobs_none_active")}
      </button>
      <div role="status"><ul>{listed.map((job) => <JobLine key={job.id} job={job} />)}</ul></div>
    </section>
  );
}

function RoomLink({ room, name, current, children }: { room: string; name?: string; current?: boolean; children: string }) {
  const enter = (event: MouseEvent) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return; // into another tab or window
    event.preventDefault();
    go(room);
  };
  return <a class={name} href={room} aria-current={current ? "page" : undefined} onClick={enter}>{children}</a>;
}

function Frame() {
  const [help, setHelp] = useState(false);
  const room = ROOMS.find((one) => one.path === path.value) ?? ROOMS[0]!;
  const first = addressOf(path.value, query.value) === room.path;
  useEffect(() => {
    const key = (event: KeyboardEvent) => {
      if (event.key === "?" && !(event.target as HTMLElement).closest("input, textarea")) setHelp(true);
    };
    document.addEventListener("keydown", key);
    return () => document.removeEventListener("keydown", key);
  }, []);
  return (
    <>
      <a class="skip" href="#content">{t("skip")}</a>
      <header class="top">
        <RoomLink room="/" name="brand">Tumble</RoomLink>
        <nav aria-label={t("rooms")}>
          {ROOMS.map((one) => <RoomLink key={one.path} room={one.path} current={one === room && first}>{t(one.name)}</RoomLink>)}
        </nav>
        <span class={connected.value ? "connection" : "connection lost"} role="status">
          {connected.value ? "" : `⚠ ${t("connection_lost")}`}
        </span>
        <Signed />
        <select aria-label={t("language")} value={language.value} onChange={(event) => void setLanguage(event.currentTarget.value as "en" | "zh")}>
          <option value="en" lang="en">English</option>
          <option value="zh" lang="zh-CN">中文</option>
        </select>
        <button onClick={() => setHelp(true)} aria-label={t("help")} title={`${t("help")} (?)`}>?</button>
      </header>
      <main id="content" tabIndex={-1} aria-busy={waiting.value > 0}><room.Page key={room.path} /></main>
      <JobTray />
      {help && <Help onClose={() => setHelp(false)} />}
    </>
  );
}

function Closed({ problems }: { problems: string[] }) {
  return (
    <main class="closed">
      <h1>Tumble</h1>
      <p>{t("session_needed")}</p>
      <p class="hint">{problems.join("; ")}</p>
    </main>
  );
}

/// The token of the link becomes a cookie that no script can read, and leaves the address.
async function openSession(): Promise<void> {
  const token = /^#token=([0-9a-f]+)$/.exec(location.hash)?.[1];
  if (token === undefined) return;
  history.replaceState(null, "", location.pathname + location.search);
  await post("/api/session", { token });
}

async function begin(): Promise<void> {
  const place = document.getElementById("app")!;
  arrive();
  await loadTexts();
  try {
    await openSession();
    const session = await loadSession();
    if (session.users && !session.open) {
      render(<SignIn onOpen={() => void begin()} />, place);
      return;
    }
    const { body } = await get<{ folder: string }>("/api/workbench");
    document.title = `${body.folder} · Tumble`;
  } catch (error) {
    render(<Closed problems={problemsOf(error)} />, place);
    return;
  }
  window.addEventListener("popstate", arrive);
  await start();
  render(<Frame />, place);
}

void begin();
