// The parameters of questions about a recording.
import { Channel, Recording } from "../api";
import { sets, units } from "./view";

export function fileQuery(file: string): URLSearchParams {
  const query = new URLSearchParams({ file });
  for (const text of sets.value) query.append("set", text);
  return query;
}

/// Parameters of a question about a span, for the channels that are shown.
export function spanQuery(recording: Recording, channels: Channel[], from: number, to: number): URLSearchParams {
  const query = fileQuery(recording.name);
  query.set("from", String(from));
  query.set("to", String(to));
  for (const channel of channels) {
    query.append("channel", channel.name);
    query.append("unit", units.value[channel.name] ?? channel.unit);
  }
  return query;
}
