//! How much memory loading takes, counted by the allocator: bounded by the size of what is loaded,
//! whatever it says.

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::atomic::{AtomicIsize, Ordering::Relaxed};

use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb, Rgba};
use kinetree_gltf::{LoadedWorld, Options, load_with};

/// The system's allocator, counted. What grows is allocated anew, copied and freed, as it may be in
/// the worst case.
struct Counting;

static NOW: AtomicIsize = AtomicIsize::new(0);
static MOST: AtomicIsize = AtomicIsize::new(0);

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// SAFETY: every call goes to the system's allocator as it came; counting touches no memory but two
// atomics.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let size = layout.size() as isize;
        MOST.fetch_max(NOW.fetch_add(size, Relaxed) + size, Relaxed);
        // SAFETY: the caller's promises are those of the system's allocator.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size() as isize, Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// Loads a file; also the most bytes that this took at a time, and the bytes that are still held.
fn counted(path: &Path, options: &Options) -> (Result<LoadedWorld, String>, usize, usize) {
    let before = NOW.load(Relaxed);
    MOST.store(before, Relaxed);
    let loaded = load_with(path, options).map_err(|error| error.to_string());
    let most = MOST.load(Relaxed) - before;
    let held = NOW.load(Relaxed) - before;
    (loaded, most.max(0) as usize, held.max(0) as usize)
}

/// A megabyte of JSON that repeats one element.
fn repeated(before: &str, what: &str, after: &str) -> String {
    const LENGTH: usize = 1 << 20;
    let mut text = format!("{{\"asset\":{{\"version\":\"2.0\"}},{before}");
    while text.len() < LENGTH {
        text += what;
        text.push(',');
    }
    text.pop();
    text + after + "}"
}

