// Every view is its address: the path names the room, the query what is seen in it.
import { batch, signal } from "@preact/signals";

export const path = signal(""); // until one has arrived
export const query = signal(new URLSearchParams());

const readers: Record<string, (query: URLSearchParams) => void> = {};

/// What a room does when one comes to it by a link, by "back" or by a bookmark.
export function onArrival(room: string, read: (query: URLSearchParams) => void): void {
  readers[room] = read;
}

export function arrive(): void {
  batch(() => {
    path.value = location.pathname;
    query.value = new URLSearchParams(location.search);
    readers[path.value]?.(query.value);
  });
}

export function addressOf(room: string, seen: URLSearchParams): string {
  const text = seen.toString();
  return text === "" ? room : `${room}?${text}`;
}

/// Another place; "back" leads to where one was.
export function go(room: string, seen = new URLSearchParams()): void {
  history.pushState(null, "", addressOf(room, seen));
  arrive();
}

/// The same place seen in another way: the address follows, "back" does not stop here.
export function show(seen: URLSearchParams): void {
  const now = addressOf(path.peek(), seen);
  if (now !== location.pathname + location.search) history.replaceState(null, "", now);
  query.value = seen;
}
