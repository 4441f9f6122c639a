//! Cases: small files that say what is measured, and what the answers must be.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use crate::failure::Failure;
use crate::rays::RayKind;
use crate::scene::SceneChoice;

/// What is measured about one scene.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Case {
    /// The name in tables and results.
    pub(crate) name: String,
    /// What is traced.
    pub(crate) scene: SceneChoice,
    /// The camera; by default one of the scene, or else one that shows most of it.
    #[serde(default, alias = "eye")]
    pub(crate) camera: Option<CameraChoice>,
    /// The seed of everything random about the rays.
    pub(crate) seed: u64,
    /// The number of triangles of the scene, if it is known. If a file of the same name has another
    /// number, no hits are expected of it.
    #[serde(default)]
    pub(crate) triangles: Option<usize>,
    /// About how many rays a set has; the shuffled set has four times as many.
    pub(crate) rays: usize,
    /// The same for a quick run.
    pub(crate) quick_rays: usize,
    /// Which sets of rays are traced; all by default.
    #[serde(default = "all_kinds")]
    pub(crate) sets: Vec<RayKind>,
    /// Names of engines, or their first letters; all engines by default.
    #[serde(default)]
    pub(crate) engines: Vec<String>,
    /// The same for a quick run, where slow builders would take all the time.
    #[serde(default)]
    pub(crate) quick_engines: Vec<String>,
    /// How many rays of a set must hit something, in a full run and in a quick one.
    #[serde(default)]
    pub(crate) hits: BTreeMap<RayKind, Hits>,
}

/// A camera as it is written in a case file.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraChoice {
    /// Metres, world space.
    pub(crate) position: [f32; 3],
    /// The direction of view; of any length.
    pub(crate) forward: [f32; 3],
    /// The tangent of half the angle of view.
    pub(crate) half: f32,
}

impl CameraChoice {
    /// A point in the direction of view, world space.
    pub(crate) fn target(&self) -> glam::Vec3 {
        glam::Vec3::from(self.position) + glam::Vec3::from(self.forward)
    }
}

/// The number of rays of a set that must hit something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hits {
    /// In a full run.
    pub(crate) full: Option<usize>,
    /// In a quick run.
    pub(crate) quick: Option<usize>,
}

fn all_kinds() -> Vec<RayKind> {
    RayKind::ALL.to_vec()
}

/// The cases that come with the program and are always measured.
const BUILT_IN: [&str; 4] = [
    include_str!("../cases/race.toml"),
    include_str!("../cases/terrain.toml"),
    include_str!("../cases/pile.toml"),
    include_str!("../cases/long_diagonals.toml"),
];

/// Cameras and expected hits of files that do not come with the program, used when one of them is
/// named on the command line.
const KNOWN: [&str; 5] = [
    include_str!("../cases/files/stanford_bunny.toml"),
    include_str!("../cases/files/kitchen_country.toml"),
    include_str!("../cases/files/race_black_forest.toml"),
    include_str!("../cases/files/teapot_in_stadium_a.toml"),
    include_str!("../cases/files/thin_diagonals_a.toml"),
];

/// By how many rays the hits of a set may differ from what the case says: one in a thousand, plus
/// two. The start of a ray that begins at a hit depends on the rounding of libraries and compilers,
/// and on which of two triangles at the same distance was hit. Four bounces add up: one in two
/// hundred.
pub(crate) fn leeway(kind: RayKind, rays: usize) -> usize {
    let one_in = if kind == RayKind::Bounce4 { 200 } else { 1000 };
    rays / one_in + 2
}

impl Case {
    /// The cases that come with the program.
    pub(crate) fn built_in() -> Result<Vec<Self>, Failure> {
        BUILT_IN.iter().map(|text| Self::parse(text)).collect()
    }

    /// Parses the text of a case file.
    pub(crate) fn parse(text: &str) -> Result<Self, Failure> {
        Ok(toml::from_str(text)?)
    }

