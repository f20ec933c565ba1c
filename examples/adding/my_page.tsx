// A page of one's own: the verdicts of one result. Its imports are those of web/src/verdicts/room.tsx.
import { useAnswer } from "../archive/answer";
import { query } from "../route";
import { t } from "../texts";

interface Verdicts {
  name: string;
  method: string;
  verdicts: { parameter: string; value: string; limit: string; outcome: "pass" | "fail" | "undecided" }[];
}

const COLUMNS = ["results_parameter", "results_measured", "results_limit", "results_verdict"];

export function VerdictsRoom() {
  const file = query.value.get("file");
  const { body, problems } = useAnswer<Verdicts>(file === null ? null : `/api/verdicts?file=${encodeURIComponent(file)}`);
  return (
    <section>
      <h1>{t("results_verdicts")}</h1>
      {problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      {body && body.verdicts.length === 0 && <p class="notice">{t("results_no_limits")}</p>}
      {body && body.verdicts.length > 0 && (
        <div class="scroll" tabIndex={0} role="region" aria-label={t("results_verdicts")}>
          <table class="list" data-testid="verdicts">
            <thead><tr>{COLUMNS.map((key) => <th scope="col" key={key}>{t(key)}</th>)}</tr></thead>
            <tbody>
              {body.verdicts.map((one) => (
                <tr key={one.parameter}>
                  <td>{one.parameter}</td><td>{one.value}</td><td>{one.limit}</td>
                  <td>{t(`archive_verdict_${one.outcome}`)}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}
