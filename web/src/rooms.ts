// The rooms of the workbench, in the order of the menu. The server knows their paths (page_routes).
import type { ComponentType } from "preact";
import { PlansRoom } from "./plans/room";
import { RecordingsRoom } from "./recordings/room";

export interface Room {
  path: string;
  /// Key of its name.
  name: string;
  Page: ComponentType;
}

export const ROOMS: Room[] = [
  { path: "/", name: "recordings", Page: RecordingsRoom },
  { path: "/plans", name: "plans_room", Page: PlansRoom },
];
