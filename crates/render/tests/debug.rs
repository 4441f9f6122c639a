//! `Debug` of pictures fits on a screen.

use kinetree_render::Film;

#[test]
fn debug_prints_sizes_and_not_contents() {
    let text = format!("{:?}", Film::new(300, 200));
    assert!(text.len() < 200 && text.contains("width: 300"), "{} letters: {text:.200}", text.len());
}
