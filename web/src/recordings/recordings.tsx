// The recordings of the folder, and how more come into it.
import { useEffect, useRef, useState } from "preact/hooks";
import { get, ListedRecording, problemsOf, upload } from "../api";
import { listing } from "../jobs";
import { openFile } from "./view";
import { bytes, count, date, duration, t } from "../texts";

interface Listing {
  recordings: ListedRecording[];
  unprintable: number;
  cut: boolean;
}

interface Sending {
  name: string;
  done: number;
  problems: string[];
}

function State({ recording }: { recording: ListedRecording }) {
  if (recording.problems) return <span class="badge error" title={recording.problems.join("\n")}>✖ {t("cannot_be_read")}</span>;
  if (recording.live) return <span class={recording.live.going_on ? "badge going-on" : "badge"}>{t(recording.live.going_on ? "live_badge" : "live_badge_ended")}</span>;
  if (recording.job) return <span class="badge">{t("being_read")}</span>;
  if (recording.warnings === undefined) return <span class="badge">{recording.channels ? t("being_checked") : t("open_to_see")}</span>;
  if (recording.warnings > 0) return <span class="badge warning">⚠ {t("findings_count", { count: recording.warnings })}</span>;
  return <span class="badge good">✓ {t("no_findings")}</span>;
}

function Entry({ recording }: { recording: ListedRecording }) {
  const open = (event: MouseEvent) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    openFile(recording.name);
  };
  return (
    <tr>
      <th scope="row">
        <a href={"/?file=" + encodeURIComponent(recording.name)} onClick={open}>{recording.name}</a>
        {recording.instrument && <small>{recording.instrument}</small>}
        {recording.problems && <small class="problem">{recording.problems[0]}</small>}
      </th>
      <td class="wide">{recording.channels && <span title={recording.channels.join(", ")}>{recording.channels.slice(0, 4).join(", ")}{recording.channels.length > 4 ? " …" : ""}</span>}</td>
      <td class="number">{recording.duration !== undefined && duration(recording.duration)}</td>
      <td class="number wide">{recording.samples !== undefined && count(recording.samples)}</td>
      <td class="number wide">{recording.bytes > 0 && bytes(recording.bytes)}</td>
      <td class="wide">{date(recording.modified)}</td>
      <td><State recording={recording} /></td>
    </tr>
  );
}

export function RecordingsPage() {
  const [all, setAll] = useState<Listing | null>(null);
  const [problems, setProblems] = useState<string[]>([]);
  const [wanted, setWanted] = useState("");
  const [sending, setSending] = useState<Sending[]>([]);
  const [over, setOver] = useState(false);
  const input = useRef<HTMLInputElement>(null);
  const search = useRef<HTMLInputElement>(null);

  useEffect(() => {
    const timer = setTimeout(async () => {
      try {
        setAll((await get<Listing>("/api/recordings")).body);
        setProblems([]);
      } catch (error) {
        setProblems(problemsOf(error));
      }
    }, all ? 150 : 0);
    return () => clearTimeout(timer);
  }, [listing.value]);
  useEffect(() => {
    const key = (event: KeyboardEvent) => {
      if (event.key !== "/" || (event.target as HTMLElement).closest("input, textarea, select")) return;
      event.preventDefault();
      search.current?.focus();
    };
    document.addEventListener("keydown", key);
    return () => document.removeEventListener("keydown", key);
  }, []);

  const send = async (files: File[]) => {
    let opened: string | null = null;
    for (const file of files) {
      const state = (done: number, found: string[] = []) =>
        setSending((before) => [...before.filter((entry) => entry.name !== file.name), { name: file.name, done, problems: found }]);
      state(0);
      try {
        opened = (await upload(file, state)).name;
        setSending((before) => before.filter((entry) => entry.name !== file.name));
      } catch (error) {
        state(0, problemsOf(error));
      }
    }
    if (opened && files.length === 1) openFile(opened);
    else ++listing.value;
  };

  const words = wanted.toLowerCase().split(/\s+/).filter(Boolean);
  const matching = (all?.recordings ?? []).filter((recording) => {
    const text = [recording.name, recording.instrument ?? "", ...(recording.channels ?? [])].join(" ").toLowerCase();
    return words.every((word) => text.includes(word));
  });
  return (
    <section class={over ? "recordings dropping" : "recordings"}
      onDragOver={(event) => { event.preventDefault(); setOver(true); }}
      onDragLeave={() => setOver(false)}
      onDrop={(event) => { event.preventDefault(); setOver(false); void send(Array.from(event.dataTransfer?.files ?? [])); }}>
      <header class="list-head">
        <h1>{t("recordings")}</h1>
        <label class="search">
          {t("search")}
          <input ref={search} type="search" value={wanted} onInput={(event) => setWanted(event.currentTarget.value)} />
        </label>
        <input ref={input} type="file" multiple hidden data-testid="upload" onChange={(event) => { void send(Array.from(event.currentTarget.files ?? [])); event.currentTarget.value = ""; }} />
        <button class="main" onClick={() => input.current?.click()}>{t("upload")}</button>
      </header>
      <p class="hint">{t("upload_hint")}</p>
      {sending.map((entry) => (
        <p key={entry.name} class={entry.problems.length > 0 ? "problem" : ""} role="status">
          {entry.name}: {entry.problems.length > 0 ? entry.problems.join("; ") || t("connection_lost") : <progress value={entry.done} max={1} aria-label={entry.name} />}
        </p>
      ))}
      {problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      {all && all.recordings.length === 0 && <p class="notice">{t("no_recordings")}</p>}
      {matching.length > 0 && (
        <table class="list" data-testid="recordings">
          <thead>
            <tr>
              <th scope="col">{t("file")}</th>
              <th scope="col" class="wide">{t("channels")}</th>
              <th scope="col" class="number">{t("duration")}</th>
              <th scope="col" class="number wide">{t("samples")}</th>
              <th scope="col" class="number wide">{t("size")}</th>
              <th scope="col" class="wide">{t("changed")}</th>
              <th scope="col">{t("state")}</th>
            </tr>
          </thead>
          <tbody>{matching.map((recording) => <Entry key={recording.name} recording={recording} />)}</tbody>
        </table>
      )}
      {all && all.recordings.length > 0 && matching.length === 0 && <p class="notice">{t("nothing_found")}</p>}
      {all && all.unprintable > 0 && <p class="hint">{t("unprintable", { count: all.unprintable })}</p>}
      {all?.cut && <p class="hint">{t("list_cut", { count: all.recordings.length })}</p>}
    </section>
  );
}
