//! Where pictures and trees are written: links, pipes, devices, leftovers of killed programs, and
//! the files that are read.

mod common;

use std::fs;
use std::process::Command;

use common::{Sandbox, errors_of, triangle};

const SMALL: &str = "render small.gltf --size 8x8 --spp 1";

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("small.gltf"));
    sandbox
}

#[test]
fn a_folder_that_cannot_be_written_to_is_found_before_any_work() {
    let sandbox = sandbox();
    #[cfg(target_os = "linux")]
    for command in ["render missing.glb --out /proc/never.png", "bake missing.glb --out /proc/new/never.trees"] {
        let complaint = sandbox.fail_in_one_line(command);
        assert!(complaint.contains("/proc/") && complaint.contains("cannot be written"), "{complaint}");
    }
    let folder = sandbox.path("closed");
    fs::create_dir(&folder).unwrap();
    let mut permissions = fs::metadata(&folder).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&folder, permissions).unwrap();
    if fs::write(folder.join("probe"), b"").is_ok() {
        println!("SKIPPED: this user may write everywhere");
        return;
    }
    for command in ["render missing.glb --out closed/a.png", "bake missing.glb --out closed/new/a.trees"] {
        let complaint = sandbox.fail_in_one_line(command);
        assert!(complaint.contains("closed/"), "{complaint}");
    }
}

#[test]
fn no_folder_is_made_for_a_picture_that_never_comes() {
    let sandbox = sandbox();
    sandbox.fail_in_one_line("render missing.glb --out lap/a.png");
    assert!(!sandbox.path("lap").exists());
}

#[cfg(unix)]
#[test]
fn a_symbolic_link_is_followed_and_stays() {
    use std::os::unix::fs::symlink;
    let sandbox = sandbox();
    fs::create_dir(sandbox.path("pictures")).unwrap();
    fs::write(sandbox.path("pictures/real.png"), b"old").unwrap();
    symlink("pictures/real.png", sandbox.path("link.png")).unwrap();
    symlink("pictures/real.trees", sandbox.path("link.trees")).unwrap();
    sandbox.succeed(&format!("{SMALL} --out link.png"));
    sandbox.succeed("bake small.gltf --out link.trees");
    for link in ["link.png", "link.trees"] {
        assert!(fs::symlink_metadata(sandbox.path(link)).unwrap().is_symlink(), "{link}");
    }
    assert!(image::open(sandbox.path("pictures/real.png")).is_ok());
    assert!(fs::symlink_metadata(sandbox.path("pictures/real.trees")).unwrap().is_file());
}

