// ---- charts beside the motion, with its time as a cursor ----------------------------------------------------------------

// Okabe & Ito (2008), told apart by all kinds of colour vision.
const CURVES = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
const curveColour = (i) => (dark.matches && i === 0 ? "#56a5e0" : CURVES[i % CURVES.length]);
const EDGE = { right: 12, top: 24, bottom: 22 };

class Chart {
  constructor(page, motion, number) {
    Object.assign(this, { page, motion, ...motion.charts[number] });
    this.pen = page.getContext("2d");
    this.still = document.createElement("canvas");
    const values = this.curves.map((curve) => curve.values);
    const end = (pick, none) => values.reduce((end, list) => list.reduce((a, b) => pick(a, b), end), none);
    [this.low, this.high] = [end(Math.min, Infinity), end(Math.max, -Infinity)];
    const ends = [this.low, this.high].map((end) => this.middle + end);
    if (constant(...ends)) {
      const room = 1e-3 * Math.max(...ends.map(Math.abs)) || 1;
      [this.low, this.high] = [this.low - room, this.high + room];
    }
    page.setAttribute("role", "img");
    page.setAttribute("aria-label", `${this.title}, over time`);
    const follow = (event) => {
      const { left } = page.getBoundingClientRect();
      return this.timeAt(event.clientX - left);
    };
    page.addEventListener("pointerdown", (event) => {
      page.setPointerCapture(event.pointerId);
      this.seek?.(follow(event));
    });
    page.addEventListener("pointermove", (event) => event.buttons && this.seek?.(follow(event)));
  }

  /** Between the first sample and the last; times of a chart are those after the first. */
  get span() {
    return this.motion.times[this.motion.last];
  }

  timeAt(x) {
    const part = (x - this.left) / (this.width - this.left - EDGE.right);
    return Math.min(Math.max(part, 0), 1) * this.span;
  }

  x(time) {
    return this.left + (time / this.span) * (this.width - this.left - EDGE.right);
  }

  y(value) {
    return this.height - EDGE.bottom - ((value - this.low) / (this.high - this.low)) * (this.height - EDGE.top - EDGE.bottom);
  }

  resize(pixelRatio) {
    const { width, height } = this.page.getBoundingClientRect();
    Object.assign(this, { width, height, pixelRatio });
    for (const page of [this.page, this.still]) {
      page.width = Math.max(Math.round(width * pixelRatio), 1);
      page.height = Math.max(Math.round(height * pixelRatio), 1);
    }
    this.#drawStill();
  }

  /** All but the cursor; long curves with the lowest and the highest value of each column of pixels. */
  #drawStill() {
    const pen = this.still.getContext("2d");
    const { ink, soft, line } = palette();
    pen.setTransform(this.pixelRatio, 0, 0, this.pixelRatio, 0, 0);
    pen.clearRect(0, 0, this.width, this.height);
    pen.font = `11.5px ${FONT}`;
    const most = Math.max((this.height - EDGE.top - EDGE.bottom) / 34, 1);
    const up = ticks(this.middle + this.low, this.middle + this.high, most).map(({ value, label }) => ({ value: value - this.middle, label }));
    this.left = 14 + Math.max(...up.map(({ label }) => pen.measureText(label).width), 0);
    const { from } = this.motion;
    const times = (room) => ticks(from, from + this.span, Math.max((this.width - this.left) / room, 1));
    // One and a half times as wide as a label, since the last one is moved back into the picture.
    const room = Math.max(70, ...times(70).map(({ label }) => 1.5 * pen.measureText(label).width));
    const across = times(room).map(({ value, label }) => ({ value: value - from, label }));
    const [bottom, right] = [this.height - EDGE.bottom, this.width - EDGE.right];
    const rule = (a, b, colour) => {
      pen.strokeStyle = colour;
      pen.lineWidth = 1;
      pen.beginPath();
      pen.moveTo(...a);
      pen.lineTo(...b);
      pen.stroke();
    };
    pen.textBaseline = "middle";
    pen.textAlign = "right";
    for (const { value, label } of up) {
      rule([this.left, this.y(value)], [right, this.y(value)], line);
      pen.fillStyle = soft;
      pen.fillText(label, this.left - 5, this.y(value));
    }
    pen.textAlign = "center";
    for (const { value, label } of across) {
      rule([this.x(value), bottom], [this.x(value), bottom + 3], soft);
      pen.fillText(label, Math.min(this.x(value), this.width - pen.measureText(label).width / 2), bottom + 12);
    }
    rule([this.left, bottom], [right, bottom], soft);
    pen.lineJoin = "round";
    pen.lineWidth = 1.4;
    this.curves.forEach(({ values }, i) => {
      pen.strokeStyle = curveColour(i);
      pen.beginPath();
      this.#trace(pen, values);
      pen.stroke();
    });
    pen.textAlign = "left";
    pen.font = `12px ${FONT}`;
    pen.fillStyle = ink;
    pen.fillText(this.title, 6, 11);
    let x = this.width - EDGE.right;
    pen.textAlign = "right";
    [...this.curves.entries()].reverse().forEach(([i, { label }]) => {
      if (!label) return;
      pen.fillStyle = curveColour(i);
      pen.fillText(label, x, 11);
      x -= pen.measureText(label).width + 10;
    });
  }

  #trace(pen, values) {
    const { times } = this.motion;
    const column = (i) => Math.floor(2 * this.x(times[i]));
    for (let i = 0; i < values.length; ) {
      let end = i + 1;
      while (end < values.length && column(end) === column(i)) end++;
      let [low, high] = [i, i];
      for (let j = i; j < end; j++) {
        if (values[j] < values[low]) low = j;
        if (values[j] > values[high]) high = j;
      }
      for (const j of [...new Set([i, low, high, end - 1])].sort((a, b) => a - b)) pen.lineTo(this.x(times[j]), this.y(values[j]));
      i = end;
    }
  }

  draw() {
    const { pen, motion } = this;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.page.width, this.page.height);
    pen.drawImage(this.still, 0, 0);
    pen.setTransform(this.pixelRatio, 0, 0, this.pixelRatio, 0, 0);
    this.cursor = this.x(motion.time());
    pen.strokeStyle = pen.fillStyle = palette().ink;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(this.cursor, EDGE.top - 2);
    pen.lineTo(this.cursor, this.height - EDGE.bottom);
    pen.stroke();
    const whole = Math.min(Math.floor(motion.frame), motion.last);
    const next = Math.min(whole + 1, motion.last);
    this.curves.forEach(({ values }, i) => {
      pen.fillStyle = curveColour(i);
      pen.beginPath();
      pen.arc(this.cursor, this.y(values[whole] + (motion.frame - whole) * (values[next] - values[whole])), 3, 0, 2 * Math.PI);
      pen.fill();
    });
  }
}

