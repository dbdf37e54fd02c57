//! The CPU renderer's images are the same to the bit whatever the number of threads, the optimisation, the processor that the program is
//! compiled for, and the one that it runs on.
//!
//! A hash that changes here changes every run's hash: the table is to be renewed only with a change to the model that means to
//! (`cargo run --release -p ductloop-sensor --no-default-features --example image_hash`).

#[path = "../examples/image_hash.rs"]
mod image_hash;

use std::path::{Path, PathBuf};
use std::process::Command;

/// FNV-1a of each image.
const GOLDEN: [(&str, u64); 11] = [
    ("plain", 0x9e4a_134a_ce8e_9b5b),
    ("zinc", 0xcea1_a879_1994_684c),
    ("portrait", 0xcdce_239f_b5c5_deeb),
    ("boxes", 0x7b84_1641_09ac_b494),
    ("bent", 0x8231_ad2e_e6a8_569c),
    ("joints", 0xc825_bf90_4ff2_7512),
    ("moving", 0xe786_2dbf_2807_bb14),
    ("raw", 0xad98_71d5_2831_5071),
    ("unfocused", 0x82b6_a36e_e075_a193),
    ("mirrors", 0x47e7_c207_e4bb_8e2d),
    ("bare", 0x74b2_88b7_f382_2948),
];

fn golden(names: &[&str]) -> String {
    let asked = |name: &str| names.is_empty() || names.contains(&name);
    GOLDEN.iter().filter(|(name, _)| asked(name)).map(|(name, hash)| format!("{name} {hash:016x}\n")).collect()
}

/// The example, built with these further arguments and flags for the compiler.
fn build(folder: &str, arguments: &[&str], flags: &str) -> PathBuf {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join(folder);
    let mut cargo = Command::new(env!("CARGO"));
    // As an example it brings the tests' dependencies along; as a program of the package it would be installed with it.
    cargo.args(["build", "--offline", "--quiet", "--no-default-features", "--example", "image_hash"]);
    cargo.args(["--config", "profile.release.debug=false", "--config", "profile.dev.debug=false"]).args(arguments);
    cargo.current_dir(env!("CARGO_MANIFEST_DIR")).env("CARGO_TARGET_DIR", &target);
    // Flags of whoever runs the tests are not meant for this build.
    cargo.env_remove("CARGO_ENCODED_RUSTFLAGS").env("RUSTFLAGS", flags);
    let status = cargo.status().expect("cargo runs");
    assert!(status.success(), "the example could not be built ({status})");
    let profile = if arguments.contains(&"--release") { "release" } else { "debug" };
    target.join(profile).join("examples/image_hash")
}

fn printed(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(output.status.success(), "{command:?}: {}\n{}", output.status, String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("names and digits")
}

#[test]
fn images_are_those_of_the_table_on_any_number_of_threads() {
    let pictures = image_hash::pictures();
    for threads in 1..=3 {
        let found: String = pictures.iter().map(|p| format!("{} {:016x}\n", p.name, p.hash(threads))).collect();
        assert_eq!(found, golden(&[]), "{threads} threads");
    }
}

#[test]
fn images_do_not_depend_on_the_optimisation() {
    let example = build("bits-unoptimised", &["--config", "profile.dev.opt-level=0"], "");
    assert_eq!(printed(&mut Command::new(example)), golden(&[]));
}

#[test]
fn images_do_not_depend_on_the_processor_compiled_for() {
    let example = build("bits-native", &["--release"], "-C target-cpu=native");
    assert_eq!(printed(&mut Command::new(example)), golden(&[]));
}

/// This program, compiled for any x86-64 processor unless flags say otherwise, on an old one without AVX (2008) and on one with
/// AVX2 (2013).
#[test]
fn images_do_not_depend_on_the_processor_run_on() {
    if !cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        println!("skipped: qemu-user runs Linux programs");
        return;
    }
    let qemu = "qemu-x86_64";
    if let Err(error) = Command::new(qemu).arg("--version").output() {
        let allowed = std::env::var_os("DUCTLOOP_ALLOW_NO_QEMU").is_some();
        assert!(
            allowed,
            "{qemu}: {error}; on Debian or Ubuntu `apt-get install qemu-user` installs it, DUCTLOOP_ALLOW_NO_QEMU=1 does without"
        );
        println!("skipped: {qemu}: {error}");
        return;
    }
    let program = std::env::current_exe().expect("a path");
    // Vector instructions are slow in emulation: some images must do for the newer one.
    for (processor, names) in [("Nehalem", ""), ("Haswell", "boxes joints raw")] {
        let mut emulated = Command::new(qemu);
        emulated.args(["-cpu", processor]).arg(&program).args(["--ignored", "--exact", EMULATED]).env(NAMES, names);
        assert!(printed(&mut emulated).contains("1 passed"), "{processor}");
    }
}

/// The test that is run in emulation, and where it finds the names of its images.
const EMULATED: &str = "some_images_are_those_of_the_table";
const NAMES: &str = "DUCTLOOP_IMAGE_NAMES";

#[test]
#[ignore = "the test of the processor run on runs it in emulation"]
fn some_images_are_those_of_the_table() {
    let names = std::env::var(NAMES).unwrap_or_default();
    let names: Vec<&str> = names.split_whitespace().collect();
    let pictures = image_hash::pictures().into_iter().filter(|p| names.is_empty() || names.contains(&p.name));
    assert_eq!(pictures.map(|p| format!("{} {:016x}\n", p.name, p.hash(1))).collect::<String>(), golden(&names));
}
