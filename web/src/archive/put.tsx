// A result of the folder into the archive, with the files that it was made from.
import { useState } from "preact/hooks";
import { post, problemsOf } from "../api";
import { listing } from "../jobs";
import { may } from "../session/session";
import { t } from "../texts";
import { addressIn, enter, short, useAnswer } from "./answer";

interface Done {
  results: number;
  files: number;
  known: number;
  sha256: string;
  model: string;
  serial: string;
}

export function PutPage() {
  const { body } = useAnswer<{ results: string[] }>("/api/archive/candidates");
  const [problems, setProblems] = useState<string[]>([]);
  const [done, setDone] = useState<Done | null>(null);
  const submit = async (event: SubmitEvent) => {
    event.preventDefault();
    const fields = new FormData(event.currentTarget as HTMLFormElement);
    try {
      setDone(await post<Done>("/api/archive/results", Object.fromEntries(fields)));
      setProblems([]);
      ++listing.value;
    } catch (error) {
      setDone(null);
      setProblems(problemsOf(error));
    }
  };
  const unit = done ? `${done.model}/${done.serial}` : "";
  return (
    <section>
      <h1>{t("archive_view_put")}</h1>
      <p class="hint">{t("archive_put_hint")}</p>
      {!may("operate") && <p class="notice">{t("archive_put_needs_role")}</p>}
      {body && body.results.length === 0 && <p class="notice">{t("archive_no_results")}</p>}
      {body && body.results.length > 0 && may("operate") && (
        <form class="ask" onSubmit={(event) => void submit(event)}>
          <label>{t("archive_result")}<select name="result">{body.results.map((name) => <option key={name} value={name}>{name}</option>)}</select></label>
          <label>{t("archive_replaces")}<input name="replaces" placeholder="1f0c3a…" /></label>
          <label>{t("archive_why")}<input name="reason" maxLength={500} /></label>
          <button class="main">{t("archive_put")}</button>
        </form>
      )}
      {problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      {done && (
        <p role="status" class="notice">
          {t("archive_put_done", { results: done.results, files: done.files, known: done.known })} <code>{short(done.sha256)}</code>{" "}
          <a href={addressIn({ unit })} onClick={(event) => enter(event, { unit })}>{unit}</a>
        </p>
      )}
    </section>
  );
}
