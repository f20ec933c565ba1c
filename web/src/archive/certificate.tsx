// The certificate as it would be issued: the page that `tumble certificate` writes, in a frame that runs nothing.
import { useState } from "preact/hooks";
import { post, problemsOf } from "../api";
import { query, show } from "../route";
import { may } from "../session/session";
import { language, t } from "../texts";
import { useAnswer } from "./answer";

interface Preview {
  notes: string[];
  number: string;
  specimen: boolean;
}

const RULES = ["", "simple", "guarded:1", "risk:0.025", "method6", "non-binary"];

export function CertificatePage() {
  const { body: listed } = useAnswer<{ results: string[]; labs: string[] }>("/api/archive/candidates");
  const [said, setSaid] = useState<string[]>([]);
  const seen = query.value, archived = seen.get("sha256");
  const chosen: Record<string, string> = {
    ...(archived === null ? { result: seen.get("result") ?? listed?.results[0] ?? "" } : { sha256: archived }),
    lab: seen.get("lab") ?? listed?.labs[0] ?? "",
    rule: seen.get("rule") ?? "",
    language: seen.get("language") ?? language.value,
    number: seen.get("number") ?? "",
  };
  const ready = chosen.lab !== "" && (chosen.result ?? chosen.sha256) !== "";
  const asked = new URLSearchParams(Object.entries(chosen).filter(([, value]) => value !== ""));
  const { body, problems } = useAnswer<Preview>(ready ? `/api/archive/certificate?${asked}` : null);
  const change = (key: string, value: string) => show(new URLSearchParams({ view: "certificate", ...Object.fromEntries(asked), [key]: value }));
  const issue = () => post("/api/archive/certificate", chosen).then(() => setSaid([]), (error) => setSaid(problemsOf(error)));
  const choice = (key: string, values: string[], words = (value: string) => value) => (
    <label>{t(`archive_choose_${key}`)}
      <select value={chosen[key]} onChange={(event) => change(key, event.currentTarget.value)}>
        {values.map((value) => <option key={value} value={value}>{words(value)}</option>)}
      </select>
    </label>
  );
  return (
    <section>
      <h1>{t("archive_view_certificate")}</h1>
      {listed && (listed.labs.length === 0 || (archived === null && listed.results.length === 0)) && <p class="notice">{t("archive_certificate_needs")} <code>examples/lab.toml</code></p>}
      {listed && (
        <div class="form-row">
          {archived === null && choice("result", listed.results)}
          {choice("lab", listed.labs)}
          {choice("rule", RULES, (rule) => (rule === "" ? t("archive_rule_of_lab") : rule))}
          {choice("language", ["en", "zh"], (code) => (code === "zh" ? "中文" : "English"))}
          <label>{t("archive_choose_number")}<input value={chosen.number} placeholder={body?.number} onChange={(event) => change("number", event.currentTarget.value)} /></label>
        </div>
      )}
      {problems.length > 0 && (
        <div role="alert" class="notice" data-testid="missing">
          <p>{t("archive_certificate_missing", { count: problems.length })}</p>
          <ul>{problems.map((problem) => <li class="problem" key={problem}>{problem}</li>)}</ul>
        </div>
      )}
      {body?.specimen && <p class="warning">⚠ {t("archive_specimen")}</p>}
      {body?.notes.map((note) => <p class="hint" key={note}>{note}</p>)}
      {body && archived === null && may("approve") && <p><button class="main" onClick={() => void issue()}>{t("archive_issue")}</button> <span class="hint">{t("archive_issue_does")}</span></p>}
      {said.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      {body && <iframe class="page" sandbox="" src={`/api/archive/certificate/page?${asked}`} title={t("archive_view_certificate")} />}
    </section>
  );
}
