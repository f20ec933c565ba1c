// Results beside each other: what changed between two of one instrument, and each parameter over up to 200 of them.
import { language, t } from "../texts";
import { Compared, useAnswer } from "./answers";
import { FigureView } from "./figure";
import { Findings, Problems } from "./result";
import { hidden, openResults, parameter, queryOf, RESULTS, zoom } from "./view";

function Pair({ compared, pair }: { compared: Compared; pair: Compared["pairs"][number] }) {
  const name = (number: number) => compared.results[number]?.name ?? "";
  const title = `${name(pair.earlier)} → ${name(pair.later)}`;
  return (
    <section class="part" data-testid="pair">
      <h2>{title}</h2>
      <div class="scroll" tabIndex={0} role="region" aria-label={title}>
        <table class="numbers">
          <thead>
            <tr>
              {["results_parameter", "results_earlier", "results_later", "results_difference"].map((key) => <th scope="col" key={key}>{t(key)}</th>)}
              <th scope="col">{t("results_unit_short")}</th>
              <th scope="col">E<sub>n</sub></th>
            </tr>
          </thead>
          <tbody>
            {pair.differences.map((one) => (
              <tr key={one.parameter} class={one.significant ? "significant" : ""}>
                <th scope="row">{one.readable}</th>
                <td>{one.earlier}</td><td>{one.later}</td><td>{one.difference}</td>
                <td>{one.unit === "1" ? "" : one.unit}</td>
                <td>{one.significant ? <strong>{one.e_n} *</strong> : one.e_n}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <p class="hint">{t("results_together", { text: pair.together })}</p>
    </section>
  );
}

function Units({ compared }: { compared: Compared }) {
  const names = compared.figures.map((figure) => figure.name);
  const chosen = Math.max(0, names.indexOf(parameter.value));
  const figure = compared.figures[chosen];
  if (!figure) return null;
  const labels = compared.results.map((result) => result.serial || result.name);
  return (
    <section class="part">
      <h2>{t("results_over_units")}</h2>
      <p class="form-row">
        <label>
          {t("results_parameter")}
          <select value={names[chosen]} onChange={(event) => { parameter.value = event.currentTarget.value; zoom.value = null; }}>
            {compared.figures.map((one) => <option key={one.name} value={one.name}>{one.y.name}</option>)}
          </select>
        </label>
      </p>
      <FigureView figure={figure} hidden={hidden.value} zoom={zoom.value} drawing="" names={labels}
        onHide={(series) => (hidden.value = hidden.value.includes(series) ? [] : [series])} onZoom={(to) => (zoom.value = to)} />
      <div class="scroll" tabIndex={0} role="region" aria-label={t("results_over_units")}>
        <table class="numbers" data-testid="units">
          <thead><tr><th scope="col">{t("results_unit")}</th><th scope="col">{t("results_result")}</th><th scope="col">{figure.y.name}</th><th scope="col">{t("results_sd")}</th></tr></thead>
          <tbody>
            {compared.results.map((result, i) => (
              <tr key={i}>
                <th scope="row">{i + 1} {result.serial}</th>
                <td><a href={`${RESULTS}?${queryOf([result.name])}`} onClick={(event) => { event.preventDefault(); openResults([result.name]); }}>{result.name}</a></td>
                <td>{compared.values[chosen]?.[i]?.value || t("results_not_determined")}</td>
                <td>{compared.values[chosen]?.[i]?.sd}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}

export function ComparisonPage({ files }: { files: string[] }) {
  const { answer: compared, problems } = useAnswer<Compared>(`/api/results/compare?${queryOf(files)}&language=${language.value}`);
  return (
    <article class="result">
      <header class="recording-head">
        <h1>{t("results_compared", { count: files.length })}</h1>
        {files.length === 2 && <button onClick={() => openResults([...files].reverse())}>{t("results_swap")}</button>}
        <a href={RESULTS} onClick={(event) => { event.preventDefault(); openResults([]); }}>{t("results_all")}</a>
      </header>
      <Problems problems={problems} />
      {compared && (
        <div class="result-columns">
          <div>
            {compared.pairs.map((pair, i) => <Pair key={i} compared={compared} pair={pair} />)}
            {compared.pairs.length > 0 && <p class="hint">{t("results_e_n_hint")}</p>}
            {compared.pairs.length === 0 && <p class="hint">{t("results_many_units")}</p>}
            <Findings findings={compared.findings} />
          </div>
          <div><Units compared={compared} /></div>
        </div>
      )}
    </article>
  );
}
