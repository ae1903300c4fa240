//! The 3-D page where its numbers are at their ends, opened in headless Chromium.

use crate::page::browser::{self, Browser};
use crate::page::{ball, changed, colourful, dot, keep, opened, pixel, settled};
use rattle::view::{Mesh, Page, Scene3};
use serde_json::json;

/// Whether something is drawn so far to the right of a body, as high as the first one: `own` is that, and `low` and
/// `high` are two that stand at −1 and 2.
fn drawn(page: &mut Browser, from: &str, off: f64) -> bool {
    let place = format!("[{from}[0] + {off} / 3 * (high[0] - low[0]), own[1]]");
    pixel(page, &format!("((own, low, high) => {place})(...[0, 1, 2].map(rattle.place))"))[3] > 40
}

/// A trail that goes round space, of more than half a period, lies behind its body and is no longer than it is.
#[test]
fn trails_go_round_space() {
    let Some(chromium) = browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("round.html");
    let times: Vec<f64> = (0..=30).map(f64::from).collect();
    // Rightwards, round once every ten samples; two that stand show where x is −1 and 2.
    let round: Vec<_> = times.iter().map(|t| [(0.1 * t + 0.05) % 1.0, 0.0, 0.0]).collect();
    let stands = |x: f64| vec![[x, 0.0, 0.2]; times.len()];
    let scene =
        Scene3::new("round").bodies(&times, &[round, stands(-1.0), stands(2.0)]).periods([1.0, 0.0, 0.0]);
    // A ball that is as far from one image of its next place as from another goes one way, and its trail with it.
    let halves: Vec<_> = times.iter().map(|t| [0.5 * (t % 2.0), 0.0, 0.0]).collect();
    let half =
        Scene3::new("half").bodies(&times, &[halves, stands(-1.0), stands(2.0)]).periods([1.0, 0.0, 0.0]);
    Page::new("Round").scene(scene.trail(9)).scene(half.trail(2)).write(&file).unwrap();
    let mut page = opened(&chromium, &file, [1120, 720]);
    for (frame, head) in [(29, 0.95), (23, 0.35), (22, 0.25)] {
        page.evaluate(&format!("rattle.pause(); rattle.seek({frame}); rattle.draw()"));
        keep(&mut page, &format!("round-{frame}"));
        let along: Vec<bool> =
            (-18..40).map(|i| drawn(&mut page, "low", 1.025 + 0.05 * f64::from(i))).collect();
        let seen: Vec<f64> = (-18..40)
            .zip(along)
            .filter(|(_, drawn)| *drawn)
            .map(|(i, _)| 0.05 * f64::from(i) + 0.025)
            .collect();
        let ends = [seen[0], seen[seen.len() - 1]];
        // Samples at 0.1 each; the last fade out.
        assert!(ends[1] < head + 0.06 && ends[0] > head - 0.95 && ends[0] < head - 0.6, "{frame}: {seen:?}");
        assert!(seen.len() as f64 > (ends[1] - ends[0]) / 0.05 - 1.0, "{frame}: {seen:?} has gaps");
    }
    for frame in [10, 11] {
        let mut x = |frame: f64| {
            page.evaluate(&format!("rattle.show(1); rattle.pause(); rattle.seek({frame}); rattle.draw()"));
            page.evaluate("rattle.place(0)[0]").as_f64().unwrap()
        };
        let rightwards = x(f64::from(frame) - 0.5) > x(f64::from(frame) - 1.0);
        x(f64::from(frame));
        keep(&mut page, &format!("half-{frame}"));
        let beside = [-0.25, 0.25].map(|off| drawn(&mut page, "own", off));
        assert_eq!(beside, [rightwards, !rightwards], "{frame}");
    }
    assert_eq!(page.complaints, Vec::<String>::new());
}

/// From now on the page keeps in `written` what texts are drawn: their words, and where.
fn written(page: &mut Browser) {
    page.evaluate(
        "window.written = []; const pens = CanvasRenderingContext2D.prototype, write = pens.fillText; \
         pens.fillText = function (...text) { written.push(text); return write.apply(this, text) }; 0",
    );
}

