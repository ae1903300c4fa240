#!/usr/bin/env bash
# Makes three.min.js, byte for byte: three.js as far as the page uses it, in one file without imports.
# Needs node and npm. With --check it changes nothing and says whether the committed file is what it makes.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
three=0.187.0
esbuild=0.28.2

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init --yes >/dev/null
npm install --silent --no-audit --no-fund --save-exact "three@$three" "esbuild@$esbuild"

cat >entry.js <<'JS'
export {
  BufferAttribute, BufferGeometry, Color, DataTexture, DirectionalLight, DoubleSide, FloatType, FrontSide,
  GreaterDepth, HemisphereLight, InstancedMesh, Matrix4, Mesh, MeshStandardMaterial, NearestFilter, PerspectiveCamera, RGBAFormat,
  Scene, ShaderMaterial, SphereGeometry, Vector2, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
JS

{
  printf '/*!\nthree.js %s, https://threejs.org\n\n' "$three"
  cat node_modules/three/LICENSE
  printf '*/\n'
} >banner.txt
npx esbuild entry.js --bundle --minify --format=iife --global-name=THREE --target=es2022 \
  --legal-comments=none --log-level=warning --outfile=body.js
# A page's script ends at the first "</script", wherever it stands; in JavaScript the backslash changes nothing.
cat banner.txt body.js | sed 's#</script#<\\/script#g; s#<!--#<\\!--#g' >three.min.js

if [ "${1:-}" = --check ]; then
  cmp three.min.js "$here/three.min.js"
  cmp node_modules/three/LICENSE "$here/LICENSE-three.txt"
  echo "three.min.js is what bundle.sh makes"
else
  cp three.min.js "$here/three.min.js"
  cp node_modules/three/LICENSE "$here/LICENSE-three.txt"
  ls -l "$here/three.min.js"
fi
