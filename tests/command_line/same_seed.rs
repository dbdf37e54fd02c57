//! The same seed gives the same run, whatever the threads; another seed another.

use super::workshop::Workshop;

#[test]
fn the_same_seed_gives_the_same_run() {
    let workshop = Workshop::new();
    let hash = |args: &[&str]| {
        let args: Vec<_> = ["run", "short.toml", "--json", "--renderer", "cpu"].iter().chain(args).copied().collect();
        let ran = workshop.run(&args).expect(0);
        ran.json()["runs"][0]["run_hash"].as_str().expect("a hash").to_owned()
    };
    let first = hash(&[]);
    assert_eq!(hash(&[]), first);
    assert_eq!(hash(&["--threads", "1"]), first);
    assert_eq!(hash(&["--threads", "2"]), first);
    // More than there are cores, and an odd number: bands of other heights.
    assert_eq!(hash(&["--threads", "6"]), first);
    // The file's own seed, said aloud.
    assert_eq!(hash(&["--seed", "1"]), first);
    assert_ne!(hash(&["--seed", "2"]), first);
}
