//! Numbers formatted for readers.

use std::time::Duration;

/// A duration in milliseconds.
pub(crate) fn millis(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// A count with separated thousands: `1,157,529`.
pub(crate) fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index) % 3 == 0 {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Bytes with a suitable unit.
pub(crate) fn bytes(number: u64) -> String {
    match number {
        0..10_000 => format!("{number} B"),
        10_000..1_000_000 => format!("{:.1} kB", number as f64 / 1e3),
        _ => format!("{:.1} MB", number as f64 / 1e6),
    }
}

/// A count with a noun in the singular or plural.
pub(crate) fn of(number: u64, one: &str, many: &str) -> String {
    format!("{} {}", count(number), if number == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_stand_apart() {
        let texts = [0, 12, 999, 1000, 1_157_529].map(count);
        assert_eq!(texts, ["0", "12", "999", "1,000", "1,157,529"]);
        assert_eq!([512, 20_000, 123_456_789].map(bytes), ["512 B", "20.0 kB", "123.5 MB"]);
        assert_eq!(of(1, "mesh", "meshes"), "1 mesh");
    }
}
