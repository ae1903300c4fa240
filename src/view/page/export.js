// ---- pictures and films to keep -----------------------------------------------------------------------------------------

const FILM_RATE = 25; // pictures for each of the spectator's seconds

/** One picture of all that moves, with even sides, as codecs want them. */
function compose(layers, charts, title, time) {
  const ratio = layers[0].width / layers[0].clientWidth;
  const [head, beside] = [Math.round(44 * ratio), Math.max(...charts.map(({ page }) => page.width), 0)];
  const page = document.createElement("canvas");
  page.width = 2 * Math.ceil((layers[0].width + beside) / 2);
  page.height = 2 * Math.ceil((head + Math.max(layers[0].height, charts.reduce((sum, chart) => sum + chart.page.height, 0))) / 2);
  const pen = page.getContext("2d");
  const { ink, soft, paper } = palette();
  pen.fillStyle = paper;
  pen.fillRect(0, 0, page.width, page.height);
  layers.forEach((layer) => pen.drawImage(layer, 0, head));
  let top = head;
  for (const { page: chart } of charts) {
    pen.drawImage(chart, layers[0].width, top);
    top += chart.height;
  }
  pen.textBaseline = "middle";
  pen.font = `600 ${17 * ratio}px ${FONT}`;
  pen.fillStyle = ink;
  pen.fillText(title, 16 * ratio, head / 2);
  pen.font = `${14 * ratio}px ${FONT}`;
  pen.textAlign = "right";
  pen.fillStyle = soft;
  pen.fillText(time, page.width - 16 * ratio, head / 2);
  return page;
}

const toPng = (page) => new Promise((done) => page.toBlob(done, "image/png"));

const CRC = Uint32Array.from({ length: 256 }, (_, i) => {
  let rest = i;
  for (let bit = 0; bit < 8; bit++) rest = rest & 1 ? 0xedb88320 ^ (rest >>> 1) : rest >>> 1;
  return rest;
});

function crc32(bytes) {
  let rest = 0xffffffff;
  for (const byte of bytes) rest = CRC[(rest ^ byte) & 255] ^ (rest >>> 8);
  return (rest ^ 0xffffffff) >>> 0;
}

/** What a ZIP archive has room for: files (one more is a sign for larger archives), and bytes of them; the rest of 4 GiB is for its directory. */
const MOST_FILES = 65534;
const MOST_BYTES = 4e9;

/** A ZIP archive of files that are stored as they are: PNG is packed already. */
class Archive {
  parts = [];
  entries = [];
  length = 0;

  hasRoom(bytes, mostFiles) {
    return this.entries.length < mostFiles && this.length + bytes.length < MOST_BYTES;
  }

  add(name, bytes) {
    const entry = { name: new TextEncoder().encode(name), crc: crc32(bytes), size: bytes.length, at: this.length };
    this.entries.push(entry);
    this.#push(this.#header(0x04034b50, entry), entry.name, bytes);
  }

  finish() {
    const start = this.length;
    this.entries.forEach((entry) => this.#push(this.#header(0x02014b50, entry), entry.name));
    const end = new DataView(new ArrayBuffer(22));
    end.setUint32(0, 0x06054b50, true);
    [8, 10].forEach((at) => end.setUint16(at, this.entries.length, true));
    end.setUint32(12, this.length - start, true);
    end.setUint32(16, start, true);
    this.#push(new Uint8Array(end.buffer));
    return new Blob(this.parts, { type: "application/zip" });
  }

  #push(...parts) {
    this.parts.push(...parts);
    this.length += parts.reduce((sum, part) => sum + part.length, 0);
  }

  /** Of a file, or of its line in the directory, which has some numbers more. */
  #header(kind, { name, crc, size, at }) {
    const listed = kind === 0x02014b50;
    const view = new DataView(new ArrayBuffer(listed ? 46 : 30));
    let place = listed ? 6 : 4;
    view.setUint32(0, kind, true);
    if (listed) view.setUint16(4, 20, true);
    [20, 0x800, 0, 0, 0x21].forEach((value, i) => view.setUint16(place + 2 * i, value, true)); // 1 January 1980
    place += 10;
    [crc, size, size].forEach((value, i) => view.setUint32(place + 4 * i, value, true));
    view.setUint16(place + 12, name.length, true);
    if (listed) view.setUint32(42, at, true);
    return new Uint8Array(view.buffer);
  }
}

function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

const fileName = () => document.title.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "") || "motion";

