//! Renders a glTF file to a portable float map (PFM), linear and unexposed: for comparisons with
//! other renderers.
//!
//! `cargo run --release -p kinetree-gltf --example film -- scene.gltf out.pfm width height spp seed
//! ex,ey,ez tx,ty,tz degrees [zenith horizon ground]`, the last three r,g,b each, for a sky.
//! `scripts/reference_pictures.py` uses it.

use std::error::Error;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;

use kinetree_render::{Film, Settings, render};
use kinetree_world::{Camera, Sky};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, out, width, height, spp, seed, eye, target, degrees, sky @ ..] = &arguments[..] else {
        return Err("scene out width height spp seed eye target degrees [zenith horizon ground]".into());
    };
    let mut world = kinetree_gltf::load(Path::new(scene))?.world;
    if let [zenith, horizon, ground] = sky {
        let (zenith, horizon, ground) = (triple(zenith)?, triple(horizon)?, triple(ground)?);
        world.sky = Sky::Gradient { zenith, horizon, ground };
    }
    let camera = Camera::look_at(triple(eye)?, triple(target)?, degrees.parse::<f32>()?.to_radians());
    let settings = Settings {
        width: width.parse()?,
        height: height.parse()?,
        spp: spp.parse()?,
        seed: seed.parse()?,
        ..Settings::default()
    };
    let rendered = render(&world.frame(0.0)?, &camera, &settings, &|_| ControlFlow::Continue(()))?;
    if rendered.lost_samples > 0 {
        return Err(format!("{} samples were lost", rendered.lost_samples).into());
    }
    std::fs::write(out, pfm(&rendered.film)?)?;
    Ok(())
}

fn triple(text: &str) -> Result<[f32; 3], Box<dyn Error>> {
    let numbers: Vec<f32> = text.split(',').map(str::parse).collect::<Result<_, _>>()?;
    Ok(<[f32; 3]>::try_from(numbers).map_err(|_| format!("{text} is not three numbers"))?)
}

/// Little-endian, rows from the bottom.
fn pfm(film: &Film) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write!(bytes, "PF\n{} {}\n-1.0\n", film.width(), film.height())?;
    for y in (0..film.height()).rev() {
        for x in 0..film.width() {
            film.pixel([x, y]).iter().for_each(|channel| bytes.extend(channel.to_le_bytes()));
        }
    }
    Ok(bytes)
}
