// What is known of the span: statistics, cursors, findings, noise, results.
import { useEffect, useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import { Channel, Finding, get, post, Plans, problemsOf, Recording, StatisticsRow, ValuesRow } from "../api";
import { fileOfJob, jobs } from "../jobs";
import { seen, showPlace } from "./navigate";
import { cursors, selection, sets } from "./view";
import { spanQuery } from "./queries";
import { count, language, t } from "../texts";
import { timeText } from "./time_text";

/// Asks when the address has been the same for a moment, and shows the latest answer.
function useAnswer<Answer>(address: string | null): { answer: Answer | null; problems: string[] } {
  const [answer, setAnswer] = useState<Answer | null>(null);
  const [problems, setProblems] = useState<string[]>([]);
  useEffect(() => {
    if (address === null) {
      setAnswer(null);
      return;
    }
    const control = new AbortController();
    const timer = setTimeout(async () => {
      try {
        const { body } = await get<Answer>(address, control.signal);
        setAnswer(body);
        setProblems([]);
      } catch (error) {
        if ((error as Error).name !== "AbortError") setProblems(problemsOf(error));
      }
    }, 60);
    return () => {
      clearTimeout(timer);
      control.abort();
    };
  }, [address]);
  return { answer, problems };
}

function Section({ title, name, children }: { title: string; name: string; children: ComponentChildren }) {
  return (
    <details class="section" open data-section={name}>
      <summary><h2>{title}</h2></summary>
      {children}
    </details>
  );
}

function Problems({ problems }: { problems: string[] }) {
  return <>{problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}</>;
}

function Statistics({ recording, channels }: { recording: Recording; channels: Channel[] }) {
  const of = selection.value ?? seen(recording);
  const address = channels.length > 0 ? "/api/recording/statistics?" + spanQuery(recording, channels, of.from, of.to) : null;
  const { answer, problems } = useAnswer<{ rows: StatisticsRow[] }>(address);
  const start = recording.meta.clock_start, step = (of.to - of.from) / 1000;
  return (
    <Section name="span" title={t(selection.value ? "statistics_of_selection" : "statistics_of_view")}>
      <p class="span-text">
        {timeText(of.from, step, start)} … {timeText(of.to, step, start)} s
        {selection.value && <button class="quiet" onClick={() => (selection.value = null)}>{t("clear_selection")}</button>}
      </p>
      <Problems problems={problems} />
      {answer && (
        <div class="scroll" tabIndex={0} role="region" aria-label={t("statistics_of_view")}>
          <table class="numbers" data-testid="statistics">
            <thead>
              <tr>
                <th scope="col">{t("channel")}</th>
                {["mean", "sd", "minimum", "maximum", "slope", "samples", "missing"].map((name) => <th scope="col" key={name}>{t(name)}</th>)}
              </tr>
            </thead>
            <tbody>
              {answer.rows.map((row) => (
                <tr key={row.channel}>
                  <th scope="row">{row.channel} <small>{row.unit}</small></th>
                  <td>{row.text.mean}</td>
                  <td>{row.text.sd}</td>
                  <td>{row.text.minimum}</td>
                  <td>{row.text.maximum}</td>
                  <td>{row.text.slope} <small>{row.slope_unit}</small></td>
                  <td>{count(row.samples)}</td>
                  <td class={row.missing > 0 ? "warning" : ""}>{count(row.missing)}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
      {channels.length > 0 && (
        <p>
          <a class="button" download href={"/api/recording/csv?" + spanQuery(recording, channels, of.from, of.to)}>{t("save_csv")}</a>
        </p>
      )}
    </Section>
  );
}

function Cursors({ recording, channels }: { recording: Recording; channels: Channel[] }) {
  const { a, b } = cursors.value;
  const times = [a, b].filter((time): time is number => time !== undefined);
  const query = spanQuery(recording, channels, 0, 0);
  for (const time of times) query.append("at", String(time));
  const { answer, problems } = useAnswer<{ rows: ValuesRow[] }>(
    times.length > 0 && channels.length > 0 ? "/api/recording/values?" + query : null,
  );
  const letters = [a !== undefined && "A", b !== undefined && "B"].filter(Boolean) as string[];
  if (times.length === 0)
    return (
      <Section name="cursors" title={t("cursors")}>
        <p class="hint">{t("cursors_hint")}</p>
      </Section>
    );
  const both = times.length === 2;
  return (
    <Section name="cursors" title={t("cursors")}>
      <Problems problems={problems} />
      {answer && (
        <div class="scroll" tabIndex={0} role="region" aria-label={t("cursors")}>
          <table class="numbers" data-testid="cursors">
            <thead>
              <tr>
                <th scope="col">{t("channel")}</th>
                {letters.map((letter) => <th scope="col" key={letter}>{letter}</th>)}
                {both && <th scope="col">B − A</th>}
              </tr>
            </thead>
            <tbody>
              {answer.rows[0] && (
                <tr>
                  <th scope="row">{t("time")} <small>s</small></th>
                  {answer.rows[0].values.map((value) => <td key={value.time}>{Number(value.time.toPrecision(10))}</td>)}
                  {both && <td>{Number((answer.rows[0].time_difference ?? 0).toPrecision(9))}</td>}
                </tr>
              )}
              {answer.rows.map((row) => (
                <tr key={row.channel}>
                  <th scope="row">{row.channel} <small>{row.unit}</small></th>
                  {row.values.map((value, i) => <td key={i}>{value.text || t("missing_value")}</td>)}
                  {both && <td>{row.difference_text}</td>}
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </Section>
  );
}

const SIGN = { info: "ⓘ", warning: "⚠", error: "✖" };

function Findings({ recording }: { recording: Recording }) {
  const one = (finding: Finding, i: number) => {
    const time = (finding.worst ?? finding.first)?.time;
    return (
      <li key={i} class={finding.severity}>
        <span class="sign">{SIGN[finding.severity]} {t(`severity_${finding.severity}`)}</span>
        <span> {finding.where && <strong>{finding.where}: </strong>}{finding.message}</span>
        {time !== undefined && (
          <button class="quiet" onClick={() => showPlace(recording, time)}>{t("show_place", { time: timeText(time, 0.001) })}</button>
        )}
      </li>
    );
  };
  return (
    <Section name="findings" title={t("findings")}>
      {recording.findings === null && !recording.problems && <p role="status">{t("being_checked")}</p>}
      {recording.problems && <Problems problems={recording.problems} />}
      {recording.findings?.length === 0 && <p>✓ {t("no_findings")}</p>}
      <ul class="findings" data-testid="findings">{recording.findings?.map(one)}</ul>
    </Section>
  );
}

function Noise({ recording, channels }: { recording: Recording; channels: Channel[] }) {
  const [started, setStarted] = useState<string | null>(null);
  const [problems, setProblems] = useState<string[]>([]);
  const fitting = channels.filter((channel) => channel.kind === "angular_rate" || channel.kind === "specific_force");
  const [chosen, setChosen] = useState("");
  const names = chosen ? [chosen] : fitting.length > 0 ? fitting.map((channel) => channel.name) : channels.slice(0, 1).map((channel) => channel.name);
  const job = started ? jobs.value[started] : undefined;
  const begin = async () => {
    const of = selection.value ?? seen(recording);
    try {
      const { job: id } = await post<{ job: string }>("/api/jobs/noise", {
        file: recording.name, from: of.from, to: of.to, channels: names, set: sets.value, language: language.value,
      });
      setStarted(id);
      setProblems([]);
    } catch (error) {
      setProblems(problemsOf(error));
    }
  };
  return (
    <Section name="noise" title={t("noise")}>
      <p class="hint">{t("noise_hint")}</p>
      <p class="form-row">
        <label>
          {t("channel")}
          <select value={chosen} onChange={(event) => setChosen(event.currentTarget.value)}>
            {fitting.length > 1 && <option value="">{t("all_of_them")}</option>}
            {channels.map((channel) => <option key={channel.name} value={channel.name}>{channel.name}</option>)}
          </select>
        </label>
        <button disabled={channels.length === 0} onClick={begin}>{t("noise_begin")}</button>
      </p>
      <Problems problems={problems} />
      {job && job.state === "failed" && <Problems problems={job.problems} />}
      {job && (job.state === "waiting" || job.state === "running") && <p role="status">{t("job_goes_on")}</p>}
      {job?.state === "done" && (
        <div data-testid="noise-figures">
          {job.files.filter((name) => name.endsWith(".svg")).map((name) => (
            <img key={name} class="figure" src={fileOfJob(job, name)} alt={t("noise_figure")} />
          ))}
          <p><a href={fileOfJob(job, "report.html")} target="_blank" rel="noopener">{t("open_report")}</a></p>
        </div>
      )}
    </Section>
  );
}

function Identify({ recording }: { recording: Recording }) {
  const { answer, problems: failed } = useAnswer<Plans>("/api/plans");
  const [what, setWhat] = useState("");
  const [started, setStarted] = useState<string | null>(null);
  const [problems, setProblems] = useState<string[]>([]);
  const job = started ? jobs.value[started] : undefined;
  const plans = answer?.plans.filter((plan) => plan.method !== "") ?? [];
  const choices = answer ? [...plans.map((plan) => `plan:${plan.name}`), ...answer.methods.map((method) => `method:${method.name}`)] : [];
  const chosen = what || choices[0] || "";
  const begin = async () => {
    const at = chosen.indexOf(":");
    try {
      const { job: id } = await post<{ job: string }>("/api/jobs/identify", {
        recordings: [recording.name], [chosen.slice(0, at)]: chosen.slice(at + 1), set: sets.value, language: language.value,
      });
      setStarted(id);
      setProblems([]);
    } catch (error) {
      setProblems(problemsOf(error));
    }
  };
  return (
    <Section name="identify" title={t("identify")}>
      <p class="form-row">
        <label>
          {t("plan_or_method")}
          <select value={chosen} onChange={(event) => setWhat(event.currentTarget.value)}>
            {plans.length > 0 && (
              <optgroup label={t("plans")}>
                {plans.map((plan) => <option key={plan.name} value={`plan:${plan.name}`}>{plan.title} ({plan.name})</option>)}
              </optgroup>
            )}
            <optgroup label={t("methods")}>
              {answer?.methods.map((method) => <option key={method.name} value={`method:${method.name}`}>{method.name}</option>)}
            </optgroup>
          </select>
        </label>
        <button disabled={!chosen} onClick={begin}>{t("identify_begin")}</button>
      </p>
      <Problems problems={[...failed, ...problems, ...(job?.state === "failed" ? job.problems : [])]} />
      {job && (job.state === "waiting" || job.state === "running") && <p role="status">{t("job_goes_on")}</p>}
      {job?.state === "done" && (
        <p data-testid="identified">
          ✓ <a href={fileOfJob(job, "report.html")} target="_blank" rel="noopener">{t("open_report")}</a>{" "}
          <a href={`/results?file=${encodeURIComponent(`jobs/${job.id}/result.json`)}`}>{t("results_show")}</a>
        </p>
      )}
    </Section>
  );
}

function About({ recording }: { recording: Recording }) {
  const rows: [string, string][] = [
    ["SHA-256", recording.sha256],
    ...recording.channels.map((channel): [string, string] => [channel.name, `${Number(channel.rate.toPrecision(6))} Hz, ${t(channel.stamped ? "stamped" : "even")}`]),
    ...Object.entries(recording.meta),
  ];
  return (
    <Section name="file" title={t("about_file")}>
      <dl class="about">
        {rows.filter(([, value]) => value).map(([name, value]) => (
          <div key={name}><dt>{name}</dt><dd>{value}</dd></div>
        ))}
      </dl>
    </Section>
  );
}

export function Inspector({ recording, channels }: { recording: Recording; channels: Channel[] }) {
  return (
    <aside class="inspector" aria-label={t("inspector")}>
      <Statistics recording={recording} channels={channels} />
      <Cursors recording={recording} channels={channels} />
      {!recording.live && <Findings recording={recording} />}
      {!recording.live && <Noise recording={recording} channels={channels} />}
      {!recording.live && <Identify recording={recording} />}
      <About recording={recording} />
    </aside>
  );
}
