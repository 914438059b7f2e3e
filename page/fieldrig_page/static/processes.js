// The processes of the rig: their states and figures, and a restart of each.
import { html } from 'htm/preact';
import { useState } from 'preact/hooks';
import { api } from './live.js';

const FIGURES = ['restarts', 'MB with shared', 'CPU s', 'late at most', 'cycles kept'];

export function View({ rig, role, kept = {} }) {
  const [refusal, setRefusal] = useState(null);
  const processes = Object.entries(rig.processes ?? {});
  const restart = async (name) => {
    try {
      await api('POST', `restart/${name}`);
      setRefusal(null);
    } catch (cause) {
      setRefusal(cause);
    }
  };
  return html`<section aria-labelledby="processes">
    <h2 id="processes">Processes</h2>
    ${refusal && html`<p class="refusal" role="alert">${refusal.what}${refusal.remedy && `; ${refusal.remedy}`}</p>`}
    <div class="wide" tabindex="0" role="region" aria-label="table of the processes"><table>
      <thead><tr><th>process</th><th>state</th>${FIGURES.map((title) => html`<th class="number">${title}</th>`)}<th>runs</th>
        ${role === 'operate' && html`<th>do</th>`}</tr></thead>
      <tbody>${processes.map(([name, process]) => html`<tr key=${name}>
        <th scope="row">${name}</th>
        <td><span class=${`pill ${look(process)}`}>${look(process) === 'late' && process.state === 'ready' ? 'late' : process.state}</span></td>
        <td class="number">${process.restarts ?? ''}</td>
        <td class="number">${process.memory_mb ?? ''}</td>
        <td class="number">${process.cpu_s ?? ''}</td>
        <td class="number">${process.late ? `${process.late.worst_ms.toFixed(1)} ms` : ''}</td>
        <td class="number">${kept[name] === undefined ? '' : `${kept[name]} %`}</td>
        <td>${[...(process.buses ?? []), ...(process.devices ?? [])].join(', ')}</td>
        ${role === 'operate' && html`<td>${process.restarts !== undefined && html`
          <button onClick=${() => restart(name)} aria-label=${`Restart ${name}`}>Restart</button>`}</td>`}
      </tr>`)}</tbody>
    </table></div>
  </section>`;
}

function look(process) {
  if (process.state === 'ready') return process.late?.words ? 'late' : 'ok';
  return process.state === 'dead' || process.state === 'gone' ? 'down' : 'late';
}
