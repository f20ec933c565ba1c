// Correlations of the parameters as colours; their numbers on demand.
import { t } from "../texts";
import type { Result } from "./answers";
import { numbers } from "./view";

function Cell({ r }: { r: number | null }) {
  if (r === null) return <td>–</td>;
  const text = r.toFixed(2).replace("-", "−");
  const depth = Math.round(100 * Math.abs(r));
  const style = { background: `color-mix(in srgb, ${r < 0 ? "#e69f00" : "#56b4e9"} ${depth}%, var(--back))` };
  return <td style={style} title={text}>{numbers.value ? text : ""}</td>;
}

export function Correlation({ result }: { result: Result }) {
  if (!result.correlation) return null;
  const title = t("results_correlation");
  return (
    <section class="part" data-part="correlation">
      <h2>{title}</h2>
      <p class="form-row">
        <button aria-pressed={numbers.value} onClick={() => (numbers.value = !numbers.value)}>{t("results_numbers")}</button>
        <span class="hint">{t("results_correlation_hint")}</span>
      </p>
      <div class="scroll" tabIndex={0} role="region" aria-label={title}>
        <table class={numbers.value ? "heat with-numbers" : "heat"} data-testid="correlation">
          <thead><tr><td />{result.parameters.map((row, j) => <th scope="col" key={j} title={row.readable}>{j + 1}</th>)}</tr></thead>
          <tbody>
            {result.correlation.map((row, i) => (
              <tr key={i}>
                <th scope="row">{i + 1} {result.parameters[i]?.readable}</th>
                {row.map((r, j) => <Cell key={j} r={r} />)}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}
