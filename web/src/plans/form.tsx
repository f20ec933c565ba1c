// The plan as a form. Its fields are those of the catalogue; each change is made in the text, which keeps its comments.
import { useEffect, useState } from "preact/hooks";
import { get } from "../api";
import { language, t } from "../texts";
import { Entry, Node, Option } from "./ask";
import { Field, field, TEXT } from "./fields";
import { Schedule } from "./schedule";
import { change, entry, lastDocument, look } from "./state";

/// One of the catalogue.
function Choice({ path, kind, node, label }: { path: string[]; kind: string; node?: Node; label: string }) {
  const [all, setAll] = useState<{ name: string; summary: string }[]>([]);
  useEffect(() => {
    get<{ name: string; summary: string }[]>("/api/catalogue?kind=" + kind).then((answer) => setAll(answer.body), () => undefined);
  }, [kind, language.value]);
  const summary = all.find((one) => one.name === node?.text)?.summary ?? "";
  const option: Option = { ...TEXT, name: label, type: "word", words: all.map((one) => one.name), description: summary };
  return <Field path={path} option={option} node={node} label={label} />;
}

function useEntry(kind: string, name: string | undefined): Entry | null {
  const [found, setFound] = useState<Entry | null>(null);
  useEffect(() => {
    let wanted = true;
    setFound(null);
    if (name) entry(kind, name).then((one) => wanted && setFound(one), () => undefined);
    return () => void (wanted = false);
  }, [kind, name, language.value]);
  return found;
}

/// What the catalogue accepts: what the plan states first, the others on demand.
function Options({ section, options, table }: { section: string; options: Option[]; table: Record<string, Node> }) {
  const [wanted, setWanted] = useState("");
  const given = options.filter((option) => option.name in table);
  const others = options.filter((option) => !(option.name in table) && `${option.name} ${option.description}`.toLowerCase().includes(wanted.toLowerCase()));
  const row = (option: Option) => <Field key={option.name} path={[section, option.name]} option={option} node={table[option.name]} />;
  return (
    <>
      {given.map(row)}
      {options.length > given.length && (
        <details class="more">
          <summary>{t("plans_more_options", { count: options.length - given.length })}</summary>
          {options.length - given.length > 8 && (
            <label class="search">{t("search")} <input type="search" value={wanted} onInput={(event) => setWanted(event.currentTarget.value)} /></label>
          )}
          {others.map(row)}
        </details>
      )}
    </>
  );
}

function Limits({ list }: { list: Node[] }) {
  return (
    <>
      {list.map((limit, i) => (
        <div class="limit" key={i} role="group" aria-label={t("plans_limit_of", { name: limit.table?.parameter?.text ?? "" })}>
          <Field path={["limit", i, "parameter"]} option={field("parameter")} node={limit.table?.parameter} label={t("plans_parameter")} />
          <Field path={["limit", i, "min"]} option={field("min")} node={limit.table?.min} label={t("minimum")} />
          <Field path={["limit", i, "max"]} option={field("max")} node={limit.table?.max} label={t("maximum")} />
          <button class="quiet" onClick={() => void change("delete", ["limit", i])}>{t("plans_delete")}</button>
        </div>
      ))}
      <button onClick={() => void change("add", ["limit"], { parameter: "bias", max: "1 deg/h" })}>{t("plans_add_limit")}</button>
    </>
  );
}

const SITE: [string, string][] = [["latitude", "deg"], ["longitude", "deg"], ["height", "m"], ["gravity", "m/s^2"]];

export function PlanForm() {
  const document = lastDocument.value;
  const method = document?.method?.text, model = document?.instrument?.table?.model?.text, kind = document?.rig?.table?.kind?.text;
  const ofMethod = useEntry("methods", method), ofModel = useEntry("models", model), ofRig = useEntry("rigs", kind);
  if (!document) return <section class="plan-form" aria-label={t("plans_form")} />;
  const table = (name: string) => document[name]?.table ?? {};
  const readable = look.value?.document != null;
  const section = (name: string, content: preact.ComponentChildren, open = true) => (
    <details class="section" open={open}><summary><h2>{t(`plans_section_${name}`)}</h2></summary>{content}</details>
  );
  return (
    <section class="plan-form" aria-label={t("plans_form")}>
      {!readable && <p class="notice problem">{t("plans_not_toml")}</p>}
      <fieldset disabled={!readable}>
        {section("plan", <>
          <Field path={["title"]} option={field("title")} node={document.title} label={t("plans_title")} />
          <Choice path={["method"]} kind="methods" node={document.method} label={t("plans_method")} />
        </>)}
        {section("instrument", <>
          <Choice path={["instrument", "model"]} kind="models" node={table("instrument").model} label={t("plans_model")} />
          <Field path={["instrument", "serial"]} option={field("serial")} node={table("instrument").serial} label={t("plans_serial")} />
          <Field path={["instrument", "rate"]} option={field("rate", "Hz")} node={table("instrument").rate} label={t("plans_rate")} />
        </>)}
        {section("site", SITE.map(([name, unit]) => (
          <Field key={name} path={["site", name]} option={field(name, unit)} node={table("site")[name]} label={t(`plans_${name}`)} />
        )), "site" in document)}
        {section("rig", <>
          <Choice path={["rig", "kind"]} kind="rigs" node={table("rig").kind} label={t("plans_rig")} />
          <Field path={["rig", "equipment"]} option={field("equipment")} node={table("rig").equipment} label={t("plans_equipment")} />
          {ofRig && <Options section="rig" options={ofRig.options} table={table("rig")} />}
        </>)}
        {section("schedule", <Schedule list={document.schedule?.list ?? []} axes={ofRig?.axes ?? []} />)}
        {ofMethod && section("settings", <Options section="settings" options={ofMethod.options} table={table("settings")} />)}
        {ofMethod?.roles && ofMethod.roles.length > 0 && section("channels", ofMethod.roles.map((role) => (
          <Field key={role.name} path={["channels", role.name]} node={table("channels")[role.name]}
            option={{ ...field(role.name), description: [role.description, `[${role.unit}]`].filter(Boolean).join(" ") }} />
        )), "channels" in document)}
        {section("limits", <Limits list={document.limit?.list ?? []} />, (document.limit?.list ?? []).length > 0)}
        {ofModel && section("truth", <><p class="hint">{t("plans_truth_hint")}</p><Options section="truth" options={ofModel.options} table={table("truth")} /></>, false)}
      </fieldset>
    </section>
  );
}
