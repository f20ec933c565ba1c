// The rig and the instrument as they move through the schedule: picture, timeline, playing.
import { useEffect, useRef, useState } from "preact/hooks";
import { problemsOf } from "../api";
import { duration, t } from "../texts";
import { ask, Motion, PlannedRun } from "./ask";
import { Camera, css, Picture, pictureOf } from "./scene";
import { draw as wantedDraw, file, lastSchedule, look, run, text, time } from "./state";
import { Draw, webglOn } from "./webgl";

const FRAMES_A_SECOND = 30, AHEAD = 150;
const calm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

/// The text of the last plan that could be read, since only that has a motion.
function useSoundText(): string {
  const [sound, setSound] = useState("");
  const good = look.value !== null && look.value.problems.length === 0;
  const now = text.value;
  useEffect(() => {
    if (good) setSound(now);
  }, [good, look.value]);
  return sound;
}

interface Course {
  motion: Motion;
  of: string;
}

/// Instants around the present one, asked from the server as they are needed.
function useMotion(sound: string, playing: boolean, speed: number): { course: Course | null; problems: string[] } {
  const [course, setCourse] = useState<Course | null>(null);
  const [problems, setProblems] = useState<string[]>([]);
  const at = time.value, of = `${run.value}\n${sound}`;
  const step = speed / FRAMES_A_SECOND;
  const motion = course?.of === of ? course.motion : null;
  const index = motion ? Math.floor((at - motion.from) / motion.step + 1e-6) : -1;
  const count = motion?.parts[0]?.at.length ?? 0;
  const inside = playing ? index >= 0 && index < count && count > 1 && motion!.step === step : index >= 0 && index < count && Math.abs(at - motion!.from - index * motion!.step) < 0.5 * Math.max(step, 1e-3) && count > 1 || (motion?.from === at && count === 1);
  const needed = sound !== "" && (!inside || (playing && index > count / 2));
  const key = needed ? `${of}\n${playing ? Math.floor(index / 30) : at}\n${playing}\n${step}\n${inside}` : "";
  useEffect(() => {
    if (key === "") return;
    const control = new AbortController();
    const begin = time.value;
    const question = { file: file.value ?? "", text: sound, run: run.value, from: begin, step: playing ? step : 1, count: playing ? AHEAD : 1 };
    ask<Motion>("/api/plan/motion", question, control.signal).then(
      (answer) => {
        if (control.signal.aborted) return;
        setCourse({ motion: answer, of });
        setProblems([]);
      },
      (error) => {
        if (!control.signal.aborted) setProblems(problemsOf(error));
      },
    );
    // while playing, what is asked is used even when the next question follows
    return () => {
      if (!playing) control.abort();
    };
  }, [key]);
  return { course, problems };
}

function Drawing({ picture, camera, onTurn }: { picture: Picture | null; camera: Camera; onTurn: (camera: Camera) => void }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const drawer = useRef<Draw | null>(null);
  const [svg, setSvg] = useState(wantedDraw.value === "svg");
  const grip = useRef<{ x: number; y: number; camera: Camera } | null>(null);
  useEffect(() => {
    if (svg || !canvas.current) return;
    drawer.current = webglOn(canvas.current);
    if (!drawer.current) setSvg(true);
    const lost = () => setSvg(true);
    canvas.current.addEventListener("webglcontextlost", lost);
  }, [svg]);
  useEffect(() => {
    if (picture && !svg) drawer.current?.(picture.faces);
  }, [picture, svg]);
  useEffect(() => {
    if (svg || !canvas.current) return;
    const watcher = new ResizeObserver(() => picture && drawer.current?.(picture.faces));
    watcher.observe(canvas.current);
    return () => watcher.disconnect();
  }, [picture, svg]);
  const turn = (azimuth: number, elevation: number) =>
    onTurn({ azimuth, elevation: Math.max(-1.5, Math.min(1.5, elevation)) });
  const keys = (event: KeyboardEvent) => {
    const step = { ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, 0.12], ArrowDown: [0, -0.12] }[event.key];
    if (!step) return;
    event.preventDefault();
    turn(camera.azimuth + step[0], camera.elevation + step[1]);
  };
  const depth = (points: [number, number, number][]) => points.reduce((sum, point) => sum + point[2], 0) / points.length;
  const corner = ([x, y]: [number, number, number]) => `${(100 * x).toFixed(2)},${(-100 * y).toFixed(2)}`;
  return (
    <div class="drawing" role="application" aria-label={t("plans_picture")} aria-roledescription={t("plans_picture_keys")} tabIndex={0} onKeyDown={keys}
      onPointerDown={(event) => {
        grip.current = { x: event.clientX, y: event.clientY, camera };
        (event.currentTarget as Element).setPointerCapture(event.pointerId);
      }}
      onPointerMove={(event) => {
        const from = grip.current;
        if (from) turn(from.camera.azimuth - (event.clientX - from.x) / 150, from.camera.elevation + (event.clientY - from.y) / 150);
      }}
      onPointerUp={() => (grip.current = null)} onPointerCancel={() => (grip.current = null)}>
      {!svg && <canvas ref={canvas} data-testid="scene-webgl" aria-hidden="true" />}
      <svg viewBox="-100 -100 200 200" aria-hidden="true" data-testid={svg ? "scene-svg" : "scene-labels"}>
        {svg && picture && [...picture.faces].sort((a, b) => depth(a.points) - depth(b.points)).map(({ points, paint, light }, i) => (
          <polygon key={i} points={points.map(corner).join(" ")} fill={css(paint, light)} stroke={css(paint, light)} stroke-width="0.3" />
        ))}
        {picture?.labels.map((label) => (
          <text key={label.text} x={100 * label.at[0]} y={-100 * label.at[1]} text-anchor="middle" dominant-baseline="middle">{label.text}</text>
        ))}
      </svg>
    </div>
  );
}

