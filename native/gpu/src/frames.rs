// SPDX-License-Identifier: GPL-3.0-or-later
//! One frame: control points in, all turns, vertices out, in one submission. Nothing is made on the device for it.

use std::sync::{Arc, mpsc};
use std::time::Duration;

use crate::buffers::{Buffers, TURNS};
use crate::device::{Device, Pipelines};
use crate::error::{Error, Result};
use crate::faults;
use crate::kernels::{GROUP, Kernel, Resource};
use crate::pack::Packed;
use crate::types::{Frame, Status};

/// Bytes before the control points in the upload: room for the frame, a multiple of every alignment.
const HEADER: usize = 256;

/// A device that does not answer for so long counts as lost; drivers reset a card that hangs for two to ten seconds.
const PATIENCE: Duration = Duration::from_secs(60);

/// Bytes of the two time stamps.
const STAMPS: usize = 2 * size_of::<u64>();

/// Groups of every kernel.
struct Dispatches {
    tiles: [u32; 3],
    groups: [u32; 3],
    runs: [u32; 3],
    points: [u32; 3],
    vertices: [u32; 3],
}

impl Dispatches {
    fn of(&self, kernel: Kernel) -> [u32; 3] {
        match kernel {
            Kernel::Deform | Kernel::Shift => self.tiles,
            Kernel::Gradient => self.groups,
            Kernel::Reduce => self.runs,
            Kernel::Gather => self.points,
            Kernel::Solve => [1, 1, 1],
            Kernel::Write => self.vertices,
        }
    }
}

/// Everything that frames of one mesh use, made once.
pub(crate) struct Frames {
    device: Arc<Device>,
    pipelines: Arc<Pipelines>,
    buffers: Buffers,
    dispatches: Dispatches,
    /// Mapped between frames.
    upload: wgpu::Buffer,
    /// Not mapped between frames.
    readback: wgpu::Buffer,
    stamps: Option<Stamps>,
    points: usize,
    vertices: usize,
}

struct Stamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Nanoseconds of one tick.
    period: f64,
}

/// What a frame gave, as it lies in memory that the device wrote.
pub(crate) struct Reading<'a> {
    pub(crate) status: &'a [Status],
    /// Steps of the control points, one row a turn.
    pub(crate) delta: &'a [f32],
    /// How far every vertex moved.
    pub(crate) moved: &'a [[f32; 3]],
    /// Seconds that the kernels took, where the device keeps time.
    pub(crate) seconds: Option<f64>,
}

