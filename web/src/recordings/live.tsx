// A recording that is being made: how far it is, and whether the view follows its end.
import { useEffect, useState } from "preact/hooks";
import { get, Recording } from "../api";
import { seen, whole } from "./navigate";
import { openFile, span } from "./view";
import { duration, t } from "../texts";

/// [ms] between two questions about a recording that goes on.
export const LOOK_EVERY = 500;

/// A view that showed the end of the recording shows it again once there is more.
export function follow(before: Recording | null, now: Recording): void {
  const of = span.value;
  if (!before?.live || !of || before.name !== now.name || of.to < before.last) return;
  span.value = { from: of.from + now.last - of.to, to: now.last };
}

/// The last tenth of what is there, or as much as was seen.
function backToEnd(recording: Recording): void {
  const all = whole(recording), now = seen(recording);
  const width = Math.min(span.value ? now.to - now.from : Infinity, all.to - all.from);
  span.value = { from: all.to - width, to: all.to };
}

/// The file that the recording has become, once it is there.
function useSealed(target: string, wanted: boolean): boolean {
  const [there, setThere] = useState(false);
  useEffect(() => {
    if (!wanted || there) return;
    const ask = () => get(`/api/recording?${new URLSearchParams({ file: target })}`).then(() => setThere(true), () => undefined);
    void ask();
    const timer = setInterval(ask, 1000);
    return () => clearInterval(timer);
  }, [target, wanted, there]);
  return there;
}

export function Live({ recording }: { recording: Recording }) {
  const live = recording.live!;
  const sealed = useSealed(live.target, !live.going_on);
  const follows = seen(recording).to >= recording.last;
  return (
    <p class={live.going_on ? "live-bar going-on" : "live-bar"} data-testid="live" data-last={recording.last}>
      {live.going_on && <strong>● {t("live_recording", { time: duration(recording.last - recording.first) })}</strong>}
      {!live.going_on && <strong>{t(sealed ? "live_sealed" : "live_ended")}</strong>}
      {live.going_on && follows && <span>{t("live_follows")}</span>}
      {live.going_on && !follows && <button onClick={() => backToEnd(recording)}>{t("live_back")}</button>}
      {live.behind && <span>{t("live_behind")}</span>}
      {sealed && (
        <a href={"/?file=" + encodeURIComponent(live.target)} onClick={(event) => { event.preventDefault(); openFile(live.target); }}>{live.target}</a>
      )}
      <span class="hint">{t("live_hint")}</span>
    </p>
  );
}
