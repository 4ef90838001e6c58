// The map from above, in the world's frame: robots, trails, the cameras' fields of view.
import { Camera2D, colours, fit, make } from './draw.js';
import { bestPlaces } from './store.js';

const kGoneMs = 1500, kListMs = 300, kPalette = ['#2f7fe8', '#d9711c', '#1f9d61', '#b03bb8', '#c2352f', '#0f98a8', '#8a7a10', '#6a5be0'];

export class Arena {
  constructor(store, app) {
    Object.assign(this, { store, app, fitted: false, following: false, measuring: false, points: [], drawn: [], nextList: 0 });
    this.canvas = document.getElementById('map');
    this.list = document.getElementById('robots');
    this.text = document.getElementById('arena-text');
    this.view = new Camera2D(this.canvas, () => { this.following = false; this.show(); }, { least: 0.5, most: 1e5, flip: -1 });
    this.buttons = Object.fromEntries(['fit', 'measure', 'follow'].map(id => [id, document.getElementById(id)]));
    this.buttons.fit.onclick = () => this.showAll();
    this.buttons.measure.onclick = () => this.measure();
    this.buttons.follow.onclick = () => this.follow();
    this.canvas.addEventListener('click', event => this.click(event));
  }

  show() {
    this.buttons.measure.setAttribute('aria-pressed', String(this.measuring));
    this.buttons.follow.setAttribute('aria-pressed', String(this.following));
  }
  measure() { this.measuring = !this.measuring; this.points = []; this.show(); }
  follow() { this.following = !this.following && !!this.chosen; this.show(); }
  showAll() { this.fitted = false; this.following = false; this.show(); }

  key(event) {
    const moves = { ArrowLeft: [-60, 0], ArrowRight: [60, 0], ArrowUp: [0, -60], ArrowDown: [0, 60] };
    if (event.key === 'm') this.measure();
    else if (event.key === 'f') this.follow();
    else if (event.key === '0') this.showAll();
    else if (event.key === 'Escape') { this.chosen = null; this.points = []; }
    else if (event.key === '+' || event.key === '-') this.view.zoomAt(...this.view.size().map(side => side / 2), event.key === '+' ? 1.4 : 1 / 1.4);
    else if (moves[event.key]) this.view.pan(...moves[event.key]);
    else return false;
    return true;
  }

  click(event) {
    if (this.view.moved) return;
    const at = this.view.toUnits(event.offsetX, event.offsetY);
    if (this.measuring) {
      if (this.points.length === 2) this.points = [];
      this.points.push(at);
      return;
    }
    let nearest = 24;
    this.chosen = null;
    for (const each of this.drawn) {
      const distance = Math.hypot(each.px - event.offsetX, each.py - event.offsetY);
      if (distance < nearest) { nearest = distance; this.chosen = { camera: each.camera, key: each.key }; }
    }
  }

  /// Who is where, of all cameras that were heard lately; cameras without a world are in their own frame.
  gather() {
    const result = [], now = performance.now(), chosen = this.app.cameraIndex();
    for (const camera of this.store.cameras) {
      if (!camera || (chosen !== null && camera.index !== chosen)) continue;
      const { world, list } = bestPlaces(camera);
      const gone = now - camera.heard > kGoneMs && !this.app.replayPaused();
      for (const each of list) result.push({ ...each, camera: camera.index, world, gone, trail: camera.trails.get(each.key) ?? [] });
    }
    return result;
  }

  draw() {
    const { context, width, height } = fit(this.canvas);
    const ink = colours(), bodies = this.gather();
    const inWorld = bodies.some(body => body.world) || !bodies.length;
    // The world from above has y upwards; a camera's own frame is shown as the camera sees it, with y downwards.
    this.view.flip = inWorld ? -1 : 1;
    this.fitAll(bodies, width, height);
    if (this.following && this.chosen) {
      const each = bodies.find(body => body.camera === this.chosen.camera && body.key === this.chosen.key);
      if (each) { this.view.x = each.x; this.view.y = each.y; }
    }
    context.fillStyle = ink.map;
    context.fillRect(0, 0, width, height);
    this.drawGrid(context, ink, width, height);
    for (const camera of this.store.cameras) if (camera) this.drawField(context, ink, camera);
    this.drawn = [];
    for (const body of bodies) this.drawTrail(context, body);
    for (const body of bodies) this.drawBody(context, ink, body);
    this.drawMeasure(context, ink);
    this.drawScale(context, ink, height);
    this.text.textContent = bodies.length ? `${bodies.length} in ${inWorld ? 'the world’s frame' : 'the camera’s frame, as no world file is set'}` : 'nobody is seen';
    this.drawList(bodies);
  }

