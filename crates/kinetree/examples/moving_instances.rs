//! A car with turning wheels drives past a camera; each frame finds what is in the middle of the
//! picture.

use kinetree::{Affine, EditError, Mesh, Motion, Ray, Scene};

fn main() -> Result<(), EditError> {
    let mut scene = Scene::new();
    let body = scene.add_mesh(slab(2.0, 0.6, 1.0)?, Motion::Rigid)?;
    let wheel = scene.add_mesh(slab(0.4, 0.4, 0.1)?, Motion::Rigid)?;

    let car = scene.add_node(scene.root(), Affine::IDENTITY)?;
    scene.add_instance(car, body, Affine::IDENTITY)?;
    let mut axles = Vec::new();
    for (x, z) in [(-1.3, 1.0), (1.3, 1.0), (-1.3, -1.0), (1.3, -1.0)] {
        let hub = scene.add_node(car, Affine::from_translation([x, -0.6, z]))?;
        let axle = scene.add_node(hub, Affine::IDENTITY)?;
        scene.add_instance(axle, wheel, Affine::IDENTITY)?;
        axles.push(axle);
    }

    let middle = Ray::new([0.0, -0.5, 10.0], [0.0, 0.0, -1.0]);
    for frame in 0..9 {
        let way = frame as f32 - 4.0;
        scene.place(car, Affine::from_translation([way, 0.0, 0.0]))?;
        for axle in &axles {
            scene.place(*axle, Affine::from_axis_angle([0.0, 0.0, 1.0], -way / 0.4))?;
        }
        let view = scene.commit();
        match view.closest_hit(&middle) {
            Some(hit) if view.mesh_id(&hit) == wheel => println!("car at {way:+}: a wheel, {:.2} m away", hit.t),
            Some(hit) => println!("car at {way:+}: the body, {:.2} m away", hit.t),
            None => println!("car at {way:+}: nothing"),
        }
    }
    Ok(())
}

/// A box with half the given size on each side of its middle.
fn slab(x: f32, y: f32, z: f32) -> Result<Mesh, EditError> {
    let corners: Vec<[f32; 3]> = (0..8)
        .map(|corner| {
            [(corner & 1, x), (corner >> 1 & 1, y), (corner >> 2, z)]
                .map(|(bit, half)| if bit == 1 { half } else { -half })
        })
        .collect();
    let sides = [[0_u32, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Ok(Mesh::new(&corners, &triangles)?)
}
