// SPDX-License-Identifier: GPL-3.0-or-later
//! Laws of the fold test: what it proves is so, and what it finds is there.

use crate::shared::{bases, noise, slanted};
use isochor_core::{AxisBasis, DEPTH, DMat3, DVec3, FoldTest, Lattice, Verdict};

/// Control points moved at random by up to `amount` of their spacing.
fn moved(lattice: &Lattice, amount: f64, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    let spacing = lattice.shape().map(|count| 1.0 / count as f64);
    let mut any = || amount * DVec3::new(random(), random(), random()) * DVec3::from_array(spacing);
    lattice.rest().iter().map(|p| p + lattice.edges() * any()).collect()
}

/// The determinant of the derivative, in units of the frame's, by central differences of the map itself. The differences stay
/// in the domain.
fn determinant(lattice: &Lattice, control: &[DVec3], at: DVec3) -> f64 {
    let step = 1e-6;
    let at = at.clamp(DVec3::splat(step), DVec3::splat(1.0 - step));
    let sides: Vec<DVec3> =
        DVec3::AXES.iter().flat_map(|axis| [at + axis * step, at - axis * step]).collect();
    let points = lattice.evaluate(&sides, control).unwrap();
    let [s, t, u] = [0, 2, 4].map(|i| (points[i] - points[i + 1]) / (2.0 * step));
    DMat3::from_cols(s, t, u).determinant() / lattice.edges().determinant()
}

fn under(lattice: &Lattice, matrix: DMat3) -> Vec<DVec3> {
    lattice.rest().into_iter().map(|p| matrix * p + DVec3::new(5.0, -3.0, 0.5)).collect()
}

#[test]
fn affine_maps_are_unfolded_and_mirrored_ones_folded_everywhere() {
    let matrix =
        DMat3::from_cols(DVec3::new(0.3, 1.1, -0.2), DVec3::new(-0.9, 0.4, 0.1), DVec3::new(0.2, 0.3, 2.0));
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        for matrix in [DMat3::IDENTITY, matrix, matrix * 1e-9, matrix * 1e60, matrix * 1e-60] {
            let control = under(&lattice, matrix);
            let found = lattice.folds(&control, None, DEPTH).unwrap();
            // Beside an offset of 5, a size of 1e-60 is nothing.
            let is_lost = matrix.x_axis.length() < 1e-30;
            let expected = if is_lost { Verdict::Undecided } else { Verdict::Unfolded };
            assert_eq!(found.verdict, expected, "{name} under {matrix}");
            assert_eq!(lattice.is_unfolded(&control, None).unwrap(), expected == Verdict::Unfolded);
        }
        let mirrored = matrix * DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
        let found = lattice.folds(&under(&lattice, mirrored), None, DEPTH).unwrap();
        assert_eq!(found.verdict, Verdict::Folded, "{name}");
        assert!(found.parameters.len() >= 16 * 16 * 16, "{name}: {}", found.parameters.len());
        // Measured from a mirrored rest shape, it is the plain one that folds.
        let rest = under(&lattice, mirrored);
        let verdict = |control: &[DVec3]| lattice.folds(control, Some(&rest), DEPTH).unwrap().verdict;
        assert_eq!(verdict(&under(&lattice, mirrored * 0.5)), Verdict::Unfolded, "{name}");
        assert_eq!(verdict(&lattice.rest()), Verdict::Folded, "{name}");
    }
}

#[test]
fn no_proof_against_a_sample_and_no_fold_without_a_wrong_determinant() {
    let mut verdicts = [0; 3];
    for (case, (name, axes)) in bases().into_iter().enumerate() {
        let lattice = slanted(axes);
        let test = FoldTest::new(&lattice, None).unwrap();
        for step in 0..40_u32 {
            let seed = 1000 * case as u64 + u64::from(step);
            let control = moved(&lattice, 0.05 * f64::from(step + 1), seed);
            let found = test.folds(&control, DEPTH).unwrap();
            verdicts[found.verdict as usize] += 1;
            assert_eq!(test.is_unfolded(&control).unwrap(), found.verdict == Verdict::Unfolded);
            let mut random = noise(seed + 7);
            for _ in 0..200 {
                let at = (DVec3::new(random(), random(), random()) + 1.0) * 0.5;
                let here = determinant(&lattice, &control, at);
                assert!(found.verdict == Verdict::Folded || here > -1e-7, "{name} {step}: {here} at {at}");
            }
            for &at in found.parameters.iter().step_by(29) {
                let here = determinant(&lattice, &control, at);
                assert!(here < 1e-3, "{name} {step}: {here} at {at}");
            }
        }
    }
    println!("unfolded, folded, undecided: {verdicts:?}");
    assert!(verdicts[0] > 60 && verdicts[1] > 60 && verdicts[2] < 3, "{verdicts:?}");
}

