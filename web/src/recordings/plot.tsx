// One channel over a span: bars from the least to the greatest value, or the samples themselves.
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import type { ChannelView, Finding, Mark } from "../api";
import type { Span } from "./view";

/// Width of the axis of values: one for all rows, so that their times stand under each other.
export const GUTTER = 78;
const RIGHT = 12;

export interface Drawn {
  span: Span;
  selection: Span | null;
  cursors: { a?: number; b?: number };
  window?: Span;
  marks: Mark[];
  findings: Finding[];
}

interface Props {
  view: ChannelView | undefined;
  drawn: Drawn;
  label: string;
  height: number;
  axis: boolean;
  axisText: (time: number, step: number) => string;
  onSelect: (span: Span | null) => void;
  onPoint?: (time: number, second: boolean) => void;
  onHover?: (time: number | null) => void;
}

function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/// What stands behind the curves: every second segment, the selection.
function drawBehind(plot: uPlot, drawn: Drawn): void {
  const { ctx, bbox } = plot;
  const across = (span: Span, fill: string) => {
    const left = Math.max(plot.valToPos(span.from, "x", true), bbox.left);
    const right = Math.min(plot.valToPos(span.to, "x", true), bbox.left + bbox.width);
    if (right <= left) return;
    ctx.fillStyle = fill;
    ctx.fillRect(left, bbox.top, Math.max(right - left, 1), bbox.height);
  };
  drawn.marks.forEach((mark, i) => {
    if (i % 2 === 1) across({ from: mark.begin, to: mark.end }, colour("--band"));
  });
  if (drawn.selection) across(drawn.selection, colour("--selection"));
  if (drawn.window) across(drawn.window, colour("--selection"));
}

/// What stands before them: cursors with their letters, findings as ticks at the top.
function drawBefore(plot: uPlot, drawn: Drawn): void {
  const { ctx, bbox } = plot;
  const within = (x: number) => x >= bbox.left && x <= bbox.left + bbox.width;
  const scale = devicePixelRatio;
  ctx.save();
  for (const [letter, time] of Object.entries(drawn.cursors)) {
    const x = plot.valToPos(time, "x", true);
    if (!within(x)) continue;
    ctx.strokeStyle = ctx.fillStyle = colour("--cursor");
    ctx.lineWidth = scale;
    ctx.setLineDash(letter === "a" ? [] : [4 * scale, 3 * scale]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.font = `bold ${12 * scale}px system-ui, sans-serif`;
    ctx.textBaseline = "top";
    ctx.textAlign = "left";
    ctx.fillText(letter.toUpperCase(), x + 4 * scale, bbox.top + 10 * scale);
  }
  ctx.setLineDash([]);
  for (const finding of drawn.findings) {
    const time = (finding.worst ?? finding.first)?.time;
    if (time === undefined) continue;
    const x = plot.valToPos(time, "x", true);
    if (!within(x)) continue;
    ctx.fillStyle = colour(finding.severity === "info" ? "--info" : "--warning");
    ctx.beginPath();
    ctx.moveTo(x - 5 * scale, bbox.top);
    ctx.lineTo(x + 5 * scale, bbox.top);
    ctx.lineTo(x, bbox.top + 8 * scale);
    ctx.fill();
  }
  ctx.restore();
}

function data(view: ChannelView | undefined): uPlot.AlignedData {
  if (!view) return [[], [], []];
  const middle = !view.samples && view.times.length > 1 ? 0.5 * (view.times[1] - view.times[0]) : 0;
  return [Array.from(view.times, (time) => time + middle), view.low, view.high] as uPlot.AlignedData;
}

function options(props: () => Props, width: number): uPlot.Options {
  const axis = {
    stroke: () => colour("--text"),
    grid: { stroke: () => colour("--grid"), width: 1 },
    ticks: { stroke: () => colour("--grid"), width: 1 },
    font: "12px system-ui, sans-serif",
  };
  const line = { stroke: () => colour("--curve"), width: 1, points: { show: false }, spanGaps: false };
  return {
    width,
    height: props().height,
    padding: [6, RIGHT, props().axis ? 0 : 6, 0],
    legend: { show: false },
    scales: { x: { time: false, range: () => [props().drawn.span.from, props().drawn.span.to] } },
    cursor: {
      sync: { key: "rows", scales: ["x", null] },
      drag: { x: true, y: false, setScale: false, dist: 4 },
      points: { show: false },
      y: false,
      bind: { dblclick: () => null },
    },
    axes: [
      {
        ...axis,
        show: props().axis,
        values: (_plot, splits) =>
          splits.map((time) => props().axisText(time, splits.length > 1 ? splits[1] - splits[0] : 1)),
      },
      { ...axis, size: GUTTER, values: (_plot, splits) => splits.map((value) => String(Number(value.toPrecision(9)))) },
    ],
    series: [{}, { ...line }, { ...line }],
    bands: [{ series: [2, 1], fill: () => colour("--curve-fill") }],
    hooks: {
      drawClear: [(plot) => drawBehind(plot, props().drawn)],
      draw: [(plot) => drawBefore(plot, props().drawn)],
      setSelect: [
        (plot) => {
          const { left, width: wide } = plot.select;
          if (wide > 3)
            props().onSelect({ from: plot.posToVal(left, "x"), to: plot.posToVal(left + wide, "x") });
          if (wide > 0) plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        },
      ],
      setCursor: [
        (plot) => {
          const left = plot.cursor.left ?? -1;
          if (plot.cursor.event) props().onHover?.(left >= 0 ? plot.posToVal(left, "x") : null);
        },
      ],
    },
  };
}

export function Plot(props: Props) {
  const place = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const latest = useRef(props);
  latest.current = props;

  useEffect(() => {
    const element = place.current!;
    const made = new uPlot(options(() => latest.current, element.clientWidth || 600), data(latest.current.view), element);
    plot.current = made;
    const resized = new ResizeObserver(() => made.setSize({ width: element.clientWidth, height: latest.current.height }));
    resized.observe(element);
    const theme = matchMedia("(prefers-color-scheme: dark)");
    const redraw = () => made.redraw(false);
    theme.addEventListener("change", redraw);
    // A drag ends with a click too: only what did not move is a point.
    let pressed = 0;
    made.over.addEventListener("mousedown", (event) => (pressed = event.clientX));
    made.over.addEventListener("click", (event) => {
      const left = made.cursor.left ?? -1;
      if (left >= 0 && Math.abs(event.clientX - pressed) < 4)
        latest.current.onPoint?.(made.posToVal(left, "x"), event.shiftKey);
    });
    return () => {
      theme.removeEventListener("change", redraw);
      resized.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, []);

  useEffect(() => plot.current?.setData(data(props.view)), [props.view]);
  useEffect(() => {
    plot.current?.setScale("x", { min: props.drawn.span.from, max: props.drawn.span.to });
    plot.current?.redraw(false);
  }, [props.drawn]);

  return <div class="plot" ref={place} role="img" aria-label={props.label} style={{ height: `${props.height}px` }} />;
}
