//! Two windmills from one file stand in a scene of the caller's; one is taken out again while the
//! other goes on.
//!
//! `cargo run -p kinetree-gltf --example windmills`, with a path for another file.

use std::error::Error;

use kinetree::{Affine, Ray, Scene};
use kinetree_gltf::{Clip, Options, Source, read};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1);
    let source = path.as_deref().map_or(Source::from(&include_bytes!("windmill.gltf")[..]), Source::from);
    // A file is read on any thread; what is read is then inserted as often as needed.
    let asset = read(source, &Options::new())?;
    let mut scene = Scene::new();
    let root = scene.root();
    let mut left = asset.load_into(&mut scene, root)?;
    let mut right = asset.load_into(&mut scene, root)?;
    scene.place(right.root(), Affine::from_translation([10.0, 0.0, 0.0]))?;

    for frame in 0..8 {
        let seconds = f64::from(frame) / 2.0;
        if frame < 4 {
            left.player.go_to(&mut scene, &Clip::Together, seconds)?;
        } else if frame == 4 {
            left.remove(&mut scene)?;
        }
        right.player.go_to(&mut scene, &Clip::Together, 0.5 * seconds)?;
        let view = scene.commit();
        for (name, mill, x) in [("left", &left, 1.0), ("right", &right, 11.0)] {
            let hit = view.closest_hit(&Ray::new([x, 3.5, 10.0], [0.0, 0.0, -1.0]));
            let material = hit.and_then(|hit| mill.material(view.instance_id(&hit), hit.primitive));
            let color = material.map(|material| material.base_color);
            println!("{seconds:.1} s: beside the hub of the {name} mill: {color:?}");
        }
    }
    Ok(())
}
