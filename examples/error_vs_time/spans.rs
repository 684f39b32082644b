//! The passes of a frame, as the engine's own diagnostics time them on CPU and GPU.

use std::{collections::BTreeMap, time::Instant};

use bevy::diagnostic::DiagnosticsStore;

/// The passes of one name in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Span {
    pub count: usize,
    /// Milliseconds, all of them together.
    pub cpu: f64,
    /// `None` where the adapter has no timestamps.
    pub gpu: Option<f64>,
}

/// Of one frame: name of a pass -> its times. Passes within passes are parts of the outer ones.
#[derive(Clone, Debug, Default)]
pub struct Spans(pub BTreeMap<String, Span>);

impl Spans {
    /// The GPU time of all passes, in milliseconds.
    pub fn gpu(&self) -> Option<f64> {
        let times: Vec<f64> = self.0.values().filter_map(|span| span.gpu).collect();
        (!times.is_empty()).then(|| times.iter().sum())
    }

    pub fn get(&self, name: &str) -> Option<Span> {
        self.0.get(name).copied()
    }
}

/// Reads the newest frame that has come back from the GPU, once.
#[derive(Default)]
pub struct Reader {
    last: Option<Instant>,
}

impl Reader {
    /// `None` if nothing has come back since the last call.
    pub fn read(&mut self, store: &DiagnosticsStore) -> Option<Spans> {
        let newest = store
            .iter()
            .filter(|diagnostic| is_span(diagnostic.path().as_str()))
            .filter_map(|diagnostic| diagnostic.measurement())
            .map(|measurement| measurement.time)
            .max()?;
        if self.last.is_some_and(|last| newest <= last) {
            return None;
        }
        self.last = Some(newest);
        let mut measured = Vec::new();
        for diagnostic in store.iter() {
            for measurement in diagnostic.measurements() {
                if measurement.time == newest {
                    measured.push((diagnostic.path().as_str(), measurement.value));
                }
            }
        }
        Some(collect(&measured))
    }
}

fn is_span(path: &str) -> bool {
    path.starts_with("render/")
        && (path.ends_with("/elapsed_cpu") || path.ends_with("/elapsed_gpu"))
}

fn collect(measured: &[(&str, f64)]) -> Spans {
    let mut spans = Spans::default();
    for (path, value) in measured.iter().filter(|(path, _)| is_span(path)) {
        let Some((name, clock)) = path
            .strip_prefix("render/")
            .and_then(|path| path.rsplit_once('/'))
        else {
            continue;
        };
        let is_outermost = measured.iter().all(|(other, _)| {
            let outer = other
                .strip_prefix("render/")
                .and_then(|other| other.rsplit_once('/'))
                .map(|(outer, _)| outer);
            outer.is_none_or(|outer| {
                name.strip_prefix(outer)
                    .is_none_or(|rest| !rest.starts_with('/'))
            })
        });
        if !is_outermost {
            continue;
        }
        let span = spans.0.entry(name.to_owned()).or_default();
        if clock == "elapsed_gpu" {
            span.gpu = Some(span.gpu.unwrap_or(0.0) + value);
        } else {
            span.cpu += value;
            span.count += 1;
        }
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_of_one_name_add_up_and_inner_ones_are_not_counted_twice() {
        let spans = collect(&[
            ("render/opaque/elapsed_cpu", 1.0),
            ("render/opaque/elapsed_cpu", 2.0),
            ("render/opaque/elapsed_gpu", 3.0),
            ("render/opaque/elapsed_gpu", 4.0),
            ("render/mirror/elapsed_cpu", 5.0),
            ("render/mirror/elapsed_gpu", 6.0),
            ("render/mirror/shadow/elapsed_gpu", 6.0),
            ("render/opaque/fragment_shader_invocations", 1e6),
            ("fps", 60.0),
        ]);
        let opaque = spans.get("opaque").expect("it is there");
        assert_eq!((opaque.count, opaque.cpu, opaque.gpu), (2, 3.0, Some(7.0)));
        assert_eq!(spans.0.len(), 2);
        assert_eq!(spans.gpu(), Some(13.0));
    }

    #[test]
    fn without_timestamps_there_is_no_gpu_time() {
        let spans = collect(&[("render/opaque/elapsed_cpu", 1.0)]);
        assert_eq!(spans.gpu(), None);
    }
}
