//! The page of a flow in a headless Chromium: water moves, stands still when told, and what is shown fits the window.

#[path = "../../tests/browser/mod.rs"]
#[allow(dead_code)]
mod browser;

use browser::Browser;
use rattle_flow::{FlowError, Page, dam_break};
use std::io::Cursor;

/// Width, and red, green and blue from the top left.
fn pixels(page: &mut Browser) -> (usize, Vec<[u8; 3]>) {
    let shot = page.screenshot(None);
    let mut reader = png::Decoder::new(Cursor::new(shot)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let channels = info.color_type.samples();
    let pixels = bytes.chunks_exact(channels).map(|pixel| [pixel[0], pixel[1], pixel[2]]);
    (info.width as usize, pixels.collect())
}

/// How many pixels have more blue than red, as only water does.
fn water(pixels: &[[u8; 3]]) -> usize {
    pixels.iter().filter(|[red, _, blue]| i32::from(*blue) > 40 + i32::from(*red)).count()
}

fn keep(page: &mut Browser, name: &str) {
    if let Some(folder) = std::env::var_os("SCREENSHOTS") {
        std::fs::write(std::path::Path::new(&folder).join(name), page.screenshot(None)).unwrap();
    }
}

/// `SCREENSHOTS=folder` keeps the pictures.
#[test]
fn a_browser_plays_the_dam_break() {
    let Some(chromium) = browser::find() else { return };
    let mesh = dam_break::mesh(0.25).unwrap();
    let depth = dam_break::depth(&mesh);
    let mut simulation = dam_break::flow(mesh).simulate(depth, 1.0 / 16.0).unwrap();
    let mut film = Page::new("A dam breaks & <water> runs", simulation.flow());
    film.add(0.0, simulation.depth()).unwrap();
    for _ in 0..60 {
        simulation.run(4).unwrap();
        film.add(simulation.time(), simulation.depth()).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("dam.html");
    film.caption("An upper basin, a ramp with plants, a lower basin.")
        .units("<m>", "s")
        .lift(1.5)
        .write(&file)
        .unwrap();

    let mut page = Browser::start(&chromium, &[]);
    page.resize(1280, 720, false);
    page.open(&file);
    page.wait("frame > 0 && playing"); // it starts by playing
    assert_eq!(page.evaluate("document.title"), "A dam breaks & <water> runs");
    assert_eq!(page.evaluate("document.getElementById('problem').textContent"), "");

    // Where the slider is put the page stands still: water above at first, below at the end.
    let seek = |page: &mut Browser, frame: usize| {
        let put = format!(
            "slider.value = {frame}; slider.dispatchEvent(new Event('input')); window.settled = false; \
             requestAnimationFrame(() => requestAnimationFrame(() => {{ window.settled = true; }}))"
        );
        page.evaluate(&put);
        page.wait(&format!("frame == {frame} && !playing && settled"));
        page.wait(&format!(
            "document.getElementById('now').textContent == 't = {:.2} s'",
            0.25 * frame as f64
        ));
        pixels(page)
    };
    let (_, start) = seek(&mut page, 0);
    keep(&mut page, "start.png");
    let (_, end) = seek(&mut page, 60);
    keep(&mut page, "desktop.png");
    let (_, again) = seek(&mut page, 60);
    assert!(end == again, "the picture moves while paused");
    assert!(water(&start) > 10_000, "{}", water(&start));
    assert!(water(&end) as f64 > 1.3 * water(&start) as f64, "{} {}", water(&end), water(&start));

    // What colours, lengths and times are.
    let legend = page.evaluate("document.getElementById('legend').textContent");
    assert_eq!(legend, "depth 0  1 <m>; the ground is 3 by 6 <m>, heights drawn 1.5 times as high");
    page.click("#play");
    page.wait("playing && frame < 59 && frame > 0"); // from the end it begins again

    page.dark(true);
    let (_, dark) = seek(&mut page, 20);
    keep(&mut page, "dark.png");
    assert!(dark[0].iter().all(|&x| x < 60), "{:?} at the corner of a dark page", dark[0]);
    page.dark(false);

    page.resize(390, 844, true);
    let (width, phone) = seek(&mut page, 20);
    keep(&mut page, "phone.png");
    assert!(width >= 390 && water(&phone) > 1000, "{width} {}", water(&phone));
    let fits = "[...document.querySelectorAll('button, input, output, h1, header p')].every(e => {
        const r = e.getBoundingClientRect();
        return r.left >= 0 && r.right <= innerWidth && r.bottom <= innerHeight;
    })";
    assert_eq!(page.evaluate(fits), true);
    assert!(page.evaluate("slider.getBoundingClientRect().width").as_f64().unwrap() > 100.0);
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
}

