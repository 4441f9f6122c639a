//! `Debug` of pictures, textures and surfaces fits on a screen.

use kinetree_render::Film;
use kinetree_world::{Filter, Surface, Texture, Wrap};

#[test]
fn debug_says_how_large_things_are_and_not_all_that_is_in_them() {
    let (texels, wrap) = (vec![[1; 4]; 256 * 256], [Wrap::default(); 2]);
    let texture = Texture { width: 256, height: 256, texels, srgb: true, wrap, filter: Filter::default() };
    let surface = Surface { uvs: vec![[0.5; 2]; 5000], ..Surface::default() };
    let texts = [format!("{texture:?}"), format!("{surface:?}"), format!("{:?}", Film::new(300, 200))];
    for (text, figure) in texts.iter().zip(["height: 256", "uvs: 5000", "width: 300"]) {
        assert!(text.len() < 200 && text.contains(figure), "{} letters: {:.200}", text.len(), text);
    }
}
