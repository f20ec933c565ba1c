// What is drawn of a rig at one instant, as faces in space: WebGL and SVG draw the same ones. Attitudes come from the
// server; here they are only drawn.
import { Motion } from "./ask";

export type Vector = [number, number, number];

export interface Camera {
  azimuth: number;
  elevation: number;
}

export type Paint = "base" | "rig0" | "rig1" | "rig2" | "instrument" | "x" | "y" | "z" | "gravity" | "earth" | "compass";

/// A flat face: its corners as seen (right, up, towards the eye), within -1 ... 1; brightness from the light.
export interface Face {
  points: Vector[];
  paint: Paint;
  light: number;
}

export interface Label {
  text: string;
  at: Vector;
  paint: Paint;
}

export interface Picture {
  faces: Face[];
  labels: Label[];
}

const plus = (a: Vector, b: Vector): Vector => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const minus = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (k: number, a: Vector): Vector => [k * a[0], k * a[1], k * a[2]];
const dot = (a: Vector, b: Vector) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Vector, b: Vector): Vector => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a: Vector) => Math.hypot(...a);
const unit = (a: Vector): Vector => times(1 / (length(a) || 1), a);

/// Two unit vectors across `n` and each other.
function across(n: Vector): [Vector, Vector] {
  const u = unit(cross(n, Math.abs(n[2]) < 0.8 ? [0, 0, 1] : [1, 0, 0]));
  return [u, cross(n, u)];
}

/// Where a part is, with its axes seen in level axes.
interface Frame {
  axes: [Vector, Vector, Vector];
  origin: Vector;
}

function frameOf(at: number[], scale: number): Frame {
  return {
    axes: [[at[0], at[1], at[2]], [at[3], at[4], at[5]], [at[6], at[7], at[8]]] as [Vector, Vector, Vector],
    origin: [scale * at[9], scale * at[10], scale * at[11]],
  };
}

const seenIn = (frame: Frame, v: Vector): Vector =>
  plus(plus(times(v[0], frame.axes[0]), times(v[1], frame.axes[1])), times(v[2], frame.axes[2]));

type Body = { corners: Vector[]; paint: Paint }[];

function tube(from: Vector, to: Vector, begin: number, end: number, paint: Paint, sides = 8): Body {
  const [u, v] = across(unit(minus(to, from)));
  const corner = (centre: Vector, radius: number, i: number) => {
    const angle = (2 * Math.PI * i) / sides;
    return plus(centre, plus(times(radius * Math.cos(angle), u), times(radius * Math.sin(angle), v)));
  };
  const body: Body = [];
  for (let i = 0; i < sides; ++i)
    body.push({ corners: [corner(from, begin, i), corner(from, begin, i + 1), corner(to, end, i + 1), corner(to, end, i)], paint });
  for (const [centre, radius] of [[from, begin], [to, end]] as [Vector, number][])
    if (radius > 0) body.push({ corners: Array.from({ length: sides }, (_, i) => corner(centre, radius, i)), paint });
  return body;
}

function arrow(from: Vector, along: Vector, paint: Paint, thick = 0.018): Body {
  const tip = plus(from, along), neck = plus(from, times(1 - Math.min(0.6, (5.5 * thick) / length(along)), along));
  return [...tube(from, neck, thick, thick, paint, 6), ...tube(neck, tip, 2.6 * thick, 0, paint, 8)];
}

/// A gimbal: a ring in the plane of u and v.
function ring(centre: Vector, u: Vector, v: Vector, radius: number, width: number, paint: Paint): Body {
  const n = unit(cross(u, v)), steps = 40, body: Body = [];
  const corner = (i: number, inner: boolean, top: boolean) => {
    const angle = (2 * Math.PI * i) / steps, r = radius + (inner ? -0.5 : 0.5) * width;
    return plus(plus(centre, times((top ? 0.7 : -0.7) * width, n)), plus(times(r * Math.cos(angle), u), times(r * Math.sin(angle), v)));
  };
  for (let i = 0; i < steps; ++i)
    for (const [a, b] of [[[false, true], [false, false]], [[true, true], [true, false]], [[true, true], [false, true]], [[true, false], [false, false]]] as [boolean, boolean][][])
      body.push({ corners: [corner(i, ...(a as [boolean, boolean])), corner(i + 1, ...(a as [boolean, boolean])), corner(i + 1, ...(b as [boolean, boolean])), corner(i, ...(b as [boolean, boolean]))], paint });
  return body;
}

