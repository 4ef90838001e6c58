// The time line of a log.

export class ReplayBar {
  constructor(store, app) {
    Object.assign(this, { store, app });
    this.bar = document.getElementById('replay');
    this.play = document.getElementById('play');
    this.time = document.getElementById('time');
    this.clock = document.getElementById('clock');
    this.speed = document.getElementById('speed');
    this.moment = document.getElementById('moment');
    this.play.onclick = () => this.toggle();
    this.time.oninput = () => this.seek(Number(this.time.value), false);
    this.time.onchange = () => this.seek(Number(this.time.value), this.wasPlaying ?? true);
    this.time.onpointerdown = () => { this.wasPlaying = this.state?.playing; };
    this.speed.onchange = () => this.seek(this.state.now_ms, this.state.playing);
    store.addEventListener('server', () => this.show());
  }

  get state() { return this.store.server?.replay; }

  seek(at, playing) {
    this.app.forget();
    this.app.link.seek({ at, speed: Number(this.speed.value), playing });
  }
  toggle() {
    const atEnd = this.state.now_ms >= this.state.last_ms - 1;
    this.seek(atEnd && !this.state.playing ? this.state.first_ms : this.state.now_ms, !this.state.playing);
  }

  show() {
    const state = this.state;
    this.bar.hidden = !state;
    if (!state) return;
    this.time.min = state.first_ms;
    this.time.max = state.last_ms;
    if (document.activeElement !== this.time || state.playing) this.time.value = state.now_ms;
    this.play.textContent = state.playing ? 'pause' : 'play';
    const date = new Date(state.now_ms);
    this.clock.textContent = `${date.toISOString().slice(0, 10)} ${date.toISOString().slice(11, 22)} UTC, ${((state.now_ms - state.first_ms) / 1000).toFixed(1)} of ${((state.last_ms - state.first_ms) / 1000).toFixed(1)} s`;
    this.moment.href = this.app.hashOf({ t: Math.round(state.now_ms) });
  }
}
