//! The channels of the animations that are read: for every node that they move, its keys.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use crate::accessor::Accessors;
use crate::clip::Clips;
use crate::document::Document;
use crate::error::{Item, Problem};
use crate::json::{Animation, Channel, ElementType, Interpolation as InterpolationJson, Path};
use crate::keys::{Interpolation, Keys};
use crate::notes::Notes;

/// What the animations of a file do. Times start with 0.
#[derive(Default)]
pub(crate) struct Animations {
    /// By node, what moves it.
    pub(crate) nodes: BTreeMap<usize, PerClip<Channels>>,
    /// By node, the weights of the morph targets of its mesh.
    pub(crate) weights: BTreeMap<usize, PerClip<Keys>>,
}

/// A value for each animation that has one, with the index of the animation, in ascending order.
pub(crate) type PerClip<T> = Vec<(usize, T)>;

/// What an animation does to the transform of a node.
#[derive(Default)]
pub(crate) struct Channels {
    pub(crate) translation: Option<Keys>,
    pub(crate) rotation: Option<Keys>,
    pub(crate) scale: Option<Keys>,
}

impl Animations {
    /// Reads the animations that are chosen, and sets their durations.
    ///
    /// # Errors
    /// References to what is not there; keys that are broken.
    pub(crate) fn read(
        document: &Document,
        accessors: &Accessors<'_>,
        clips: &mut Clips,
        notes: &mut Notes,
    ) -> Result<Self, Problem> {
        let mut animations = Self::default();
        let mut times = HashMap::new();
        let all = clips.all.iter_mut().zip(document.root.animations.iter()).enumerate();
        for (clip, (info, animation)) in all.filter(|(_, (info, _))| info.is_read) {
            let item = document.animation_item(clip);
            let mut reader = Reader { document, accessors, animation, item, clip, times: &mut times };
            for (number, channel) in animation.channels.iter().enumerate() {
                let end = reader.read(number, channel, &mut animations, notes)?;
                info.duration = info.duration.max(end);
            }
        }
        Ok(animations)
    }

    /// The nodes whose scale is animated, which may mirror what is below them.
    pub(crate) fn scaled(&self) -> impl Iterator<Item = usize> {
        let is_scaled = |channels: &PerClip<Channels>| channels.iter().any(|(_, channels)| channels.scale.is_some());
        self.nodes.iter().filter(move |(_, channels)| is_scaled(channels)).map(|(&node, _)| node)
    }
}

struct Reader<'a> {
    document: &'a Document,
    accessors: &'a Accessors<'a>,
    animation: &'a Animation,
    item: Item,
    /// The index of the animation.
    clip: usize,
    /// By accessor; most channels share theirs.
    times: &'a mut HashMap<usize, Arc<[f32]>>,
}

impl Reader<'_> {
    /// Reads a channel, and returns the time of its last key, seconds; 0 if it is ignored.
    fn read(
        &mut self,
        number: usize,
        channel: &Channel,
        animations: &mut Animations,
        notes: &mut Notes,
    ) -> Result<f64, Problem> {
        let item = self.item.clone();
        let mut ignore = |why: &str| notes.add(|| format!("{item}: channel {number} {why}, and is ignored"));
        let path = channel.target.path;
        let Some(node) = channel.target.node else {
            notes.ignored("a channel without a node", "what only extensions animate stands still", Some(&item));
            return Ok(0.0);
        };
        self.document.get(node, "node", &item)?;
        let node = node.value();
        let width = match path {
            Path::Translation | Path::Scale => 3,
            Path::Rotation => 4,
            Path::Weights => self.target_count(node),
            Path::Unknown => {
                notes.ignored("a channel for an unknown property", "it moves nothing", Some(&item));
                return Ok(0.0);
            }
        };
        if width == 0 {
            ignore("moves the morph targets of a node that has none");
            return Ok(0.0);
        }
        let Some(keys) = self.keys(number, channel, width)? else {
            ignore("has no keys");
            return Ok(0.0);
        };
        let end = keys.end();
        let replaced = if path == Path::Weights {
            let of_node = animations.weights.entry(node).or_default();
            let earlier = of_node.pop_if(|(clip, _)| *clip == self.clip);
            of_node.push((self.clip, keys));
            earlier.is_some()
        } else {
            let of_node = animations.nodes.entry(node).or_default();
            if of_node.last().is_none_or(|(clip, _)| *clip != self.clip) {
                // Most nodes are moved by one animation.
                of_node.reserve_exact(1);
                of_node.push((self.clip, Channels::default()));
            }
            let channels = &mut of_node.last_mut().expect("it has the channels of this animation").1;
            let slot = match path {
                Path::Translation => &mut channels.translation,
                Path::Rotation => &mut channels.rotation,
                _ => &mut channels.scale,
            };
            slot.replace(keys).is_some()
        };
        if replaced {
            notes.add(|| format!("{item}: channel {number} takes the place of an earlier one for the same node"));
        }
        Ok(end)
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
