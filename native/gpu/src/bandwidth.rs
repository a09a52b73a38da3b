// SPDX-License-Identifier: GPL-3.0-or-later
//! How fast a device copies: what the times of a frame are compared with.

use std::time::Instant;

use crate::device::Device;
use crate::error::{Error, Result};

/// Bytes of one copy: beyond the caches of today's cards, within the smallest limit of a buffer.
const BYTES: u64 = 256 << 20;

/// Copies in the short and in the long run; the difference of their times is free of what starting a run costs.
const COPIES: [u32; 2] = [4, 36];

/// Runs of which the fastest counts.
const RUNS: usize = 5;

impl Device {
    /// Bytes per second that the device copies within its own memory; each byte copied is read once and written once, and
    /// counts twice.
    ///
    /// # Errors
    /// The device has no room for two buffers of 256 MiB, or failed.
    pub fn copy_bandwidth(&self) -> Result<f64> {
        let bytes = BYTES.min(self.device.limits().max_buffer_size);
        let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let descriptor =
            wgpu::BufferDescriptor { label: Some("copy"), size: bytes, usage, mapped_at_creation: false };
        let buffers = self.scoped(|| [0, 1].map(|_| self.device.create_buffer(&descriptor)))?;
        self.time_copies(&buffers, COPIES[0])?;
        let mut best = [f64::INFINITY; 2];
        for _ in 0..RUNS {
            for (best, copies) in best.iter_mut().zip(COPIES) {
                *best = best.min(self.time_copies(&buffers, copies)?);
            }
        }
        let copied = f64::from(COPIES[1] - COPIES[0]) * bytes as f64;
        Ok(2.0 * copied / (best[1] - best[0]))
    }

    /// Seconds for so many copies from one buffer to the other, there and back.
    fn time_copies(&self, buffers: &[wgpu::Buffer; 2], copies: u32) -> Result<f64> {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for copy in 0..copies as usize {
            let (from, to) = (&buffers[copy % 2], &buffers[(copy + 1) % 2]);
            encoder.copy_buffer_to_buffer(from, 0, to, 0, from.size());
        }
        let commands = encoder.finish();
        let start = Instant::now();
        self.queue.submit([commands]);
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map_err(|cause| Error::Lost(format!("GPU: the copies did not end: {cause}")))?;
        self.check()?;
        Ok(start.elapsed().as_secs_f64())
    }
}
