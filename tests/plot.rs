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

fn histogram() -> Chart {
    let maxwell = |v: f64| v * v * (-v * v / 2.0).exp() * 0.8;
    let centres = (0..20).map(|i| 0.2 * f64::from(i) + 0.1);
    let noise = |v: f64| maxwell(v) * (1.0 + 0.1 * (40.0 * v).sin());
    Chart::new("Speeds")
        .x("speed")
        .y("f(v)")
        .bars("seen", centres.map(|v| (v, noise(v))))
        .line("exact", (0..=200).map(|i| 0.02 * f64::from(i)).map(|v| (v, maxwell(v))))
}

fn warming() -> Chart {
    let mean = |t: f64| 1.0 - (-t).exp();
    let times = || (0..=100).map(|i| 0.05 * f64::from(i));
    Chart::new("Warming")
        .band("± σ", times().map(|t| (t, mean(t) - 0.1 * t, mean(t) + 0.1 * t)))
        .line("mean", times().map(|t| (t, mean(t))))
        .line("the same", times().map(|t| (t, mean(t))))
}

fn saddle() -> Chart {
    let row = |j: u32| (0..60).map(|i| (f64::from(i) - 29.5) * (f64::from(j) - 29.5) / 900.0).collect();
    Chart::new("Saddle")
        .equal_aspect()
        .map("U / J", [-1.0, 1.0], [-1.0, 1.0], (0..60).map(row).collect())
        .line("zero", [(0.0, -1.0), (0.0, 1.0)])
}

