//! The fast integrator against its slow twin, and pictures against themselves.

mod common;

use std::ops::ControlFlow;

use common::{Estimate, Model, Shape, picture, placed, settings};
use kinetree::{Affine, Motion, Ray};
use kinetree_render::{Film, Integrator, IntegratorKind, Sampler, Settings, Tracer, render_with};
use kinetree_world::{Alpha, Camera, Filter, Frame, Light, Material, Scatter, Sky, Texture, Wrap};

/// All features at once: area lights, a sun with a disc, a sky, glass, thin glass, textures, masked
/// and blended alpha.
fn everything() -> Frame {
    let mut model = Model::default();
    let board = (0..64).map(|i| if (i + i / 8) % 2 == 0 { [230, 200, 60, 255] } else { [40, 60, 200, 90] }).collect();
    model.material_set.textures.push(Texture {
        width: 8,
        height: 8,
        texels: board,
        srgb: true,
        wrap: [Wrap::Repeat; 2],
        filter: Filter::Bilinear,
    });
    model.sky = Sky::Gradient { zenith: [0.3, 0.5, 0.9], horizon: [0.8; 3], ground: [0.1; 3] };
    let textured = |material: Material| Material { base_color_texture: Some(0.into()), ..material };
    let thin_glass = Material { scatter: Scatter::ThinDielectric { ior: 1.5 }, ..Material::diffuse([0.8, 1.0, 0.9]) };
    let glowing = Material { emission_texture: Some(0.into()), ..Material::emissive([6.0, 5.0, 4.0]) };
    let at = |scale: f32, position| placed([scale; 3], [0.3, 1.0, 0.2], 0.4, position);
    model
        .with(&Shape::square(), textured(Material::diffuse([0.7; 3])), Affine::from_scale([12.0; 3]))
        .with(&Shape::sphere(16).smooth(), Material::glass(1.5), at(0.6, [-0.8, 0.8, 0.0]))
        .with_moving(
            &Shape::sphere(6).smooth(),
            Material::diffuse([0.6, 0.3, 0.2]),
            at(0.5, [1.0, 0.5, 0.6]),
            Motion::Rigid,
        )
        .with(&Shape::square(), thin_glass, placed([1.5; 3], [1.0, 0.0, 0.0], 1.2, [1.0, 0.9, 1.4]))
        .with(
            &Shape::square(),
            Material { alpha: Alpha::Mask { cutoff: 0.6 }, ..textured(Material::diffuse([0.5; 3])) },
            placed([1.2; 3], [0.0, 0.0, 1.0], 1.3, [-2.0, 0.7, 0.5]),
        )
        .with_moving(
            &Shape::square(),
            Material { alpha: Alpha::Blend, ..textured(Material::diffuse([0.9, 0.2, 0.2])) },
            placed([2.0; 3], [1.0, 0.0, 0.0], 0.3, [0.0, 2.0, 0.3]),
            Motion::Deforming,
        )
        .with_moving(
            &Shape::square(),
            glowing,
            placed([1.0, 1.0, 2.0], [1.0, 0.0, 0.0], 2.8, [0.0, 2.6, -1.0]),
            Motion::Dynamic,
        )
        .with(
            &Shape::cube(),
            Material { two_sided: false, emission: [3.0, 1.0, 0.5], ..Material::diffuse([0.4; 3]) },
            placed([0.1, 0.5, -0.2], [0.0, 1.0, 0.0], 0.5, [2.0, 0.5, -1.0]),
        )
        .lit_by(Light::Sun { direction: [0.4, -0.8, -0.3], irradiance: [1.0; 3], angle: 0.5 })
        .lit_by(Light::Point { position: [0.0, 1.5, 2.0], intensity: [1.0; 3], range: 20.0 })
        .frame()
}

fn camera() -> Camera {
    Camera::look_at([0.5, 1.8, 5.0], [0.0, 0.7, 0.0], 0.8)
}

