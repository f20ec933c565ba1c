// The name under which somebody gives orders: of who has signed in, else kept by the browser.
import { computed, signal } from "@preact/signals";
import { session } from "../session/session";

const typed = signal(localStorage.getItem("operator") ?? "");
export const who = computed(() => session.value.user || typed.value);
/// Who has signed in acts under that name alone.
export const named = computed(() => session.value.user !== "");

export function setWho(name: string): void {
  typed.value = name;
  localStorage.setItem("operator", name);
}
