// MessagePack (github.com/msgpack/msgpack/blob/master/spec.md), as much of it as the page and its server use.
// Integers beyond 2^53, such as instants, lose their last digits; values of that size come as texts.  Binary data becomes an
// ArrayBuffer of its own, as typed arrays need alignment.  The server sends no extensions.

import { named } from './named.js';

const utf8 = new TextDecoder();
const toUtf8 = new TextEncoder();

export function decode(buffer) {
  return new Reader(buffer).value();
}

class Reader {
  constructor(buffer) {
    this.buffer = buffer;
    this.view = new DataView(buffer);
    this.at = 0;
  }

  number(method, size) {
    const value = this.view[method](this.at);
    this.at += size;
    return Number(value);
  }

  text(length) {
    const bytes = new Uint8Array(this.buffer, this.at, length);
    this.at += length;
    return utf8.decode(bytes);
  }

  binary(length) {
    this.at += length;
    return this.buffer.slice(this.at - length, this.at);
  }

  array(length) {
    return Array.from({ length }, () => this.value());
  }

  map(length) {
    const found = named();
    for (let left = length; left > 0; left -= 1) {
      const key = this.value();
      found[key] = this.value();
    }
    return found;
  }

  value() {
    const head = this.number('getUint8', 1);
    if (head < 0x80) return head;
    if (head < 0x90) return this.map(head & 0x0f);
    if (head < 0xa0) return this.array(head & 0x0f);
    if (head < 0xc0) return this.text(head & 0x1f);
    if (head >= 0xe0) return head - 0x100;
    const read = FORMATS[head];
    if (!read) throw new Error(`MessagePack has no value that begins with ${head}, or the server never sends it`);
    return read(this);
  }
}

const length = { 1: 'getUint8', 2: 'getUint16', 4: 'getUint32' };
const sized = (kind, size) => (reader) => reader[kind](reader.number(length[size], size));
const plain = (method, size) => (reader) => reader.number(method, size);

// The table "Formats" of the specification, row by row.
const FORMATS = {
  0xc0: () => null,
  0xc2: () => false,
  0xc3: () => true,
  0xc4: sized('binary', 1),
  0xc5: sized('binary', 2),
  0xc6: sized('binary', 4),
  0xca: plain('getFloat32', 4),
  0xcb: plain('getFloat64', 8),
  0xcc: plain('getUint8', 1),
  0xcd: plain('getUint16', 2),
  0xce: plain('getUint32', 4),
  0xcf: plain('getBigUint64', 8),
  0xd0: plain('getInt8', 1),
  0xd1: plain('getInt16', 2),
  0xd2: plain('getInt32', 4),
  0xd3: plain('getBigInt64', 8),
  0xd9: sized('text', 1),
  0xda: sized('text', 2),
  0xdb: sized('text', 4),
  0xdc: sized('array', 2),
  0xdd: sized('array', 4),
  0xde: sized('map', 2),
  0xdf: sized('map', 4),
};

export function encode(value) {
  const bytes = [];
  write(value, bytes);
  return new Uint8Array(bytes);
}

function write(value, bytes) {
  if (value === null || value === undefined) bytes.push(0xc0);
  else if (value === false || value === true) bytes.push(value ? 0xc3 : 0xc2);
  else if (typeof value === 'number') writeNumber(value, bytes);
  else if (typeof value === 'string') writeText(value, bytes);
  else if (Array.isArray(value)) {
    writeSized(bytes, 0xdd, value.length);
    for (const item of value) write(item, bytes);
  } else {
    const entries = Object.entries(value);
    writeSized(bytes, 0xdf, entries.length);
    for (const [key, item] of entries) {
      writeText(key, bytes);
      write(item, bytes);
    }
  }
}

function writeNumber(value, bytes) {
  const view = new DataView(new ArrayBuffer(8));
  const isWhole = Number.isSafeInteger(value);
  if (isWhole) view.setBigInt64(0, BigInt(value));
  else view.setFloat64(0, value);
  bytes.push(isWhole ? 0xd3 : 0xcb, ...new Uint8Array(view.buffer));
}

function writeText(value, bytes) {
  const data = toUtf8.encode(value);
  writeSized(bytes, 0xdb, data.length);
  for (const byte of data) bytes.push(byte);
}

// The longest form of a length is always right, and the page sends little.
function writeSized(bytes, head, size) {
  bytes.push(head, size >>> 24, (size >>> 16) & 255, (size >>> 8) & 255, size & 255);
}
