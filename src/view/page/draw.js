// Drawing that several pages share.

// Sizes as the browser tells of them after its layout: to ask for one makes it do its layout at once, which costs more
// than the drawing where several are asked for between changes of text.
const boxes = new WeakMap();
const observer = new ResizeObserver(entries => {
  for (const { target, contentRect } of entries) Object.assign(boxes.get(target), { width: contentRect.width, height: contentRect.height });
});

/// { width, height } of what is shown of a canvas, CSS pixels; the same object each time.
export function boxOf(canvas) {
  let box = boxes.get(canvas);
  if (box) return box;
  boxes.set(canvas, box = { width: canvas.clientWidth, height: canvas.clientHeight });
  observer.observe(canvas);
  return box;
}

/// Sizes a canvas to what is shown of it; gives its context and size in CSS pixels.
export function fit(canvas) {
  const ratio = window.devicePixelRatio || 1, box = boxOf(canvas);
  const width = Math.max(1, Math.round(box.width * ratio)), height = Math.max(1, Math.round(box.height * ratio));
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  const context = canvas.getContext('2d');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { context, width: box.width, height: box.height };
}

/// Draws texts from a cache: to lay out and fill one anew takes longer than to draw a marker.
export class Labels {
  constructor(most = 3000) { this.most = most; this.sprites = new Map(); }

  /// Centred on x, its baseline at y. @param rim drawn about it; null: none.
  draw(context, text, x, y, font, fill, rim = null) {
    const ratio = window.devicePixelRatio || 1, key = `${text}|${font}|${fill}|${ratio}`;
    let sprite = this.sprites.get(key);
    if (!sprite) {
      if (this.sprites.size >= this.most) this.sprites.delete(this.sprites.keys().next().value);
      this.sprites.set(key, sprite = spriteOf(text, font, fill, rim, ratio));
    }
    const { canvas, width, height, base } = sprite;
    // On whole pixels it stays sharp.
    context.drawImage(canvas, Math.round((x - width / 2) * ratio) / ratio, Math.round((y - base) * ratio) / ratio, width, height);
  }
}

function spriteOf(text, font, fill, rim, ratio) {
  const canvas = document.createElement('canvas'), context = canvas.getContext('2d');
  context.font = font;
  const size = context.measureText(text), rise = Math.ceil(size.actualBoundingBoxAscent) + 3, fall = Math.ceil(size.actualBoundingBoxDescent) + 3;
  canvas.width = Math.ceil((size.width + 6) * ratio);
  canvas.height = Math.ceil((rise + fall) * ratio);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.font = font;
  context.textAlign = 'center';
  const middle = canvas.width / ratio / 2;
  if (rim) { context.lineWidth = 3; context.strokeStyle = rim; context.strokeText(text, middle, rise); }
  context.fillStyle = fill;
  context.fillText(text, middle, rise);
  return { canvas, width: canvas.width / ratio, height: canvas.height / ratio, base: rise };
}

/// The theme's colours, by the names in style.css.
export function colours() { return themes[dark.matches ? 1 : 0] ??= readColours(); }

const dark = matchMedia('(prefers-color-scheme: dark)'), themes = [];

function readColours() {
  const style = getComputedStyle(document.documentElement);
  return Object.fromEntries(['ground', 'panel', 'text', 'soft', 'line', 'good', 'warn', 'bad', 'pick', 'map', 'accent']
    .map(name => [name, style.getPropertyValue(`--${name}`).trim()]));
}

/// An element with text and children.
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === 'class') element.className = value;
    else if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.filter(child => child !== null && child !== undefined));
  return element;
}

/// Rows of a table: [name, value].
export function rows(pairs) {
  return make('table', {}, ...pairs.map(([name, value]) => make('tr', {}, make('th', { scope: 'row' }, name), make('td', {}, value))));
}

/// Pan and zoom of a canvas: `scale` CSS pixels a unit, `x`, `y` the unit at its middle.
export class Camera2D {
  constructor(canvas, change, { least = 1e-3, most = 1e5, flip = 1 } = {}) {
    Object.assign(this, { canvas, change, least, most, flip, x: 0, y: 0, scale: 1, pointers: new Map(), moved: false });
    canvas.addEventListener('wheel', event => { event.preventDefault(); this.zoomAt(event.offsetX, event.offsetY, Math.exp(-event.deltaY / 400)); }, { passive: false });
    canvas.addEventListener('pointerdown', event => { canvas.setPointerCapture(event.pointerId); this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]); this.moved = false; });
    canvas.addEventListener('pointermove', event => this.drag(event));
    for (const name of ['pointerup', 'pointercancel']) canvas.addEventListener(name, event => this.pointers.delete(event.pointerId));
  }
  size() { const { width, height } = boxOf(this.canvas); return [width, height]; }
  toScreen(x, y) { const [w, h] = this.size(); return [w / 2 + (x - this.x) * this.scale, h / 2 + this.flip * (y - this.y) * this.scale]; }
  toUnits(px, py) { const [w, h] = this.size(); return [this.x + (px - w / 2) / this.scale, this.y + this.flip * (py - h / 2) / this.scale]; }
  zoomAt(px, py, factor) {
    const before = this.toUnits(px, py);
    this.scale = Math.min(this.most, Math.max(this.least, this.scale * factor));
    const after = this.toUnits(px, py);
    this.x += before[0] - after[0]; this.y += before[1] - after[1];
    this.change();
  }
  drag(event) {
    const from = this.pointers.get(event.pointerId);
    if (!from) return;
    const to = [event.offsetX, event.offsetY];
    if (Math.hypot(to[0] - from[0], to[1] - from[1]) < 3 && !this.moved) return;
    this.moved = true;
    if (this.pointers.size === 2) {  // two fingers: zoom about the other
      const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
      const distance = p => Math.max(1, Math.hypot(p[0] - other[0], p[1] - other[1]));
      this.zoomAt(...other, distance(to) / distance(from));
    } else {
      this.x -= (to[0] - from[0]) / this.scale; this.y -= this.flip * (to[1] - from[1]) / this.scale;
      this.change();
    }
    this.pointers.set(event.pointerId, to);
  }
  pan(dx, dy) { this.x += dx / this.scale; this.y += this.flip * dy / this.scale; this.change(); }
  fitTo(left, top, right, bottom) {
    const [w, h] = this.size();
    this.x = (left + right) / 2; this.y = (top + bottom) / 2;
    this.scale = Math.min(this.most, Math.max(this.least, Math.min(w / Math.max(1e-9, right - left), h / Math.max(1e-9, bottom - top))));
  }
}
