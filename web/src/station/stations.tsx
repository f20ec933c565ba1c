// The stations of the folder, their runs, and how a run is begun.
import { useEffect, useState } from "preact/hooks";
import { get, Plans, post, problemsOf } from "../api";
import { fileOfJob, jobs } from "../jobs";
import { date, t } from "../texts";
import { named, setWho, who } from "./who";

interface Listed {
  file: string;
  name?: string;
  slots?: { slot: string; frames: string; link: string }[];
  devices?: { name: string; controller: string; link: string }[];
  problems?: string[];
}

interface Listing {
  stations: Listed[];
  runs: { run: string; begun: number; alive: boolean }[];
}

interface DryRun {
  problems: string[];
  timeline: { label: string; begin_text: string; duration_text: string; rule: string }[];
  total_text: string;
}

interface Answers {
  good: boolean;
  rows: { device: string; asked: string; answer: string; milliseconds: string }[];
}

type Mode = "rehearse" | "virtual" | "run";
const MODES: Mode[] = ["rehearse", "virtual", "run"];

function Problems({ all }: { all: string[] }) {
  return <>{all.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}</>;
}

function Timeline({ dry }: { dry: DryRun }) {
  return (
    <details open>
      <summary>{t("station_would_take", { time: dry.total_text, count: dry.timeline.length })}</summary>
      <div class="scroll timeline-table" tabIndex={0} role="region" aria-label={t("station_timeline")}>
        <table class="numbers">
          <thead><tr><th scope="col">{t("station_begins")}</th><th scope="col">{t("duration")}</th><th scope="col">{t("station_segment")}</th></tr></thead>
          <tbody>
            {dry.timeline.map((segment, i) => (
              <tr key={i}><td>{segment.begin_text}</td><td>{segment.duration_text}</td><td class="text">{segment.label} {segment.rule && <small>{segment.rule}</small>}</td></tr>
            ))}
          </tbody>
        </table>
      </div>
    </details>
  );
}

function Begin({ listing, onRun }: { listing: Listing; onRun: (run: string) => void }) {
  const [plans, setPlans] = useState<Plans["plans"]>([]);
  const [plan, setPlan] = useState("");
  const [mode, setMode] = useState<Mode>("rehearse");
  const [file, setFile] = useState("");
  const [units, setUnits] = useState<Record<string, string>>({});
  const [speed, setSpeed] = useState("");
  const [accept, setAccept] = useState("");
  const [dry, setDry] = useState<DryRun | null>(null);
  const [found, setFound] = useState<string[]>([]);
  const [busy, setBusy] = useState(false);
  useEffect(() => {
    get<Plans>("/api/plans").then(({ body }) => setPlans(body.plans.filter((one) => !one.name.startsWith("runs/"))), (error) => setFound(problemsOf(error)));
  }, []);
  useEffect(() => setDry(null), [plan, mode, file, units, accept]);
  const station = listing.stations.find((one) => one.file === file);
  const real = mode !== "rehearse";
  const asked = { mode, plan, station: file, who: who.value, units, speed, accept_expired: accept };
  const act = async (work: () => Promise<void>) => {
    setBusy(true);
    setFound([]);
    try {
      await work();
    } catch (error) {
      setFound(problemsOf(error));
    }
    setBusy(false);
  };
  const check = () => act(async () => setDry(await post<DryRun>("/api/station/dry-run", asked)));
  const begin = () => act(async () => onRun((await post<{ run: string }>("/api/station/start", asked)).run));
  const ready = plan !== "" && (!real || file !== "") && !busy;
  return (
    <section class="panel begin" aria-labelledby="begin-title">
      <h2 id="begin-title">{t("station_begin_title")}</h2>
      <div class="form-row">
        <label>{t("station_plan")}
          <select value={plan} onChange={(event) => setPlan(event.currentTarget.value)}>
            <option value="">–</option>
            {plans.map((one) => <option key={one.name} value={one.name}>{one.title} ({one.name})</option>)}
          </select>
        </label>
        <label>{t("station_how")}
          <select value={mode} onChange={(event) => setMode(event.currentTarget.value as Mode)}>
            {MODES.map((one) => <option key={one} value={one}>{t(`station_mode_${one}`)}</option>)}
          </select>
        </label>
        <label>{t("station")}
          <select value={file} onChange={(event) => setFile(event.currentTarget.value)}>
            <option value="">{real ? "–" : t("station_made")}</option>
            {listing.stations.filter((one) => !one.problems).map((one) => <option key={one.file} value={one.file}>{one.name} ({one.file})</option>)}
          </select>
        </label>
      </div>
      <p class="hint">{t(`station_mode_${mode}_hint`)}</p>
      <div class="form-row">
        {real && (station?.slots ?? []).map(({ slot }) => (
          <label key={slot}>{t("station_serial", { slot })}
            <input value={units[slot] ?? ""} onInput={(event) => setUnits({ ...units, [slot]: event.currentTarget.value })} />
          </label>
        ))}
        {real && <label>{t("station_operator")}<input value={who.value} readOnly={named.value} autocomplete="name" onInput={(event) => setWho(event.currentTarget.value)} /></label>}
        {mode !== "run" && <label>{t("station_speed")}<input value={speed} inputMode="decimal" placeholder={mode === "rehearse" ? t("station_fastest") : "1"} onInput={(event) => setSpeed(event.currentTarget.value)} /></label>}
        {real && <label>{t("station_accept")}<input value={accept} onInput={(event) => setAccept(event.currentTarget.value)} /></label>}
      </div>
      <div class="toolbar">
        <button disabled={!ready} onClick={() => void check()}>{t("station_dry_run")}</button>
        <button class="main" disabled={!ready || (dry !== null && dry.problems.length > 0)} onClick={() => void begin()}>{t("station_begin")}</button>
        {dry && dry.problems.length === 0 && <span class="badge good" role="status">✓ {t("station_no_problem")}</span>}
        {dry && dry.problems.length > 0 && <span class="badge error" role="status">✖ {t("station_refused", { count: dry.problems.length })}</span>}
      </div>
      {dry && <Problems all={dry.problems} />}
      <Problems all={found} />
      {dry && dry.timeline.length > 0 && <Timeline dry={dry} />}
    </section>
  );
}

