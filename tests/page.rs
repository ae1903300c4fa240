//! The 3-D page, opened in headless Chromium: it draws, plays, pauses, seeks, turns, and complains of nothing.

pub(crate) mod browser;

use browser::Browser;
use rattle::view::{Mesh, Page, Scene3};
use serde_json::json;
use std::path::Path;
use std::time::{Duration, Instant};
use std::{fs, thread};

/// The lemniscate's tube of genus two, a = 1 and r = 1/6.
fn tube([x, y, z]: [f64; 3]) -> (f64, [f64; 3]) {
    let s = x * x + y * y;
    let f = s * s - (x * x - y * y);
    let gradient = [2.0 * f * (4.0 * s * x - 2.0 * x), 2.0 * f * (4.0 * s * y + 2.0 * y), 2.0 * z];
    (f * f + z * z - 1.0 / 36.0, gradient)
}

/// Curves on the tube that look like motion: straight steps, pulled back by Newton's method. No physics.
fn curve(start: [f64; 3], angle: f64, steps: usize) -> Vec<[f64; 3]> {
    let (mut q, mut v) = (start, [angle.cos(), angle.sin(), 0.0]);
    let mut path = vec![q];
    for _ in 0..steps {
        let before = q;
        q = [0, 1, 2].map(|i| q[i] + 0.01 * v[i]);
        for _ in 0..8 {
            let (g, n) = tube(q);
            let step = g / dot(n, n);
            q = [0, 1, 2].map(|i| q[i] - step * n[i]);
        }
        let (_, n) = tube(q);
        let moved = [0, 1, 2].map(|i| q[i] - before[i]);
        let off = dot(moved, n) / dot(n, n);
        let along = [0, 1, 2].map(|i| moved[i] - off * n[i]);
        v = along.map(|component| component / dot(along, along).sqrt());
        path.push(q);
    }
    path
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn billiards() -> Page {
    let steps = 2000;
    let times: Vec<f64> = (0..=steps).map(|i| 0.01 * i as f64).collect();
    let top = [0.0, 0.0, 1.0 / 6.0];
    let fan: Vec<_> =
        (0..25).map(|k| curve(top, std::f64::consts::TAU * f64::from(k) / 24.0, steps)).collect();
    let crowd: Vec<_> = (0..21).map(|k| curve(fan[3][100 * k], 0.3 * k as f64, steps)).collect();
    let mesh = Mesh::of(tube, [-1.2, -0.6, -0.3], [1.2, 0.6, 0.3], 112).unwrap();
    let fan = Scene3::new("25 trajectories")
        .surface(&mesh)
        .bodies(&times, &fan)
        .trail(100)
        .caption("From the middle of the saddle in 25 directions. </script> & <b>not bold</b>");
    let crowd =
        Scene3::new("Gas of 21").surface(&mesh).bodies(&times, &crowd).trail(50).caption("Each on its own.");
    Page::new("Billiards on a surface of <genus> two & more").scene(fan).scene(crowd)
}

/// A page in a window of this width and height, once its script has run.
pub(crate) fn opened(chromium: &Path, file: &Path, [width, height]: [u32; 2]) -> Browser {
    let mut page = Browser::start(chromium, &[]);
    page.resize(width, height, false);
    page.open(file);
    page.wait("window.rattle !== undefined");
    page
}

/// `RATTLE_PICTURES=folder` keeps screenshots, to be looked at.
pub(crate) fn keep(page: &mut Browser, name: &str) {
    if let Some(folder) = std::env::var_os("RATTLE_PICTURES") {
        fs::create_dir_all(&folder).unwrap();
        fs::write(Path::new(&folder).join(format!("{name}.png")), page.screenshot(None)).unwrap();
    }
}

/// Red, green and blue of the stage, at half its size.
fn stage(page: &mut Browser) -> Vec<[u8; 3]> {
    let png = page.screenshot(Some(("#canvas", 0.5)));
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut buffer = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut buffer).unwrap();
    let samples = info.color_type.samples();
    buffer.chunks(info.line_size).flat_map(|row| row.chunks(samples).map(|p| [p[0], p[1], p[2]])).collect()
}

