// The focus of the keyboard is never lost: what is pressed may vanish, or not be for pressing any more, and then the focus
// goes to its neighbour.  Who uses a pointer or a finger is left alone, as a field with the focus opens a keyboard.

const CAN_HAVE_IT = 'a[href], button:not(:disabled), input:not(:disabled), select:not(:disabled), textarea, summary, [tabindex="0"]';

// Watches everything in `root`; `home()` is where the focus goes if the view is another one.
export function keepFocus(root, home) {
  let last = null; // what has the focus by the keyboard, and its places in what is around it, from inside out
  root.addEventListener('focusin', ({ target }) => { last = target.matches(':focus-visible') ? { target, around: around(target, root) } : null; });
  // What vanishes is left before it is gone, so whether it is shows after that.
  root.addEventListener('focusout', ({ target }) => queueMicrotask(() => { if (last?.target === target && !isGone(target)) last = null; }));
  addEventListener('hashchange', () => { if (last) last.around = []; });
  const look = () => {
    if (last === null || !isGone(last.target)) return;
    const { target, around: places } = last;
    last = null;
    (neighbour(target, places) ?? home())?.focus();
  };
  new MutationObserver(look).observe(root, { subtree: true, childList: true, attributes: true, attributeFilter: ['disabled'] });
}

const isGone = (target) => !target.isConnected || target.disabled === true;

function around(target, root) {
  const places = [];
  for (let parent = target.parentElement; parent && parent !== root; parent = parent.parentElement)
    places.push({ parent, place: [...parent.querySelectorAll(CAN_HAVE_IT)].indexOf(target) });
  return places;
}

function neighbour(target, places) {
  for (const { parent, place } of places) {
    if (!parent.isConnected) continue;
    const others = [...parent.querySelectorAll(CAN_HAVE_IT)].filter((one) => one.checkVisibility());
    // One that is there, and off, has its counterpart before it; in the place of one that has vanished is the next.
    const found = target.isConnected ? others.findLast((one) => isBefore(one, target)) : others[place];
    if (found ?? others.at(-1)) return found ?? (target.isConnected ? others[0] : others.at(-1));
  }
  return null;
}

const isBefore = (one, other) => (one.compareDocumentPosition(other) & Node.DOCUMENT_POSITION_FOLLOWING) !== 0;