    /// The case for a path from the command line: a case file, or a glTF file with the usual rays.
    pub(crate) fn of_file(path: &Path) -> Result<Self, Failure> {
        if path.extension().is_some_and(|extension| extension == "toml") {
            let mut case = Self::parse(&std::fs::read_to_string(path)?)?;
            if let (SceneChoice::File { path: scene, .. }, Some(folder)) = (&mut case.scene, path.parent()) {
                *scene = folder.join(&scene);
            }
            return Ok(case);
        }
        for text in KNOWN {
            let mut case = Self::parse(text)?;
            if let SceneChoice::File { path: known, .. } = &mut case.scene
                && known.file_name() == path.file_name()
            {
                *known = path.into();
                return Ok(case);
            }
        }
        let name = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
        Ok(Self {
            name,
            scene: SceneChoice::File { path: path.into(), time: 0.0 },
            camera: None,
            seed: 1,
            triangles: None,
            rays: 1 << 18,
            quick_rays: 1 << 14,
            sets: all_kinds(),
            engines: Vec::new(),
            quick_engines: Vec::new(),
            hits: BTreeMap::new(),
        })
    }

    /// Whether an engine takes part.
    pub(crate) fn wants(&self, engine: &str, quick: bool) -> bool {
        let named = |names: &[String]| names.is_empty() || names.iter().any(|start| engine.starts_with(start.as_str()));
        named(&self.engines) && (!quick || named(&self.quick_engines))
    }

    /// About how many rays a set has.
    pub(crate) fn count(&self, kind: RayKind, quick: bool) -> usize {
        let count = if quick { self.quick_rays } else { self.rays };
        if kind == RayKind::DiffuseShuffled { 4 * count } else { count }
    }

    /// How many rays of a set must hit something, if that is known for a scene with this number of
    /// triangles.
    pub(crate) fn expected(&self, kind: RayKind, quick: bool, triangles: usize) -> Option<usize> {
        if self.triangles.is_some_and(|known| known != triangles) {
            return None;
        }
        self.hits.get(&kind).and_then(|hits| if quick { hits.quick } else { hits.full })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cases_of_the_program_can_be_read() {
        let cases = Case::built_in().unwrap();
        assert_eq!(cases.len(), BUILT_IN.len());
        assert!(cases.iter().all(|case| case.quick_rays <= case.rays && !case.sets.is_empty()));
        assert!(KNOWN.iter().all(|text| Case::parse(text).is_ok_and(|case| case.triangles.is_some())));
        let known = Case::of_file(Path::new("somewhere/stanford_bunny.glb")).unwrap();
        let here = SceneChoice::File { path: "somewhere/stanford_bunny.glb".into(), time: 0.0 };
        assert!(known.triangles == Some(69_630) && known.scene == here);
        assert_eq!(Case::of_file(Path::new("other.glb")).unwrap().triangles, None);
    }

    #[test]
    fn one_ray_in_a_thousand_may_differ_and_more_only_after_four_bounces() {
        for kind in RayKind::ALL {
            let expected = if kind == RayKind::Bounce4 { 52 } else { 12 };
            assert_eq!(leeway(kind, 10_000), expected, "{kind:?}");
        }
    }

    #[test]
    fn what_a_case_does_not_know_is_refused() {
        assert!(Case::parse("name = 'x'\nspeed = 3").is_err());
        let text = "name='x'\nseed=1\nrays=64\nquick_rays=64\nengines=['embree']\n[scene]\nkind='pile'\nseed=1\ntriangles=9\n[hits.axis]\nquick=5\n";
        let case = Case::parse(text).unwrap();
        assert!(case.wants("embree medium", true) && !case.wants("obvhs", false));
        assert_eq!((case.expected(RayKind::Axis, true, 9), case.expected(RayKind::Axis, false, 9)), (Some(5), None));
        assert_eq!((case.count(RayKind::Axis, true), case.count(RayKind::DiffuseShuffled, true)), (64, 256));
        let other = Case { triangles: Some(8), ..case };
        assert_eq!(other.expected(RayKind::Axis, true, 9), None);
    }
}
