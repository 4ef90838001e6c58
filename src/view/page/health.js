// How the services fare: rates, latency, drops, warnings, and what to do about each.
import { cameraAdvice } from './advice.js';
import { Kind } from './decode.js';
import { colours, make, rows } from './draw.js';

const kPointsShown = 300;

export class Health {
  constructor(store, app) {
    Object.assign(this, { store, app, section: document.getElementById('health'), cards: new Map() });
    this.versions = make('div', { class: 'card' });
    this.grid = make('div', { class: 'cards' });
    this.section.append(this.grid);
    store.addEventListener('news', event => { if (event.detail.kind === Kind.status || event.detail.kind === Kind.history) this.dirty = true; });
    store.addEventListener('server', () => { this.dirty = true; });
  }

  key() { return false; }

  draw() {
    const now = performance.now();
    if (!this.dirty && now < (this.next ?? 0)) return;
    this.dirty = false;
    this.next = now + 1000;
    const chosen = this.app.cameraIndex();
    const shown = this.store.cameras.filter(camera => camera && (chosen === null || camera.index === chosen));
    const key = shown.map(camera => `${camera.index}:${camera.name}`).join();
    if (key !== this.shownKey) {
      this.shownKey = key;
      for (const card of this.cards.values()) for (const chart of card.charts) chart.destroy();
      this.cards.clear();
      this.grid.replaceChildren(...(shown.length ? shown.flatMap(camera => this.build(camera)) : [make('p', { class: 'none' }, 'No camera is heard yet.')]), this.versions);
    }
    for (const camera of shown) this.fill(camera);
    const server = this.store.server;
    if (server) this.versions.replaceChildren(make('h2', {}, 'View'), rows([
      ['version', server.version], ['LCM', server.url || 'a log'], ['messages that could not be read', String(server.unreadable)],
      ['trouble', server.trouble || 'none']]));
  }

  build(camera) {
    const ink = colours();
    Chart.defaults.color = ink.text; Chart.defaults.borderColor = ink.line; Chart.defaults.animation = false;
    Chart.defaults.font.family = 'system-ui, sans-serif';
    const plot = label => { const canvas = make('canvas', { role: 'img', 'aria-label': label }); return [canvas, make('div', { class: 'plot' }, canvas)]; };
    const [stageCanvas, stagePlot] = plot(`Latency of ${camera.name} by stage`);
    const [histogramCanvas, histogramPlot] = plot(`Latency of ${camera.name}, last minute`);
    const [timeCanvas, timePlot] = plot(`Last ten minutes of ${camera.name}`);
    const card = { facts: make('div'), todo: make('ul', { class: 'todo' }) };
    const axis = (text, extra = {}) => ({ title: { display: true, text }, beginAtZero: true, ...extra });
    const bars = (label, colour) => ({ label, data: [], backgroundColor: colour, borderWidth: 0 });
    card.stages = new Chart(stageCanvas, { type: 'bar', data: { labels: [], datasets: [bars('median', ink.pick), bars('99 %', ink.warn), bars('worst', ink.soft)] }, options: { maintainAspectRatio: false, scales: { y: axis('ms') } } });
    card.histogram = new Chart(histogramCanvas, { type: 'bar', data: { labels: [], datasets: [bars('frames', ink.pick)] }, options: { maintainAspectRatio: false, plugins: { legend: { display: false } }, scales: { x: { title: { display: true, text: 'capture to publishing, ms' } }, y: axis('frames') } } });
    const line = (label, colour, yAxisID, dash = []) => ({ label, data: [], borderColor: colour, borderDash: dash, borderWidth: 1.5, pointRadius: 0, yAxisID, stepped: false });
    card.time = new Chart(timeCanvas, { type: 'line', data: { datasets: [line('published, frames/s', ink.good, 'rate'), line('latency 99 %, ms', ink.warn, 'ms', [6, 3]), line('lost frames', ink.bad, 'rate', [2, 2])] },
      options: { maintainAspectRatio: false, parsing: false, scales: { x: { type: 'linear', title: { display: true, text: 'minutes ago' }, ticks: { callback: value => Math.abs(value).toFixed(0) } }, rate: axis('frames/s', { position: 'left' }), ms: axis('ms', { position: 'right', grid: { drawOnChartArea: false } }) } } });
    card.charts = [card.stages, card.histogram, card.time];
    this.cards.set(camera.index, card);
    return [
      make('div', { class: 'card' }, make('h2', {}, camera.name), card.facts, card.todo),
      make('div', { class: 'card' }, make('h3', {}, `${camera.name}: latency by stage`), stagePlot),
      make('div', { class: 'card' }, make('h3', {}, `${camera.name}: latency, last minute`), histogramPlot),
      make('div', { class: 'card wide' }, make('h3', {}, `${camera.name}: last ten minutes`), timePlot)];
  }

