// One recording: overview, segments, stacked channels, and beside them what is known of the span.
import { useEffect, useRef, useState } from "preact/hooks";
import { batch, useComputed, useSignalEffect } from "@preact/signals";
import { Channel, get, Mark, Problem, problemsOf, Recording } from "../api";
import { Inspector } from "./inspector";
import { jobs, listing } from "../jobs";
import { follow, Live, LOOK_EVERY } from "./live";
import { look, pan, pointed, pressKey, seen, setCursor, whole, zoom } from "./navigate";
import { Drawn, GUTTER, Plot } from "./plot";
import { fileQuery, spanQuery } from "./queries";
import { cursors, hidden, selection, sets, span, units } from "./view";
import { answered, forgetSpan, overview, showOverview, showSpan, viewProblems, views } from "./span_data";
import { count, duration, language, t } from "../texts";
import { Clock, clock, timeText } from "./time_text";

export function shownChannels(recording: Recording): Channel[] {
  return recording.channels.filter((channel) => !hidden.value.includes(channel.name) && channel.samples > 0);
}

function Reading({ file, failed }: { file: string; failed: string[] }) {
  const [text, setText] = useState(sets.value.join("\n"));
  if (failed.length === 0)
    return (
      <p class="notice" role="status">
        {t("recording_prepared", { file })}
      </p>
    );
  const again = (event: Event) => {
    event.preventDefault();
    sets.value = text.split("\n").map((line) => line.trim()).filter(Boolean);
  };
  return (
    <section class="notice problem" role="alert">
      <h2>{t("recording_refused", { file })}</h2>
      {failed.map((problem) => <p key={problem}>{problem}</p>)}
      <form onSubmit={again}>
        <label for="reading">{t("reading_options")}</label>
        <textarea id="reading" rows={3} value={text} placeholder="rate=100" spellcheck={false}
          onInput={(event) => setText(event.currentTarget.value)} />
        <button type="submit">{t("read_again")}</button>
      </form>
    </section>
  );
}

function Segments({ marks, seenSpan, onChoose }: { marks: Mark[]; seenSpan: { from: number; to: number }; onChoose: (mark: Mark) => void }) {
  const width = seenSpan.to - seenSpan.from;
  const inView = marks.filter((mark) => mark.end > seenSpan.from && mark.begin < seenSpan.to).slice(0, 400);
  if (inView.length === 0) return null;
  return (
    <div class="segments" style={{ marginLeft: `${GUTTER}px` }} role="group" aria-label={t("segments")}>
      {inView.map((mark) => {
        const left = Math.max(0, (mark.begin - seenSpan.from) / width), right = Math.min(1, (mark.end - seenSpan.from) / width);
        return (
          <button key={`${mark.run} ${mark.begin}`} title={mark.label} onClick={() => onChoose(mark)}
            style={{ left: `${100 * left}%`, width: `max(2px, ${100 * (right - left)}%)` }}>
            {mark.label || t("no_label")}
          </button>
        );
      })}
    </div>
  );
}

function Row({ recording, channel, drawn, axis }: { recording: Recording; channel: Channel; drawn: Drawn; axis: boolean }) {
  const unit = units.value[channel.name] ?? channel.unit;
  const start = recording.meta.clock_start;
  return (
    <div class="row" data-channel={channel.name}>
      <div class="row-head">
        <strong>{channel.name}</strong>
        <select aria-label={t("unit_of", { channel: channel.name })} value={unit}
          onChange={(event) => (units.value = { ...units.value, [channel.name]: event.currentTarget.value })}>
          {channel.units.map((name) => <option key={name} value={name}>{name}</option>)}
        </select>
        <button class="quiet" aria-label={t("hide_channel", { channel: channel.name })} title={t("hide_channel", { channel: channel.name })}
          onClick={() => (hidden.value = [...hidden.value, channel.name])}>×</button>
      </div>
      <Plot view={views.value[channel.name]} drawn={drawn} height={axis ? 150 : 118} axis={axis}
        label={t("plot_of", { channel: channel.name, unit })}
        axisText={(time, step) => timeText(time, step, start)}
        onSelect={(chosen) => (selection.value = chosen)}
        onPoint={(time, second) => setCursor(recording, second ? "b" : "a", time)}
        onHover={(time) => (pointed.value = time)} />
    </div>
  );
}

