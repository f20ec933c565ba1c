// One plan: form and text of it, its picture, and what it will tell.
import { useEffect, useState } from "preact/hooks";
import { get, post, Problem, problemsOf } from "../api";
import { fileOfJob, jobs, listing } from "../jobs";
import { duration, language, t } from "../texts";
import { PlanForm } from "./form";
import { Predicted } from "./prediction";
import { Stage } from "./stage";
import { file, history, lastSchedule, load, loaded, look, lookAt, openPlan, restored, saved, shown, tag, template, text, trouble, undo, unsaved, write } from "./state";
import { PlanText } from "./text";
import { batch } from "@preact/signals";

/// Writes the file; a refusal is shown and nothing is lost.
async function save(name: string, known: string, refused: (problems: string[]) => void): Promise<void> {
  const now = text.value;
  try {
    const answer = await post<{ file: string; tag: string }>("/api/plan/save", { file: name, text: now, tag: known });
    refused([]);
    ++listing.value;
    if (answer.file === file.value) {
      batch(() => {
        saved.value = now;
        tag.value = answer.tag;
      });
    } else {
      openPlan({ file: answer.file });
    }
  } catch (error) {
    refused(problemsOf(error));
    if ((error as Problem).status === 0) refused([t("connection_lost")]);
  }
}

function SaveAs({ onSave }: { onSave: (name: string) => void }) {
  const [open, setOpen] = useState(false);
  const [name, setName] = useState("");
  const begin = (file.value || `${template.value ?? "plan"}.toml`).replace(/\.toml$/, file.value ? "-2.toml" : ".toml");
  if (!open) return <button onClick={() => { setName(begin); setOpen(true); }}>{t("plans_save_as")}</button>;
  return (
    <form class="save-as" onSubmit={(event) => {
      event.preventDefault();
      onSave(name.endsWith(".toml") ? name : `${name}.toml`);
      setOpen(false);
    }}>
      <label>{t("file")} <input type="text" value={name} ref={(input) => input?.focus()} onInput={(event) => setName(event.currentTarget.value)} /></label>
      <button class="main">{t("plans_save")}</button>
      <button type="button" onClick={() => setOpen(false)}>{t("cancel")}</button>
    </form>
  );
}

/// Jobs of this plan: what they do, and what came of them.
function PlanJobs() {
  const own = Object.values(jobs.value).filter((job) => job.title === file.value && ["rehearse", "optimise", "validate"].includes(job.kind));
  const latest = own.sort((a, b) => b.begun - a.begun || b.id.localeCompare(a.id))[0];
  const [problems, setProblems] = useState<string[]>([]);
  if (!latest) return null;
  const active = latest.state === "waiting" || latest.state === "running";
  const take = async () => {
    try {
      const response = await fetch(fileOfJob(latest, "optimised.toml"));
      if (!response.ok) throw { problems: [response.statusText] };
      write(await response.text());
      setProblems([]);
    } catch (error) {
      setProblems(problemsOf(error));
    }
  };
  return (
    <p class="plan-job" role="status" data-testid="plan-job">
      {t(`job_${latest.kind}`)}: {t(`job_is_${latest.state}`)}{active && latest.doing ? `, ${latest.doing}` : ""}{" "}
      {latest.files.includes("report.html") && <a class="button" href={fileOfJob(latest, "report.html")} target="_blank" rel="noopener">{t("open_report")}</a>}
      {latest.files.includes("optimised.toml") && <button onClick={() => void take()}>{t("plans_take_schedule")}</button>}
      {[...latest.problems, ...problems].map((problem) => <span class="problem" key={problem}>{problem}</span>)}
    </p>
  );
}

function Head() {
  const [refused, setRefused] = useState<string[]>([]);
  const name = file.value || t("plans_new");
  const total = lastSchedule.value?.total ?? 0;
  const start = async (what: string) => {
    try {
      await post("/api/jobs/plan", { file: file.value, what, language: language.value });
      setRefused([]);
    } catch (error) {
      setRefused(problemsOf(error));
    }
  };
  const idle = unsaved.value || !file.value || (look.value?.problems.length ?? 1) > 0;
  return (
    <header class="plan-head">
      <div class="recording-head">
        <h1>{name}</h1>
        <span role="status" class={unsaved.value ? "warning" : "hint"} data-testid="plan-state">{unsaved.value ? `● ${t("plans_unsaved")}` : t("plans_is_saved")}</span>
        {total > 0 && <span class="hint">{t("plans_total", { time: duration(total) })}</span>}
      </div>
      <div class="toolbar">
        <button class="quiet" onClick={() => openPlan(null)}>← {t("plans_room")}</button>
        {file.value && <button class="main" disabled={!unsaved.value} onClick={() => void save(file.value!, tag.value, setRefused)}>{t("plans_save")}</button>}
        <SaveAs onSave={(to) => void save(to, to === file.value ? tag.value : "", setRefused)} />
        <button disabled={history.value.length === 0} onClick={undo}>{t("plans_undo")}</button>
        <button disabled={idle} title={idle ? t("plans_save_first") : ""} onClick={() => void start("rehearse")}>{t("plans_rehearse")}</button>
        <button disabled={idle} title={idle ? t("plans_save_first") : ""} onClick={() => void start("optimise")}>{t("plans_optimise")}</button>
        <button disabled={idle} title={idle ? t("plans_save_first") : t("plans_validate_hint")} onClick={() => void start("validate")}>{t("plans_validate")}</button>
        <span class="shown" role="group" aria-label={t("plans_shown")}>
          {(["form", "text", "both"] as const).map((one) => (
            <button key={one} class={one} aria-pressed={shown.value === one || (shown.value === "" && one === "both")} onClick={() => (shown.value = one)}>{t(`plans_show_${one}`)}</button>
          ))}
        </span>
      </div>
      {refused.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      {restored.value && unsaved.value && (
        <p class="notice">{t("plans_restored")} <button class="quiet" onClick={() => void load(true)}>{t("plans_discard")}</button></p>
      )}
      <PlanJobs />
    </header>
  );
}

export function PlanEditor() {
  useEffect(() => void load(), []);
  useEffect(() => (loaded.value ? lookAt(text.value) : undefined), [text.value, loaded.value, language.value]);
  useEffect(() => {
    const warn = (event: BeforeUnloadEvent) => {
      if (unsaved.value && history.value.length > 0) event.preventDefault();
    };
    addEventListener("beforeunload", warn);
    return () => removeEventListener("beforeunload", warn);
  }, []);
  useEffect(() => { // somebody else may have saved it meanwhile
    if (!file.value || unsaved.value) return;
    get<{ tag: string }>("/api/plan?file=" + encodeURIComponent(file.value)).then((answer) => {
      if (loaded.value && answer.body.tag !== tag.value && !unsaved.value) void load();
    }, () => undefined);
  }, [listing.value]);
  return (
    <article class="plan" data-shown={shown.value || undefined}>
      <Head />
      {trouble.value.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      <div class="plan-columns">
        <PlanForm />
        <PlanText />
        <div class="plan-side">
          <Stage />
          <Predicted />
        </div>
      </div>
    </article>
  );
}
