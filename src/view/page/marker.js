// One marker: its cells, bits, margins, Gaussians, warnings and its last minute.
import { warningAdvice } from './advice.js';
import { Kind, warningNames } from './decode.js';
import { colours, fit, make, rows } from './draw.js';
import { findMarker } from './live.js';

const kDoubtful = 3, kRedrawMs = 200;
const kInks = { dark: ['#101010', '#1238e6'], light: ['#ffffff', '#ffdf00'] };

export class MarkerPanel {
  constructor(store, app) {
    Object.assign(this, { store, app, panel: document.getElementById('marker'), next: 0 });
    this.cells = make('canvas', { height: 230, 'aria-label': 'Cells as they were read' });
    this.gaussians = make('canvas', { height: 210, 'aria-label': 'Luminance and saturation of the cells' });
    this.history = make('canvas', { height: 150, 'aria-label': 'The last minute' });
    this.ellipse = make('canvas', { height: 110, 'aria-label': 'Covariance of the position' });
    this.facts = make('div');
    this.title = make('h2');
    this.panel.append(this.title, this.facts,
      make('h3', {}, 'Cells'), this.cells, make('h3', {}, 'Luminance and saturation'), this.gaussians,
      make('h3', {}, 'Position, one standard deviation'), this.ellipse, make('h3', {}, 'Last minute'), this.history);
    store.addEventListener('news', event => { if (event.detail.kind === Kind.detail) this.next = 0; });
  }

  draw() {
    const chosen = this.app.marker;
    this.panel.hidden = !chosen;
    const now = performance.now();
    if (!chosen || now < this.next) return;
    this.next = now + kRedrawMs;
    const camera = this.store.camera(chosen.camera);
    const each = findMarker(camera.frame, chosen);
    if (each) chosen.center = [...each.center];
    const detail = camera.detail && this.isOf(camera.detail, chosen) ? camera.detail : null;
    this.title.textContent = chosen.hasId ? `Marker ${chosen.id}` : 'Marker without an id';
    this.facts.replaceChildren(...this.describe(each, detail, camera));
    this.drawCells(detail);
    this.drawGaussians(detail);
    this.drawEllipse(each);
    this.drawHistory(camera.histories.get(`${chosen.family}/${chosen.id}`) ?? []);
  }

  isOf(detail, chosen) { return detail.family === chosen.family && (chosen.hasId ? detail.id === chosen.id : detail.id === null); }

  describe(each, detail, camera) {
    if (!each) return [make('p', { class: 'bad' }, 'not seen in the newest frame')];
    const family = camera.about?.families[each.family];
    const facts = [
      ['kind', `${each.rows} × ${each.cols}${family ? ` ${family.variant}, ${(1000 * family.side_m).toFixed(0)} mm` : ''}`],
      ['corners used', `${each.cornersUsed} of ${(each.rows - 1) * (each.cols - 1)}, ${each.rms.toFixed(3)} px off`],
      ['bits corrected', String(each.bitsCorrected)],
    ];
    if (each.hasPose) {
      const frame = camera.frame.world ? 'world' : 'camera';
      facts.push([`position (${frame})`, `${[...each.position].map(value => value.toFixed(4)).join(', ')} m`],
        ['heading', `${(each.heading * 180 / Math.PI).toFixed(2)}°`],
        ['uncertainty', `${(1000 * each.sigmaM).toFixed(2)} mm, ${(each.sigmaRad * 180 / Math.PI).toFixed(3)}°`],
        ['distance', `${each.distance.toFixed(3)} m`], ['ambiguity', `${(100 * each.ambiguity).toFixed(1)} %`]);
    } else facts.push(['pose', 'none: the camera is not calibrated']);
    const warnings = warningNames(each.warnings).map(name => {
      const [what, todo, level = 'warn'] = warningAdvice[name] ?? [name, ''];
      return make('li', { class: level }, what, make('small', {}, todo));
    });
    const result = [rows(facts)];
    if (warnings.length) result.push(make('ul', { class: 'todo' }, ...warnings));
    else result.push(make('p', { class: 'good' }, 'no warnings'));
    if (!detail) result.push(make('p', { class: 'none' }, 'Cells come from chequerd on request; [view] allow may forbid it.'));
    else if (detail.message) result.push(make('p', { class: 'warn' }, detail.message));
    return result;
  }

