// Pictures of all cameras with what was found in them, or one of them large.
import { idOf, kMarkerWords, marker } from './decode.js';
import { Camera2D, Labels, boxOf, fit, make } from './draw.js';
import { rateHz } from './store.js';

const kPictureLastsMs = 3000, kPictureIsOldMs = 700, kTextMs = 400, kLabelFromPx = 16;
/// Of an animation frame's time, for drawing: the browser shows it in the rest.
const kDrawMs = 5;
// On a picture, whatever the theme: light lines with a dark rim.
const kInk = { good: '#3dff9e', warn: '#ffc93d', none: '#ff8bd0', pick: '#ffffff', axisX: '#ff5f5f', axisY: '#5fdc5f', axisZ: '#7fb6ff' };
const kRim = 'rgb(0 0 0 / 75%)';

export class Live {
  constructor(store, app) {
    Object.assign(this, { store, app, tiles: new Map(), frozen: null, nextText: 0, labels: new Labels() });
    this.grid = document.getElementById('tiles');
    this.text = document.getElementById('live-text');
    this.freezeButton = document.getElementById('freeze');
    this.freezeButton.onclick = () => this.freeze();
    document.getElementById('reset').onclick = () => this.reset();
    store.addEventListener('server', () => { this.layout(); });
  }

  /// One canvas a camera that is shown.
  layout() {
    const chosen = this.app.cameraIndex();
    const shown = this.store.cameras.filter(camera => camera && (chosen === null || camera.index === chosen));
    const key = shown.map(camera => `${camera.index}:${camera.name}`).join();
    if (key === this.shownKey) return;
    this.shownKey = key;
    this.tiles.clear();
    this.grid.style.gridTemplateColumns = `repeat(${Math.ceil(Math.sqrt(shown.length)) || 1}, 1fr)`;
    this.grid.replaceChildren(...shown.map(camera => this.tile(camera, chosen !== null)));
    if (!shown.length) this.grid.append(make('p', { class: 'none' }, 'No camera is heard yet.'));
  }

  tile(camera, large) {
    const canvas = make('canvas', { tabindex: large ? 0 : null, 'aria-label': `Camera ${camera.name}` });
    const caption = make('p', {}, camera.name);
    const tile = { camera, canvas, caption, large, fitted: false };
    tile.view = new Camera2D(canvas, () => this.moved(tile), { least: 0.02, most: 200 });
    canvas.addEventListener('click', event => this.click(tile, event));
    this.tiles.set(camera.index, tile);
    return make('div', { class: 'tile' }, canvas, caption);
  }

  click(tile, event) {
    if (tile.view.moved) return;
    if (!tile.large) return this.app.chooseCamera(tile.camera.name);
    const frame = this.frameOf(tile.camera);
    const at = tile.view.toUnits(event.offsetX, event.offsetY);
    const reach = 24 / tile.view.scale;
    let best = null, nearest = Infinity;
    for (let i = 0; frame && i < frame.count; ++i) {
      const each = marker(frame, i);
      const distance = Math.hypot(each.center[0] - at[0], each.center[1] - at[1]);
      const size = each.outline[0] === each.outline[0] ? Math.hypot(each.outline[0] - each.center[0], each.outline[1] - each.center[1]) : 0;
      if (distance < Math.max(reach, size) && distance < nearest) { best = each; nearest = distance; }
    }
    this.app.chooseMarker(best && { camera: tile.camera.index, id: best.id, hasId: best.hasId, family: best.family, center: [...best.center] });
  }

  /// The frame that is drawn: that of the picture, so that both fit, else the newest.
  frameOf(camera) {
    if (this.frozen) return this.frozen.get(camera.index)?.frame ?? null;
    const picture = this.pictureOf(camera);
    return picture?.frame ?? camera.frame;
  }
  pictureOf(camera) {
    if (this.frozen) return this.frozen.get(camera.index)?.picture ?? null;
    const picture = camera.picture;
    return picture && (performance.now() - picture.at < kPictureLastsMs || this.app.replayPaused()) ? picture : null;
  }

