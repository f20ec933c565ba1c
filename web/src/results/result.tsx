// One result: does it pass, how sure is it, and what limits it.
import type { ComponentChildren } from "preact";
import { useMemo } from "preact/hooks";
import { inLanguage } from "../api";
import { count, language, t } from "../texts";
import { Figure, ListedResult, ParameterRow, Result, Split, useAnswer } from "./answers";
import { Budget } from "./budget";
import { Compensate } from "./compensate";
import { Correlation } from "./correlation";
import { FigureView } from "./figure";
import { figure, hidden, openResults, RESULTS, showFigure, units, zoom } from "./view";

export function Problems({ problems }: { problems: string[] }) {
  return <>{problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}</>;
}

function Section({ title, name, children }: { title: string; name: string; children: ComponentChildren }) {
  return (
    <section class="part" data-part={name}>
      <h2>{title}</h2>
      {children}
    </section>
  );
}

const SIGN = { pass: "✓", fail: "✖", undecided: "?" };
const BADGE = { pass: "good", fail: "error", undecided: "warning" };

function Verdicts({ result }: { result: Result }) {
  // What failed stands first.
  const order = ["fail", "undecided", "pass"];
  const all = [...result.verdicts].sort((a, b) => order.indexOf(a.outcome) - order.indexOf(b.outcome));
  return (
    <Section title={t("results_verdicts")} name="verdicts">
      {all.length === 0 && <p class="hint">{t("results_no_limits")}</p>}
      {all.length > 0 && (
        <div class="scroll" tabIndex={0} role="region" aria-label={t("results_verdicts")}>
          <table class="plain-table">
            <thead><tr>{["results_verdict", "results_parameter", "results_limit", "results_measured", "results_sd"].map((key) => <th scope="col" key={key}>{t(key)}</th>)}</tr></thead>
            <tbody>
              {all.map((one, i) => (
                <tr key={i}>
                  <td><span class={`badge ${BADGE[one.outcome]}`}>{SIGN[one.outcome]} {t(`results_is_${one.outcome}`)}</span></td>
                  <th scope="row">{one.readable}</th>
                  <td>{one.limit}</td>
                  <td>{one.measured}</td>
                  <td>{one.sd}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </Section>
  );
}

/// Widths behind and before the point, so that the points of a column stand below each other.
function widest(rows: ParameterRow[], of: (row: ParameterRow) => string): string {
  return `${Math.max(0, ...rows.map((row) => of(row).length))}ch`;
}

function Aligned({ number, before, after }: { number: Split; before?: string; after?: string }) {
  return (
    <>
      <span class="before" style={{ minWidth: before }}>{number[0].replace("-", "−")}</span>
      <span class="after" style={{ minWidth: after }}>{number[1]}</span>
    </>
  );
}

function UnitChoice({ row }: { row: ParameterRow }) {
  if (row.units.length < 2) return <>{row.unit === "1" ? "" : row.unit}</>;
  return (
    <select aria-label={t("results_unit_of", { name: row.readable })} value={row.unit}
      onChange={(event) => (units.value = { ...units.value, [row.name]: event.currentTarget.value })}>
      {row.units.map((unit) => <option key={unit} value={unit}>{unit}</option>)}
    </select>
  );
}

function Parameters({ rows, title, name, choose }: { rows: ParameterRow[]; title: string; name: string; choose: boolean }) {
  const widths = {
    value: widest(rows, (row) => row.value[1]), sdBefore: widest(rows, (row) => row.sd[0]), sd: widest(rows, (row) => row.sd[1]),
    lower: widest(rows, (row) => `${row.lower[1]},`), upperBefore: widest(rows, (row) => row.upper[0]), upper: widest(rows, (row) => row.upper[1]),
  };
  return (
    <Section title={title} name={name}>
      <div class="scroll" tabIndex={0} role="region" aria-label={title}>
        <table class="parameters" data-testid={name}>
          <thead>
            <tr>
              {["results_parameter", "results_value", "results_sd"].map((key) => <th scope="col" key={key}>{t(key)}</th>)}
              <th scope="col"><span class="unseen">{t("results_power")}</span></th>
              <th scope="col">{t("results_unit_short")}</th>
              <th scope="col">{t("results_interval")}</th>
              <th scope="col"><abbr title={t("results_freedom")}>ν</abbr></th>
            </tr>
          </thead>
          <tbody>
            {rows.map((row) => (
              <tr key={row.name}>
                <th scope="row">
                  {row.readable} {row.readable !== row.name && <code>{row.name}</code>}
                  {row.description && <small>{row.description}</small>}
                </th>
                <td class="value"><Aligned number={row.value} after={widths.value} /></td>
                <td class="sd"><Aligned number={row.sd} before={widths.sdBefore} after={widths.sd} /></td>
                <td class="power">{row.power}</td>
                <td class="in">{choose ? <UnitChoice row={row} /> : row.unit === "1" ? "" : row.unit}</td>
                <td class="interval">
                  {row.lower[0] === "" ? "–" : (
                    <>[<Aligned number={[row.lower[0], `${row.lower[1]},`]} after={widths.lower} /> <Aligned number={row.upper} before={widths.upperBefore} />]</>
                  )}
                </td>
                <td class="freedom">{row.degrees_of_freedom}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <p class="hint">{t("results_sd_hint")}</p>
    </Section>
  );
}

function Figures({ file, result }: { file: string; result: Result }) {
  const { answer, problems } = useAnswer<Figure[]>(`/api/result/figures?file=${encodeURIComponent(file)}`);
  const number = Math.min(figure.value, Math.max(1, result.figures.length));
  const shown = answer?.[number - 1];
  const of = (kind: string) => inLanguage(`/api/result/figure.${kind}?file=${encodeURIComponent(file)}&figure=${number}`);
  const hide = (series: number) =>
    (hidden.value = hidden.value.includes(series) ? hidden.value.filter((one) => one !== series) : [...hidden.value, series]);
  if (result.figures.length === 0) return null;
  return (
    <Section title={t("results_figures")} name="figures">
      <Problems problems={problems} />
      <p class="form-row">
        <label>
          {t("results_figure")}
          <select value={number} onChange={(event) => showFigure(Number(event.currentTarget.value))}>
            {result.figures.map((name, i) => <option key={i} value={i + 1}>{i + 1}. {name}</option>)}
          </select>
        </label>
        <a class="button" href={of("svg")} download={`figure-${number}.svg`}>SVG</a>
        <a class="button" href={of("csv")} download={`figure-${number}.csv`}>CSV</a>
      </p>
      {shown && <FigureView figure={shown} hidden={hidden.value} zoom={zoom.value} drawing={of("svg")} onHide={hide} onZoom={(to) => (zoom.value = to)} />}
    </Section>
  );
}

const FINDING = { info: "ⓘ", warning: "⚠", error: "✖" };

export function Findings({ findings }: { findings: Result["findings"] }) {
  if (findings.length === 0) return null;
  const order = ["error", "warning", "info"];
  const sorted = [...findings].sort((a, b) => order.indexOf(a.severity) - order.indexOf(b.severity));
  return (
    <Section title={t("findings")} name="findings">
      <ul class="findings">
        {sorted.map((finding, i) => (
          <li key={i} class={finding.severity}>
            <span class="sign">{FINDING[finding.severity]} {t(`severity_${finding.severity}`)}</span>
            <span> {finding.where && <strong>{finding.where}: </strong>}{finding.message}</span>
          </li>
        ))}
      </ul>
    </Section>
  );
}

function Provenance({ result }: { result: Result }) {
  const { inputs, plans, settings, command_line: given, seed } = result.provenance;
  const hashes = [...plans, ...inputs];
  return (
    <Section title={t("results_provenance")} name="provenance">
      <dl class="about">
        {hashes.map((one) => <div key={one.file}><dt>{one.file}</dt><dd class="hash">{one.sha256}</dd></div>)}
        {Object.entries({ ...settings, ...given }).map(([key, value]) => <div key={key}><dt>{key}</dt><dd>{value}</dd></div>)}
        {seed !== null && <div><dt>{t("results_seed")}</dt><dd>{seed}</dd></div>}
      </dl>
      {plans.filter((plan) => plan.text).map((plan) => <details key={plan.file}><summary>{plan.file}</summary><pre tabIndex={0}>{plan.text}</pre></details>)}
    </Section>
  );
}

/// Another result beside this one: of the same instrument those first.
function CompareWith({ file, result }: { file: string; result: Result }) {
  const { answer } = useAnswer<{ results: ListedResult[] }>("/api/results");
  const others = (answer?.results ?? []).filter((one) => one.name !== file && one.method === result.method);
  if (others.length === 0) return null;
  const sorted = [...others].sort((a, b) => Number(b.serial === result.serial) - Number(a.serial === result.serial));
  return (
    <label class="compare-with">
      {t("results_compare_with")}
      <select value="" onChange={(event) => openResults([event.currentTarget.value, file])}>
        <option value="" />
        {sorted.map((one) => <option key={one.name} value={one.name}>{[one.serial, one.date, one.name].filter(Boolean).join(" · ")}</option>)}
      </select>
    </label>
  );
}

export function ResultPage({ file }: { file: string }) {
  const chosen = Object.entries(units.value).map(([name, unit]) => `&unit=${encodeURIComponent(`${name}~${unit}`)}`).join("");
  const { answer: result, problems } = useAnswer<Result>(`/api/result?file=${encodeURIComponent(file)}&language=${language.value}${chosen}`);
  const tally = useMemo(() => {
    const of = (outcome: string) => result?.verdicts.filter((one) => one.outcome === outcome).length ?? 0;
    return { pass: of("pass"), fail: of("fail"), undecided: of("undecided") };
  }, [result]);
  if (!result) return <Problems problems={problems} />;
  const facts = [result.method_name, result.model, result.serial && t("results_serial", { serial: result.serial }), file].filter(Boolean);
  const page = `/api/result/page?file=${encodeURIComponent(file)}&language=${language.value}`;
  return (
    <article class="result">
      <header class="recording-head">
        <h1>{result.title || result.method_name}</h1>
        {tally.fail > 0 && <span class="badge error">✖ {t("results_failed", { count: tally.fail })}</span>}
        {tally.undecided > 0 && <span class="badge warning">? {t("results_undecided", { count: tally.undecided })}</span>}
        {tally.pass > 0 && <span class="badge good">✓ {t("results_passed", { count: tally.pass })}</span>}
        <p class="facts">{facts.map((fact) => <span key={fact}>{fact}</span>)}</p>
        {result.fit && (
          <p class="facts">
            <span>{t("results_fit", { observations: count(result.fit.observations), freedom: result.fit.degrees_of_freedom })}</span>
            {result.fit.chi_square && <span>{t("results_chi_square", { value: result.fit.chi_square })}</span>}
          </p>
        )}
        <p class="toolbar">
          <a class="button" href={page} target="_blank" rel="noopener">{t("open_report")}</a>
          <a class="button" href={`/api/result/file?file=${encodeURIComponent(file)}`} download={file.split("/").pop()}>JSON</a>
          <CompareWith file={file} result={result} />
          <a class="all-results" href={RESULTS} onClick={(event) => { event.preventDefault(); openResults([]); }}>{t("results_all")}</a>
        </p>
      </header>
      <Problems problems={problems} />
      <div class="result-columns">
        <div>
          <Verdicts result={result} />
          <Figures file={file} result={result} />
          <Budget result={result} />
          {result.compensates && <Compensate file={file} />}
        </div>
        <div>
          {result.parameters.length > 0 && <Parameters rows={result.parameters} title={t("results_parameters")} name="parameters" choose />}
          {result.with_prior && <Parameters rows={result.with_prior} title={t("results_with_prior")} name="with_prior" choose={false} />}
          <Findings findings={result.findings} />
          <Correlation file={file} result={result} />
          <Provenance result={result} />
        </div>
      </div>
    </article>
  );
}
