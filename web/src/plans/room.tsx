// The plans of the folder, or one of them.
import "./plans.css";
import { PlanEditor } from "./editor";
import { PlanList } from "./list";
import { file, template } from "./state";

export function PlansRoom() {
  return file.value === null ? <PlanList /> : <PlanEditor key={`${file.value}?${template.value ?? ""}`} />;
}
