#!/usr/bin/env sh
# Makes the guide a book: out/book/index.html. Installs mdBook first where there is none (a minute or two).
set -eu
cd "$(dirname "$0")"
command -v mdbook >/dev/null || cargo install mdbook --locked --no-default-features --features search
PATH="$PATH:${CARGO_HOME:-$HOME/.cargo}/bin" mdbook build
