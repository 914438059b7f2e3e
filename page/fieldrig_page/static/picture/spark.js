// The last values of a device, about a minute of them, as a small line.
import { html } from 'htm/preact';

const WIDTH = 100, HEIGHT = 20, EDGE = 2;

export function Spark({ values, name }) {
  const numbers = values.map(Number).filter(Number.isFinite);
  if (numbers.length < 2) return html`<svg class="spark" aria-hidden="true" viewBox="0 0 ${WIDTH} ${HEIGHT}"></svg>`;
  const low = Math.min(...numbers), span = Math.max(...numbers) - low;
  const x = at => WIDTH - (numbers.length - 1 - at) * (WIDTH / 59);
  const y = value => (span ? HEIGHT - EDGE - ((value - low) / span) * (HEIGHT - 2 * EDGE) : HEIGHT / 2);
  const points = numbers.map((value, at) => `${x(at).toFixed(1)},${y(value).toFixed(1)}`);
  return html`<svg class="spark" role="img" aria-label=${`${name}, its last values`} viewBox="0 0 ${WIDTH} ${HEIGHT}" preserveAspectRatio="none">
    <polygon points=${`${x(0).toFixed(1)},${HEIGHT} ${points.join(' ')} ${WIDTH},${HEIGHT}`} /><polyline points=${points.join(' ')} /></svg>`;
}
