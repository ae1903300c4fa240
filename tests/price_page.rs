//! The page of what accuracy costs, opened in headless Chromium: it draws, and the pointer tells method, step, error
//! and cost, on a desk and on a phone.

use crate::page::browser::{Browser, find};
use rattle::price::{Candidate, Numbers, Price, Prices};
use serde_json::json;

#[allow(dead_code, reason = "the example writes more than its page")]
#[path = "../examples/accuracy/page.rs"]
mod written;

pub(crate) struct Report {
    file: &'static str,
    title: &'static str,
    prices: Prices,
}

/// Rows of RATTLE, of order 2, and of a method that is always exact; in lanes at a hundredth of the price.
fn report(title: &'static str, file: &'static str, scale: f64) -> Report {
    let row = |method: Candidate, h: f64, error: f64| Price {
        method,
        h,
        tolerance: None,
        position: Some(error),
        energy: 0.1 * error,
        averages: Vec::new(),
        drifts: Vec::new(),
        growth: [1.0, 0.0],
        seconds: scale * 1e-6 / h * if method.is_in_lanes() { 0.01 } else { 1.0 },
        spread: 0.05,
        steps: (5.0 / h) as u64,
        corrections: None,
        order: Some(2.0),
        rounding: false,
        front: error < 1e-3,
    };
    let lanes = Candidate::InLanes(&Candidate::Rattle, Numbers::Single);
    let rows = [0.1, 0.03, 0.01].into_iter().flat_map(|h| {
        [row(Candidate::Rattle, h, h * h), row(Candidate::Taylor, h, 1e-15), row(lanes, h, h * h)]
    });
    let mut rows: Vec<_> = rows.collect();
    rows.sort_by_key(|row| row.method.to_string());
    let prices = Prices {
        duration: 5.0,
        pilot: 5.0,
        reference: [Candidate::Taylor, Candidate::Lobatto8],
        reference_error: 1e-14,
        reference_energy_error: None,
        rounding: 0.0,
        way: 1.0,
        lyapunov_time: Some(1.5),
        predictable: Some(40.0),
        positions_until: 5.0,
        averages: Vec::new(),
        rows,
        refused: Vec::new(),
        seconds: 1.0,
    };
    Report { file, title, prices }
}

#[test]
fn the_pointer_tells_method_step_error_and_cost() {
    let Some(chromium) = find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("index.html");
    let reports = [report("A </script> of <b>two</b>", "first", 1.0), report("Dear", "second", 100.0)];
    std::fs::write(
        &file,
        written::page(&reports, &[("gravity", 42.0)], "a processor", "<svg></svg>").unwrap(),
    )
    .unwrap();

    let mut page = Browser::start(&chromium, &[]);
    for (width, height, mobile) in [(1280, 800, false), (390, 844, true)] {
        page.resize(width, height, mobile);
        page.open(&file);
        page.wait("document.querySelectorAll('#chart circle').length === 10");
        assert_eq!(page.evaluate("document.querySelectorAll('b').length"), 0, "a title became markup");
        let fits = format!("document.documentElement.scrollWidth <= {width}");
        assert_eq!(page.evaluate(&fits), true, "the page overflows {width} pixels");
        let inside = "[...document.querySelectorAll('#chart text, #chart line')].every(mark => { \
                      const box = mark.getBoundingClientRect(), all = get('chart').getBoundingClientRect(); \
                      return box.left >= all.left - 1 && box.right <= all.right + 1 \
                      && box.bottom <= all.bottom + 1; })";
        assert_eq!(page.evaluate(inside), true, "a mark lies outside of the diagram");

        // Each mark tells what it is.
        for (number, told) in [(0, "RATTLE, h = 0.100"), (5, "RATTLE, single in lanes, h = 0.0100")] {
            let place = format!(
                "(() => {{ const box = document.querySelectorAll('#chart circle')[{number}].getBoundingClientRect(); \
                 return [box.x + box.width / 2, box.y + box.height / 2]; }})()"
            );
            let place = page.evaluate(&place);
            page.mouse_over(place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
            page.wait(&format!("told.textContent.startsWith({told:?})"));
        }
        let text = page.evaluate("told.textContent");
        let error = "error in position 1.0e-4, in energy 1.0e-5, order 2.0";
        let cost = format!("1,000 ns ± 5 % for a unit of time, 500 steps; {error}");
        assert_eq!(text, format!("RATTLE, single in lanes, h = 0.0100: {cost}"));

        // Lists of digits, a method hidden, errors of energy, another scene.
        let lists = "[digits.children.length, lanes.children.length, side.hidden, effects.textContent]";
        assert_eq!(page.evaluate(lists), json!([15, 4, false, "42.0gravity"]));
        page.evaluate("document.querySelectorAll('#legend button')[0].click()");
        assert_eq!(page.evaluate("document.querySelectorAll('#chart circle').length"), 7);
        page.evaluate("document.querySelectorAll('#legend button')[0].click(); energy.click()");
        assert_eq!(
            page.evaluate("document.querySelectorAll('#chart text[transform]')[0].textContent"),
            "error in energy"
        );
        page.evaluate("energy.click(); scene.value = 1; scene.dispatchEvent(new Event('change'))");
        assert_eq!(
            page.evaluate(
                "machine.textContent.includes('Dear: measured on all of 5 units of time. Chaotic')"
            ),
            true
        );
    }
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
}
