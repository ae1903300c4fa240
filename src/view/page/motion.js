// ---- one scene --------------------------------------------------------------------------------------------------------

const geometries = {};
function meshGeometry(number, space) {
  const key = `${number}: ${space.middle}, ${space.unit}`; // scenes on the same surfaces share them
  if (geometries[key]) return geometries[key];
  const { vertices, normals, triangles, wide, closed } = data.meshes[number];
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(decodePoints(vertices, space), 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(decode(normals, Int16Array), 3, true));
  geometry.setIndex(new THREE.BufferAttribute(decode(triangles, wide ? Uint32Array : Uint16Array), 1));
  geometry.closed = closed;
  return (geometries[key] = geometry);
}

/** Flat faces: corners counter-clockwise, of one normal and one colour each. */
function faces(list) {
  const [place, normal, colour, index] = [[], [], [], []];
  for (const { corners, towards, tint } of list) {
    const first = place.length / 3;
    corners.forEach((corner) => {
      place.push(...corner);
      normal.push(...towards);
      colour.push(tint.r, tint.g, tint.b);
    });
    for (let i = 2; i < corners.length; i++) index.push(first, first + i - 1, first + i);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(place), 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(new Float32Array(normal), 3));
  geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(colour), 3));
  geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(index), 1));
  return geometry;
}

/** The six faces of a box between two corners. */
function boxFaces(low, high, tint) {
  return [0, 1, 2].flatMap((axis) => [-1, 1].map((sign) => {
    const [u, v] = sign > 0 ? [(axis + 1) % 3, (axis + 2) % 3] : [(axis + 2) % 3, (axis + 1) % 3];
    const corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([i, j]) => {
      const corner = [0, 0, 0];
      corner[axis] = sign > 0 ? high[axis] : low[axis];
      corner[u] = i ? high[u] : low[u];
      corner[v] = j ? high[v] : low[v];
      return corner;
    });
    const towards = [0, 0, 0];
    towards[axis] = sign;
    return { corners, towards, tint };
  }));
}

const AXES = ["#d0443e", "#3c9a3f", "#3a6fd8"].map((text) => new THREE.Color(text));

function boxGeometry(sides) {
  const half = sides.map((side) => side / 2);
  const thick = 0.03 * Math.max(...sides);
  const axis = (i) => [0, 1, 2].map((j) => (j === i ? 0.35 * Math.max(...sides) + half[i] : thick));
  const rods = [0, 1, 2].map((i) => boxFaces([0, 1, 2].map((j) => (j === i ? 0 : -thick)), axis(i), AXES[i]));
  return faces([...boxFaces(half.map((x) => -x), half, new THREE.Color(1, 1, 1)), ...rods.flat()]);
}

const SEGMENTS = 72;
function discGeometry(axis, radius) {
  const z = new THREE.Vector3(...axis).normalize();
  const x = new THREE.Vector3(Math.abs(z.x) < 0.7 ? 1 : 0, Math.abs(z.x) < 0.7 ? 0 : 1, 0).cross(z).normalize();
  const y = z.clone().cross(x);
  const at = (i, r, h) => {
    const turn = (2 * Math.PI * i) / SEGMENTS;
    return x.clone().multiplyScalar(r * Math.cos(turn)).addScaledVector(y, r * Math.sin(turn)).addScaledVector(z, h).toArray();
  };
  const half = 0.03 * radius;
  const tint = new THREE.Color(1, 1, 1);
  const rim = Array.from({ length: SEGMENTS }, (_, i) => i);
  return faces([
    { corners: rim.map((i) => at(i, radius, half)), towards: z.toArray(), tint },
    { corners: rim.map((i) => at(-i, radius, -half)), towards: z.clone().negate().toArray(), tint },
    ...rim.map((i) => ({
      corners: [at(i, radius, -half), at(i + 1, radius, -half), at(i + 1, radius, half), at(i, radius, half)],
      towards: at(i + 0.5, 1, 0),
      tint,
    })),
  ]);
}