pub(crate) fn distance(a: [u8; 3], b: [u8; 3]) -> u32 {
    a.iter().zip(b).map(|(&a, b)| u32::from(a.abs_diff(b))).max().unwrap()
}

/// Part of the pixels that differ visibly.
pub(crate) fn changed(a: &[[u8; 3]], b: &[[u8; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|&(&a, &b)| distance(a, b) > 12).count() as f64 / a.len() as f64
}

/// Part of the pixels with a strong colour: particles and trails; surface and ground are nearly grey.
pub(crate) fn colourful(pixels: &[[u8; 3]]) -> f64 {
    let strong = |pixel: &&[u8; 3]| pixel.iter().max().unwrap() - pixel.iter().min().unwrap() > 70;
    pixels.iter().filter(strong).count() as f64 / pixels.len() as f64
}

#[test]
fn a_browser_plays_the_page() {
    let Some(chromium) = browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("billiards.html");
    billiards().write(&file).unwrap();
    let bytes = fs::metadata(&file).unwrap().len();
    assert!(bytes < 2_000_000, "the page has {bytes} bytes");

    let mut page = Browser::start(&chromium, &[]);
    page.resize(1120, 720, false);
    page.open(&file);
    page.wait("window.rattle !== undefined && rattle.frame() > 0");
    assert_eq!(page.evaluate("rattle.playing()"), true, "the page starts by playing");
    assert_eq!(page.evaluate("document.querySelectorAll('b').length"), 0, "a caption became markup");
    assert_eq!(page.evaluate("document.title"), "Billiards on a surface of <genus> two & more");

    // Playing follows the clock: 2000 samples take 30 s at speed 1, so 100 of them 1.5 s. A busy machine may be late,
    // but none may be early (by more than the quarter of a second that one slow picture before the seek may count).
    let start = Instant::now();
    page.evaluate("rattle.seek(0)");
    page.wait("rattle.frame() >= 100 && rattle.frame() < 1900");
    assert!(start.elapsed() > Duration::from_millis(1200), "100 frames in {:?}", start.elapsed());

    // Pausing by the button holds the frame and the picture.
    page.click("#play");
    page.evaluate("rattle.seek(700)");
    let held = settled(&mut page);
    thread::sleep(Duration::from_millis(300));
    assert_eq!(page.evaluate("[rattle.playing(), rattle.frame()]"), json!([false, 700]));
    assert_eq!(changed(&held, &stage(&mut page)), 0.0, "the picture moves while paused");
    keep(&mut page, "frame-700");

    // Coloured trails and heads are there.
    assert!(colourful(&held) > 0.005, "{} of the stage is in strong colours", colourful(&held));

    // The slider, the keys and the read-out.
    page.evaluate("slider.value = 1500; slider.dispatchEvent(new Event('input'))");
    assert_eq!(page.evaluate("rattle.frame()"), 1500);
    let later = settled(&mut page);
    assert!(changed(&held, &later) > 0.005, "frames 700 and 1500 look the same");
    assert_eq!(page.evaluate("clock.textContent"), "t = 15.00 1500 / 2000");
    keep(&mut page, "frame-1500");
    page.key("ArrowRight", "ArrowRight", 39);
    assert_eq!(page.evaluate("rattle.frame()"), 1501);
    page.key("Home", "Home", 36);
    assert_eq!(page.evaluate("rattle.frame()"), 0);
    page.key(" ", "Space", 32);
    page.wait("rattle.playing() && rattle.frame() > 0");
    page.evaluate("document.getElementById('play').focus()");
    page.key(" ", "Space", 32);
    assert_eq!(page.evaluate("rattle.playing()"), false, "space on the button presses it once");

    // Dragging turns the surface, and the button turns it back.
    page.evaluate("rattle.seek(700)");
    assert_eq!(changed(&held, &settled(&mut page)), 0.0, "the same frame looks different");
    page.mouse("mousePressed", 560.0, 360.0);
    (1..=8).for_each(|i| page.mouse("mouseMoved", 560.0 + 25.0 * f64::from(i), 360.0 - 10.0 * f64::from(i)));
    page.mouse("mouseReleased", 760.0, 280.0);
    let turned = settled(&mut page);
    assert!(changed(&held, &turned) > 0.1, "dragging changed {} of the picture", changed(&held, &turned));
    keep(&mut page, "turned");
    page.click("#reset");
    assert!(changed(&held, &settled(&mut page)) < 0.002, "the view did not come back");

    // The switch, in both themes.
    page.click("#tabs button:nth-child(2)");
    assert_eq!(page.evaluate("[rattle.scene(), caption.textContent]"), json!([1, "Each on its own."]));
    page.evaluate("rattle.seek(900)");
    let gas = settled(&mut page);
    assert!(changed(&held, &gas) > 0.005, "the second scene looks like the first");
    keep(&mut page, "gas");
    page.dark(true);
    thread::sleep(Duration::from_millis(300));
    let dark = settled(&mut page);
    assert!(changed(&gas, &dark) > 0.9, "the dark theme looks like the light one");
    assert!(colourful(&dark) > 0.005, "no strong colours in the dark");
    // In the dark the surface stands out from the ground, which itself varies by about 30.
    let drawn =
        dark.iter().filter(|&&pixel| distance(pixel, dark[0]) > 45).count() as f64 / dark.len() as f64;
    assert!((0.2..0.8).contains(&drawn), "{drawn} of the stage differs from the ground");
    keep(&mut page, "gas-dark");
    page.evaluate("rattle.show(0)");
    settled(&mut page);
    keep(&mut page, "dark");

    // A phone, upright: everything is in sight, nothing overflows.
    page.resize(390, 844, true);
    thread::sleep(Duration::from_millis(300));
    settled(&mut page);
    keep(&mut page, "phone-dark");
    page.dark(false);
    settled(&mut page);
    keep(&mut page, "phone");
    // A phone widens its viewport for what overflows, so the numbers here are the phone's, not the page's.
    let size = "[document.documentElement.scrollWidth, document.documentElement.scrollHeight]";
    assert_eq!(page.evaluate(size), json!([390, 844]), "the page overflows a phone");
    let reachable = "['play', 'slider', 'speed', 'clock'].every((id) => { \
                     const r = document.getElementById(id).getBoundingClientRect(); \
                     return r.left >= 0 && r.right <= 390 && r.bottom <= 844; })";
    assert_eq!(page.evaluate(reachable), true, "a control is out of sight on a phone");
    page.resize(844, 390, true);
    thread::sleep(Duration::from_millis(300));
    settled(&mut page);
    keep(&mut page, "phone-wide");

    assert_eq!(page.complaints, Vec::<String>::new());
    assert_eq!(
        page.evaluate("performance.getEntriesByType('resource').length"),
        0,
        "the page loads something"
    );
}

/// Two bodies at the ends of a rod that turns, one of them on a rod to a fixed place; a disc, a wall and a box;
/// colours, sizes, names, axes, and charts.
fn machine() -> Scene3 {
    let times: Vec<f64> = (0..=10).map(|i| 0.1 * f64::from(i)).collect();
    let turn = |r: f64, t: f64| [r * t.cos(), 0.0, r * t.sin()];
    let arms: Vec<Vec<[f64; 3]>> =
        [1.0, -1.0].iter().map(|r| times.iter().map(|t| turn(*r, *t)).collect()).collect();
    let attitudes: Vec<[[f64; 3]; 3]> =
        times.iter().map(|t| [[t.cos(), t.sin(), 0.0], [-t.sin(), t.cos(), 0.0], [0.0, 0.0, 1.0]]).collect();
    let of_time = |f: fn(f64) -> f64| times.iter().map(|t| f(*t)).collect::<Vec<f64>>();
    Scene3::new("machine")
        .bodies(&times, &arms)
        .rods([(0, 1)])
        .rods([(0, [0.0, 0.0, 2.0])])
        .disc([-1.8, 0.4, 0.0], [0.0, 1.0, 0.0], 0.5)
        .wall([-2.4, 0.6, -1.4], [[4.8, 0.0, 0.0], [0.0, 0.0, 3.6]])
        .turning_box([0.5, 0.7, 0.9], &[[1.8, 0.0, -0.8]], &attitudes)
        .sizes(&[vec![0.12], of_time(|t| 0.12 + 0.2 * t)])
        .coloured_by("speed / m s⁻¹", &[vec![0.0], of_time(|t| t)])
        .names(["left", ""])
        .axes(["x / m", "y / m", "z / m"])
        .chart("Energy", [("kinetic", of_time(f64::sin)), ("potential", of_time(f64::cos))])
        .chart("Error", [("", of_time(|t| 1e-15 * (9.0 * t).sin()))])
        .seconds(0.4)
}

/// Sizes and colours of all bodies by the pixel in their middle, and whether there is something at a point of the
/// stage: red, green, blue and how opaque it is, of what is drawn in space.
pub(crate) fn pixel(page: &mut Browser, place: &str) -> [u8; 4] {
    let read = "rattle.draw(); const copy = document.createElement('canvas'); const ratio = canvas.width / canvas.clientWidth; \
                [copy.width, copy.height] = [canvas.width, canvas.height]; const pen = copy.getContext('2d'); \
                pen.drawImage(canvas, 0, 0); return [...pen.getImageData(ratio * x, ratio * y, 1, 1).data]";
    let found = page.evaluate(&format!("(([x, y]) => {{ {read} }})({place})"));
    [0, 1, 2, 3].map(|i| found[i].as_u64().unwrap() as u8)
}

#[test]
#[cfg(long)]
fn the_page_draws_what_a_scene_has() {
    let Some(chromium) = browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("machine.html");
    let mesh = Mesh::of(tube, [-1.2, -0.6, -0.3], [1.2, 0.6, 0.3], 60).unwrap();
    let still = |place: [f64; 3]| vec![place; 2];
    let warm = Scene3::new("warm")
        .bodies(&[0.0, 1.0], &[still([-0.9, 0.0, 0.0]), still([0.9, 0.0, 0.0])])
        .surface(&mesh)
        .heat("height", mesh.vertices.iter().map(|q| q[0]));
    let crowd: Vec<_> = (0..500).map(|i| still([f64::from(i % 25), f64::from(i / 25), 0.0])).collect();
    let crowd = Scene3::new("crowd").bodies(&[0.0, 1.0], &crowd);
    let bare = |trail| {
        Scene3::new("bare")
            .bodies(&[0.0, 1.0, 2.0], &[[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0]]])
            .trail(trail)
    };
    Page::new("Machine & more")
        .scene(machine())
        .scene(warm)
        .scene(crowd)
        .scene(bare(0))
        .scene(bare(2))
        .write(&file)
        .unwrap();
    let mut page = Browser::start(&chromium, &[]);
    page.resize(1120, 720, false);
    page.downloads(folder.path());
    page.open(&file);
    page.wait("window.rattle !== undefined");
    page.evaluate("rattle.pause(); rattle.seek(0)");
    keep(&mut page, "machine");

    // Rods are where the bodies are, at each time: in the middle between both, and nothing beside it.
    for frame in [0, 4, 10] {
        page.evaluate(&format!("rattle.seek({frame}); rattle.draw()"));
        let between = |part: f64, up: f64| {
            format!(
                "((a, b) => [a[0] + {part} * (b[0] - a[0]), a[1] + {part} * (b[1] - a[1]) - {up}])(rattle.place(0), rattle.place(1))"
            )
        };
        for part in [0.3, 0.5, 0.7] {
            let [r, g, b, opaque] = pixel(&mut page, &between(part, 0.0));
            assert!(
                opaque > 230 && distance([r, g, b], [g, g, g]) < 60,
                "frame {frame}: no rod at {part}: {r} {g} {b} {opaque}"
            );
            assert!(pixel(&mut page, &between(part, 22.0))[3] < 120, "frame {frame}: the rod is everywhere");
        }
        // One end of the other rod is fixed.
        assert!(
            pixel(
                &mut page,
                "((a, b) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2])(rattle.place(0), rattle.place(2))"
            )[3] > 230
        );
    }
    // The first body has the lowest colour of the scale all the time, and its size; the second goes to the other end of
    // both.
    let purple = |[r, g, b, _]: [u8; 4]| b > g && r > g;
    let yellow = |[r, g, b, _]: [u8; 4]| r > b && g > b && g > 120;
    let grown = "((a) => [a[0], a[1] + 20])(rattle.place(1))";
    page.evaluate("rattle.seek(0)");
    assert!(purple(pixel(&mut page, "rattle.place(0)")) && purple(pixel(&mut page, "rattle.place(1)")));
    assert!(pixel(&mut page, grown)[3] < 120, "it is large from the start");
    page.evaluate("rattle.seek(10)");
    assert!(purple(pixel(&mut page, "rattle.place(0)")) && yellow(pixel(&mut page, "rattle.place(1)")));
    assert!(yellow(pixel(&mut page, grown)), "it does not grow");

    // The charts' cursors follow the time, and a press on a chart goes there.
    for frame in [0, 5, 10] {
        page.evaluate(&format!("rattle.seek({frame}); rattle.draw()"));
        let cursors = page.evaluate("rattle.cursors()");
        for chart in [0, 1] {
            assert!(
                (cursors[chart].as_f64().unwrap() - 0.1 * f64::from(frame)).abs() < 1e-3,
                "{frame}: {cursors}"
            );
        }
    }
    let middle = "(() => { const r = document.querySelector('#charts canvas').getBoundingClientRect(); return [r.x + 0.55 * r.width, r.y + r.height / 2] })()";
    let place = page.evaluate(middle);
    page.mouse("mousePressed", place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
    page.mouse("mouseReleased", place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
    assert!([4, 5, 6].map(|frame| json!(frame)).contains(&page.evaluate("rattle.frame()")));

    // A change of size is drawn before the browser shows it: an observer that comes after the page's own sees a full
    // canvas.
    page.evaluate(
        "rattle.play(); window.seen = []; new ResizeObserver(() => { const copy = document.createElement('canvas'); \
         [copy.width, copy.height] = [canvas.width, canvas.height]; const pen = copy.getContext('2d'); \
         pen.drawImage(canvas, 0, 0); const { data } = pen.getImageData(0, 0, copy.width, copy.height); \
         let full = 0; for (let i = 3; i < data.length; i += 4) full += data[i] > 0; seen.push([copy.width, full]) }) \
         .observe(document.getElementById('stage'))",
    );
    for width in [800, 390, 640, 1120] {
        page.resize(width, 720, false);
        page.wait(&format!(
            "seen.at(-1)?.[0] === canvas.width && innerWidth === {width} && Math.abs(canvas.clientWidth - canvas.width) < 1"
        ));
    }
    let seen = page.evaluate("seen");
    assert!(seen.as_array().unwrap().len() >= 4, "{seen}");
    assert!(
        seen.as_array().unwrap().iter().all(|size| size[1].as_u64() > Some(2000)),
        "an empty picture: {seen}"
    );

    // Scales of colours, names and axes are words and colours over the picture.
    let over = "(() => { rattle.draw(); const notes = document.getElementById('notes'); \
                const { data } = notes.getContext('2d').getImageData(notes.width - 220, 0, 220, 50); \
                const near = (i, rgb) => rgb.every((c, k) => Math.abs(data[i + k] - c) < 24); let ends = [0, 0]; \
                for (let i = 0; i < data.length; i += 4) [[68, 1, 84], [253, 231, 37]].forEach((rgb, k) => ends[k] += near(i, rgb) && data[i + 3] > 250); \
                return ends })()";
    page.evaluate("rattle.pause()");
    let ends = page.evaluate(over);
    assert!(
        ends[0].as_u64() > Some(20) && ends[1].as_u64() > Some(20),
        "both ends of viridis on the scale: {ends}"
    );

    // A surface in colours: purple on the left, yellow on the right.
    page.evaluate("rattle.show(1)");
    keep(&mut page, "warm");
    let [left, right] =
        ["0", "1"].map(|body| pixel(&mut page, &format!("((a) => [a[0], a[1] - 14])(rattle.place({body}))")));
    assert!(purple(left) && yellow(right), "{left:?} {right:?}");
    let ends = page.evaluate(over);
    assert!(ends[0].as_u64() > Some(20) && ends[1].as_u64() > Some(20), "{ends}");

    // Of five hundred each says which it is.
    page.evaluate("rattle.show(2)");
    let at = page.evaluate("((a) => { const r = canvas.getBoundingClientRect(); return [a[0] + r.x, a[1] + r.y] })(rattle.place(317))");
    page.mouse_over(at[0].as_f64().unwrap(), at[1].as_f64().unwrap());
    assert_eq!(page.evaluate("rattle.pointed()"), 317);
    keep(&mut page, "crowd");

    // Trails are there when asked for.
    let trails = [3, 4].map(|scene| {
        page.evaluate(&format!("rattle.show({scene}); rattle.seek(2)"));
        pixel(&mut page, "((a) => [a[0], a[1] + 120])(rattle.place(0))")[3]
    });
    assert!(trails[0] == 0 && trails[1] > 60, "{trails:?}");

    // The buttons save a picture, and the film as an archive of pictures.
    page.evaluate("rattle.show(0); rattle.seek(3)");
    page.click("#photo");
    let picture = browser::downloaded(&folder.path().join("machine-more.png"));
    assert!(size(&picture)[0] > 1000, "stage and charts side by side: {:?}", size(&picture));
    page.click("#film");
    let film = browser::downloaded(&folder.path().join("machine-more.zip"));
    let mut film = zip::ZipArchive::new(std::io::Cursor::new(film)).unwrap();
    assert_eq!(film.len(), 11, "25 pictures a second for 0.4 s, and one at the start");
    let mut frames = Vec::new();
    for i in 0..film.len() {
        let mut file = film.by_index(i).unwrap();
        assert_eq!(file.name().unwrap(), format!("frame-{i:05}.png"));
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut file, &mut bytes).unwrap(); // its sum of bytes is checked
        assert_eq!(size(&bytes), size(&picture));
        frames.push(bytes);
    }
    assert!(frames.windows(2).all(|pair| pair[0] != pair[1]), "two pictures in a row are the same");
    assert_eq!(frames[3], picture, "the film's picture of a time is that of the button");
    assert_eq!(page.evaluate("rattle.frame()"), 3, "the film changed the time");
    assert_eq!(page.complaints, Vec::<String>::new());
}

/// Width and height of a PNG, which codecs want even.
fn size(png: &[u8]) -> [u32; 2] {
    let reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let size = [reader.info().width, reader.info().height];
    assert_eq!(size.map(|side| side % 2), [0, 0]);
    size
}

#[test]
fn without_webgl_the_page_says_so() {
    let Some(chromium) = browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("page.html");
    Page::new("Flight").scene(flight()).write(&file).unwrap();
    let mut page = Browser::start(&chromium, &["--disable-3d-apis"]);
    page.open(&file);
    page.wait("!problem.hidden && problem.textContent.includes('needs WebGL 2')");
    assert_eq!(page.complaints, Vec::<String>::new());
}

pub(crate) fn flight() -> Scene3 {
    Scene3::new("flight").bodies(&[0.0, 1.0], &[[[0.0; 3], [1.0; 3]]])
}

/// The stage once damping has come to rest: two screenshots in a row that agree.
pub(crate) fn settled(page: &mut Browser) -> Vec<[u8; 3]> {
    let mut picture = stage(page);
    for _ in 0..60 {
        thread::sleep(Duration::from_millis(100));
        let next = stage(page);
        if next.len() == picture.len() && changed(&picture, &next) == 0.0 {
            return next;
        }
        picture = next;
    }
    panic!("the picture does not come to rest");
}

pub(crate) fn ball(r: f64) -> Mesh {
    let g = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z - r * r, [2.0 * x, 2.0 * y, 2.0 * z]);
    Mesh::of(g, [-1.1; 3], [1.1; 3], 40).unwrap()
}

