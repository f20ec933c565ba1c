// The plan as text: line numbers, and each problem at its line.
import { useRef } from "preact/hooks";
import { t } from "../texts";
import { look, text, write } from "./state";

let typing: ReturnType<typeof setTimeout> | undefined;

/// What is typed in one go is undone in one go.
function typed(next: string): void {
  write(next, typing === undefined);
  clearTimeout(typing);
  typing = setTimeout(() => (typing = undefined), 800);
}

export function goToLine(area: HTMLTextAreaElement | null, line: number): void {
  if (!area) return;
  const lines = area.value.split("\n");
  const begin = lines.slice(0, line - 1).reduce((sum, one) => sum + one.length + 1, 0);
  area.focus();
  area.setSelectionRange(begin, begin + (lines[line - 1]?.length ?? 0));
  const height = area.scrollHeight / Math.max(1, lines.length);
  area.closest(".code")?.scrollTo({ top: Math.max(0, (line - 6) * height) });
}

export function PlanText() {
  const area = useRef<HTMLTextAreaElement>(null);
  const problems = look.value?.problems ?? [];
  const byLine = new Map<number, string>();
  for (const { line, message } of problems) byLine.set(line, byLine.has(line) ? `${byLine.get(line)}; ${message}` : message);
  const lines = text.value.split("\n");
  return (
    <section class="plan-text" aria-label={t("plans_text")}>
      <div class="code">
        <div class="lines" aria-hidden="true">
          {lines.map((line, i) => {
            const message = byLine.get(i + 1);
            return (
              <div key={i} class={message ? "wrong" : ""} data-line={i + 1}>
                {line === "" ? " " : line}
                {message && <span class="said">{`  ✖ ${message}`}</span>}
              </div>
            );
          })}
        </div>
        <textarea ref={area} value={text.value} spellcheck={false} autocomplete="off" wrap="off" aria-label={t("plans_text")}
          aria-invalid={problems.length > 0} aria-describedby="plan-problems"
          onInput={(event) => typed(event.currentTarget.value)} />
      </div>
      <div id="plan-problems" role="status" data-testid="plan-problems">
        {look.value && problems.length === 0 && <p class="good">✓ {t("plans_no_problem")}</p>}
        {problems.length > 0 && (
          <ul class="findings">
            {problems.map(({ line, message }) => (
              <li key={`${line} ${message}`} class="error">
                {line > 0
                  ? <button class="quiet" onClick={() => goToLine(area.current, line)}>{t("plans_line", { line })}</button>
                  : <span class="sign">✖</span>} {message}
              </li>
            ))}
          </ul>
        )}
      </div>
    </section>
  );
}
