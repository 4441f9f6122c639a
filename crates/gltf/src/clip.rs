//! The animations that are played: for every node that they move, the keys.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

use crate::accessor::Accessors;
use crate::document::Document;
use crate::error::{Item, Problem, Quoted};
use crate::json::{Animation, Channel, ElementType, Interpolation as InterpolationJson, Path};
use crate::keys::{Interpolation, Keys};
use crate::notes::Notes;
use crate::{Clip as Choice, ClipInfo, Options};

/// What the animations do. Times start with 0.
#[derive(Default)]
pub(crate) struct Clip {
    /// By node.
    pub(crate) nodes: BTreeMap<usize, Channels>,
    /// By node: the weights of its morph targets.
    pub(crate) weights: BTreeMap<usize, Keys>,
    /// Seconds.
    pub(crate) duration: f64,
    /// All animations of the file.
    pub(crate) all: Vec<ClipInfo>,
}

/// What an animation does to the placement of a node.
#[derive(Default)]
pub(crate) struct Channels {
    pub(crate) translation: Option<Keys>,
    pub(crate) rotation: Option<Keys>,
    pub(crate) scale: Option<Keys>,
}

impl Clip {
    /// Reads the chosen animations; a file without any has a clip that does nothing.
    pub(crate) fn read(
        document: &Document,
        accessors: &Accessors<'_>,
        options: &Options,
        notes: &mut Notes,
    ) -> Result<Self, Problem> {
        let animations = &document.root.animations;
        let is_played = chosen(document, &options.clip)?;
        if options.clip == Choice::Together && animations.len() > 1 {
            note_choice(document, &is_played, notes);
        }
        let mut clip = Self::default();
        let mut times = HashMap::new();
        for (index, animation) in animations.iter().enumerate() {
            let name = animation.name.as_deref().map(str::to_owned);
            clip.all.push(ClipInfo { name, is_played: is_played[index] });
            if !is_played[index] {
                continue;
            }
            let item = document.animation_item(index);
            let mut reader = Reader { document, accessors, animation, item, times: &mut times };
            for (number, channel) in animation.channels.iter().enumerate() {
                reader.read(number, channel, &mut clip, notes)?;
            }
        }
        Ok(clip)
    }

    /// The nodes whose size changes, which may mirror what is below them.
    pub(crate) fn resized(&self) -> impl Iterator<Item = usize> {
        self.nodes.iter().filter(|(_, channels)| channels.scale.is_some()).map(|(&node, _)| node)
    }
}

/// How many animations a note or an error lists by name.
const MOST_NAMES: usize = 20;

/// For every animation whether it is played.
fn chosen(document: &Document, choice: &Choice) -> Result<Vec<bool>, Problem> {
    let animations = &document.root.animations;
    let (index, asked) = match choice {
        Choice::Together => return Ok(compatible(document)),
        Choice::Index(0) if animations.is_empty() => return Ok(Vec::new()),
        Choice::Index(index) => (Some(*index), index.to_string()),
        Choice::Name(name) => {
            let index = animations.iter().position(|animation| animation.name.as_deref() == Some(name));
            (index, Quoted::new(name).to_string())
        }
    };
    let Some(index) = index.filter(|&index| index < animations.len()) else {
        let known = (0..animations.len()).take(MOST_NAMES).map(|index| label(document, index)).collect();
        return Err(Problem::NoClip { asked, count: animations.len(), known });
    };
    Ok((0..animations.len()).map(|other| other == index).collect())
}

/// The first animation, and every other that moves nothing that one before it moves.
fn compatible(document: &Document) -> Vec<bool> {
    let mut moved: HashSet<(usize, Path)> = HashSet::new();
    let targets = |animation: &Animation| {
        let known = animation.channels.iter().filter(|channel| channel.target.path != Path::Unknown);
        known.filter_map(|channel| Some((channel.target.node?.value(), channel.target.path))).collect::<Vec<_>>()
    };
    let animations = document.root.animations.iter();
    animations
        .map(|animation| {
            let targets = targets(animation);
            let is_free = targets.iter().all(|target| !moved.contains(target));
            if is_free {
                moved.extend(targets);
            }
            is_free
        })
        .collect()
}

fn note_choice(document: &Document, is_played: &[bool], notes: &mut Notes) {
    notes.add(|| {
        let played: Vec<usize> = (0..is_played.len()).filter(|&index| is_played[index]).collect();
        let names: Vec<String> = played.iter().take(MOST_NAMES).map(|&index| label(document, index)).collect();
        let more = played.len() - names.len();
        let names = names.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() };
        let verb = if played.len() == 1 { "is played" } else { "are played together" };
        let others = if played.len() < is_played.len() { "; the others move what these move" } else { "" };
        format!("of {} animations, {names} {verb}{others}", is_played.len())
    });
}

