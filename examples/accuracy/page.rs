//! All diagrams on one page that needs nothing else.

use crate::Report;
use serde_json::{Value, json};

/// The page, with a diagram of long runs at its end.
pub(crate) fn page(reports: &[Report], processor: &str, long: &str) -> Result<String, serde_json::Error> {
    let scenes: Vec<Value> = reports.iter().map(scene).collect();
    let data = serde_json::to_string(&json!({ "processor": processor, "scenes": scenes }))?;
    Ok(include_str!("page.html").replace("LONG RUNS", long).replace("\"DATA\"", &data.replace("</", "<\\/")))
}

fn scene(report: &Report) -> Value {
    let prices = &report.prices;
    let rows = prices.rows.iter().map(|row| {
        json!({
            "method": row.method.to_string(), "h": row.h, "tolerance": row.tolerance, "position": row.position,
            "energy": row.energy, "ns": 1e9 * row.seconds, "spread": row.spread, "steps": row.steps,
            "order": row.order, "rounding": row.rounding, "front": row.front,
        })
    });
    let rows = rows.collect::<Vec<_>>();
    let digits: Vec<Value> = prices
        .digits()
        .into_iter()
        .map(|(digits, ns, method)| json!([digits, ns, method.to_string()]))
        .collect();
    json!({
        "title": report.title, "file": report.file, "duration": prices.duration, "pilot": prices.pilot, "rows": rows,
        "digits": digits, "lyapunov": prices.lyapunov_time, "predictable": prices.predictable,
        "floor": prices.reference_error.max(prices.rounding), "positions": prices.tells_positions(),
    })
}
