// Plans of the folder, and those that come with the program to start from.
import { useEffect, useState } from "preact/hooks";
import { get, problemsOf } from "../api";
import { listing } from "../jobs";
import { date, language, t } from "../texts";
import { ListedPlan, Template } from "./ask";
import { openPlan, PLANS } from "./state";

interface Listing {
  plans: ListedPlan[];
  templates: Template[];
}

function PlanLink({ to, children }: { to: { file?: string; template?: string }; children: string }) {
  const address = PLANS + "?" + new URLSearchParams(to as Record<string, string>).toString();
  const open = (event: MouseEvent) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    openPlan(to);
  };
  return <a href={address} onClick={open}>{children}</a>;
}

export function PlanList() {
  const [all, setAll] = useState<Listing | null>(null);
  const [problems, setProblems] = useState<string[]>([]);
  const [wanted, setWanted] = useState("");
  useEffect(() => {
    get<Listing>("/api/plans").then((answer) => setAll(answer.body), (error) => setProblems(problemsOf(error)));
  }, [listing.value, language.value]);
  const words = wanted.toLowerCase().split(/\s+/).filter(Boolean);
  const matches = (...texts: string[]) => words.every((word) => texts.join(" ").toLowerCase().includes(word));
  const plans = (all?.plans ?? []).filter((plan) => matches(plan.name, plan.title, plan.method, plan.instrument, plan.rig));
  const templates = (all?.templates ?? []).filter((plan) => matches(plan.name, plan.title, plan.method));
  return (
    <section class="plan-list">
      <header class="list-head">
        <h1>{t("plans_room")}</h1>
        <label class="search">
          {t("search")}
          <input type="search" value={wanted} onInput={(event) => setWanted(event.currentTarget.value)} />
        </label>
      </header>
      {problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      <h2>{t("plans_of_folder")}</h2>
      {all && all.plans.length === 0 && <p class="notice">{t("plans_none")}</p>}
      {plans.length > 0 && (
        <table class="list" data-testid="plans">
          <thead>
            <tr>
              <th scope="col">{t("file")}</th>
              <th scope="col" class="wide">{t("plans_method")}</th>
              <th scope="col" class="wide">{t("plans_rig")}</th>
              <th scope="col" class="wide">{t("changed")}</th>
            </tr>
          </thead>
          <tbody>
            {plans.map((plan) => (
              <tr key={plan.name}>
                <th scope="row"><PlanLink to={{ file: plan.name }}>{plan.name}</PlanLink><small>{plan.title}</small></th>
                <td class="wide">{plan.method}</td>
                <td class="wide">{plan.rig}</td>
                <td class="wide">{date(plan.modified)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      <h2>{t("plans_templates")}</h2>
      <p class="hint">{t("plans_templates_hint")}</p>
      <ul class="templates" data-testid="templates">
        {templates.map((plan) => (
          <li key={plan.name}>
            <PlanLink to={{ template: plan.name }}>{plan.title}</PlanLink>
            <small>{plan.name}</small>
          </li>
        ))}
      </ul>
    </section>
  );
}
