// Signatures: who signed which bytes, when, and what it means; and the form that asks for the password again.
import { useState } from "preact/hooks";
import { post, problemsOf } from "../api";
import { listing } from "../jobs";
import { may, session } from "../session/session";
import { t } from "../texts";
import { moment, short, Signature } from "./answer";

export function SignatureList({ signatures }: { signatures: Signature[] }) {
  if (signatures.length === 0) return null;
  return (
    <section class="block" aria-label={t("archive_signatures")}>
      <h2>{t("archive_signatures")}</h2>
      <ul class="signatures" data-testid="signatures">
        {signatures.map((one) => (
          <li key={one.number} class={one.problem === "" ? "" : "problem"}>
            {one.problem === ""
              ? <span class="badge good">✓ {t(`archive_meaning_${one.meaning}`)}</span>
              : <span class="badge error">✖ {t("archive_not_of_this")}</span>}{" "}
            {one.by}, {moment(one.time)} UTC, {t(`archive_of_${one.of}`)} <code>{short(one.sha256)}</code>: {one.why}
            {one.problem !== "" && <span> ({t(`archive_meaning_${one.meaning}`)}; {one.problem})</span>}
          </li>
        ))}
      </ul>
    </section>
  );
}

/// Why one cannot sign, or the form.
export function SignForm({ sha256 }: { sha256: string }) {
  const [problems, setProblems] = useState<string[]>([]);
  const [busy, setBusy] = useState(false);
  if (!session.value.users) return <p class="hint">{t("archive_sign_needs_users")} <code>tumble serve --users FILE</code></p>;
  if (!may("approve")) return <p class="hint">{t("archive_sign_needs_role")}</p>;
  const submit = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = event.currentTarget as HTMLFormElement, fields = new FormData(form);
    setBusy(true);
    try {
      await post("/api/archive/sign", { sha256, meaning: fields.get("meaning"), reason: fields.get("reason"), password: fields.get("password") });
      setProblems([]);
      form.reset();
      ++listing.value;
    } catch (error) {
      setProblems(problemsOf(error));
      (form.elements.namedItem("password") as HTMLInputElement).value = "";
    }
    setBusy(false);
  };
  return (
    <form class="ask" onSubmit={(event) => void submit(event)} aria-label={t("archive_sign")}>
      <p>{t("archive_sign_as", { name: session.value.user })} <code>{short(sha256)}</code></p>
      <label>{t("archive_meaning")}
        <select name="meaning">
          {(["approved", "reviewed"] as const).map((meaning) => <option key={meaning} value={meaning}>{t(`archive_meaning_${meaning}`)}</option>)}
        </select>
      </label>
      <label>{t("archive_why")}<input name="reason" required maxLength={500} /></label>
      <label>{t("session_password")}<input name="password" type="password" autocomplete="current-password" required /></label>
      {problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      <button class="main" disabled={busy}>{t("archive_sign")}</button>
    </form>
  );
}
