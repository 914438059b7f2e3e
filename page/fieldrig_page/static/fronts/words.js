// Values of points in words, for eyes and for screen readers.

// The name of a value among pairs of value and name; undefined without one.
export function nameOf(value, names = []) {
  return names.find(([one]) => one === value)?.[1];
}

// The name of a value, or the value itself.
export function named(value, names) {
  return nameOf(value, names) ?? shown(value);
}

export function shown(value) {
  if (value === undefined || value === null) return '–';
  if (value === true) return 'on';
  if (value === false) return 'off';
  return typeof value === 'number' ? number(value) : String(value);
}

// A number with so many decimals; without `decimals` as short as seven digits have it.
export function number(value, decimals) {
  if (typeof value !== 'number') return '–';
  const text = decimals === undefined ? String(Number(value.toPrecision(7))) : value.toFixed(decimals);
  return text.replace(/^-(0(?:\.0*)?)$/, '$1').replace('-', '−');
}
