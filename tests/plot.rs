//! Charts: what a reader sees in the SVG text.

use rattle::plot::{Chart, PlotError};

const H: [f64; 6] = [0.02, 0.01, 0.005, 0.0025, 0.00125, 0.000625];

fn accuracy() -> Chart {
    Chart::new("What accuracy costs in time")
        .x("step h")
        .y("error in position at t = 5")
        .log_log()
        .marked("RATTLE", H.map(|h| (h, 3.0 * h * h)))
        .slope(2.0, "h²")
        .marked("fourth order", H.map(|h| (h, 40.0 * h.powi(4))))
        .slope(4.0, "h⁴")
}

fn energies() -> Chart {
    let curve = |k: u32| {
        let phase = f64::from(k) / 4.0;
        let points = (0..=2000).map(move |i| {
            let t = f64::from(i) * 0.01;
            (t, 0.012 * (3.0 * t + phase).sin() * (0.7 * t + phase).cos().powi(2))
        });
        (format!("θ = {}°", 15 * k), points)
    };
    Chart::new("Energy over 25 trajectories")
        .x("time t")
        .y("(E − E₀) / mean kinetic energy")
        .family((0..25).map(curve))
}

fn lemniscate() -> Chart {
    let points = (0..=400).map(|i| {
        let (s, c) = (f64::from(i) * std::f64::consts::TAU / 400.0).sin_cos();
        (s / (1.0 + c * c), s * c / (1.0 + c * c))
    });
    Chart::new("The lemniscate of Bernoulli, a = 1").x("x").y("y").equal_aspect().line("", points)
}

