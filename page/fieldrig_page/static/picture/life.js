// What the topic `life` tells: the state of each part, two values of each device, their last minute, and events.
import { named } from '../named.js';

const MOST_SAMPLES = 60, MOST_EVENTS = 100;

export const EMPTY = { parts: named(), values: named(), samples: named(), events: [] };

export function reduce(before, frame) {
  const from = frame.whole ? EMPTY : before;
  return {
    parts: named(from.parts, frame.parts),
    values: named(from.values, frame.values),
    samples: frame.samples ? withRows(from.samples, frame.samples) : from.samples,
    events: [...from.events, ...(frame.events || [])].slice(-MOST_EVENTS),
  };
}

// A row has only the devices whose values have changed; the others stay as they are.
function withRows(before, rows) {
  const samples = named(before);
  for (const row of rows)
    for (const name of new Set([...Object.keys(samples), ...Object.keys(row)])) {
      const own = samples[name] || [];
      samples[name] = [...own, row[name] || own[own.length - 1]].slice(-MOST_SAMPLES);
    }
  return samples;
}

const DIGITS = 4, LONG = 1e7;
const PREFIXES = [[1e12, 'T'], [1e9, 'G'], [1e6, 'M']];

// A value as text: four digits are enough for a card, and do not jump; three and a prefix leave room for its name.
export function show(value) {
  if (value === true) return 'on';
  if (value === false) return 'off';
  if (typeof value !== 'number' || !Number.isFinite(value)) return String(value ?? '').trim() || '–';
  const size = Math.abs(value);
  if (size >= LONG) return long(value);
  if (Number.isInteger(value)) return value.toLocaleString('en').replaceAll(',', '\u202f');
  if (size < 0.1) return String(Number(value.toPrecision(DIGITS - 1)));
  return value.toFixed(Math.max(DIGITS - 1 - Math.floor(Math.log10(Math.max(size, 1))), 0));
}

function long(value) {
  const [scale, prefix] = PREFIXES.find(([least]) => Math.abs(value) >= least);
  const digits = (value / scale).toPrecision(DIGITS - 1);
  return `${digits.includes('e') ? Number(digits) : digits} ${prefix}`;
}
