// What has happened: events of the rig, and faults and conditions that begin and end, the newest first.
import { html } from 'htm/preact';

const time = seconds => new Date(seconds * 1000).toLocaleTimeString('en-GB');

export function Events({ events, buses }) {
  return html`<section aria-labelledby="events"><h2 id="events">Events</h2>
    ${events.length === 0 ? html`<p class="quiet">Nothing has happened since this page’s server began.</p>` : html`<ol class="events" tabindex="0" aria-labelledby="events">
      ${[...events].reverse().map(event => html`<li key=${event.number}><time class="quiet">${time(event.time_s)}</time>
        <span>${event.part ? html`<a href=${`#/${buses[event.part] ? 'bus' : 'device'}/${event.part}`}>${event.part}</a>` : 'rig'}</span><span>${event.text}</span></li>`)}</ol>`}</section>`;
}
