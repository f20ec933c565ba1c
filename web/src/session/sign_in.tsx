// The page before the workbench where people sign in, and their name in the head of it.
import { useState } from "preact/hooks";
import { problemsOf } from "../api";
import { t } from "../texts";
import { session, signIn, signOut, wrongBefore } from "./session";

export function SignIn({ onOpen }: { onOpen: () => void }) {
  const [problems, setProblems] = useState<string[]>([]);
  const [busy, setBusy] = useState(false);
  const submit = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = new FormData(event.currentTarget as HTMLFormElement);
    setBusy(true);
    try {
      await signIn(String(form.get("name")).trim(), String(form.get("password")));
      onOpen();
    } catch (error) {
      setProblems(problemsOf(error));
      setBusy(false);
    }
  };
  return (
    <main class="closed">
      <h1>Tumble</h1>
      <form class="ask" onSubmit={(event) => void submit(event)}>
        <label>{t("session_name")}<input name="name" autocomplete="username" required /></label>
        <label>{t("session_password")}<input name="password" type="password" autocomplete="current-password" required /></label>
        {problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
        <button class="main" disabled={busy}>{t("session_sign_in")}</button>
      </form>
    </main>
  );
}

/// Who is signed in; wrong passwords of others under this name are said once.
export function Signed() {
  const { users, user, roles } = session.value;
  if (!users) return null;
  return (
    <span class="signed">
      <span title={roles.map((role) => t(`session_may_${role}`)).join(", ")}>{user}</span>
      {wrongBefore.value > 0 && <span class="warning" role="alert">⚠ {t("session_wrong_before", { count: wrongBefore.value })}</span>}
      <button class="quiet" onClick={() => void signOut()}>{t("session_sign_out")}</button>
    </span>
  );
}