  freeze() {
    if (this.frozen) this.frozen = null;
    else {
      const kept = new Map();
      for (const { camera } of this.tiles.values()) {
        const picture = this.pictureOf(camera);
        kept.set(camera.index, { frame: this.frameOf(camera), picture: picture && { ...picture, bitmap: copyOf(picture.bitmap) } });
      }
      this.frozen = kept;
    }
    this.freezeButton.setAttribute('aria-pressed', String(!!this.frozen));
  }

  reset() {
    for (const tile of this.tiles.values()) tile.fitted = false;
    this.app.link.tell({ region: null });
  }

  /// The region that is looked at is asked for in more detail.
  moved(tile) {
    if (!tile.large) { tile.fitted = false; return; }
    const frame = this.frameOf(tile.camera), picture = this.pictureOf(tile.camera);
    const width = picture?.imageWidth ?? frame?.width, height = picture?.imageHeight ?? frame?.height;
    if (!width) return;
    const [left, top] = tile.view.toUnits(0, 0), [right, bottom] = tile.view.toUnits(...tile.view.size());
    const x = Math.max(0, Math.floor(left)), y = Math.max(0, Math.floor(top));
    const w = Math.min(width, Math.ceil(right)) - x, h = Math.min(height, Math.ceil(bottom)) - y;
    const zoomed = w > 8 && h > 8 && w < 0.8 * width;
    this.app.link.tell({ region: zoomed ? [x, y, w, h] : null });
  }

  key(event) {
    const tile = [...this.tiles.values()].find(each => each.large);
    const moves = { ArrowLeft: [-60, 0], ArrowRight: [60, 0], ArrowUp: [0, -60], ArrowDown: [0, 60] };
    if (event.key === 'f') this.freeze();
    else if (event.key === '0') this.reset();
    else if (tile && (event.key === '+' || event.key === '-')) tile.view.zoomAt(...tile.view.size().map(side => side / 2), event.key === '+' ? 1.4 : 1 / 1.4);
    else if (tile && moves[event.key]) tile.view.pan(...moves[event.key]);
    else if (event.key === 'Escape') this.app.chooseMarker(null);
    else return false;
    return true;
  }

  /// Markers of the camera that is large: where each was drawn, CSS pixels.
  get drawn() { return [...this.tiles.values()].filter(tile => tile.large || this.tiles.size === 1).flatMap(tile => tile.drawn ?? []); }

  draw() {
    const now = performance.now();
    const tiles = [...this.tiles.values()];
    const begin = this.turn ?? 0;
    this.drawnTiles = 0;
    // Tiles take turns, and what a frame has no time for comes in the next one: no burst of pictures makes it late.
    for (let i = 0; i < tiles.length; ++i) {
      const at = (begin + i) % tiles.length;
      if (this.drawnTiles > 0 && performance.now() - now > kDrawMs) { this.turn = at; break; }
      if (this.drawTile(tiles[at])) ++this.drawnTiles;
    }
    if (now < this.nextText) return;
    this.nextText = now + kTextMs;
    this.showTexts(tiles);
  }

  /// All texts at once: the browser does its layout once for them.
  showTexts(tiles) {
    let markers = 0, slowest = 0;
    for (const tile of tiles) {
      this.caption(tile);
      markers += tile.camera.frame?.count ?? 0;
      slowest = Math.max(slowest, tile.camera.frame?.latency ?? 0);
    }
    this.text.textContent = `${tiles.length} camera${tiles.length === 1 ? '' : 's'}, ${markers} markers, latency up to ${slowest.toFixed(1)} ms${this.frozen ? ', frozen' : ''}`;
  }

