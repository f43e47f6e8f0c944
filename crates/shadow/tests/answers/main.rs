//! What bakes and queries answer, each kind of scene or promise in its own file: one program, which is linked once and whose tests run side by side. What
//! measures time, or counts for the whole process, is a program of its own beside it.

mod details;
mod dice;
mod efforts;
mod estimates;
mod fallbacks;
mod hubs;
#[path = "../judged/mod.rs"]
mod judged;
mod literal_faults;
mod neighbours;
mod only_what_is_required;
mod parts_of_meshes;
mod piles;
mod repeats;
mod scales;
mod soft_cells;
mod soft_closed_forms;
mod soft_points;