  fitAll(bodies, width, height) {
    if (this.fitted || !width) return;
    const points = bodies.map(body => [body.x, body.y]);
    for (const camera of this.store.cameras) if (camera) points.push(...fieldOf(camera));
    const sound = points.filter(([x, y]) => Number.isFinite(x) && Number.isFinite(y));
    if (!sound.length) return;
    const xs = sound.map(point => point[0]), ys = sound.map(point => point[1]);
    const rim = 0.08 * Math.max(0.5, Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys));
    this.view.fitTo(Math.min(...xs) - rim, Math.min(...ys) - rim, Math.max(...xs) + rim, Math.max(...ys) + rim);
    this.fitted = bodies.length > 0 && this.store.cameras.some(camera => camera?.about);
  }

  drawGrid(context, ink, width, height) {
    const step = niceStep(80 / this.view.scale);
    const [left, top] = this.view.toUnits(0, 0), [right, bottom] = this.view.toUnits(width, height);
    context.strokeStyle = ink.line;
    context.lineWidth = 0.6;
    context.beginPath();
    for (let x = Math.ceil(left / step) * step; x < right; x += step) { const [px] = this.view.toScreen(x, 0); context.moveTo(px, 0); context.lineTo(px, height); }
    for (let y = Math.ceil(Math.min(top, bottom) / step) * step; y < Math.max(top, bottom); y += step) { const [, py] = this.view.toScreen(0, y); context.moveTo(0, py); context.lineTo(width, py); }
    context.stroke();
    const [ox, oy] = this.view.toScreen(0, 0);
    context.lineWidth = 1.5; context.strokeStyle = ink.soft;
    context.beginPath(); context.moveTo(ox - 8, oy); context.lineTo(ox + 8, oy); context.moveTo(ox, oy - 8); context.lineTo(ox, oy + 8); context.stroke();
  }

  drawField(context, ink, camera) {
    const field = fieldOf(camera);
    if (field.length < 3) return;
    context.strokeStyle = ink.soft;
    context.setLineDash([6, 4]);
    context.lineWidth = 1.2;
    context.beginPath();
    field.forEach(([x, y], i) => context[i ? 'lineTo' : 'moveTo'](...this.view.toScreen(x, y)));
    context.closePath();
    context.stroke();
    context.setLineDash([]);
    context.fillStyle = ink.soft;
    context.font = '12px system-ui, sans-serif';
    context.textAlign = 'left';
    const [px, py] = this.view.toScreen(...field[0]);
    context.fillText(camera.name, px + 4, py + 14);
  }

  colourOf(body) { return kPalette[[...body.key].reduce((sum, c) => (sum * 31 + c.charCodeAt(0)) >>> 0, 7) % kPalette.length]; }

  drawTrail(context, body) {
    if (body.trail.length < 2) return;
    context.strokeStyle = this.colourOf(body);
    context.globalAlpha = 0.45;
    context.lineWidth = 2;
    context.beginPath();
    body.trail.forEach(([, x, y], i) => context[i ? 'lineTo' : 'moveTo'](...this.view.toScreen(x, y)));
    context.stroke();
    context.globalAlpha = 1;
  }

  drawBody(context, ink, body) {
    const [px, py] = this.view.toScreen(body.x, body.y);
    if (!Number.isFinite(px)) return;
    this.drawn.push({ px, py, key: body.key, name: body.name, camera: body.camera, x: body.x, y: body.y });
    const size = Math.max(7, Math.min(26, 0.06 * this.view.scale));
    context.save();
    context.translate(px, py);
    if (Number.isFinite(body.vx) && Math.hypot(body.vx, body.vy) > 0.01) {  // where it is in a second
      context.strokeStyle = ink.text; context.lineWidth = 1.6;
      context.beginPath(); context.moveTo(0, 0); context.lineTo(body.vx * this.view.scale, this.view.flip * body.vy * this.view.scale); context.stroke();
    }
    context.rotate(this.view.flip * body.heading);
    context.fillStyle = body.gone || body.coasting ? 'transparent' : this.colourOf(body);
    context.strokeStyle = body.offFloor ? ink.bad : body.gone || body.coasting ? this.colourOf(body) : ink.text;
    context.setLineDash(body.coasting || body.gone ? [3, 3] : []);
    context.lineWidth = body.offFloor ? 3 : 1.4;
    context.beginPath();
    context.moveTo(1.3 * size, 0); context.lineTo(-0.8 * size, 0.8 * size); context.lineTo(-0.4 * size, 0); context.lineTo(-0.8 * size, -0.8 * size); context.closePath();
    context.fill(); context.stroke();
    context.restore();
    const chosen = this.chosen && this.chosen.camera === body.camera && this.chosen.key === body.key;
    if (chosen) { context.strokeStyle = ink.pick; context.lineWidth = 2.5; context.beginPath(); context.arc(px, py, 1.8 * size, 0, 7); context.stroke(); }
    context.fillStyle = ink.text;
    context.font = `${chosen ? 700 : 500} 13px system-ui, sans-serif`;
    context.textAlign = 'center';
    context.fillText(body.name + (body.offFloor ? ' ✕ off the floor' : body.coasting ? ' … coasting' : body.gone ? ' … lost' : ''), px, py - 1.5 * size - 3);
  }

  drawMeasure(context, ink) {
    if (!this.points.length) return;
    const screen = this.points.map(point => this.view.toScreen(...point));
    context.strokeStyle = context.fillStyle = ink.pick;
    context.lineWidth = 2;
    for (const [px, py] of screen) { context.beginPath(); context.arc(px, py, 4, 0, 7); context.fill(); }
    if (screen.length < 2) return;
    context.beginPath(); context.moveTo(...screen[0]); context.lineTo(...screen[1]); context.stroke();
    this.measured = Math.hypot(this.points[0][0] - this.points[1][0], this.points[0][1] - this.points[1][1]);
    context.font = '600 14px system-ui, sans-serif';
    context.textAlign = 'center';
    context.fillText(`${this.measured.toFixed(3)} m`, (screen[0][0] + screen[1][0]) / 2, (screen[0][1] + screen[1][1]) / 2 - 8);
  }

  drawScale(context, ink, height) {
    const length = niceStep(100 / this.view.scale), pixels = length * this.view.scale;
    context.strokeStyle = context.fillStyle = ink.text;
    context.lineWidth = 2;
    context.beginPath(); context.moveTo(14, height - 22); context.lineTo(14, height - 16); context.lineTo(14 + pixels, height - 16); context.lineTo(14 + pixels, height - 22); context.stroke();
    context.textAlign = 'left';
    context.font = '12px system-ui, sans-serif';
    context.fillText(length >= 1 ? `${length} m` : `${(100 * length).toFixed(length < 0.01 ? 1 : 0)} cm`, 16, height - 24);
  }

  drawList(bodies) {
    const now = performance.now();
    if (now < this.nextList) return;
    this.nextList = now + kListMs;
    const row = body => make('tr', {
      'aria-selected': String(!!this.chosen && this.chosen.key === body.key && this.chosen.camera === body.camera),
      onclick: () => { this.chosen = { camera: body.camera, key: body.key }; this.nextList = 0; },
    }, make('td', {}, body.name), ...[body.x, body.y].map(value => make('td', {}, value.toFixed(3))),
    make('td', {}, `${(body.heading * 180 / Math.PI).toFixed(0)}°`),
    make('td', {}, Number.isFinite(body.vx) ? Math.hypot(body.vx, body.vy).toFixed(2) : '–'));
    const sorted = [...bodies].sort((a, b) => a.name.localeCompare(b.name, undefined, { numeric: true })).slice(0, 200);
    this.list.replaceChildren(make('h2', {}, 'Robots'), make('table', {},
      make('thead', {}, make('tr', {}, ...['name', 'x m', 'y m', 'heading', 'm/s'].map(name => make('th', { scope: 'col' }, name)))),
      make('tbody', {}, ...sorted.map(row))));
  }
}

/// Where a camera sees the floor (z = 0), world; empty where that is not known.
export function fieldOf(camera) {
  const about = camera.about;
  if (!about?.rim || !about.world_from_camera) return [];
  const [px, py, pz] = about.world_from_camera.position, [w, x, y, z] = about.world_from_camera.orientation;
  const result = [];
  for (const [u, v] of about.rim) {
    // The ray (u, v, 1), turned into the world.
    const tx = 2 * (y * 1 - z * v), ty = 2 * (z * u - x * 1), tz = 2 * (x * v - y * u);
    const dx = u + w * tx + y * tz - z * ty, dy = v + w * ty + z * tx - x * tz, dz = 1 + w * tz + x * ty - y * tx;
    if (dz * pz >= 0 || Math.abs(dz) < 0.05) continue;  // beyond the horizon
    result.push([px - dx * pz / dz, py - dy * pz / dz]);
  }
  return result;
}

/// 1, 2 or 5 times a power of ten, at least `least`.
function niceStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * [1, 2, 5, 10].find(factor => factor * power >= least);
}
