// What is known of the chosen card: why it is as it is, its wires with values and units, its partners, and its power.
import { html } from 'htm/preact';
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks';
import { api, useLive, useWish } from '../live.js';
import { named } from '../named.js';
import { familyOf } from './card.js';
import { show } from './life.js';

const POWER_OFF = 'power_off', NONE = named();

export function Chosen({ name, graph, part, mayOperate, onChoose, onClose }) {
  const device = graph.devices[name], wires = useWires(name), [refusal, setRefusal] = useState(null), close = useRef(null);
  useEffect(() => setRefusal(null), [name]);
  useLayoutEffect(() => close.current?.focus(), [name]); // a later one took the focus that closing had given back to the card
  const own = graph.wires.filter(wire => wire.publisher === name || wire.readers.includes(name));
  const act = (method, path, body) => api(method, path, body).then(() => setRefusal(null), setRefusal);
  const others = wire => (wire.publisher === name ? wire.readers : [wire.publisher]);
  const onKey = event => { if (event.key === 'Escape') onClose(); };
  return html`<aside class="chosen-part" aria-label=${`about ${name}`} onKeyDown=${onKey}>
    <h2><a href=${`#/device/${name}`}>${name}</a> <span class="pill ${part.level}">${part.word}</span>
      <button ref=${close} class="plain" aria-label="close" onClick=${onClose}>✕</button></h2>
    <div class="body">
      <p class="quiet">${device.about}</p>
      ${(part.why || []).length > 0 && html`<ul class="why">${part.why.map(line => html`<li>${line}</li>`)}</ul>`}
      <dl class="facts"><div><dt>kind</dt><dd><code>${device.kind}</code></dd></div><div><dt>process</dt><dd>${device.process}${part.restarts ? `, ${part.restarts} restarts` : ''}</dd></div>
        <div><dt>buses</dt><dd>${device.buses.map(bus => html`<a class="port ${familyOf(graph.buses[bus])}" href=${`#/bus/${bus}`}>${bus}</a> `)}</dd></div></dl>
      ${own.length > 0 && html`<table class="wires"><caption>Wires</caption><thead><tr><th scope="col">wire</th><th scope="col" class="number">value</th><th scope="col">joins</th></tr></thead><tbody>
        ${own.map(wire => { const now = wires[`${wire.bus}/${wire.name}`]; return html`<tr key=${wire.name}><th scope="row">${wire.publisher === name ? '→' : '←'} ${wire.name}</th>
          <td class="number">${now ? html`${show(now[0])} <span class="unit">${now[1]}</span>` : '–'}</td><td>${others(wire).map(other => html`<button class="link" onClick=${() => onChoose(other)}>${other}</button> `)}</td></tr>`; })}</tbody></table>`}
      ${refusal && html`<p class="refusal" role="alert"><b>${refusal.what}</b> ${refusal.remedy}</p>`}
      ${mayOperate && html`<p class="row">${part.off === undefined
        ? html`<button onClick=${() => act('POST', 'faults', { part: name, what: POWER_OFF })}>Power off</button>`
        : html`<button class="main" onClick=${() => act('DELETE', `faults/${name}/${part.off}`)}>Power on</button>`}
        <button onClick=${() => act('POST', `restart/${name}`)}>Restart</button><a class="button" href=${`#/device/${name}`}>Open</a></p>`}
    </div></aside>`;
}

// The present values of the wires of a device, by BUS/WIRE: value and unit.
function useWires(name) {
  const wires = useLive('wires', (before, frame) => (frame.whole ? frame.values : named(before, frame.values)), NONE);
  useWish('wires', name);
  return wires;
}