function wallGeometry([corner, a, b]) {
  const at = (i, j) => corner.map((x, k) => x + i * a[k] + j * b[k]);
  const towards = new THREE.Vector3(...a).cross(new THREE.Vector3(...b)).normalize().toArray();
  return faces([{ corners: [at(0, 0), at(1, 0), at(1, 1), at(0, 1)], towards, tint: new THREE.Color(1, 1, 1) }]);
}

/** How many periods lead from the end of a way to its image that is nearest to the start, as `nearest` of the shaders. */
const periodsBack = (way, period) => (period > 0 ? Math.floor(0.5 - way / period) : 0);

class Motion {
  constructor(source) {
    Object.assign(this, source);
    this.#fromMiddle();
    this.times = decode(source.times, Float32Array); // after the first, which is `from`
    this.frames = this.times.length;
    this.positions = decodePoints(source.positions, this);
    this.rods = decode(source.rods, Uint32Array);
    this.last = this.frames - 1;
    this.frame = 0;
    const span = this.times[this.last];
    this.pace = span / source.seconds;
    this.written = notation(Math.max(Math.abs(this.from), Math.abs(this.from + span)), (1.02 * span) / this.last);
    this.charts = source.charts.map(({ title, middle, curves }) => ({
      title,
      middle,
      curves: curves.map(({ label, values }) => ({ label, values: decode(values, Float32Array) })),
    }));
    this.#surfaces();
    this.#solids();
    this.#bounds();
    this.#pieces();
    this.objects = [...this.surfaces, ...this.solids.map(({ mesh }) => mesh), ...this.flat];
    this.paint();
  }