fn json_takes_at_most_60_bytes_for_each_of_its_own() {
    const TRIANGLE: &str = r#""accessors":[{"componentType":5126,"count":3,"type":"VEC3"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"#;
    let deep = format!("{}{}", "[".repeat(100), "]".repeat(100));
    let nested = format!("{}0{}", r#"{"":"#.repeat(100), "}".repeat(100));
    let list = |name: &str, what: &str| (format!("{name} of {what}"), repeated(&format!("\"{name}\":["), what, "]"));
    let in_mesh = |what: &str| {
        (format!("a mesh of {what}"), repeated(r#""nodes":[{"mesh":0}],"meshes":[{"primitives":["#, what, "]}]"))
    };
    let animated = r#""nodes":[{}],"accessors":[{"componentType":5126,"count":0,"type":"SCALAR"}],"animations":["#;
    let channel = r#"{"sampler":0,"target":{"node":0,"path":"translation"}}"#;
    let cases = [
        list("nodes", "{}"),
        list("nodes", r#"{"name":""}"#),
        list("nodes", r#"{"children":[]}"#),
        list("nodes", r#"{"scale":[1,1,1]}"#),
        list("nodes", r#"{"extensions":{}}"#),
        list("materials", "{}"),
        list("materials", r#"{"extensions":{}}"#),
        list("materials", r#"{"pbrMetallicRoughness":{}}"#),
        list("images", "{}"),
        list("textures", "{}"),
        list("samplers", "{}"),
        list("scenes", "{}"),
        list("cameras", "{}"),
        list("skins", r#"{"joints":[]}"#),
        list("meshes", r#"{"primitives":[]}"#),
        list("animations", r#"{"channels":[],"samplers":[]}"#),
        list("extensionsUsed", r#""""#),
        list("extras", "{}"),
        list("extras", r#"{"":0}"#),
        list("extras", "[[]]"),
        list("extras", &deep),
        list("extras", &nested),
        in_mesh(r#"{"attributes":{}}"#),
        in_mesh(r#"{"attributes":{"POSITION":0}}"#),
        in_mesh(r#"{"attributes":{},"targets":[]}"#),
        ("targets".into(), repeated(r#""meshes":[{"primitives":[{"attributes":{},"targets":["#, "{}", "]}]}]")),
        ("weights".into(), repeated(r#""meshes":[{"primitives":[],"weights":["#, "0", "]}]")),
        ("roots".into(), repeated(r#""nodes":[{}],"scenes":[{"nodes":["#, "0", "]}]")),
        ("instances".into(), repeated(&format!("{TRIANGLE}\"nodes\":["), r#"{"mesh":0}"#, "]")),
        ("joints".into(), {
            let before = format!("{TRIANGLE}\"nodes\":[{{\"mesh\":0,\"skin\":0}}],\"skins\":[{{\"joints\":[");
            repeated(&before, "0", "]}]")
        }),
        ("channels".into(), repeated(&format!("{animated}{{\"samplers\":[],\"channels\":["), channel, "]}]")),
        ("lights".into(), {
            let before = r#""extensions":{"KHR_lights_punctual":{"lights":["#;
            repeated(before, r#"{"type":"spot"}"#, "]}}")
        }),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let path = folder.path().join("scene.gltf");
    for (what, text) in cases {
        std::fs::write(&path, &text).expect("the temporary folder can be written");
        let (loaded, most, _) = counted(&path, &Options::default());
        let ratio = most as f64 / text.len() as f64;
        let what: String = what.chars().take(60).collect();
        println!("{what}: {ratio:.1} bytes a byte, {:?}", loaded.err());
        assert!(ratio <= 60.0, "{what}: {ratio:.1} bytes for each byte of text");
    }
}

fn a_file_that_is_named_in_many_ways_is_read_once() {
    const BYTES: usize = 1 << 20;
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    std::fs::write(folder.path().join("a.bin"), vec![0; BYTES]).expect("the temporary folder can be written");
    let buffer = |i: usize| format!(r#"{{"byteLength":{BYTES},"uri":"{}%61.bin"}}"#, "./".repeat(i));
    let buffers: Vec<String> = (0..100).map(buffer).collect();
    let text = format!(r#"{{"asset":{{"version":"2.0"}},"buffers":[{}]}}"#, buffers.join(","));
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, text).expect("the temporary folder can be written");
    let (loaded, most, _) = counted(&path, &Options::default());
    assert!(loaded.is_ok() && most < 3 * BYTES, "{most} bytes, {:?}", loaded.err());
}

/// A textured triangle, in a folder with its image.
fn textured(folder: &Path, image: &DynamicImage, format: ImageFormat) -> std::path::PathBuf {
    image.save_with_format(folder.join("image"), format).expect("the temporary folder can be written");
    let text = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
        "accessors":[{"componentType":5126,"count":3,"type":"VEC3"}],
        "materials":[{"pbrMetallicRoughness":{"metallicFactor":0,"baseColorTexture":{"index":0}}}],
        "textures":[{"source":0}],"images":[{"uri":"image"}]}"#;
    let path = folder.join("scene.gltf");
    std::fs::write(&path, text).expect("the temporary folder can be written");
    path
}

fn an_image_takes_four_bytes_a_pixel_while_it_is_decoded_and_after() {
    const SIDE: u32 = 1024;
    const PIXELS: usize = (SIDE * SIDE) as usize;
    let shade = |x: u32, y: u32| ((x * 64) ^ (y * 63)) as u16;
    let rgba16 = ImageBuffer::from_fn(SIDE, SIDE, |x, y| Rgba([shade(x, y), 7, 9, 40_000]));
    let rgb16 = ImageBuffer::from_fn(SIDE, SIDE, |x, y| Rgb([shade(x, y), 7, 9]));
    let rgb8 = ImageBuffer::from_fn(SIDE, SIDE, |x, y| Rgb([(x / 8) as u8, (y / 8) as u8, 9]));
    let grey = ImageBuffer::from_fn(SIDE, SIDE, |x, y| Luma([(x / 8 + y / 8) as u8]));
    for (image, format) in [
        (DynamicImage::ImageRgba16(rgba16), ImageFormat::Png),
        (DynamicImage::ImageRgb16(rgb16), ImageFormat::Png),
        (DynamicImage::ImageRgb8(rgb8.clone()), ImageFormat::Png),
        (DynamicImage::ImageLuma8(grey.clone()), ImageFormat::Png),
        (DynamicImage::ImageRgb8(rgb8), ImageFormat::Jpeg),
        (DynamicImage::ImageLuma8(grey), ImageFormat::Jpeg),
    ] {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let path = textured(folder.path(), &image, format);
        let file = std::fs::metadata(folder.path().join("image")).expect("the image is there").len() as usize;
        let kind = image.color();
        drop(image);
        let (loaded, most, held) = counted(&path, &Options::default());
        assert_eq!(loaded.expect("a good scene").world.material_set.textures[0].texels.len(), PIXELS);
        // The file is held while it is read, by a decoder of JPEG twice; a decoder needs some rows
        // and tables.
        let (allowed, kept) = (4 * PIXELS + 2 * file + (1 << 19), 4 * PIXELS + (1 << 16));
        println!("{kind:?} {format:?}: {most} bytes, then {held}, for {PIXELS} pixels and a file of {file} bytes");
        assert!(most <= allowed && held <= kept, "{kind:?} {format:?}: {most} of {allowed}, {held} of {kept} bytes");
    }
}

fn an_image_beyond_the_bound_is_not_decoded() {
    const SIDE: u32 = 512;
    let image = DynamicImage::ImageRgb8(ImageBuffer::from_pixel(SIDE, SIDE, Rgb([1, 2, 3])));
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let path = textured(folder.path(), &image, ImageFormat::Png);
    let bytes = u64::from(4 * SIDE * SIDE);
    for (max_texture_bytes, textures) in [(bytes, 1), (bytes - 1, 0), (0, 0)] {
        let (loaded, most, _) = counted(&path, &Options::new().max_texture_bytes(max_texture_bytes));
        let loaded = loaded.expect("a scene, with or without its texture");
        assert_eq!((loaded.world.material_set.textures.len(), loaded.notes.len()), (textures, 1 - textures));
        assert!(textures == 1 || most < 1 << 18, "{most} bytes");
        let note = format!("image 0 needs {bytes} bytes, where textures may take {max_texture_bytes} more");
        assert!(loaded.notes.iter().all(|line| line.starts_with(&note)), "{:?}", loaded.notes);
    }
}

/// One after the other, since the allocations of the whole process are counted.
#[test]
fn memory_is_bounded_by_what_is_loaded() {
    json_takes_at_most_60_bytes_for_each_of_its_own();
    a_file_that_is_named_in_many_ways_is_read_once();
    an_image_takes_four_bytes_a_pixel_while_it_is_decoded_and_after();
    an_image_beyond_the_bound_is_not_decoded();
}
