//! The procedural textures of the race.

use glam::Vec2;
use kinetree_world::{Filter, Texture};

use crate::canvas::Canvas;
use crate::rng::{Rng, fractal};

/// Grey, speckled, with worn patches. Tiles every 4 m or so.
pub(crate) fn asphalt(seed: u64) -> Texture {
    let mut rng = Rng::new(seed, 101);
    let mut canvas = Canvas::new(256, 256, [0; 4]);
    let grains: Vec<f32> = (0..256 * 256).map(|_| rng.range(-1.0, 1.0)).collect();
    canvas.paint(|x, y, _| {
        let patch = tiled(seed ^ 1, x, y, 256, 5.0);
        let level = 205.0 + 26.0 * patch + 24.0 * grains[(y * 256 + x) as usize];
        let level = level.clamp(0.0, 255.0) as u8;
        [level, level, level, 255]
    });
    canvas.finish(Filter::Bilinear)
}

/// Blades and tufts: multiplies the green of the ground.
pub(crate) fn grass(seed: u64) -> Texture {
    let mut rng = Rng::new(seed, 102);
    let mut canvas = Canvas::new(256, 256, [0; 4]);
    let grains: Vec<f32> = (0..256 * 256).map(|_| rng.range(-1.0, 1.0)).collect();
    canvas.paint(|x, y, _| {
        let blade = 0.6 * grains[(y * 256 + x) as usize] + 0.4 * grains[((y / 3) * 256 + x) as usize];
        let tuft = tiled(seed ^ 2, x, y, 256, 9.0);
        let level = (206.0 + 34.0 * blade + 34.0 * tuft).clamp(0.0, 255.0);
        [level as u8, level as u8, (level * 0.9) as u8, 255]
    });
    canvas.finish(Filter::Bilinear)
}

/// Noise that repeats at the edges of a square image.
fn tiled(seed: u64, x: u32, y: u32, size: u32, features: f32) -> f32 {
    let blend = |x: f32, y: f32| fractal(seed, x * features, y * features, 3);
    let (u, v) = (x as f32 / size as f32, y as f32 / size as f32);
    let row = |v: f32| blend(u, v) * (1.0 - u) + blend(u - 1.0, v) * u;
    row(v) * (1.0 - v) + row(v - 1.0) * v
}

/// White and black squares, eight by eight.
pub(crate) fn chequer() -> Texture {
    let mut canvas = Canvas::new(8, 8, [0; 4]);
    canvas.paint(|x, y, _| if (x + y) % 2 == 0 { [236, 236, 236, 255] } else { [16, 16, 18, 255] });
    canvas.finish(Filter::Nearest)
}

/// A twig of leaves on a transparent ground: alpha is the mask, grey the brightness of each leaf.
pub(crate) fn leaves(seed: u64, count: u32, slimness: f32) -> Texture {
    let mut rng = Rng::new(seed, 103 + u64::from(count));
    // The transparent texels have the colour of the leaves, so that filtering leaves no rim.
    let mut canvas = Canvas::new(128, 128, [190, 190, 190, 0]);
    for _ in 0..count {
        let place = Vec2::from_angle(rng.range(0.0, std::f32::consts::TAU)) * rng.unit().sqrt() * 48.0;
        let size = rng.range(8.0, 14.0);
        let level = rng.range(150.0, 250.0) as u8;
        let angle = place.to_angle() + rng.range(-0.9, 0.9);
        canvas.ellipse(place + Vec2::splat(64.0), Vec2::new(size, size * slimness), angle, [level, level, level, 255]);
    }
    canvas.finish_clamped()
}

/// A drooping branch of needles, stem at the top: alpha is the mask.
pub(crate) fn needles(seed: u64) -> Texture {
    let mut rng = Rng::new(seed, 104);
    let mut canvas = Canvas::new(128, 128, [180, 180, 180, 0]);
    for _ in 0..210 {
        let along = rng.unit();
        let spread = 12.0 + 46.0 * along * (1.15 - along) / 0.33;
        let side = if rng.chance(0.5) { 1.0 } else { -1.0 };
        let start = Vec2::new(64.0 + side * rng.unit() * spread * 0.6, 4.0 + along * 100.0);
        let angle = std::f32::consts::FRAC_PI_2 - side * rng.range(0.2, 1.0);
        let level = rng.range(120.0, 245.0) as u8;
        canvas.ellipse(start, Vec2::new(rng.range(9.0, 17.0), 2.1), angle, [level, level, level, 255]);
    }
    canvas.finish_clamped()
}

/// A puff that fades from its middle: alpha is the density.
pub(crate) fn puff(seed: u64) -> Texture {
    let mut canvas = Canvas::new(64, 64, [255, 255, 255, 0]);
    canvas.paint(|x, y, _| {
        let local = (Vec2::new(x as f32, y as f32) - 31.5) / 31.5;
        let billow = 0.75 + 0.5 * fractal(seed ^ 5, x as f32 / 14.0, y as f32 / 14.0, 3);
        let density = (1.0 - local.length_squared()).clamp(0.0, 1.0).powf(1.3) * billow;
        [255, 255, 255, (density.clamp(0.0, 1.0) * 255.0) as u8]
    });
    canvas.finish_clamped()
}

/// An advertising board with a name, a frame and two stripes.
pub(crate) fn board(text: &str, ground: [u8; 4], ink: [u8; 4]) -> Texture {
    let (width, height) = (256, 64);
    let mut canvas = Canvas::new(width, height, ground);
    canvas.rectangle([0, 0], [256, 4], ink).rectangle([0, 60], [256, 64], ink);
    let letters = text.chars().count() as i32 * 6 - 1;
    let dot = (220 / letters).clamp(2, 6);
    let left = (256 - letters * dot) / 2;
    canvas.text(text, [left, 32 - 7 * dot / 2], [dot, dot], [false; 2], ink);
    canvas.finish_clamped()
}

/// The paint of a car. Along the image: from the tail (left) to the nose. Across: from the right
/// sill (top) over the roof (middle) to the left sill.
pub(crate) fn livery(number: &str, paint: [u8; 4], stripe: [u8; 4], roundel: [u8; 4]) -> Texture {
    let (width, height) = (1024, 512);
    let mut canvas = Canvas::new(width, height, paint);
    for side in [-1, 1] {
        let stripe_at = 256 + side * 26;
        canvas.rectangle([0, stripe_at - 15], [1024, stripe_at + 15], stripe);
        // The sill and a wedge that rises to the tail.
        canvas.paint(|x, y, old| {
            let across = (f32::from(y as u16) - 256.0) * side as f32;
            let wedge = 238.0 - 62.0 * (1.0 - x as f32 / 520.0).max(0.0);
            if across > wedge { stripe } else { old }
        });
        canvas.ellipse(Vec2::new(452.0, 256.0 + side as f32 * 196.0), Vec2::new(58.0, 34.0), 0.0, roundel);
    }
    let dot = [9, 6];
    let (wide, high) = ((number.chars().count() as i32 * 6 - 1) * dot[0], 7 * dot[1]);
    // On the right side the image is upside down, on the left side it is mirrored.
    for (side, flip) in [(-1, [false, true]), (1, [true, false])] {
        canvas.text(number, [452 - wide / 2, 256 + side * 196 - high / 2], dot, flip, [12, 12, 14, 255]);
    }
    canvas.finish_clamped()
}
