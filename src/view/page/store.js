// What the page knows: of each camera the newest of everything, and what is kept of the last minutes.
import { Kind, body, idOf, kMarkerWords, marker } from './decode.js';

const kSilentMs = 2500, kTrailMs = 10000, kTrailStepMs = 100, kHistoryMs = 60000, kHistoryStepMs = 500, kLatencyMs = 60000;
const kMostNotices = 200, kTimelineRows = 600, kMostTracked = 2000;

export class Store extends EventTarget {
  cameras = [];
  server = null;
  connected = false;
  notices = [];

  camera(index) {
    return this.cameras[index] ??= {
      index, name: `camera ${index}`, prefix: '', frame: null, picture: null, zoom: null, robots: null, tracks: null,
      status: null, about: null, detail: null, calibration: null, calibrationHeard: 0, timeline: [], latencies: [], trails: new Map(), histories: new Map(),
      heard: 0, statusHeard: 0, silent: false, frames: 0, stamps: [],
    };
  }

  note(text, level = 'warn') {
    this.notices.push({ at: Date.now(), text, level });
    if (this.notices.length > kMostNotices) this.notices.shift();
    this.dispatchEvent(new Event('notice'));
  }

  setConnected(connected) {
    if (connected === this.connected) return;
    this.connected = connected;
    if (!connected) this.lostAt = Date.now();
    if (!connected) this.note('the view itself does not answer; trying again', 'bad');
    else if (this.lostAt) this.note(`the view answers again, after ${((Date.now() - this.lostAt) / 1000).toFixed(1)} s`, 'good');
    this.dispatchEvent(new Event('link'));
  }

  take(message) {
    if (message.kind === Kind.server) return this.takeServer(message.json);
    const camera = this.camera(message.camera);
    switch (message.kind) {
      case Kind.frame: this.takeFrame(camera, message); break;
      case Kind.robots: camera.robots = message; this.trail(camera, message); break;
      case Kind.tracks: camera.tracks = message; this.trail(camera, message); break;
      case Kind.picture: this.takePicture(camera, message, 'picture'); break;
      case Kind.zoom: this.takePicture(camera, message, 'zoom'); break;
      case Kind.status: this.takeStatus(camera, message.json); break;
      case Kind.history: camera.timeline = message.json.rows; break;
      case Kind.camera: camera.about = message.json; break;
      case Kind.detail: camera.detail = message.json; break;
      case Kind.calibration: this.takeCalibration(camera, message.json); break;
    }
    this.dispatchEvent(new CustomEvent('news', { detail: { kind: message.kind, camera } }));
  }

  takeServer(server) {
    if (this.server && this.server.instance !== server.instance) {
      this.note('the view was started anew', 'warn');
      this.cameras = [];
    }
    if (server.trouble && this.server?.trouble !== server.trouble) this.note(server.trouble, 'bad');
    if (!server.trouble && this.server?.trouble) this.note('LCM is heard again', 'good');
    this.server = server;
    server.cameras.forEach(({ prefix, name }, i) => Object.assign(this.camera(i), { prefix, name }));
    this.dispatchEvent(new Event('server'));
  }

  takeFrame(camera, frame) {
    const now = performance.now();
    camera.frame = frame;
    camera.heard = now;
    ++camera.frames;
    camera.stamps.push(now);
    while (camera.stamps[0] < now - 2000) camera.stamps.shift();
    camera.latencies.push([now, frame.latency]);
    while (camera.latencies[0][0] < now - kLatencyMs) camera.latencies.shift();
    if (now >= (camera.nextSample ?? 0)) {
      camera.nextSample = now + kHistoryStepMs;
      this.sample(camera, frame, now);
    }
    if (!camera.tracks && !camera.robots) this.trail(camera, frame);
  }

  /// Twice a second, of every marker: what its history shows.
  sample(camera, frame, now) {
    const { f, u } = frame;
    for (let i = 0, at = 0; i < frame.count; ++i, at += kMarkerWords) {
      if ((u[at + 2] & 1) === 0) continue;
      const key = `${(u[at + 2] >>> 8) & 255}/${idOf(u[at], u[at + 1])}`;
      let rows = camera.histories.get(key);
      if (!rows) {
        if (camera.histories.size >= kMostTracked) camera.histories.delete(camera.histories.keys().next().value);
        camera.histories.set(key, rows = []);
      }
      rows.push({ now, x: f[at + 26], y: f[at + 27], z: f[at + 28], rms: f[at + 22], luminance: f[at + 23], saturation: f[at + 24] });
      while (rows[0].now < now - kHistoryMs) rows.shift();
    }
  }

  trail(camera, message) {
    const now = performance.now();
    if (now < (camera.nextTrail ?? 0)) return;
    camera.nextTrail = now + kTrailStepMs;
    for (const each of placesOf(camera, message)) {
      let trail = camera.trails.get(each.key);
      if (!trail) {
        if (camera.trails.size >= kMostTracked) camera.trails.delete(camera.trails.keys().next().value);
        camera.trails.set(each.key, trail = []);
      }
      trail.push([now, each.x, each.y]);
      while (trail[0][0] < now - kTrailMs) trail.shift();
    }
    if (now < (camera.nextSweep ?? 0)) return;
    camera.nextSweep = now + 2000;
    for (const [key, trail] of camera.trails) if (trail.at(-1)[0] < now - kTrailMs) camera.trails.delete(key);
  }