#[test]
fn charts_show_their_words_and_points() {
    for (name, chart, words) in [
        ("accuracy", accuracy(), vec!["What accuracy costs in time", "step h", "h⁴", "10⁻⁸", "10⁻²"]),
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
        ("bars", histogram(), vec!["speed", "f(v)", "exact"]),
        ("band", warming(), vec!["± σ", "mean"]),
        ("map", saddle(), vec!["U / J", "zero"]),
        (
            "escaped",
            Chart::new("a < b & \"c\"").line("<x>", [(0.0, 0.0), (1.0, 1.0)]),
            vec!["a &lt; b &amp;", "&lt;x&gt;"],
        ),
        (
            "controls", // which XML cannot have, escaped or not
            Chart::new("\u{1b}[1mbold\u{1b}[0m\0").line("\u{ffff}", [(0.0, 0.0), (1.0, 1.0)]),
            vec!["\u{fffd}[1mbold\u{fffd}[0m\u{fffd}", ">\u{fffd}<"],
        ),
    ] {
        let svg = chart.to_svg().unwrap();
        words.iter().for_each(|word| assert!(svg.contains(word), "{name}: no `{word}` in the picture"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}: a coordinate is not a number");
        assert!(svg.chars().all(|c| c == '\n' || !c.is_control()), "{name}: no reader of XML opens it");
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

/// A small change of a large number fills a linear axis; what is below rounding is a constant.
#[test]
fn linear_axes_show_small_changes() {
    for (size, part) in [(1e-6, 0.5), (1e-9, 0.5), (1e-10, 0.5), (1e-12, 0.5), (1e-15, 0.0)] {
        let energy = (0..=200).map(|i| (f64::from(i), -0.5 + size * (0.1 * f64::from(i)).sin()));
        let svg = Chart::new("Energy").line("", energy).to_svg().unwrap();
        let line = svg.split("<path d=\"M ").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
        let heights: Vec<f64> =
            line.split(" L ").map(|p| p.split_whitespace().nth(1).unwrap().parse().unwrap()).collect();
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let covered = (heights.iter().copied().fold(0.0, f64::max) - low) / 480.0;
        assert!(
            if part > 0.0 { covered > part } else { covered < 0.01 },
            "{size:e}: {covered} of the height"
        );
        let mut labels: Vec<&str> =
            svg.split("text-anchor=\"end\"").skip(1).map(|t| t.split(['>', '<']).nth(1).unwrap()).collect();
        let all = labels.len();
        labels.dedup();
        assert!(all >= 3 && labels.len() == all, "{size:e}: ticks with the same label: {labels:?}");
    }
}

/// The sheet is as high as the legend, and a line of one point is a dot.
#[test]
fn legends_and_single_points_are_whole() {
    let lines = |n: u32| {
        let line = |chart: Chart, k| {
            chart.line(format!("curve {k}"), [(0.0, f64::from(k)), (1.0, f64::from(k + 1))])
        };
        (0..n).fold(Chart::new("many").x("x"), line)
    };
    let number = |text: &str, name: &str| -> f64 {
        text.split(&format!("{name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
    };
    for n in [1, 20, 30, 80] {
        for chart in [lines(n), lines(n).equal_aspect()] {
            let svg = chart.to_svg().unwrap();
            let height = number(&svg, "height");
            let last = svg.lines().find(|line| line.contains(&format!(">curve {}<", n - 1))).unwrap();
            assert!(
                number(last, " y") < height - 5.0,
                "{n}: the last row is at {} of {height}",
                number(last, " y")
            );
            let below = svg.lines().find(|line| line.contains(">x<")).unwrap();
            assert!(number(below, " y") < height.min(901.0), "{n}: the label of x");
        }
    }
    assert_eq!(number(&lines(5).to_svg().unwrap(), "height"), 480.0);
    for points in [vec![(1.0, 2.0)], vec![(1.0, 2.0); 3]] {
        let svg = Chart::new("one").line("a", [(0.0, 0.0), (2.0, 3.0)]).line("dot", points).to_svg().unwrap();
        assert!(svg.contains("<circle"), "nothing is drawn");
    }
}

/// The numbers of an attribute, of all elements that the text names.
pub(crate) fn numbers(svg: &str, element: &str, attribute: &str) -> Vec<f64> {
    let lines = svg.lines().filter(|line| line.contains(element));
    let value = |line: &str| line.split(&format!(" {attribute}=\"")).nth(1)?.split('"').next()?.parse().ok();
    lines.map(|line| value(line).expect(line)).collect()
}

/// Places of the n-th line that is drawn.
fn places(svg: &str, n: usize) -> Vec<[f64; 2]> {
    let line = svg.split("<path d=\"M ").nth(n + 1).and_then(|rest| rest.split('"').next()).unwrap();
    let numbers = |place: &str| place.split_whitespace().map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
    line.split(" L ").map(numbers).map(|place| [place[0], place[1]]).collect()
}

/// Left, right, top and bottom of the axes: the first two dark lines are they.
fn frame(svg: &str) -> [f64; 4] {
    let ink: Vec<&str> = svg.lines().filter(|line| line.contains("stroke=\"#2b2f36\"")).collect();
    let side = |line: &str, name: &str| numbers(line, "<line", name)[0];
    [side(ink[1], "x1"), side(ink[1], "x2"), side(ink[0], "y1"), side(ink[0], "y2")]
}

/// Marks on the outermost points lie whole inside the axes, also where these end at ticks.
#[test]
fn no_mark_is_cut() {
    let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)];
    for chart in [Chart::new("").marked("", corners), Chart::new("").points("", corners)] {
        for chart in [chart.clone(), chart.equal_aspect()] {
            let svg = chart.to_svg().unwrap();
            let [left, right, top, bottom] = frame(&svg);
            let of = |name| numbers(&svg, "<circle", name);
            let radius = of("r")[0];
            assert_eq!(of("cx").len(), 4);
            assert!(of("cx").iter().all(|x| (left + radius..=right - radius).contains(x)), "{svg}");
            assert!(of("cy").iter().all(|y| (top + radius..=bottom - radius).contains(y)), "{svg}");
        }
    }
}

/// Bars stand on zero, lie within the axes, and are as high as their numbers.
#[test]
fn bars_stand_on_zero() {
    let heights = [3.0, 7.0, -2.0];
    let svg = Chart::new("").bars("n", heights.map(|y| (y, y))).to_svg().unwrap();
    let [left, right, top, bottom] = frame(&svg);
    let of = |name| numbers(&svg, "crispEdges", name).into_iter().take(3).collect::<Vec<f64>>();
    let (x, y, width, height) = (of("x"), of("y"), of("width"), of("height"));
    let unit = height[0] / 3.0;
    assert!((height[1] - 7.0 * unit).abs() < 0.03 && (height[2] - 2.0 * unit).abs() < 0.03, "{height:?}");
    // Foot of the first, and top of the one below zero.
    assert!(
        (y[0] + height[0] - y[2]).abs() < 0.03 && (y[1] + height[1] - y[2]).abs() < 0.03,
        "{y:?} {height:?}"
    );
    for i in 0..3 {
        assert!(x[i] >= left && x[i] + width[i] <= right && y[i] >= top && y[i] + height[i] <= bottom + 0.01);
    }
    // On a logarithmic axis they stand on its end.
    let svg = Chart::new("").log_y().bars("", [(0.0, 1e-3), (1.0, 10.0)]).to_svg().unwrap();
    let bottom = frame(&svg)[3];
    let (y, height) = (numbers(&svg, "crispEdges", "y"), numbers(&svg, "crispEdges", "height"));
    assert!((y[1] + height[1] - bottom).abs() < 0.02 && height[1] > 300.0, "{y:?} {height:?} {bottom}");
    // So do the lowest, also where their number is a tick.
    for least in [1e-3, 1.0, 0.3] {
        let bars = [1.0, 2.0, 40.0, 2000.0].map(|times| (f64::ln(times), least * times));
        for number in 1..=4 {
            let svg = Chart::new("").log_y().bars("", bars[..number].to_vec()).to_svg().unwrap();
            let height = numbers(&svg, "crispEdges", "height");
            assert!(height.iter().all(|&height| height > 10.0), "{least} {number}: {height:?}");
        }
    }
}

/// On a logarithmic axis of x too, where the foot of the first would be below zero.
#[test]
fn bars_stand_over_powers() {
    let svg = Chart::new("").log_x().bars("", [(1.0, 3.0), (10.0, 2.0), (100.0, 1.0)]).to_svg().unwrap();
    let left = frame(&svg)[0];
    let (x, width) = (numbers(&svg, "crispEdges", "x"), numbers(&svg, "crispEdges", "width"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert!(
        x.len() == 3 && (x[0] - left).abs() < 0.02 && width.iter().all(|&width| width > 1.0),
        "{x:?} {width:?}"
    );
}

/// Decay is a straight line where only y is logarithmic, and a power on log–log axes is none there.
#[test]
fn one_axis_may_be_logarithmic() {
    let decay = [0.0, 5.0, 10.0].map(|t| (t, f64::exp(-t)));
    let powers = [1.0, 10.0, 100.0].map(|x| (x, f64::log10(x)));
    for chart in [Chart::new("").log_y().line("", decay), Chart::new("").log_x().line("", powers)] {
        let [a, b, c] = places(&chart.to_svg().unwrap(), 0)[..] else { panic!("three points") };
        assert!((a[0] - 2.0 * b[0] + c[0]).abs() < 0.03 && (a[1] - 2.0 * b[1] + c[1]).abs() < 0.03);
        assert!((a[1] - c[1]).abs() > 200.0);
    }
    assert!(matches!(
        Chart::new("").log_y().line("", [(-1.0, 1.0), (0.0, 0.0)]).to_svg(),
        Err(PlotError::NotPositive { index: 1, .. })
    ));
}

/// A band's edge is the two curves, and the curve that comes next has its colour.
#[test]
fn a_band_lies_between_its_curves() {
    let svg = Chart::new("")
        .line("other", [(0.0, 0.0), (2.0, 0.0)])
        .band("", [(0.0, 1.0, 3.0), (1.0, 0.0, 4.0), (2.0, 1.0, 3.0)])
        .line("mean", [(0.0, 1.0), (2.0, 1.0)])
        .to_svg()
        .unwrap();
    let (band, mean) = (svg.lines().find(|line| line.contains("fill-opacity")).unwrap(), places(&svg, 2));
    let edge = places(&band.replace(" Z", ""), 0);
    assert_eq!(edge.len(), 6);
    assert_eq!((edge[0], edge[2]), (mean[0], mean[1]), "its lower ends");
    assert_eq!([edge[3][0], edge[4][0], edge[5][0]], [edge[2][0], edge[1][0], edge[0][0]], "there and back");
    assert!(edge[4][1] < edge[3][1] && edge[1][1] > edge[0][1]);
    let colour = band.split("fill=\"").nth(1).unwrap().split('"').next().unwrap();
    assert!(svg.lines().rfind(|line| line.contains("stroke-width=\"1.6\"")).unwrap().contains(colour));
}

/// A number of a band that cannot be drawn is told as the one of the list that was given, in either curve.
#[test]
fn a_band_tells_which_of_its_points_is_none() {
    let error = |spoilt: usize, high: bool| {
        let of = |i: usize, is_high: bool| if i == spoilt && high == is_high { f64::NAN } else { 1.0 };
        Chart::new("").band("", (0..4).map(|i| (i as f64, of(i, false), of(i, true)))).to_svg().unwrap_err()
    };
    for (spoilt, high) in (0..4).flat_map(|i| [(i, false), (i, true)]) {
        let PlotError::NotFinite { index, x, .. } = error(spoilt, high) else { panic!("another error") };
        assert_eq!((index, x), (spoilt, spoilt as f64), "high: {high}");
    }
    let falls = Chart::new("").log_y().band("", [(0.0, 1.0, 2.0), (1.0, 1.0, 0.0), (2.0, 1.0, 2.0)]);
    assert!(matches!(falls.to_svg(), Err(PlotError::NotPositive { index: 1, .. })));
}

/// A line to compare with lies below its curve and between its ends, whatever the curve does.
#[test]
fn a_slope_lies_below_its_curve() {
    let powers = |p: f64| {
        (0..=12).map(move |k| 0.01_f64 * 10_f64.powf(f64::from(k) / 6.0)).map(move |x| (x, x.powf(p)))
    };
    let saturated = powers(4.0).map(|(x, y)| (x, y + 1e-5));
    let bent = powers(2.0).map(|(x, y)| (x, if x > 0.5 { 100.0 * y } else { y }));
    let curves: [(&str, Vec<(f64, f64)>); 6] = [
        ("as steep", powers(2.0).collect()),
        ("steeper", powers(4.0).collect()),
        ("flatter", powers(0.5).collect()),
        ("constant", powers(0.0).collect()),
        ("saturated", saturated.collect()),
        ("bent", bent.collect()),
    ];
    for ((name, curve), order) in curves.iter().flat_map(|curve| [(curve, 2.0), (curve, -1.0), (curve, 4.0)])
    {
        let svg = Chart::new("").log_log().line("", curve.iter().copied()).slope(order, "").to_svg().unwrap();
        let (curve, line) = (places(&svg, 0), places(&svg, 1));
        let [a, b] = line[..] else { panic!("{name}, {order}: {line:?}") };
        let [first, last] = [curve[0], curve[curve.len() - 1]];
        assert!(a[0] < b[0] && a[0] > first[0] - 0.1 && b[0] < last[0] + 0.1, "{name}, {order}: {line:?}");
        for [x, y] in curve.into_iter().filter(|place| place[0] >= a[0] && place[0] <= b[0]) {
            let height = a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]); // down the sheet
            assert!(height > y + 1.0, "{name}, {order}: {height} at {x}, and the curve is at {y}");
        }
    }
}

/// Cells tile their rectangle, low y below, and the lowest and the highest number have the ends of viridis.
#[test]
fn a_map_tiles_its_box() {
    let rows = vec![vec![0.0, 1.0, 2.0], vec![3.0, 3.0, 10.0]];
    let chart = |rows| Chart::new("Map").map("U / J", [0.0, 3.0], [-1.0, 1.0], rows);
    let svg = chart(rows).to_svg().unwrap();
    let [left, right, top, bottom] = frame(&svg);
    let cells: Vec<&str> = svg.lines().filter(|line| line.contains("crispEdges")).collect();
    let of = |i: usize, name: &str| numbers(cells[i], "<rect", name)[0];
    let area: f64 = (0..5).map(|i| of(i, "width") * of(i, "height")).sum();
    assert!((area / ((right - left) * (bottom - top)) - 1.0).abs() < 1e-4, "{area}");
    assert!(
        cells[0].contains("#440154") && (of(0, "y") + of(0, "height") - bottom).abs() < 0.02,
        "{}",
        cells[0]
    );
    assert!(cells[4].contains("#fde725") && (of(4, "y") - top).abs() < 0.02, "{}", cells[4]);
    assert!((of(3, "width") - 2.0 * of(0, "width")).abs() < 0.03, "equal neighbours are one");
    assert!(svg.contains(">U / J<") && svg.contains(">10<"));
    for (rows, words) in [
        (vec![], "0 rows"),
        (vec![vec![1.0, 2.0], vec![3.0]], "rows of one length"),
        (vec![vec![1.0, 2.0], vec![3.0, f64::NAN]], "number 1 of row 1 is not finite"),
    ] {
        let message = chart(rows).to_svg().unwrap_err().to_string();
        assert!(message.contains("chart `Map`") && message.contains(words), "{message}");
    }
    assert!(Chart::new("").log_x().map("", [0.0, 1.0], [0.0, 1.0], vec![vec![1.0]]).to_svg().is_err());
}

/// A curve on another is dashed, a third differently; one beside it is not.
#[test]
fn curves_on_each_other_are_told_apart() {
    let wave = |shift: f64| (0..500).map(move |i| (f64::from(i), (0.05 * f64::from(i)).sin() + shift));
    let circle = || (0..90).map(|i| f64::from(4 * i).to_radians().sin_cos());
    for (chart, expected) in [
        (
            Chart::new("").line("a", wave(0.0)).line("b", wave(1e-9)).line("c", wave(0.0)),
            ["none", "9 7", "3 8"],
        ),
        (Chart::new("").line("a", wave(0.0)).line("b", wave(0.3)).line("c", wave(0.6)), ["none"; 3]),
        (
            Chart::new("").line("a", wave(0.0)).line("b", wave(0.0).step_by(7)).line("c", wave(0.1)),
            ["none", "9 7", "none"],
        ),
        (
            Chart::new("")
                .line("a", circle())
                .line("b", circle())
                .line("c", circle().map(|p| (p.0, 2.0 * p.1))),
            ["none", "9 7", "none"],
        ),
    ] {
        let svg = chart.to_svg().unwrap();
        let dashes: Vec<&str> =
            svg.split("stroke-dasharray=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
        assert_eq!(dashes[..3], expected);
        assert_eq!(dashes[3..], expected, "in the legend");
    }
}

/// Of a million points a few thousand are written; every column of the picture has the same highest and lowest.
#[test]
fn long_curves_are_thinned_and_look_the_same() {
    let value = |i: u32| if i == 777_777 { 5.0 } else { (0.37 * f64::from(i)).sin() };
    let long = (0..1_000_000).map(|i| (f64::from(i), value(i)));
    let thin = places(&Chart::new("").line("", long.clone()).to_svg().unwrap(), 0);
    assert!((1000..8000).contains(&thin.len()), "{} points", thin.len());
    assert!(thin.windows(2).all(|pair| pair[0][0] <= pair[1][0]));
    let [first, last] = [thin[0], thin[thin.len() - 1]];
    let scale = (last[0] - first[0]) / 999_999.0;
    // The scale of heights from the spike and one more known point.
    let spike = thin.iter().map(|p| p[1]).fold(f64::MAX, f64::min);
    let unit = (first[1] - spike) / (5.0 - value(0));
    let mut columns = vec![[f64::MAX, f64::MIN]; 2000];
    let column = |x: f64| (2.0 * x) as usize;
    for (x, y) in long {
        let column = &mut columns[column(first[0] + scale * x)];
        let place = first[1] - unit * (y - value(0));
        *column = [column[0].min(place), column[1].max(place)];
    }
    let mut seen = vec![[f64::MAX, f64::MIN]; 2000];
    for [x, y] in thin {
        let column = &mut seen[column(x)];
        *column = [column[0].min(y), column[1].max(y)];
    }
    // Places are rounded to hundredths, which may move a point into the next column: two side by side are compared.
    let mut compared = 0;
    for (all, thin) in columns
        .windows(2)
        .zip(seen.windows(2))
        .filter(|(all, _)| all[0][0] < f64::MAX && all[1][0] < f64::MAX)
    {
        let both = |pair: &[[f64; 2]]| [pair[0][0].min(pair[1][0]), pair[0][1].max(pair[1][1])];
        let (all, thin) = (both(all), both(thin));
        assert!((all[0] - thin[0]).abs() < 0.02 && (all[1] - thin[1]).abs() < 0.02, "{all:?} {thin:?}");
        compared += 1;
    }
    assert!(compared > 1000);
    // A curve that goes back is left as it is.
    let circle = (0..20_000).map(|i| (0.01 * f64::from(i)).sin_cos());
    assert_eq!(places(&Chart::new("").line("", circle).to_svg().unwrap(), 0).len(), 20_000);
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
        (
            line(vec![(0.0, 1.0), (1.0, f64::INFINITY)]),
            "curve 1 `second`: point 1 is (1, inf), which is beyond 1e150; leave it out",
        ),
        (line(vec![(0.0, 1.0), (1.0, -2e150)]), "curve 1 `second`: point 1 is (1, -2e150), which"),
        (line(vec![(0.0, f64::NAN)]), "point 0 is (0, NaN), which is not a number; leave it out"),
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
