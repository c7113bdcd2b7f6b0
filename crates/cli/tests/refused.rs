//! Scenes that must be refused: files in `tests/refused`, each with the expected message in its
//! first line, so that a message is found by its words.

use std::{fs, path::Path, process::Command};

#[test]
fn every_scene_is_refused_with_the_message_in_its_first_line() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/refused");
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        let first = text.lines().next().unwrap();
        let expected = first.strip_prefix("# expected: ").unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_carom"))
            .arg("check")
            .arg(&path)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{}: {said}", path.display());
        assert!(said.contains(expected), "{}: {said}", path.display());
        count += 1;
    }
    assert!(count > 30, "{count} scenes");
}
