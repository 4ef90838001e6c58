// How far a calibration has come that runs beside this page: coverage and residuals, and what it asks for next.
import { colours, fit, make } from './draw.js';

/// After the last word of a calibration: so long it stays on the page.
const kStaysMs = 600000, kSilentMs = 3000;
/// As the picture of `chequer calibrate lens` has it: so many pixels of 960 for a residual of twice the RMS.
const kDrawnPx = 24, kMapWidth = 960;
const kStates = { collecting: '… running', solving: '… calculating', done: '✓ done', failed: '✕ failed' };

export class CalibrationCard {
  constructor(camera) {
    this.advice = make('p', { class: 'advice', role: 'status' });
    this.state = make('p');
    this.canvas = make('canvas', { class: 'coverage', 'aria-label': `Calibration of ${camera.name}: coverage and residuals` });
    this.note = make('p');
    this.table = make('div');
    this.title = make('h3');
    this.element = make('div', { class: 'card calibration', hidden: '' }, this.title, this.advice, this.state, this.canvas, this.note, this.table);
  }

  /// To be called now and then. @returns whether there is one to show.
  fill(camera, now) {
    const calibration = camera.calibration;
    this.element.hidden = !calibration || now - camera.calibrationHeard > kStaysMs;
    if (this.element.hidden) return false;
    const runs = calibration.state === 'collecting' || calibration.state === 'solving';
    const silent = runs && now - camera.calibrationHeard > kSilentMs;
    const key = `${calibration.utc_ms} ${silent} ${this.canvas.clientWidth}`;
    if (key === this.shown) return true;
    this.shown = key;
    this.title.textContent = `${camera.name}: calibration of the ${calibration.kind}`;
    this.advice.textContent = calibration.advice;
    this.advice.className = `advice ${calibration.state === 'failed' ? 'bad' : calibration.advice === 'enough' || calibration.state === 'done' ? 'good' : 'warn'}`;
    this.state.textContent = silent ? '✕ not heard any more: it was ended' : stateText(calibration);
    const { context, width, height } = fit(this.canvas);
    this.scale = Math.min(width / (calibration.width || width), height / (calibration.height || height));
    context.clearRect(0, 0, width, height);
    if (calibration.kind === 'lens') this.drawLens(context, calibration);
    else this.drawWorld(context, calibration);
    return true;
  }

  drawLens(context, calibration) {
    const ink = colours(), { rows, cols, parts, rms, residuals } = calibration;
    const w = calibration.width * this.scale / cols, h = calibration.height * this.scale / rows;
    context.textAlign = 'center';
    context.font = '11px system-ui, sans-serif';
    this.counts = parts;
    parts.forEach((views, i) => {
      const x = i % cols * w, y = Math.floor(i / cols) * h;
      context.globalAlpha = views ? Math.min(0.6, 0.15 + views / 20) : 0.2;
      context.fillStyle = views > 1 ? ink.good : ink.warn;
      context.fillRect(x, y, w, h);
      context.globalAlpha = 1;
      context.strokeStyle = ink.line;
      context.strokeRect(x, y, w, h);
      context.fillStyle = ink.text;
      context.fillText(views || '–', x + w / 2, y + h / 2 + 4);
    });
    const grow = rms > 0 ? kDrawnPx / (2 * rms) * calibration.width * this.scale / kMapWidth : 0;
    this.lines = this.strokeResiduals(context, residuals, grow, 3 * rms, ink);
    const covered = parts.filter(views => views > 1).length / Math.max(1, parts.length);
    this.note.textContent = `coverage ${(100 * covered).toFixed(0)} %; numbers: views of each part` +
      (rms > 0 ? `; residual ${rms.toFixed(3)} px RMS, lines ${(grow / this.scale).toFixed(0)} times as long` : '; residuals come with some tilted views');
  }

  /// Lines from where points are seen; those beyond three times the RMS in the colour of what is wrong, and dashed.
  strokeResiduals(context, residuals, grow, limit, ink) {
    const well = new Path2D(), off = new Path2D();
    for (let i = 0; i + 3 < residuals.length; i += 4) {
      const x = residuals[i] * this.scale, y = residuals[i + 1] * this.scale;
      const path = Math.hypot(residuals[i + 2], residuals[i + 3]) > limit ? off : well;
      path.moveTo(x, y);
      path.lineTo(x + grow * residuals[i + 2], y + grow * residuals[i + 3]);
    }
    context.lineWidth = 1;
    context.strokeStyle = ink.accent;
    context.stroke(well);
    context.setLineDash([3, 2]);
    context.strokeStyle = ink.bad;
    context.stroke(off);
    context.setLineDash([]);
    return residuals.length / 4;
  }

  drawWorld(context, calibration) {
    const ink = colours();
    context.strokeStyle = ink.line;
    context.strokeRect(0, 0, calibration.width * this.scale, calibration.height * this.scale);
    context.textAlign = 'center';
    context.font = '12px system-ui, sans-serif';
    for (const each of calibration.references) {
      if (!each.frames) continue;
      const x = each.center[0] * this.scale, y = each.center[1] * this.scale, wrong = contradicts(each);
      context.strokeStyle = context.fillStyle = wrong ? ink.bad : each.offset_m ? ink.good : ink.warn;
      context.lineWidth = 2;
      context.beginPath();
      context.arc(x, y, 6, 0, 7);
      context.stroke();
      context.fillText(`${each.id}${wrong ? ' ▲' : ''}`, x, y - 10);
    }
    this.note.textContent = calibration.rms > 0 ? `residual ${(1000 * calibration.rms).toFixed(2)} mm RMS` : 'no estimate yet';
    this.table.replaceChildren(make('table', {}, make('tr', {}, ...['reference', 'frames', 'off, mm'].map(name => make('th', { scope: 'col' }, name))),
      ...calibration.references.map(each => make('tr', { class: contradicts(each) ? 'bad' : null }, make('td', {}, each.id),
        make('td', {}, each.frames || '✕ not seen'), make('td', {}, each.offset_m ? (1000 * Math.hypot(...each.offset_m)).toFixed(2) : '–')))));
  }
}

function contradicts({ offset_m: offset, limit_m: limit }) { return !!offset && limit > 0 && Math.hypot(...offset) > limit; }

function stateText(calibration) {
  const { frames, views, tilted, edge_px: edge } = calibration;
  const seen = calibration.kind === 'lens' ? `${views} of ${frames} frames taken, ${tilted} tilted${edge > 0 ? `, edges ${edge.toFixed(1)} px` : ''}` : `${frames} frames`;
  return `${kStates[calibration.state] ?? calibration.state}; ${seen}`;
}
