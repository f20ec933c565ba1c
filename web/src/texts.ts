// What people read, by meaning, from text/en.toml and text/zh.toml.
import { signal } from "@preact/signals";

export type Language = "en" | "zh";

const stored = localStorage.getItem("language");
export const language = signal<Language>(
  stored === "en" || stored === "zh" ? stored : navigator.language.startsWith("zh") ? "zh" : "en",
);
const table = signal<Record<string, string>>({});

export async function loadTexts(): Promise<void> {
  const response = await fetch("/api/texts?language=" + language.value);
  table.value = await response.json();
  document.documentElement.lang = language.value === "zh" ? "zh-CN" : "en";
}

export async function setLanguage(chosen: Language): Promise<void> {
  language.value = chosen;
  localStorage.setItem("language", chosen);
  await loadTexts();
}

/// The text of a key; {name} in it stands for the value of that name.
export function t(key: string, values: Record<string, string | number> = {}): string {
  const text = table.value[key] ?? key;
  return text.replace(/\{(\w+)\}/g, (_, name: string) => String(values[name] ?? ""));
}

export function count(value: number): string {
  return new Intl.NumberFormat(language.value).format(value);
}

export function bytes(value: number): string {
  const units = ["B", "kB", "MB", "GB", "TB"];
  let power = 0;
  while (value >= 1000 && power + 1 < units.length) {
    value /= 1000;
    ++power;
  }
  return `${power === 0 ? value : value.toPrecision(3)} ${units[power]}`;
}

/// 3 h 3 min; 12.5 s
export function duration(seconds: number): string {
  if (seconds < 60) return `${Number(seconds.toPrecision(4))} s`;
  const whole = Math.round(seconds), minutes = Math.floor(whole / 60);
  if (minutes < 60) return `${minutes} min ${whole % 60} s`;
  const rounded = Math.round(seconds / 60);
  return `${Math.floor(rounded / 60)} h ${rounded % 60} min`;
}

export function date(seconds: number): string {
  return new Intl.DateTimeFormat(language.value, { dateStyle: "medium", timeStyle: "short" }).format(1e3 * seconds);
}
