// The fields of a plan: what each shows, and how a change of one is made in the text.
import { useEffect, useState } from "preact/hooks";
import { problemsOf } from "../api";
import { t } from "../texts";
import { Node, Option } from "./ask";
import { change, look } from "./state";

const NUMBER = /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i;

/// What a person wrote, as a value of the plan: numbers of quantities get the unit that the field shows.
export function valueOf(written: string, option: Pick<Option, "type" | "unit">): unknown {
  const text = written.trim();
  if (option.type === "integer" && /^[-+]?\d+$/.test(text)) return Number(text);
  if (option.type === "flag") return text === "true";
  if (option.type === "quantity" && option.unit && option.unit !== "1" && NUMBER.test(text)) return `${text} ${option.unit}`;
  return text;
}

function rangeOf(option: Option): string {
  const from = option.min !== undefined ? `${option.min_excluded ? ">" : "≥"} ${option.min}` : "";
  const to = option.max !== undefined ? `${option.max_excluded ? "<" : "≤"} ${option.max}` : "";
  return [from, to].filter(Boolean).join(", ");
}

function problemsAt(line: number | undefined): string[] {
  if (!line) return [];
  return (look.value?.problems ?? []).filter((problem) => problem.line === line).map((problem) => problem.message);
}

interface FieldProps {
  path: (string | number)[];
  option: Option;
  node?: Node;
  label?: string;
  /// Only the input, for a table that has headings.
  bare?: boolean;
}

/// A value of the plan. Empty: it is not in the plan, and the default holds.
export function Field({ path, option, node, label, bare }: FieldProps) {
  const [draft, setDraft] = useState<string | null>(null);
  const [refused, setRefused] = useState<string[]>([]);
  const now = node?.text ?? "";
  useEffect(() => setDraft(null), [now, node?.line]);
  const commit = async (written: string) => {
    if (written.trim() === now) return setDraft(null);
    setDraft(written);
    try {
      await (written.trim() === "" ? change("remove", path) : change("set", path, valueOf(written, option)));
      setRefused([]);
    } catch (error) {
      setRefused(problemsOf(error));
    }
  };
  const problems = [...refused, ...problemsAt(node?.line)];
  const name = label ?? option.name, wrong = problems.length > 0;
  const id = "plan-" + path.join("-").replace(/[^\w-]/g, "_");
  const hint = option.default ?? (option.unit && option.unit !== "1" ? option.unit : "");
  const words = option.type === "flag" ? ["true", "false"] : option.type === "word" ? option.words : undefined;
  const input = words
    ? (
      <select id={id} value={draft ?? now} aria-label={bare ? name : undefined} aria-invalid={wrong} aria-describedby={wrong ? `${id}-said` : undefined}
        onChange={(event) => void commit(event.currentTarget.value)}>
        <option value="">{option.default ? t("plans_default", { value: option.default }) : t("plans_not_set")}</option>
        {words.map((word) => <option key={word} value={word}>{word}</option>)}
        {now !== "" && !words.includes(now) && <option value={now}>{now}</option>}
      </select>
    )
    : (
      <input id={id} type="text" value={draft ?? now} placeholder={hint} autocomplete="off" spellcheck={false}
        aria-label={bare ? name : undefined} aria-invalid={wrong} aria-describedby={wrong ? `${id}-said` : undefined}
        onInput={(event) => setDraft(event.currentTarget.value)} onChange={(event) => void commit(event.currentTarget.value)} />
    );
  const said = wrong && <span class="problem" id={`${id}-said`}>{problems.join("; ")}</span>;
  if (bare) return <span class={wrong ? "field bare wrong" : "field bare"}>{input}{said}</span>;
  return (
    <div class={wrong ? "field wrong" : "field"}>
      <label for={id}>{name}</label>
      {input}
      <small>{[option.description, rangeOf(option), option.unit && option.unit !== "1" ? `[${option.unit}]` : ""].filter(Boolean).join(" · ")}</small>
      {said}
    </div>
  );
}

export const TEXT: Option = { name: "", type: "text", default: null, description: "" };
export const field = (name: string, unit?: string): Option => ({ ...TEXT, name, type: unit ? "quantity" : "text", unit });
