//! Numbers as they are read.

use crate::output::short;
use maud::{Markup, html};

/// A number of three digits that knows all of its digits.
pub(super) fn number(value: f64) -> Markup {
    html! { data value=(value) { (minus(&short(value))) } }
}

/// The same with its sign.
pub(super) fn signed(value: f64) -> Markup {
    let sign = if value >= 0.0 { "+" } else { "" };
    html! { data value=(value) { (sign) (minus(&short(value))) } }
}

/// With a minus sign as wide as a plus sign.
fn minus(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

/// The number at a tick, which has few digits.
pub(super) fn tick(value: f64) -> String {
    let size = value.abs();
    if value != 0.0 && !(1e-4..1e6).contains(&size) {
        return minus(&format!("{value:.0e}"));
    }
    // Sums of steps such as 0.1 are not exact.
    minus(&((value * 1e9).round() / 1e9).to_string())
}

/// Bytes in the unit that suits them.
pub(super) fn bytes(count: u64) -> Markup {
    let count = count as f64;
    let (size, unit) = match count {
        c if c >= 1e9 => (1e9, "GB"),
        c if c >= 1e6 => (1e6, "MB"),
        _ => (1e3, "kB"),
    };
    html! { data value=(count) { (format!("{:.1}", count / size)) } " " (unit) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short() {
        let cases = [
            (0.1 + 0.2, "0.3"),
            (-20.0, "\u{2212}20"),
            (0.0, "0"),
            (1e-5, "1e\u{2212}5"),
        ];
        for (value, text) in cases {
            assert_eq!(tick(value), text);
        }
    }

    #[test]
    fn numbers_keep_their_digits() {
        let third = 1.0 / 3.0;
        let text = number(-third).into_string();
        assert_eq!(
            text,
            format!("<data value=\"{}\">\u{2212}0.333</data>", -third)
        );
        assert_eq!(
            bytes(1_500_000).into_string(),
            "<data value=\"1500000\">1.5</data> MB"
        );
    }
}
