#!/usr/bin/env sh
# Makes a book of the project's pages: out/book/index.html. Installs mdBook first where there is none (some minutes).
# A copy with the pages alone is the book's source, since mdBook follows no link out of its source.
set -eu
cd "$(dirname "$0")/.."
PATH="$PATH:${CARGO_HOME:-$HOME/.cargo}/bin"
command -v mdbook >/dev/null || cargo install mdbook --locked --no-default-features --features search

rm -rf out/book out/book-source
mkdir -p out/book-source/docs/guide out/book-source/benches/peers
cp ./*.md CITATION.cff LICENSE-* out/book-source
cp docs/*.md docs/*.png docs/*.svg out/book-source/docs
cp docs/guide/*.md out/book-source/docs/guide
cp benches/peers/README.md benches/peers/results.json out/book-source/benches/peers
cp -r docs/accuracy out/book-source/docs
cp -r docs/gallery docs/accuracy out/book-source/docs
{
    printf '# Summary\n\n[rattle](README.md)\n'
    sed '1d; s#](#](docs/#' docs/SUMMARY.md
    echo '- [Architecture](ARCHITECTURE.md)'
    echo '- [Contributing](CONTRIBUTING.md)'
    echo '- [Security](SECURITY.md)'
    echo '- [What others were asked](benches/peers/README.md)'
    echo
    echo '---'
    echo
    echo '[Changelog](CHANGELOG.md)'
} > out/book-source/SUMMARY.md
cp docs/book.toml out/book-source
mdbook build out/book-source
# mdBook calls README.md index.html, and links to it README.html.
for folder in . docs/guide benches/peers; do cp "out/book/$folder/index.html" "out/book/$folder/README.html"; done