#[cfg(unix)]
#[test]
fn a_pipe_gets_the_picture_and_stays_a_pipe() {
    use std::os::unix::fs::FileTypeExt;
    let sandbox = sandbox();
    let made = Command::new("mkfifo").arg(sandbox.path("pipe")).status();
    if !made.is_ok_and(|status| status.success()) {
        println!("SKIPPED: there is no mkfifo");
        return;
    }
    sandbox.succeed(&format!("{SMALL} --out plain.png"));
    let reader = {
        let pipe = sandbox.path("pipe");
        std::thread::spawn(move || fs::read(pipe).unwrap())
    };
    sandbox.succeed(&format!("{SMALL} --out pipe"));
    assert!(reader.join().unwrap() == fs::read(sandbox.path("plain.png")).unwrap());
    assert!(fs::symlink_metadata(sandbox.path("pipe")).unwrap().file_type().is_fifo());
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_gets_the_bytes_alone_and_the_summary_goes_to_standard_error() {
    let sandbox = sandbox();
    sandbox.succeed(&format!("{SMALL} --out plain.png"));
    sandbox.succeed("bake small.gltf --out plain.trees");
    for (command, plain, word) in [(SMALL, "plain.png", "FPS"), ("bake small.gltf", "plain.trees", "quality")] {
        let output = sandbox.run(&format!("{command} --out /dev/stdout"));
        assert!(output.status.success(), "{}", errors_of(&output));
        assert!(output.stdout == fs::read(sandbox.path(plain)).unwrap(), "{command}");
        assert!(errors_of(&output).contains(word), "{}", errors_of(&output));

        // The same into a file, through the shell's redirection.
        let redirected = fs::File::create(sandbox.path("redirected")).unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_kinetree"));
        program.args(command.split(' ')).args(["--quiet", "--out", "/dev/stdout"]).current_dir(sandbox.path("."));
        assert!(program.stdout(redirected).status().unwrap().success());
        assert!(fs::read(sandbox.path("redirected")).unwrap() == fs::read(sandbox.path(plain)).unwrap(), "{command}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_device_is_written_to_and_stays_a_device() {
    use std::os::unix::fs::FileTypeExt;
    let sandbox = sandbox();
    // Every write to it fails: the device is always full.
    let complaint = sandbox.fail_in_one_line(&format!("{SMALL} --out /dev/full"));
    assert!(complaint.contains("/dev/full"), "{complaint}");
    assert!(fs::symlink_metadata("/dev/full").unwrap().file_type().is_char_device());
}

#[test]
fn a_leftover_goes_only_when_its_program_is_gone() {
    let sandbox = sandbox();
    // No process has the first id; the second process runs.
    let [gone, alive] =
        [999_999_999, std::process::id()].map(|process| sandbox.path(&format!(".kinetree-{process}-0.part")));
    fs::write(&gone, b"half a picture").unwrap();
    fs::write(&alive, b"half a picture").unwrap();
    sandbox.succeed(&format!("{SMALL} --out a.png"));
    assert!(!gone.exists());
    assert!(alive.exists() || !cfg!(target_os = "linux"));
}

#[test]
fn programs_in_one_folder_do_not_disturb_each_other() {
    let sandbox = sandbox();
    let names: Vec<String> = (0..6).map(|number| format!("{number}.png")).collect();
    let programs: Vec<_> = names
        .iter()
        .map(|name| {
            let mut program = Command::new(env!("CARGO_BIN_EXE_kinetree"));
            program.args(SMALL.split(' ')).args(["--quiet", "--out", name]).current_dir(sandbox.path("."));
            program.spawn().expect("the program starts")
        })
        .collect();
    assert!(programs.into_iter().all(|mut program| program.wait().unwrap().success()));
    let mut expected: Vec<_> = names.iter().map(|name| sandbox.path(name)).collect();
    expected.push(sandbox.path("small.gltf"));
    assert_eq!(sandbox.files(), expected);
}

#[test]
fn what_is_read_is_never_written_over_whatever_its_name() {
    let sandbox = sandbox();
    sandbox.succeed("bake small.gltf --out small.trees");
    fs::hard_link(sandbox.path("small.trees"), sandbox.path("7.png")).unwrap();
    fs::hard_link(sandbox.path("small.gltf"), sandbox.path("scene.png")).unwrap();
    let mut commands = vec![
        "bake small.gltf --out small.gltf".to_owned(),
        "bake small.gltf --out ./small.gltf".to_owned(),
        format!("{SMALL} --out scene.png"),
        format!("{SMALL} --trees small.trees --out 7.png"),
        format!("{SMALL} --trees small.trees --frames 5..8 --out %d.png"),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("small.gltf", sandbox.path("link.png")).unwrap();
        commands.push(format!("{SMALL} --out link.png"));
    }
    let before = ["small.gltf", "small.trees"].map(|name| fs::read(sandbox.path(name)).unwrap());
    for command in &commands {
        let complaint = sandbox.fail(command, 2);
        assert!(complaint.contains("same file"), "{command}: {complaint}");
    }
    assert!(before == ["small.gltf", "small.trees"].map(|name| fs::read(sandbox.path(name)).unwrap()));
    // Files that a scene refers to are protected too: here its buffer.
    let text = fs::read_to_string(sandbox.path("small.gltf")).unwrap();
    let start = text.find("data:").unwrap();
    let end = start + text[start..].find('"').unwrap();
    let named = format!("{}buffer.png{}", &text[..start], &text[end..]);
    fs::write(sandbox.path("named.gltf"), named).unwrap();
    let corners = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    fs::write(sandbox.path("buffer.png"), &bytes).unwrap();
    for command in ["render named.gltf --size 8x8 --spp 1 --out buffer.png", "bake named.gltf --out ./buffer.png"] {
        assert!(sandbox.fail(command, 2).contains("same file"), "{command}");
    }
    assert!(fs::read(sandbox.path("buffer.png")).unwrap() == bytes);
    // A file with the same content is another file.
    fs::copy(sandbox.path("small.gltf"), sandbox.path("copy.png")).unwrap();
    sandbox.succeed(&format!("{SMALL} --out copy.png"));
}

#[test]
fn more_threads_than_cores_are_cut_to_them_with_a_note() {
    let sandbox = sandbox();
    let cores = std::thread::available_parallelism().unwrap().get();
    let output = sandbox.run(&format!("{SMALL} --threads 100000 --json"));
    assert!(output.status.success(), "{}", errors_of(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["threads"], cores);
    assert!(errors_of(&output).contains("100000 threads were asked for"), "{}", errors_of(&output));
    assert!(sandbox.run(&format!("{SMALL} --threads 100000 --quiet")).stderr.is_empty());
    assert!(sandbox.run(&format!("{SMALL} --threads 1 --json")).stderr.is_empty());
}
