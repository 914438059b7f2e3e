// The newest picture of the scope: a minimum and a maximum per pixel and row, by the number of the bucket.
// Both are NaN in a gap; without news, where the last value holds, they are Infinity and -Infinity.

export class Buckets {
  first = 0; // number of the bucket at the left edge
  count = 0;
  bucketNs = 1;
  offsetNs = 0; // instant of bucket 0
  before = []; // the value of each row that holds at the left edge
  #rows = [];

  get endNs() { return this.instant(this.first + this.count); }
  get firstNs() { return this.instant(this.first); }

  instant(number) { return number * this.bucketNs + this.offsetNs; }

  // Takes a frame of the topic.
  take(frame) {
    if (frame.bucket_ns === undefined) return;
    if (frame.whole) {
      this.before = frame.before;
      this.bucketNs = frame.bucket_ns;
      this.offsetNs = frame.offset_ns;
      this.#rows = frame.columns.map(() => new Row(frame.count + 2));
    }
    if (!frame.whole) this.#leave(frame.first);
    this.first = frame.first;
    this.count = frame.count;
    for (const part of frame.parts) {
      const low = new Float64Array(part.low); // decoded as a copy, so it is aligned
      const high = new Float64Array(part.high);
      part.rows.forEach((row, place) => {
        this.#rows[row]?.put(part.first, low.subarray(place * part.n, (place + 1) * part.n), high.subarray(place * part.n, (place + 1) * part.n));
      });
    }
  }

  // Keeps the values that hold at the new left edge.
  #leave(first) {
    for (let row = 0; row < this.#rows.length; row++) {
      for (let number = this.first; number < Math.min(first, this.first + this.count); number++) {
        const kept = this.#rows[row];
        if (!kept.has(number)) this.before[row] = null;
        else if (kept.low[kept.slot] !== Infinity) this.before[row] = kept.high[kept.slot];
      }
    }
  }

  // Calls `visit(place, low, high)` for each bucket on the screen from left to right.
  each(row, visit) {
    const kept = this.#rows[row];
    for (let place = 0; place < this.count; place++) {
      if (kept === undefined || !kept.has(this.first + place)) visit(place, NaN, NaN);
      else visit(place, kept.low[kept.slot], kept.high[kept.slot]);
    }
  }

  // The lowest and highest value on the screen; null if there is none.
  range(row) {
    const held = this.before[row] ?? NaN;
    let low = Infinity;
    let high = -Infinity;
    let isFirst = true;
    this.each(row, (_, a, b) => {
      if (a < low) low = a;
      if (b > high) high = b;
      if (isFirst && a === Infinity && held < low) low = held;
      if (isFirst && a === Infinity && held > high) high = held;
      isFirst = false;
    });
    return low <= high ? [low, high] : null;
  }

  // The newest value of a row; NaN in a gap.
  newest(row) {
    let value = this.before[row] ?? NaN;
    let last = NaN;
    this.each(row, (_, low, high) => {
      if (low !== Infinity && high === high) value = high;
      if (high === high) last = value;
    });
    return last;
  }
}

class Row {
  slot = 0;
  #begin = 0;
  #end = 0;

  constructor(length) {
    this.low = new Float64Array(length).fill(NaN);
    this.high = new Float64Array(length).fill(NaN);
  }

  put(first, low, high) {
    const length = this.low.length;
    if (first > this.#end || first < this.#begin) this.#begin = first; // what lies between is not known
    for (let place = Math.max(low.length - length, 0); place < low.length; place++) {
      const slot = mod(first + place, length);
      this.low[slot] = low[place];
      this.high[slot] = high[place];
    }
    this.#end = first + low.length;
    this.#begin = Math.max(this.#begin, this.#end - length);
  }

  // Finds the slot of a bucket; false if it is not here.
  has(number) {
    this.slot = mod(number, this.low.length);
    return number >= this.#begin && number < this.#end;
  }
}

function mod(number, length) {
  return ((number % length) + length) % length;
}
