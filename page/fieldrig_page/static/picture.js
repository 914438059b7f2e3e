// The rig as a picture: cards in a grid, placed by the rule of the server (layout.py), and alive by the topic `life`.
import { html } from 'htm/preact';
import { useLayoutEffect, useMemo, useRef, useState } from 'preact/hooks';
import { Events } from './events.js';
import { api, useAnswer, useLive, useModule, useWish } from './live.js';
import { Card, familyOf } from './picture/card.js';
import { Chosen } from './picture/chosen.js';
import { EMPTY, reduce } from './picture/life.js';
import { Ring } from './picture/ring.js';

const MOST_SIGNALS = 6;
const SAMPLED_NS = 10_000_000;  // often enough for a first look, and seldom enough for any host
const SMALL = 8;  // devices of a rig that leaves room for the scope beside its picture
const NOTHING = {};

export function View({ role }) {
  const [graph, refusal] = useAnswer('rig');
  const life = useLive('life', reduce, EMPTY);
  useWish('life', true);
  if (refusal && !graph) return html`<p class="refusal" role="alert">${refusal.what} ${refusal.remedy}</p>`;
  if (!graph) return html`<p class="quiet">The picture is loading.</p>`;
  const isSmall = Object.keys(graph.devices).length <= SMALL;
  const picture = html`<${Picture} graph=${graph} life=${life} mayOperate=${role === 'operate'} isSmall=${isSmall} /><${Events} events=${life.events} buses=${graph.buses} />`;
  if (!isSmall) return picture;
  return html`<div class="with-scope"><div>${picture}</div><${Beside} role=${role} life=${life} names=${Object.keys(graph.devices)} /></div>`;
}

// The scope beside the picture of a small rig, with the first number of each card from the start.
function Beside({ role, life, names }) {
  const [module] = useModule(() => import('./scope/scope.js')), signals = useRef(null);
  const present = names.filter((name) => life.samples[name] && life.values[name]);  // a device that is down has none
  if (signals.current === null && present.length > 0) signals.current = present.flatMap((name) => firstNumber(life, name)).slice(0, MOST_SIGNALS);
  return module && signals.current && html`<${module.Scope} role=${role} signals=${signals.current} usual=${{ rhythm: SAMPLED_NS }} isCompact=${true} />`;
}

function firstNumber(life, name) {
  const now = life.samples[name].at(-1);
  const at = life.values[name].findIndex((_, place) => typeof now[place] === 'number');
  return at < 0 ? [] : [`${name}/${life.values[name][at].key}`];
}

function usePlaces(host) {
  const [width, setWidth] = useState(0);
  useLayoutEffect(() => {
    const sizes = new ResizeObserver(() => setWidth(Math.floor(host.current.clientWidth)));
    sizes.observe(host.current);
    return () => sizes.disconnect();
  }, []);
  return useAnswer(width ? `rig/layout?width=${width}` : null)[0];
}

