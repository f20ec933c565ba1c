// Where the uncertainty of each parameter comes from: a stacked bar, and on demand the numbers.
import { t } from "../texts";
import type { ParameterRow, Result } from "./answers";
import { parameter } from "./view";

// The colours of the report, behind which stripes follow.
const COLOURS = 6;

function classOf(source: number): string {
  return `source-${source % COLOURS}${source >= COLOURS ? " striped" : ""}`;
}

function Numbers({ row, sources }: { row: ParameterRow; sources: string[] }) {
  return (
    <table class="numbers budget-numbers">
      <thead><tr><th scope="col">{t("results_source")}</th><th scope="col">{t("results_sd")} <small>{row.unit === "1" ? "" : row.unit}</small></th><th scope="col">{t("results_share")}</th></tr></thead>
      <tbody>
        {sources.map((source, k) => (
          <tr key={k}><th scope="row">{source}</th><td>{row.budget[k]?.sd}</td><td>{row.budget[k]?.percent}</td></tr>
        ))}
      </tbody>
    </table>
  );
}

function Bar({ row, sources }: { row: ParameterRow; sources: string[] }) {
  const open = parameter.value === row.name;
  return (
    <li>
      <button class="quiet bar-name" aria-expanded={open} onClick={() => (parameter.value = open ? "" : row.name)}>{row.readable}</button>
      <span class="bar" role="img" aria-label={sources.map((source, k) => `${source} ${row.budget[k]?.percent}`).join(", ")}>
        {row.budget.map((part, k) => part.share !== null && part.share > 0.001 && (
          <span key={k} class={classOf(k)} style={{ width: `${100 * Math.min(1, part.share)}%` }} title={`${sources[k]}: ${part.percent}`}>
            {part.share > 0.12 ? part.percent : ""}
          </span>
        ))}
      </span>
      {open && <Numbers row={row} sources={sources} />}
    </li>
  );
}

export function Budget({ result }: { result: Result }) {
  if (result.sources.length === 0) return null;
  return (
    <section class="part" data-part="budget">
      <h2>{t("results_budget")}</h2>
      <ul class="figure-legend">{result.sources.map((source, k) => <li key={k}><span class={`swatch ${classOf(k)}`} />{source}</li>)}</ul>
      <ul class="bars" data-testid="budget">{result.parameters.map((row) => <Bar key={row.name} row={row} sources={result.sources} />)}</ul>
      <p class="hint">{t("results_budget_hint")}</p>
    </section>
  );
}