impl Frames {
    /// Uploads a packed binding and makes what its frames need.
    pub(crate) fn new(device: &Arc<Device>, packed: &Packed<'_>) -> Result<Self> {
        let pipelines = device.pipelines(packed.taps)?;
        let buffers = Buffers::new(device, &pipelines, packed)?;
        let (points, vertices) = (packed.points(), packed.slot_of_vertex.len());
        let limit = device.device.limits().max_compute_workgroups_per_dimension as usize;
        let columns = packed.taps[1] * packed.taps[2];
        let [tiles, groups, runs, all_points, all_vertices] =
            [packed.tiles.len(), packed.groups(), packed.runs.len(), points, vertices.div_ceil(GROUP)]
                .map(|count| spread(count, limit));
        let make = |label, size: usize, usage, mapped_at_creation| {
            let size = size as u64;
            device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation,
            })
        };
        use wgpu::BufferUsages as Usage;
        device.scoped(|| Self {
            device: Arc::clone(device),
            pipelines,
            buffers,
            dispatches: Dispatches {
                tiles,
                groups,
                runs: [runs[0], runs[1], columns.div_ceil(GROUP) as u32],
                points: all_points,
                vertices: all_vertices,
            },
            upload: make("upload", HEADER + points * 16, Usage::MAP_WRITE | Usage::COPY_SRC, true),
            readback: make(
                "readback",
                Sections::new(points, vertices).end,
                Usage::MAP_READ | Usage::COPY_DST,
                false,
            ),
            stamps: device.device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| Stamps {
                queries: device.device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("stamps"),
                    ty: wgpu::QueryType::Timestamp,
                    count: 2,
                }),
                resolved: make("stamps", STAMPS, Usage::QUERY_RESOLVE | Usage::COPY_SRC, false),
                period: f64::from(device.queue.get_timestamp_period()),
            }),
            points,
            vertices,
        })
    }

    /// Runs a frame of so many turns and shows `read` what it gave. Not for two threads at once.
    pub(crate) fn run<R>(
        &self,
        frame: &Frame,
        controls: &[[f32; 4]],
        turns: usize,
        read: impl FnOnce(Reading<'_>) -> R,
    ) -> Result<R> {
        if faults::is_wanted("lost") {
            self.device.lose();
        }
        self.device.check()?;
        self.send(frame, controls)?;
        let submission = self.device.queue.submit([self.encode(turns)]);
        let mapped = [(&self.readback, wgpu::MapMode::Read), (&self.upload, wgpu::MapMode::Write)];
        self.wait(submission, &mapped)?;
        let view = self.readback.slice(..).get_mapped_range().map_err(|cause| lost(&cause))?;
        let result = read(self.reading(&view));
        drop(view);
        self.readback.unmap();
        Ok(result)
    }

    /// Writes what changes into the mapped upload.
    fn send(&self, frame: &Frame, controls: &[[f32; 4]]) -> Result<()> {
        let mut view = self.upload.slice(..).get_mapped_range_mut().map_err(|cause| lost(&cause))?;
        view.slice(..size_of::<Frame>()).copy_from_slice(bytemuck::bytes_of(frame));
        view.slice(HEADER..).copy_from_slice(bytemuck::cast_slice(controls));
        drop(view);
        self.upload.unmap();
        Ok(())
    }

    fn encode(&self, turns: usize) -> wgpu::CommandBuffer {
        let buffers = &self.buffers;
        let mut encoder = self
            .device
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") });
        let (frame, controls) = (buffers.of(Resource::Frame), buffers.of(Resource::Controls));
        encoder.copy_buffer_to_buffer(&self.upload, 0, frame, 0, frame.size());
        encoder.copy_buffer_to_buffer(&self.upload, HEADER as u64, controls, 0, controls.size());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("frame"),
            timestamp_writes: self.stamps.as_ref().map(|stamps| wgpu::ComputePassTimestampWrites {
                query_set: &stamps.queries,
                beginning_of_pass_write_index: Some(0),
                end_of_pass_write_index: Some(1),
            }),
        });
        let mut dispatch = |kernel, turn| {
            let [x, y, z] = self.dispatches.of(kernel);
            pass.set_pipeline(self.pipelines.of(kernel));
            pass.set_bind_group(0, buffers.group(kernel, turn), &[]);
            pass.dispatch_workgroups(x, y, z);
        };
        dispatch(Kernel::Deform, 0);
        for turn in 0..turns {
            dispatch(Kernel::Gradient, turn);
            dispatch(Kernel::Reduce, turn);
            dispatch(Kernel::Gather, turn);
            dispatch(Kernel::Solve, turn);
            dispatch(Kernel::Shift, turn);
        }
        dispatch(Kernel::Write, 0);
        drop(pass);
        self.collect(&mut encoder);
        encoder.finish()
    }

    /// Copies the results side by side into the read-back buffer.
    fn collect(&self, encoder: &mut wgpu::CommandEncoder) {
        let sections = Sections::new(self.points, self.vertices);
        for (resource, start) in [
            (Resource::Status, sections.status),
            (Resource::Delta, sections.delta),
            (Resource::Moved, sections.moved),
        ] {
            let buffer = self.buffers.of(resource);
            encoder.copy_buffer_to_buffer(buffer, 0, &self.readback, start as u64, buffer.size());
        }
        if let Some(stamps) = &self.stamps {
            encoder.resolve_query_set(&stamps.queries, 0..2, &stamps.resolved, 0);
            encoder.copy_buffer_to_buffer(&stamps.resolved, 0, &self.readback, 0, STAMPS as u64);
        }
    }

    /// Waits for a submission, with these buffers mapped at the end.
    fn wait(
        &self,
        submission: wgpu::SubmissionIndex,
        buffers: &[(&wgpu::Buffer, wgpu::MapMode)],
    ) -> Result<()> {
        let (sender, mapped) = mpsc::channel();
        for &(buffer, mode) in buffers {
            let sender = sender.clone();
            // The receiver is gone only after this call gave up on the device.
            buffer.map_async(mode, .., move |result| drop(sender.send(result)));
        }
        let poll = wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(PATIENCE) };
        let polled = self.device.device.poll(poll).map_err(|cause| lost(&cause));
        self.device.check()?;
        polled?;
        for _ in buffers {
            mapped.recv_timeout(PATIENCE).map_err(|cause| lost(&cause))?.map_err(|cause| lost(&cause))?;
        }
        Ok(())
    }

    /// Bytes on the device; what is mapped for the CPU lies in its memory.
    pub(crate) fn bytes(&self) -> u64 {
        self.buffers.bytes()
    }

    /// Writes into a buffer before what is dispatched next.
    pub(crate) fn upload(&self, resource: Resource, offset: usize, bytes: &[u8]) {
        self.device.queue.write_buffer(self.buffers.of(resource), offset as u64, bytes);
    }

    /// Starts kernels, each with the index of a turn, one after the other, without waiting for them.
    pub(crate) fn dispatch(&self, steps: &[(Kernel, usize)]) -> Result<()> {
        self.device.check()?;
        let mut encoder = self
            .device
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("passes") });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        for &(kernel, turn) in steps {
            let [x, y, z] = self.dispatches.of(kernel);
            pass.set_pipeline(self.pipelines.of(kernel));
            pass.set_bind_group(0, self.buffers.group(kernel, turn), &[]);
            pass.dispatch_workgroups(x, y, z);
        }
        drop(pass);
        self.device.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Waits for what was started, and shows `read` the bytes of some buffers.
    pub(crate) fn fetch<R>(&self, resources: &[Resource], read: impl FnOnce(&[&[u8]]) -> R) -> Result<R> {
        let device = &self.device.device;
        let sizes: Vec<u64> = resources.iter().map(|&resource| self.buffers.of(resource).size()).collect();
        let copy = self.device.scoped(|| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("fetch"),
                size: sizes.iter().sum(),
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })?;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut start = 0;
        for (&resource, size) in resources.iter().zip(&sizes) {
            encoder.copy_buffer_to_buffer(self.buffers.of(resource), 0, &copy, start, *size);
            start += size;
        }
        let submission = self.device.queue.submit([encoder.finish()]);
        self.wait(submission, &[(&copy, wgpu::MapMode::Read)])?;
        let view = copy.slice(..).get_mapped_range().map_err(|cause| lost(&cause))?;
        let mut rest: &[u8] = &view;
        let mut parts = Vec::with_capacity(sizes.len());
        for size in sizes {
            let (part, after) = rest.split_at(size as usize);
            parts.push(part);
            rest = after;
        }
        Ok(read(&parts))
    }

    fn reading<'a>(&self, bytes: &'a [u8]) -> Reading<'a> {
        let sections = Sections::new(self.points, self.vertices);
        let ticks: &[u64] = bytemuck::cast_slice(&bytes[..STAMPS]);
        Reading {
            status: bytemuck::cast_slice(&bytes[sections.status..sections.delta]),
            delta: bytemuck::cast_slice(&bytes[sections.delta..sections.moved]),
            moved: bytemuck::cast_slice(&bytes[sections.moved..sections.end]),
            seconds: self
                .stamps
                .as_ref()
                .map(|stamps| ticks[1].wrapping_sub(ticks[0]) as f64 * stamps.period * 1e-9),
        }
    }
}

/// Starts of what stands in the read-back buffer, behind the time stamps, in bytes.
struct Sections {
    status: usize,
    delta: usize,
    moved: usize,
    end: usize,
}

impl Sections {
    fn new(points: usize, vertices: usize) -> Self {
        let status = STAMPS;
        let delta = status + TURNS * size_of::<Status>();
        let moved = delta + TURNS * points * size_of::<f32>();
        Self { status, delta, moved, end: moved + vertices * size_of::<[f32; 3]>() }
    }
}

/// So many groups along x, and on along y where they are more than a dispatch allows along x.
fn spread(count: usize, limit: usize) -> [u32; 3] {
    let rows = count.div_ceil(limit);
    [count.div_ceil(rows.max(1)) as u32, rows as u32, 1]
}

fn lost(cause: &dyn std::fmt::Display) -> Error {
    Error::Lost(format!("GPU: the frame did not come back: {cause}"))
}
