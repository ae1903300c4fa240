// The page's own script is one module, joined of the files of this folder: data, bodies, motion, notes, charts, export,
// stage. three.js is the global THREE. A position on the time axis is a `frame`, a real number between two samples.

const element = (id) => document.getElementById(id);
const canvas = element("canvas");
const data = JSON.parse(element("data").textContent);

// ---- data: base64, little-endian ------------------------------------------------------------------------------------

function decode(text, Type) {
  return new Type(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);
}

/** Points are 16-bit fractions of a cube; here from the middle of a scene and in its unit, before they are f32. */
function decodePoints({ corner, size, points }, { middle, unit }) {
  const whole = decode(points, Uint16Array);
  return Float32Array.from(whole, (value, i) => (corner[i % 3] - middle[i % 3] + (size * value) / 65535) / unit);
}

// ---- colours --------------------------------------------------------------------------------------------------------

const dark = matchMedia("(prefers-color-scheme: dark)");
const palette = () =>
  dark.matches
    ? { surface: 0x6d7a90, sky: 0xffffff, ground: 0x20242e, rod: 0x9fabbd, light: 0.8, chroma: 0.15, ghost: 0.4,
        ink: "#e9edf3", soft: "#9aa5b4", line: "#3a4452", paper: "#161b23" }
    : { surface: 0xd9d3c7, sky: 0xffffff, ground: 0x8d8578, rod: 0x6b7482, light: 0.56, chroma: 0.19, ghost: 0.36,
        ink: "#1f2733", soft: "#5b6675", line: "#cfcbc1", paper: "#f5f3ee" };

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

const HUES = 30; // as many on one circle can be told apart

/** Up to HUES bodies on one circle of hues; many of them on rings of other lightness and strength, neighbours far apart. */
function hue(i, count) {
  const { light, chroma } = palette();
  if (count <= HUES) return oklch(light, chroma, 0.07 + i / count);
  const shade = (i % 5) / 4 - 0.5;
  const strength = 1 - 0.35 * (Math.floor(i / 5) % 2);
  return oklch(light + 0.3 * shade, chroma * strength, 0.07 + i * 0.6180339887);
}

/** Viridis (van der Walt & Smith 2015) at 0, 0.1 … 1, sRGB. */
const VIRIDIS = ["440154", "482576", "414487", "355f8d", "2a788e", "21918c", "22a884", "44bf70", "7ad151", "bddf26", "fde725"];
const viridis = VIRIDIS.map((text) => new THREE.Color(`#${text}`)); // linear inside

function viridisAt(part, into) {
  const place = Math.min(Math.max(part, 0), 1) * (viridis.length - 1);
  const below = Math.min(Math.floor(place), viridis.length - 2);
  return into.copy(viridis[below]).lerp(viridis[below + 1], place - below);
}

/** One notation for all numbers of a scale: in full with equally many decimals, or by powers of ten. */
function numbers(values, step) {
  const write = notation(Math.max(...values.map(Math.abs)), step);
  return values.map((value) => (Math.abs(value) < 1e-6 * step ? "0" : write(value)));
}

/** How numbers up to the largest are written, so that those a step apart differ. */
function notation(largest, step) {
  const digits = Math.max(Math.ceil(-Math.log10(step) - 1e-9), 0);
  const plain = largest === 0 || (largest < 1e6 && largest >= 1e-3 && digits <= 6);
  const exponent = plain ? 0 : Math.floor(Math.log10(largest) + 1e-12);
  const decimals = Math.min(plain ? digits : Math.max(Math.ceil(exponent - Math.log10(step) - 1e-9), 0), 15);
  const raised = String(exponent).replace(/./g, (c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c]));
  return (value) => {
    const text = (value / 10 ** exponent).toFixed(decimals).replace("-", "−");
    return plain ? text : `${text}·10${raised}`;
  };
}

/** Whether two numbers are one but for rounding: round numbers between them would not be distinct doubles. */
const constant = (low, high) => !(high - low > 1e-13 * Math.max(Math.abs(low), Math.abs(high)));

/** Round numbers in a range, at most so many steps: 1, 2 or 5 times a power of ten. */
function ticks(low, high, most) {
  if (constant(low, high)) return [];
  const wanted = (high - low) / most;
  const decade = 10 ** Math.floor(Math.log10(wanted));
  const step = [1, 2, 5, 10].map((n) => n * decade).find((size) => size >= wanted * (1 - 1e-9));
  const values = [];
  for (let i = Math.ceil(low / step - 1e-6); i <= Math.floor(high / step + 1e-6); i++) values.push(i * step);
  const labels = numbers(values, step);
  return values.map((value, i) => ({ value, label: labels[i] }));
}