/// Each mesh is shown from its time on: a ball of twice the radius covers four times as many pixels.
#[test]
#[cfg(long)]
fn a_moving_surface_moves() {
    let Some(chromium) = browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.html");
    let scene =
        Scene3::new("ball").times(&[0.0, 1.0, 2.0]).moving_surface(&[(0.0, ball(0.5)), (1.5, ball(1.0))]);
    Page::new("Ball").scene(scene).write(&file).unwrap();
    let mut page = opened(&chromium, &file, [1120, 720]);
    page.evaluate("rattle.pause()");
    let mut covered = |frame: u32| {
        page.evaluate(&format!("rattle.seek({frame}); rattle.draw()"));
        let across = "(() => { const w = canvas.clientWidth, h = canvas.clientHeight; rattle.draw(); \
                      const copy = document.createElement('canvas'); \
                      [copy.width, copy.height] = [canvas.width, canvas.height]; const pen = copy.getContext('2d'); \
                      pen.drawImage(canvas, 0, 0); const all = pen.getImageData(0, 0, canvas.width, canvas.height).data; \
                      let n = 0; for (let i = 3; i < all.length; i += 4) n += all[i] > 230; return n })()";
        let pixels = page.evaluate(across).as_f64().unwrap();
        keep(&mut page, &format!("ball {frame}"));
        pixels
    };
    let [first, second, last] = [0, 1, 2].map(&mut covered);
    println!("{first} {second} {last}");
    assert!(first > 1000.0 && (second / first - 1.0).abs() < 0.01, "{first} {second}");
    assert!((last / first - 4.0).abs() < 0.6, "{first} {last}");
}