#[test]
fn light_sampling_changes_the_noise_and_not_the_mean() {
    let frame = everything();
    // Blocks of the picture, each estimated with several seeds.
    let blocks = |kind, spp| {
        let runs: Vec<Vec<[f32; 3]>> = (0..8)
            .map(|seed| {
                let settings = Settings { seed, ..settings(kind, 32, spp) };
                let film = picture(&frame, &camera(), &settings).film;
                let mut sums = vec![[0.0_f32; 3]; 16];
                for y in 0..32 {
                    for x in 0..32 {
                        let sum = &mut sums[(y / 8 * 4 + x / 8) as usize];
                        *sum = std::array::from_fn(|channel| sum[channel] + film.pixel([x, y])[channel] / 64.0);
                    }
                }
                sums
            })
            .collect();
        (0..16 * 3)
            .map(|i| Estimate::of(&runs.iter().map(|run| f64::from(run[i / 3][i % 3])).collect::<Vec<_>>()))
            .collect::<Vec<_>>()
    };
    let (simple, path) = (blocks(IntegratorKind::Simple, 128), blocks(IntegratorKind::Path, 32));
    let mut distance = 0.0;
    for (index, (simple, path)) in simple.iter().zip(&path).enumerate() {
        let error = (simple.error.powi(2) + path.error.powi(2)).sqrt();
        let apart = (simple.mean - path.mean).abs() / error;
        // Errors are estimated from eight runs: Student's t with some fourteen degrees of freedom
        // exceeds six about once in 30 000.
        assert!(apart < 6.0, "block {}, channel {}: {simple:?} {path:?}", index / 3, index % 3);
        assert!(error < 0.03 * path.mean, "block {}: too noisy to tell: {simple:?} {path:?}", index / 3);
        distance += (simple.mean - path.mean) / path.mean / 48.0;
    }
    assert!(distance.abs() < 0.003, "a bias of {distance}");
}

/// An integrator without a batched version of its own.
struct OneByOne(Box<dyn Integrator>);

impl Integrator for OneByOne {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: &Ray, sampler: &mut Sampler) -> [f32; 3] {
        self.0.radiance(tracer, ray, sampler)
    }
}

#[test]
fn many_rays_together_give_the_colours_of_single_rays_to_the_bit() {
    let frame = everything();
    for kind in IntegratorKind::ALL {
        // More samples than one batch, and fewer; paths that end early or late; with and without
        // light clamped.
        for (size, spp, max_depth, clamp) in
            [(40, 5, 64, None), (21, 90, 3, None), (9, 1, 64, Some(0.5)), (5, 1, 0, None)]
        {
            let settings = Settings { height: size / 2 + 3, max_depth, clamp, ..settings(kind, size, spp) };
            let together = picture(&frame, &camera(), &settings);
            let one_by_one = OneByOne(kind.with(&settings));
            let one_by_one = render_with(&one_by_one, &frame, &camera(), &settings, &|_| ControlFlow::Continue(()));
            let one_by_one = one_by_one.expect("good settings");
            let bits = |film: &Film| film.pixels().iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert!(bits(&together.film) == bits(&one_by_one.film), "{kind}, {settings:?}");
            assert_eq!(together.rays, one_by_one.rays, "{kind}, {settings:?}");
        }
    }
}

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() {
    let frame = everything();
    for kind in IntegratorKind::ALL {
        let with = |threads| {
            let settings = Settings { width: 50, height: 35, threads, ..settings(kind, 0, 3) };
            let picture = picture(&frame, &camera(), &settings);
            let bits: Vec<u32> = picture.film.pixels().iter().flatten().map(|channel| channel.to_bits()).collect();
            (bits, picture.rays)
        };
        let one = with(Some(1));
        assert!(one == with(Some(2)) && one == with(Some(5)) && one == with(None), "{kind}");
        assert!(one.1 >= 50 * 35 * 3, "{kind}: {} rays", one.1);
    }
}

#[test]
fn another_seed_is_other_noise_and_later_samples_complement_earlier_ones() {
    let frame = everything();
    let with = |seed, first_sample, spp| {
        let settings = Settings { seed, first_sample, ..settings(IntegratorKind::Path, 16, spp) };
        picture(&frame, &camera(), &settings).film
    };
    assert_ne!(with(0, 0, 4), with(1, 0, 4));
    let (first, second, both) = (with(0, 0, 4), with(0, 4, 4), with(0, 0, 8));
    for (pixel, together) in both.pixels().iter().enumerate() {
        let mean = 0.5 * (first.pixels()[pixel][1] + second.pixels()[pixel][1]);
        assert!((mean - together[1]).abs() < 1e-5 * (1.0 + mean));
    }
}
