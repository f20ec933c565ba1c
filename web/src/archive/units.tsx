// All units: model, results, last test, when the next is due. Overdue ones are marked by a word.
import { useState } from "preact/hooks";
import { post, problemsOf } from "../api";
import { may } from "../session/session";
import { count, t } from "../texts";
import { addressIn, enter, moment, nameOf, Unit, useAnswer } from "./answer";

const MOST = 500;

function Entry({ unit }: { unit: Unit }) {
  const seen = { unit: nameOf(unit) };
  return (
    <tr>
      <th scope="row"><a href={addressIn(seen)} onClick={(event) => enter(event, seen)}>{unit.serial}</a></th>
      <td>{unit.model}</td>
      <td class="number">{count(unit.results)}</td>
      <td>{moment(unit.last)}</td>
      <td>{unit.overdue ? <span class="badge error">✖ {t("archive_overdue")} {unit.due}</span> : unit.due}</td>
    </tr>
  );
}

/// The parameters of a model, each a chart over its units.
function ModelCharts({ model }: { model: string }) {
  const { body } = useAnswer<{ parameters: string[] }>(`/api/archive/model?model=${encodeURIComponent(model)}`);
  if (!body || body.parameters.length === 0) return null;
  return (
    <p class="links">{t("archive_over_units", { model })}{" "}
      {body.parameters.map((parameter) => {
        const seen = { model, parameter, kind: "summary" };
        return <a key={parameter} href={addressIn(seen)} onClick={(event) => enter(event, seen)}>{parameter}</a>;
      })}
    </p>
  );
}

export function UnitsPage() {
  const { body, problems } = useAnswer<{ units: Unit[] }>("/api/archive/units");
  const [search, setSearch] = useState("");
  const [said, setSaid] = useState<string[]>([]);
  const words = search.toLowerCase();
  const matching = body?.units.filter((unit) => nameOf(unit).toLowerCase().includes(words)) ?? [];
  const models = [...new Set(matching.map((unit) => unit.model))];
  const verify = () => post("/api/archive/verify", {}).then(() => setSaid([]), (error) => setSaid(problemsOf(error)));
  return (
    <section>
      <header class="list-head">
        <h1>{t("archive")}</h1>
        <label class="search">{t("archive_search")}<input type="search" value={search} onInput={(event) => setSearch(event.currentTarget.value)} /></label>
        {may("operate") && <button onClick={() => void verify()} title={t("archive_verify_does")}>{t("archive_verify")}</button>}
      </header>
      {[...problems, ...said].map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      {body && body.units.length === 0 && <p class="notice">{t("archive_no_units")}</p>}
      {models.length > 0 && models.length <= 5 && models.map((model) => <ModelCharts key={model} model={model} />)}
      {matching.length > 0 && (
        <div class="scroll">
          <table class="list" data-testid="units">
            <thead>
              <tr>
                <th scope="col">{t("archive_serial")}</th><th scope="col">{t("archive_model")}</th>
                <th scope="col" class="number">{t("archive_results")}</th><th scope="col">{t("archive_last")}</th>
                <th scope="col">{t("archive_next_due")}</th>
              </tr>
            </thead>
            <tbody>{matching.slice(0, MOST).map((unit) => <Entry key={nameOf(unit)} unit={unit} />)}</tbody>
          </table>
        </div>
      )}
      {matching.length > MOST && <p class="hint">{t("archive_cut", { count: count(MOST), all: count(matching.length) })}</p>}
    </section>
  );
}