/// A number of the page's data.
fn number(html: &str, name: &str) -> f64 {
    let (_, rest) = html.split_once(&format!("\"{name}\":")).unwrap();
    rest[..rest.find(',').unwrap()].parse().unwrap()
}

/// Ground without water is shown without: as numbers of 32 bits, too, no depth is above the film that is left out.
#[test]
fn dry_ground_is_shown_dry() {
    let flow = dam_break::flow(dam_break::mesh(0.5).unwrap());
    let depth = dam_break::depth(flow.mesh());
    let page = |scale: f64| {
        let mut page = Page::new("Drought", &flow);
        let depth: Vec<f64> = depth.iter().map(|h| scale * h).collect();
        for time in [0.0, 1.0] {
            page.add(time, &depth).unwrap();
        }
        page
    };
    let html = page(0.0).to_html().unwrap();
    assert_eq!((number(&html, "deepest"), number(&html, "film")), (1.0, 0.002));
    assert!(html.contains("if (h <= film) discard;"));
    let html = page(1e-9).to_html().unwrap();
    assert!((number(&html, "deepest") * 1e9 - 1.0).abs() < 0.1, "{}", number(&html, "deepest"));

    let Some(chromium) = browser::find() else { return };
    let (folder, mut all) = (tempfile::tempdir().unwrap(), None);
    for (scale, wet) in [(0.0, false), (1.0, true), (f64::MIN_POSITIVE, false)] {
        let file = folder.path().join("dry.html");
        page(scale).write(&file).unwrap();
        let mut shown = Browser::start(&chromium, &[]);
        shown.resize(640, 480, false);
        shown.open(&file);
        shown.wait("frame > 0 && playing");
        // The least film, which is hardly blue, changes the colour of the ground.
        let (_, pixels) = pixels(&mut shown);
        let bare = pixels.iter().filter(|[red, _, blue]| {
            let (red, blue) = (i32::from(*red), i32::from(*blue));
            (4 * blue - 3 * red).abs() < 16 && (60..235).contains(&red)
        });
        let bare = bare.count();
        let all = *all.get_or_insert(bare);
        assert!(
            all > 5000 && if wet { bare < all - 1000 } else { bare == all },
            "{bare} of {all} with {scale:e}"
        );
        assert!(shown.complaints.is_empty(), "{:?}", shown.complaints);
    }
}

/// Without a time there is nothing to play: the page is not written.
#[test]
fn a_page_without_a_time_is_refused() {
    let flow = dam_break::flow(dam_break::mesh(0.5).unwrap());
    let mut page = Page::new("Nothing", &flow);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("nothing.html");
    let error = page.to_html().unwrap_err();
    assert!(matches!(error, FlowError::Number { what: "the number of times on a page", .. }), "{error}");
    assert_eq!(page.write(&file).unwrap_err().kind(), std::io::ErrorKind::InvalidInput);
    assert!(!file.exists());
    page.add(0.0, &dam_break::depth(flow.mesh())).unwrap();
    page.write(&file).unwrap();
}
