//! Ticks of charts: round numbers, which stand where points of these numbers are drawn.

use crate::plot::numbers;
use rattle::plot::Chart;

/// Labels beside the axes with their y, or below them with their x.
fn labels(svg: &str, up: bool) -> Vec<(String, f64)> {
    let (kind, name) =
        if up { ("\"end\" font-size=\"12\"", "y") } else { ("\"middle\" font-size=\"12\"", "x") };
    let text = |line: &str| line.split(['<', '>']).nth(2).unwrap().to_string();
    let lines = svg.lines().filter(|line| line.contains(kind));
    lines.map(text).zip(numbers(svg, kind, name)).collect()
}

/// The number that a label tells: as 0.05, 10⁻³ or −1.5·10⁶.
fn number(label: &str) -> f64 {
    const RAISED: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻";
    let digit = |c: char| RAISED.chars().position(|raised| raised == c);
    let power = label.strip_prefix("10").filter(|rest| rest.starts_with(|c| digit(c).is_some()));
    let label = power.map_or(label.into(), |power| format!("1·10{power}"));
    let plain = |c: char| digit(c).map_or(c, |n| char::from(b"0123456789-"[n]));
    label.replace("·10", "e").replace('−', "-").chars().map(plain).collect::<String>().parse().unwrap()
}

#[test]
fn ticks_are_round_numbers() {
    let linear = |low, high| Chart::new("").line("", [(low, 0.0), (high, 1.0)]);
    let decades = |low, high| Chart::new("").log_log().line("", [(low, 1.0), (high, 2.0)]);
    for (chart, expected) in [
        (linear(0.0, 1.0), "0 0.2 0.4 0.6 0.8 1.0"),
        (linear(-1e150, 1e150), "−1.0·10¹⁵⁰ −0.5·10¹⁵⁰ 0 0.5·10¹⁵⁰ 1.0·10¹⁵⁰"),
        (linear(0.0, 30.0), "0 5 10 15 20 25 30"),
        (linear(-7.0, 90_000.0), "−20000 0 20000 40000 60000 80000 100000"),
        (linear(0.0, 1e6), "0 0.2·10⁶ 0.4·10⁶ 0.6·10⁶ 0.8·10⁶ 1.0·10⁶"),
        (linear(0.0, 5e-16), "0 1·10⁻¹⁶ 2·10⁻¹⁶ 3·10⁻¹⁶ 4·10⁻¹⁶ 5·10⁻¹⁶"),
        (linear(0.0004, 0.0021), "0.0004 0.0006 0.0008 0.0010 0.0012 0.0014 0.0016 0.0018 0.0020 0.0022"),
        (
            linear(1.0, 1.000_008),
            "1.000000 1.000001 1.000002 1.000003 1.000004 1.000005 1.000006 1.000007 1.000008",
        ),
        (decades(1e-3, 1e6), "10⁻³ 10⁻² 10⁻¹ 10⁰ 10¹ 10² 10³ 10⁴ 10⁵ 10⁶"),
        (decades(0.03, 7e3), "0.01 0.1 1 10 100 1000 10000"),
        (decades(1e-3, 0.2), "10⁻³ 2·10⁻³ 5·10⁻³ 10⁻² 2·10⁻² 5·10⁻² 10⁻¹ 2·10⁻¹"),
        (
            decades(1e-40, 1.0),
            "10⁻⁴² 10⁻³⁹ 10⁻³⁶ 10⁻³³ 10⁻³⁰ 10⁻²⁷ 10⁻²⁴ 10⁻²¹ 10⁻¹⁸ 10⁻¹⁵ 10⁻¹² 10⁻⁹ 10⁻⁶ 10⁻³ 10⁰",
        ),
        (decades(3.0, 4.0), "3.0 3.2 3.4 3.6 3.8 4.0"),
        (linear(1.0, 100.0).log_x(), "1 2 5 10 20 50 100"),
    ] {
        let svg = chart.to_svg().unwrap();
        let found: Vec<String> = labels(&svg, false).into_iter().map(|(label, _)| label).collect();
        assert_eq!(found.join(" "), expected);
    }
}

/// Where a label tells a number a point of that number is drawn: on linear axes, and on logarithmic ones with ticks at
/// powers of ten, at 2 and 5 times them, and at multiples; across and up.
#[test]
fn ticks_stand_at_their_numbers() {
    let charts = [
        (Chart::new(""), [0.0, 1.0]),
        (Chart::new(""), [-7.0, 90_000.0]),
        (Chart::new(""), [0.0, 5e-16]),
        (Chart::new(""), [0.0004, 0.0020]),
        (Chart::new("").log_log(), [3.0, 4.0]),
        (Chart::new("").log_log(), [1e-3, 0.2]),
        (Chart::new("").log_log(), [0.03, 7e3]),
        (Chart::new("").log_log(), [1e-40, 1.0]),
    ];
    for (up, (chart, ends)) in [false, true].into_iter().flat_map(|up| charts.clone().map(|case| (up, case)))
    {
        let point = |value: f64| if up { (1.0, value) } else { (value, 1.0) };
        let bare = chart.line("", ends.map(point));
        let told = labels(&bare.to_svg().unwrap(), up);
        let svg = bare.marked("", told.iter().map(|(label, _)| point(number(label)))).to_svg().unwrap();
        let (ticks, marks) = (labels(&svg, up), numbers(&svg, "<circle", if up { "cy" } else { "cx" }));
        assert!(ticks.len() >= 4 && ticks.len() == told.len() && ticks.len() == marks.len(), "{ticks:?}");
        for (((label, place), (before, _)), mark) in ticks.iter().zip(told).zip(marks) {
            assert_eq!(*label, before, "the axis ended at ticks already");
            // The line on which letters of size 12 stand is below their middle; places are rounded to hundredths.
            let place = if up { place - 0.35 * 12.0 } else { *place };
            assert!((place - mark).abs() < 0.02, "{label} is at {place}, and its number at {mark}");
        }
    }
}
