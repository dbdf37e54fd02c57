//! Which renderer is taken, and that it is said.

use serde_json::{Value, json};

use super::workshop::{NO_ADAPTER, Workshop};

fn manifest(workshop: &Workshop) -> Value {
    serde_json::from_str(&workshop.read("out/short/manifest.json")).expect("JSON")
}

#[test]
fn without_an_adapter_the_processor_renders_and_that_is_said() {
    let workshop = Workshop::new();
    let ran = workshop.run_with(&NO_ADAPTER, &["run", "short.toml", "--json"]).expect(0).saying(&["rendering with cpu"]);
    assert_eq!(ran.json()["runs"][0]["renderer"], "cpu");
    let manifest = manifest(&workshop);
    assert_eq!((&manifest["renderer"], &manifest["adapter"]), (&json!("cpu"), &Value::Null));
    // Only the driver's name is missing, as a user would hide it.
    workshop.run_with(&NO_ADAPTER[..1], &["run", "short.toml"]).expect(0).saying(&["rendering with cpu"]);
    // Who names the renderer is not told about it.
    let ran = workshop.run(&["run", "short.toml", "--renderer", "cpu"]).expect(0);
    assert!(!ran.stderr.contains("rendering with"), "{}", ran.stderr);
}

#[test]
fn wgpu_alone_needs_an_adapter_and_says_what_to_install() {
    let workshop = Workshop::new();
    for command in [&["run", "short.toml", "--json"][..], &["render", "short.toml", "--at-s", "0"]] {
        let command = [command, &["--renderer", "wgpu"]].concat();
        let ran = workshop.run_with(&NO_ADAPTER, &command).expect(3).saying(&["no graphics adapter", "mesa-vulkan-drivers"]);
        if command.contains(&"--json") {
            assert!(ran.json()["errors"][0]["message"].as_str().expect("words").contains("mesa-vulkan-drivers"));
        }
    }
    assert_eq!(workshop.files("out").len(), 0);
}

/// Any adapter serves who asks for wgpu; `auto` takes one of hardware only.
#[test]
fn wgpu_takes_any_adapter_and_auto_one_of_hardware() {
    let workshop = Workshop::new();
    let ran = workshop.run(&["run", "short.toml", "--renderer", "wgpu", "--json"]).expect(0);
    assert_eq!(ran.json()["runs"][0]["renderer"], "wgpu");
    let adapter = manifest(&workshop)["adapter"].clone();
    let is_software = adapter["software"].as_bool().unwrap_or_else(|| panic!("{adapter}"));
    let ran = workshop.run(&["run", "short.toml", "--json"]).expect(0);
    let (taken, said) = if is_software { ("cpu", "rendering with cpu: ") } else { ("wgpu", "rendering with wgpu on ") };
    assert_eq!(ran.json()["runs"][0]["renderer"], taken);
    assert!(ran.stderr.contains(said), "{}", ran.stderr);
}
