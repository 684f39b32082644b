//! What a device holds, by the allocator of the graphics library.

use bevy::render::renderer::RenderDevice;

use crate::support::stage::Stage;

/// Live allocations of textures and buffers.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    pub bytes: u64,
    /// Label and size.
    pub allocations: Vec<(String, u64)>,
}

impl Memory {
    /// `None` where the backend does not tell.
    pub fn of(stage: &mut Stage) -> Option<Self> {
        let device = stage.world().resource::<RenderDevice>().wgpu_device();
        let report = device.generate_allocator_report()?;
        Some(Self {
            bytes: report.total_allocated_bytes,
            allocations: report
                .allocations
                .into_iter()
                .map(|allocation| (allocation.name, allocation.size))
                .collect(),
        })
    }

    /// How many allocations have a label that starts so, and their bytes.
    pub fn labeled(&self, start: &str) -> (usize, u64) {
        let of_label = self
            .allocations
            .iter()
            .filter(|(name, _)| name.starts_with(start));
        of_label.fold((0, 0), |(count, bytes), (_, size)| {
            (count + 1, bytes + size)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_labeled_so_is_counted() {
        let names = [
            ("planar_mirror_depth_stencil", 5),
            ("planar_mirror_shadow_maps", 7),
            ("x", 9),
        ];
        let memory = Memory {
            bytes: 21,
            allocations: names.map(|(name, size)| (name.to_owned(), size)).to_vec(),
        };
        assert_eq!(memory.labeled("planar_mirror"), (2, 12));
        assert_eq!(memory.labeled("none"), (0, 0));
    }
}
