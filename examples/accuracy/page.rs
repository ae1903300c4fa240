//! All diagrams on one page that needs nothing else. The page is that of `rattle-flow`'s example `flow_accuracy`, too.

use super::Report;
use rattle::price::Candidate;
use serde_json::{Value, json};

/// The page, with a diagram of long runs and a list of effects and their nanoseconds at its end.
pub(crate) fn page(
    reports: &[Report],
    effects: &[(&str, f64)],
    processor: &str,
    long: &str,
) -> Result<String, serde_json::Error> {
    let scenes: Vec<Value> = reports.iter().map(scene).collect();
    let data = json!({
        "processor": processor, "scenes": scenes, "effects": effects,
        "units": ["ns", "nanoseconds"], "errors": ["position", "energy"], "step": "h", "orders": [2, 4, 8],
    });
    let data = serde_json::to_string(&data)?;
    Ok(include_str!("page.html").replace("LONG RUNS", long).replace("\"DATA\"", &data.replace("</", "<\\/")))
}

fn scene(report: &Report) -> Value {
    let prices = &report.prices;
    let rows = prices.rows.iter().map(|row| {
        json!({
            "method": row.method.to_string(), "h": row.h, "tolerance": row.tolerance, "first": row.position,
            "second": row.energy, "cost": 1e9 * row.seconds, "spread": row.spread, "steps": row.steps,
            "order": row.order, "rounding": row.rounding, "front": row.front,
        })
    });
    let rows = rows.collect::<Vec<_>>();
    let list = |digits: Vec<(u32, f64, Candidate)>| -> Vec<Value> {
        digits.into_iter().map(|(digits, ns, method)| json!([digits, ns, method.to_string()])).collect()
    };
    let (digits, lanes) = (list(prices.digits()), list(prices.digits_in_lanes()));
    json!({
        "title": report.title, "file": report.file, "duration": prices.duration, "pilot": prices.pilot, "rows": rows,
        "digits": digits, "lanes": lanes, "lyapunov": prices.lyapunov_time, "predictable": prices.predictable,
        "floor": prices.reference_error.max(prices.rounding), "positions": prices.tells_positions(),
    })
}
