// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers in messages, as a person would write them.

/// Six significant digits, with a power of ten only where there would be many zeros: `3.29505`, `0.04`, `1e300`.
pub(crate) fn number(value: f64) -> String {
    if value.is_infinite() {
        return if value > 0.0 { "infinity".into() } else { "-infinity".into() };
    }
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    let is_plain = rounded == 0.0 || rounded.is_nan() || (1e-4..1e6).contains(&rounded.abs());
    if is_plain { format!("{}", rounded + 0.0) } else { format!("{rounded:e}") }
}

/// Several, as `(1, 0.5, 0)`.
pub(crate) fn bracketed(values: impl IntoIterator<Item = f64>) -> String {
    let all: Vec<String> = values.into_iter().map(number).collect();
    format!("({})", all.join(", "))
}

#[cfg(test)]
mod tests {
    use super::{bracketed, number};

    #[test]
    fn numbers_are_written_as_people_write_them() {
        for (value, text) in [
            (3.295_049_267_592_471, "3.29505"),
            (-2.000_000_000_1, "-2"),
            (0.1 + 0.2, "0.3"),
            (123_456.7, "123457"),
            (999_999.9, "1e6"),
            (75_712_812_922.0, "7.57128e10"),
            (0.000_1, "0.0001"),
            (0.000_012_345_678, "1.23457e-5"),
            (5e-324, "5e-324"),
            (f64::MAX, "1.79769e308"),
            (0.0, "0"),
            (-0.0, "0"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "infinity"),
            (f64::NEG_INFINITY, "-infinity"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn several_stand_in_brackets() {
        assert_eq!(bracketed([1.0, 0.5, -0.25]), "(1, 0.5, -0.25)");
    }
}