function box(frame: Frame, half: Vector, paint: Paint): Body {
  const corner = (x: number, y: number, z: number) => plus(frame.origin, seenIn(frame, [x * half[0], y * half[1], z * half[2]]));
  const body: Body = [];
  for (let axis = 0; axis < 3; ++axis)
    for (const side of [-1, 1]) {
      const place = (a: number, b: number) => {
        const at: Vector = [0, 0, 0];
        at[axis] = side;
        at[(axis + 1) % 3] = a;
        at[(axis + 2) % 3] = b;
        return corner(...at);
      };
      body.push({ corners: [place(-1, -1), place(1, -1), place(1, 1), place(-1, 1)], paint });
    }
  return body;
}

const RIG: Paint[] = ["rig0", "rig1", "rig2"];

/// The parts of the rig: a ring for each axis that carries another, a plate for the last, a beam for an arm.
function bodiesOfRig(motion: Motion, at: number, scale: number): Body {
  const frames = motion.parts.map((part) => frameOf(part.at[at], scale));
  const turning = motion.parts.map((part, i) => ({ part, frame: frames[i] })).filter(({ part }) => part.name !== "instrument");
  const body: Body = [];
  turning.forEach(({ part, frame }, i) => {
    const axis = unit(seenIn(frame, part.axis)), next = turning[i + 1], paint = RIG[Math.min(i, 2)];
    const follower = next ? next.frame : frames[frames.length - 1];
    const arm = minus(follower.origin, frame.origin);
    if (part.slides) {
      body.push(...tube(plus(frame.origin, times(-0.42, axis)), plus(frame.origin, times(-0.26, axis)), 0.3, 0.3, paint, 28));
      body.push(...arrow(frame.origin, times(0.75, axis), paint), ...arrow(frame.origin, times(-0.75, axis), paint));
      return;
    }
    if (length(arm) > 0.3) {
      body.push(...tube(plus(frame.origin, times(-0.55, axis)), plus(frame.origin, times(0.06, axis)), 0.09, 0.09, "base", 16));
      const along = unit(arm), side = cross(axis, along);
      body.push(...box({ axes: [along, side, axis], origin: plus(plus(frame.origin, times(0.5, arm)), times(-0.22, axis)) }, [0.5 * length(arm) + 0.12, 0.07, 0.04], paint));
      return;
    }
    const radius = 0.5 + 0.17 * Math.max(0, turning.length - 2 - i);
    if (!next) {
      body.push(...tube(plus(frame.origin, times(-0.24, axis)), plus(frame.origin, times(-0.2, axis)), 0.36, 0.36, paint, 32));
      const reach = i === 0 ? 0.62 : radius;
      body.push(...tube(plus(frame.origin, times(-reach, axis)), plus(frame.origin, times(-0.24, axis)), 0.05, 0.05, paint, 12));
      // a mark on the rim, so that turning is seen
      const mark = unit(Math.abs(dot(axis, frame.axes[0])) < 0.8 ? frame.axes[0] : frame.axes[1]);
      body.push(...box({ axes: [mark, cross(axis, mark), axis], origin: plus(frame.origin, plus(times(0.3, mark), times(-0.19, axis))) }, [0.05, 0.02, 0.015], "x"));
      return;
    }
    const inner = unit(seenIn(next.frame, next.part.axis));
    const [u] = across(axis);
    const second = length(cross(axis, inner)) > 0.1 ? unit(minus(inner, times(dot(inner, axis), axis))) : u;
    body.push(...ring(frame.origin, axis, second, radius, 0.06, paint));
    for (const side of [-1, 1])
      body.push(...tube(plus(frame.origin, times(side * radius, axis)), plus(frame.origin, times(side * (radius + 0.14), axis)), 0.03, 0.03, paint, 10));
  });
  return body;
}

export interface Words {
  gravity: string;
  earthRate: string;
  north: string;
  east: string;
}

