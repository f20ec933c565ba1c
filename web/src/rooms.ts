// The rooms of the workbench, in the order of the menu. The server knows their paths (page_routes).
import type { ComponentType } from "preact";
import { ArchiveRoom } from "./archive/room";
import { RecordingsRoom } from "./recordings/room";
import { StationRoom } from "./station/room";
import { ResultsRoom } from "./results/room";

export interface Room {
  path: string;
  /// Key of its name.
  name: string;
  Page: ComponentType;
}

export const ROOMS: Room[] = [
  { path: "/", name: "recordings", Page: RecordingsRoom },
  { path: "/archive", name: "archive", Page: ArchiveRoom },
  { path: "/station", name: "station", Page: StationRoom },
  { path: "/results", name: "results", Page: ResultsRoom },
];
