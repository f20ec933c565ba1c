// Ticks of a logarithmic axis that begins and ends anywhere: uPlot's own go on without end where the least value is not
// one digit times a power of ten.

const least_decades = 1, most_decades = 12, most_labels = 7;

/// Powers of ten and their multiples, or where the axis is shorter than a decade numbers at even steps. At most 120.
export function logarithmicTicks(least: number, greatest: number): number[] {
  if (!(least > 0 && greatest > least && Number.isFinite(greatest))) return [];
  const decades = Math.log10(greatest / least);
  if (decades < least_decades) return evenTicks(least, greatest);
  const step = Math.max(1, Math.ceil(decades / most_decades)), multiples = step > 1 ? [1] : [1, 2, 3, 4, 5, 6, 7, 8, 9];
  const ticks: number[] = [];
  for (let power = Math.floor(Math.log10(least)); power <= Math.log10(greatest); power += step)
    for (const multiple of multiples) {
      const tick = Number(`${multiple}e${power}`);
      if (tick >= least && tick <= greatest) ticks.push(tick);
    }
  return ticks;
}

/// Three to eight multiples of 1, 2 or 5 times a power of ten.
function evenTicks(least: number, greatest: number): number[] {
  const rough = (greatest - least) / 4, power = Math.floor(Math.log10(rough));
  const multiple = [1, 2, 5, 10].find((one) => one * 10 ** power >= rough) ?? 10, step = Number(`${multiple}e${power}`);
  const first = Math.ceil(least / step), ticks: number[] = [];
  if (!(first + 8 > first)) return []; // shorter than the numbers can say
  for (let number = first; number * step <= greatest && ticks.length < 9; ++number) ticks.push(Number((number * step).toPrecision(12)));
  return ticks;
}

/// Which ticks have a number beside them: all of a short axis, else as many parts of a decade as there is room for.
export function labelledTicks(ticks: number[]): (number | null)[] {
  if (ticks.length <= most_labels) return ticks;
  const isOneOf = (digits: string) => (tick: number) => digits.includes(tick.toExponential()[0]!) && Number(tick.toPrecision(1)) === tick;
  const parts = ticks.filter(isOneOf("125")), whole = ticks.filter(isOneOf("1"));
  const each = Math.ceil(whole.length / most_labels);
  const labelled = new Set(parts.length <= most_labels ? parts : whole.filter((_, i) => i % each === 0));
  return ticks.map((tick) => (labelled.has(tick) ? tick : null));
}

export function tickText(tick: number | null): string | null {
  if (tick === null) return null;
  const number = Number(tick.toPrecision(6));
  return number >= 1e6 || number < 1e-4 ? number.toExponential().replace("e+", "e") : String(number);
}
