// The one connection: opened again by itself, told what the page looks at, silent while the page is hidden.
import { decode } from './decode.js';

const kRetryMs = 500;
const kNoDetail = 0, kDetailById = 1, kDetailByPlace = 2;

/// What the page looks at; see client_message.h.
function wishBytes(wish) {
  const view = new DataView(new ArrayBuffer(48));
  view.setUint8(0, 1);
  view.setUint8(1, wish.visible ? 1 : 0);
  view.setUint32(4, wish.kinds.reduce((bits, kind) => bits | 1 << kind, 0), true);
  view.setUint16(8, wish.camera ?? 0xffff, true);
  view.setUint16(10, wish.pictureWidth, true);
  (wish.region ?? [0, 0, 0, 0]).forEach((value, i) => view.setFloat32(12 + 4 * i, value, true));
  const detail = wish.detail;
  view.setUint8(28, !detail ? kNoDetail : detail.hasId ? kDetailById : kDetailByPlace);
  if (!detail) return view.buffer;
  const id = BigInt(detail.id);
  view.setUint16(30, detail.family, true);
  view.setUint32(32, Number(id & 0xffffffffn), true);
  view.setUint32(36, Number(id >> 32n), true);
  detail.center.forEach((value, i) => view.setFloat32(40 + 4 * i, value, true));
  return view.buffer;
}

function seekBytes({ at, speed, playing }) {
  const view = new DataView(new ArrayBuffer(16));
  view.setUint8(0, 2);
  view.setUint8(1, playing ? 1 : 0);
  view.setFloat32(4, speed, true);
  view.setFloat64(8, at, true);
  return view.buffer;
}

export class Link {
  /// @param take gets each message, decoded. @param change is told whether the server is there.
  constructor(take, change) {
    this.take = take;
    this.change = change;
    this.wish = { visible: !document.hidden, kinds: [], pictureWidth: 640 };
    this.sent = '';
    document.addEventListener('visibilitychange', () => this.tell({ visible: !document.hidden }));
    this.open();
  }

  open() {
    const socket = new WebSocket(`ws://${location.host}/`, 'chequer');
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => { this.socket = socket; this.sent = ''; this.change(true); this.send(); if (this.moment) this.seek(this.moment); };
    socket.onmessage = event => this.take(decode(event.data));
    socket.onclose = () => {
      if (this.socket) this.change(false);
      this.socket = null;
      setTimeout(() => this.open(), kRetryMs);
    };
  }

  /// Changes what the page looks at.
  tell(changes) {
    Object.assign(this.wish, changes);
    this.send();
  }

  send() {
    const key = JSON.stringify(this.wish);
    if (!this.socket || key === this.sent) return;
    this.sent = key;
    this.socket.send(wishBytes(this.wish));
  }

  seek(moment) {
    this.moment = moment;
    this.socket?.send(seekBytes(moment));
  }
}
