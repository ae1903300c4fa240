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

/// The chart crate clamps logarithms at 1e-10; errors near rounding must not end up on that floor.
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

/// It also takes short ranges for empty: errors near rounding must fill a linear axis as well.
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
