// The page's own script: reads the data, draws the surface and the moving particles, and listens to the controls.
// three.js is the global THREE. A position on the time axis is a `frame`, a real number between two samples.

const element = (id) => document.getElementById(id);
const canvas = element("canvas");
const data = JSON.parse(element("data").textContent);

// ---- data: base64, little-endian ------------------------------------------------------------------------------------

function decode(text, Type) {
  return new Type(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);
}

/** Points are 16-bit fractions of a cube. */
function decodePoints({ corner, size, points }) {
  const whole = decode(points, Uint16Array);
  return Float32Array.from(whole, (value, i) => corner[i % 3] + (size * value) / 65535);
}

// ---- colours --------------------------------------------------------------------------------------------------------

const dark = matchMedia("(prefers-color-scheme: dark)");
const palette = () =>
  dark.matches ? { surface: 0x6d7a90, sky: 0xffffff, ground: 0x20242e, light: 0.8, chroma: 0.15, ghost: 0.4 }
               : { surface: 0xd9d3c7, sky: 0xffffff, ground: 0x8d8578, light: 0.56, chroma: 0.19, ghost: 0.36 };

/** OKLCH (Ottosson 2020) to linear sRGB: hues of equal lightness, told apart equally well. */
function oklch(lightness, chroma, turn) {
  const a = chroma * Math.cos(2 * Math.PI * turn);
  const b = chroma * Math.sin(2 * Math.PI * turn);
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const rgb = [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
  return rgb.map((value) => Math.min(Math.max(value, 0), 1));
}

const hue = (i, count) => oklch(palette().light, palette().chroma, 0.07 + i / count);

// ---- trails: one ribbon per particle, bent by the graphics processor --------------------------------------------------

// All positions lie in one texture. The vertex shader reads those of the last `trail` samples, so a frame costs the
// processor one number.
const TEXTURE_WIDTH = 2048;

const ribbonVertex = `
uniform highp sampler2D samples;
uniform float frame, frames, trail, width, thin, lift;
uniform vec2 pixels;
attribute vec3 place; // age in samples, side −1 or 1, particle
attribute vec3 colour;
varying vec3 hue;
varying float fade, side;

vec3 sampled(float index) {
  int texel = int(place.z) * int(frames) + int(clamp(index, 0.0, frames - 1.0));
  return texelFetch(samples, ivec2(texel % ${TEXTURE_WIDTH}, texel / ${TEXTURE_WIDTH}), 0).xyz;
}
// The head glides between samples; the older points are the samples themselves.
vec3 aged(float age) {
  float whole = floor(frame);
  if (age <= 0.0) return mix(sampled(whole), sampled(whole + 1.0), frame - whole);
  return sampled(whole + 1.0 - age);
}
vec4 seen(vec3 point) {
  vec4 view = modelViewMatrix * vec4(point, 1.0);
  view.xyz *= 1.0 - lift / length(view.xyz); // towards the eye: off the surface, same place on the screen
  return projectionMatrix * view;
}
void main() {
  vec4 here = seen(aged(place.x));
  vec4 ahead = seen(aged(max(place.x - 1.0, 0.0)));
  vec4 behind = seen(aged(min(place.x + 1.0, trail)));
  vec2 along = (ahead.xy / ahead.w - behind.xy / behind.w) * pixels;
  float size = length(along);
  vec2 across = size > 1e-6 ? vec2(-along.y, along.x) / size : vec2(0.0);

  float age = place.x <= 0.0 ? 0.0 : frame - floor(frame) + place.x - 1.0;
  fade = max(1.0 - age / trail, 0.0);
  side = place.y;
  hue = colour;
  float thickness = max(width * projectionMatrix[1][1] * pixels.y / here.w, thin) * (0.2 + 0.8 * fade);
  here.xy += across * side * thickness / pixels * here.w;
  gl_Position = here;
}`;

const ribbonFragment = `
uniform float strength;
varying vec3 hue;
varying float fade, side;
void main() {
  float edge = 1.0 - smoothstep(1.0 - 1.5 * fwidth(side), 1.0, abs(side));
  gl_FragColor = vec4(hue, strength * edge * pow(fade, 0.8));
  #include <colorspace_fragment>
}`;

function ribbonGeometry(particles, trail) {
  const length = trail + 1;
  const place = new Float32Array(particles * length * 2 * 3);
  const index = new Uint32Array(particles * trail * 6);
  for (let particle = 0, vertex = 0, corner = 0; particle < particles; particle++) {
    for (let age = 0; age < length; age++, vertex += 2) {
      place.set([age, -1, particle, age, 1, particle], 3 * vertex);
      if (age < trail) {
        index.set([vertex, vertex + 1, vertex + 2, vertex + 1, vertex + 3, vertex + 2], corner);
        corner += 6;
      }
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(place, 3)); // three.js counts vertices by it
  geometry.setAttribute("place", new THREE.BufferAttribute(place, 3));
  geometry.setAttribute("colour", new THREE.BufferAttribute(new Float32Array(place.length), 3));
  geometry.setIndex(new THREE.BufferAttribute(index, 1));
  return geometry;
}

function samplesTexture(positions) {
  const points = positions.length / 3;
  const height = Math.ceil(points / TEXTURE_WIDTH);
  const texels = new Float32Array(TEXTURE_WIDTH * height * 4);
  for (let i = 0; i < points; i++) texels.set(positions.subarray(3 * i, 3 * i + 3), 4 * i);
  const texture = new THREE.DataTexture(texels, TEXTURE_WIDTH, height, THREE.RGBAFormat, THREE.FloatType);
  texture.minFilter = texture.magFilter = THREE.NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

// ---- one scene --------------------------------------------------------------------------------------------------------

const surfaces = [];
function surface(number) {
  if (surfaces[number]) return surfaces[number];
  const { vertices, normals, triangles, wide, closed } = data.meshes[number];
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(decodePoints(vertices), 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(decode(normals, Int16Array), 3, true));
  geometry.setIndex(new THREE.BufferAttribute(decode(triangles, wide ? Uint32Array : Uint16Array), 1));
  const side = closed ? THREE.FrontSide : THREE.DoubleSide;
  const material = new THREE.MeshStandardMaterial({ roughness: 0.5, metalness: 0.05, side });
  return (surfaces[number] = new THREE.Mesh(geometry, material));
}

class Motion {
  constructor(source) {
    Object.assign(this, source);
    this.times = decode(source.times, Float32Array);
    this.frames = this.times.length;
    this.positions = decodePoints(source.positions);
    this.last = this.frames - 1;
    this.frame = 0;
    this.pace = (this.times[this.last] - this.times[0]) / source.seconds;
    this.digits = Math.min(Math.max(Math.ceil(-Math.log10((this.times[this.last] - this.times[0]) / this.last) - 0.01), 0), 6);
    this.surface = source.mesh === null ? null : surface(source.mesh);
    this.shapes = [this.positions, this.surface?.geometry.attributes.position.array ?? []];
    this.corners = this.#bounds();
    this.radius = 0.5 * new THREE.Vector3(...this.corners[0]).distanceTo(new THREE.Vector3(...this.corners[1]));
    this.objects = [...this.#ribbons(), ...this.#heads()];
    if (this.surface) this.objects.push(this.surface);
    this.paint();
  }

  #bounds() {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (const array of this.shapes) {
      for (let i = 0; i < array.length; i++) {
        low[i % 3] = Math.min(low[i % 3], array[i]);
        high[i % 3] = Math.max(high[i % 3], array[i]);
      }
    }
    return [low, high];
  }

  // Drawn twice: as it is, and faint where the surface hides it.
  #ribbons() {
    this.uniforms = {
      samples: { value: samplesTexture(this.positions) },
      frame: { value: 0 },
      frames: { value: this.frames },
      trail: { value: this.trail },
      width: { value: 0.0055 * this.radius },
      thin: { value: 1 },
      lift: { value: 0.008 * this.radius },
      pixels: { value: new THREE.Vector2(1, 1) },
    };
    this.strengths = [{ value: 1 }, { value: 0 }];
    this.ribbon = ribbonGeometry(this.particles, this.trail);
    return this.strengths.map((strength, pass) => {
      const material = new THREE.ShaderMaterial({
        uniforms: { ...this.uniforms, strength },
        vertexShader: ribbonVertex,
        fragmentShader: ribbonFragment,
        transparent: true,
        depthWrite: false,
        side: THREE.DoubleSide,
      });
      if (pass === 1) material.depthFunc = THREE.GreaterDepth;
      const mesh = new THREE.Mesh(this.ribbon, material);
      mesh.frustumCulled = false;
      mesh.renderOrder = 2 - pass;
      return mesh;
    });
  }

  #heads() {
    const ball = new THREE.SphereGeometry(1, 20, 14);
    const solid = new THREE.MeshStandardMaterial({ roughness: 0.35 });
    const hidden = new THREE.MeshStandardMaterial({ roughness: 0.35, transparent: true, depthWrite: false });
    hidden.depthFunc = THREE.GreaterDepth;
    this.heads = [solid, hidden].map((material) => {
      const mesh = new THREE.InstancedMesh(ball, material, this.particles);
      mesh.frustumCulled = false;
      mesh.renderOrder = material === hidden ? 1 : 0;
      return mesh;
    });
    return this.heads;
  }

  /** Colours for the theme in force. */
  paint() {
    const { surface: ground, ghost } = palette();
    const colour = this.ribbon.attributes.colour;
    const ball = new THREE.Color();
    for (let particle = 0; particle < this.particles; particle++) {
      const rgb = hue(particle, this.particles);
      this.heads.forEach((mesh) => mesh.setColorAt(particle, ball.setRGB(...rgb)));
      const span = 2 * (this.trail + 1);
      for (let i = 0; i < span; i++) colour.array.set(rgb, 3 * (particle * span + i));
    }
    colour.needsUpdate = true;
    this.heads.forEach((mesh) => (mesh.instanceColor.needsUpdate = true));
    this.heads[1].material.opacity = this.strengths[1].value = ghost;
    this.surface?.material.color.setHex(ground);
  }

  /** Puts heads and trails to the current frame. `worldPerPixel` keeps heads visible from far away. */
  place(eye, worldPerPixel, pixels, pixelRatio) {
    this.uniforms.frame.value = this.frame;
    this.uniforms.pixels.value.copy(pixels);
    this.uniforms.thin.value = 2.4 * pixelRatio;
    const size = Math.max(0.014 * this.radius, 4.2 * worldPerPixel);
    const whole = Math.min(Math.floor(this.frame), this.last);
    const part = this.frame - whole;
    for (let particle = 0; particle < this.particles; particle++) {
      const here = 3 * (particle * this.frames + whole);
      const next = whole < this.last ? here + 3 : here;
      const at = (i) => this.positions[here + i] + part * (this.positions[next + i] - this.positions[here + i]);
      point.set(at(0), at(1), at(2));
      lifted.copy(eye).sub(point).setLength(size).add(point); // towards the eye, so that no head is half sunk in
      matrix.makeScale(size, size, size).setPosition(lifted);
      this.heads.forEach((mesh) => mesh.setMatrixAt(particle, matrix));
    }
    this.heads.forEach((mesh) => (mesh.instanceMatrix.needsUpdate = true));
  }

  /** Time goes on by `seconds` of the spectator's; after the end it starts again. */
  advance(seconds) {
    const time = this.time() + seconds * this.pace;
    this.frame = time >= this.times[this.last] ? 0 : this.frameAt(time);
  }

  time() {
    const whole = Math.min(Math.floor(this.frame), this.last);
    const next = Math.min(whole + 1, this.last);
    return this.times[whole] + (this.frame - whole) * (this.times[next] - this.times[whole]);
  }

  frameAt(time) {
    let [low, high] = [0, this.last];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle;
      else high = middle;
    }
    return low + (time - this.times[low]) / (this.times[high] - this.times[low]);
  }
}
const matrix = new THREE.Matrix4();
const point = new THREE.Vector3();
const lifted = new THREE.Vector3();