function Station({ station }: { station: Listed }) {
  const [job, setJob] = useState("");
  const [answers, setAnswers] = useState<Answers | null>(null);
  const [found, setFound] = useState<string[]>([]);
  const work = job === "" ? undefined : jobs.value[job];
  const done = work !== undefined && ["done", "failed"].includes(work.state);
  useEffect(() => {
    if (!done || !work) return;
    if (work.files.includes("check.json")) get<Answers>(fileOfJob(work, "check.json")).then(({ body }) => setAnswers(body), (error) => setFound(problemsOf(error)));
    else setFound(work.problems);
  }, [done]);
  const check = async () => {
    setAnswers(null);
    setFound([]);
    try {
      setJob((await post<{ job: string }>("/api/station/check", { station: station.file })).job);
    } catch (error) {
      setFound(problemsOf(error));
    }
  };
  return (
    <li class="panel">
      <div class="panel-head">
        <h3>{station.name ?? station.file} <small>{station.file}</small></h3>
        {!station.problems && <button disabled={job !== "" && !done} onClick={() => void check()}>{t("station_check")}</button>}
      </div>
      {station.devices && <p class="facts">{station.devices.map((one) => <span key={one.name}>{one.name}: {one.controller}, {one.link}</span>)}</p>}
      {station.slots && <p class="facts">{station.slots.map((one) => <span key={one.slot}>{t("station_slot", { slot: one.slot })}: {one.frames} {one.link}</span>)}</p>}
      <Problems all={station.problems ?? found} />
      {answers && (
        <div class="scroll">
          <table class="numbers" data-testid="answers">
            <thead><tr><th scope="col">{t("station_device")}</th><th scope="col">{t("station_asked")}</th><th scope="col">{t("station_answer")}</th><th scope="col">ms</th></tr></thead>
            <tbody>{answers.rows.map((row, i) => <tr key={i}><th scope="row">{row.device}</th><td class="text">{row.asked}</td><td class="text">{row.answer}</td><td>{row.milliseconds}</td></tr>)}</tbody>
          </table>
        </div>
      )}
    </li>
  );
}

export function StationsPage({ onRun }: { onRun: (run: string) => void }) {
  const [listing, setListing] = useState<Listing | null>(null);
  const [found, setFound] = useState<string[]>([]);
  useEffect(() => {
    let ended = false;
    const look = async () => {
      try {
        const { body } = await get<Listing>("/api/station");
        if (!ended) setListing(body);
        setFound([]);
      } catch (error) {
        if (!ended) setFound(problemsOf(error));
      }
    };
    void look();
    const timer = setInterval(() => { if (!document.hidden) void look(); }, 4000);
    return () => {
      ended = true;
      clearInterval(timer);
    };
  }, []);
  return (
    <section class="station">
      <h1>{t("station")}</h1>
      <Problems all={found} />
      {listing && <Begin listing={listing} onRun={onRun} />}
      {listing && listing.runs.length > 0 && (
        <section>
          <h2>{t("station_runs")}</h2>
          <table class="list" data-testid="runs">
            <thead><tr><th scope="col">{t("station_run")}</th><th scope="col">{t("station_begun")}</th><th scope="col">{t("state")}</th></tr></thead>
            <tbody>
              {listing.runs.map((one) => (
                <tr key={one.run}>
                  <th scope="row"><a href={"/station?run=" + encodeURIComponent(one.run)} onClick={(event) => { if (event.ctrlKey || event.metaKey || event.shiftKey) return; event.preventDefault(); onRun(one.run); }}>{one.run}</a></th>
                  <td>{date(one.begun)}</td>
                  <td>{one.alive ? <span class="badge good">▶ {t("station_goes_on")}</span> : <span class="badge">{t("station_has_ended")}</span>}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </section>
      )}
      <section>
        <h2>{t("station_stations")}</h2>
        {listing && listing.stations.length === 0 && <p class="notice">{t("station_none")}</p>}
        <ul class="stations">{listing?.stations.map((one) => <Station key={one.file} station={one} />)}</ul>
      </section>
    </section>
  );
}
