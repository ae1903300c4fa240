// ---- bodies, rods and trails: flat pieces that face the eye, shaped and shaded by the graphics processor --------------

// All positions lie in one texture, fixed places after them; sizes and colours that change with time in another. Vertex
// shaders read them at the current frame, so a frame costs the processor one number, however many bodies there are.
const TEXTURE_WIDTH = 2048;

function texture(texels, count) {
  const height = Math.max(Math.ceil(count / TEXTURE_WIDTH), 1);
  const full = new Float32Array(TEXTURE_WIDTH * height * 4);
  for (let i = 0; i < count; i++) full.set(texels(i), 4 * i);
  const made = new THREE.DataTexture(full, TEXTURE_WIDTH, height, THREE.RGBAFormat, THREE.FloatType);
  made.minFilter = made.magFilter = THREE.NearestFilter;
  made.needsUpdate = true;
  return made;
}

const reading = `
uniform highp sampler2D samples, each;
uniform float frame, frames, particles, eachFrames;
uniform vec3 periods; // of space, 0 where it has none
vec4 texel(highp sampler2D from, int i) {
  return texelFetch(from, ivec2(i % ${TEXTURE_WIDTH}, i / ${TEXTURE_WIDTH}), 0);
}
vec3 sampled(float body, float index) {
  return texel(samples, int(body) * int(frames) + int(clamp(index, 0.0, frames - 1.0))).xyz;
}
// How often a body has gone round space along the axes: counted in motion.js.
vec3 rounds(float body, float index) {
  float digits = texel(samples, int(body) * int(frames) + int(clamp(index, 0.0, frames - 1.0))).w;
  return mod(floor(digits / vec3(1.0, 256.0, 65536.0)), 256.0);
}
// The image of a place that is nearest to another.
vec3 nearest(vec3 place, vec3 to) {
  return place + periods * floor((to - place) / max(periods, vec3(1e-20)) + 0.5);
}
// Bodies glide between samples; what has a number beyond theirs is a fixed place.
vec3 placed(float body) {
  if (body >= particles) return texel(samples, int(particles) * int(frames) + int(body - particles)).xyz;
  float whole = floor(frame);
  vec3 here = sampled(body, whole);
  return mix(here, nearest(sampled(body, whole + 1.0), here), frame - whole);
}
// Colour's place on the scale, and size.
vec2 own(float body) {
  float whole = clamp(floor(frame), 0.0, max(eachFrames - 1.0, 0.0));
  int first = int(body) * int(eachFrames) + int(whole);
  vec2 next = whole + 1.0 < eachFrames ? texel(each, first + 1).xy : texel(each, first).xy;
  return mix(texel(each, first).xy, next, eachFrames > 1.5 ? frame - floor(frame) : 0.0);
}`;

const scaling = `
uniform vec3 scale[${VIRIDIS.length}];
vec3 onScale(float part) {
  float place = clamp(part, 0.0, 1.0) * ${VIRIDIS.length - 1}.0;
  int below = int(min(place, ${VIRIDIS.length - 2}.0));
  return mix(scale[below], scale[below + 1], place - float(below));
}`;

// The lights of `start`, for a normal as the eye sees it.
const shading = `
uniform vec3 ground;
vec3 lit(vec3 colour, vec3 normal, vec3 up) {
  vec3 key = normalize(vec3(-0.6, 0.9, 0.8)), rim = normalize(vec3(0.9, -0.4, -0.3));
  vec3 light = 0.58 * mix(ground, vec3(1.0), 0.5 + 0.5 * dot(normal, up));
  light += 0.8 * max(dot(normal, key), 0.0) + 0.22 * max(dot(normal, rim), 0.0) * vec3(0.75, 0.83, 1.0);
  float shine = pow(max(dot(normal, normalize(key + vec3(0.0, 0.0, 1.0))), 0.0), 40.0);
  return colour * light + 0.22 * shine;
}
float deep(vec3 point) { vec4 seen = eyeToScreen * vec4(point, 1.0); return 0.5 + 0.5 * seen.z / seen.w; }`;

const ballVertex = `
${reading}
${scaling}
uniform float size, smallest, lift, tinted, sized;
attribute vec3 corner; // left to right, bottom to top, body
attribute vec3 colour;
varying vec3 tint, middle, up;
varying vec2 across;
varying float radius;
void main() {
  vec2 mine = own(corner.z);
  middle = (modelViewMatrix * vec4(placed(corner.z), 1.0)).xyz;
  radius = max(sized > 0.5 ? mine.y : size, -middle.z * smallest);
  middle *= 1.0 - lift * radius / length(middle); // towards the eye, so that no head is half sunk in
  tint = tinted > 0.5 ? onScale(mine.x) : colour;
  up = (viewMatrix * vec4(0.0, 0.0, 1.0, 0.0)).xyz;
  across = 1.08 * corner.xy;
  gl_Position = projectionMatrix * vec4(middle + vec3(across * radius, 0.0), 1.0);
}`;

