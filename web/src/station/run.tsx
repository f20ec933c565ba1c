// One run: is it running well, and what must I do now?
import { useEffect, useState } from "preact/hooks";
import type { ChannelView } from "../api";
import { post, problemsOf } from "../api";
import { Plot } from "../recordings/plot";
import { duration, t } from "../texts";
import { Convergence, predictedOf, usePredicted } from "./convergence";
import { again, Bar, Happened, lostSince, Point, problems, Progress, Prompt, run, Run, View } from "./run_data";
import { named, setWho, who } from "./who";

const ALARM = ["stopping", "aborting", "faulted"];
const LOUD = ["faulted", "interrupted"];
const WAITING = ["holding", "pausing", "paused"];
const SIGN: Record<Progress["state"], string> = { done: "✓", skipped: "–", now: "▶", next: "○" };

async function order(name: string, body: Record<string, unknown>, say: (found: string[]) => void): Promise<void> {
  try {
    await post("/api/station/order", { run: name, who: who.value, ...body });
    say([]);
  } catch (error) {
    say(problemsOf(error));
  }
}

/// The word of the state: of the run while it goes on, else how it ended.
function stateOf(now: Run): { text: string; kind: string } {
  if (now.ending !== "")
    return { text: t(`station_ending_${now.ending}`), kind: now.ending === "complete" ? "good" : LOUD.includes(now.ending) ? "alarm" : "waiting" };
  const phase = now.view?.phase ?? "preparing";
  const kind = ALARM.includes(phase) ? "alarm" : WAITING.includes(phase) || now.view?.prompt ? "waiting" : "running";
  return { text: t(`station_phase_${phase}`), kind };
}

