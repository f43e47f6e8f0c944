//! Work side by side: with threads where the feature `rayon` is on, else one after the other. The same results.

/// Below this many triangles, a task is not divided.
pub(super) const SERIAL: usize = 1 << 12;

/// The results of `run` for each item, in order.
#[cfg(feature = "rayon")]
pub(super) fn map<T: Send, R: Send>(items: Vec<T>, run: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
    use rayon::prelude::*;
    items.into_par_iter().map(run).collect()
}

/// The results of `run` for each item, in order.
#[cfg(not(feature = "rayon"))]
pub(super) fn map<T: Send, R: Send>(items: Vec<T>, run: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
    items.into_iter().map(run).collect()
}

/// What tasks made behind each other, moved.
pub(super) fn joined<T>(parts: Vec<Vec<T>>) -> Vec<T> {
    let mut all = Vec::with_capacity(parts.iter().map(Vec::len).sum());
    parts.into_iter().for_each(|part| all.extend(part));
    all
}