/// Colours of what is constant but for rounding, which no scale can show: the page draws, and says the number.
#[test]
fn a_constant_has_one_colour() {
    let Some(chromium) = browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("constant.html");
    let ulps = |x: f64, n: u64| f64::from_bits(x.to_bits() + n);
    let mut page = Page::new("Constant");
    for (number, off) in [(0.5, 1), (1.0, 1), (0.98, 3), (123.4, 2), (0.98, 0)] {
        let mesh = ball(0.8);
        let values = (0..mesh.vertices.len()).map(|i| ulps(number, if i % 2 == 0 { off } else { 0 }));
        let bodies = [vec![[1.0, 0.0, 0.0]; 2], vec![[-1.0, 0.0, 0.0]; 2]];
        let scene = Scene3::new("one").surface(&mesh).heat("curvature", values).bodies(&[0.0, 1.0], &bodies);
        page = page.scene(scene.coloured_by("energy", &[[number], [ulps(number, off)]]));
    }
    page.write(&file).unwrap();
    let mut page = opened(&chromium, &file, [1120, 720]);
    written(&mut page);
    let mut surfaces = Vec::new();
    for (scene, number) in ["0.5", "1", "0.98", "123.4", "0.98"].into_iter().enumerate() {
        page.evaluate(&format!("rattle.pause(); rattle.show({scene}); written.length = 0; rattle.draw()"));
        // On the scale of the surface and on that of the bodies.
        let told = page.evaluate("written.map(([text]) => text)");
        let numbers = told.as_array().unwrap().iter().filter(|text| **text == number).count();
        assert_eq!(numbers, 2, "{scene}: {told}");
        // In the middle of the ball, and cells of it beside.
        surfaces.push([0.0, 0.1, -0.1, 0.23, -0.37].map(|off| {
            let place = format!("((a, b) => [0, 1].map((i) => (a[i] + b[i] + {off} * (a[0] - b[0])) / 2))");
            pixel(&mut page, &format!("{place}(rattle.place(0), rattle.place(1))"))
        }));
        let [left, right] = ["0", "1"].map(|body| pixel(&mut page, &format!("rattle.place({body})")));
        let apart = left.iter().zip(right).map(|(a, b)| a.abs_diff(b)).max();
        assert!(apart < Some(12) && left[3] > 200, "{scene}: {left:?} {right:?}"); // the light differs a little
    }
    // In the last scene all numbers are the same to the bit.
    for (scene, surface) in surfaces.iter().enumerate() {
        assert!(
            surface == &surfaces[4] && surface.iter().all(|pixel| pixel[3] == 255),
            "{scene}: {surfaces:?}"
        );
    }
    keep(&mut page, "constant");
    assert_eq!(page.complaints, Vec::<String>::new());
}

/// A ball with a path around it, rods, a disc, a wall, a box and radii, so far away and so large.
fn model(title: &str, away: [f64; 3], size: f64) -> Scene3 {
    let place = |q: [f64; 3]| [0, 1, 2].map(|i| away[i] + size * q[i]);
    let g = |q: [f64; 3]| {
        let d = [0, 1, 2].map(|i| q[i] - away[i]);
        (dot(d, d) - 0.25 * size * size, d.map(|x| 2.0 * x))
    };
    let mesh = Mesh::of(g, place([-0.6; 3]), place([0.6; 3]), 24).unwrap();
    let times: Vec<f64> = (0..=20).map(|i| 0.1 * f64::from(i)).collect();
    let turn = |t: f64, r: f64| place([r * t.cos(), r * t.sin(), 0.1]);
    let paths = [0.5, 1.0].map(|r| times.iter().map(|t| turn(*t, r)).collect::<Vec<_>>());
    Scene3::new(title)
        .surface(&mesh)
        .bodies(&times, &paths)
        .trail(10)
        .sizes(&[vec![0.03 * size], vec![0.06 * size]])
        .rods([(0, 1)])
        .rods([(1, place([0.0, 0.0, 1.0]))])
        .disc(place([-0.9, 0.2, 0.0]), [0.0, 1.0, 0.3], 0.3 * size)
        .wall(place([-1.2, 0.6, -0.7]), [[2.4 * size, 0.0, 0.0], [0.0, 0.0, 1.8 * size]])
        .turning_box(
            [0.2, 0.3, 0.4].map(|x| x * size),
            &[place([0.8, 0.0, -0.5])],
            &[[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]],
        )
        .axes(["x", "y", "z"])
}

