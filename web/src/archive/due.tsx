// What must be calibrated soon: overdue first.
import { query, show } from "../route";
import { t } from "../texts";
import { addressIn, enter, nameOf, useAnswer } from "./answer";

interface Due {
  equipment: { due: string; equipment: string; certificate: string; laboratory: string; overdue: boolean }[];
  units: { due: string; model: string; serial: string; last_result: string; overdue: boolean }[];
  until: string;
}

interface Line {
  due: string;
  overdue: boolean;
  what: string;
  unit: string | null;
  since: string;
}

function linesOf(due: Due): Line[] {
  const lines: Line[] = [
    ...due.equipment.map((one) => ({ due: one.due, overdue: one.overdue, what: one.equipment, unit: null, since: [one.certificate, one.laboratory].filter((word) => word !== "").join(", ") })),
    ...due.units.map((one) => ({ due: one.due, overdue: one.overdue, what: nameOf(one), unit: nameOf(one), since: one.last_result })),
  ];
  return lines.sort((a, b) => a.due.localeCompare(b.due) || a.what.localeCompare(b.what));
}

export function DuePage() {
  const days = query.value.get("days") ?? "60";
  const { body, problems } = useAnswer<Due>(`/api/archive/due?days=${encodeURIComponent(days)}`);
  const lines = body ? linesOf(body) : [];
  return (
    <section>
      <header class="list-head">
        <h1>{t("archive_view_due")}</h1>
        <label class="search">{t("archive_within")}
          <select value={days} onChange={(event) => show(new URLSearchParams({ view: "due", days: event.currentTarget.value }))}>
            {[...new Set(["30", "60", "180", "365", days])].map((value) => <option key={value} value={value}>{t("archive_days", { count: value })}</option>)}
          </select>
        </label>
      </header>
      {problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      {body && lines.length === 0 && <p class="notice">{t("archive_nothing_due", { day: body.until })}</p>}
      {lines.length > 0 && (
        <div class="scroll">
          <table class="list" data-testid="due">
            <thead><tr>{["archive_due", "archive_what", "archive_since"].map((key) => <th scope="col" key={key}>{t(key)}</th>)}</tr></thead>
            <tbody>
              {lines.map((line) => (
                <tr key={line.what}>
                  <td>{line.due} {line.overdue && <span class="badge error">✖ {t("archive_overdue")}</span>}</td>
                  <td>{line.unit === null ? line.what : <a href={addressIn({ unit: line.unit })} onClick={(event) => enter(event, { unit: line.unit! })}>{line.what}</a>}</td>
                  <td>{line.since}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}
