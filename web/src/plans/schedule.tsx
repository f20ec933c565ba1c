// The segments of the schedule as a table: what each axis does, how long.
import { useState } from "preact/hooks";
import { problemsOf } from "../api";
import { t } from "../texts";
import { Axis, Node } from "./ask";
import { Field, field } from "./fields";
import { change, lastSchedule, run, time } from "./state";

const positionUnit = (axis: Axis) => axis.unit;
const intervalUnit = (axis: Axis) => (axis.unit === "degC" ? "K" : axis.unit);
const speedUnit = (axis: Axis) => `${intervalUnit(axis)}/s`;

/// A motion of a kind to begin with.
function begun(kind: string, axis: Axis): unknown {
  switch (kind) {
    case "rate":
      return { rate: `1 ${speedUnit(axis)}` };
    case "slew":
    case "ramp":
      return { [kind]: `1 ${speedUnit(axis)}`, to: axis.unit === "degC" ? "20 degC" : `90 ${axis.unit}` };
    case "sine":
      return { sine: { amplitude: `1 ${intervalUnit(axis)}`, frequency: "1 Hz" } };
    case "sweep":
      return { sweep: { amplitude: `1 ${intervalUnit(axis)}`, from: "10 Hz", to: "100 Hz" } };
    case "random":
      return { random: { frequency: ["20 Hz", "2000 Hz"], psd: [`1e-3 (${intervalUnit(axis)})^2/Hz`, `1e-3 (${intervalUnit(axis)})^2/Hz`] } };
    default:
      return { [kind]: axis.unit === "degC" ? "20 degC" : `0 ${axis.unit}` };
  }
}

/// The values of a motion: where they are in its table, and their units.
function parts(kind: string, axis: Axis): [string[], string][] {
  switch (kind) {
    case "hold":
    case "dwell":
      return [[[kind], positionUnit(axis)]];
    case "rate":
      return [[[kind], speedUnit(axis)]];
    case "slew":
    case "ramp":
      return [[[kind], speedUnit(axis)], [["to"], positionUnit(axis)]];
    case "sine":
      return [[["sine", "amplitude"], intervalUnit(axis)], [["sine", "frequency"], "Hz"]];
    case "sweep":
      return [[["sweep", "amplitude"], intervalUnit(axis)], [["sweep", "from"], "Hz"], [["sweep", "to"], "Hz"]];
    default:
      return [];
  }
}

function MotionCell({ index, axis, node, label }: { index: number; axis: Axis; node?: Node; label: string }) {
  const kind = axis.motions.find((one) => node?.table && one in node.table) ?? "";
  const [refused, setRefused] = useState<string[]>([]);
  const choose = (next: string) => {
    const path = ["schedule", index, axis.name];
    (next === "" ? change("remove", path) : change("set", path, begun(next, axis))).then(() => setRefused([]), (error) => setRefused(problemsOf(error)));
  };
  const inside = (path: string[]) => path.reduce<Node | undefined>((one, key) => one?.table?.[key], node);
  return (
    <span class="motion">
      <select value={kind} aria-label={t("plans_motion_of", { axis: axis.name, segment: label })} onChange={(event) => choose(event.currentTarget.value)}>
        <option value="">{node ? "?" : "–"}</option>
        {axis.motions.map((one) => <option key={one} value={one}>{one}</option>)}
      </select>
      {parts(kind, axis).map(([path, unit]) => (
        <Field key={path.join(".")} bare path={["schedule", index, axis.name, ...path]} node={inside(path)}
          option={field(path[path.length - 1], unit)} label={`${label}, ${axis.name}, ${path[path.length - 1]}`} />
      ))}
      {refused.map((problem) => <span class="problem" key={problem}>{problem}</span>)}
    </span>
  );
}

