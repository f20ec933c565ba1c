// A figure of a result, drawn live from the description that the report is drawn from.
import { useEffect, useRef, useState } from "preact/hooks";
import uPlot from "uplot";
import { t } from "../texts";
import type { Axis, Figure, Link, Series } from "./answers";
import { drawCells, drawColouredPoints, inPlot, ScaleBar, valueAt } from "./colours";
import { linkedPoints, PointLinks } from "./point_links";
import { labelledTicks, logarithmicTicks, tickText } from "./log_axis";
import type { Zoom } from "./view";

interface Props {
  figure: Figure;
  hidden: number[];
  zoom: Zoom | null;
  /// Texts of the numbers of x, where these are numbers of results.
  names?: string[];
  /// Where points lead that have links.
  links?: { addressOf: (link: Link) => { href: string; name: string }; follow: (event: MouseEvent, link: Link) => void };
  onHide: (series: number) => void;
  onZoom: (zoom: Zoom | null) => void;
}

const dark = matchMedia("(prefers-color-scheme: dark)");

function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

export function titleOf(axis: Axis): string {
  return axis.unit === "1" ? axis.name : `${axis.name} [${axis.unit}]`;
}

/// Points of a series in order of x. A line is drawn in the order of its points: one that runs back cannot be drawn so.
function ordered(series: Series): number[] {
  const places = series.x.map((_, i) => i).filter((i) => series.x[i] !== null);
  return series.points ? places.sort((a, b) => series.x[a]! - series.x[b]!) : places;
}

export function canBeLive(figure: Figure): boolean {
  return figure.series.every((series) => {
    if (series.points) return true;
    const x = series.x.filter((value): value is number => value !== null);
    return x.every((value, i) => i === 0 || value >= x[i - 1]!);
  });
}

/// All series on one list of x; where a series has no point there it is undefined, which is no gap.
function data(figure: Figure): uPlot.AlignedData {
  const tables = figure.series.map((series) => {
    const places = ordered(series);
    const column = (values: (number | null)[]) => places.map((i) => values[i] ?? null);
    return [column(series.x), column(series.y), ...(series.lower ? [column(series.lower), column(series.upper!)] : [])];
  });
  // The corners of a map are a series that is not drawn, so that the axes have room for its cells.
  const { map } = figure;
  if (map) tables.push([[map.x[0]!, map.x[map.x.length - 1]!], [map.y[0]!, map.y[map.y.length - 1]!]]);
  return uPlot.join(tables as uPlot.AlignedData[]);
}

/// Number of the column of y of each series; the edges of its band are behind it.
function columnsOf(figure: Figure): number[] {
  let next = 1;
  return figure.series.map((series) => {
    const own = next;
    next += series.lower ? 3 : 1;
    return own;
  });
}

function pen(series: Series): string {
  return dark.matches ? series.dark : series.colour;
}

/// Bars from the lower to the upper edge of the points.
function drawBars(plot: uPlot, figure: Figure, columns: number[], hidden: number[]): void {
  const { bbox } = plot;
  inPlot(plot, (ctx) => {
    figure.series.forEach((series, k) => {
      if (!series.points || !series.lower || hidden.includes(k)) return;
      ctx.strokeStyle = pen(series);
      ctx.lineWidth = 1.2 * devicePixelRatio;
      ctx.beginPath();
      const [x, lower, upper] = [plot.data[0], plot.data[columns[k]! + 1]!, plot.data[columns[k]! + 2]!];
      for (let i = 0; i < x.length; ++i) {
        const low = lower[i], high = upper[i];
        if (low === null || low === undefined || high === null || high === undefined) continue;
        const at = plot.valToPos(x[i]!, "x", true);
        const bottom = figure.y.logarithmic && low <= 0 ? bbox.top + bbox.height : plot.valToPos(low, "y", true);
        ctx.moveTo(at, bottom);
        ctx.lineTo(at, plot.valToPos(high, "y", true));
      }
      ctx.stroke();
    });
  });
}

