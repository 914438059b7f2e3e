// The shell of the page: its head, the ways to its views, and the view that the address names.
import { html, render } from 'htm/preact';
import { useEffect, useLayoutEffect, useState } from 'preact/hooks';
import { keepFocus } from './focus.js';
import { live, role, useAnswer, useLive, useModule, useRefusals, useWish } from './live.js';

// Each view is a module with `export function View({rig, path, role})`; `path` is what follows its hash.  One that needs
// a name, such as `#/device/NAME`, is hidden from the navigation.  `of` says what the name in its address is one of, and
// `needs` what the rig must have for the view to be in the navigation.
const VIEWS = [
  { title: 'Picture', hash: 'picture', load: () => import('./picture.js') },
  { title: 'Device', hash: 'device', isHidden: true, of: ['devices'], load: () => import('./device.js') },
  { title: 'Values', hash: 'values', of: ['devices'], load: () => import('./values.js') },
  { title: 'Traffic', hash: 'traffic', of: ['buses'], load: () => import('./traffic.js') },
  { title: 'Scope', hash: 'scope', load: () => import('./scope/scope.js') },
  { title: 'Bus', hash: 'bus', isHidden: true, of: ['buses'], load: () => import('./traffic.js') },
  { title: 'Faults', hash: 'faults', of: ['devices', 'buses'], load: () => import('./faults.js') },
  { title: 'Programs', hash: 'programs', of: ['devices'], load: () => import('./programs.js') },
  { title: 'Time', hash: 'time', load: () => import('./time.js') },
  { title: 'Time line', hash: 'timeline', needs: 'prelude', load: () => import('./timeline.js') },
];
// What `#/` shows.
const FIRST = VIEWS[0];

const STATES = {
  connecting: 'connecting',
  away: 'page server away, trying again',
  silent: 'page server silent: what is shown is old',
  refused: 'this address is no longer good: open the one that fieldrig up has printed',
};

function App() {
  const state = useLive('state', (_, message) => message.state, live.state);
  const rig = useLive('rig', (_, message) => message, {});
  const refusals = useRefusals();
  const [name, path] = useHash();
  const view = VIEWS.find((one) => one.hash === name) ?? FIRST;
  const greeting = live.greeting;
  useWish('rig', true);
  useEffect(() => { document.querySelector('nav [aria-current]')?.scrollIntoView({ block: 'nearest', inline: 'center' }); }, [greeting, view]);
  useEffect(() => { document.title = greeting ? `${greeting.rig} · ${view.title}` : 'fieldrig'; }, [greeting, view]);
  if (greeting === null) return html`<main class="alone"><p role="status">${STATES[state]} ...</p></main>`;
  const whole = { ...greeting, ...rig };
  return html`
    <a class="skip" href="#main" onClick=${focusMain}>to the content</a>
    <header>
      <a class="mark" href="#/" aria-label=${`${greeting.rig}, to the first view`}><${Mark} /><h1>${greeting.rig}</h1></a>
      <${Pill} state=${state} rig=${rig} />
      <nav aria-label="views">${VIEWS.filter((one) => !one.isHidden && (!one.needs || rig[one.needs] !== undefined)).map((one) => html`
        <a href=${`#/${one === FIRST ? '' : one.hash}`} aria-current=${one === view ? 'page' : null}>${one.title}</a>`)}</nav>
      <p class="facts">${facts(whole)}</p>
    </header>
    <main id="main" tabindex="-1">${refusals.map(([topic, what]) => html`<p class="refusal" role="alert">${topic} is refused: ${what}</p>`)}<${Loaded} key=${view.hash} view=${view} rig=${whole} path=${path} /></main>`;
}

function Mark() {
  return html`<svg viewBox="0 0 24 24" aria-hidden="true"><path d="M2 17h5l3-10 4 12 3-8h5" /></svg>`;
}

function Pill({ state, rig }) {
  const word = state === 'open' ? rig.state ?? 'asking' : STATES[state];
  const look = state !== 'open' || rig.state === 'away' ? 'down' : { ready: 'ok', paused: 'late', degraded: 'down' }[rig.state] ?? 'late';
  return html`<p class=${`pill ${look}`} role="status">${word}</p>`;
}

function facts(rig) {
  const parts = [`${rig.time} time`];
  if (rig.now_ns !== undefined) parts.push(`at ${(rig.now_ns / 1e9).toFixed(1)} s`);
  if (rig.uptime_s !== undefined) parts.push(`up ${duration(rig.uptime_s)}`);
  parts.push(role === 'look' ? 'looking only' : 'operating');
  return parts.join(', ');
}

function duration(seconds) {
  const whole = Math.floor(seconds);
  if (whole < 60) return `${whole} s`;
  return whole < 3600 ? `${Math.floor(whole / 60)} min` : `${Math.floor(whole / 3600)} h ${Math.floor((whole % 3600) / 60)} min`;
}

// The view itself once its module is there; another view is another component, which begins anew.
function Loaded({ view, rig, path }) {
  const [module, trouble] = useModule(view.load);
  if (trouble) return html`<p class="refusal" role="alert">${view.title} cannot be shown: ${trouble}</p>`;
  if (module === null) return null;
  const shown = html`<${module.View} rig=${rig} path=${path} role=${role} />`;
  return view.of && path ? html`<${Named} view=${view} name=${path}>${shown}<//>` : shown;
}

// What an address names, if the rig has it: a bookmark may be older than the rig file.
function Named({ view, name, children }) {
  const [rig] = useAnswer('rig');
  if (rig === null) return html`<p class="quiet" role="status">asking ...</p>`;
  const names = view.of.flatMap((sort) => Object.keys(rig[sort]));
  if (names.includes(name)) return children;
  const words = { devices: 'device', buses: 'bus' };
  return html`<section><h2>${view.title}</h2>
    <p class="refusal" role="alert">${rig.rig} has no ${view.of.map((sort) => words[sort]).join(' or ')} ${name}</p>
    <p class="ways">${names.map((one) => html`<a key=${one} href=${`#/${view.hash}/${encodeURIComponent(one)}`}>${one}</a>`)}</p></section>`;
}

// The address after the hash: `#/device/tank` is ["device", "tank"].
function useHash() {
  const read = () => location.hash.replace(/^#\/?/, '').split('/').map(decoded);
  const [parts, setParts] = useState(read);
  useLayoutEffect(() => {
    const take = () => { if (location.hash.startsWith('#/') || location.hash === '') setParts(read()); };
    addEventListener('hashchange', take);
    return () => removeEventListener('hashchange', take);
  }, []);
  return [parts[0], parts.slice(1).join('/')];
}

function decoded(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return part; // an address that somebody typed
  }
}

function focusMain(event) {
  event.preventDefault();
  document.getElementById('main').focus();
}

const root = document.getElementById('app');
keepFocus(root, () => document.getElementById('main'));
render(html`<${App} />`, root);
live.open();
