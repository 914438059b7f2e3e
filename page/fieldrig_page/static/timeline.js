// The time line of a scenario or a finding: what was done, the signals of its properties, and where one does not hold.
import { html } from 'htm/preact';
import { useEffect, useState } from 'preact/hooks';
import { api, useAnswer } from './live.js';

const MS = 1e6, TICKS = 4, HEIGHT = 30, WIDTH = 1000;
// Windows up to the end, in milliseconds; 0 is the whole.
const WINDOWS = [[0, 'the whole'], [1000, 'the last second'], [200, 'the last 200 ms'], [50, 'the last 50 ms']];

export function View({ rig, role }) {
  if (rig.state === undefined) return html`<section><h2>Time line</h2><p class="quiet" role="status">asking ...</p></section>`;
  if (rig.prelude === undefined) return html`<section><h2>Time line</h2><p class="refusal"><b>this rig has not been played a scenario</b> <code>fieldrig scenario open FILE</code> starts one that has</p></section>`;
  return html`<${Played} rig=${rig} role=${role} />`;
}

function Played({ rig, role }) {
  const [times, setTimes] = useState(0), [line] = useAnswer('timeline', times);
  const isThere = line?.is_there === true;
  useEffect(() => {
    if (isThere) return undefined;
    const timer = setTimeout(() => setTimes(times + 1), 500);
    return () => clearTimeout(timer);
  }, [isThere, times]);
  if (!isThere) return html`<section><h2>Time line</h2><p class="quiet" role="status">the scenario is played ...</p></section>`;
  return html`<${Line} line=${line} rig=${rig} mayOperate=${role === 'operate'} />`;
}

function Line({ line, rig, mayOperate }) {
  const [last, setLast] = useState(0), [refusal, setRefusal] = useState(null);
  const to = line.length_ns, from = last === 0 ? 0 : Math.max(0, to - last * MS);
  const now = (rig.now_ns ?? 0) - line.begin_ns;
  const go = async ns => {
    try { await api('POST', 'rig/back', { to: `${line.begin_ns + ns} ns` }); setRefusal(null); } catch (cause) { setRefusal(cause); }
  };
  const window = { from, span: Math.max(1, to - from) };
  return html`<section aria-labelledby="line" class="timeline"><h2 id="line">${line.name}</h2>
    ${line.violations.map(one => html`<div key=${one.property} class="violation"><p class="row"><span class="pill down">does not hold</span><b>${one.property}</b></p>
      <p>${one.told[0]}</p></div>`)}
    ${line.violations.length === 0 && html`<p class="row"><span class="pill ok">all hold</span></p>`}
    ${refusal && html`<p class="refusal" role="alert"><b>${refusal.what}</b> ${refusal.remedy}</p>`}
    <label class="field">shown<select value=${last} onChange=${event => setLast(Number(event.target.value))}>
      ${WINDOWS.filter(([ms]) => ms * MS < to).map(([ms, words]) => html`<option key=${ms} value=${ms}>${words}</option>`)}</select></label>
    <div class="lanes">
      <${Lane} name="actions and faults" window=${window} line=${line} now=${now}>${line.acts.map((act, number) => inside(window, act.at_ns) && html`<path key=${number} class=${`act ${act.verb}`} d=${`M${x(window, act.at_ns)} 2V${HEIGHT - 2}`} />`)}<//>
      ${line.signals.map(signal => html`<${Lane} key=${signal.place} name=${signal.place} value=${shown(valueAt(signal.changes, now))} window=${window} line=${line} now=${now}><path class="signal" d=${stepped(signal.changes, window)} /><//>`)}
      <p class="ticks" aria-hidden="true">${Array.from({ length: TICKS + 1 }, (_, tick) => html`<span key=${tick}>${((from + window.span * tick / TICKS) / MS).toFixed(window.span < 100 * MS ? 1 : 0)} ms</span>`)}</p>
    </div>
    <${Happened} line=${line} now=${now} from=${from} mayGo=${mayOperate} go=${go} /></section>`;
}

function Lane({ name, value, window, line, now, children }) {
  return html`<div class="lane"><p><span>${name}</span>${value !== undefined && html`<output>${value}</output>`}</p>
    <svg viewBox=${`0 0 ${WIDTH} ${HEIGHT}`} preserveAspectRatio="none" role="img" aria-label=${`${name} over time`}>${children}
      ${line.violations.map(one => inside(window, one.at_ns) && html`<path key=${one.property} class="broken" d=${`M${x(window, one.at_ns)} 0V${HEIGHT}`} />`)}
      ${inside(window, now) && html`<path class="now" d=${`M${x(window, now)} 0V${HEIGHT}`} />`}</svg></div>`;
}

// Everything that happened, as a table: also for those who do not see the lanes.
function Happened({ line, now, from, mayGo, go }) {
  const changes = line.signals.flatMap(({ place, changes }) => changes.filter(([at]) => at > 0 && at >= from).map(([at, value]) => ({ at, kind: 'signal', what: `${place} = ${shown(value)}` })));
  const acts = line.acts.filter(act => act.at_ns >= from).map(act => ({ at: act.at_ns, kind: act.verb === 'fault' ? 'fault' : 'action', what: act.what }));
  const broken = line.violations.map(one => ({ at: one.at_ns, kind: 'violation', what: one.property }));
  const order = ['action', 'fault', 'signal', 'violation'];
  const rows = [...acts, ...changes, ...broken].sort((one, other) => one.at - other.at || order.indexOf(one.kind) - order.indexOf(other.kind)).slice(-200);
  return html`<div class="wide"><table><caption class="hidden">what happened</caption><thead><tr><th class="number">time</th><th>kind</th><th>what</th></tr></thead>
    <tbody>${rows.map((row, number) => html`<tr key=${number} class=${row.kind === 'violation' ? 'wrong' : ''}><td class="number"><button class="link" disabled=${!mayGo || row.at > now} aria-label=${`back to ${time(row.at)}`} onClick=${() => go(row.at)}>${time(row.at)}</button></td><td>${row.kind}</td><td>${row.what}</td></tr>`)}</tbody></table></div>`;
}

const inside = (window, at) => at >= window.from && at <= window.from + window.span;
const x = (window, at) => Math.round((at - window.from) / window.span * WIDTH * 10) / 10;
const shown = value => (typeof value === 'number' && !Number.isInteger(value) ? value.toPrecision(4) : String(value));
const time = ns => `${(ns / MS).toFixed(ns % MS === 0 ? 0 : 3)} ms`;

function valueAt(changes, at) {
  const before = changes.filter(([since]) => since <= at);
  return (before.at(-1) ?? changes[0])[1];
}

// A stepped line between the least and the greatest value; texts count in the order in which they came.
function stepped(changes, window) {
  const texts = [...new Set(changes.map(([, value]) => value).filter(value => typeof value === 'string'))];
  const numbers = changes.map(([at, value]) => [at, typeof value === 'string' ? texts.indexOf(value) : Number(value)]);
  const values = numbers.map(([, value]) => value), low = Math.min(...values, 0), high = Math.max(...values, low + 1);
  const y = value => Math.round((HEIGHT - 4 - (value - low) / (high - low) * (HEIGHT - 8)) * 10) / 10;
  const before = numbers.filter(([at]) => at <= window.from).at(-1) ?? numbers[0];
  const later = numbers.filter(([at]) => at > window.from && at <= window.from + window.span);
  return `M0 ${y(before[1])}${later.map(([at, value]) => `H${x(window, at)}V${y(value)}`).join('')}H${WIDTH}`;
}