  drawCells(detail) {
    const { context, width, height } = fit(this.cells);
    const ink = colours();
    context.clearRect(0, 0, width, height);
    this.shownCells = [];
    if (!detail?.cells.length) return;
    const side = Math.min(width / detail.cols, height / detail.rows);
    const left = (width - side * detail.cols) / 2;
    detail.cells.forEach((cell, i) => {
      const row = Math.floor(i / detail.cols), col = i % detail.cols, x = left + col * side, y = row * side;
      const dark = (row + col) % 2 === 0;
      const fill = kInks[dark ? 'dark' : 'light'][cell.saturated ? 1 : 0];
      context.fillStyle = fill;
      context.fillRect(x, y, side, side);
      this.shownCells.push((cell.saturated === null ? '?' : dark ? (cell.saturated ? 'B' : 'K') : cell.saturated ? 'Y' : 'W'));
      const border = row === 0 || col === 0 || row === detail.rows - 1 || col === detail.cols - 1;
      context.fillStyle = dark ? '#fff' : '#000';
      context.textAlign = 'center';
      context.font = `${Math.max(9, side / 3.2).toFixed(0)}px system-ui, sans-serif`;
      const wrong = cell.expected !== null && cell.saturated !== null && cell.expected !== cell.saturated;
      const doubtful = !border && Math.abs(cell.log_likelihood) < kDoubtful;
      if (!cell.seen) context.fillText('✕', x + side / 2, y + side * 0.62);
      else if (!border) {
        context.fillText(cell.saturated ? '1' : '0', x + side / 2, y + side * 0.5);
        context.font = `${Math.max(8, side / 4.5).toFixed(0)}px system-ui, sans-serif`;
        context.fillText(Math.min(99, Math.abs(cell.log_likelihood)).toFixed(0) + (doubtful ? ' ?' : ''), x + side / 2, y + side * 0.85);
      }
      if (!cell.seen || wrong || doubtful) {
        context.lineWidth = 3;
        context.setLineDash(wrong ? [] : [4, 3]);
        context.strokeStyle = wrong ? ink.bad : ink.warn;
        context.strokeRect(x + 2, y + 2, side - 4, side - 4);
        context.setLineDash([]);
      }
    });
    context.fillStyle = ink.accent;
    detail.corners.forEach((corner, i) => {
      const row = Math.floor(i / (detail.cols - 1)) + 1, col = i % (detail.cols - 1) + 1;
      context.beginPath();
      context.arc(left + col * side, row * side, 3.5, 0, 7);
      if (corner) context.fill();
      else { context.strokeStyle = ink.bad; context.lineWidth = 1.5; context.stroke(); }
    });
  }

  drawGaussians(detail) {
    const { context, width, height } = fit(this.gaussians);
    context.clearRect(0, 0, width, height);
    if (!detail?.cells.length) return;
    const ink = colours();
    const half = height / 2;
    const seen = detail.cells.map((cell, i) => ({ ...cell, dark: (Math.floor(i / detail.cols) + i % detail.cols) % 2 === 0 })).filter(cell => cell.seen);
    plot(context, ink, 0, 0, width, half, 'luminance', detail.luminance_overlap,
      [['dark', detail.luminance_dark, seen.filter(cell => cell.dark).map(cell => cell.luminance), ink.text], ['light', detail.luminance_light, seen.filter(cell => !cell.dark).map(cell => cell.luminance), ink.pick]]);
    plot(context, ink, 0, half, width, half, 'saturation', detail.saturation_overlap,
      [['plain', detail.saturation_plain, seen.filter(cell => cell.saturated === false).map(cell => cell.saturation), ink.text], ['saturated', detail.saturation_saturated, seen.filter(cell => cell.saturated).map(cell => cell.saturation), ink.warn]]);
  }

