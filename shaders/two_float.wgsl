// SPDX-License-Identifier: GPL-3.0-or-later
// Sums of float32 numbers with the rounding error carried along: a two-float (x, y) stands for x + y, |y| <= ulp(x) / 2.
// (D. Knuth, TAOCP 2, 4.2.2; T. Dekker, Numer. Math. 18, 1971.) Expects `frame` to be bound.

// The same number, in a way that no compiler sees through: these sums vanish where (a + b) - a is simplified to b.
fn opaque(a: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(a) ^ frame.zero);
}

// a + b, exactly.
fn two_sum(a: f32, b: f32) -> vec2f {
    let sum = opaque(a + b);
    let part = opaque(sum - a);
    return vec2f(sum, opaque(a - opaque(sum - part)) + opaque(b - part));
}

// a + b, exactly, where |a| >= |b|.
fn quick_two_sum(a: f32, b: f32) -> vec2f {
    let sum = opaque(a + b);
    return vec2f(sum, b - opaque(sum - a));
}

fn add_float(a: vec2f, b: f32) -> vec2f {
    let sum = two_sum(a.x, b);
    return quick_two_sum(sum.x, sum.y + a.y);
}

fn add(a: vec2f, b: vec2f) -> vec2f {
    let sum = two_sum(a.x, b.x);
    return quick_two_sum(sum.x, sum.y + (a.y + b.y));
}
