// What the server sends, as typed arrays that look into the message itself. The numbers are those of topics.h and
// page_message.cpp.

export const Kind = { server: 0, frame: 1, robots: 2, tracks: 3, picture: 4, zoom: 5, status: 6, history: 7, camera: 8, detail: 9, calibration: 10 };

const kHeaderBytes = 64, kJsonHeaderBytes = 8;
export const kMarkerWords = 36, kBodyWords = 16;

export const warnings = ['id_undecided', 'poor_illumination', 'poor_white_balance', 'partly_hidden', 'ambiguous_pose',
  'id_carried', 'poor_fit', 'levels_learnt'];

const text = new TextDecoder();

/// The names of the bits of a marker's warnings.
export function warningNames(bits) {
  return Array.from({ length: 32 }, (_, bit) => (bits >>> bit) & 1 ? warnings[bit] ?? `warning_${bit}` : '').filter(Boolean);
}

function header(view, offset) {
  return {
    world: view.getUint8(offset + 1) !== 0,
    camera: view.getUint16(offset + 2, true),
    count: view.getUint32(offset + 4, true),
    sequence: view.getFloat64(offset + 8, true),
    captured: view.getFloat64(offset + 16, true),
    published: view.getFloat64(offset + 24, true),
    latency: view.getFloat32(offset + 48, true),
  };
}

/// A frame: `f` and `u` are its records as floats and as integers, kMarkerWords a marker.
function frame(buffer, offset) {
  const view = new DataView(buffer);
  const result = header(view, offset);
  result.dropped = view.getFloat64(offset + 32, true);
  result.width = view.getUint32(offset + 40, true);
  result.height = view.getUint32(offset + 44, true);
  result.f = new Float32Array(buffer, offset + kHeaderBytes, result.count * kMarkerWords);
  result.u = new Uint32Array(buffer, offset + kHeaderBytes, result.count * kMarkerWords);
  return result;
}

/// Robots or tracks: kBodyWords each, and their names.
function bodies(buffer) {
  const view = new DataView(buffer);
  const result = header(view, 0);
  result.f = new Float32Array(buffer, kHeaderBytes, result.count * kBodyWords);
  result.u = new Uint32Array(buffer, kHeaderBytes, result.count * kBodyWords);
  result.names = JSON.parse(text.decode(new Uint8Array(buffer, view.getUint32(56, true))));
  return result;
}

function picture(buffer) {
  const view = new DataView(buffer);
  const frameBytes = view.getUint32(4, true);
  return {
    camera: view.getUint16(2, true),
    sequence: view.getFloat64(8, true),
    captured: view.getFloat64(16, true),
    region: [0, 1, 2, 3].map(i => view.getUint16(32 + 2 * i, true)),
    imageWidth: view.getUint32(40, true),
    imageHeight: view.getUint32(44, true),
    frame: frameBytes ? frame(buffer, kHeaderBytes) : null,
    jpeg: new Uint8Array(buffer, kHeaderBytes + frameBytes),
  };
}

/// { kind, camera, … } of a message.
export function decode(buffer) {
  const view = new DataView(buffer);
  const kind = view.getUint8(0);
  switch (kind) {
    case Kind.frame: return { kind, ...frame(buffer, 0) };
    case Kind.robots: case Kind.tracks: return { kind, ...bodies(buffer) };
    case Kind.picture: case Kind.zoom: return { kind, ...picture(buffer) };
    default:
      return { kind, camera: view.getUint16(2, true), json: JSON.parse(text.decode(new Uint8Array(buffer, kJsonHeaderBytes))) };
  }
}

/// An id's text. Most fit into 32 bits, and large numbers cost a hundred times as much.
export function idOf(low, high) { return high ? (BigInt(high) << 32n | BigInt(low)).toString() : String(low); }

/// A marker of a frame, by its place in it.
export function marker(frame, index) {
  const at = index * kMarkerWords, { f, u } = frame;
  return {
    index,
    id: idOf(u[at], u[at + 1]),
    hasId: (u[at + 2] & 1) !== 0,
    hasPose: (u[at + 2] & 2) !== 0,
    family: (u[at + 2] >>> 8) & 255,
    warnings: u[at + 3],
    rows: u[at + 4] & 255, cols: (u[at + 4] >>> 8) & 255, cornersUsed: u[at + 4] >>> 16,
    bitsCorrected: u[at + 5],
    center: [f[at + 6], f[at + 7]],
    outline: f.subarray(at + 8, at + 16),
    axes: f.subarray(at + 16, at + 22),
    rms: f[at + 22], luminanceOverlap: f[at + 23], saturationOverlap: f[at + 24], ambiguity: f[at + 25],
    position: f.subarray(at + 26, at + 29), heading: f[at + 29], sigmaM: f[at + 30], sigmaRad: f[at + 31],
    ellipse: f.subarray(at + 32, at + 35), distance: f[at + 35],
  };
}

/// A robot or track, by its place in the message.
export function body(message, index) {
  const at = index * kBodyWords, { f, u } = message;
  const id = idOf(u[at], u[at + 1]);
  return {
    key: message.names[index] || id, name: message.names[index] || id, id,
    coasting: (u[at + 2] & 1) !== 0, offFloor: (u[at + 2] & 2) !== 0,
    x: f[at + 4], y: f[at + 5], z: f[at + 6], heading: f[at + 7],
    vx: f[at + 8], vy: f[at + 9], yawRate: f[at + 11],
    ellipse: f.subarray(at + 12, at + 15), unseen: f[at + 15],
  };
}
