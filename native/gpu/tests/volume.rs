// SPDX-License-Identifier: GPL-3.0-or-later
//! The volume is kept on the device, measured in float64 on the vertices that come out.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../core/tests/shared/mod.rs"]
mod shared;

mod device;

use isochor_core::{AxisBasis, Binding, DVec3, Error, Lattice, Method, Outside, Preserve};
use isochor_gpu::{Failure, Mesh, TOLERANCE, Work};
use shared::{bases, bumpy_ball, noise, slanted};

const SHARES: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 2.0, 0.0]];

fn single(mesh: &shared::Mesh) -> Vec<[f32; 3]> {
    mesh.vertices.iter().map(|p| p.map(|c| c as f32)).collect()
}

fn bind(lattice: &Lattice, mesh: &shared::Mesh) -> Binding<f32> {
    Binding::new(lattice.clone(), single(mesh), mesh.triangles.clone(), None, Outside::Keep).unwrap()
}

fn squash(lattice: &Lattice, factor: f64) -> Vec<DVec3> {
    let mut random = noise(3);
    let mut nudge = || 0.03 * DVec3::new(random(), random(), random());
    lattice.rest().iter().map(|p| DVec3::new(p.x * factor.sqrt(), p.y, p.z * factor) + nudge()).collect()
}

fn largest_difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn the_bouncing_balls_table_holds_on_the_device() {
    let Some(device) = device::device() else { return };
    let mesh = bumpy_ball(4);
    let mut closings = 0;
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let binding = bind(&lattice, &mesh);
        let on_device = Mesh::new(device.clone(), &binding).unwrap();
        let mut cpu = single(&mesh);
        let mut out = single(&mesh);
        // The loss is 1 - factor^1.5 but for the noise: up to 85 %, none, and a gain.
        for factor in [0.28, 0.6, 1.0, 2.5] {
            let control = squash(&lattice, factor);
            for method in [Method::Sweep, Method::Balanced] {
                for axes in SHARES {
                    let label = format!("{name} {factor} {method:?} {axes:?}");
                    let options = Preserve { axes, method, ..Preserve::default() };
                    let outcome = on_device.preserve(&binding, &control, &options, &mut out).unwrap();
                    assert_ne!(outcome.work, Work::Cpu, "{label}");
                    closings += usize::from(outcome.work == Work::DeviceAndClosing);
                    let target = outcome.preserved.target;
                    let error = (binding.measure(&out).unwrap().volume / target - 1.0).abs();
                    assert!(error <= TOLERANCE, "{label}: {error:e}");
                    let reference = binding.preserve(&control, &options, &mut cpu).unwrap();
                    assert!((target / reference.target - 1.0).abs() < 1e-12, "{label}");
                    let apart = largest_difference(&out, &cpu);
                    assert!(apart < 2e-5, "{label}: {apart:e} from the CPU");
                    for (corrected, asked) in outcome.preserved.control.iter().zip(&control) {
                        for axis in (0..3).filter(|&a| axes[a] == 0.0) {
                            assert_eq!(corrected[axis].to_bits(), asked[axis].to_bits());
                        }
                    }
                }
            }
        }
    }
    // The closing step is for hard cases; on these the device alone must do.
    assert_eq!(closings, 0, "of {} corrections", bases().len() * 32);
}