// ---- stage: camera, light, drawing ------------------------------------------------------------------------------------

const GLIDE = 5.7; // a turn goes on after a drag, by a rate that falls so fast, in 1/s

function start() {
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
  const world = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
  camera.up.set(0, 0, 1);
  const sky = new THREE.HemisphereLight(0xffffff, 0x444444, 1.5);
  sky.position.set(0, 0, 1);
  const key = new THREE.DirectionalLight(0xffffff, 1.9);
  key.position.set(-0.6, 0.9, 0.8); // over the spectator's left shoulder, whichever way the surface turns
  const rim = new THREE.DirectionalLight(0xbfd4ff, 0.7);
  rim.position.set(0.9, -0.4, -0.3);
  camera.add(key, rim);
  world.add(camera, sky);

  const controls = new THREE.OrbitControls(camera, canvas);
  controls.enableDamping = true;
  controls.rotateSpeed = 0.8;

  const motions = [];
  const size = new THREE.Vector2();
  let current = 0;
  let playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  let speed = 1;
  let stale = true; // the picture differs from the state
  let framed = true; // the camera is still where `frameAll` put it
  const motion = () => motions[current];

  // -- camera

  /** How far away the eye must be in the direction it looks from, so that every point is in sight. */
  function neededDistance() {
    const turn = camera.quaternion.clone().invert();
    const tangent = Math.tan((camera.fov * Math.PI) / 360);
    let distance = 0;
    for (const array of motion().shapes) {
      for (let i = 0; i < array.length; i += 3) {
        point.fromArray(array, i).sub(controls.target).applyQuaternion(turn);
        distance = Math.max(distance, point.z + Math.max(Math.abs(point.x) / camera.aspect, Math.abs(point.y)) / tangent);
      }
    }
    return distance;
  }

  /** Of two directions, the one from which the scene fills the stage better: along y on a wide one, along x on a tall. */
  function frameAll() {
    const [low, high] = motion().corners;
    const { radius } = motion();
    controls.target.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2);
    let best = { distance: Infinity };
    for (const direction of [new THREE.Vector3(0.32, -1, 0.8), new THREE.Vector3(1, -0.32, 1.5)]) {
      camera.position.copy(controls.target).add(direction);
      camera.lookAt(controls.target);
      const distance = neededDistance();
      if (distance < best.distance) best = { distance, direction };
    }
    camera.position.copy(best.direction).setLength(1.1 * best.distance).add(controls.target);
    camera.near = 0.02 * radius;
    camera.far = 40 * radius;
    camera.updateProjectionMatrix();
    [controls.minDistance, controls.maxDistance] = [0.3 * radius, 12 * radius];
    controls.update();
    framed = true;
    stale = true;
  }

  function resize() {
    const { width, height } = element("stage").getBoundingClientRect();
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.setSize(Math.max(width, 1), Math.max(height, 1), false);
    renderer.getDrawingBufferSize(size);
    camera.aspect = Math.max(width, 1) / Math.max(height, 1);
    camera.updateProjectionMatrix();
    if (framed) frameAll();
    stale = true;
  }

  // -- drawing

  function draw() {
    const distance = camera.position.distanceTo(controls.target);
    const worldPerPixel = (2 * distance * Math.tan((camera.fov * Math.PI) / 360) * renderer.getPixelRatio()) / size.y;
    motion().place(camera.position, worldPerPixel, size, renderer.getPixelRatio());
    renderer.render(world, camera);
    stale = false;
  }

  const { slider, clock, play: button, icon, speed: select } = Object.fromEntries(
    ["slider", "clock", "play", "icon", "speed"].map((id) => [id, element(id)]),
  );

  function report() {
    const { frame, digits, last } = motion();
    const whole = Math.floor(frame);
    if (Number(slider.value) !== whole) slider.value = whole;
    const time = `t = ${motion().time().toFixed(digits)}`;
    if (slider.getAttribute("aria-valuetext") !== time) {
      slider.setAttribute("aria-valuetext", time);
      clock.innerHTML = `${time} <small>${whole} / ${last}</small>`;
    }
  }

  let before = performance.now();
  function tick(now) {
    const seconds = Math.min(Math.max((now - before) / 1000, 0), 0.25); // a page that slept doesn't jump
    before = now;
    if (playing) {
      motion().advance(seconds * speed);
      stale = true;
    }
    controls.dampingFactor = 1 - Math.exp(-GLIDE * seconds); // a turn runs out in the same time on slow and on fast displays
    if (controls.update()) stale = true;
    if (stale) {
      draw();
      report();
    }
    requestAnimationFrame(tick);
  }

  // -- controls

  function play(on) {
    playing = on;
    icon.setAttribute("d", on ? "M6 4h4v16H6zM14 4h4v16h-4z" : "M7 4l13 8-13 8z");
    button.setAttribute("aria-label", on ? "Pause" : "Play");
  }

  function seek(frame) {
    motion().frame = Math.min(Math.max(frame, 0), motion().last);
    stale = true;
  }

  function show(number) {
    const before = motions[current];
    motions[number] ??= new Motion(data.scenes[number]);
    const same = before && (before === motions[number] || (before.mesh !== null && before.mesh === motions[number].mesh));
    motions.forEach((other) => world.remove(...other.objects));
    current = number;
    world.add(...motion().objects);
    slider.max = motion().last;
    element("caption").textContent = motion().caption;
    canvas.setAttribute("aria-label", `${document.title}: ${motion().title}. ${motion().caption}`);
    [...element("tabs").children].forEach((tab, i) => {
      tab.setAttribute("aria-selected", i === number);
      tab.tabIndex = i === number ? 0 : -1;
    });
    resize(); // the caption may have changed its height
    if (!same) frameAll(); // on the same surface the view stays
    stale = true;
  }

  function theme() {
    const { sky: above, ground } = palette();
    sky.color.setHex(above);
    sky.groundColor.setHex(ground);
    motions.forEach((each) => each.paint());
    stale = true;
  }

  const tabs = element("tabs");
  tabs.hidden = data.scenes.length < 2;
  data.scenes.forEach(({ title }, number) => {
    const tab = document.createElement("button");
    tab.type = "button";
    tab.textContent = title;
    tab.setAttribute("role", "tab");
    tab.setAttribute("aria-controls", "stage");
    tab.addEventListener("click", () => show(number));
    tabs.append(tab);
  });
  tabs.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    show((current + step + data.scenes.length) % data.scenes.length);
    tabs.children[current].focus();
  });

  button.addEventListener("click", () => play(!playing));
  select.addEventListener("change", () => (speed = Number(select.value)));
  slider.addEventListener("input", () => seek(Number(slider.value)));
  element("reset").addEventListener("click", frameAll);
  controls.addEventListener("start", () => (framed = false));
  dark.addEventListener("change", theme);
  new ResizeObserver(resize).observe(element("stage"));

  addEventListener("keydown", (event) => {
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    const on = event.target.closest?.("button, select, input")?.tagName;
    const jump = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (event.key === " " && on !== "BUTTON" && on !== "SELECT") play(!playing);
    else if (jump && on !== "SELECT") {
      play(false);
      seek(Math.floor(motion().frame) + jump * (event.shiftKey ? 50 : 1));
    } else if (event.key === "Home" && on !== "SELECT") seek(0);
    else if (event.key === "End" && on !== "SELECT") seek(motion().last);
    else if (event.key === "r" && on !== "SELECT") frameAll();
    else return;
    event.preventDefault();
  });

  theme();
  show(0);
  play(playing);
  requestAnimationFrame(tick);

  // For tests and the console.
  window.rattle = {
    frame: () => Math.floor(motion().frame),
    frames: () => motion().frames,
    playing: () => playing,
    play: () => play(true),
    pause: () => play(false),
    seek,
    scene: () => current,
    show,
    draw,
  };
}

function webgl() {
  try {
    return document.createElement("canvas").getContext("webgl2") !== null;
  } catch {
    return false;
  }
}

if (webgl()) {
  start();
} else {
  canvas.hidden = element("reset").hidden = true;
  element("problem").hidden = false;
  element("problem").textContent =
    "This picture needs WebGL 2, which this browser does not offer. Another browser, or switching on hardware acceleration, helps.";
}
