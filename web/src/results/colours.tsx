// Numbers as colours: cells of a map, coloured points, and their scale.
import type uPlot from "uplot";
import type { Figure, Scale } from "./answers";

function colourOf(scale: Scale, value: number): string {
  const share = (value - scale.low) / (scale.high - scale.low), last = scale.colours.length - 1;
  return scale.colours[Math.round(last * Math.min(1, Math.max(0, share)))]!;
}

/// Only what lies in the plot.
export function inPlot(plot: uPlot, draw: (ctx: CanvasRenderingContext2D) => void): void {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  draw(ctx);
  ctx.restore();
}

export function drawCells(plot: uPlot, figure: Figure): void {
  const { map, z } = figure;
  if (!map || !z) return;
  const x = map.x.map((edge) => Math.round(plot.valToPos(edge, "x", true)));
  const y = map.y.map((edge) => Math.round(plot.valToPos(edge, "y", true)));
  const columns = x.length - 1;
  inPlot(plot, (ctx) => {
    map.values.forEach((value, i) => {
      if (value === null) return;
      const column = i % columns, row = Math.floor(i / columns);
      ctx.fillStyle = colourOf(z, value);
      ctx.fillRect(x[column]!, y[row + 1]!, x[column + 1]! - x[column]!, y[row]! - y[row + 1]!);
    });
  });
}

/// With an edge, since a point may have the colour of its cell.
export function drawColouredPoints(plot: uPlot, figure: Figure, hidden: number[]): void {
  const { z } = figure;
  if (!z) return;
  const radius = 3.2 * devicePixelRatio;
  inPlot(plot, (ctx) => {
    figure.series.forEach((series, k) => {
      if (!series.z || hidden.includes(k)) return;
      series.z.forEach((value, i) => {
        const x = series.x[i], y = series.y[i];
        if (value === null || x === null || x === undefined || y === null || y === undefined) return;
        ctx.beginPath();
        ctx.arc(plot.valToPos(x, "x", true), plot.valToPos(y, "y", true), radius, 0, 2 * Math.PI);
        ctx.fillStyle = colourOf(z, value);
        ctx.fill();
        ctx.strokeStyle = "#fff";
        ctx.lineWidth = devicePixelRatio;
        ctx.stroke();
      });
    });
  });
}

/// The scale below the plot, from its lowest to its highest colour.
export function ScaleBar({ scale }: { scale: Scale }) {
  return (
    <div class="figure-scale" role="img" aria-label={`${scale.title}: ${scale.ticks.map((tick) => tick.label).join(", ")}`}>
      <div class="scale-colours" style={{ background: `linear-gradient(to right, ${scale.colours.join(", ")})` }} />
      <div class="scale-ticks">
        {scale.ticks.map((tick) => <span key={tick.label} style={{ left: `${100 * tick.at}%` }}>{tick.label}</span>)}
      </div>
      <p class="scale-title">{scale.title}</p>
    </div>
  );
}

/// What the cell below the pointer holds; null: there is none.
export function valueAt(figure: Figure, x: number, y: number): number | null {
  const { map } = figure;
  if (!map) return null;
  const place = (edges: number[], value: number) => edges.findIndex((edge, i) => edge <= value && value < (edges[i + 1] ?? -Infinity));
  const column = place(map.x, x), row = place(map.y, y);
  return column < 0 || row < 0 ? null : map.values[row * (map.x.length - 1) + column] ?? null;
}
