//! What a picture took, for people and for programs.

use std::fmt::Write;
use std::time::Duration;

use curvetri::embree::Device;
use curvetri::render::RenderStats;
use serde_json::{Map, Value, json};

/// Sentences for people.
pub fn text(stats: &RenderStats, device: &Device) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:10} {value}");
    };
    let total = stats.triangles.total();
    line(
        "triangles",
        format!("{total} ({})", counts(&stats.triangles.named())),
    );
    if stats.instances > 0 {
        line("instances", stats.instances.to_string());
    }
    let spheres = stats.spheres.total();
    if spheres > 0 {
        let by_kind = counts(&stats.spheres.named());
        line("spheres", format!("{spheres} ({by_kind})"));
    }
    let [load, curve, build, render] = named_times(stats).map(|(_, time)| time.as_secs_f64());
    line(
        "time",
        format!("{load:.3} s load, {curve:.3} s curve, {build:.3} s build, {render:.3} s render"),
    );
    let peak = peak_memory().map(|bytes| ("at the peak, all of the program", bytes));
    let memory = named_memory(stats).into_iter().chain(peak);
    let memory = memory.map(|(name, bytes)| format!("{:.1} MB {name}", megabytes(bytes)));
    line("memory", memory.collect::<Vec<_>>().join(", "));
    let (rays, speed) = (stats.rays, stats.mray_per_second());
    line(
        "rays",
        format!(
            "{} primary, {} shadow, {} bounce, {speed:.2} Mray/s",
            rays.primary, rays.shadow, rays.bounce
        ),
    );
    let (calls, evaluations) = (stats.calls_per_ray(), stats.evaluations_per_call());
    line(
        "kernel",
        format!("{calls:.2} calls a ray, {evaluations:.2} evaluations a call"),
    );
    line("Embree", format!("{} ({})", device.version(), device.isa()));
    text
}

/// The counts that are not zero.
fn counts(named: &[(&str, usize)]) -> String {
    let some = named.iter().filter(|(_, count)| *count > 0);
    let words: Vec<String> = some
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    words.join(", ").replace('_', " ")
}

/// One JSON object. Times are in seconds, memory in bytes.
pub fn json(stats: &RenderStats, device: &Device) -> String {
    let mut triangles: Map<String, Value> = stats
        .triangles
        .named()
        .into_iter()
        .map(|(name, count)| (name.to_owned(), count.into()))
        .collect();
    triangles.insert("total".into(), stats.triangles.total().into());
    let times = named_times(stats).map(|(name, time)| (name, time.as_secs_f64()));
    let value = json!({
        "triangles": triangles,
        "instances": stats.instances,
        "spheres": Map::from_iter(
            stats.spheres.named().map(|(name, count)| (name.to_owned(), json!(count))),
        ),
        "seconds": Map::from_iter(times.map(|(name, time)| (name.to_owned(), json!(time)))),
        "bytes": Map::from_iter(
            named_memory(stats)
                .map(|(name, bytes)| (name.to_owned(), json!(bytes)))
                .into_iter()
                .chain([("peak".to_owned(), json!(peak_memory()))]),
        ),
        "rays": {
            "primary": stats.rays.primary,
            "shadow": stats.rays.shadow,
            "bounce": stats.rays.bounce,
        },
        "mray_per_second": stats.mray_per_second(),
        "kernel": {
            "calls": stats.kernel.calls,
            "evaluations": stats.kernel.evaluations,
            "calls_per_ray": stats.calls_per_ray(),
            "evaluations_per_call": stats.evaluations_per_call(),
        },
        "embree": { "version": device.version().to_string(), "isa": device.isa() },
    });
    format!("{value:#}\n")
}

fn named_times(stats: &RenderStats) -> [(&'static str, Duration); 4] {
    let times = stats.times;
    [
        ("load", times.load),
        ("curve", times.curve),
        ("build", times.build),
        ("render", times.render),
    ]
}

fn named_memory(stats: &RenderStats) -> [(&'static str, u64); 3] {
    let memory = stats.memory;
    [
        ("mesh", memory.mesh),
        ("records", memory.records),
        ("embree", memory.embree),
    ]
}

/// The most memory the program has had in its life, where the system tells (Linux does).
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kilobytes)
}

fn megabytes(bytes: u64) -> f64 {
    bytes as f64 * 1e-6
}
