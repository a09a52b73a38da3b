// SPDX-License-Identifier: GPL-3.0-or-later
//! Twin of `two_float.wgsl`: sums of float32 numbers with the rounding error carried along.

/// `x + y` with `|y| <= ulp(x) / 2`.
pub type TwoFloat = [f32; 2];

/// `a + b`, exactly (Knuth).
pub fn two_sum(a: f32, b: f32) -> TwoFloat {
    let sum = a + b;
    let part = sum - a;
    [sum, (a - (sum - part)) + (b - part)]
}

/// `a + b`, exactly, where `|a| >= |b|` (Dekker).
pub fn quick_two_sum(a: f32, b: f32) -> TwoFloat {
    let sum = a + b;
    [sum, b - (sum - a)]
}

/// Adds a float.
pub fn add_float(a: TwoFloat, b: f32) -> TwoFloat {
    let sum = two_sum(a[0], b);
    quick_two_sum(sum[0], sum[1] + a[1])
}

/// Adds a two-float.
pub fn add(a: TwoFloat, b: TwoFloat) -> TwoFloat {
    let sum = two_sum(a[0], b[0]);
    quick_two_sum(sum[0], sum[1] + (a[1] + b[1]))
}

/// The nearest two-float.
pub fn from_f64(value: f64) -> TwoFloat {
    let high = value as f32;
    [high, (value - f64::from(high)) as f32]
}

/// Its value.
pub fn to_f64(value: TwoFloat) -> f64 {
    f64::from(value[0]) + f64::from(value[1])
}