/// Numbers that f32 or six decimals would hide: times of a picosecond, small changes on a chart, a way through the
/// border of space.
#[test]
fn small_numbers_and_periods_are_shown() {
    let Some(chromium) = browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("small.html");
    let times: Vec<f64> = (0..=100).map(|i| 1e-13 * f64::from(i)).collect();
    let path: Vec<_> = (0..=100).map(|i| [f64::from(i), 0.0, f64::from(i % 2)]).collect();
    let energy: Vec<f64> = (0..=100).map(|i| -0.5 + 1e-8 * (0.1 * f64::from(i)).sin()).collect();
    let small = Scene3::new("small").bodies(&times, &[path]).chart("Energy", [("E", energy)]);
    let around = [vec![[0.9, 0.0, 0.0], [0.1, 0.0, 0.0]], vec![[0.0; 3]; 2], vec![[1.0, 0.0, 1.0]; 2]];
    let around = Scene3::new("around").bodies(&[0.0, 1.0], &around).periods([1.0, 0.0, 0.0]).names(["a"]);
    Page::new("Small").scene(small).scene(around).write(&file).unwrap();
    let mut page = opened(&chromium, &file, [1120, 720]);
    page.evaluate("rattle.pause(); rattle.seek(25)");
    page.wait("clock.textContent.includes('25 / 100')");
    assert_eq!(page.evaluate("clock.textContent"), "t = 2.5·10⁻¹² 25 / 100");
    // The rows that the curve covers, in parts of the chart.
    let rows = "(() => { const page = document.querySelector('#charts canvas'), { width, height } = page; rattle.draw(); \
                const { data } = page.getContext('2d').getImageData(0.3 * width, 30, 0.6 * width, height - 60); let rows = new Set(); \
                for (let i = 0; i < data.length; i += 4) if (data[i] < 40 && data[i + 2] > 150) rows.add(Math.floor(i / 4 / Math.floor(0.6 * width))); \
                return rows.size / (height - 60) })()";
    keep(&mut page, "small");
    let covered = page.evaluate(rows).as_f64().unwrap();
    assert!(covered > 0.7, "the curve covers {covered} of the chart's height");
    // Half on its way, the body is on the border.
    page.evaluate("rattle.show(1); rattle.seek(0.5); rattle.draw()");
    keep(&mut page, "around");
    let across = page.evaluate("[0, 1, 2].map((body) => rattle.place(body)[0])");
    let [body, left, right] = [0, 1, 2].map(|i| across[i].as_f64().unwrap());
    assert!((body - right).abs() < 0.05 * (right - left), "{across}");
    assert!(pixel(&mut page, "rattle.place(0)")[3] > 200, "the name is elsewhere than the body");
    assert_eq!(page.complaints, Vec::<String>::new());
}
