// Which knob to turn, and which way; where in the picture markers were seen, and how well they fit there.
import { setupAdvice } from './advice.js';
import { CalibrationCard } from './calibration.js';
import { marker } from './decode.js';
import { colours, fit, make } from './draw.js';

const kColumns = 16, kRows = 9, kFillMs = 500;

export class Setup {
  constructor(store, app) {
    Object.assign(this, { store, app, section: document.getElementById('setup'), cards: new Map(), next: 0 });
    this.grid = make('div', { class: 'cards' });
    this.section.append(make('p', {}, 'Choose a camera above; its knobs are judged by the markers that are seen now. Coverage and residuals count from when this page was opened. A calibration that runs (chequer calibrate) shows here too.'), this.grid);
  }

  key() { return false; }

  /// The detail that tells most: of the marker that is largest in the picture.
  wish() {
    const camera = this.store.cameras[this.app.cameraIndex() ?? -1];
    const frame = camera?.frame;
    let best = null, largest = 0;
    for (let i = 0; frame && i < frame.count; ++i) {
      const each = marker(frame, i);
      const size = each.outline[0] === each.outline[0] ? Math.hypot(each.outline[0] - each.outline[4], each.outline[1] - each.outline[5]) : 1;
      if (each.hasId && size > largest * 1.1) { largest = size; best = each; }
    }
    // It stays the same while it is seen, so that what is asked for does not change with each frame.
    if (this.asked && best && this.asked.camera === camera.index && hasId(frame, this.asked)) return this.asked;
    this.asked = best && { camera: camera.index, id: best.id, hasId: true, family: best.family, center: [...best.center] };
    return this.asked;
  }

  draw() {
    const now = performance.now();
    if (now < this.next) return;
    this.next = now + kFillMs;
    const chosen = this.app.cameraIndex();
    const shown = this.store.cameras.filter(camera => camera && (chosen === null || camera.index === chosen));
    const key = shown.map(camera => `${camera.index}:${camera.name}`).join();
    if (key !== this.shownKey) {
      this.shownKey = key;
      this.cards.clear();
      this.grid.replaceChildren(...shown.flatMap(camera => this.build(camera)));
    }
    for (const camera of shown) this.fill(camera);
    const wanted = this.wish();
    this.app.link.tell({ detail: wanted && { ...wanted } });
  }

  build(camera) {
    const card = { todo: make('ul', { class: 'todo' }), meters: make('div'), coverage: make('canvas', { class: 'coverage', 'aria-label': `Where ${camera.name} saw markers` }), note: make('p'), calibration: new CalibrationCard(camera) };
    this.cards.set(camera.index, card);
    return [card.calibration.element, make('div', { class: 'card' }, make('h2', {}, camera.name), card.todo, card.meters),
      make('div', { class: 'card' }, make('h3', {}, `${camera.name}: coverage and residuals`), card.coverage, card.note)];
  }

  fill(camera) {
    const card = this.cards.get(camera.index), frame = camera.frame;
    if (!card) return;
    card.calibration.fill(camera, performance.now());
    const means = { count: frame?.count ?? 0, luminance: 0, saturation: 0, rms: 0, blurred: (camera.status?.detections.hint_blurred ?? 0) > 0 };
    camera.cover ??= Array.from({ length: kColumns * kRows }, () => ({ count: 0, rms: 0 }));
    for (let i = 0; frame && i < frame.count; ++i) {
      const each = marker(frame, i);
      means.luminance += each.luminanceOverlap / frame.count;
      means.saturation += each.saturationOverlap / frame.count;
      means.rms += each.rms / frame.count;
      const col = Math.floor(each.center[0] / frame.width * kColumns), row = Math.floor(each.center[1] / frame.height * kRows);
      const cell = camera.cover[row * kColumns + col];
      if (cell) { ++cell.count; cell.rms += (each.rms - cell.rms) / cell.count; }
    }
    const detail = camera.detail && performance.now() - camera.heard < 2000 ? camera.detail : null;
    card.todo.replaceChildren(...setupAdvice(means, detail).map(([level, knob, way, why]) => make('li', { class: level }, `${knob}: ${way}`, make('small', {}, why))));
    const meter = (name, value, most, limit, unit, digits) => make('tr', {}, make('th', { scope: 'row' }, name),
      make('td', {}, make('meter', { min: 0, max: most, low: limit, high: limit, optimum: 0, value: Math.min(most, value), 'aria-label': name })), make('td', {}, `${value.toFixed(digits)} ${unit}`));
    card.meters.replaceChildren(make('table', {}, meter('luminance overlap', 100 * means.luminance, 10, 2, '%', 2), meter('saturation overlap', 100 * means.saturation, 10, 2, '%', 2), meter('residual', means.rms, 1, 0.3, 'px', 3)));
    this.drawCoverage(card, camera);
  }

  drawCoverage(card, camera) {
    const { context, width, height } = fit(card.coverage);
    const ink = colours(), w = width / kColumns, h = height / kRows;
    context.clearRect(0, 0, width, height);
    let seen = 0, worst = 0;
    camera.cover.forEach((cell, i) => {
      const x = i % kColumns * w, y = Math.floor(i / kColumns) * h;
      context.strokeStyle = ink.line;
      context.strokeRect(x, y, w, h);
      if (!cell.count) return;
      ++seen;
      worst = Math.max(worst, cell.rms);
      context.globalAlpha = Math.min(1, 0.25 + cell.count / 40);
      context.fillStyle = cell.rms > 0.3 ? ink.warn : ink.good;
      context.fillRect(x + 1, y + 1, w - 2, h - 2);
      context.globalAlpha = 1;
      context.fillStyle = ink.text;
      context.textAlign = 'center';
      context.font = `${Math.min(11, w / 3).toFixed(0)}px system-ui, sans-serif`;
      context.fillText(`${cell.rms.toFixed(2)}${cell.rms > 0.3 ? '▲' : ''}`, x + w / 2, y + h / 2 + 4);
    });
    card.note.textContent = `markers were seen in ${(100 * seen / (kColumns * kRows)).toFixed(0)} % of the picture; numbers: residual, px, at most ${worst.toFixed(2)}`;
  }
}

function hasId(frame, wanted) {
  for (let i = 0; i < frame.count; ++i) { const each = marker(frame, i); if (each.hasId && each.id === wanted.id && each.family === wanted.family) return true; }
  return false;
}
