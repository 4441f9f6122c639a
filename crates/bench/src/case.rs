//! Cases: small files that say what is measured.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use crate::Failure;
use crate::rays::Kind;
use crate::scene::SceneChoice;

/// What is measured about one scene.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Case {
    /// In tables and results.
    pub(crate) name: String,
    /// What is traced.
    pub(crate) scene: SceneChoice,
    /// Of everything random about the rays.
    pub(crate) seed: u64,
    /// About how many rays a set has.
    pub(crate) rays: usize,
    /// The same for a quick run.
    pub(crate) quick_rays: usize,
    /// Which sets; all, unless told.
    #[serde(default = "all_kinds")]
    pub(crate) sets: Vec<Kind>,
    /// Names of engines, or beginnings of names; all, unless told.
    #[serde(default)]
    pub(crate) engines: Vec<String>,
    /// The same for a quick run, where slow builders would take all the time.
    #[serde(default)]
    pub(crate) quick_engines: Vec<String>,
    /// How many rays of a set must hit something, in a full run and in a quick one.
    #[serde(default)]
    pub(crate) hits: BTreeMap<Kind, Hits>,
}

/// The answer that the rays of a set must give.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hits {
    /// With all rays.
    pub(crate) full: Option<usize>,
    /// With those of a quick run.
    pub(crate) quick: Option<usize>,
}

fn all_kinds() -> Vec<Kind> {
    Kind::ALL.to_vec()
}

/// The cases that come with the program.
const BUILT_IN: [&str; 4] = [
    include_str!("../cases/race.toml"),
    include_str!("../cases/terrain.toml"),
    include_str!("../cases/pile.toml"),
    include_str!("../cases/long_diagonals.toml"),
];

impl Case {
    /// Those that come with the program.
    pub(crate) fn built_in() -> Result<Vec<Self>, Failure> {
        BUILT_IN.iter().map(|text| Self::parse(text)).collect()
    }

    /// From the text of a file.
    pub(crate) fn parse(text: &str) -> Result<Self, Failure> {
        Ok(toml::from_str(text)?)
    }

    /// What is measured about a scene that was named on the command line: a case file, or a glTF file with the usual rays.
    pub(crate) fn of_file(path: &Path) -> Result<Self, Failure> {
        if path.extension().is_some_and(|extension| extension == "toml") {
            return Self::parse(&std::fs::read_to_string(path)?);
        }
        let name = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
        Ok(Self {
            name,
            scene: SceneChoice::File { path: path.into(), time: 0.0 },
            seed: 1,
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

    /// How many rays of a set must hit something, if that is known.
    pub(crate) fn expected(&self, kind: Kind, quick: bool) -> Option<usize> {
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
    }

    #[test]
    fn what_a_case_does_not_know_is_refused() {
        assert!(Case::parse("name = 'x'\nspeed = 3").is_err());
        let text = "name='x'\nseed=1\nrays=64\nquick_rays=64\nengines=['embree']\n[scene]\nkind='pile'\nseed=1\ntriangles=9\n[hits.axis]\nquick=5\n";
        let case = Case::parse(text).unwrap();
        assert!(case.wants("embree medium", true) && !case.wants("obvhs", false));
        assert_eq!((case.expected(Kind::Axis, true), case.expected(Kind::Axis, false)), (Some(5), None));
    }
}
