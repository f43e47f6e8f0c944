//! Work side by side: with threads where the feature `rayon` is on, else one after the other. The same results.

/// Runs both.
#[cfg(feature = "rayon")]
pub(super) fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(a, b)
}

/// Runs both.
#[cfg(not(feature = "rayon"))]
pub(super) fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    (a(), b())
}

/// Items that a task takes, of those that cost a few nanoseconds each.
pub(super) const CHUNK: usize = 1 << 14;

/// Runs every task.
pub(super) fn for_each<T: Send>(tasks: &mut [T], run: &(impl Fn(&mut T) + Sync)) {
    match tasks {
        [] => {}
        [task] => run(task),
        _ => {
            let (left, right) = tasks.split_at_mut(tasks.len() / 2);
            join(|| for_each(left, run), || for_each(right, run));
        }
    }
}
