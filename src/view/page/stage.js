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

  const notes = new Notes(element("notes"));
  let charts = [];
  let filming = null;
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
    const { outline } = motion();
    for (let i = 0; i < outline.length; i += 3) {
      point.fromArray(outline, i).sub(controls.target).applyQuaternion(turn);
      distance = Math.max(distance, point.z + Math.max(Math.abs(point.x) / camera.aspect, Math.abs(point.y)) / tangent);
    }
    return distance;
  }

  /** What lies in a plane is seen from its front. */
  function directions() {
    const [low, high] = motion().corners;
    const flat = [0, 1, 2].findIndex((i) => high[i] - low[i] < 0.12 * motion().radius);
    if (flat === 1) return [new THREE.Vector3(0, -1, 0.05)];
    if (flat === 2) return [new THREE.Vector3(0, -0.05, 1)];
    return [new THREE.Vector3(0.32, -1, 0.8), new THREE.Vector3(1, -0.32, 1.5)];
  }

  /** Of two directions, the one from which the scene fills the stage better: along y on a wide one, along x on a tall. */
  function frameAll() {
    const [low, high] = motion().corners;
    const { radius } = motion();
    controls.target.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2);
    let best = { distance: Infinity };
    for (const direction of directions()) {
      camera.position.copy(controls.target).add(direction);
      camera.lookAt(controls.target);
      const distance = neededDistance();
      if (distance < best.distance) best = { distance, direction };
    }
    const room = motion().axes ? 1.3 : 1.1;
    camera.position.copy(best.direction).setLength(room * best.distance).add(controls.target);
    camera.near = 0.02 * radius;
    camera.far = 40 * radius;
    camera.updateProjectionMatrix();
    [controls.minDistance, controls.maxDistance] = [0.3 * radius, 12 * radius];
    controls.update();
    framed = true;
    stale = true;
  }

  /** Draws at once: a canvas that changes its size is empty until someone does. */
  function resize() {
    const { width, height } = element("stage").getBoundingClientRect();
    const ratio = Math.min(devicePixelRatio, 2);
    renderer.setPixelRatio(ratio);
    notes.resize(width, height, ratio);
    charts.forEach((chart) => chart.resize(ratio));
    renderer.setSize(Math.max(width, 1), Math.max(height, 1), false);
    renderer.getDrawingBufferSize(size);
    camera.aspect = Math.max(width, 1) / Math.max(height, 1);
    camera.updateProjectionMatrix();
    if (framed) frameAll();
    draw();
  }

  // -- drawing

  function draw() {
    const worldPerPixel = (2 * Math.tan((camera.fov * Math.PI) / 360) * renderer.getPixelRatio()) / size.y;
    motion().place(camera, worldPerPixel, size, renderer.getPixelRatio());
    renderer.render(world, camera);
    notes.draw(motion(), camera);
    charts.forEach((chart) => chart.draw());
    stale = false;
  }

  const { slider, clock, play: button, icon, speed: select } = Object.fromEntries(
    ["slider", "clock", "play", "icon", "speed"].map((id) => [id, element(id)]),
  );

  function report() {
    const { frame, last } = motion();
    const whole = Math.floor(frame);
    if (Number(slider.value) !== whole) slider.value = whole;
    const time = `t = ${motion().clock()}`;
    if (slider.getAttribute("aria-valuetext") !== time) {
      slider.setAttribute("aria-valuetext", time);
      clock.innerHTML = `${time} <small>${whole} / ${last}</small>`;
    }
  }

  let before = performance.now();
  function tick(now) {
    const seconds = Math.min(Math.max((now - before) / 1000, 0), 0.25); // a page that slept doesn't jump
    before = now;
    if (playing && !filming) {
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
    const same = before && (before === motions[number] || (before.meshes.length && `${before.meshes}` === `${motions[number].meshes}`));
    motions.forEach((other) => world.remove(...other.objects));
    current = number;
    world.add(...motion().objects);
    notes.pointed = null;
    showCharts();
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

  function showCharts() {
    const pages = motion().charts.map(() => document.createElement("canvas"));
    element("charts").replaceChildren(...pages);
    element("charts").hidden = pages.length === 0;
    charts = pages.map((page, i) => new Chart(page, motion(), i));
    charts.forEach((chart) => (chart.seek = (time) => seek(motion().frameAt(time))));
  }

  /** The picture of now. */
  function picture() {
    draw();
    report();
    return compose([canvas, notes.page], charts, document.title, clock.firstChild.textContent);
  }

  /**
   * All pictures at equal distances of time, in an archive, or in several where one has no room for all; a second press
   * on the button ends it, with nothing kept.
   */
  async function film(mostFiles = MOST_FILES) {
    if (filming) return (filming.ended = true) && [];
    const mine = (filming = { ended: false });
    const { frame, times, last, pace } = motion();
    const archives = [];
    let archive = new Archive();
    const count = Math.max(Math.round((times[last] / pace / speed) * FILM_RATE), 1);
    const words = element("film").textContent;
    for (let i = 0; i <= count && !mine.ended; i++) {
      seek(motion().frameAt((times[last] * i) / count));
      const png = await toPng(picture());
      const bytes = new Uint8Array(await png.arrayBuffer());
      if (!archive.hasRoom(bytes, mostFiles)) {
        archives.push(archive.finish());
        archive = new Archive();
      }
      archive.add(`frame-${String(i).padStart(Math.max(String(count).length, 5), "0")}.png`, bytes);
      element("film").textContent = `${Math.floor((100 * i) / count)} %`;
    }
    element("film").textContent = words;
    seek(frame);
    filming = null;
    return mine.ended ? [] : [...archives, archive.finish()];
  }

  function theme() {
    const { sky: above, ground } = palette();
    sky.color.setHex(above);
    sky.groundColor.setHex(ground);
    motions.forEach((each) => each.paint());
    charts.forEach((chart) => chart.resize(renderer.getPixelRatio()));
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
  element("photo").addEventListener("click", async () => download(await toPng(picture()), `${fileName()}.png`));
  element("film").addEventListener("click", async () => {
    const archives = await film();
    archives.forEach((archive, i) => download(archive, `${fileName()}${archives.length > 1 ? `-${i + 1}` : ""}.zip`));
  });
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons) return;
    const found = notes.nearest(motion(), camera, event.offsetX, event.offsetY);
    if (found !== notes.pointed) [notes.pointed, stale] = [found, true];
  });
  canvas.addEventListener("pointerleave", () => {
    if (notes.pointed !== null) [notes.pointed, stale] = [null, true];
  });
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
    picture,
    film,
    pointed: () => notes.pointed,
    place: (body) => notes.seen(motion().at(body, point), camera),
    cursors: () => charts.map(({ cursor, left, width }) => (cursor - left) / (width - left - EDGE.right)),
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
  canvas.hidden = element("tools").hidden = true;
  element("problem").hidden = false;
  element("problem").textContent =
    "This picture needs WebGL 2, which this browser does not offer. Another browser, or switching on hardware acceleration, helps.";
}
