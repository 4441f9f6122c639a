//! The materials of the race, by name.

use kinetree_world::{Alpha, Material, MaterialSet, Scatter, Texture, TextureRef};

use crate::textures;

/// Indices into [`MaterialSet::materials`]. Unless said otherwise, colours come from the vertices.
pub(crate) struct Palette {
    /// Diffuse, coloured by the vertices: most things.
    pub(crate) paint: u32,
    /// Textured in metres.
    pub(crate) asphalt: u32,
    /// Textured in metres.
    pub(crate) grass: u32,
    /// Eight by eight squares.
    pub(crate) chequer: u32,
    /// Twigs of round leaves, of slim leaves.
    pub(crate) leaves: [u32; 2],
    /// Branches of needles.
    pub(crate) needles: u32,
    /// Slightly tinted glass of one layer.
    pub(crate) glass: u32,
    /// The clear coat over a car's paint.
    pub(crate) coat: u32,
    /// White light.
    pub(crate) headlamp: u32,
    /// Red light.
    pub(crate) tail_lamp: u32,
    /// The green lamps of the start.
    pub(crate) start_lamp: u32,
    /// Translucent puffs.
    pub(crate) smoke: u32,
    /// Advertising boards.
    pub(crate) boards: [u32; 5],
    /// The paint of the two cars.
    pub(crate) liveries: [u32; 2],
}

impl Palette {
    /// Paints the textures, and adds them and all materials to a set.
    pub(crate) fn new(seed: u64, material_set: &mut MaterialSet) -> Self {
        let mut add = |material: Material| {
            material_set.materials.push(material);
            material_set.materials.len() as u32 - 1
        };
        let mut textures = Vec::new();
        let mut image = |texture: Texture| {
            textures.push(texture);
            Some(TextureRef::from(textures.len() as u32 - 1))
        };
        let textured = |texture| Material { base_color_texture: texture, ..Material::default() };
        let masked = |texture| Material { alpha: Alpha::Mask { cutoff: 0.5 }, ..textured(texture) };
        let sheet = |color: [f32; 4]| Material {
            base_color: color,
            scatter: Scatter::ThinDielectric { ior: 1.5 },
            ..Material::default()
        };
        let palette = Self {
            paint: add(Material::default()),
            asphalt: add(textured(image(textures::asphalt(seed)))),
            grass: add(textured(image(textures::grass(seed)))),
            chequer: add(textured(image(textures::chequer()))),
            leaves: [(46, 0.62), (70, 0.34)]
                .map(|(count, slimness)| add(masked(image(textures::leaves(seed, count, slimness))))),
            needles: add(masked(image(textures::needles(seed)))),
            glass: add(sheet([0.62, 0.70, 0.72, 1.0])),
            coat: add(sheet([1.0; 4])),
            headlamp: add(Material::emissive([9.0, 8.4, 7.0])),
            tail_lamp: add(Material::emissive([5.0, 0.12, 0.06])),
            start_lamp: add(Material::emissive([0.3, 6.0, 0.8])),
            smoke: add(Material {
                base_color: [0.86, 0.84, 0.82, 0.30],
                alpha: Alpha::Blend,
                ..textured(image(textures::puff(seed)))
            }),
            boards: [
                ("KINETREE", [248, 246, 240, 255], [196, 24, 30, 255]),
                ("REFIT", [22, 62, 138, 255], [250, 250, 250, 255]),
                ("SBVH", [250, 196, 20, 255], [20, 20, 24, 255]),
                ("PLOC", [24, 24, 28, 255], [255, 120, 20, 255]),
                ("SNAPSHOT", [14, 110, 84, 255], [250, 250, 244, 255]),
            ]
            .map(|(text, ground, ink)| add(textured(image(textures::board(text, ground, ink))))),
            liveries: [("7", [248, 176, 6, 255], [22, 22, 26, 255]), ("23", [18, 70, 176, 255], [255, 150, 20, 255])]
                .map(|(number, paint, stripe)| add(textured(image(textures::livery(number, paint, stripe, [250; 4]))))),
        };
        material_set.textures = textures;
        palette
    }
}