/// "1, 2, 3" as numbers of power-ups.
function RunCell({ index, node, label }: { index: number; node?: Node; label: string }) {
  const commit = (written: string) => {
    const numbers = written.split(/[\s,]+/).filter(Boolean).map(Number);
    if (written.trim() === (node?.text ?? "")) return;
    if (numbers.length === 0) void change("remove", ["schedule", index, "run"]);
    else void change("set", ["schedule", index, "run"], numbers.length === 1 ? numbers[0] : numbers);
  };
  return <input class="run" type="text" inputMode="numeric" value={node?.text ?? ""} placeholder="1" aria-label={t("plans_run_of", { segment: label })}
    onChange={(event) => commit(event.currentTarget.value)} />;
}

/// The segment where the picture is, by its label.
function current(): string | null {
  const now = lastSchedule.value?.runs.find((one) => one.run === run.value);
  return now?.segments.find((segment) => time.value < segment.begin + segment.duration)?.label ?? null;
}

export function Schedule({ list, axes }: { list: Node[]; axes: Axis[] }) {
  const [more, setMore] = useState<string[]>([]);
  const [refused, setRefused] = useState<string[]>([]);
  const used = axes.filter((axis) => !axis.name.startsWith("mount_") || more.includes(axis.name) || list.some((node) => node.table && axis.name in node.table));
  const hidden = axes.filter((axis) => !used.includes(axis));
  const runs = list.some((node) => node.table && "run" in node.table);
  const playing = current();
  const make = (kind: string, path: (string | number)[], value?: unknown) =>
    void change(kind, path, value).then(() => setRefused([]), (error) => setRefused(problemsOf(error)));
  return (
    <>
      {refused.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      <div class="scroll segments-table" tabIndex={0} role="region" aria-label={t("plans_section_schedule")}>
        <table>
          <thead>
            <tr>
              <th scope="col">{t("plans_label")}</th>
              <th scope="col">{t("duration")}</th>
              {runs && <th scope="col">{t("plans_run")}</th>}
              {used.map((axis) => <th scope="col" key={axis.name} title={axis.description}>{axis.name}</th>)}
              <th scope="col">{t("plans_actions")}</th>
            </tr>
          </thead>
          <tbody>
            {list.map((node, i) => {
              const label = node.table?.label?.text ?? String(i + 1);
              return (
                <tr key={i} class={label === playing ? "now" : ""} data-segment={i}>
                  <td><Field bare path={["schedule", i, "label"]} option={field("label")} node={node.table?.label} label={t("plans_label_of", { number: i + 1 })} /></td>
                  <td><Field bare path={["schedule", i, "duration"]} option={field("duration", "s")} node={node.table?.duration} label={t("plans_duration_of", { segment: label })} /></td>
                  {runs && <td><RunCell index={i} node={node.table?.run} label={label} /></td>}
                  {used.map((axis) => <td key={axis.name}><MotionCell index={i} axis={axis} node={node.table?.[axis.name]} label={label} /></td>)}
                  <td class="actions">
                    <button class="quiet" aria-label={t("plans_copy_of", { segment: label })} title={t("plans_copy")} onClick={() => make("copy", ["schedule", i])}>⧉</button>
                    <button class="quiet" disabled={i === 0} aria-label={t("plans_up_of", { segment: label })} title={t("plans_up")} onClick={() => make("swap", ["schedule", i - 1])}>↑</button>
                    <button class="quiet" aria-label={t("plans_delete_of", { segment: label })} title={t("plans_delete")} onClick={() => make("delete", ["schedule", i])}>✕</button>
                  </td>
                </tr>
              );
            })}
          </tbody>
        </table>
      </div>
      <div class="toolbar">
        <button onClick={() => make("add", ["schedule"], { label: t("plans_new_segment"), duration: "1 min" })}>{t("plans_add_segment")}</button>
        {hidden.length > 0 && (
          <select aria-label={t("plans_more_axes")} value="" onChange={(event) => setMore([...more, event.currentTarget.value])}>
            <option value="">{t("plans_more_axes")}</option>
            {hidden.map((axis) => <option key={axis.name} value={axis.name}>{axis.name}</option>)}
          </select>
        )}
      </div>
    </>
  );
}
