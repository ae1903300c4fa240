// ---- notes over the picture: axes, names, scales of colours, the body pointed at --------------------------------------

const FONT = '"Liberation Sans", system-ui, -apple-system, "Segoe UI", Roboto, sans-serif';
const point = new THREE.Vector3();

/** Draws on a 2-D canvas whose unit is a pixel of the page. */
class Notes {
  constructor(page) {
    this.page = page;
    this.pen = page.getContext("2d");
    this.pointed = null;
  }

  resize(width, height, pixelRatio) {
    [this.width, this.height] = [width, height];
    this.page.width = Math.max(Math.round(width * pixelRatio), 1);
    this.page.height = Math.max(Math.round(height * pixelRatio), 1);
    this.pen.setTransform(pixelRatio, 0, 0, pixelRatio, 0, 0);
  }

  /** Where a point of the scene is on the page. */
  seen(place, camera) {
    place.project(camera);
    return [(0.5 + 0.5 * place.x) * this.width, (0.5 - 0.5 * place.y) * this.height];
  }

  draw(motion, camera) {
    const { pen } = this;
    pen.clearRect(0, 0, this.width, this.height);
    if (motion.axes) this.#axes(motion, camera);
    pen.font = `13px ${FONT}`;
    motion.names.forEach((name, body) => name && this.#word(name, this.seen(motion.at(body, point), camera)));
    if (this.pointed !== null && this.pointed < motion.particles) {
      const place = this.seen(motion.at(this.pointed, point), camera);
      pen.strokeStyle = palette().ink;
      pen.lineWidth = 1.5;
      pen.beginPath();
      pen.arc(...place, 9, 0, 2 * Math.PI);
      pen.stroke();
      this.#word(motion.names[this.pointed] || `body ${this.pointed}`, place);
    }
    [motion.heat, motion.tints].filter(Boolean).forEach((scale, row) => this.#scale(scale, row));
  }

  /** The body that is nearest on the page, if one is within reach. */
  nearest(motion, camera, x, y) {
    let [best, found] = [14, null];
    for (let body = 0; body < motion.particles; body++) {
      const [u, v] = this.seen(motion.at(body, point), camera);
      const far = Math.hypot(u - x, v - y);
      if (far < best) [best, found] = [far, body];
    }
    return found;
  }

  #word(text, [x, y]) {
    const { pen } = this;
    pen.textAlign = x > this.width - 90 ? "right" : "left";
    pen.textBaseline = "middle";
    pen.lineWidth = 4;
    pen.lineJoin = "round";
    pen.strokeStyle = palette().paper;
    pen.fillStyle = palette().ink;
    const at = x > this.width - 90 ? x - 12 : x + 12;
    pen.strokeText(text, at, y - 10);
    pen.fillText(text, at, y - 10);
  }

  /** A bar of colours with its numbers, at the top on the right. */
  #scale({ label, low, high }, row) {
    const { pen } = this;
    const width = Math.min(190, this.width / 2);
    const [left, top] = [this.width - width - 26, 12 + 52 * row];
    const bar = pen.createLinearGradient(left, 0, left + width, 0);
    VIRIDIS.forEach((colour, i) => bar.addColorStop(i / (VIRIDIS.length - 1), `#${colour}`));
    pen.font = `12.5px ${FONT}`;
    pen.textBaseline = "top";
    pen.textAlign = "right";
    pen.fillStyle = palette().ink;
    pen.fillText(label, left + width, top);
    pen.fillStyle = bar;
    pen.fillRect(left, top + 18, width, 9);
    pen.textAlign = "center";
    pen.fillStyle = pen.strokeStyle = palette().soft;
    pen.lineWidth = 1;
    if (constant(low, high)) return pen.fillText(String(Number(low.toPrecision(6))), left, top + 31);
    for (const { value, label: number } of ticks(low, high, 4)) {
      const x = left + (width * (value - low)) / (high - low);
      this.#line([x, top + 27], [x, top + 31]);
      pen.fillText(number, x, top + 32);
    }
  }

  #line(a, b) {
    this.pen.beginPath();
    this.pen.moveTo(...a);
    this.pen.lineTo(...b);
    this.pen.stroke();
  }

  /**
   * Three edges of the scene's box. Each is that one of its four parallel ones that lies on the outline of the picture,
   * where nothing of the scene is behind it, and lowest (for the upright one: most to the left).
   */
  #axes(motion, camera) {
    const { pen } = this;
    const { corners: [low, high], middle: from, unit } = motion;
    const corner = (bits) => this.seen(point.set(...[0, 1, 2].map((i) => (bits >> i & 1 ? high[i] : low[i]))), camera);
    const corners = Array.from({ length: 8 }, (_, bits) => corner(bits));
    const middle = [0, 1].map((k) => corners.reduce((sum, place) => sum + place[k], 0) / 8);
    const outside = (a, b) => {
      // All corners lie on one side of an edge of the outline.
      const sides = corners.map(([x, y]) => (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]));
      return sides.every((side) => side > -1e-3) || sides.every((side) => side < 1e-3);
    };
    const vertical = new THREE.Vector3(...camera.up.toArray()).toArray().findIndex((x) => x > 0.5);
    pen.font = `12px ${FONT}`;
    pen.textBaseline = "middle";
    for (let axis = 0; axis < 3; axis++) {
      if (!(high[axis] > low[axis])) continue;
      const bases = [0, 1, 2, 3, 4, 5, 6, 7].filter((bits) => !(bits >> axis & 1));
      const edges = bases.map((bits) => [bits, corners[bits], corners[bits | (1 << axis)]]);
      const good = edges.filter(([, a, b]) => outside(a, b));
      const rank = ([, a, b]) => (axis === vertical ? -(a[0] + b[0]) : a[1] + b[1]);
      const [bits, a, b] = (good.length ? good : edges).reduce((x, y) => (rank(y) > rank(x) ? y : x));
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      if (length < 20) continue;
      // Outwards, across the edge.
      let out = [-(b[1] - a[1]) / length, (b[0] - a[0]) / length];
      const half = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
      if (out[0] * (half[0] - middle[0]) + out[1] * (half[1] - middle[1]) < 0) out = out.map((x) => -x);
      const beside = ([x, y], far) => [x + far * out[0], y + far * out[1]];
      pen.strokeStyle = palette().soft;
      pen.fillStyle = palette().soft;
      pen.lineWidth = 1;
      this.#line(a, b);
      pen.textAlign = out[0] > 0.35 ? "left" : out[0] < -0.35 ? "right" : "center";
      let wide = 0;
      const [first, last] = [low, high].map((end) => from[axis] + unit * end[axis]);
      for (const { value, label } of ticks(first, last, Math.min(Math.max(length / 55, 1), 6))) {
        const along = (value - from[axis]) / unit;
        const place = [0, 1, 2].map((i) => (i === axis ? along : bits >> i & 1 ? high[i] : low[i]));
        const at = this.seen(point.set(...place), camera);
        this.#line(at, beside(at, 4));
        pen.fillText(label, ...beside(at, 10));
        wide = Math.max(wide, pen.measureText(label).width);
      }
      pen.fillStyle = palette().ink;
      pen.fillText(motion.axes[axis], ...beside(half, 22 + wide * Math.abs(out[0])));
    }
  }
}