  /// @returns whether it was drawn: it is where something has changed.
  drawTile(tile) {
    const { camera, view } = tile;
    const frame = this.frameOf(camera), picture = this.pictureOf(camera);
    const shownZoom = picture && this.zoomIsShown(camera, picture) ? camera.zoom : null;
    const chosen = this.app.marker?.camera === camera.index ? this.app.marker : null, box = boxOf(tile.canvas);
    const is = [picture, frame, shownZoom, chosen, view.x, view.y, view.scale, tile.fitted, box.width, box.height];
    if (tile.was && is.every((each, i) => each === tile.was[i])) return false;
    tile.was = is;
    const { context, width, height } = fit(tile.canvas);
    context.fillStyle = '#16181c';
    context.fillRect(0, 0, width, height);
    const imageWidth = picture?.imageWidth ?? frame?.width, imageHeight = picture?.imageHeight ?? frame?.height;
    if (imageWidth && !tile.fitted) { view.fitTo(-0.5, -0.5, imageWidth - 0.5, imageHeight - 0.5); tile.fitted = true; }
    if (imageWidth && tile.sized !== `${width}x${height}`) { if (tile.sized) tile.fitted = tile.large && !!this.app.link.wish.region; tile.sized = `${width}x${height}`; }
    if (picture) this.drawPicture(context, view, picture);
    if (shownZoom) this.drawPicture(context, view, shownZoom);
    if (frame) this.drawMarkers(context, tile, shownZoom?.frame ?? frame);
    return true;
  }

  caption(tile) {
    const { camera } = tile, frame = this.frameOf(camera), picture = this.pictureOf(camera);
    const state = camera.silent ? '✕ not heard' : camera.status && camera.status.camera_state !== 'running' ? `✕ ${camera.status.camera_state}` : '';
    const text = `${camera.name}  ${rateHz(camera).toFixed(0)} frames/s  ${frame ? frame.count : 0} markers  ${camera.frame ? camera.frame.latency.toFixed(1) : '–'} ms  ${this.ageOf(picture)}${state}`;
    if (text !== tile.said) tile.caption.textContent = tile.said = text;
  }

  /// Whether the part that is zoomed into has come, of about the time of the whole picture.
  zoomIsShown(camera, picture) {
    const zoom = camera.zoom;
    return !!zoom && !this.frozen && !!this.app.link.wish.region && performance.now() - zoom.at < kPictureLastsMs &&
      zoom.sequence >= picture.sequence - 30;
  }

  ageOf(picture) {
    if (!picture) return 'no picture  ';
    const age = performance.now() - picture.at;
    return age > kPictureIsOldMs && !this.frozen && !this.app.replayPaused() ? `picture ${(age / 1000).toFixed(1)} s old  ` : '';
  }

  drawPicture(context, view, picture) {
    const [x, y, w, h] = picture.region;
    const [left, top] = view.toScreen(x - 0.5, y - 0.5);
    context.imageSmoothingEnabled = view.scale < 3;
    context.drawImage(picture.bitmap, left, top, w * view.scale, h * view.scale);
  }

