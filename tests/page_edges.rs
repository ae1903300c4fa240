//! The 3-D page where its numbers are at their ends, opened in headless Chromium.

use crate::page::browser::{self, Browser};
use crate::page::{ball, keep, opened, pixel};
use rattle::view::{Page, Scene3};
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
    for scene in 0..5 {
        page.evaluate(&format!("rattle.pause(); rattle.show({scene}); rattle.draw()"));
        let [left, right] = ["0", "1"].map(|body| pixel(&mut page, &format!("rattle.place({body})")));
        let apart = left.iter().zip(right).map(|(a, b)| a.abs_diff(b)).max();
        assert!(apart < Some(12) && left[3] > 200, "{scene}: {left:?} {right:?}"); // the light differs a little
    }
    keep(&mut page, "constant");
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
