// Operating parts of a front: by the HTTP API, each part's calls one after the other, so that a release never
// overtakes its press.
import { useEffect, useRef, useState } from 'preact/hooks';
import { api, inPath, live } from '../live.js';

// How the server names this page; with it a key that is held goes up when the socket of this page goes.
let page = '';
live.on('front', (message) => { if (message.page) ({ page } = message); });

const lines = new Map();

// Operates a part, such as operate('panel', 'key.F1', true).  Rejects with a Refusal.
export function operate(device, name, value) {
  const id = `${device} ${name}`;
  const path = `devices/${encodeURIComponent(device)}/front/${inPath(name)}`;
  const before = lines.get(id) ?? Promise.resolve();
  const done = before.catch(() => {}).then(() => api('POST', path, { value, page }));
  lines.set(id, done);
  return done;
}

// Handlers of a button that is down as long as it is held, by pointer or by keyboard.  It goes up when the pointer
// leaves it, when the page loses the focus or is hidden, and when the connection is lost.
export function useHeld(onChange) {
  const [isDown, setIsDown] = useState(false);
  const now = useRef({ isDown: false, onChange });
  now.current.onChange = onChange;
  const move = (next) => {
    if (now.current.isDown === next) return;
    now.current.isDown = next;
    setIsDown(next);
    now.current.onChange(next);
  };
  useEffect(() => {
    const release = () => move(false);
    const offState = live.on('state', (message) => { if (message.state !== 'open') release(); });
    addEventListener('blur', release);
    document.addEventListener('visibilitychange', release);
    return () => {
      release();
      offState();
      removeEventListener('blur', release);
      document.removeEventListener('visibilitychange', release);
    };
  }, []);
  const isKey = (event) => event.key === ' ' || event.key === 'Enter';
  return [isDown, {
    onPointerDown: (event) => { if (event.button === 0) move(true); },
    onPointerUp: () => move(false),
    onPointerLeave: () => move(false),
    onPointerCancel: () => move(false),
    onBlur: () => move(false),
    onContextMenu: (event) => event.preventDefault(), // a long touch would open a menu instead of holding the key
    onKeyDown: (event) => { if (isKey(event)) { event.preventDefault(); if (!event.repeat) move(true); } },
    onKeyUp: (event) => { if (isKey(event)) { event.preventDefault(); move(false); } },
  }];
}