const ballFragment = `
uniform mat4 eyeToScreen;
uniform float strength;
${shading}
varying vec3 tint, middle, up;
varying vec2 across;
varying float radius;
void main() {
  float off = length(across), soft = fwidth(off);
  float edge = 1.0 - smoothstep(1.0 - soft, 1.0, off);
  if (edge <= 0.0) discard;
  vec3 normal = vec3(across, sqrt(max(1.0 - off * off, 0.0)));
  gl_FragDepth = deep(middle + radius * normal);
  gl_FragColor = vec4(lit(tint, normal, up), strength * edge);
  #include <colorspace_fragment>
}`;

const rodVertex = `
${reading}
uniform float rod, thinnest;
attribute vec4 corner; // from end to end, side −1 or 1, the two ends
varying vec3 place, across, toward, up;
varying float side, radius;
void main() {
  vec3 from = placed(corner.z);
  vec3 a = (modelViewMatrix * vec4(from, 1.0)).xyz;
  vec3 b = (modelViewMatrix * vec4(nearest(placed(corner.w), from), 1.0)).xyz;
  vec3 middle = mix(a, b, corner.x);
  vec3 along = b - a + vec3(0.0, 0.0, 1e-20);
  across = normalize(cross(along, -middle) + vec3(1e-30, 0.0, 0.0));
  toward = normalize(cross(across, along));
  if (dot(toward, middle) > 0.0) toward = -toward;
  radius = max(rod, -middle.z * thinnest);
  side = 1.15 * corner.y;
  place = middle + across * side * radius;
  up = (viewMatrix * vec4(0.0, 0.0, 1.0, 0.0)).xyz;
  gl_Position = projectionMatrix * vec4(place, 1.0);
}`;

const rodFragment = `
uniform mat4 eyeToScreen;
uniform float strength;
uniform vec3 paint;
${shading}
varying vec3 place, across, toward, up;
varying float side, radius;
void main() {
  float edge = 1.0 - smoothstep(1.0 - fwidth(side), 1.0, abs(side));
  if (edge <= 0.0) discard;
  float high = sqrt(max(1.0 - side * side, 0.0));
  gl_FragDepth = deep(place + toward * radius * high);
  gl_FragColor = vec4(lit(paint, normalize(across * side + toward * high), up), strength * edge);
  #include <colorspace_fragment>
}`;

const ribbonVertex = `
${reading}
${scaling}
uniform float trail, width, thin, lift, tinted;
uniform vec2 pixels;
attribute vec3 corner; // age in samples, side −1 or 1, body
attribute vec3 colour;
varying vec3 hue;
varying float fade, side;
// The head glides between samples; the older points are the samples themselves.
vec3 aged(float age) {
  if (age <= 0.0) return placed(corner.z);
  float now = floor(frame), then = now + 1.0 - age;
  vec3 since = rounds(corner.z, now) - rounds(corner.z, then);
  return sampled(corner.z, then) - periods * (mod(since + 128.0, 256.0) - 128.0);
}
vec4 seen(vec3 point) {
  vec4 view = modelViewMatrix * vec4(point, 1.0);
  view.xyz *= 1.0 - lift / length(view.xyz); // towards the eye: off the surface, same place on the screen
  return projectionMatrix * view;
}
void main() {
  vec4 here = seen(aged(corner.x));
  vec4 ahead = seen(aged(max(corner.x - 1.0, 0.0)));
  vec4 behind = seen(aged(min(corner.x + 1.0, trail)));
  vec2 along = (ahead.xy / ahead.w - behind.xy / behind.w) * pixels;
  float size = length(along);
  vec2 across = size > 1e-6 ? vec2(-along.y, along.x) / size : vec2(0.0);

  float age = corner.x <= 0.0 ? 0.0 : frame - floor(frame) + corner.x - 1.0;
  fade = max(1.0 - age / trail, 0.0);
  side = corner.y;
  hue = tinted > 0.5 ? onScale(own(corner.z).x) : colour;
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

/** Strips of quads: `lengths` of them in a row for each of `count` things; `corner(thing, place, side)` for each vertex. */
function strips(count, length, width, corner) {
  const corners = new Float32Array(count * (length + 1) * 2 * width);
  const index = new Uint32Array(count * length * 6);
  for (let thing = 0, vertex = 0, at = 0; thing < count; thing++) {
    for (let place = 0; place <= length; place++, vertex += 2) {
      corners.set(corner(thing, place, -1), width * vertex);
      corners.set(corner(thing, place, 1), width * (vertex + 1));
      if (place === length) continue;
      index.set([vertex, vertex + 1, vertex + 2, vertex + 1, vertex + 3, vertex + 2], at);
      at += 6;
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array((corners.length / width) * 3), 3)); // three.js counts vertices by it
  geometry.setAttribute("corner", new THREE.BufferAttribute(corners, width));
  geometry.setIndex(new THREE.BufferAttribute(index, 1));
  return geometry;
}

function withColours(geometry) {
  const count = geometry.attributes.position.count;
  geometry.setAttribute("colour", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
  return geometry;
}