function Toolbar({ recording }: { recording: Recording }) {
  const clocks: Clock[] = recording.meta.clock_start ? ["s", "hms", "clock"] : ["s", "hms"];
  const goTo = (event: Event) => {
    event.preventDefault();
    const time = Number(new FormData(event.currentTarget as HTMLFormElement).get("time"));
    const now = seen(recording), half = 0.5 * (now.to - now.from);
    if (Number.isFinite(time)) look(recording, { from: time - half, to: time + half });
  };
  return (
    <div class="toolbar" role="toolbar" aria-label={t("movement")}>
      <button onClick={() => pan(recording, -0.5)} aria-label={t("earlier")} title={`${t("earlier")} (←)`}>←</button>
      <button onClick={() => pan(recording, 0.5)} aria-label={t("later")} title={`${t("later")} (→)`}>→</button>
      <button onClick={() => zoom(recording, 0.5)} aria-label={t("zoom_in")} title={`${t("zoom_in")} (+)`}>+</button>
      <button onClick={() => zoom(recording, 2)} aria-label={t("zoom_out")} title={`${t("zoom_out")} (-)`}>−</button>
      <button onClick={() => (span.value = null)} title={`${t("show_all")} (0)`}>{t("show_all")}</button>
      <button disabled={!selection.value} onClick={() => selection.value && look(recording, selection.value)} title={`${t("zoom_selection")} (z)`}>
        {t("zoom_selection")}
      </button>
      <form class="go-to" onSubmit={goTo}>
        <label for="go-to">{t("go_to")}</label>
        <input id="go-to" name="time" type="number" step="any" size={8} />
        <span>s</span>
      </form>
      <label>
        {t("time_as")}
        <select value={clock.value} onChange={(event) => (clock.value = event.currentTarget.value as Clock)}>
          {clocks.map((kind) => <option key={kind} value={kind}>{t(`time_${kind}`)}</option>)}
        </select>
      </label>
    </div>
  );
}

