//! The stored corpora of the fuzz targets, input by input: what once was looked at stays right.

use std::{fs, panic, path::Path};

#[test]
fn every_stored_input_is_taken_well() {
    let corpora = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/fuzz");
    for (name, target) in crate::targets::TARGETS {
        let mut inputs = 0;
        for entry in fs::read_dir(corpora.join(name)).unwrap_or_else(|error| panic!("the corpus of {name}: {error}")) {
            let path = entry.expect("an entry").path();
            let bytes = fs::read(&path).expect("an input");
            assert!(panic::catch_unwind(|| target(&bytes)).is_ok(), "{}", path.display());
            inputs += 1;
        }
        assert!(inputs > 0, "no inputs for {name}");
    }
}