/// Such as `1 "walk"`.
fn label(document: &Document, index: usize) -> String {
    match &document.root.animations[index].name {
        Some(name) => format!("{index} {}", Quoted::new(name)),
        None => index.to_string(),
    }
}

struct Reader<'a> {
    document: &'a Document,
    accessors: &'a Accessors<'a>,
    animation: &'a Animation,
    item: Item,
    /// By accessor; most channels share theirs.
    times: &'a mut HashMap<usize, Arc<[f32]>>,
}

impl Reader<'_> {
    fn read(&mut self, number: usize, channel: &Channel, clip: &mut Clip, notes: &mut Notes) -> Result<(), Problem> {
        let item = self.item.clone();
        let mut ignore = |why: &str| notes.add(|| format!("{item}: channel {number} {why}, and is ignored"));
        let path = channel.target.path;
        let Some(node) = channel.target.node else {
            notes.ignored("a channel without a node", "what only extensions animate stands still", Some(&item));
            return Ok(());
        };
        self.document.get(node, "node", &item)?;
        let node = node.value();
        let width = match path {
            Path::Translation | Path::Scale => 3,
            Path::Rotation => 4,
            Path::Weights => self.target_count(node),
            Path::Unknown => {
                notes.ignored("a channel for an unknown property", "it moves nothing", Some(&item));
                return Ok(());
            }
        };
        if width == 0 {
            ignore("moves the morph targets of a node that has none");
            return Ok(());
        }
        let Some(keys) = self.keys(number, channel, width)? else {
            ignore("has no keys");
            return Ok(());
        };
        let end = keys.end();
        let taken = if path == Path::Weights {
            clip.weights.insert(node, keys).is_some()
        } else {
            let channels = clip.nodes.entry(node).or_default();
            let slot = match path {
                Path::Translation => &mut channels.translation,
                Path::Rotation => &mut channels.rotation,
                _ => &mut channels.scale,
            };
            slot.replace(keys).is_some()
        };
        if taken {
            notes.add(|| format!("{item}: channel {number} takes the place of an earlier one for the same node"));
        }
        clip.duration = clip.duration.max(end);
        Ok(())
    }

    /// Of the mesh of a node.
    fn target_count(&self, node: usize) -> usize {
        self.document.root.nodes[node].mesh.map_or(0, |mesh| self.document.target_count(mesh.value()))
    }

    fn keys(&mut self, number: usize, channel: &Channel, width: usize) -> Result<Option<Keys>, Problem> {
        let samplers = &self.animation.samplers;
        let (from, index) = (&self.item, channel.sampler as usize);
        let missing = || Problem::NoSuch { from: from.clone(), kind: "sampler", index, count: samplers.len() };
        let sampler = samplers.get(index).ok_or_else(missing)?;
        let interpolation = match sampler.interpolation {
            InterpolationJson::Step => Interpolation::Step,
            InterpolationJson::Linear => Interpolation::Linear,
            InterpolationJson::CubicSpline => Interpolation::CubicSpline,
            InterpolationJson::Unknown => {
                return Err(from.invalid(format!("has an unknown interpolation in channel {number}")));
            }
        };
        let times = match self.times.get(&sampler.input.value()) {
            Some(times) => Arc::clone(times),
            None => {
                let times = self.accessors.floats::<1>(sampler.input, ElementType::Scalar, from)?;
                let times: Arc<[f32]> = times.into_flattened().into();
                self.times.insert(sampler.input.value(), Arc::clone(&times));
                times
            }
        };
        let values = match channel.target.path {
            Path::Translation | Path::Scale => {
                self.accessors.floats::<3>(sampler.output, ElementType::Vec3, from)?.into_flattened()
            }
            Path::Rotation => self.accessors.floats::<4>(sampler.output, ElementType::Vec4, from)?.into_flattened(),
            Path::Weights | Path::Unknown => {
                self.accessors.floats::<1>(sampler.output, ElementType::Scalar, from)?.into_flattened()
            }
        };
        if times.is_empty() {
            return Ok(None);
        }
        if !values.iter().all(|value| value.is_finite()) {
            return Err(from.invalid(format!("has values that are not finite in channel {number}")));
        }
        let (keys, numbers) = (times.len(), values.len());
        let fits = Keys::new(times, values, width, interpolation);
        let broken = || {
            let reason = "with times that are not finite or go back, or with too many or too few values";
            from.invalid(format!("has a channel, {number}, of {keys} keys and {numbers} numbers {reason}"))
        };
        fits.map(Some).ok_or_else(broken)
    }
}
