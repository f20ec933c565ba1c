// Points of a figure that lead somewhere: one stop of the keyboard, arrows go from point to point, Enter opens.
import type uPlot from "uplot";
import { useRef, useState } from "preact/hooks";
import { t } from "../texts";
import type { Figure, Link } from "./answers";

export interface LinkedPoint {
  x: number;
  y: number;
  link: Link;
}

/// In order of x, those that the plot shows.
export function linkedPoints(figure: Figure, hidden: number[]): LinkedPoint[] {
  const points: LinkedPoint[] = [];
  figure.series.forEach((series, k) => {
    if (!series.links || hidden.includes(k)) return;
    series.links.forEach((link, i) => {
      const x = series.x[i], y = series.y[i];
      if (link && typeof x === "number" && typeof y === "number") points.push({ x, y, link });
    });
  });
  return points.sort((a, b) => a.x - b.x);
}

/// `addressOf`: where a link leads, and what it is called.
export function PointLinks({ plot, points, addressOf, follow }: {
  plot: uPlot;
  points: LinkedPoint[];
  addressOf: (link: Link) => { href: string; name: string };
  follow: (event: MouseEvent, link: Link) => void;
}) {
  const [current, setCurrent] = useState(0);
  const list = useRef<HTMLOListElement>(null);
  const { left, top, width, height } = plot.bbox;
  const place = (point: LinkedPoint) => ({ x: plot.valToPos(point.x, "x", true), y: plot.valToPos(point.y, "y", true) });
  const seen = points.filter((point) => {
    const { x, y } = place(point);
    return x >= left && x <= left + width && y >= top && y <= top + height;
  });
  const go = (event: KeyboardEvent) => {
    const to = { ArrowRight: current + 1, ArrowLeft: current - 1, Home: 0, End: seen.length - 1 }[event.key];
    if (to === undefined || to < 0 || to >= seen.length) return;
    event.preventDefault();
    setCurrent(to);
    list.current?.querySelectorAll("a")[to]?.focus();
  };
  return (
    <ol class="point-links" ref={list} aria-label={t("results_points")} onKeyDown={go}>
      {seen.map((point, i) => {
        const { x, y } = place(point), { href, name } = addressOf(point.link);
        return (
          <li key={i}>
            <a href={href} tabIndex={i === Math.min(current, seen.length - 1) ? 0 : -1} title={name} aria-label={name}
              style={{ left: `${x / devicePixelRatio}px`, top: `${y / devicePixelRatio}px` }}
              onFocus={() => setCurrent(i)} onClick={(event) => follow(event, point.link)} />
          </li>
        );
      })}
    </ol>
  );
}
