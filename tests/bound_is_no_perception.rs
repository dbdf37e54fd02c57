//! The bound judges the perception, so it must not be made of it: of the robot's code it knows the rig's parameters and the walls' names.

use std::fs;

#[test]
fn the_bound_and_the_truth_share_no_code_with_the_perception() {
    const ALLOWED: [&str; 2] = ["ductloop_nav::perception::Wall;", "ductloop_nav::rig::"];
    let mut read = 0;
    for folder in ["src/accuracy/bound", "src/stage_scores"] {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("a file").path();
            // Scores take in what the perception hands over: types, no code.
            if path.ends_with("score.rs") {
                continue;
            }
            let text = fs::read_to_string(&path).expect("text");
            for (at, _) in text.match_indices("ductloop_nav::") {
                let rest = &text[at..];
                assert!(
                    ALLOWED.iter().any(|allowed| rest.starts_with(allowed)),
                    "{}: {}",
                    path.display(),
                    rest.lines().next().unwrap_or("")
                );
            }
            read += 1;
        }
    }
    assert!(read >= 5, "{read}");
}
