// The map from above, in the world's frame: robots, trails, the cameras' fields of view.
import { Camera2D, Labels, boxOf, colours, fit, make } from './draw.js';
import { bestPlaces } from './store.js';

/// Trails are thinned beyond so many points in all; without news the map is drawn anew that often, as robots are lost.
const kMostTrailPoints = 6000, kIdleMs = 250, kMostListed = 200;
const kGoneMs = 1500, kListMs = 500, kPalette = ['#2f7fe8', '#d9711c', '#1f9d61', '#b03bb8', '#c2352f', '#0f98a8', '#8a7a10', '#6a5be0'];

export class Arena {
  constructor(store, app) {
    Object.assign(this, { store, app, fitted: false, following: false, measuring: false, points: [], drawn: [], nextList: 0, labels: new Labels(), rows: [], collator: new Intl.Collator(undefined, { numeric: true }) });
    store.addEventListener('news', () => { this.news = true; });
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
      for (const each of list) {
        each.camera = camera.index; each.world = world; each.gone = gone; each.trail = camera.trails.get(each.key) ?? kNoTrail;
        result.push(each);
      }
    }
    return result;
  }

  /// Draws where there is something new, once an animation frame at most.
  drawNews() {
    const now = performance.now(), { view } = this, box = boxOf(this.canvas);
    const is = [view.x, view.y, view.scale, box.width, box.height, this.chosen, this.following, this.measuring, this.points.length, this.fitted, this.app.cameraIndex(), colours()];
    if (!this.news && now < this.idleAt && is.every((each, i) => each === this.was?.[i])) return;
    this.was = is;
    this.news = false;
    this.idleAt = now + kIdleMs;
    this.draw();
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
    this.drawTrails(context, bodies);
    this.drawBodies(context, ink, bodies);
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

  /// Number of its colour.
  inkOf(body) {
    if (body.ink !== undefined) return body.ink;
    let sum = 7;
    for (let i = 0; i < body.key.length; ++i) sum = (sum * 31 + body.key.charCodeAt(i)) >>> 0;
    return body.ink = sum % kPalette.length;
  }
  colourOf(body) { return kPalette[this.inkOf(body)]; }

  /// All trails of a colour as one path.
  drawTrails(context, bodies) {
    const { view } = this, [ox, oy] = view.toScreen(0, 0), sx = view.scale, sy = view.flip * view.scale;
    let points = 0;
    for (const body of bodies) points += body.trail.length;
    const step = Math.ceil(points / kMostTrailPoints) || 1, paths = kPalette.map(() => new Path2D());
    for (const body of bodies) {
      const { trail } = body, path = paths[this.inkOf(body)];
      if (trail.length < 2) continue;
      path.moveTo(ox + sx * trail[0][1], oy + sy * trail[0][2]);
      for (let i = step; i < trail.length; i += step) path.lineTo(ox + sx * trail[i][1], oy + sy * trail[i][2]);
      path.lineTo(ox + sx * body.x, oy + sy * body.y);
    }
    context.globalAlpha = 0.45;
    context.lineWidth = 2;
    paths.forEach((path, i) => { context.strokeStyle = kPalette[i]; context.stroke(path); });
    context.globalAlpha = 1;
  }

  /// Those that are well as one path a colour; whoever needs a style of their own one by one.
  drawBodies(context, ink, bodies) {
    const { view } = this, [ox, oy] = view.toScreen(0, 0), size = Math.max(7, Math.min(26, 0.06 * view.scale));
    const fills = kPalette.map(() => new Path2D()), rims = new Path2D(), speeds = new Path2D(), special = [];
    for (const body of bodies) {
      const px = ox + view.scale * body.x, py = oy + view.flip * view.scale * body.y;
      if (!Number.isFinite(px)) continue;
      this.drawn.push({ px, py, key: body.key, name: body.name, camera: body.camera, x: body.x, y: body.y });
      if (Math.abs(body.vx) + Math.abs(body.vy) > 0.01) {  // where it is in a second
        speeds.moveTo(px, py);
        speeds.lineTo(px + body.vx * view.scale, py + view.flip * body.vy * view.scale);
      }
      if (body.gone || body.coasting || body.offFloor) { special.push(body, px, py); continue; }
      arrow(fills[this.inkOf(body)], px, py, view.flip * body.heading, size);
      arrow(rims, px, py, view.flip * body.heading, size);
    }
    context.lineWidth = 1.6; context.strokeStyle = ink.text;
    context.stroke(speeds);
    fills.forEach((path, i) => { context.fillStyle = kPalette[i]; context.fill(path); });
    context.lineWidth = 1.4;
    context.stroke(rims);
    for (let i = 0; i < special.length; i += 3) this.drawSpecial(context, ink, special[i], special[i + 1], special[i + 2], size);
    this.drawNames(context, ink, bodies, size);
  }

  drawSpecial(context, ink, body, px, py, size) {
    const path = new Path2D(), hollow = body.gone || body.coasting;
    arrow(path, px, py, this.view.flip * body.heading, size);
    context.setLineDash(hollow ? [3, 3] : []);
    context.lineWidth = body.offFloor ? 3 : 1.4;
    context.fillStyle = this.colourOf(body);
    context.strokeStyle = body.offFloor ? ink.bad : hollow ? this.colourOf(body) : ink.text;
    if (!hollow) context.fill(path);
    context.stroke(path);
    context.setLineDash([]);
  }

  drawNames(context, ink, bodies, size) {
    let at = 0;
    for (const body of bodies) {
      const drawn = this.drawn[at];
      if (!drawn || drawn.key !== body.key || drawn.camera !== body.camera) continue;  // has no place
      ++at;
      const chosen = this.chosen && this.chosen.camera === body.camera && this.chosen.key === body.key;
      if (chosen) { context.strokeStyle = ink.pick; context.lineWidth = 2.5; context.beginPath(); context.arc(drawn.px, drawn.py, 1.8 * size, 0, 7); context.stroke(); }
      const state = body.offFloor ? ' ✕ off the floor' : body.coasting ? ' … coasting' : body.gone ? ' … lost' : '';
      this.labels.draw(context, body.name + state, drawn.px, drawn.py - 1.5 * size - 3, `${chosen ? 700 : 500} 13px system-ui, sans-serif`, ink.text);
    }
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
    const sorted = [...bodies].sort((a, b) => this.collator.compare(a.name, b.name)).slice(0, kMostListed);
    while (this.rows.length < sorted.length) this.rows.push(this.row());
    if (!this.table) {
      this.table = make('tbody');
      this.list.replaceChildren(make('h2', {}, 'Robots'), make('table', {},
        make('thead', {}, make('tr', {}, ...['name', 'x m', 'y m', 'heading', 'm/s'].map(name => make('th', { scope: 'col' }, name)))), this.table));
    }
    if (this.table.children.length !== sorted.length) this.table.replaceChildren(...sorted.map((_, i) => this.rows[i].element));
    sorted.forEach((body, i) => this.fillRow(this.rows[i], body));
  }

  /// Rows stay; what they say changes.
  row() {
    const cells = Array.from({ length: 5 }, () => document.createTextNode(''));
    const row = { cells, body: null, element: make('tr', { onclick: () => { this.chosen = { camera: row.body.camera, key: row.body.key }; this.nextList = 0; } }, ...cells.map(cell => make('td', {}, cell))) };
    return row;
  }

  fillRow(row, body) {
    row.body = body;
    row.element.setAttribute('aria-selected', String(!!this.chosen && this.chosen.key === body.key && this.chosen.camera === body.camera));
    [body.name, body.x.toFixed(3), body.y.toFixed(3), `${(body.heading * 180 / Math.PI).toFixed(0)}°`,
      Number.isFinite(body.vx) ? Math.hypot(body.vx, body.vy).toFixed(2) : '–'].forEach((text, i) => { if (row.cells[i].data !== text) row.cells[i].data = text; });
  }
}

const kNoTrail = [];

/// A body that points along an angle, on a path.
function arrow(path, px, py, angle, size) {
  const c = size * Math.cos(angle), s = size * Math.sin(angle);
  path.moveTo(px + 1.3 * c, py + 1.3 * s);
  path.lineTo(px - 0.8 * c - 0.8 * s, py - 0.8 * s + 0.8 * c);
  path.lineTo(px - 0.4 * c, py - 0.4 * s);
  path.lineTo(px - 0.8 * c + 0.8 * s, py - 0.8 * s - 0.8 * c);
  path.closePath();
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
