// The rooms of the workbench, in the order of the menu. The server knows their paths (page_routes).
import type { ComponentType } from "preact";
import { ArchiveRoom } from "./archive/room";
import { PlansRoom } from "./plans/room";
import { RecordingsRoom } from "./recordings/room";
import { ResultsRoom } from "./results/room";
import { StationRoom } from "./station/room";

export interface Room {
  path: string;
  /// Key of its name.
  name: string;
  Page: ComponentType;
}

export const ROOMS: Room[] = [
  { path: "/", name: "recordings", Page: RecordingsRoom },
  { path: "/plans", name: "plans_room", Page: PlansRoom },
  { path: "/results", name: "results", Page: ResultsRoom },
  { path: "/station", name: "station", Page: StationRoom },
  { path: "/archive", name: "archive", Page: ArchiveRoom },
];