/// A graphics processor knows f32 alone, which is 0.5 at 5·10⁶, and 0 for squares of 1e-23: a scene far from the
/// origin, a tiny and a huge one look as they do at the origin.
#[test]
fn scenes_of_any_place_and_size_look_alike() {
    let Some(chromium) = browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("places.html");
    let scenes = [("near", 0.0, 1.0), ("far", 5e6, 1.0), ("tiny", 0.0, 1e-12), ("huge", 1e13, 1e12)];
    let page = Page::new("Places");
    let page =
        scenes.iter().fold(page, |page, (title, x, size)| page.scene(model(title, [*x, *x, -*x], *size)));
    page.write(&file).unwrap();
    let mut page = opened(&chromium, &file, [800, 600]);
    page.evaluate("rattle.pause()");
    // Numbers on the axes are others.
    page.evaluate("document.getElementById('notes').style.display = 'none'");
    // Both bodies, and the middles of both rods.
    let middle = |a, b| {
        format!("((a, b) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2])(rattle.place({a}), rattle.place({b}))")
    };
    let small =
        [0, 1].map(|body| format!("rattle.place({body})")).into_iter().chain([middle(0, 1), middle(1, 2)]);
    let small: Vec<String> = small.collect();
    let pictures: Vec<_> = (0..scenes.len())
        .map(|scene| {
            page.evaluate(&format!(
                "rattle.show({scene}); document.getElementById('reset').click(); rattle.seek(7)"
            ));
            let picture = settled(&mut page);
            keep(&mut page, scenes[scene].0);
            (picture, small.iter().map(|place| pixel(&mut page, place)).collect::<Vec<_>>())
        })
        .collect();
    let (near, parts) = &pictures[0];
    assert!(colourful(near) > 0.0005, "{}", colourful(near));
    for ((title, ..), (picture, own)) in scenes.iter().zip(&pictures) {
        let off = changed(near, picture);
        // None does where it is drawn as it is tested; others may round edges otherwise.
        assert!(off < 0.001, "{title}: {off} of the picture differs");
        // Bodies, trails and rods are a small part of the picture.
        let strong = colourful(picture) / colourful(near);
        assert!((strong - 1.0).abs() < 0.1, "{title}: {strong} of the strong colours");
        for (i, (one, other)) in parts.iter().zip(own).enumerate() {
            let apart = one.iter().zip(other).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(apart < Some(12), "{title}: {one:?} and {other:?} at {}", small[i]);
        }
    }
    assert_eq!(page.complaints, Vec::<String>::new());
}

/// Late in a long run the page plays as it does early: the clock and a chart tell the time of the run.
#[test]
fn late_times_are_told_in_full() {
    let Some(chromium) = browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("late.html");
    let times: Vec<f64> = (0..=40).map(|k| 1e6 + 0.05 * f64::from(k)).collect();
    let path: Vec<_> = (0..=40).map(|k| [0.1 * f64::from(k), 0.0, 0.0]).collect();
    let heights: Vec<f64> = (0..=40).map(|k| (0.2 * f64::from(k)).sin()).collect();
    let scene = Scene3::new("late").bodies(&times, &[path]).trail(20).chart("height", [("z", heights)]);
    Page::new("Late").scene(scene).write(&file).unwrap();
    let mut page = opened(&chromium, &file, [1120, 720]);
    for (frame, clock) in [(0, "1.00000000·10⁶"), (10, "1.00000050·10⁶"), (40, "1.00000200·10⁶")] {
        page.evaluate(&format!("rattle.pause(); rattle.seek({frame}); rattle.picture()"));
        assert_eq!(page.evaluate("clock.firstChild.textContent.trim()"), json!(format!("t = {clock}")));
        let cursor = page.evaluate("rattle.cursors()[0]").as_f64().unwrap();
        assert!((cursor - f64::from(frame) / 40.0).abs() < 1e-3, "{cursor}");
    }
    page.evaluate("rattle.seek(15); rattle.draw()");
    keep(&mut page, "late");
    // The chart is drawn anew where it has another size.
    written(&mut page);
    page.resize(1100, 720, false);
    page.wait("written.some(([text]) => text === 'height')");
    let words = page.evaluate("written");
    let at = |word: &str| {
        let found = words.as_array().unwrap().iter().find(|text| text[0] == word);
        found.unwrap_or_else(|| panic!("no {word} in {words}"))[1].as_f64().unwrap()
    };
    // The chart begins at the first time; the name of its curve ends where the chart does, at the last.
    let [first, middle, last] = ["1.000000·10⁶", "1.000001·10⁶", "z"].map(at);
    assert!(((middle - first) / (last - first) - 0.5).abs() < 1e-6, "{words}");
    at("1.000002·10⁶");
    page.evaluate("rattle.seek(0); rattle.play()");
    page.wait("rattle.playing() && rattle.frame() > 0 && rattle.frame() < 40");
    assert_eq!(page.complaints, Vec::<String>::new());
}

/// A film that one archive has no room for is several.
#[test]
fn long_films_are_several_archives() {
    let Some(chromium) = browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("long.html");
    let scene = Scene3::new("long").bodies(&[0.0, 1.0], &[[[0.0; 3], [1.0, 0.0, 0.0]]]).seconds(0.4);
    Page::new("Long").scene(scene).write(&file).unwrap();
    let mut page = opened(&chromium, &file, [400, 300]);
    page.evaluate("rattle.pause(); rattle.film(4).then(async (parts) => { window.parts = await Promise.all(parts.map(async (part) => \
                   { const bytes = new DataView(await part.arrayBuffer()); return bytes.getUint16(bytes.byteLength - 12, true) })) })");
    page.wait("window.parts !== undefined");
    assert_eq!(page.evaluate("window.parts"), json!([4, 4, 3]));
    assert_eq!(page.complaints, Vec::<String>::new());
}