  fill(camera) {
    const card = this.cards.get(camera.index), status = camera.status;
    if (!card || !status) return;
    card.facts.replaceChildren(rows([
      ['camera', `${status.camera_state}${camera.silent ? ', not heard' : ''}`], ['source', status.camera_source || '–'],
      ['captured', `${status.capture_rate_hz.toFixed(1)} frames/s`], ['published', `${status.publish_rate_hz.toFixed(1)} frames/s`],
      ['markers a frame', `${status.markers_mean.toFixed(1)} (${status.markers_min} to ${status.markers_max})`],
      ['lost frames', `${status.frames_dropped}${Object.entries(status.drops).filter(([, count]) => count > 0).map(([name, count]) => `, ${name} ${count}`).join('')}`],
      ['deferred work', `${status.detections.deferred ?? 0} a second`],
      ['messages', `${status.messages_sent} sent, ${status.messages_failed} failed`],
      ['workers', String(status.workers)], ['version', status.version], ['up for', duration(status.uptime_s)]]));
    card.todo.replaceChildren(...cameraAdvice(status, camera.silent, camera.statusBefore).map(([level, what, todo]) => make('li', { class: level }, what, todo ? make('small', {}, todo) : null)));
    camera.statusBefore = status;
    const names = status.stages.map(stage => stage.stage);
    card.stages.data.labels = names;
    ['median_ms', 'p99_ms', 'worst_ms'].forEach((field, i) => { card.stages.data.datasets[i].data = status.stages.map(stage => stage.frames ? stage[field] : 0); });
    const { labels, counts } = histogram(camera.latencies.map(([, latency]) => latency));
    card.histogram.data.labels = labels;
    card.histogram.data.datasets[0].data = counts;
    const last = camera.timeline.at(-1)?.[0] ?? 0, step = Math.max(1, Math.floor(camera.timeline.length / kPointsShown));
    const thinned = camera.timeline.filter((_, i) => i % step === 0);
    [2, 5, 6].forEach((column, i) => { card.time.data.datasets[i].data = thinned.map(row => ({ x: (row[0] - last) / 60000, y: row[column] })); });
    for (const chart of card.charts) chart.update('none');
  }
}

/// Twelve bins up to the 99.5th percentile; the last one takes what is beyond.
function histogram(values) {
  const sorted = values.filter(Number.isFinite).sort((a, b) => a - b);
  if (!sorted.length) return { labels: [], counts: [] };
  const most = Math.max(0.1, sorted[Math.floor(0.995 * (sorted.length - 1))]), bins = 12, counts = Array(bins).fill(0);
  for (const value of sorted) ++counts[Math.min(bins - 1, Math.max(0, Math.floor(value / most * bins)))];
  return { labels: counts.map((_, i) => `${(i * most / bins).toFixed(1)}`), counts };
}

function duration(seconds) {
  const hours = Math.floor(seconds / 3600), minutes = Math.floor(seconds / 60) % 60;
  return hours ? `${hours} h ${minutes} min` : minutes ? `${minutes} min ${Math.floor(seconds % 60)} s` : `${Math.floor(seconds)} s`;
}
