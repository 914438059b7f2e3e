// What the topic `life` tells: the state of each part, two values of each device, their last minute, and events.

const MOST_SAMPLES = 60, MOST_EVENTS = 100;

export const EMPTY = { parts: {}, values: {}, samples: {}, events: [] };

export function reduce(before, frame) {
  const from = frame.whole ? EMPTY : before;
  return {
    parts: { ...from.parts, ...frame.parts },
    values: { ...from.values, ...frame.values },
    samples: frame.samples ? withRows(from.samples, frame.samples) : from.samples,
    events: [...from.events, ...(frame.events || [])].slice(-MOST_EVENTS),
  };
}

// A row has only the devices whose values have changed; the others stay as they are.
function withRows(before, rows) {
  const samples = { ...before };
  for (const row of rows)
    for (const name of new Set([...Object.keys(samples), ...Object.keys(row)])) {
      const own = samples[name] || [];
      samples[name] = [...own, row[name] || own[own.length - 1]].slice(-MOST_SAMPLES);
    }
  return samples;
}

const DIGITS = 4, LONG = 1e7;

// A value as text: four digits are enough for a card, and do not jump.
export function show(value) {
  if (value === true) return 'on';
  if (value === false) return 'off';
  if (typeof value !== 'number') return String(value ?? '').trim() || '–';
  const size = Math.abs(value);
  if (size >= LONG) return `${(value / 1e6).toFixed(2)} M`;
  if (Number.isInteger(value)) return value.toLocaleString('en').replaceAll(',', '\u202f');
  if (size < 0.1) return String(Number(value.toPrecision(DIGITS - 1)));
  return value.toFixed(Math.max(DIGITS - 1 - Math.floor(Math.log10(Math.max(size, 1))), 0));
}
