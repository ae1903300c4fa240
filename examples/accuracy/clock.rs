//! Seconds of this processor, which others on the machine do not lengthen.

/// Seconds that this thread has run.
#[cfg(unix)]
pub(crate) fn cpu_seconds() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

/// Seconds of the clock.
#[cfg(not(unix))]
pub(crate) fn cpu_seconds() -> f64 {
    std::time::UNIX_EPOCH.elapsed().expect("a clock after 1970").as_secs_f64()
}
