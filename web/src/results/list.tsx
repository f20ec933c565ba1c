// The results of the folder, and which of them are compared.
import { useState } from "preact/hooks";
import { jobs, listing } from "../jobs";
import { date, t } from "../texts";
import { ListedResult, useAnswer } from "./answers";
import { openResults, queryOf, RESULTS } from "./view";

function Verdict({ result }: { result: ListedResult }) {
  if (result.failed > 0) return <span class="badge error">✖ {t("results_failed", { count: result.failed })}</span>;
  if (result.errors > 0) return <span class="badge error">✖ {t("results_errors", { count: result.errors })}</span>;
  if (result.undecided > 0) return <span class="badge warning">? {t("results_undecided", { count: result.undecided })}</span>;
  if (result.passed > 0) return <span class="badge good">✓ {t("results_passed", { count: result.passed })}</span>;
  return <span class="badge">{t("results_not_judged")}</span>;
}

function Entry({ result, chosen, choose }: { result: ListedResult; chosen: boolean; choose: () => void }) {
  const open = (event: MouseEvent) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    openResults([result.name]);
  };
  return (
    <tr>
      <td><input type="checkbox" checked={chosen} onChange={choose} aria-label={t("results_choose", { name: result.name })} /></td>
      <th scope="row">
        <a href={`${RESULTS}?${queryOf([result.name])}`} onClick={open}>{result.title || result.method_name}</a>
        <small>{result.name}</small>
      </th>
      <td class="wide">{result.method_name}</td>
      <td>{result.serial || result.model}{result.serial && <small>{result.model}</small>}</td>
      <td class="wide">{result.date || date(result.modified)}</td>
      <td><Verdict result={result} /></td>
    </tr>
  );
}

export function ResultsPage() {
  const finished = Object.values(jobs.value).filter((job) => job.state === "done").length;
  const { answer, problems } = useAnswer<{ results: ListedResult[]; cut: boolean }>("/api/results", `${finished} ${listing.value}`);
  const [wanted, setWanted] = useState("");
  const [chosen, setChosen] = useState<string[]>([]);
  const words = wanted.toLowerCase().split(/\s+/).filter(Boolean);
  const all = answer?.results ?? [];
  const matching = all.filter((result) => {
    const text = [result.name, result.title, result.method, result.method_name, result.model, result.serial, result.date].join(" ").toLowerCase();
    return words.every((word) => text.includes(word));
  });
  const choose = (name: string) => setChosen(chosen.includes(name) ? chosen.filter((one) => one !== name) : [...chosen, name]);
  // The list has the newest first; results are compared in order of time.
  const inOrder = all.map((result) => result.name).filter((name) => chosen.includes(name)).reverse();
  return (
    <section class="results">
      <header class="list-head">
        <h1>{t("results")}</h1>
        <label class="search">
          {t("search")}
          <input type="search" value={wanted} onInput={(event) => setWanted(event.currentTarget.value)} />
        </label>
        {matching.length > 1 && <button onClick={() => setChosen(matching.slice(0, 200).map((result) => result.name))}>{t("results_choose_all")}</button>}
        <button class="main" disabled={inOrder.length < 2} onClick={() => openResults(inOrder)}>{t("results_compare", { count: inOrder.length })}</button>
      </header>
      {problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      {answer && all.length === 0 && <p class="notice">{t("results_none")}</p>}
      {matching.length > 0 && (
        <table class="list" data-testid="results">
          <thead>
            <tr>
              <th scope="col"><span class="unseen">{t("results_chosen")}</span></th>
              <th scope="col">{t("results_result")}</th>
              <th scope="col" class="wide">{t("results_method")}</th>
              <th scope="col">{t("results_unit")}</th>
              <th scope="col" class="wide">{t("results_date")}</th>
              <th scope="col">{t("results_verdict")}</th>
            </tr>
          </thead>
          <tbody>
            {matching.map((result) => <Entry key={result.name} result={result} chosen={chosen.includes(result.name)} choose={() => choose(result.name)} />)}
          </tbody>
        </table>
      )}
      {all.length > 0 && matching.length === 0 && <p class="notice">{t("results_nothing_found")}</p>}
      {answer?.cut && <p class="hint">{t("results_cut", { count: all.length })}</p>}
    </section>
  );
}