function seriesOptions(figure: Figure, hidden: number[]): uPlot.Series[] {
  const all: uPlot.Series[] = [{}];
  figure.series.forEach((series, k) => {
    const show = !hidden.includes(k), stroke = () => pen(series);
    const dash = series.dashes ? series.dashes.split(" ").map(Number) : undefined;
    all.push(series.points
      ? { show, stroke, paths: () => null, points: { show: !series.z, size: 6, fill: stroke, stroke } }
      : { show, stroke, width: 1.6, dash, points: { show: false } });
    if (series.lower) for (let edge = 0; edge < 2; ++edge) all.push({ show, stroke: "transparent", width: 0, points: { show: false }, ...(series.points && { paths: () => null }) });
  });
  if (figure.map) all.push({ stroke: "transparent", paths: () => null, points: { show: false } });
  return all;
}

/// A logarithmic axis ends a little outside of the values; uPlot would go on to the next power of ten.
function room(props: () => Props): uPlot.Scale.Range {
  return (_plot, low, high) => {
    if (!(low > 0 && high > 0)) return [0.1, 1];
    const by = props().zoom && high > low ? 1 : 1.15; // an axis without length has no ticks
    return [low / by, high * by];
  };
}

const logarithmicAxis: Partial<uPlot.Axis> = {
  splits: (_plot, _axis, least, greatest) => logarithmicTicks(least, greatest),
  filter: (_plot, ticks) => labelledTicks(ticks),
  values: (_plot, ticks: (number | null)[]) => ticks.map(tickText),
};

function options(props: () => Props, width: number): uPlot.Options {
  const { figure, hidden } = props();
  const columns = columnsOf(figure);
  const axis = {
    stroke: () => colour("--text"),
    grid: { stroke: () => colour("--grid"), width: 1 },
    ticks: { stroke: () => colour("--grid"), width: 1 },
    font: "12px system-ui, sans-serif",
    labelSize: 20,
  };
  // A long name has smaller letters: it must fit along its axis. A Chinese letter is as wide as two others.
  const widthOf = (text: string) => text.length + (text.match(/[\u2e80-\uffef]/g)?.length ?? 0);
  const labelFont = (axis: Axis) => `${widthOf(titleOf(axis)) > 40 ? 10 : 12}px system-ui, sans-serif`;
  const bands = figure.series.flatMap((series, k) =>
    series.lower && !series.points ? [{ series: [columns[k]! + 2, columns[k]! + 1] as [number, number], fill: () => pen(series) + "30" }] : []);
  return {
    width,
    height: Math.min(420, Math.max(260, 0.6 * width)),
    padding: [10, 26, 0, 0],
    legend: { show: false },
    scales: {
      x: { time: false, distr: figure.x.logarithmic ? 3 : 1, ...(figure.x.logarithmic && { range: room(props) }), ...(props().names && { range: (_plot, low, high) => [low - 0.5, high + 0.5] as [number, number] }) },
      y: { distr: figure.y.logarithmic ? 3 : 1, ...(figure.y.logarithmic && { range: room(props) }) },
    },
    cursor: { drag: { x: true, y: false, setScale: false, dist: 4 }, bind: { dblclick: () => () => { props().onZoom(null); return null; } } },
    axes: [
      { ...axis, label: titleOf(figure.x), labelFont: labelFont(figure.x), ...(figure.x.logarithmic && logarithmicAxis), ...(props().names && { incrs: [1, 2, 5, 10, 20, 50, 100] }) },
      {
        ...axis,
        label: titleOf(figure.y),
        labelFont: labelFont(figure.y),
        size: (_plot, texts) => 18 + 7 * Math.max(3, ...(texts ?? []).map((text) => String(text ?? "").length)),
        ...(figure.y.logarithmic ? logarithmicAxis : { values: (_plot: uPlot, splits: number[]) => splits.map((value) => String(Number(value.toPrecision(9)))) }),
      },
    ],
    series: seriesOptions(figure, hidden),
    bands,
    hooks: {
      drawAxes: [(plot) => drawCells(plot, figure)],
      draw: [
        (plot) => {
          drawBars(plot, figure, columns, props().hidden);
          drawColouredPoints(plot, figure, props().hidden);
        },
      ],
      setSelect: [
        (plot) => {
          const { left, width: wide } = plot.select;
          if (wide > 3) props().onZoom({ from: plot.posToVal(left, "x"), to: plot.posToVal(left + wide, "x") });
          if (wide > 0) plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        },
      ],
    },
  };
}

