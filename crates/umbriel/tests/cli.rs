//! The command from outside: exit codes, messages, what is written and what is not.

#[path = "cli/bad_input.rs"]
mod bad_input;
#[path = "cli/bake.rs"]
mod bake;
#[path = "cli/compare.rs"]
mod compare;
#[path = "cli/doctor.rs"]
mod doctor;
#[cfg(unix)]
#[path = "cli/ending.rs"]
mod ending;
#[path = "cli/info.rs"]
mod info;
#[path = "cli/query.rs"]
mod query;
#[path = "cli/render.rs"]
mod render;
#[path = "cli/rooms.rs"]
mod rooms;
#[path = "cli/soft.rs"]
mod soft;
#[path = "cli/suns.rs"]
mod suns;
#[path = "cli/tradeoff.rs"]
mod tradeoff;
#[path = "cli/workspace.rs"]
mod workspace;
