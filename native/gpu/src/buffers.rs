// SPDX-License-Identifier: GPL-3.0-or-later
//! The buffers of a mesh on a device, and the groups in which kernels bind them. Made once; a frame makes none.

use std::collections::HashMap;

use wgpu::BufferUsages as Usage;

use crate::device::{Device, Pipelines};
use crate::error::{Error, Result};
use crate::faults;
use crate::kernels::{Kernel, Resource};
use crate::pack::Packed;
use crate::types::{Frame, Index, Status};

/// Turns of a correction at most.
pub(crate) const TURNS: usize = 3;

/// Distance between the turns' indices in their buffer: the largest alignment that an adapter may ask for.
const INDEX_STRIDE: usize = 256;

/// All buffers that kernels bind, and the bind groups of every kernel for every turn.
pub(crate) struct Buffers {
    buffers: HashMap<Resource, wgpu::Buffer>,
    groups: HashMap<Kernel, [wgpu::BindGroup; TURNS]>,
}

/// How a buffer starts.
enum Content<'a> {
    Bytes(&'a [u8]),
    Room(usize),
}

impl Buffers {
    /// Uploads a packed binding.
    ///
    /// # Errors
    /// [`Error::TooLarge`] before anything is made, [`Error::OutOfMemory`], or that the device is lost.
    pub(crate) fn new(device: &Device, pipelines: &Pipelines, packed: &Packed<'_>) -> Result<Self> {
        let indices = turn_indices();
        let content = |resource| content_of(resource, packed, &indices);
        for &resource in Resource::ALL {
            check_size(device, resource, content(resource).len())?;
        }
        if faults::is_wanted("memory") {
            return Err(Error::OutOfMemory("GPU: out of memory: as ISOCHOR_GPU_FAULT asks for".into()));
        }
        let buffers: HashMap<Resource, wgpu::Buffer> = device.scoped(|| {
            let made = |&resource: &Resource| (resource, create(device, resource, &content(resource)));
            Resource::ALL.iter().map(made).collect()
        })?;
        let groups = device.scoped(|| {
            let made = |&kernel: &Kernel| {
                (kernel, std::array::from_fn(|turn| bind(device, pipelines, &buffers, kernel, turn)))
            };
            Kernel::ALL.iter().map(made).collect()
        })?;
        Ok(Self { buffers, groups })
    }

    pub(crate) fn of(&self, resource: Resource) -> &wgpu::Buffer {
        &self.buffers[&resource]
    }

    /// Bytes of all buffers together.
    pub(crate) fn bytes(&self) -> u64 {
        self.buffers.values().map(wgpu::Buffer::size).sum()
    }

    pub(crate) fn group(&self, kernel: Kernel, turn: usize) -> &wgpu::BindGroup {
        &self.groups[&kernel][turn]
    }
}

impl Content<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Bytes(bytes) => bytes.len(),
            Self::Room(bytes) => *bytes,
        }
    }
}

fn turn_indices() -> Vec<u8> {
    let mut bytes = vec![0; TURNS * INDEX_STRIDE];
    for turn in 0..TURNS {
        let index = Index { turn: turn as u32 };
        bytes[turn * INDEX_STRIDE..][..size_of::<Index>()].copy_from_slice(bytemuck::bytes_of(&index));
    }
    bytes
}

fn content_of<'a>(resource: Resource, packed: &'a Packed<'_>, indices: &'a [u8]) -> Content<'a> {
    use bytemuck::cast_slice;
    const FLOAT: usize = size_of::<f32>();
    let (points, slots) = (packed.points(), packed.slots());
    match resource {
        Resource::Frame => Content::Room(size_of::<Frame>()),
        Resource::Index => Content::Bytes(indices),
        Resource::Tiles => Content::Bytes(cast_slice(&packed.tiles)),
        Resource::Runs => Content::Bytes(cast_slice(&packed.runs)),
        Resource::Knots => Content::Bytes(cast_slice(&packed.knots)),
        Resource::Places => Content::Bytes(cast_slice(&packed.places)),
        Resource::Rest => Content::Bytes(cast_slice(&packed.rest)),
        Resource::Offsets => Content::Bytes(cast_slice(&packed.offsets)),
        Resource::Steps => Content::Bytes(cast_slice(packed.steps)),
        Resource::Starts => Content::Bytes(cast_slice(&packed.starts)),
        Resource::Entries => Content::Bytes(cast_slice(&packed.entries)),
        Resource::SlotOfVertex => Content::Bytes(cast_slice(packed.slot_of_vertex)),
        Resource::Controls => Content::Room(points * 4 * FLOAT),
        Resource::State => Content::Room(3 * slots * FLOAT),
        Resource::Pull => Content::Room(slots * FLOAT),
        Resource::Volumes => Content::Room(packed.groups() * 2 * FLOAT),
        Resource::Partials => Content::Room(packed.runs.len() * packed.cell_taps() * FLOAT),
        Resource::Coefficients => Content::Room(points * 2 * FLOAT),
        Resource::Delta => Content::Room(TURNS * points * FLOAT),
        Resource::Status => Content::Room(TURNS * size_of::<Status>()),
        Resource::Moved => Content::Room(3 * packed.slot_of_vertex.len() * FLOAT),
    }
}

fn check_size(device: &Device, resource: Resource, bytes: usize) -> Result<()> {
    let limit = device.buffer_limit();
    if bytes as u64 <= limit {
        return Ok(());
    }
    Err(Error::TooLarge(format!(
        "GPU: the mesh needs {bytes} bytes for {:?}, expected at most the {limit} that a buffer of {:?} holds; use the CPU, or fewer vertices",
        resource.name(),
        device.adapter().name
    )))
}

fn usage(resource: Resource) -> Usage {
    match resource {
        Resource::Frame => Usage::UNIFORM | Usage::COPY_DST,
        Resource::Index => Usage::UNIFORM | Usage::COPY_DST,
        Resource::Controls => Usage::STORAGE | Usage::COPY_DST,
        // Results can be looked at, by a frame or by a test.
        _ => Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST,
    }
}

fn create(device: &Device, resource: Resource, content: &Content<'_>) -> wgpu::Buffer {
    let buffer = device.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(resource.name()),
        size: content.len() as u64,
        usage: usage(resource),
        mapped_at_creation: false,
    });
    if let Content::Bytes(bytes) = content {
        device.queue.write_buffer(&buffer, 0, bytes);
    }
    buffer
}

fn bind(
    device: &Device,
    pipelines: &Pipelines,
    buffers: &HashMap<Resource, wgpu::Buffer>,
    kernel: Kernel,
    turn: usize,
) -> wgpu::BindGroup {
    let resource = |resource: &Resource| match resource {
        Resource::Index => wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &buffers[resource],
            offset: (turn * INDEX_STRIDE) as u64,
            size: wgpu::BufferSize::new(size_of::<Index>() as u64),
        }),
        _ => buffers[resource].as_entire_binding(),
    };
    let entries: Vec<wgpu::BindGroupEntry<'_>> = kernel
        .resources()
        .iter()
        .enumerate()
        .map(|(binding, name)| wgpu::BindGroupEntry { binding: binding as u32, resource: resource(name) })
        .collect();
    device.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(kernel.name()),
        layout: &pipelines.of(kernel).get_bind_group_layout(0),
        entries: &entries,
    })
}
