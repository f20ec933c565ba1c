// A parameter over time or over units: control charts, drift, summary. All numbers, texts and drawings are the server's.
import { useState } from "preact/hooks";
import type { Figure, Link } from "../results/answers";
import { FigureView } from "../results/figure";
import type { Zoom } from "../results/view";
import "../results/results.css";
import { query, show } from "../route";
import { language, t } from "../texts";
import { addressIn, enter, short, useAnswer } from "./answer";

interface Column {
  name: string;
  unit: string;
  number: boolean;
}

interface Chart {
  title: string;
  parameters: { name: string; description: string; text: string; interval: string }[];
  tables: { name: string; title: string; caption: string; columns: Column[]; cells: string[][] }[];
  findings: { severity: "info" | "warning" | "error"; message: string }[];
  figures: (Figure & { svg: string; csv: string })[];
}

const MOST_ROWS = 200;

const asData = (type: string, text: string): string => `data:${type};charset=utf-8,${encodeURIComponent(text)}`;

/// A point of a chart is a result, or a unit.
function seenOf(link: Link): Record<string, string> {
  return link.result ? { kept: link.result, unit: link.unit } : { unit: link.unit };
}

const linksOfPoints = {
  addressOf: (link: Link) => ({ href: addressIn(seenOf(link)), name: link.result ? t("archive_point", { result: short(link.result), unit: link.unit }) : link.unit }),
  follow: (event: MouseEvent, link: Link) => enter(event, seenOf(link)),
};

function ChartFigure({ figure }: { figure: Chart["figures"][number] }) {
  const [hidden, setHidden] = useState<number[]>([]);
  const [zoom, setZoom] = useState<Zoom | null>(null);
  const hide = (series: number) => setHidden(hidden.includes(series) ? hidden.filter((one) => one !== series) : [...hidden, series]);
  return (
    <div class="chart">
      <FigureView figure={figure} hidden={hidden} zoom={zoom} links={linksOfPoints} onHide={hide} onZoom={setZoom}
        drawing={asData("image/svg+xml", figure.svg)} />
      <p class="form-row">
        <a class="button" href={asData("image/svg+xml", figure.svg)} download={`${figure.name}.svg`} aria-label={`SVG: ${figure.name}`}>SVG</a>
        <a class="button" href={asData("text/csv", figure.csv)} download={`${figure.name}.csv`} aria-label={`CSV: ${figure.name}`}>CSV</a>
      </p>
    </div>
  );
}

/// The newest rows where there are many.
function Table({ table }: { table: Chart["tables"][number] }) {
  const count = table.cells[0]?.length ?? 0, first = Math.max(0, count - MOST_ROWS);
  if (count === 0) return null;
  return (
    <section class="block" aria-label={table.title}>
      <h2>{table.title}</h2> <span class="hint">{table.caption}</span>
      {first > 0 && <p class="hint">{t("archive_cut", { count: MOST_ROWS, all: count })}</p>}
      <div class="scroll" tabIndex={0} role="group" aria-label={table.title}>
        <table class="list numbers" data-testid={table.name}>
          <thead><tr>{table.columns.map((column, k) => <th scope="col" key={k} class={column.number ? "number" : ""}>{column.name}{column.unit !== "" && <small>{column.unit}</small>}</th>)}</tr></thead>
          <tbody>
            {Array.from({ length: count - first }, (_, i) => (
              <tr key={i}>{table.columns.map((column, k) => <td key={k} class={column.number ? "number" : ""}>{table.cells[k]![first + i]}</td>)}</tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}

function Limits() {
  const seen = query.value;
  const submit = (event: SubmitEvent) => {
    event.preventDefault();
    const fields = new FormData(event.currentTarget as HTMLFormElement), next = new URLSearchParams(seen);
    for (const which of ["min", "max"]) {
      const text = String(fields.get(which)).trim();
      if (text === "") next.delete(which);
      else next.set(which, text);
    }
    show(next);
  };
  return (
    <form class="form-row" onSubmit={submit}>
      <label>{t("archive_min")}<input name="min" defaultValue={seen.get("min") ?? ""} placeholder="-0.5 deg/h" /></label>
      <label>{t("archive_max")}<input name="max" defaultValue={seen.get("max") ?? ""} placeholder="0.5 deg/h" /></label>
      <button>{t("archive_apply")}</button>
    </form>
  );
}

export function ChartPage() {
  const seen = query.value, unit = seen.get("unit"), model = seen.get("model") ?? "", parameter = seen.get("parameter")!;
  const kind = seen.get("kind") ?? "chart", kinds = unit === null ? ["summary", "chart"] : ["drift", "chart"];
  const asked = new URLSearchParams(seen);
  asked.set("kind", kind);
  asked.set("language", language.value);
  const { body, problems } = useAnswer<Chart>(`/api/archive/chart?${asked}`);
  const whose = unit ?? model;
  const back: Record<string, string> = unit === null ? {} : { unit };
  return (
    <section>
      <p class="links"><a href={addressIn(back)} onClick={(event) => enter(event, back)}>← {unit ?? t("archive_view_units")}</a></p>
      <header class="list-head">
        <h1>{parameter}: {whose}</h1>
        <label class="search">{t("archive_kind")}
          <select value={kind} onChange={(event) => { const next = new URLSearchParams(seen); next.set("kind", event.currentTarget.value); show(next); }}>
            {kinds.map((one) => <option key={one} value={one}>{t(`archive_kind_${one}`)}</option>)}
          </select>
        </label>
      </header>
      {kind !== "chart" && <Limits key={`${whose} ${parameter}`} />}
      {problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      {body && (
        <>
          <ul class="findings">
            {body.findings.map((one) => <li key={one.message} class={one.severity}><span class="sign">{one.severity === "info" ? "ℹ" : "⚠"}</span> {one.message}</li>)}
          </ul>
          {body.figures.map((figure) => <ChartFigure key={figure.name} figure={figure} />)}
          <dl class="about" data-testid="numbers">
            {body.parameters.map((one) => <div key={one.name}><dt title={one.description}>{one.name}</dt><dd>{one.text} <span class="hint">{one.interval}</span></dd></div>)}
          </dl>
          {body.tables.map((table) => <Table key={table.name} table={table} />)}
        </>
      )}
    </section>
  );
}