  /** All that has a place or a length, from the middle of the scene and in its unit; axes alone tell the scene's own. */
  #fromMiddle() {
    const { middle, unit } = this;
    const place = (point) => point.map((x, i) => (x - middle[i]) / unit);
    const lengths = (list) => list.map((length) => length / unit);
    this.periods = lengths(this.periods);
    this.places = this.places.map(place);
    this.discs = this.discs.map((disc) => ({ ...disc, radius: disc.radius / unit }));
    this.walls = this.walls.map(([corner, ...sides]) => [place(corner), ...sides.map(lengths)]);
    this.boxes = this.boxes.map((box) => ({ ...box, sides: lengths(box.sides) }));
  }

  #surfaces() {
    const values = this.heat && decode(this.heat.values, Uint16Array);
    let first = 0;
    this.surfaces = this.meshes.map((number) => {
      const geometry = new THREE.BufferGeometry();
      const shared = meshGeometry(number, this);
      Object.entries(shared.attributes).forEach(([name, attribute]) => geometry.setAttribute(name, attribute));
      geometry.setIndex(shared.index);
      if (values) {
        const colours = new Float32Array(3 * shared.attributes.position.count);
        const colour = new THREE.Color();
        for (let i = 0; i < colours.length / 3; i++) viridisAt(values[first + i] / 65535, colour).toArray(colours, 3 * i);
        first += colours.length / 3;
        geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
      }
      const side = shared.closed ? THREE.FrontSide : THREE.DoubleSide;
      const material = new THREE.MeshStandardMaterial({ roughness: 0.5, metalness: 0.05, side, vertexColors: Boolean(values) });
      return new THREE.Mesh(geometry, material);
    });
  }

  /** Discs, walls and boxes: what carries each of them is a body's number, or paths of centre and attitude. */
  #solids() {
    const mesh = (geometry, options) =>
      new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ roughness: 0.5, vertexColors: true, ...options }));
    const glass = { side: THREE.DoubleSide, transparent: true, opacity: 0.16, depthWrite: false };
    this.solids = [
      ...this.discs.map(({ centre, axis, radius }) => {
        const geometry = discGeometry(axis, radius);
        geometry.computeBoundingBox(); // about its centre
        return { mesh: mesh(geometry, {}), centre, reach: geometry.boundingBox.max.toArray() };
      }),
      ...this.walls.map((wall) => ({ mesh: mesh(wallGeometry(wall), glass) })),
      ...this.boxes.map(({ sides, centres, turns }) => ({
        mesh: mesh(boxGeometry(sides), {}),
        centres: decodePoints(centres, this),
        turns: decode(turns, Float32Array),
        reach: Array(3).fill(0.5 * Math.hypot(...sides) + 0.3 * Math.max(...sides)),
      })),
    ];
    this.solids.forEach((solid) => {
      if (!solid.reach) solid.mesh.renderOrder = 4;
      solid.mesh.frustumCulled = false;
    });
  }

  /** Bounds of all that is drawn, and in each direction from the middle the farthest point: what the camera must see. */
  #bounds() {
    const points = [];
    const add = (array) => points.push(array);
    add(this.positions);
    add(new Float32Array(this.places.flat()));
    this.surfaces.forEach((surface) => add(surface.geometry.attributes.position.array));
    for (const { centres, centre, reach, mesh } of this.solids) {
      const middles = centres ?? (centre === undefined ? [] : this.#all(centre));
      if (!reach) add(mesh.geometry.attributes.position.array);
      for (const sign of reach ? [-1, 1] : []) {
        const moved = (x, i, axis) => x + (i % 3 === axis ? sign * reach[axis] : 0);
        for (let axis = 0; axis < 3; axis++) add(Float32Array.from(middles, (x, i) => moved(x, i, axis)));
      }
    }
    const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    for (const array of points) {
      for (let i = 0; i < array.length; i++) {
        low[i % 3] = Math.min(low[i % 3], array[i]);
        high[i % 3] = Math.max(high[i % 3], array[i]);
      }
    }
    this.corners = [low, high];
    this.radius = Math.max(0.5 * Math.hypot(...[0, 1, 2].map((i) => high[i] - low[i])), 1e-30);
    const middle = [0, 1, 2].map((i) => (low[i] + high[i]) / 2);
    const [rows, columns] = [40, 80];
    const farthest = new Map();
    for (const array of points) {
      for (let i = 0; i < array.length; i += 3) {
        const [x, y, z] = [array[i] - middle[0], array[i + 1] - middle[1], array[i + 2] - middle[2]];
        const far = Math.hypot(x, y, z);
        const row = Math.min(Math.floor((0.5 + 0.5 * (far ? z / far : 0)) * rows), rows - 1);
        const cell = row * columns + Math.floor((0.5 + Math.atan2(y, x) / (2 * Math.PI)) * (columns - 1));
        if (!(far <= farthest.get(cell)?.far)) farthest.set(cell, { far, point: array.subarray(i, i + 3) });
      }
    }
    this.outline = new Float32Array([...farthest.values()].flatMap(({ point }) => [...point]));
  }

  /** Where a body is at all times, or a fixed place. */
  #all(end) {
    return end < this.particles
      ? this.positions.subarray(3 * end * this.frames, 3 * (end + 1) * this.frames)
      : this.places[end - this.particles];
  }

  /**
   * How often each body has gone round space along the axes, at each sample: from one to the next it goes to the nearest
   * image. Counts to 256 are the digits of one number, the most that f32 holds.
   */
  #rounds() {
    const rounds = new Float32Array(this.positions.length / 3);
    if (!this.periods.some((period) => period > 0)) return rounds;
    for (let i = 0; i < rounds.length; i++) {
      if (i % this.frames === 0) continue; // the first of a body
      this.periods.forEach((period, axis) => {
        const way = this.positions[3 * i + axis] - this.positions[3 * (i - 1) + axis];
        const digit = 256 ** axis;
        const before = Math.floor(rounds[i - 1] / digit) % 256;
        rounds[i] += digit * ((((before + periodsBack(way, period)) % 256) + 256) % 256);
      });
    }
    return rounds;
  }

  /** A length that rods typically have at the start. */
  #rodLength() {
    const lengths = [];
    for (let i = 0; i < this.rods.length; i += 2) {
      const [a, b] = [this.#all(this.rods[i]), this.#all(this.rods[i + 1])];
      lengths.push(Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
    }
    return lengths.sort((a, b) => a - b)[lengths.length >> 1] ?? Infinity;
  }

  /** Balls, rods and trails; once more, faint, where a surface hides them. */
  #pieces() {
    const { particles, frames } = this;
    const bodies = this.positions.length / 3;
    const place = (i) => (i < bodies ? this.positions.subarray(3 * i, 3 * i + 3) : this.places[i - bodies]);
    const rounds = this.#rounds();
    const sample = (i) => [...place(i), rounds[i] ?? 0];
    const sizes = this.sizes && decode(this.sizes.values, Float32Array).map((size) => size / this.unit);
    const tints = this.tints && decode(this.tints.values, Uint16Array);
    const eachFrames = Math.max(this.sizes?.each ?? 1, this.tints?.each ?? 1);
    const value = (list, each, i) => (!list ? 0 : each === eachFrames ? list[i] : list[Math.floor(i / eachFrames)]);
    const own = (i) => [value(tints, this.tints?.each, i) / 65535, value(sizes, this.sizes?.each, i), 0, 0];
    const rodLength = this.#rodLength();
    const crowd = Math.min(1, 8 / Math.sqrt(particles || 1));
    const size = Math.min(0.014 * this.radius * Math.max(crowd, 0.5), 0.3 * rodLength);
    this.fine = rodLength < 0.1 * this.radius; // joints need not stand out
    this.uniforms = {
      samples: { value: texture(sample, bodies + this.places.length) },
      each: { value: texture(own, sizes || tints ? particles * eachFrames : 1) },
      eachFrames: { value: sizes || tints ? eachFrames : 0 },
      frame: { value: 0 },
      frames: { value: frames },
      particles: { value: particles },
      periods: { value: new THREE.Vector3(...this.periods) },
      trail: { value: this.trail },
      width: { value: 0.0055 * this.radius },
      thin: { value: 1 },
      lift: { value: 0 },
      pixels: { value: new THREE.Vector2(1, 1) },
      size: { value: size },
      smallest: { value: 0 },
      thinnest: { value: 0 },
      rod: { value: Math.min(0.006 * this.radius, 0.14 * rodLength) },
      tinted: { value: tints ? 1 : 0 },
      sized: { value: sizes ? 1 : 0 },
      scale: { value: viridis },
      ground: { value: new THREE.Color() },
      paint: { value: new THREE.Color() },
      eyeToScreen: { value: new THREE.Matrix4() },
    };
    this.strengths = [{ value: 1 }, { value: 0 }];
    this.balls = withColours(strips(particles, 1, 3, (body, end, side) => [2 * end - 1, side, body]));
    const { rods } = this;
    const sticks = strips(rods.length / 2, 1, 4, (rod, end, side) => [end, side, rods[2 * rod], rods[2 * rod + 1]]);
    this.ribbon = withColours(strips(this.trail ? particles : 0, this.trail, 3, (body, age, side) => [age, side, body]));
    const hidden = this.surfaces.length > 0;
    this.flat = [
      [this.balls, ballVertex, ballFragment, 3, sizes ? 0 : 1],
      [sticks, rodVertex, rodFragment, 2, 0],
      [this.ribbon, ribbonVertex, ribbonFragment, 5, 0.008 * this.radius],
    ].flatMap(([geometry, vertexShader, fragmentShader, order, lift]) => {
      if (geometry.index.count === 0) return [];
      return this.strengths.slice(0, hidden ? 2 : 1).map((strength, pass) => {
        const uniforms = { ...this.uniforms, strength, lift: { value: lift } };
        const material = new THREE.ShaderMaterial({ uniforms, vertexShader, fragmentShader, transparent: true, side: THREE.DoubleSide });
        material.depthWrite = pass === 0 && order < 5;
        if (pass === 1) material.depthFunc = THREE.GreaterDepth;
        const mesh = new THREE.Mesh(geometry, material);
        mesh.frustumCulled = false;
        mesh.renderOrder = pass === 1 ? 1 : order; // what a surface hides is drawn before what could hide it as well
        return mesh;
      });
    });
  }

  /** Colours for the theme in force. */
  paint() {
    const { surface, ground, ghost, rod } = palette();
    const colours = (geometry, each) => {
      const { array } = geometry.attributes.colour;
      for (let body = 0; body < array.length / each / 3; body++) {
        const rgb = hue(body, this.particles);
        for (let i = 0; i < each; i++) array.set(rgb, 3 * (body * each + i));
      }
      geometry.attributes.colour.needsUpdate = true;
    };
    colours(this.balls, 4);
    colours(this.ribbon, 2 * (this.trail + 1));
    this.strengths[1].value = ghost;
    this.uniforms.ground.value.setHex(ground);
    this.uniforms.paint.value.setHex(rod);
    this.surfaces.forEach(({ material }) => material.color.setHex(this.heat ? 0xffffff : surface));
    this.solids.forEach(({ mesh }) => mesh.material.color.setHex(surface));
  }

  /** Puts everything to the current frame. `worldPerPixel`, at distance one, keeps heads and rods visible from far away. */
  place(camera, worldPerPixel, pixels, pixelRatio) {
    const { uniforms } = this;
    uniforms.frame.value = this.frame;
    uniforms.pixels.value.copy(pixels);
    uniforms.thin.value = 2.4 * pixelRatio;
    uniforms.smallest.value = (this.sizes ? 0.8 : this.fine ? 1.4 : Math.max(4.2 * Math.min(1, 18 / Math.sqrt(this.particles)), 1.4)) * worldPerPixel;
    uniforms.thinnest.value = (this.fine ? 0.7 : 1.2) * worldPerPixel;
    uniforms.eyeToScreen.value.copy(camera.projectionMatrix);
    const time = this.time();
    const shown = this.starts.findLastIndex((start) => start <= time);
    this.surfaces.forEach((surface, i) => (surface.visible = i === Math.max(shown, 0)));
    for (const { mesh, centre, centres, turns } of this.solids) {
      if (centre !== undefined) this.at(centre, mesh.position);
      if (centres) {
        this.#between(centres, 3, mesh.position);
        this.#between(turns, 4, mesh.quaternion);
        mesh.quaternion.normalize();
      }
    }
  }

  /** A body at the current frame, or a fixed place. */
  at(end, into) {
    if (end >= this.particles) return into.fromArray(this.places[end - this.particles]);
    return this.#between(this.#all(end), 3, into);
  }

  /**
   * Between the two samples of a path around the current frame: on the way to the nearest image of the next place, as
   * the shaders go; quaternions of one rotation may have either sign.
   */
  #between(path, width, into) {
    const whole = path.length === width ? 0 : Math.min(Math.floor(this.frame), this.last);
    const next = path.length === width ? 0 : Math.min(whole + 1, this.last);
    const [a, b] = [path.subarray(width * whole, width * (whole + 1)), path.subarray(width * next, width * (next + 1))];
    const part = this.frame - Math.floor(this.frame);
    const sign = width === 4 && a.reduce((sum, x, i) => sum + x * b[i], 0) < 0 ? -1 : 1;
    const round = (i) => (width === 3 ? this.periods[i] * periodsBack(b[i] - a[i], this.periods[i]) : 0);
    return into.fromArray(Array.from(a, (x, i) => x + part * (sign * b[i] + round(i) - x)));
  }

  /** Time goes on by `seconds` of the spectator's; after the end it starts again. */
  advance(seconds) {
    const time = this.time() + seconds * this.pace;
    this.frame = time >= this.times[this.last] ? 0 : this.frameAt(time);
  }

  /** After the first sample. */
  time() {
    const whole = Math.min(Math.floor(this.frame), this.last);
    const next = Math.min(whole + 1, this.last);
    return this.times[whole] + (this.frame - whole) * (this.times[next] - this.times[whole]);
  }

  /** The time of the run, in words. */
  clock() {
    return this.written(this.from + this.time());
  }

  frameAt(time) {
    if (time >= this.times[this.last]) return this.last;
    let [low, high] = [0, this.last];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle;
      else high = middle;
    }
    return low + Math.max(time - this.times[low], 0) / (this.times[high] - this.times[low]);
  }
}