function Timeline({ now }: { now: PlannedRun }) {
  const end = now.duration || 1;
  return (
    <div class="course">
      <div class="bars">
        {now.segments.map((segment, i) => {
          const here = time.value >= segment.begin && time.value < segment.begin + segment.duration;
          return (
            <button key={i} title={`${segment.label}: ${duration(segment.duration)}`} aria-current={here ? "true" : undefined}
              style={{ left: `${(100 * segment.begin) / end}%`, width: `max(2px, ${(100 * segment.duration) / end}%)` }}
              onClick={() => (time.value = segment.begin)}>
              {segment.label}
            </button>
          );
        })}
        <span class="playhead" style={{ left: `${(100 * Math.min(time.value, end)) / end}%` }} />
      </div>
      <input type="range" min="0" max={end} step={end / 2000} value={time.value} aria-label={t("plans_scrub")}
        aria-valuetext={duration(Math.round(10 * time.value) / 10)} onInput={(event) => (time.value = Number(event.currentTarget.value))} />
    </div>
  );
}

const SPEEDS = [1, 10, 60, 300];

export function Stage() {
  const [playing, setPlaying] = useState(false);
  const [speed, setSpeed] = useState(10);
  const [camera, setCamera] = useState<Camera>({ azimuth: 0.45, elevation: 0.5 });
  const sound = useSoundText();
  const schedule = lastSchedule.value;
  const now = schedule?.runs.find((one) => one.run === run.value) ?? schedule?.runs[0];
  const { course, problems } = useMotion(sound, playing && !calm(), speed);
  const available = useRef(0);
  const motion = course?.motion ?? null;
  const count = motion?.parts[0]?.at.length ?? 0;
  available.current = motion && course!.of === `${run.value}\n${sound}` ? motion.from + (count - 1) * motion.step : 0;

  useEffect(() => {
    if (now && now.run !== run.value) run.value = now.run;
    if (now && time.value > now.duration) time.value = 0;
  }, [now]);
  useEffect(() => {
    if (!playing || !now) return;
    if (calm()) { // from one segment to the next, without moving pictures
      const timer = setInterval(() => {
        const next = now.segments.find((segment) => segment.begin + 0.5 * segment.duration > time.value + 1e-6);
        if (next) time.value = next.begin + 0.5 * next.duration;
        else setPlaying(false);
      }, 1200);
      return () => clearInterval(timer);
    }
    let before = performance.now(), frame = 0;
    const advance = (instant: number) => {
      const next = time.value + (speed * Math.min(100, instant - before)) / 1000;
      before = instant;
      if (next >= now.duration) {
        time.value = now.duration;
        setPlaying(false);
        return;
      }
      if (next <= available.current) time.value = next; // else it waits for the server
      frame = requestAnimationFrame(advance);
    };
    frame = requestAnimationFrame(advance);
    return () => cancelAnimationFrame(frame);
  }, [playing, speed, now]);

  const index = motion ? Math.max(0, Math.min(count - 1, Math.floor((time.value - motion.from) / motion.step + 1e-6))) : 0;
  const words = { gravity: t("plans_gravity_arrow"), earthRate: t("plans_earth_rate_arrow"), north: t("plans_north"), east: t("plans_east") };
  const picture = motion && count > 0 ? pictureOf(motion, index, camera, words) : null;
  const segment = now?.segments.findIndex((one) => time.value < one.begin + one.duration) ?? -1;
  const settled = segment >= 0 && motion ? time.value >= (motion.settled[segment] ?? 0) : true;
  if (schedule && schedule.runs.length === 0) return <p class="notice">{t("plans_no_schedule")}</p>;
  return (
    <section class="stage" aria-label={t("plans_stage")} data-time={time.value.toFixed(2)}>
      <Drawing picture={picture} camera={camera} onTurn={setCamera} />
      {problems.map((problem) => <p class="problem" key={problem}>{problem}</p>)}
      {now && (
        <>
          <div class="toolbar">
            <button class="main" aria-pressed={playing} onClick={() => {
              if (!playing && time.value >= now.duration - 1e-6) time.value = 0;
              setPlaying(!playing);
            }}>{playing ? `❚❚ ${t("plans_pause")}` : `▶ ${t("plans_play")}`}</button>
            <label>{t("plans_speed")}
              <select value={speed} onChange={(event) => setSpeed(Number(event.currentTarget.value))}>
                {SPEEDS.map((one) => <option key={one} value={one}>{`${one}×`}</option>)}
              </select>
            </label>
            {schedule!.runs.length > 1 && (
              <label>{t("plans_run")}
                <select value={now.run} onChange={(event) => { time.value = 0; run.value = Number(event.currentTarget.value); }}>
                  {schedule!.runs.map((one) => <option key={one.run} value={one.run}>{one.run}</option>)}
                </select>
              </label>
            )}
            <span>{duration(Math.round(10 * time.value) / 10)} / {duration(now.duration)}</span>
          </div>
          <Timeline now={now} />
          <p class="state" data-testid="stage-state">
            <strong>{now.segments[segment]?.label ?? t("plans_end")}</strong>{" "}
            <span class={settled ? "good" : "warning"}>{settled ? `✓ ${t("plans_settled")}` : `↻ ${t("plans_moving")}`}</span>{" "}
            {motion?.axes.filter((axis) => !axis.name.startsWith("mount_") || axis.values[index] !== "0.0 deg").map((axis) => <span class="axis" key={axis.name}>{axis.name} {axis.values[index]}</span>)}
          </p>
        </>
      )}
    </section>
  );
}