function Opened({ recording }: { recording: Recording }) {
  const rows = useRef<HTMLDivElement>(null);
  const [pixels, setPixels] = useState(900);
  const all = whole(recording), now = seen(recording);
  const shown = shownChannels(recording);
  const findings = (recording.findings ?? []).filter((finding) => finding.severity !== "info");

  useEffect(() => {
    const element = rows.current!;
    const measure = () => setPixels(Math.max(100, Math.round((element.clientWidth - GUTTER - 12) * devicePixelRatio)));
    const resized = new ResizeObserver(measure);
    resized.observe(element);
    measure();
    const wheel = (event: WheelEvent) => {
      if (!(event.target as HTMLElement).closest(".u-over")) return;
      if (event.ctrlKey || Math.abs(event.deltaX) > Math.abs(event.deltaY) || event.shiftKey) {
        event.preventDefault();
        pan(recording, (event.deltaX || event.deltaY) / 1000);
      } else {
        event.preventDefault();
        zoom(recording, Math.pow(1.0015, event.deltaY), pointed.value ?? undefined);
      }
    };
    element.addEventListener("wheel", wheel, { passive: false });
    const key = (event: KeyboardEvent) => {
      const target = event.target as HTMLElement;
      if (target.closest("input, textarea, select, dialog")) return;
      if (pressKey(recording, event)) event.preventDefault();
    };
    document.addEventListener("keydown", key);
    return () => {
      resized.disconnect();
      element.removeEventListener("wheel", wheel);
      document.removeEventListener("keydown", key);
    };
  }, [recording]);

  useEffect(() => forgetSpan, [recording.tag]);
  const names = shown.map((channel) => channel.name);
  useEffect(() => {
    const query = spanQuery(recording, shown, now.from, now.to);
    query.set("pixels", String(pixels));
    query.set("tag", recording.tag);
    if (recording.live) query.set("last", String(recording.last));
    if (shown.length > 0) showSpan({ query: query.toString(), channels: names });
  });
  const first = shown[0];
  useEffect(() => {
    if (!first) return;
    const query = spanQuery(recording, [first], all.from, all.to);
    query.set("pixels", "1200");
    query.set("tag", recording.tag);
    void showOverview(query.toString());
  }, [recording.tag, recording.live && recording.last, first?.name, first && units.value[first.name]]);

  const drawn: Drawn = { span: now, selection: selection.value, cursors: cursors.value, marks: recording.marks, findings };
  const view = first && views.value[first.name];
  const start = recording.meta.clock_start;
  return (
    <div class="recording" data-answered={answered.value}>
      <header class="recording-head">
        <h1>{recording.name}</h1>
        <p class="facts">
          {recording.instrument && <span>{recording.instrument}</span>}
          <span>{duration(all.to - all.from)}</span>
          <span>{t("channels_count", { count: recording.channels.length })}</span>
          <span>{t("samples_count", { count: count(Math.max(0, ...recording.channels.map((channel) => channel.samples))) })}</span>
          {recording.live ? null : recording.findings === null ? (
            <span>{t(recording.problems ? "cannot_be_checked" : "being_checked")}</span>
          ) : (
            <span class={findings.length > 0 ? "badge warning" : "badge good"}>
              {findings.length > 0 ? `⚠ ${t("findings_count", { count: findings.length })}` : `✓ ${t("no_findings")}`}
            </span>
          )}
        </p>
        {recording.live && <Live recording={recording} />}
      </header>
      <div class="columns">
        <div class="stack" ref={rows}>
          <Toolbar recording={recording} />
          {first && (
            <div class="overview">
              <Plot view={overview.value ?? undefined} height={56} axis={false} label={t("overview")}
                drawn={{ ...drawn, span: all, selection: null, window: now }} axisText={(time, step) => timeText(time, step, start)}
                onSelect={(chosen) => chosen && look(recording, chosen)}
                onPoint={(time) => {
                  const half = 0.5 * (now.to - now.from);
                  look(recording, { from: time - half, to: time + half });
                }} />
            </div>
          )}
          <Segments marks={recording.marks} seenSpan={now} onChoose={(mark) => look(recording, { from: mark.begin, to: mark.end })} />
          {viewProblems.value.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
          {shown.map((channel, i) => (
            <Row key={channel.name} recording={recording} channel={channel} drawn={drawn} axis={i + 1 === shown.length} />
          ))}
          {shown.length === 0 && <p class="notice">{t("all_hidden")}</p>}
          <p class="axis-note">
            <span>{t(clock.value === "s" ? "time_axis" : "time_axis_clock")}</span>
            {view && <span data-testid="what-is-drawn">{view.samples ? t("true_samples") : t("bars_of", { count: count(view.block) })}</span>}
            {shown.some((channel) => views.value[channel.name]?.missing) && <span class="warning">⚠ {t("samples_missing_here")}</span>}
          </p>
          {hidden.value.length > 0 && (
            <p class="hidden-channels">
              {t("hidden_channels")}
              {hidden.value.map((name) => (
                <button key={name} onClick={() => (hidden.value = hidden.value.filter((other) => other !== name))}>{name}</button>
              ))}
            </p>
          )}
        </div>
        <Inspector recording={recording} channels={shown} />
      </div>
    </div>
  );
}

export function RecordingPage({ file }: { file: string }) {
  const [recording, setRecording] = useState<Recording | null>(null);
  const [failed, setFailed] = useState<string[]>([]);
  const latest = useRef<Recording | null>(null);
  const asked = useComputed(() => fileQuery(file).toString());
  const again = (before: Recording, ended: boolean) =>
    setRecording((latest.current = { ...before, live: { ...before.live!, going_on: before.live!.going_on && !ended } }));
  const refreshed = async () => {
    try {
      const { status, body } = await get<Recording>(`/api/recording?${asked.value}&language=${language.value}`);
      setFailed([]);
      const found = status === 200 ? body : null;
      if (found?.live) batch(() => follow(latest.current, found));
      setRecording((latest.current = found));
    } catch (error) {
      const before = latest.current;
      // Sealed and removed; or the server cannot be reached, and is asked again.
      if (before?.live && before.name === file) return again(before, (error as Problem).status === 404);
      setRecording((latest.current = null));
      setFailed(problemsOf(error));
    }
  };
  // Asked again when a job that prepares a recording has gone on or ended.
  const state = useComputed(() => {
    const preparing = Object.values(jobs.value).filter((job) => job.kind === "prepare");
    return preparing.map((job) => job.id + job.state).join() + listing.value;
  });
  // A view that is refused: the file may have been replaced, or removed.
  useSignalEffect(() => {
    if (viewProblems.value.length > 0 && latest.current && !latest.current.live) void refreshed();
  });
  // A run that was stopped may be carried on.
  useEffect(() => {
    if (!recording?.live) return;
    const timer = setTimeout(refreshed, recording.live.behind ? 0 : recording.live.going_on ? LOOK_EVERY : 4 * LOOK_EVERY);
    return () => clearTimeout(timer);
  }, [recording]);
  const done = recording !== null && (recording.live !== undefined || recording.findings !== null || recording.problems !== undefined);
  useSignalEffect(() => {
    void asked.value;
    void state.value;
    if (!done || failed.length > 0) void refreshed();
  });
  useEffect(() => {
    setRecording((latest.current = null));
    void refreshed();
  }, [asked.value]);
  const spoken = useRef(language.value);
  useEffect(() => {
    if (spoken.current === language.value) return;
    spoken.current = language.value;
    void refreshed(); // the messages of findings
  }, [language.value]);
  // While the view is there and the checks are not, the view appears as soon as it can.
  useEffect(() => {
    if (done || failed.length > 0) return;
    const timer = setInterval(refreshed, 700);
    return () => clearInterval(timer);
  }, [done, failed.length, asked.value]);
  if (!recording) return <Reading file={file} failed={failed} />;
  return <Opened recording={recording} />;
}