#[test]
fn a_fold_by_a_hair_is_told_from_none() {
    // x = s + a s (1 - s) (1 - 2 s): its slope is 1 + a at the ends, and 1 - a / 2, the least, in the middle.
    let axes =
        [AxisBasis::bernstein(4), AxisBasis::bernstein(3), AxisBasis::bernstein(2)].map(Result::unwrap);
    let lattice = Lattice::new(axes, DVec3::ZERO, DMat3::IDENTITY).unwrap();
    let bent = |a: f64| {
        let x = [0.0, (1.0 + a) / 3.0, (2.0 - a) / 3.0, 1.0];
        let place = |(i, p): (usize, DVec3)| DVec3::new(x[i / 6], p.y, p.z);
        lattice.rest().into_iter().enumerate().map(place).collect::<Vec<_>>()
    };
    for hair in [1e-1, 1e-3, 1e-6, 1e-9] {
        assert!(lattice.is_unfolded(&bent(2.0 - hair), None).unwrap(), "{hair}");
        let found = lattice.folds(&bent(2.0 + hair), None, DEPTH).unwrap();
        assert_eq!(found.verdict, Verdict::Folded, "{hair}");
        assert!(found.parameters.iter().all(|p| (p.x - 0.5).abs() < hair.sqrt()), "{hair}");
    }
    let found = lattice.folds(&bent(2.0), None, DEPTH).unwrap();
    assert_eq!((found.verdict, found.undecided.len()), (Verdict::Undecided, 1));
    assert!((found.undecided[0].x - 0.5).abs() < 1e-3, "{:?}", found.undecided);
}

#[test]
fn flat_shapes_are_undecided_and_a_bend_past_a_full_turn_is_unfolded() {
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        for turn in [DMat3::IDENTITY, turn] {
            let flat = under(&lattice, turn * DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0)));
            assert_eq!(lattice.folds(&flat, None, 4).unwrap().verdict, Verdict::Undecided, "{name}");
        }
    }
    let lattice = slanted(std::array::from_fn(|axis| AxisBasis::uniform([24, 5, 4][axis], 3).unwrap()));
    let bent = lattice.rest().into_iter().map(|p| {
        let s = lattice.parameter(p);
        let (sin, cos) = (s.x * 7.5).sin_cos();
        DVec3::new((3.0 - s.y) * sin, (s.y - 3.0) * cos, s.z)
    });
    let bent: Vec<DVec3> = bent.collect();
    assert_eq!(lattice.folds(&bent, None, DEPTH).unwrap().verdict, Verdict::Unfolded);
}

#[test]
fn the_same_on_any_number_of_threads() {
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::clamped(9, 3).unwrap()));
    let control = moved(&lattice, 1.5, 3);
    let all = lattice.folds(&control, None, DEPTH).unwrap();
    assert_eq!(all.verdict, Verdict::Folded);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| lattice.folds(&control, None, DEPTH).unwrap()), all);
}

#[test]
#[ignore = "a measurement"]
fn how_long_it_takes() {
    let cube = |axis: fn() -> AxisBasis| slanted(std::array::from_fn(|_| axis()));
    for (name, lattice) in [
        ("Bernstein 4^3", cube(|| AxisBasis::bernstein(4).unwrap())),
        ("Bernstein 8^3", cube(|| AxisBasis::bernstein(8).unwrap())),
        ("uniform 10^3", cube(|| AxisBasis::uniform(10, 3).unwrap())),
        ("clamped 20^3", cube(|| AxisBasis::clamped(20, 3).unwrap())),
        ("Bernstein 21^3", cube(|| AxisBasis::bernstein(21).unwrap())),
    ] {
        let test = FoldTest::new(&lattice, None).unwrap();
        let flat = under(&lattice, DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0)));
        let shapes = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0].map(|amount| (amount, moved(&lattice, amount, 1)));
        for (amount, control) in shapes.into_iter().chain([(f64::NAN, flat)]) {
            let start = std::time::Instant::now();
            let (mut rounds, mut proved) = (0, false);
            while rounds < 3 || start.elapsed().as_millis() < 100 && rounds < 1000 {
                proved = test.is_unfolded(&control).unwrap();
                rounds += 1;
            }
            let cheap = start.elapsed().as_secs_f64() * 1e6 / f64::from(rounds);
            let start = std::time::Instant::now();
            let found = test.folds(&control, DEPTH).unwrap();
            let whole = start.elapsed().as_secs_f64() * 1e6;
            println!(
                "{name}, moved by {amount}: proved {proved} in {cheap:.0} us; {:?}, {} and {} in {whole:.0} us",
                found.verdict,
                found.parameters.len(),
                found.undecided.len()
            );
        }
    }
}
