//! Ends from outside: Ctrl-C, and a reader that has seen enough.

use std::{process::Command, thread::sleep, time::Duration};

use crate::workspace::Workspace;

#[test]
fn an_interrupt_ends_cleanly_and_leaves_nothing() {
    let workspace = Workspace::noon();
    // Deep enough for minutes, so the signal comes in time on any machine.
    let child = workspace.start("bake noon.toml --boundary-depth 16 -o out.csv -o out.json");
    sleep(Duration::from_millis(700));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("a signal");
    assert!(killed.success());
    let output = child.wait_with_output().expect("an end");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{message}");
    assert!(message.contains("interrupted"), "{message}");
    assert_eq!(workspace.files(), ["noon.toml"]);
}

#[test]
fn a_closed_pipe_is_a_success() {
    let workspace = Workspace::noon();
    let mut child = workspace.start("bake noon.toml --boundary-depth 4 -o out.csv");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("an end");
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]));
    assert_eq!(workspace.files(), ["noon.toml", "out.csv"], "files are written all the same");
}

#[cfg(unix)]
#[test]
fn a_file_beyond_the_limit_is_a_failed_write() {
    let workspace = Workspace::noon();
    let program = env!("CARGO_BIN_EXE_umbriel");
    // Some blocks of a shell's `ulimit -f`, of 512 or 1024 bytes; the grid takes a hundred times that.
    let line = format!("ulimit -f 8; exec '{program}' bake noon.toml --boundary-depth 6 -o out.vtu");
    let output = Command::new("sh").args(["-c", &line]).current_dir(workspace.path("")).output().expect("a shell");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("cannot write"), "{message}");
    assert_eq!(workspace.files(), ["noon.toml"]);
}

#[test]
fn more_samples_than_memory_holds_are_refused() {
    let workspace = Workspace::noon();
    let output = workspace.start("bake noon.toml --spacing 1e-9").wait_with_output().expect("an end");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("samples are too many"), "{message}");
}
