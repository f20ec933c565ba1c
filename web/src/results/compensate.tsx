// The error model of this result subtracted from a recording of the folder, by a job.
import { useState } from "preact/hooks";
import { ListedRecording, Plans, post, problemsOf } from "../api";
import { jobs } from "../jobs";
import { t } from "../texts";
import { Figure, useAnswer } from "./answers";
import { FigureView } from "./figure";
import { RESULTS } from "./view";

function Done({ job }: { job: string }) {
  const made = `jobs/${job}/compensation.json`;
  const { answer } = useAnswer<Figure[]>(`/api/result/figures?file=${encodeURIComponent(made)}`);
  return (
    <div data-testid="compensated">
      {answer?.map((figure, i) => (
        <FigureView key={figure.name} figure={figure} hidden={[]} zoom={null} onHide={() => undefined} onZoom={() => undefined}
          drawing={`/api/result/figure.svg?file=${encodeURIComponent(made)}&figure=${i + 1}`} />
      ))}
      <p>
        ✓ <a href={`${RESULTS}?file=${encodeURIComponent(made)}`}>{t("results_show")}</a>{" "}
        <a href={`/?file=${encodeURIComponent(`jobs/${job}/compensated.h5`)}`}>{t("results_compensated_recording")}</a>
      </p>
    </div>
  );
}

export function Compensate({ file }: { file: string }) {
  const { answer: recordings } = useAnswer<{ recordings: ListedRecording[] }>("/api/recordings");
  const { answer: plans } = useAnswer<Plans>("/api/plans");
  const [chosen, setChosen] = useState("");
  const [plan, setPlan] = useState("");
  const [started, setStarted] = useState<string | null>(null);
  const [problems, setProblems] = useState<string[]>([]);
  const job = started ? jobs.value[started] : undefined;
  const known = recordings?.recordings ?? [];
  const recording = chosen || known[0]?.name || "";
  const begin = async () => {
    try {
      const { job: id } = await post<{ job: string }>("/api/jobs/compensate", { result: file, recording, ...(plan && { plan }) });
      setStarted(id);
      setProblems([]);
    } catch (error) {
      setProblems(problemsOf(error));
    }
  };
  return (
    <section class="part" data-part="compensate">
      <h2>{t("results_compensate")}</h2>
      <p class="hint">{t("results_compensate_hint")}</p>
      <p class="form-row">
        <label>
          {t("results_recording")}
          <select value={recording} onChange={(event) => setChosen(event.currentTarget.value)}>
            {known.map((one) => <option key={one.name} value={one.name}>{one.name}</option>)}
          </select>
        </label>
        <label>
          {t("results_motion")}
          <select value={plan} onChange={(event) => setPlan(event.currentTarget.value)}>
            <option value="">{t("results_motion_recorded")}</option>
            {plans?.plans.map((one) => <option key={one.name} value={one.name}>{one.name}</option>)}
          </select>
        </label>
        <button disabled={recording === ""} onClick={() => void begin()}>{t("results_compensate_begin")}</button>
      </p>
      {[...problems, ...(job?.state === "failed" ? job.problems : [])].map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      {job && (job.state === "waiting" || job.state === "running") && <p role="status">{t("job_goes_on")}</p>}
      {job?.state === "done" && <Done job={job.id} />}
    </section>
  );
}