/// What is always on the screen: the state, and the way to stop.
function RunBar({ name, now }: { name: string; now: Run }) {
  const [found, setFound] = useState<string[]>([]);
  const state = stateOf(now);
  const view = now.view;
  const active = now.alive && now.ending === "";
  const stopping = view !== null && ALARM.includes(view.phase);
  useEffect(() => {
    const before = document.title;
    document.title = `${state.kind === "alarm" ? "⚠ " : ""}${state.text} · ${before}`;
    return () => void (document.title = before);
  }, [state.text]);
  return (
    <section class={`run-bar ${state.kind}`} aria-label={t("station_controls")}>
      <p class="run-state" role={state.kind === "alarm" ? "alert" : "status"} data-testid="state">{state.kind === "alarm" ? "⚠ " : ""}{state.text}</p>
      {active && view && (
        <p class="run-left">
          {view.label} <span class="number">{t("station_left", { time: view.left_text })}</span>
          {view.wall_left !== null && now.facts.rig !== "" && <span> ({duration(view.wall_left)})</span>}
        </p>
      )}
      {active && (
        <div class="run-buttons">
          {view && ["paused", "pausing"].includes(view.phase)
            ? <button disabled={who.value === ""} onClick={() => void order(name, { order: "resume" }, setFound)}>{t("station_resume")}</button>
            : <button disabled={who.value === "" || stopping} onClick={() => void order(name, { order: "pause" }, setFound)}>{t("station_pause")}</button>}
          <button class="stop" onClick={() => void order(name, { order: "stop" }, setFound)}>{t("station_stop")}</button>
        </div>
      )}
      {found.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
    </section>
  );
}

function Who() {
  return (
    <label class="who">
      {t("station_your_name")}
      <input value={who.value} readOnly={named.value} autocomplete="name" onInput={(event) => setWho(event.currentTarget.value)} />
    </label>
  );
}

function Question({ name, prompt }: { name: string; prompt: Prompt }) {
  const [found, setFound] = useState<string[]>([]);
  return (
    <section class="question" aria-labelledby="question">
      <h2 id="question">{t("station_question")}</h2>
      <p class="question-text" role="alert">{prompt.text}</p>
      <div class="run-buttons">
        {prompt.choices.map((choice) => (
          <button key={choice} class={choice === prompt.standard ? "main" : ""} disabled={who.value === ""}
            onClick={() => void order(name, { order: "answer", prompt: prompt.id, choice }, setFound)}>
            {wordOf("choice", choice)}
          </button>
        ))}
      </div>
      {who.value === "" && <p class="hint">{t("station_name_needed")}</p>}
      {found.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
    </section>
  );
}

function Timeline({ now }: { now: Run }) {
  const progress = now.view?.segments ?? now.segments ?? [];
  return (
    <section class="panel">
      <h2>{t("station_timeline")}</h2>
      <ol class="timeline" tabIndex={0} aria-label={t("station_timeline")}>
        {now.facts.segments.map((segment, i) => {
          const { state, attempts } = progress[i] ?? { state: "next" as const, attempts: 0 };
          const active = state === "now" && now.view !== null;
          return (
            <li key={i} class={state} style={{ flexGrow: segment.duration }} aria-current={state === "now" ? "step" : undefined}
              title={`${segment.label}, ${segment.duration_text}${segment.rule ? `, ${segment.rule}` : ""}`}>
              <span class="sign">{SIGN[state]}</span> {segment.label}
              <span class="visually-hidden">, {t(`station_segment_${state}`)}</span>
              {attempts > 1 && <small> {t("station_attempt", { count: attempts })}</small>}
              {active && <progress value={now.view!.recorded} max={segment.duration} aria-label={segment.label} />}
            </li>
          );
        })}
      </ol>
    </section>
  );
}

function Axes({ view }: { view: View }) {
  if (view.axes.length === 0) return null;
  return (
    <section class="panel scroll">
      <h2>{t("station_axes")}</h2>
      <table class="numbers" data-testid="axes">
        <thead><tr>{["axis", "demanded", "actual", "rate"].map((key) => <th scope="col" key={key}>{t(`station_${key}`)}</th>)}</tr></thead>
        <tbody>
          {view.axes.map((axis) => (
            <tr key={axis.name}><th scope="row">{axis.name}</th><td>{axis.demanded}</td><td>{axis.position}</td><td>{axis.rate}</td></tr>
          ))}
        </tbody>
      </table>
    </section>
  );
}

const TICK = (time: number) => String(Number(time.toPrecision(9)));

function drawn(times: number[], low: (number | null)[], high: (number | null)[]): ChannelView {
  return { samples: true, block: 1, times: Float64Array.from(times), low, high, missing: false };
}

function Curve({ view, label }: { view: ChannelView; label: string }) {
  const first = view.times[0] ?? 0, last = view.times[view.times.length - 1] ?? 1;
  const span = { from: first, to: last > first ? last : first + 1 };
  return (
    <Plot view={view} drawn={{ span, selection: null, cursors: {}, marks: [], findings: [] }} label={label} height={110} axis
      axisText={TICK} onSelect={() => undefined} />
  );
}

function Channels({ name, now, view }: { name: string; now: Run; view: View }) {
  const [whole, setWhole] = useState(false);
  const bars: Bar[] = (whole ? now.curves?.whole : now.curves?.recent) ?? [];
  const times = bars.map((bar) => bar[0]);
  return (
    <section class="panel">
      <div class="panel-head">
        <h2>{t("channels")}</h2>
        {now.alive && <a href={"/?file=" + encodeURIComponent(`${name}/live.samples`)}>{t("live_look")}</a>}
        <div role="group" aria-label={t("station_span")}>
          <button aria-pressed={!whole} onClick={() => setWhole(false)}>{t("station_recent")}</button>
          <button aria-pressed={whole} onClick={() => setWhole(true)}>{t("station_whole")}</button>
        </div>
      </div>
      {view.channels.map((channel, i) => (
        <div class="live-row" key={`${channel.slot}.${channel.name}`}>
          <p class="live-head">
            <strong>{Object.keys(now.facts.units).length > 1 ? `${channel.slot}.` : ""}{channel.name}</strong>
            <span>{channel.mean} {channel.unit}</span>
            <small>{t("station_noise", { sd: channel.sd, allan: channel.allan })}</small>
          </p>
          <Curve label={t("plot_of", { channel: channel.name, unit: channel.unit })}
            view={drawn(times, bars.map((bar) => bar[1][i] ?? null), bars.map((bar) => bar[2][i] ?? null))} />
        </div>
      ))}
      <p class="hint">{t("time_axis")}</p>
    </section>
  );
}

function Estimates({ name, now, view }: { name: string; now: Run; view: View }) {
  const [chosen, setChosen] = useState(0);
  const predicted = usePredicted(name);
  if (view.estimates.length === 0) return null;
  const curve = now.estimates[chosen] ?? now.estimates[0];
  const points: Point[] = curve?.points ?? [];
  return (
    <section class="panel">
      <h2>{t("station_estimate")}</h2>
      <div class="scroll">
        <table class="numbers" data-testid="estimates">
          <thead><tr><th scope="col">{t("station_parameter")}</th><th scope="col">{t("station_value")}</th><th scope="col">{t("station_sd_predicted")}</th><th scope="col">{t("station_unit")}</th></tr></thead>
          <tbody>
            {view.estimates.map((one, i) => (
              <tr key={`${one.slot}.${one.name}`}>
                <th scope="row"><button class="quiet" aria-pressed={i === chosen} onClick={() => setChosen(i)}>{Object.keys(now.facts.units).length > 1 ? `${one.slot}.` : ""}{one.name}</button></th>
                <td>{one.text}</td><td>{predictedOf(predicted, one.name, one.unit)?.text}</td><td>{one.unit}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      {curve && points.length > 1 && (
        <Curve label={t("station_converging", { name: curve.name, unit: curve.unit })}
          view={drawn(points.map((one) => one[0]), points.map((one) => one[1]), points.map((one) => one[2]))} />
      )}
      {curve && predicted && <Convergence name={curve.name} unit={curve.unit} points={points} predicted={predicted} />}
    </section>
  );
}

/// A word of the program, a choice or a kind of event, in the language of the page where that has one.
function wordOf(what: string, word: string): string {
  const key = `station_${what}_${word}`, text = t(key);
  return text === key ? word : text;
}

function textOf(event: Happened, now: Run): string {
  if (event.kind !== "journal") return event.text;
  const segment = event.segment === undefined ? "" : now.facts.segments[event.segment]?.label ?? event.text;
  const step = t(`station_step_${event.step ?? "begins"}`, { segment, attempt: event.attempt ?? 1 });
  return [step, event.ending && event.step === "ends" ? wordOf("ending", event.ending) : "", event.reason ?? ""].filter(Boolean).join(": ");
}

function Log({ now }: { now: Run }) {
  const [all, setAll] = useState(false);
  const shown = now.events.filter((event) => all || !event.everyday).slice(-300).reverse();
  return (
    <section class="panel">
      <div class="panel-head">
        <h2>{t("station_log")}</h2>
        <label><input type="checkbox" checked={all} onChange={(event) => setAll(event.currentTarget.checked)} /> {t("station_log_all")}</label>
      </div>
      <ol class="log" data-testid="log" tabIndex={0} aria-label={t("station_log")}>
        {shown.map((event, i) => (
          <li key={event.id > 0 ? event.id : `x${i}`} data-id={event.id} class={`kind-${event.kind.replace(/\W/g, "-")}`}>
            <span class="number">{event.time_text}</span> <b>{wordOf("kind", event.kind)}</b> <span>{textOf(event, now)}</span>
          </li>
        ))}
      </ol>
    </section>
  );
}

/// What is known beside, and what can be done with a run that has ended.
function Ended({ name, now }: { name: string; now: Run }) {
  const [found, setFound] = useState<string[]>([]);
  const [speed, setSpeed] = useState("1");
  const resume = async () => {
    try {
      await post("/api/station/resume", { run: name, who: who.value, ...(now.facts.rig === "virtual" && { speed }) });
      setFound([]);
      again();
    } catch (error) {
      setFound(problemsOf(error));
    }
  };
  const may = !now.alive && now.ending !== "complete" && now.facts.rig !== "rehearsed";
  return (
    <section class="panel">
      {now.ending_text && <p>{now.ending_text}</p>}
      {now.alive && <p role="status">{t("station_sealing")}</p>}
      {now.recordings.map((file) => <p key={file}><a href={"/?file=" + encodeURIComponent(file)}>{t("station_open_recording", { file })}</a></p>)}
      {may && (
        <div class="form-row">
          {now.facts.rig === "virtual" && <label>{t("station_speed")}<input value={speed} inputMode="decimal" onInput={(event) => setSpeed(event.currentTarget.value)} /></label>}
          <button class="main" disabled={who.value === ""} onClick={() => void resume()}>{t("station_carry_on")}</button>
          <span class="hint">{t("station_carry_on_hint")}</span>
        </div>
      )}
      {found.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
    </section>
  );
}

export function RunPage({ name }: { name: string }) {
  const now = run.value;
  if (!now) return <section class="station"><h1>{name}</h1>{problems.value.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}</section>;
  const view = now.view;
  const lost = lostSince.value;
  return (
    <section class={lost === null ? "station run" : "station run stale"}>
      <RunBar name={name} now={now} />
      <header class="list-head">
        <h1>{now.facts.title || name}</h1>
        <Who />
      </header>
      {lost !== null && <p class="notice warning" role="alert">{t("station_lost", { time: new Date(lost).toLocaleTimeString() })}</p>}
      <p class="facts">
        {now.facts.rig !== "" && <span class="badge warning">{t(now.facts.rig === "virtual" ? "station_virtual" : "station_rehearsed")}</span>}
        <span>{now.facts.station}</span>
        {Object.entries(now.facts.units).map(([slot, serial]) => <span key={slot}>{slot}: {serial}</span>)}
        <span>{t("station_operator")}: {now.facts.operator}</span>
        <span>{name}</span>
      </p>
      {view?.prompt && now.ending === "" && <Question key={view.prompt.id} name={name} prompt={view.prompt} />}
      {now.ending !== "" && <Ended name={name} now={now} />}
      <Timeline now={now} />
      {view && (
        <p class="facts" data-testid="recorder">
          <span>{t("station_time")} {view.time_text}</span>
          <span>{t("station_on_disk", { time: view.acknowledged_text })}</span>
          <span class={view.lost + view.damaged > 0 ? "warning" : ""}>{t("station_frames", { frames: view.frames, lost: view.lost, damaged: view.damaged })}</span>
        </p>
      )}
      {view && (
        <div class="station-columns">
          <div><Axes view={view} /><Estimates name={name} now={now} view={view} /></div>
          <Channels name={name} now={now} view={view} />
        </div>
      )}
      <Log now={now} />
    </section>
  );
}
