// SPDX-License-Identifier: GPL-3.0-or-later
//! The device that the tests run on.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::panic,
    reason = "each test crate uses its own part, and fails by panicking"
)]

use std::sync::Arc;

use isochor_gpu::{Choice, Device};

/// Opens the best adapter, a software rasteriser included, and says which. Without one: a failure where CI is set, elsewhere
/// `None` and a loud line.
pub fn device() -> Option<Arc<Device>> {
    match Device::open(Choice::Any) {
        Ok(device) => {
            println!("adapter: {:?}", device.adapter());
            Some(device)
        }
        Err(reason) if std::env::var_os("CI").is_some() => panic!("CI must test the GPU path: {reason}"),
        Err(reason) => {
            eprintln!("!!!! SKIPPED, NOT TESTED: {reason} !!!!");
            None
        }
    }
}
