//! A cloth in the wind: the same triangles with other positions in every frame. Its tree is
//! refitted, and rebuilt only when it has drifted.

use kinetree::{Affine, EditError, Mesh, Motion, Ray, Scene};

const SIDE: u32 = 64;

fn main() -> Result<(), EditError> {
    let mut scene = Scene::new();
    let mut triangles = Vec::new();
    for y in 0..SIDE - 1 {
        for x in 0..SIDE - 1 {
            let at = y * SIDE + x;
            triangles.extend([[at, at + 1, at + SIDE], [at + 1, at + SIDE + 1, at + SIDE]]);
        }
    }
    let cloth = scene.add_mesh(Mesh::new(&waving(0.0), &triangles)?, Motion::Deforming)?;
    scene.add_instance(scene.root(), cloth, Affine::IDENTITY)?;

    for frame in 0..6 {
        scene.set_positions(cloth, &waving(frame as f32 * 0.1))?;
        let view = scene.commit();
        let hit = view.closest_hit(&Ray::new([0.31, 0.52, 5.0], [0.0, 0.0, -1.0]));
        let mesh = &view.report().meshes[0];
        println!(
            "frame {frame}: {} ({}), drift {:.3}, hit at {:?}",
            mesh.action,
            mesh.reason,
            mesh.drift,
            hit.map(|hit| hit.t)
        );
    }
    Ok(())
}

/// Metres; the left edge hangs on its pole.
fn waving(seconds: f32) -> Vec<[f32; 3]> {
    (0..SIDE * SIDE)
        .map(|i| {
            let (x, y) = ((i % SIDE) as f32 / SIDE as f32, (i / SIDE) as f32 / SIDE as f32);
            [x, y, 0.2 * x * (9.0 * x - 20.0 * seconds + 2.0 * y).sin()]
        })
        .collect()
}
