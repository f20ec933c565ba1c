// Correlation or covariance of the parameters: colours are correlations, and the numbers are shown on demand.
import { useState } from "preact/hooks";
import { problemsOf } from "../api";
import { t } from "../texts";
import type { Result } from "./answers";
import { matrix, numbers, units } from "./view";

function Cell({ r, covariance }: { r: number | null; covariance: string | null | undefined }) {
  const correlation = r === null ? "–" : r.toFixed(2).replace("-", "−");
  const text = covariance === undefined ? correlation : covariance ?? "–";
  const style = r === null ? {} : { background: `color-mix(in srgb, ${r < 0 ? "#e69f00" : "#56b4e9"} ${Math.round(100 * Math.abs(r))}%, var(--back))` };
  return <td style={style} title={text}>{numbers.value || covariance !== undefined || r === null ? text : ""}</td>;
}

/// The whole matrix with all its digits, into a spreadsheet.
function Save({ file }: { file: string }) {
  const [said, setSaid] = useState("");
  const query = new URLSearchParams({ file, kind: matrix.value });
  for (const [name, unit] of Object.entries(units.value)) query.append("unit", `${name}~${unit}`);
  const address = `/api/result/matrix.csv?${query}`;
  const copy = async () => {
    try {
      const answer = await fetch(address);
      if (!answer.ok) throw new Error(answer.statusText);
      await navigator.clipboard.writeText(await answer.text());
      setSaid(t("results_copied"));
    } catch (error) {
      setSaid(problemsOf(error).join(" "));
    }
  };
  return (
    <>
      {/* A browser gives the clipboard to pages of this computer and by TLS alone. */}
      {window.isSecureContext && <button onClick={() => void copy()}>{t("results_copy")}</button>}
      <a class="button" href={address} download={`${matrix.value}.csv`} aria-label={`CSV: ${t(`results_${matrix.value}`)}`}>CSV</a>
      <span role="status">{said}</span>
    </>
  );
}

export function Correlation({ file, result }: { file: string; result: Result }) {
  const { correlation, covariance } = result;
  if (!correlation || !covariance) return null;
  const covariances = matrix.value === "covariance";
  const title = t(covariances ? "results_covariance" : "results_correlation");
  return (
    <section class="part" data-part="correlation">
      <h2>{title}</h2>
      <p class="form-row">
        <span role="group" aria-label={t("results_matrix")}>
          {(["correlation", "covariance"] as const).map((kind) => (
            <button key={kind} aria-pressed={matrix.value === kind} onClick={() => (matrix.value = kind)}>{t(`results_${kind}`)}</button>
          ))}
        </span>
        {!covariances && <button aria-pressed={numbers.value} onClick={() => (numbers.value = !numbers.value)}>{t("results_numbers")}</button>}
        <Save file={file} />
      </p>
      <p class="hint">{t(covariances ? "results_covariance_hint" : "results_correlation_hint")}</p>
      <div class="scroll" tabIndex={0} role="region" aria-label={title}>
        <table class={`heat${covariances ? " with-covariances" : numbers.value ? " with-numbers" : ""}`} data-testid="correlation">
          <thead><tr><td />{result.parameters.map((row, j) => <th scope="col" key={j} title={row.readable}>{j + 1}</th>)}</tr></thead>
          <tbody>
            {correlation.map((row, i) => (
              <tr key={i}>
                <th scope="row">{i + 1} {result.parameters[i]?.readable}{covariances && result.parameters[i]?.unit !== "1" && <small> {result.parameters[i]?.unit}</small>}</th>
                {row.map((r, j) => <Cell key={j} r={r} covariance={covariances ? covariance[i]![j]! : undefined} />)}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}