function Picture({ graph, life, mayOperate, isSmall }) {
  const host = useRef(null), places = usePlaces(host);
  const [chosen, setChosen] = useState(null), [refusal, setRefusal] = useState(null);
  const partners = useMemo(() => new Set(chosen ? graph.partners[chosen] : []), [chosen]);
  const act = (method, path, body) => api(method, path, body).then(() => setRefusal(null), setRefusal);
  const close = () => { host.current.querySelector(`[data-part="${chosen}"] .more`)?.focus(); setChosen(null); };
  const counts = `${counted(graph.devices, 'device', 'devices')}, ${counted(graph.buses, 'bus', 'buses')}`;
  const rings = Object.values(graph.buses).filter(bus => bus.shape === 'ring');
  return html`<section class="picture" aria-labelledby="picture-title"><h2 id="picture-title">Rig <small>${counts}</small><${Legend} /></h2>
    ${refusal && html`<p class="refusal" role="alert"><b>${refusal.what}</b> ${refusal.remedy}</p>`}
    <div class=${`cards ${isSmall ? 'large' : ''}`} ref=${host} style=${places ? gridOf(places) : {}}>
      ${places && html`${rings.map(bus => html`<${Ring} key=${bus.name} bus=${bus} host=${host} cuts=${life.parts[bus.name]?.cuts || NOTHING} mayOperate=${mayOperate} stamp=${places}
          onCut=${after => act('POST', 'faults', { part: bus.name, what: 'break', after })} onHeal=${number => act('DELETE', `faults/${bus.name}/${number}`)} />`)}
        ${places.strips.map(strip => html`<${Strip} key=${`${strip.bus} ${strip.row} ${strip.first}`} strip=${strip} bus=${graph.buses[strip.bus]} part=${life.parts[strip.bus] || NOTHING} places=${places} />`)}
        ${Object.entries(places.cards).map(([name, cell]) => html`<${Card} key=${name} device=${graph.devices[name]} part=${life.parts[name] || NOTHING}
          keys=${life.values[name] || []} samples=${life.samples[name] || []} buses=${graph.buses} ports=${portsOf(graph, places, name)} ring=${graph.devices[name].buses.find(bus => graph.buses[bus].shape === 'ring')}
          place=${{ gridRow: rowOf(places, cell.row) + places.levels[cell.row], gridColumn: cell.column + 1 }}
          isChosen=${chosen === name} isPartner=${partners.has(name)} onChoose=${() => setChosen(chosen === name ? null : name)} />`)}`}
    </div>
    ${chosen && html`<${Chosen} name=${chosen} graph=${graph} part=${life.parts[chosen] || NOTHING} mayOperate=${mayOperate} onChoose=${setChosen} onClose=${close} />`}
    <${Cables} graph=${graph} life=${life} places=${places} /></section>`;
}

const counted = (parts, one, many) => `${Object.keys(parts).length} ${Object.keys(parts).length === 1 ? one : many}`;

const Legend = () => html`<small class="legend"><span class="pill ok">ready</span> <span class="pill late">late</span> <span class="pill fault">fault</span> <span class="pill down">down</span></small>`;

// The first row of the grid that belongs to a row of cards: its strips come before the cards.
const rowOf = (places, row) => 1 + places.levels.slice(0, row).reduce((sum, levels) => sum + levels + 1, 0);
const gridOf = places => ({
  gridTemplateColumns: `repeat(${places.columns}, minmax(0, 1fr))`,
  gridTemplateRows: places.levels.map(levels => `${'20px '.repeat(levels)}auto`).join(' '),
});

const isOver = (strip, cell) => strip.row === cell.row && strip.first <= cell.column && cell.column <= strip.last;
// The line of a ring leads through its cards, so they need no label for it.
const portsOf = (graph, places, name) => graph.devices[name].buses.filter(bus =>
  !['wires', 'ring'].includes(graph.buses[bus].shape) && !places.strips.some(strip => strip.bus === bus && isOver(strip, places.cards[name])));

function Strip({ strip, bus, part, places }) {
  const place = { gridRow: rowOf(places, strip.row) + places.levels[strip.row] - 1 - strip.level, gridColumn: `${strip.first + 1} / ${strip.last + 2}` };
  const level = part.level || 'unknown';
  return html`<div class=${`strip ${familyOf(bus)}`} style=${place} data-part=${strip.is_again ? null : bus.name}><a href=${`#/bus/${bus.name}`}>${bus.name}</a>
    ${!strip.is_again && html`<span class="load">${part.load || bus.kind}</span>${level !== 'ok' && html`<span class="pill ${level}">${part.word || '…'}</span>`}`}</div>`;
}

const isIdle = part => !part.load || part.load.startsWith('0 ');

// Cables and wires have no strip: they are listed below the cards with their loads.
function Cables({ graph, life, places }) {
  const listed = Object.values(graph.buses).filter(bus => !places?.strips.some(strip => strip.bus === bus.name));
  return listed.length > 0 && html`<ul class="cables" aria-label="cables and wires">${listed.map(bus => { const part = life.parts[bus.name] || NOTHING, level = part.level || 'unknown';
    return html`<li key=${bus.name} data-part=${bus.name}><a class="port ${familyOf(bus)}" href=${`#/bus/${bus.name}`}>${bus.name}</a> <span class="load" title=${bus.kind}>${isIdle(part) ? '' : part.load}</span>${level !== 'ok' && level !== 'unknown' && html` <span class="pill ${level}">${part.word}</span>`}</li>`; })}</ul>`;
}