/// Everything at instant number `at`, as it is seen.
export function pictureOf(motion: Motion, at: number, camera: Camera, words: Words): Picture {
  const last = motion.parts[motion.parts.length - 1];
  const reach = Math.max(0, ...motion.parts.map((part) => Math.hypot(part.at[at][9], part.at[at][10], part.at[at][11])));
  // an arm fills the picture; a lever of some centimetres does not move the instrument visibly
  const scale = reach > 0.3 ? 0.95 / reach : 0.8;
  const instrument = frameOf(last.at[at], scale);
  const size = reach > 0.3 ? 0.55 : 1;
  const body = bodiesOfRig(motion, at, scale);
  body.push(...box(instrument, [0.17 * size, 0.13 * size, 0.09 * size], "instrument"));
  const labels: { text: string; at: Vector; paint: Paint }[] = [];
  (["x", "y", "z"] as const).forEach((name, i) => {
    const along = times(0.42 * size, instrument.axes[i]);
    body.push(...arrow(instrument.origin, along, name, 0.015));
    labels.push({ text: name, at: plus(instrument.origin, times(1.15, along)), paint: name });
  });
  const floor: Vector = [0, 0, -0.92];
  body.push(...ring(floor, [1, 0, 0], [0, 1, 0], 0.95, 0.015, "compass"));
  body.push(...arrow(floor, [0, 0.95, 0], "compass", 0.01), ...arrow(floor, [0.95, 0, 0], "compass", 0.01));
  labels.push({ text: words.north, at: plus(floor, [0, 1.05, 0]), paint: "compass" }, { text: words.east, at: plus(floor, [1.05, 0, 0]), paint: "compass" });
  const right: Vector = [Math.cos(camera.azimuth), Math.sin(camera.azimuth), 0];
  const eye: Vector = [Math.sin(camera.azimuth) * Math.cos(camera.elevation), -Math.cos(camera.azimuth) * Math.cos(camera.elevation), Math.sin(camera.elevation)];
  const up = cross(eye, right);
  const aside: Vector = plus(times(-1, right), times(0.25, up));
  body.push(...arrow(aside, times(0.55, unit(motion.gravity)), "gravity", 0.02));
  labels.push({ text: words.gravity, at: plus(aside, times(0.64, unit(motion.gravity))), paint: "gravity" });
  if (length(motion.earth_rate) > 0) {
    body.push(...arrow(aside, times(0.55, unit(motion.earth_rate)), "earth", 0.02));
    labels.push({ text: words.earthRate, at: plus(aside, times(0.64, unit(motion.earth_rate))), paint: "earth" });
  }
  const seen = (v: Vector): Vector => [dot(v, right) / 1.3, dot(v, up) / 1.3, dot(v, eye) / 3];
  const lamp = unit(plus(plus(times(0.4, right), times(0.75, up)), times(0.6, eye)));
  return {
    faces: body.map(({ corners, paint }) => {
      let normal = unit(cross(minus(corners[1], corners[0]), minus(corners[2], corners[0])));
      if (dot(normal, eye) < 0) normal = times(-1, normal);
      return { points: corners.map(seen), paint, light: 0.6 + 0.4 * Math.max(0, dot(normal, lamp)) };
    }),
    labels: labels.map((label) => ({ ...label, at: seen(label.at) })),
  };
}

/// Colours that are clear on a light and on a dark page.
const COLOURS: Record<Paint, [number, number, number]> = {
  base: [0.45, 0.48, 0.52], rig0: [0.62, 0.66, 0.7], rig1: [0.5, 0.58, 0.68], rig2: [0.7, 0.64, 0.54],
  instrument: [0.16, 0.44, 0.72], x: [0.84, 0.22, 0.16], y: [0.16, 0.6, 0.28], z: [0.27, 0.38, 0.95],
  gravity: [0.8, 0.42, 0.05], earth: [0.56, 0.24, 0.74], compass: [0.55, 0.58, 0.62],
};

/// Red, green, blue of a face, 0 to 1.
export function colourOf(paint: Paint, light = 1): [number, number, number] {
  const [r, g, b] = COLOURS[paint];
  return [r * light, g * light, b * light];
}

export function css(paint: Paint, light = 1): string {
  return `rgb(${colourOf(paint, light).map((part) => Math.round(255 * part)).join(" ")})`;
}
