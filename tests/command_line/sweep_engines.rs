//! What `sweep --engine` says where the engine is not there. Real engines: `tests/engines/run.sh`.

use super::workshop::Workshop;

const SWEEP: &str = r#"format = 1
kind = "sweep"
name = "small"
base = "short.toml"
[factor]
duct.width_m = [0.4, 0.5]
"#;

fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.write("small.toml", SWEEP);
    workshop.write("empty/none", "");
    workshop
}

/// No engine: exit code 2 before anything is planned, and what to do instead.
#[test]
fn an_engine_that_is_not_here_is_named_before_anything_is_planned() {
    let workshop = workshop();
    let nowhere = workshop.path("empty").display().to_string();
    for (args, words) in [
        (vec!["--engine", "slurm", "--nodes", "2"], vec!["Slurm is not on this machine", "login node", "leave `--engine` out"]),
        (vec!["--engine", "ray", "--nodes", "2"], vec!["there is no Python here", "python3", "pip install ray"]),
        (vec!["--engine", "ray", "--nodes", "2", "--python", "/no/python"], vec!["/no/python", "pip install ray"]),
    ] {
        let args: Vec<_> = ["sweep", "small.toml"].into_iter().chain(args).collect();
        workshop.run_with(&[("PATH", &nowhere)], &args).expect(2).saying(&words);
    }
    assert!(workshop.names("out").is_empty(), "{:?}", workshop.names("out"));
}

/// A Python without Ray in it: the line that installs it.
#[test]
#[cfg(unix)]
fn a_python_without_ray_is_told_how_to_get_it() {
    use std::os::unix::fs::PermissionsExt;
    let workshop = workshop();
    // It answers as Python does where the module is not found.
    workshop.write("bin/python", "#!/bin/sh\nexit 7\n");
    let python = workshop.path("bin/python");
    std::fs::set_permissions(&python, std::fs::Permissions::from_mode(0o755)).expect("permissions");
    let python = python.display().to_string();
    let ran = workshop.run(&["sweep", "small.toml", "--engine", "ray", "--nodes", "2", "--python", &python]);
    ran.expect(2).saying(&["Ray is not installed", &format!("{python} -m pip install ray")]);
    assert!(workshop.names("out").is_empty());
}

/// A scheduler that takes the job and loses it: exit code 3, with the logs and the call that goes on. And one that refuses it: 2.
#[test]
#[cfg(unix)]
fn jobs_that_end_with_cases_missing_are_told_of() {
    use std::os::unix::fs::PermissionsExt;
    let workshop = workshop();
    let program = |name: &str, text: &str| {
        workshop.write(&format!("bin/{name}"), format!("#!/bin/sh\n{text}\n"));
        std::fs::set_permissions(workshop.path(&format!("bin/{name}")), std::fs::Permissions::from_mode(0o755))
            .expect("permissions");
    };
    program("sbatch", "echo \"$@\" >> submitted\ncase \"$1\" in --version) ;; *) echo 42 ;; esac");
    program("squeue", "");
    let path = format!("{}:/usr/bin:/bin", workshop.path("bin").display());
    let call = ["sweep", "small.toml", "--engine", "slurm", "--nodes", "5", "--partition", "p", "--engine-arg=--time=5"];
    let place = workshop.path("out/small").display().to_string();
    workshop.run_with(&[("PATH", &path)], &call).expect(3).saying(&[
        "2 of 2 cases are not done",
        &format!("{place}/logs/slurm-42-*.log"),
        "the same call",
        &format!("ductloop sweep work {place}"),
    ]);
    let submitted = workshop.read("submitted");
    // No more tasks than points; what was asked for expressly comes last.
    for words in ["--array=1-2 ", "--requeue", "--partition=p --time=5 ", "/slurm.sh"] {
        assert!(submitted.contains(words), "{words}: {submitted}");
    }
    let script = workshop.read("out/small/slurm.sh");
    assert!(
        script.contains(&format!("sweep work {place} --shard \"$SLURM_ARRAY_TASK_ID/2\" --threads \"$SLURM_CPUS_ON_NODE\"")),
        "{script}"
    );
    program("sbatch", "case \"$1\" in --version) ;; *) echo 'invalid partition specified: p' >&2; exit 1 ;; esac");
    workshop.run_with(&[("PATH", &path)], &call).expect(2).saying(&["invalid partition specified: p", "--engine-arg"]);
    // What is done already needs no job: this machine does it, and the next call with the refusing Slurm ends well.
    workshop.run(&["sweep", "work", &place, "--quiet"]).expect(0);
    workshop.run_with(&[("PATH", &path)], &call).expect(0);
    assert!(workshop.path("out/small/report.html").exists());
}

/// Options of another engine, or of none.
#[test]
fn options_of_another_engine_are_refused() {
    let workshop = workshop();
    for (args, words) in [
        (vec!["--engine", "ray", "--nodes", "2", "--partition", "p"], "--partition: this is for Slurm"),
        (vec!["--engine", "ray", "--nodes", "2", "--engine-arg=--time=5"], "--engine-arg: this is for Slurm"),
        (vec!["--engine", "slurm", "--nodes", "2", "--address", "a:1"], "--address: this is for Ray"),
        (vec!["--engine", "slurm", "--nodes", "2", "--python", "p"], "--python: this is for Ray"),
        (vec!["--engine", "slurm"], "--nodes"),
        (vec!["--nodes", "2"], "--engine"),
        (vec!["--partition", "p"], "--engine"),
        (vec!["--engine", "slurm", "--nodes", "0"], "0"),
    ] {
        let args: Vec<_> = ["sweep", "small.toml"].into_iter().chain(args).collect();
        workshop.run(&args).expect(2).saying(&[words]);
    }
}
