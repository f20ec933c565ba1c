// Who asks, and what they may do. Where people sign in, the server says so.
import { signal } from "@preact/signals";
import { get, post } from "../api";

export type Role = "read" | "operate" | "approve";

export interface Session {
  /// Whether people sign in; else whoever has the link may do everything.
  users: boolean;
  open: boolean;
  user: string;
  roles: Role[];
}

export const session = signal<Session>({ users: false, open: false, user: "", roles: [] });
/// Wrong passwords for this name since its user signed in the last time.
export const wrongBefore = signal(0);

export async function loadSession(): Promise<Session> {
  const { body } = await get<Session>("/api/session");
  session.value = body;
  return body;
}

export const may = (role: Role): boolean => session.value.roles.includes(role);

export async function signIn(name: string, password: string): Promise<void> {
  const { wrong_before } = await post<{ wrong_before: number }>("/api/session", { name, password });
  wrongBefore.value = wrong_before;
}

export async function signOut(): Promise<void> {
  await post("/api/session/end", {});
  location.reload();
}