function Live(props: Props) {
  const place = useRef<HTMLDivElement>(null);
  const latest = useRef(props);
  latest.current = props;
  const [theme, setTheme] = useState(dark.matches);
  const [plot, setPlot] = useState<{ made: uPlot; width: number } | null>(null);
  const [pointed, setPointed] = useState("");
  useEffect(() => {
    const changed = () => setTheme(dark.matches);
    dark.addEventListener("change", changed);
    return () => dark.removeEventListener("change", changed);
  }, []);
  useEffect(() => {
    const element = place.current!;
    const made = new uPlot(options(() => latest.current, element.clientWidth || 600), data(props.figure), element);
    if (props.zoom) made.setScale("x", { min: props.zoom.from, max: props.zoom.to });
    element.dataset.drawn = "yes";
    const seen = () => setPlot({ made, width: made.width });
    seen();
    if (props.figure.map) made.over.addEventListener("mousemove", () => setPointed(textAt(props.figure, made)));
    const resized = new ResizeObserver(() => {
      const width = element.clientWidth;
      if (width > 0 && width !== made.width) {
        made.setSize({ width, height: made.height });
        requestAnimationFrame(seen); // when it is drawn anew
      }
    });
    resized.observe(element);
    return () => {
      resized.disconnect();
      setPlot(null);
      made.destroy();
    };
  }, [props.figure, props.zoom, props.hidden.join(), theme]);
  const { figure, links } = props;
  const points = links ? linkedPoints(figure, props.hidden) : [];
  return (
    <>
      <div class="figure-frame">
        <div class="figure-plot" ref={place} role="img" aria-label={t("results_plot_of", { y: figure.z?.name ?? figure.y.name, x: figure.x.name })} />
        {plot && links && points.length > 0 && <PointLinks plot={plot.made} points={points} {...links} />}
      </div>
      {figure.z && <ScaleBar scale={figure.z} />}
      {figure.map && <p class="hint pointed">{pointed || "\u00a0"}</p>}
    </>
  );
}

/// Place and value of the cell below the pointer.
function textAt(figure: Figure, plot: uPlot): string {
  const { left = -1, top = -1 } = plot.cursor;
  if (left < 0 || top < 0) return "";
  const x = plot.posToVal(left, "x"), y = plot.posToVal(top, "y"), value = valueAt(figure, x, y);
  const part = (axis: Axis, number: number) => `${axis.name} ${Number(number.toPrecision(3))}${axis.unit === "1" ? "" : ` ${axis.unit}`}`;
  return [part(figure.x, x), part(figure.y, y), ...(value === null ? [] : [part(figure.z!, value)])].join(", ").replace(/-/g, "−");
}

function Legend({ figure, hidden, onHide }: Props) {
  return (
    <ul class="figure-legend">
      {figure.series.map((series, k) => (
        <li key={k}>
          <button class="quiet" aria-pressed={!hidden.includes(k)} onClick={() => onHide(k)}>
            <svg width="26" height="10" aria-hidden="true">
              {series.points
                ? <circle cx="13" cy="5" r="3" fill={pen(series)} />
                : <path d="M0 5h26" stroke={pen(series)} stroke-width="2" stroke-dasharray={series.dashes || undefined} />}
            </svg>
            {" "}{series.name}
          </button>
        </li>
      ))}
    </ul>
  );
}

/// `drawing`: address of the same figure as a drawing, for one that runs back and forth.
export function FigureView(props: Props & { drawing: string }) {
  const { figure, zoom, onZoom } = props;
  const bands = figure.series.filter((series) => series.band);
  return (
    <figure class="result-figure">
      {canBeLive(figure) ? <Live {...props} /> : <img class="figure" src={props.drawing} alt={figure.name} />}
      <Legend {...props} />
      <figcaption>
        <strong>{t("results_caption", { name: props.names ? figure.y.name : figure.name })}</strong>
        {bands.length > 0 && ` ${t("results_bands", { what: [...new Set(bands.map((series) => series.band))].join(t("results_next")) })}`}
        {!props.names && figure.notes.map((note) => ` ${t("results_note", { note })}`)}
        {zoom ? <button class="quiet" onClick={() => onZoom(null)}>{t("show_all")}</button> : canBeLive(figure) && <small> {t("results_zoom_hint")}</small>}
      </figcaption>
    </figure>
  );
}