#[test]
fn charts_show_their_words_and_points() {
    for (name, chart, words) in [
        ("accuracy", accuracy(), vec!["What accuracy costs in time", "step h", "h⁴", "10⁻⁸", "0.01"]),
        ("energies", energies(), vec!["θ = 0°", "θ = 180°", "θ = 360°", "−0.01", "time t"]),
        ("lemniscate", lemniscate(), vec!["The lemniscate of Bernoulli", ">x<", ">y<"]),
        ("tiny", Chart::new("Rounding").line("", [(0.0, 0.0), (1.0, -4e-16)]), vec!["−2·10⁻¹⁶"]),
        ("tiniest", Chart::new("Subnormal").line("", [(0.0, 5e-324), (5e-324, 0.0)]), vec!["0.5"]),
        (
            "steepest",
            Chart::new("Steep")
                .log_log()
                .line("", [(1e-9, 1.0), (1.0, 1.0)])
                .slope(-900.0, "")
                .slope(f64::NAN, ""),
            vec!["10⁻⁶"],
        ),
        ("constant", Chart::new("Flat").line("", [(0.0, 0.5), (1.0, 0.5)]), vec!["0.5"]),
        ("a point", Chart::new("Dot").marked("", [(3.0, 0.0)]), vec!["<circle"]),
        ("widest", Chart::new("Widest").line("", [(-1e150, -1e150), (1e150, 1e150)]), vec!["10¹⁵⁰"]),
        ("far off", Chart::new("Far").line("", [(1e15, 1e9), (1e15 + 1.0, 1e9 + 1e-6)]), vec!["10¹⁵"]),
        (
            "all decades",
            Chart::new("Decades").log_log().line("", [(1e-150, 1e150), (1e150, 1e-150)]).slope(-1.0, "1/x"),
            vec!["10⁹⁵"],
        ),
        ("one decade", Chart::new("Decade").log_log().line("", [(1.0, 1e-9), (1.0, 1e-9)]), vec!["10⁻⁹"]),
        (
            "escaped",
            Chart::new("a < b & \"c\"").line("<x>", [(0.0, 0.0), (1.0, 1.0)]),
            vec!["a &lt; b &amp;", "&lt;x&gt;"],
        ),
    ] {
        let svg = chart.to_svg().unwrap();
        words.iter().for_each(|word| assert!(svg.contains(word), "{name}: no `{word}` in the picture"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}: a coordinate is not a number");
        // RATTLE_PICTURES=folder keeps the pictures, to be looked at.
        if let Some(folder) = std::env::var_os("RATTLE_PICTURES") {
            chart.save(std::path::Path::new(&folder).join(format!("{name}.svg"))).unwrap();
        }
    }
}

/// Errors near rounding are what such a chart is for.
#[test]
fn logarithmic_axes_reach_rounding() {
    let points = [(1e-3, 1e-15), (1e-2, 1e-13), (1e-1, 1e-11)];
    let svg = Chart::new("Deep").log_log().line("", points).to_svg().unwrap();
    let line = svg.split("<path d=\"M ").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    let heights: Vec<f64> =
        line.split(" L ").map(|p| p.split_whitespace().nth(1).unwrap().parse().unwrap()).collect();
    assert_eq!(heights.len(), 3, "{line}");
    let (first, second) = (heights[0] - heights[1], heights[1] - heights[2]);
    assert!(first > 20.0 && (first - second).abs() < 0.1, "equal decades, unequal heights: {line}");
    assert!(svg.contains("10⁻¹⁵") && svg.contains("10⁻¹¹"));
}

/// Errors near rounding fill a linear axis as well.
#[test]
fn linear_axes_reach_rounding() {
    let heights = |size: f64| -> Vec<f64> {
        let svg = Chart::new("Tiny").line("", [(0.0, -size), (1.0, 0.0), (2.0, size)]).to_svg().unwrap();
        let line = svg.split("<path d=\"M ").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
        line.split(" L ").map(|p| p.split_whitespace().nth(1).unwrap().parse().unwrap()).collect()
    };
    for size in [1e-300, 1e-16, 1e-12, 1e-7, 1e-6, 1.0] {
        let heights = heights(size);
        assert!(heights[0] - heights[2] > 300.0, "{size:e}: {heights:?}");
        assert!((heights[0] - 2.0 * heights[1] + heights[2]).abs() < 0.1, "{size:e}: {heights:?}");
    }
}

#[test]
fn ticks_are_round_numbers() {
    let linear = |low, high| Chart::new("").line("", [(low, 0.0), (high, 1.0)]);
    let decades = |low, high| Chart::new("").log_log().line("", [(low, 1.0), (high, 2.0)]);
    for (chart, labels) in [
        (linear(0.0, 1.0), "0 0.2 0.4 0.6 0.8 1"),
        (linear(-1e150, 1e150), "−10¹⁵⁰ −5·10¹⁴⁹ 0 5·10¹⁴⁹ 10¹⁵⁰"),
        (linear(0.0, 30.0), "0 5 10 15 20 25 30"),
        (linear(-7.0, 90_000.0), "0 20000 40000 60000 80000"),
        (linear(0.0, 1e6), "0 2·10⁵ 4·10⁵ 6·10⁵ 8·10⁵ 10⁶"),
        (linear(0.0, 5e-16), "0 10⁻¹⁶ 2·10⁻¹⁶ 3·10⁻¹⁶ 4·10⁻¹⁶ 5·10⁻¹⁶"),
        (linear(0.0004, 0.0021), "4·10⁻⁴ 6·10⁻⁴ 8·10⁻⁴ 0.001 0.0012 0.0014 0.0016 0.0018 0.002"),
        (linear(1.0, 1.000_008), "1 1.000001 1.000002 1.000003 1.000004 1.000005 1.000006 1.000007 1.000008"),
        (decades(1e-3, 1e6), "10⁻³ 0.01 0.1 1 10 100 1000 10000 10⁵ 10⁶"),
        (decades(1e-3, 0.2), "10⁻³ 2·10⁻³ 5·10⁻³ 0.01 0.02 0.05 0.1 0.2"),
        (decades(1e-40, 1.0), "10⁻³⁹ 10⁻³⁶ 10⁻³³ 10⁻³⁰ 10⁻²⁷ 10⁻²⁴ 10⁻²¹ 10⁻¹⁸ 10⁻¹⁵ 10⁻¹² 10⁻⁹ 10⁻⁶ 10⁻³ 1"),
        (decades(3.0, 4.0), "2.5 3 3.5 4 4.5 5"),
    ] {
        let svg = chart.to_svg().unwrap();
        let below = svg.lines().filter(|line| line.contains("\"middle\" font-size=\"12\""));
        let found: Vec<&str> = below.map(|line| line.split(['<', '>']).nth(2).unwrap()).collect();
        assert_eq!(found.join(" "), labels);
    }
}

#[test]
fn a_circle_stays_a_circle() {
    for (width, height) in [(1.0, 1.0), (1e-9, 1e-9), (40.0, 1.0), (1.0, 9.0)] {
        let ellipse =
            (0..=180).map(|i| f64::from(2 * i).to_radians()).map(|a| (width * a.cos(), height * a.sin()));
        let svg = Chart::new("Ellipse").equal_aspect().line("around", ellipse).to_svg().unwrap();
        let line = svg.split("<path d=\"M ").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
        let places = line.split(" L ").map(|p| p.split_once(' ').unwrap());
        let places: Vec<[f64; 2]> = places.map(|(x, y)| [x.parse().unwrap(), y.parse().unwrap()]).collect();
        let size = |i: usize| {
            let side = || places.iter().map(|place| place[i]);
            side().fold(f64::MIN, f64::max) - side().fold(f64::MAX, f64::min)
        };
        assert!(
            size(0) > 80.0 && size(0) < 860.0 && size(1) < 900.0,
            "{width} {height}: {} × {}",
            size(0),
            size(1)
        );
        // Each place is rounded to hundredths.
        assert!(
            (size(0) * height - size(1) * width).abs() < 0.02 * (width + height),
            "{} × {}",
            size(0),
            size(1)
        );
    }
}

#[test]
fn errors_name_the_chart_the_curve_and_the_point() {
    let line =
        |points: Vec<(f64, f64)>| Chart::new("Energy").line("first", [(1.0, 1.0)]).line("second", points);
    for (chart, words) in [
        (Chart::new("Energy"), "chart `Energy` has no point"),
        (Chart::new("Energy").line("", []), "chart `Energy` has no point"),
        (line(vec![(0.0, 1.0), (1.0, f64::INFINITY)]), "curve 1 `second`: point 1 is (1, inf)"),
        (line(vec![(0.0, 1.0), (1.0, -2e150)]), "curve 1 `second`: point 1 is (1, -2"),
        (line(vec![(1.0, 1.0), (2.0, 0.0)]).log_log(), "curve 1 `second`: point 1 is (2e0, 0e0)"),
    ] {
        let message = chart.to_svg().unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    accuracy().save(&file).unwrap();
    assert!(matches!(accuracy().save(file.join("below.svg")), Err(PlotError::Io { .. })));
}
