// What the plan will tell, while it is written, beside what the saved one tells.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { problemsOf } from "../api";
import { language, t } from "../texts";
import { ask, Prediction } from "./ask";
import { file, look, saved, text } from "./state";

const prediction = signal<Prediction | null>(null);
const working = signal(false);
const problems = signal<string[]>([]);
/// This page, so that a prediction that it does not want any more is ended.
const page = Array.from(crypto.getRandomValues(new Uint8Array(8)), (byte) => byte.toString(16).padStart(2, "0")).join("");

const sleep = (time: number) => new Promise((done) => setTimeout(done, time));

async function follow(body: unknown, control: AbortController): Promise<void> {
  await sleep(250);
  for (let pause = 60; !control.signal.aborted; pause = Math.min(1000, 1.4 * pause)) {
    const answer = await ask<Prediction>(`/api/plan/predict?language=${language.value}`, body, control.signal);
    if (control.signal.aborted) return;
    if (answer.ready) {
      prediction.value = answer;
      problems.value = answer.problems;
      working.value = false;
      return;
    }
    await sleep(pause);
  }
}

function usePrediction(): void {
  const sound = look.value !== null && look.value.problems.length === 0;
  const now = text.value, before = saved.value;
  useEffect(() => {
    if (!sound) {
      working.value = false;
      return;
    }
    const control = new AbortController();
    working.value = true;
    follow({ page, file: file.value ?? "", text: now, saved: before ?? "" }, control).catch((error) => {
      if (control.signal.aborted) return;
      working.value = false;
      problems.value = problemsOf(error);
    });
    return () => control.abort();
  }, [sound, now, before, language.value]);
}

const SIGN: Record<string, string> = { worse: "▲", better: "▼", same: "=", new: "+", none: "" };

export function Predicted() {
  usePrediction();
  useEffect(() => () => void (prediction.value = null), []);
  const answer = prediction.value;
  const compared = answer?.rows.some((row) => row.saved !== "") ?? false;
  const stale = working.value || (look.value?.problems.length ?? 0) > 0;
  return (
    <section class="predicted section" aria-label={t("plans_predicted")} data-testid="predicted" data-state={working.value ? "working" : "ready"}>
      <h2>{t("plans_predicted")}</h2>
      <p role="status" class={compared && answer!.worse > 0 ? "warning" : "hint"}>
        {working.value ? t("plans_predicting")
          : (look.value?.problems.length ?? 0) > 0 ? t("plans_predict_after")
          : compared ? (answer!.worse > 0 ? `▲ ${t("plans_worse", { count: answer!.worse })}` : answer!.better > 0 ? `▼ ${t("plans_better", { count: answer!.better })}` : t("plans_same"))
          : t("plans_predicted_hint")}
      </p>
      {!working.value && problems.value.map((problem) => <p class="problem" key={problem}>{problem}</p>)}
      {answer && answer.rows.length > 0 && (
        <div class={stale ? "scroll stale" : "scroll"} tabIndex={0} role="region" aria-label={t("plans_sd")}>
          <table class="numbers">
            <thead>
              <tr>
                <th scope="col">{t("plans_parameter")}</th>
                <th scope="col">{t("plans_sd")}</th>
                <th scope="col">{t("plans_unit")}</th>
                {compared && <th scope="col">{t("plans_saved_sd")}</th>}
                {compared && <th scope="col">{t("plans_change")}</th>}
              </tr>
            </thead>
            <tbody>
              {answer.rows.map((row) => (
                <tr key={row.name} class={row.change} data-parameter={row.name}>
                  <th scope="row" title={row.description}>{row.name.split("_").map((part, i) => <>{i > 0 && <>_<wbr /></>}{part}</>)}</th>
                  <td>{row.sd}</td>
                  <td>{row.unit}</td>
                  {compared && <td>{row.saved}</td>}
                  {compared && <td class="change">{row.change === "none" ? "" : `${SIGN[row.change]} ${row.change === "same" || row.ratio === "" ? "" : `${row.ratio}× `}${t(`plans_is_${row.change}`)}`}</td>}
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
      {answer && answer.lost.length > 0 && <p class="warning">{t("plans_lost", { names: answer.lost.join(", ") })}</p>}
      {answer && answer.findings.length > 0 && (
        <ul class="findings">
          {answer.findings.map((finding) => (
            <li key={finding.message} class={finding.severity}><span class="sign">{t(`severity_${finding.severity}`)}</span> {finding.message}</li>
          ))}
        </ul>
      )}
    </section>
  );
}
