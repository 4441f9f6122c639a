//! `Debug` of worlds, frames and what they hold fits on a screen.

use kinetree::{Affine, Mesh, Motion, Scene};
use kinetree_world::{Filter, Material, MaterialSet, Surface, Texture, World, Wrap};

#[test]
fn debug_prints_sizes_and_not_contents() {
    let mut scene = Scene::new();
    let positions: Vec<[f32; 3]> = (0..3000).map(|i| [i as f32, (i % 3) as f32, 0.0]).collect();
    let triangles: Vec<[u32; 3]> = (0..1000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = Mesh::new(&positions, &triangles).expect("a good mesh");
    let mesh = scene.add_mesh(mesh, Motion::Static).expect("a mesh fits");
    let instance = scene.add_instance(scene.root(), mesh, Affine::IDENTITY).expect("an instance fits");
    let mut world = World::new(scene);

    let (texels, wrap) = (vec![[1; 4]; 256 * 256], [Wrap::default(); 2]);
    let texture = Texture { width: 256, height: 256, texels, srgb: true, wrap, filter: Filter::default() };
    let surface = Surface { uvs: vec![[0.5; 2]; 3000], ..Surface::default() };
    let texts = [(format!("{texture:?}"), "height: 256"), (format!("{surface:?}"), "uvs: 3000")];
    let (materials, textures) = (vec![Material::default(); 70], vec![texture; 2]);
    world.material_set = MaterialSet { materials, textures, surfaces: vec![surface] }.into();
    world.material_bindings.bind(instance, 0);
    let frame = world.frame(0.0).expect("nothing moves");
    let set = (format!("{:?}", world.material_set), "materials: 70");
    let bindings = (format!("{:?}", world.material_bindings), "instances: 1");
    let [world, frame] = [(format!("{world:?}"), "cameras: 0"), (format!("{frame:?}"), "time: 0.0")];
    for (text, figure) in texts.into_iter().chain([set, bindings, world, frame]) {
        assert!(text.len() < 600 && text.contains(figure), "{} letters: {text:.800}", text.len());
    }
}
