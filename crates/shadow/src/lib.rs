//! Lit, shadowed and still undecided surface, with proofs.
//!
//! [`bake`] classifies surfaces: which cells of which faces are lit, which are in shadow, how much is undecided.
//! [`bake_hours`] does so for many lights one after the other, and tells for how long surfaces are lit.
//! [`Queries`] answers single points exactly. [`soft_bake`] and [`Queries::visible_fraction`] do so for lights with an extent. [`doctor`] tells what about a scene limits the answers.
//! [`rivals`] are the other ways to find shadows, and [`tradeoff`] measures what time and memory buy with each.

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod bake;
mod bodies;
mod budget;
mod by_object;
mod cell_octree;
mod coarse;
pub mod doctor;
mod effort;
mod embedded;
mod exact;
mod fine;
mod flat_receiver;
mod groups;
mod hours;
mod levels;
mod light_space;
mod loose;
mod parts;
mod portals;
mod progress;
mod query;
mod receivers;
mod report;
mod request;
pub mod rivals;
mod sample_points;
mod samples;
mod search;
mod session;
mod slack;
mod soft;
mod solids;
mod spacing;
mod sums;
#[cfg(test)]
mod test_bodies;
mod throng;
mod tickets;
pub mod tradeoff;
mod trial;

pub use bake::bake;
pub use cell_octree::CellOctree;
pub use effort::typical_effort;
pub use hours::{
    HourBounds, HourCell, HourCells, HoursError, HoursReport, LightSummary, ObjectHours, SampledHours, TimedLight,
    bake_hours, hours,
};
pub use loose::{FacePoint, Points, PointsError};
pub use portals::reached_receivers;
pub use progress::{Cancelled, Progress, Silent};
pub use query::{Answer, Place, Precision, Queries, QueryDefect};
pub use report::{
    Cell, LightReport, LitArea, ObjectReport, PortalWork, Report, SampleAnswers, SampleCount, Time, Verdict, Work,
};
pub use request::{CellMethod, Detail, OwnDetails, Request, Sampling};
pub use sample_points::{SamplePoint, for_each_sample, most_samples};
pub use search::{Clutter, Expected, PointCost, Search, SearchChoice, SearchCosts, WayCosts};
pub use session::{Change, ChangeDefect, Session, Update};
pub use soft::{AreaBounds, Fraction, SoftCell, SoftLight, SoftObject, SoftRequest, image as soft_image, soft_bake};
