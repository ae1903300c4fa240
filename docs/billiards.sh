#!/usr/bin/env sh
# Makes the README's picture, docs/billiards.png: the example's page as Chromium shows it. Run in the project's folder.
set -eu
cargo run --release --example billiards
"${CHROME:-chromium}" --headless --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --hide-scrollbars \
    --window-size=1280,720 --virtual-time-budget=8000 --screenshot=docs/billiards.png "file://$PWD/out/billiards/index.html"
