//! The machine and the date of a measurement.

use std::time::{SystemTime, UNIX_EPOCH};

/// The name of the processor as its maker writes it, or else its architecture.
pub(crate) fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name"));
    let name = line.and_then(|line| line.split_once(':')).map(|(_, name)| name.trim().to_owned());
    name.unwrap_or_else(|| format!("{} processor", std::env::consts::ARCH))
}

/// The number of hardware threads.
pub(crate) fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Bytes of a core's second-level cache, or 1 MiB if the system does not tell.
pub(crate) fn second_cache() -> usize {
    let text = std::fs::read_to_string("/sys/devices/system/cpu/cpu0/cache/index2/size").unwrap_or_default();
    let kilobytes = text.trim().strip_suffix('K').and_then(|number| number.parse::<usize>().ok());
    kilobytes.map_or(1 << 20, |kilobytes| kilobytes << 10)
}

/// The versions of the engines in the lock file of this program. Embree reports its version itself.
pub(crate) fn versions() -> String {
    const LOCK: &str = include_str!("../../../Cargo.lock");
    let version = |name: &str| {
        let start = LOCK.find(&format!("name = \"{name}\"\nversion = \""))?;
        LOCK[start..].split('"').nth(3).map(|version| format!("{name} {version}"))
    };
    let names: [(&str, bool); 5] = [
        ("kinetree", true),
        ("tinybvh-rs", cfg!(feature = "tinybvh")),
        ("obvhs", cfg!(feature = "obvhs")),
        ("parry3d", cfg!(feature = "parry3d")),
        ("bvh", cfg!(feature = "bvh")),
    ];
    let text: Vec<String> =
        names.into_iter().filter(|(_, there)| *there).filter_map(|(name, _)| version(name)).collect();
    text.join(", ").replace("tinybvh-rs ", "tinybvh 1.6.8 through tinybvh-rs ")
}

/// The name of the machine as a folder name: processor and number of threads.
pub(crate) fn folder_name() -> String {
    let name: String = format!("{} x{}", processor(), threads())
        .to_lowercase()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { ' ' })
        .collect();
    name.split_whitespace().filter(|word| !["r", "tm", "cpu"].contains(word)).collect::<Vec<_>>().join("-")
}

/// Today's date in UTC, such as `2026-01-31`.
pub(crate) fn date() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs());
    date_of(seconds / 86_400)
}

/// The Gregorian date of a number of days since 1970-01-01 (Hinnant 2013, "chrono-Compatible
/// Low-Level Date Algorithms").
fn date_of(days: u64) -> String {
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{:04}-{month:02}-{day:02}", year + era * 400 + next)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_named() {
        let versions = versions();
        assert!(versions.starts_with(concat!("kinetree ", env!("CARGO_PKG_VERSION"))), "{versions}");
        assert_eq!(versions.contains("obvhs 0."), cfg!(feature = "obvhs"), "{versions}");
    }

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (days, date) in [(0, "1970-01-01"), (59, "1970-03-01"), (11_016, "2000-02-29"), (20_454, "2026-01-01")] {
            assert_eq!(date_of(days), date);
        }
    }
}
