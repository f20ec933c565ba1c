// The standard uncertainty of the estimate so far, beside the one that the plan will have reached at its end.
import { useEffect, useMemo, useState } from "preact/hooks";
import { get } from "../api";
import type { Figure, Series } from "../results/answers";
import { FigureView } from "../results/figure";
import type { Zoom } from "../results/view";
import "../results/results.css";
import { language, t } from "../texts";
import type { Point } from "./run_data";

type Style = Pick<Series, "colour" | "dark" | "dashes">;

export interface Predicted {
  ready: boolean;
  rows: { name: string; unit: string; sd: number; text: string }[];
  styles: [Style, Style];
}

/// What the plan of a run predicts; null until it is known.
export function usePredicted(run: string): Predicted | null {
  const [predicted, setPredicted] = useState<Predicted | null>(null);
  useEffect(() => {
    const control = new AbortController();
    let timer: ReturnType<typeof setTimeout>;
    const ask = async () => {
      try {
        const { body } = await get<Predicted>(`/api/station/run/predicted?run=${encodeURIComponent(run)}`, control.signal);
        if (control.signal.aborted) return;
        if (body.ready) setPredicted(body);
        else timer = setTimeout(() => void ask(), 1000);
      } catch {
        if (!control.signal.aborted) timer = setTimeout(() => void ask(), 5000);
      }
    };
    setPredicted(null);
    void ask();
    return () => {
      control.abort();
      clearTimeout(timer);
    };
  }, [run]);
  return predicted;
}

export function predictedOf(predicted: Predicted | null, name: string, unit: string): Predicted["rows"][number] | undefined {
  return predicted?.rows.find((row) => row.name === name && row.unit === unit);
}

function figureOf(name: string, unit: string, points: Point[], predicted: Predicted): Figure {
  const known = points.filter((point) => point[3] !== null && point[3] > 0);
  const x = known.map((point) => point[0]), first = x[0] ?? 0, last = x[x.length - 1] ?? 1;
  const end = predictedOf(predicted, name, unit);
  const line = (title: string, style: Style, at: number[], y: (number | null)[]): Series => ({ name: title, points: false, ...style, x: at, y });
  return {
    name,
    x: { name: t("station_time"), unit: "s", logarithmic: false },
    y: { name: t("station_sd_of", { name }), unit, logarithmic: true },
    series: [
      line(t("station_sd_now"), predicted.styles[0], x, known.map((point) => point[3])),
      ...(end && end.sd > 0 ? [line(t("station_sd_predicted"), predicted.styles[1], [first, last], [end.sd, end.sd])] : []),
    ],
    notes: [t("station_sd_hint")],
  };
}

export function Convergence({ name, unit, points, predicted }: { name: string; unit: string; points: Point[]; predicted: Predicted }) {
  const [hidden, setHidden] = useState<number[]>([]);
  const [zoom, setZoom] = useState<Zoom | null>(null);
  const figure = useMemo(() => figureOf(name, unit, points, predicted), [name, unit, points, predicted, language.value]);
  if (figure.series[0]!.x.length < 2) return null;
  return (
    <div data-testid="convergence">
      <FigureView figure={figure} hidden={hidden} zoom={zoom} drawing=""
        onHide={(series) => setHidden(hidden.includes(series) ? [] : [series])} onZoom={setZoom} />
    </div>
  );
}