  drawEllipse(each) {
    const { context, width, height } = fit(this.ellipse);
    context.clearRect(0, 0, width, height);
    if (!each || !(each.ellipse[0] > 0)) return;
    const ink = colours(), [major, minor, angle] = each.ellipse;
    const scale = 0.42 * height / major;
    context.strokeStyle = ink.pick;
    context.lineWidth = 2;
    context.beginPath();
    context.ellipse(width / 2, height / 2, major * scale, Math.max(0.5, minor * scale), angle, 0, 7);
    context.stroke();
    context.fillStyle = ink.soft;
    context.font = '12px system-ui, sans-serif';
    context.textAlign = 'left';
    context.fillText(`in the picture ${major.toFixed(3)} × ${minor.toFixed(3)} px`, 4, 13);
  }

  drawHistory(history) {
    const { context, width, height } = fit(this.history);
    context.clearRect(0, 0, width, height);
    const ink = colours();
    context.font = '12px system-ui, sans-serif';
    context.textAlign = 'left';
    if (history.length < 2) { context.fillStyle = ink.soft; context.fillText('it has just come', 4, 14); return; }
    const mean = axis => history.reduce((sum, row) => sum + row[axis], 0) / history.length;
    const [mx, my] = [mean('x'), mean('y')];
    const series = [['distance from its mean, mm', row => 1000 * Math.hypot(row.x - mx, row.y - my), ink.pick, []], ['residual, px', row => row.rms, ink.warn, [5, 3]]];
    series.forEach(([name, value, colour, dash], k) => {
      const top = k * height / 2, values = history.map(value).map(v => Number.isFinite(v) ? v : 0), most = Math.max(1e-6, ...values);
      const now = performance.now();
      context.strokeStyle = colour; context.lineWidth = 1.6; context.setLineDash(dash);
      context.beginPath();
      history.forEach((row, i) => context[i ? 'lineTo' : 'moveTo'](width * (1 - (now - row.now) / 60000), top + (height / 2 - 4) - (height / 2 - 22) * values[i] / most));
      context.stroke();
      context.setLineDash([]);
      context.fillStyle = ink.text;
      context.fillText(`${name}: up to ${most.toFixed(2)}`, 4, top + 13);
    });
  }
}

/// Two Gaussians of equal height over their values.
function plot(context, ink, x, y, width, height, title, overlap, groups) {
  const ends = groups.flatMap(([, { mean, deviation }, values]) => [mean - 2.2 * deviation, mean + 2.2 * deviation, ...values]).filter(Number.isFinite);
  let least = Math.min(...ends), most = Math.max(...ends);
  const rim = 0.06 * (most - least || 1); least -= rim; most += rim;
  const at = value => x + (value - least) / (most - least) * width;
  const floor = y + height - 20, top = y + 20;
  context.font = '12px system-ui, sans-serif';
  context.textAlign = 'left';
  context.fillStyle = ink.text;
  context.fillText(`${title}, overlap ${(100 * overlap).toFixed(2)} %`, x + 2, y + 13);
  groups.forEach(([name, { mean, deviation }, values, colour], k) => {
    context.strokeStyle = colour; context.lineWidth = 2; context.setLineDash(k ? [6, 3] : []);
    context.beginPath();
    const sigma = Math.max(deviation, (most - least) / 300);
    for (let i = 0; i <= 120; ++i) {
      const value = least + (most - least) * i / 120, z = (value - mean) / sigma;
      context[i ? 'lineTo' : 'moveTo'](at(value), floor - (floor - top) * Math.exp(-z * z / 2));
    }
    context.stroke();
    context.setLineDash([]);
    context.lineWidth = 1;
    context.beginPath();
    for (const value of values) { context.moveTo(at(value), floor + 1); context.lineTo(at(value), floor + 6); }
    context.stroke();
    context.fillStyle = colour;
    context.textAlign = k ? 'right' : 'left';
    context.fillText(`${name} ${mean.toFixed(1)} ± ${deviation.toFixed(1)}`, k ? x + width - 2 : x + 2, y + height - 3);
  });
}
