// SPDX-License-Identifier: GPL-3.0-or-later
//! What the WGSL declares is what the host gives it: bindings, structures, group sizes and workgroup memory, read from the
//! compiled source.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::mem::offset_of;

use isochor_gpu::kernels::{GROUP, Kernel};
use isochor_gpu::types::{Frame, Index, Status, Tile, Turn};
use naga::front::wgsl::parse_str;
use naga::proc::Layouter;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Module, TypeInner};

const TAPS: [[usize; 3]; 5] = [[4, 4, 4], [2, 8, 21], [3, 5, 3], [1, 4, 64], [64, 64, 64]];

/// Smallest workgroup memory that WebGPU allows an adapter.
const WORKGROUP_BYTES: u32 = 16384;

fn module(kernel: Kernel, taps: [usize; 3]) -> Module {
    let source = kernel.source(taps);
    let module = parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
    Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).unwrap();
    module
}

#[test]
fn bindings_are_the_resources_in_their_order() {
    for &kernel in Kernel::ALL {
        let module = module(kernel, [4, 4, 4]);
        let mut bound: Vec<(u32, u32, String)> = module
            .global_variables
            .iter()
            .filter_map(|(_, variable)| {
                let binding = variable.binding?;
                Some((binding.group, binding.binding, variable.name.clone()?))
            })
            .collect();
        bound.sort();
        let expected: Vec<(u32, u32, String)> = kernel
            .resources()
            .iter()
            .enumerate()
            .map(|(i, resource)| (0, i as u32, resource.name().to_owned()))
            .collect();
        assert_eq!(bound, expected, "{}", kernel.name());
    }
}

#[test]
fn group_sizes_and_entry_points_are_the_ones_dispatched() {
    for &kernel in Kernel::ALL {
        let module = module(kernel, [4, 4, 4]);
        assert_eq!(module.entry_points.len(), 1);
        let entry = &module.entry_points[0];
        assert_eq!(entry.name, kernel.name());
        // A group of `gather` does one control point, so its size is its own affair; see the twin.
        let threads = if kernel == Kernel::Gather { 64 } else { GROUP as u32 };
        assert_eq!(entry.workgroup_size, [threads, 1, 1], "{}", kernel.name());
    }
}

#[test]
fn every_degree_compiles_within_webgpus_workgroup_memory() {
    for taps in TAPS {
        for &kernel in Kernel::ALL {
            let module = module(kernel, taps);
            let mut layouter = Layouter::default();
            layouter.update(module.to_ctx()).unwrap();
            let shared = module.global_variables.iter().filter(|(_, v)| v.space == AddressSpace::WorkGroup);
            let bytes: u32 = shared.map(|(_, variable)| layouter[variable.ty].size).sum();
            assert!(bytes <= WORKGROUP_BYTES, "{} {taps:?}: {bytes}", kernel.name());
        }
    }
}

#[test]
fn storage_buffers_stay_within_webgpus_count() {
    for &kernel in Kernel::ALL {
        let module = module(kernel, [4, 4, 4]);
        let storage =
            module.global_variables.iter().filter(|(_, v)| matches!(v.space, AddressSpace::Storage { .. }));
        assert!(storage.count() <= 8, "{}", kernel.name());
    }
}

/// Names, offsets and size of a structure in the WGSL.
fn structure(name: &str) -> (Vec<(String, usize)>, usize) {
    let module = module(Kernel::Shift, [4, 4, 4]);
    let (_, found) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).unwrap();
    let TypeInner::Struct { members, span } = &found.inner else { panic!("{name} is no structure") };
    let member = |member: &naga::StructMember| (member.name.clone().unwrap(), member.offset as usize);
    (members.iter().map(member).collect(), *span as usize)
}

macro_rules! check {
    ($type:ident: $($member:ident),+) => {{
        let (members, span) = structure(stringify!($type));
        let expected = vec![$((stringify!($member).to_owned(), offset_of!($type, $member))),+];
        assert_eq!(members, expected, stringify!($type));
        assert_eq!(span, size_of::<$type>(), stringify!($type));
    }};
}

#[test]
fn structures_have_one_layout() {
    check!(Turn: axis, last, done, unused);
    check!(Frame: to_frame, from_frame, turns, middle, shape, wanted, amount, balanced, flat_axis, no_volume, zero, negligible);
    check!(Index: turn);
    check!(Tile: first_slot, slots, first_point, knots_u, knots_v, knots_w);
    check!(Status: volume, steep, left_to_cpu);
}
