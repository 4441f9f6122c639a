//! One animation of the file: for every node that it moves, the keys.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use gltf::json;
use gltf::json::accessor::Type;
use gltf::json::animation::{Channel, Interpolation as InterpolationJson, Property};
use gltf::json::validation::Checked;

use crate::accessor::Accessors;
use crate::document::Document;
use crate::error::{Item, Problem, Quoted};
use crate::keys::{Interpolation, Keys};
use crate::notes::Notes;
use crate::{Clip as Choice, Options};

/// What an animation does. Times start with 0.
#[derive(Default)]
pub(crate) struct Clip {
    /// By node.
    pub(crate) nodes: BTreeMap<usize, Channels>,
    /// By node: the weights of its morph targets.
    pub(crate) weights: BTreeMap<usize, Keys>,
    /// Seconds.
    pub(crate) duration: f64,
}

/// What an animation does to the placement of a node.
#[derive(Default)]
pub(crate) struct Channels {
    pub(crate) translation: Option<Keys>,
    pub(crate) rotation: Option<Keys>,
    pub(crate) scale: Option<Keys>,
}

impl Clip {
    /// Reads the chosen animation; that of a file without any does nothing.
    pub(crate) fn read(
        document: &Document,
        accessors: &Accessors<'_>,
        options: &Options,
        notes: &mut Notes,
    ) -> Result<Self, Problem> {
        let animations = &document.root.animations;
        let (index, asked) = match &options.clip {
            Choice::Index(0) if animations.is_empty() => return Ok(Self::default()),
            Choice::Index(index) => (Some(*index), index.to_string()),
            Choice::Name(name) => {
                let named = |animation: &json::Animation| animation.name.as_ref() == Some(name);
                (animations.iter().position(named), Quoted::new(name).to_string())
            }
        };
        let animation = index.and_then(|index| Some((index, animations.get(index)?)));
        let Some((index, animation)) = animation else {
            return Err(Problem::NoClip { asked, count: animations.len() });
        };
        let item = Item::named("animation", index, animation.name.as_ref());
        let mut reader = Reader { document, accessors, animation, item, times: HashMap::new() };
        let mut clip = Self::default();
        for (place, channel) in animation.channels.iter().enumerate() {
            reader.read(place, channel, &mut clip, notes)?;
        }
        Ok(clip)
    }
}

struct Reader<'a> {
    document: &'a Document,
    accessors: &'a Accessors<'a>,
    animation: &'a json::Animation,
    item: Item,
    /// By accessor; most channels share theirs.
    times: HashMap<usize, Arc<[f32]>>,
}

impl Reader<'_> {
    fn read(&mut self, place: usize, channel: &Channel, clip: &mut Clip, notes: &mut Notes) -> Result<(), Problem> {
        let item = self.item.clone();
        let mut ignore = |why: &str| notes.add(|| format!("{item}: channel {place} {why}, and is ignored"));
        let Checked::Valid(property) = channel.target.path else {
            ignore("moves something unknown");
            return Ok(());
        };
        let node = channel.target.node.value();
        self.document.get(channel.target.node, "node", &item)?;
        let width = match property {
            Property::Translation | Property::Scale => 3,
            Property::Rotation => 4,
            Property::MorphTargetWeights => self.target_count(node),
        };
        if width == 0 {
            ignore("moves the morph targets of a node that has none");
            return Ok(());
        }
        let Some(keys) = self.keys(place, channel, property, width)? else {
            ignore("has no keys");
            return Ok(());
        };
        let end = keys.end();
        let taken = if property == Property::MorphTargetWeights {
            clip.weights.insert(node, keys).is_some()
        } else {
            let channels = clip.nodes.entry(node).or_default();
            let slot = match property {
                Property::Translation => &mut channels.translation,
                Property::Rotation => &mut channels.rotation,
                _ => &mut channels.scale,
            };
            slot.replace(keys).is_some()
        };
        if taken {
            notes.add(|| format!("{item}: channel {place} takes the place of an earlier one for the same node"));
        }
        clip.duration = clip.duration.max(end);
        Ok(())
    }

    /// Of the mesh of a node.
    fn target_count(&self, node: usize) -> usize {
        self.document.root.nodes[node].mesh.map_or(0, |mesh| self.document.target_count(mesh.value()))
    }

    fn keys(
        &mut self,
        place: usize,
        channel: &Channel,
        property: Property,
        width: usize,
    ) -> Result<Option<Keys>, Problem> {
        let samplers = &self.animation.samplers;
        let (from, count) = (&self.item, samplers.len());
        let missing = || Problem::NoSuch { from: from.clone(), kind: "sampler", index: channel.sampler.value(), count };
        let sampler = samplers.get(channel.sampler.value()).ok_or_else(missing)?;
        let interpolation = match sampler.interpolation {
            Checked::Valid(InterpolationJson::Step) => Interpolation::Step,
            Checked::Valid(InterpolationJson::Linear) => Interpolation::Linear,
            Checked::Valid(InterpolationJson::CubicSpline) => Interpolation::CubicSpline,
            Checked::Invalid => return Err(from.invalid(format!("has an unknown interpolation in channel {place}"))),
        };
        let times = match self.times.get(&sampler.input.value()) {
            Some(times) => Arc::clone(times),
            None => {
                let times = self.accessors.floats::<1>(sampler.input, Type::Scalar, from)?;
                let times: Arc<[f32]> = times.into_flattened().into();
                self.times.insert(sampler.input.value(), Arc::clone(&times));
                times
            }
        };
        let values = match property {
            Property::Translation | Property::Scale => {
                self.accessors.floats::<3>(sampler.output, Type::Vec3, from)?.into_flattened()
            }
            Property::Rotation => self.accessors.floats::<4>(sampler.output, Type::Vec4, from)?.into_flattened(),
            Property::MorphTargetWeights => {
                self.accessors.floats::<1>(sampler.output, Type::Scalar, from)?.into_flattened()
            }
        };
        if times.is_empty() {
            return Ok(None);
        }
        if !values.iter().all(|value| value.is_finite()) {
            return Err(from.invalid(format!("has values that are not finite in channel {place}")));
        }
        let (keys, numbers) = (times.len(), values.len());
        let fits = Keys::new(times, values, width, interpolation);
        let broken = || {
            let reason = "with times that are not finite or go back, or with too many or too few values";
            from.invalid(format!("has a channel, {place}, of {keys} keys and {numbers} numbers {reason}"))
        };
        fits.map(Some).ok_or_else(broken)
    }
}
