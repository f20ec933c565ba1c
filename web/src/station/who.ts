// The name under which somebody gives orders, kept by the browser.
import { signal } from "@preact/signals";

export const who = signal(localStorage.getItem("operator") ?? "");

export function setWho(name: string): void {
  who.value = name;
  localStorage.setItem("operator", name);
}
