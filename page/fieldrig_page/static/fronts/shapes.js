// The shapes of the drawings, each in its own measures.
import { html } from 'htm/preact';

const numeric = (value) => (typeof value === 'number' ? value : 0);
const within = (value, low, high) => Math.min(Math.max(value, low), high);

export function Tank({ values, scale }) {
  const y = (level) => 96 - 84 * within(level / scale.height, 0, 1);
  const top = y(numeric(values.level));
  return html`<svg viewBox="0 0 160 110">
    ${numeric(values.inflow) > 0 && html`<path class="water" d=${`M52 4h5V${top}h-5z`} />`}
    <rect class="water" x="36" y=${top} width="88" height=${96 - top} />
    <path class="wall" d="M36 12V96H124V12" /><path class="pipe" d="M20 5H54V12" /><path class="pipe" d="M124 92H146V104" />
    ${numeric(values.outflow) > 0 && html`<path class="water" d="M142 98h8v10h-8z" />`}
    ${numeric(values.leak) > 0 && html`<path class="water" d="M24 84h12v3h-12z" />`}
    ${['high', 'low'].filter((name) => scale[name] !== undefined).map((name) => html`<path class="notch" d=${`M124 ${y(scale[name])}h8`} /><text x="135" y=${Math.min(y(scale[name]) + 3, 87) /* above the outlet */}>${name}</text>`)}
  </svg>`;
}

export function Winder({ values, scale }) {
  const most = Math.max(scale.full, numeric(values.radius));
  const radius = 42 * numeric(values.radius) / most, core = 42 * scale.core / most, turn = numeric(values.angle) * 180 / Math.PI % 360;
  const dancer = 74 + 60 * within(numeric(values.dancer), 0, 0.4);
  return html`<svg viewBox="0 0 200 110">
    ${values.broken !== true ? html`<path class="web" d=${`M58 ${54 - radius}H${values.dancer === undefined ? 196 : `118L140 ${dancer}L162 ${54 - radius}H196`}`} />` : html`<path class="web torn" d=${`M58 ${54 - radius}h26l6 10`} />`}
    ${values.dancer !== undefined && html`<circle class="roller" cx="140" cy=${dancer} r="6" />`}
    <circle class="roll" cx="58" cy="54" r=${radius} /><circle class="core" cx="58" cy="54" r=${core} />
    <path class="mark" transform=${`rotate(${turn} 58 54)`} d=${`M58 ${54 - core}V${54 - radius}`} /></svg>`;
}

export function Conveyor({ values, scale }) {
  const long = 180 / scale.length, fronts = String(values.fronts ?? '').split(',').filter(Boolean).map(Number);
  const sensors = Object.entries(scale).filter(([key]) => key.startsWith('sensor.'));
  const turn = numeric(values.position) * long / 9 * 180 / Math.PI % 360;
  return html`<svg viewBox="0 0 204 80">
    <rect class="belt" x="3" y="40" width="198" height="18" rx="9" />
    ${[12, 192].map((x) => html`<g transform=${`rotate(${turn} ${x} 49)`}><circle class="roller" cx=${x} cy="49" r="7" /><path class="mark" d=${`M${x} 49v-6`} /></g>`)}
    ${fronts.map((front) => html`<rect class="product" x=${12 + (front - scale.product) * long} y="24" width=${scale.product * long} height="15" rx="1.5" />`)}
    ${sensors.map(([key, at]) => html`<path class=${`beam ${values[key] === true ? 'covered' : ''}`} d=${`M${12 + at * long} 14V62`} /><text x=${12 + at * long} y="74">${key.slice(7)}</text>`)}</svg>`;
}

export function Shaft({ values, scale }) {
  const turn = numeric(values.angle) / scale.turn * 360 % 360;
  return html`<svg viewBox="0 0 110 110">
    ${Array.from({ length: 12 }, (_, at) => html`<path class="tick" transform=${`rotate(${at * 30} 55 55)`} d="M55 4v5" />`)}
    <circle class="disc" cx="55" cy="55" r="42" /><g transform=${`rotate(${turn} 55 55)`}><path class="hand" d="M55 55V16" /><circle class="hole" cx="55" cy="24" r="4" /></g>
    <circle class="core" cx="55" cy="55" r="8" /></svg>`;
}

export function Slide({ values, scale }) {
  const place = numeric(values.position), span = Math.max(100, Math.abs(place) * 1.2);
  const x = (at) => 100 + 88 * within(at / span, -1, 1);
  const from = scale.from ?? -span;
  return html`<svg viewBox="0 0 200 70">
    <rect class="belt" x="6" y="44" width="188" height="6" rx="3" /><rect class="zone" x=${x(from)} y="52" width=${Math.max(x(scale.to) - x(from), 1)} height="5" />
    <text x="100" y="67">zero switch ${values.zero === true ? 'closed' : 'open'}</text>
    <rect class="product" x=${x(place) - 12} y="22" width="24" height="21" rx="2" /></svg>`;
}

export function Heater({ values, scale }) {
  const degc = numeric(values.temperature), top = Math.max(scale.limit ?? 0, degc, 100);
  const warm = within((degc - 15) / (top - 15), 0, 1);
  return html`<svg viewBox="0 0 160 100">
    <rect class="body" x="20" y="22" width="100" height="46" rx="5" /><rect class="heat" x="20" y="22" width="100" height="46" rx="5" opacity=${warm} />
    <path class="coil" d="M28 78h10l5-6 8 12 8-12 8 12 8-12 8 12 8-12 5 6h10" opacity=${0.3 + 0.7 * within(numeric(values.duty) / 100, 0, 1)} />
    <rect class="scale" x="134" y="10" width="8" height="78" rx="4" /><rect class="bar" x="134" y=${88 - 78 * within(degc / top, 0, 1)} width="8" height=${78 * within(degc / top, 0, 1)} rx="4" />
    ${scale.limit !== undefined && html`<path class="notch" d=${`M130 ${88 - 78 * scale.limit / top}h16`} />`}</svg>`;
}
