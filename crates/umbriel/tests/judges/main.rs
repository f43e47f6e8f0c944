//! The judges: what the program says, held against the definition ([`oracle`]), closed forms ([`forms`]), rivals, and itself.
//!
//! One program, since nearly all of them need the oracle. `UMBRIEL_CASES` and `UMBRIEL_FIRST` number the cases of those that
//! count them (`cargo xtask soak`).

// What they judge by.
mod chance;
mod floor;
mod forms;
mod oracle;
mod proving;
mod stored;
#[path = "../../../../fuzz/src/targets/mod.rs"]
mod targets;

mod adversarial;
mod analytic_segments;
mod borders;
mod closed_forms;
mod closed_forms_checked;
mod closed_forms_solids;
mod coarse_example;
mod corpus;
mod crowds;
mod cut_outs;
mod extremes;
mod far_away;
mod hard_cases;
mod hidden_surfaces;
mod many_points;
mod metamorphic;
mod oracle_by_hand;
mod projected;
mod proofs;
mod queries;
mod random_scenes;
mod rivals;
mod rooms;
mod same_answers;
mod shuffle;
mod soft_fixtures;
mod solids_by_hand;
mod tessellation;
mod two_pass;
mod watertight;