  /// Decodes one at a time of each camera; what comes meanwhile is replaced by what is newer.
  takePicture(camera, message, name) {
    const waiting = `${name}Waiting`, decoding = `${name}Decoding`;
    camera[waiting] = message;
    if (camera[decoding]) return;
    camera[decoding] = true;
    camera[waiting] = null;
    createImageBitmap(new Blob([message.jpeg], { type: 'image/jpeg' })).then(bitmap => {
      camera[name]?.bitmap.close();
      camera[name] = { ...message, bitmap, at: performance.now() };
    }, () => this.note(`${camera.name}: a picture was damaged`, 'warn')).finally(() => {
      camera[decoding] = false;
      if (camera[waiting]) this.takePicture(camera, camera[waiting], name);
    });
  }

  takeStatus(camera, status) {
    const before = camera.status;
    camera.status = status;
    camera.statusHeard = performance.now();
    if (camera.silent) this.note(`${camera.name} is heard again`, 'good');
    camera.silent = false;
    camera.timeline.push(timelineRow(status, before));
    if (camera.timeline.length > kTimelineRows) camera.timeline.shift();
    if (!before) return;
    if (status.detections.instance !== before.detections.instance) this.note(`${camera.name}: chequerd was started anew ${status.uptime_s.toFixed(0)} s ago`, 'warn');
    if (status.camera_state !== before.camera_state) {
      const why = status.camera_message ? `: ${status.camera_message}` : '';
      this.note(`${camera.name}: camera ${status.camera_state}${why}`, status.camera_state === 'running' ? 'good' : 'bad');
    }
    const lost = status.frames_dropped - before.frames_dropped;
    if (lost > 0 && lost >= 0.5 * status.capture_rate_hz) this.note(`${camera.name}: ${lost} frames were lost within a second`, 'warn');
  }

  takeCalibration(camera, calibration) {
    const before = camera.calibration?.state;
    camera.calibration = calibration;
    camera.calibrationHeard = performance.now();
    if (calibration.state === before) return;
    if (calibration.state === 'done') this.note(`${camera.name}: the ${calibration.kind} is calibrated`, 'good');
    if (calibration.state === 'failed') this.note(`${camera.name}: the ${calibration.kind} is not calibrated: ${calibration.advice}`, 'bad');
  }

  /// To be called now and then: notices who is not heard any more.
  watch() {
    if (!this.connected || document.hidden) return;
    const now = performance.now();
    for (const camera of this.cameras) {
      if (!camera?.statusHeard || camera.silent || now - camera.statusHeard < kSilentMs) continue;
      if (this.server?.replay && !this.server.replay.playing) continue;
      camera.silent = true;
      this.note(`${camera.name} is not heard any more: chequerd was stopped, or LCM does not reach this host`, 'bad');
    }
  }

  /// A page that was hidden has heard nothing; that is no silence.
  wake() {
    for (const camera of this.cameras) if (camera) camera.statusHeard = performance.now();
  }
}

function timelineRow(status, before) {
  const total = status.stages.find(stage => stage.stage === 'total') ?? { median_ms: 0, p99_ms: 0 };
  return [status.utc_ms, status.capture_rate_hz, status.publish_rate_hz, status.markers_mean, total.median_ms, total.p99_ms,
    before ? Math.max(0, status.frames_dropped - before.frames_dropped) : 0, status.detections.deferred ?? 0,
    ['waiting', 'running', 'ended'].indexOf(status.camera_state)];
}

/// Who is where: robots and tracks, or without them the markers of a frame.
export function places(message) {
  if (message.names) return Array.from({ length: message.count }, (_, i) => body(message, i));
  const result = [];
  for (let i = 0; i < message.count; ++i) {
    const each = marker(message, i);
    if (!each.hasId || !each.hasPose) continue;
    result.push({ key: each.id, name: each.id, id: each.id, x: each.position[0], y: each.position[1], z: each.position[2],
      heading: each.heading, vx: NaN, vy: NaN, yawRate: NaN, coasting: false, offFloor: false, ellipse: null, unseen: NaN });
  }
  return result;
}

/// The same, made once of each message.
function placesOf(camera, message) {
  if (camera.placed?.message !== message) camera.placed = { message, list: places(message) };
  return camera.placed.list;
}

/// The best there is of a camera: tracks, else robots, else markers.
export function bestPlaces(camera) {
  const message = camera.tracks ?? camera.robots ?? camera.frame;
  return message ? { world: message.world, list: placesOf(camera, message) } : { world: false, list: [] };
}

/// Frames a second that arrived within the last two seconds.
export function rateHz(camera) {
  const stamps = camera.stamps;
  if (stamps.length < 2 || performance.now() - stamps.at(-1) > 2000) return 0;
  return (stamps.length - 1) / ((stamps.at(-1) - stamps[0]) / 1000);
}
