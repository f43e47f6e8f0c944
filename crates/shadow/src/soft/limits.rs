//! Limits as detail under area lights: a share that may stay open, a time, or the memory of the cells.
//!
//! All receivers are divided to depth 0, 1, 2 and so on, until the limit is met; what a depth finds only narrows what is known, so the result is valid whenever
//! that stops, and more time never gives wider bounds. A depth that the clock or the memory catches is given up. Cost: a depth has been through all before
//! it, which together cost about as much as itself where penumbrae are wide, and less where cells lie along borders.

use std::{sync::atomic::AtomicU64, time::Instant};

use super::bake::{AreaBounds, Bake, SoftCell, SoftLight, SoftObject, SoftRequest};
use crate::{
    budget::{Limit, Until},
    levels::MAX_DEPTH,
    progress::Cancelled,
    report::LitArea,
    request::Detail,
};

/// Where to stop, if that is how the detail is given; time is shared by the lights of the request.
pub(super) fn of(request: &SoftRequest, begun: Instant, lights_done: usize) -> Option<Limit> {
    match request.detail {
        Detail::MaxUndecided { share } => Some(Limit { share, ..Limit::default() }),
        Detail::Memory { bytes } => Some(Limit { bytes: Some(bytes), ..Limit::default() }),
        Detail::Time { limit } => {
            let lights = request.lights.len().max(1) as u32;
            let deadline = begun + limit / lights * (lights_done as u32 + 1).min(lights);
            Some(Limit { deadline: Some(deadline), ..Limit::default() })
        }
        _ => None,
    }
}

/// Divides all receivers depth by depth as far as the limit lets it. The first look is taken whatever it costs.
///
/// # Errors
/// [`Cancelled`] when the caller's progress says so.
pub(super) fn refine(bake: Bake, limit: &Limit) -> Result<SoftLight, Cancelled> {
    let until = Until { progress: bake.progress, deadline: limit.deadline };
    let room = limit.bytes.map(|bytes| bytes / size_of::<SoftCell>() as u64);
    let at = |depth: u8| Bake {
        detail: Detail::Depth { interior: depth, boundary: depth },
        room: None,
        tolerance: bake.tolerance.min(if limit.share > 0.0 { limit.share } else { 0.5f64.powi(depth.into()) }),
        ..bake
    };
    let mut known = at(0).run()?;
    for depth in 1..=MAX_DEPTH {
        if is_enough(&known, limit.share) || until.is_over() {
            break;
        }
        let deeper = Bake { room: room.map(AtomicU64::new), progress: &until, ..at(depth) };
        match deeper.run() {
            Ok(found) => narrow(&mut known, found),
            Err(Cancelled) if bake.progress.is_cancelled() => return Err(Cancelled),
            Err(Cancelled) => break,
        }
    }
    Ok(known)
}

/// Whether little enough of the visible fraction is open.
fn is_enough(known: &SoftLight, share: f64) -> bool {
    let area: f64 = known.objects.iter().map(|object| object.area).sum();
    let open: f64 = known.objects.iter().map(|object| object.visible.upper - object.visible.lower).sum();
    open <= share * area
}

/// Takes a deeper look; bounds that were tighter before are kept.
fn narrow(known: &mut SoftLight, found: SoftLight) {
    let both = |a: AreaBounds, b: AreaBounds| AreaBounds { lower: a.lower.max(b.lower), upper: a.upper.min(b.upper) };
    known.cells = found.cells;
    for (before, now) in known.objects.iter_mut().zip(found.objects) {
        let (lower, upper) = (before.visible.lower.max(now.visible.lower), before.visible.upper.min(now.visible.upper));
        *before = SoftObject {
            lit: both(before.lit, now.lit),
            penumbra: both(before.penumbra, now.penumbra),
            umbra: both(before.umbra, now.umbra),
            visible: LitArea { lower, upper, estimate: now.visible.estimate.clamp(lower, upper) },
            ..now
        };
    }
}
