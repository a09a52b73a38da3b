// SPDX-License-Identifier: GPL-3.0-or-later
//! What a device that fails says. One test a process state, so they run one after the other.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../core/tests/shared/mod.rs"]
mod shared;

mod device;

use std::sync::Mutex;

use isochor_core::{Binding, Outside, Preserve};
use isochor_gpu::{Choice, Device, Error, Failure, Mesh};
use shared::{bases, bumpy_ball, slanted};

/// The faults are environment variables of the process.
static ALONE: Mutex<()> = Mutex::new(());

fn binding() -> Binding<f32> {
    let ball = bumpy_ball(3);
    let single = ball.vertices.iter().map(|p| p.map(|c| c as f32)).collect();
    Binding::new(slanted(bases().swap_remove(2).1), single, ball.triangles, None, Outside::Keep).unwrap()
}

fn with_variable<R>(name: &str, value: &str, f: impl FnOnce() -> R) -> R {
    // SAFETY: every test of this file that reads or writes the environment holds `ALONE`.
    unsafe { std::env::set_var(name, value) };
    let result = f();
    // SAFETY: as above.
    unsafe { std::env::remove_var(name) };
    result
}

#[test]
fn a_lost_device_says_so_and_opens_again() {
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let Some(device) = device::device() else { return };
    let binding = binding();
    let mesh = Mesh::new(device.clone(), &binding).unwrap();
    let mut out = binding.vertices().to_vec();
    let control = binding.lattice().rest();
    let mut frame = |mesh: &Mesh| mesh.preserve(&binding, &control, &Preserve::default(), &mut out);
    frame(&mesh).unwrap();
    let lost = with_variable("ISOCHOR_GPU_FAULT", "lost", || frame(&mesh));
    assert!(matches!(lost, Err(Failure::Device(Error::Lost(_)))), "{lost:?}");
    let again = frame(&mesh);
    assert!(matches!(again, Err(Failure::Device(Error::Lost(_)))), "{again:?}");
    assert!(matches!(Mesh::new(device, &binding), Err(Error::Lost(_))));
    let reopened = Device::open(Choice::Any).unwrap();
    frame(&Mesh::new(reopened, &binding).unwrap()).unwrap();
}

#[test]
fn a_mesh_beyond_the_limits_is_named() {
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let Some(device) = device::device() else { return };
    let made = with_variable("ISOCHOR_GPU_BUFFER_LIMIT", "1000", || Mesh::new(device.clone(), &binding()));
    let Err(Error::TooLarge(message)) = made else { unreachable!("a mesh of a thousand bytes") };
    assert!(message.contains("expected at most the 1000"), "{message}");
    Mesh::new(device, &binding()).unwrap();
}

#[test]
fn full_memory_is_named_and_leaves_the_device_in_order() {
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let Some(device) = device::device() else { return };
    let made = with_variable("ISOCHOR_GPU_FAULT", "memory", || Mesh::new(device.clone(), &binding()));
    assert!(matches!(made, Err(Error::OutOfMemory(_))));
    Mesh::new(device, &binding()).unwrap();
}

#[test]
fn an_unknown_adapter_is_named_with_those_there() {
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let Err(Error::NoAdapter(message)) = Device::open(Choice::Named("Voodoo 2")) else {
        unreachable!("no such card is left")
    };
    assert!(message.contains("Voodoo 2"), "{message}");
}
