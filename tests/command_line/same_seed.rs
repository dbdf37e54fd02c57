//! The same seed gives the same run, whatever the threads and the processor; another seed another.

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

/// The hash of a run of half a second with the default model. It changes with every change to physics, images or navigation that
/// is meant to change results, and with nothing else.
const GOLDEN: &str = "5016adb1f0e3ad91f05ee96c4ba7454f";

/// Physics, images and navigation, all to the bit, on a processor without AVX as on this one.
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
#[test]
fn an_old_processor_gives_the_same_run() {
    let workshop = Workshop::new();
    let half_a_second = ["run", "short.toml", "--renderer", "cpu", "--json", "--set", "time_limit_s=0.5"];
    let hash = |ran: super::workshop::Ran| ran.json()["runs"][0]["run_hash"].as_str().expect("a hash").to_owned();
    // It is not there in half a second, so the verdict is a failure.
    assert_eq!(hash(workshop.run(&half_a_second).expect(1)), GOLDEN, "on this processor");
    match workshop.run_on(&["qemu-x86_64", "-cpu", "Nehalem"], &[&half_a_second[..], &["--force"]].concat()) {
        Some(ran) => assert_eq!(hash(ran.expect(1)), GOLDEN, "on an old processor"),
        None => assert!(
            std::env::var_os("DUCTLOOP_ALLOW_NO_QEMU").is_some(),
            "there is no qemu-x86_64; on Debian or Ubuntu `apt-get install qemu-user` installs it, DUCTLOOP_ALLOW_NO_QEMU=1 does without"
        ),
    }
}
