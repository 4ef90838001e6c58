// The page as a whole: which part is shown, what is asked of the server, and when things are drawn.
import { Arena } from './arena.js';
import { Kind } from './decode.js';
import { make } from './draw.js';
import { Health } from './health.js';
import { Live } from './live.js';
import { MarkerPanel } from './marker.js';
import { ReplayBar } from './replay.js';
import { Setup } from './setup.js';
import { Link } from './socket.js';
import { Store } from './store.js';

const kAlways = [Kind.server, Kind.status, Kind.history, Kind.camera];
const kKinds = {
  live: [...kAlways, Kind.frame, Kind.picture, Kind.zoom, Kind.detail],
  arena: [...kAlways, Kind.frame, Kind.robots, Kind.tracks],
  health: [...kAlways, Kind.frame],
  setup: [...kAlways, Kind.frame, Kind.detail, Kind.calibration],
};
const kNoticesShown = 4, kNoticeLastsMs = 20000;

class App {
  constructor() {
    this.store = new Store();
    this.marker = null;
    this.link = new Link(message => this.store.take(message), connected => this.store.setConnected(connected));
    this.live = new Live(this.store, this);
    this.arena = new Arena(this.store, this);
    this.health = new Health(this.store, this);
    this.setup = new Setup(this.store, this);
    this.panel = new MarkerPanel(this.store, this);
    this.replay = new ReplayBar(this.store, this);
    this.select = document.getElementById('camera');
    this.select.onchange = () => this.chooseCamera(this.select.value || null);
    this.store.addEventListener('server', () => this.listCameras());
    this.store.addEventListener('link', () => this.showLink());
    this.store.addEventListener('notice', () => this.showNotices());
    window.addEventListener('hashchange', () => this.readHash());
    document.addEventListener('keydown', event => this.key(event));
    document.addEventListener('visibilitychange', () => { if (!document.hidden) this.store.wake(); });
    setInterval(() => { this.store.watch(); this.showNotices(); }, 500);
    this.frameTimes = [];
    this.readHash();
    const moment = this.hash.get('t');
    if (moment) this.link.seek({ at: Number(moment), speed: 1, playing: false });
    requestAnimationFrame(now => this.draw(now));
  }

  get page() { return this.pageName; }

  readHash() {
    const [page, rest = ''] = location.hash.slice(1).split('?');
    this.hash = new URLSearchParams(rest);
    this.pageName = page in kKinds ? page : 'live';
    const camera = this.hash.get('camera');
    if (camera !== this.cameraName) { this.cameraName = camera; this.marker = null; this.link.tell({ region: null }); }
    for (const section of document.querySelectorAll('.page')) section.hidden = section.id !== this.pageName;
    for (const link of document.querySelectorAll('nav a')) {
      link.toggleAttribute('aria-current', link.dataset.page === this.pageName);
      link.href = this.hashOf({}, link.dataset.page);
    }
    this.tell();
    this.live.layout();
  }

  /// The address of a page, of the same camera.
  hashOf(extra, page = this.pageName) {
    const parameters = new URLSearchParams();
    if (this.cameraName) parameters.set('camera', this.cameraName);
    for (const [name, value] of Object.entries(extra)) parameters.set(name, value);
    const text = parameters.toString();
    return `#${page}${text ? `?${text}` : ''}`;
  }

  chooseCamera(name) {
    this.cameraName = name;
    this.marker = null;
    this.link.tell({ region: null, detail: null });
    history.replaceState(null, '', this.hashOf({}));
    this.readHash();
    this.arena.showAll();
    this.tell();
    this.live.layout();
    this.listCameras();
  }

  /// Number of the camera that is chosen, or the only one; null: all.
  cameraIndex() {
    if (!this.cameraName) return this.store.cameras.length === 1 ? 0 : null;
    const found = this.store.cameras.find(camera => camera && camera.name === this.cameraName);
    return found ? found.index : null;
  }

  chooseMarker(chosen) {
    this.marker = chosen;
    this.panel.next = 0;
    this.tell();
  }

  tell() {
    const index = this.cameraIndex();
    const onLive = this.pageName === 'live';
    this.link.tell({
      kinds: kKinds[this.pageName], camera: index,
      pictureWidth: index === null && this.store.cameras.length > 4 ? 320 : 640,
      detail: onLive ? this.marker && { ...this.marker } : this.pageName === 'setup' ? this.link.wish.detail : null,
      region: onLive ? this.link.wish.region : null,
    });
  }

  replayPaused() { return !!this.store.server?.replay && !this.store.server.replay.playing; }

  /// What was shown belongs to another time of the log.
  forget() {
    for (const camera of this.store.cameras) {
      if (!camera) continue;
      camera.trails.clear(); camera.histories.clear();
      Object.assign(camera, { frame: null, robots: null, tracks: null, status: null, timeline: [], latencies: [], detail: null, statusHeard: 0 });
    }
  }

  listCameras() {
    const names = this.store.cameras.filter(Boolean).map(camera => camera.name);
    this.select.replaceChildren(make('option', { value: '' }, 'all'), ...names.map(name => make('option', { value: name }, name)));
    this.select.value = this.cameraName ?? '';
    this.tell();
  }

  showLink() {
    const link = document.getElementById('link');
    const { connected } = this.store;
    link.textContent = connected ? 'connected' : 'no connection, trying again';
    link.className = connected ? 'good' : 'bad';
  }

  showNotices() {
    const now = Date.now();
    const recent = this.store.notices.filter(notice => now - notice.at < kNoticeLastsMs).slice(-kNoticesShown);
    const key = recent.map(notice => `${notice.at}${notice.text}`).join();
    if (key === this.noticesShown) return;
    this.noticesShown = key;
    document.getElementById('notices').replaceChildren(...recent.map(({ at, text, level }) =>
      make('li', {}, make('time', {}, new Date(at).toLocaleTimeString()), make('span', { class: level }, text))));
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT)$/.test(event.target.tagName)) return;
    const pages = ['live', 'arena', 'health', 'setup'];
    if (pages[event.key - 1]) { location.hash = this.hashOf({}, pages[event.key - 1]); return; }
    if (event.key === ' ' && this.store.server?.replay && event.target.tagName !== 'BUTTON') { event.preventDefault(); this.replay.toggle(); return; }
    if (event.key === 'c') {
      const names = [null, ...this.store.cameras.filter(Boolean).map(camera => camera.name)];
      this.chooseCamera(names[(names.indexOf(this.cameraName ?? null) + 1) % names.length]);
      return;
    }
    if (this[this.pageName].key(event)) event.preventDefault();
  }

  draw(now) {
    this.frameTimes.push(now);
    if (this.frameTimes.length > 4000) this.frameTimes.shift();
    const page = this[this.pageName];
    if (page.drawNews) page.drawNews(); else page.draw();
    if (this.pageName === 'live') this.panel.draw();
    requestAnimationFrame(next => this.draw(next));
  }
}

// Named for the console, and for tests.
window.chequer = new App();
