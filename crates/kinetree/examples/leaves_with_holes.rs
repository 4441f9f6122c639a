//! A filter (any-hit) decides where a leaf has holes: shadow rays pass through them, and stop at
//! the solid parts.

use kinetree::{Affine, Candidate, EditError, Mesh, Motion, Ray, Scene};

fn main() -> Result<(), EditError> {
    let square = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]];
    let mut scene = Scene::new();
    let leaf = scene.add_mesh(Mesh::new(&square, &[[0, 2, 1], [0, 3, 2]])?, Motion::Static)?;
    scene.add_instance(scene.root(), leaf, Affine::from_translation([0.0, 2.0, 0.0]))?;
    let view = scene.commit();

    // Round holes on a grid: a game would look into the leaf's alpha texture here.
    let solid = |candidate: &Candidate<'_>| {
        let (u, v) = ((candidate.u() * 4.0).fract() - 0.5, (candidate.v() * 4.0).fract() - 0.5);
        u * u + v * v > 0.1
    };
    let shadows = view.query().filter(&solid);
    for z in -10..10 {
        let row: String = (-20..20)
            .map(|x| {
                let ground = [x as f32 / 18.0, 0.0, z as f32 / 9.0];
                if shadows.occluded(&Ray::new(ground, [0.0, 1.0, 0.0])) { '#' } else { '.' }
            })
            .collect();
        println!("{row}");
    }
    Ok(())
}
