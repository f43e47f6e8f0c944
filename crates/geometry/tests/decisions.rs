//! Decisions are counted by thread, and none is lost when threads end.

use umbriel_geometry::decisions::{Decisions, Level, count};

#[test]
fn nothing_is_lost_when_threads_end() {
    let before = Decisions::of_process();
    for round in 1..=3 {
        let thread = std::thread::spawn(move || {
            count(Level::Single, 10);
            count(Level::Double, 2);
            count(Level::Exact, round);
            Decisions::of_thread()
        });
        let own = thread.join().expect("the thread counts");
        assert_eq!(
            own,
            Decisions { single: 10, double: 2, pair: 0, expansion: 0, exact: round },
            "a thread counts for itself"
        );
    }
    let counted = Decisions::of_process() - before;
    assert_eq!(
        counted,
        Decisions { single: 30, double: 6, pair: 0, expansion: 0, exact: 6 },
        "this is the only test here"
    );
}