  drawMarkers(context, tile, frame) {
    const { view } = tile, scale = view.scale;
    const [ox, oy] = view.toScreen(0, 0);
    const f = frame.f, u = frame.u;
    const paths = { good: new Path2D(), warn: new Path2D(), none: new Path2D() };
    tile.drawn = [];
    const axes = [new Path2D(), new Path2D(), new Path2D()];
    const labels = [];
    for (let i = 0, at = 0; i < frame.count; ++i, at += kMarkerWords) {
      const state = (u[at + 2] & 1) === 0 ? 'none' : u[at + 3] ? 'warn' : 'good';
      const cx = ox + f[at + 6] * scale, cy = oy + f[at + 7] * scale;
      const path = paths[state];
      let size = 6;
      const known = f[at + 8] === f[at + 8];
      if (known) {
        for (let k = 0; k < 4; ++k) {
          const px = ox + f[at + 8 + 2 * k] * scale, py = oy + f[at + 9 + 2 * k] * scale;
          if (k === 0) path.moveTo(px, py); else path.lineTo(px, py);
        }
        path.closePath();
        size = Math.hypot(f[at + 8] - f[at + 6], f[at + 9] - f[at + 7]) * scale;
        if (size > 12) for (let k = 0; k < 3; ++k) { axes[k].moveTo(cx, cy); axes[k].lineTo(ox + f[at + 16 + 2 * k] * scale, oy + f[at + 17 + 2 * k] * scale); }
      } else {
        path.moveTo(cx + 6, cy); path.arc(cx, cy, 6, 0, 7);
      }
      if (tile.large || this.tiles.size === 1) tile.drawn.push({ i, cx, cy, outline: known ? Array.from({ length: 8 }, (_, k) => (k % 2 ? oy : ox) + f[at + 8 + k] * scale) : null });
      if (size > kLabelFromPx) labels.push([at, cx, cy, size, state]);
    }
    context.lineJoin = 'round';
    // Small ones are told apart by the width of their lines: dashes would not show, and take most of the time.
    const small = !labels.length && frame.count > 20;
    const dashes = { good: [], warn: [7, 3], none: [2, 3] }, widths = { good: 1.3, warn: 2.6, none: 3.9 };
    for (const width of small ? [0] : [3.5, 1.6]) for (const state of ['good', 'warn', 'none']) {
      context.setLineDash(small ? [] : dashes[state]);
      context.lineWidth = width || widths[state];
      context.strokeStyle = width > 2 ? 'rgb(0 0 0 / 55%)' : kInk[state];
      context.stroke(paths[state]);
    }
    context.setLineDash([]);
    [kInk.axisX, kInk.axisY, kInk.axisZ].forEach((ink, k) => { context.strokeStyle = ink; context.lineWidth = 2; context.stroke(axes[k]); });
    this.drawLabels(context, frame, labels);
    this.drawChosen(context, tile, frame, ox, oy, scale);
    tile.transform = { ox, oy, scale };
  }

  drawLabels(context, frame, labels) {
    context.textAlign = 'center';
    context.lineWidth = 3;
    context.strokeStyle = kRim;
    for (const [at, cx, cy, size, state] of labels) {
      const name = state === 'none' ? '?' : idOf(frame.u[at], frame.u[at + 1]);
      const font = `600 ${Math.min(20, Math.max(11, size / 3)).toFixed(0)}px system-ui, sans-serif`;
      this.labels.draw(context, name, cx, cy - size - 3, font, kInk[state], kRim);
      if (size < 70) continue;
      context.fillStyle = kInk[state];
      // Quality, where there is room for it.
      const text = `${frame.f[at + 22].toFixed(2)} px${state === 'warn' ? ' ▲' : ''}`;
      context.font = '12px system-ui, sans-serif';
      context.strokeText(text, cx, cy + size + 14);
      context.fillText(text, cx, cy + size + 14);
    }
  }

  drawChosen(context, tile, frame, ox, oy, scale) {
    const chosen = this.app.marker;
    if (!chosen || chosen.camera !== tile.camera.index) return;
    const each = findMarker(frame, chosen);
    if (!each) return;
    context.strokeStyle = kInk.pick;
    context.lineWidth = 2.5;
    context.beginPath();
    context.arc(ox + each.center[0] * scale, oy + each.center[1] * scale, 8 + 1.15 * scale * (each.outline[0] === each.outline[0] ? Math.hypot(each.outline[0] - each.center[0], each.outline[1] - each.center[1]) : 10), 0, 7);
    context.stroke();
  }
}

/// The chosen marker in a frame: by its id, else whatever is nearest to where it was.
export function findMarker(frame, chosen) {
  let best = null, nearest = 40;
  for (let i = 0; frame && i < frame.count; ++i) {
    const each = marker(frame, i);
    if (chosen.hasId) { if (each.hasId && each.id === chosen.id && each.family === chosen.family) return each; continue; }
    const distance = Math.hypot(each.center[0] - chosen.center[0], each.center[1] - chosen.center[1]);
    if (!each.hasId && distance < nearest) { best = each; nearest = distance; }
  }
  return best;
}

/// A bitmap is closed when a newer picture comes; a frozen one is kept.
function copyOf(bitmap) {
  const canvas = document.createElement('canvas');
  canvas.width = bitmap.width; canvas.height = bitmap.height;
  canvas.getContext('2d').drawImage(bitmap, 0, 0);
  return canvas;
}
