//! The animations of a file, and the choice among them.

use std::collections::HashSet;
use std::fmt;

use kinetree::EditError;

use crate::document::Document;
use crate::error::{Problem, Quoted};
use crate::json::{Animation, Path};
use crate::notes::Notes;

/// Which of the animations of a file are played.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Clip {
    /// The first, and all others that move nothing that one before them moves: one animation for
    /// each object, as many programs write them, is one performance, whereas several for the same
    /// object are alternatives. They begin together; the shorter ones wait at their ends for the
    /// longest.
    #[default]
    Together,
    /// By its index in the file. Index 0 is accepted even if the file has no animation: then
    /// nothing moves.
    Index(usize),
    /// By its name; of several with the same name, the first.
    Name(String),
}

impl From<usize> for Clip {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

impl From<&str> for Clip {
    fn from(name: &str) -> Self {
        Self::Name(name.to_owned())
    }
}

/// As an error message names it.
impl fmt::Display for Clip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Together => f.write_str("together"),
            Self::Index(index) => index.fmt(f),
            Self::Name(name) => Quoted::new(name).fmt(f),
        }
    }
}

/// An animation of a file.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ClipInfo {
    /// As written in the file.
    pub name: Option<String>,
    /// Seconds; 0 if it was not read.
    pub duration: f64,
    /// Whether it can be played: [`Options::clip`](field@crate::Options::clip) says which ones are
    /// read.
    pub is_read: bool,
    /// Whether it is one of [`Clip::Together`], among those that were read.
    pub is_played: bool,
}

/// Why an animation could not be brought to a time.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlayError {
    /// The file has no such animation, or it was not read.
    #[error("no animation {clip} can be played; those that can are: {}", known_or_none(.known))]
    NoClip {
        /// The one that was to be played.
        clip: Clip,
        /// The first of those that can be played, such as `0 "walk"`.
        known: Vec<String>,
    },
    /// The scene refused an edit, such as one of a node that has been removed.
    #[error(transparent)]
    Edit(#[from] EditError),
}

fn known_or_none(known: &[String]) -> String {
    if known.is_empty() { "none".to_owned() } else { known.join(", ") }
}

/// All animations of a file. Always: what is played was read.
pub(crate) struct Clips {
    pub(crate) all: Vec<ClipInfo>,
}

/// The animations that give one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Playing {
    /// None: everything is at rest.
    Nothing,
    /// Those of [`Clip::Together`].
    Together,
    /// By its index in the file.
    One(usize),
}

/// How many animations a note or an error lists by name.
const MOST_NAMES: usize = 20;

impl Clips {
    /// Decides which animations are read: all, without a choice.
    ///
    /// # Errors
    /// A choice that the file does not have.
    pub(crate) fn choose(document: &Document, choice: Option<&Clip>, notes: &mut Notes) -> Result<Self, Problem> {
        let animations = &document.root.animations;
        let info = |animation: &Animation| ClipInfo {
            name: animation.name.as_deref().map(str::to_owned),
            duration: 0.0,
            is_read: true,
            is_played: false,
        };
        let mut clips = Self { all: animations.iter().map(info).collect() };
        if let Some(clip @ (Clip::Index(_) | Clip::Name(_))) = choice {
            let chosen = clips.find(clip).ok_or_else(|| Problem::NoClip {
                asked: clip.to_string(),
                count: animations.len(),
                known: clips.labels(|_| true),
            })?;
            for (index, info) in clips.all.iter_mut().enumerate() {
                info.is_read = chosen == Playing::One(index);
            }
        }
        let mut moved = HashSet::new();
        for (info, animation) in clips.all.iter_mut().zip(animations.iter()).filter(|(info, _)| info.is_read) {
            let targets = targets(animation);
            info.is_played = targets.iter().all(|target| !moved.contains(target));
            if info.is_played {
                moved.extend(targets);
            }
        }
        if choice == Some(&Clip::Together) {
            clips.all.iter_mut().for_each(|info| info.is_read = info.is_played);
            if clips.all.len() > 1 {
                clips.note_choice(notes);
            }
        }
        Ok(clips)
    }

    /// What is played for a choice.
    ///
    /// # Errors
    /// An animation that is not there, or was not read.
    pub(crate) fn playing(&self, clip: &Clip) -> Result<Playing, PlayError> {
        let can_play = |playing: &Playing| match *playing {
            Playing::One(index) => self.all[index].is_read,
            Playing::Together | Playing::Nothing => true,
        };
        self.find(clip)
            .filter(can_play)
            .ok_or_else(|| PlayError::NoClip { clip: clip.clone(), known: self.labels(|info| info.is_read) })
    }

    /// Whether an animation is among those that are played.
    pub(crate) fn includes(&self, playing: Playing, clip: usize) -> bool {
        match playing {
            Playing::Nothing => false,
            Playing::Together => self.all[clip].is_played,
            Playing::One(index) => index == clip,
        }
    }

    /// Seconds until the longest ends.
    pub(crate) fn duration(&self, playing: Playing) -> f64 {
        let played = (0..self.all.len()).filter(|&clip| self.includes(playing, clip));
        played.map(|clip| self.all[clip].duration).fold(0.0, f64::max)
    }

    fn find(&self, clip: &Clip) -> Option<Playing> {
        match clip {
            Clip::Together => Some(Playing::Together),
            Clip::Index(0) if self.all.is_empty() => Some(Playing::Nothing),
            Clip::Index(index) => Some(Playing::One(*index)).filter(|_| *index < self.all.len()),
            Clip::Name(name) => self.all.iter().position(|info| info.name.as_deref() == Some(name)).map(Playing::One),
        }
    }

    fn note_choice(&self, notes: &mut Notes) {
        notes.add(|| {
            let played = self.all.iter().filter(|info| info.is_played).count();
            let names = self.labels(|info| info.is_played);
            let more = played - names.len();
            let names = names.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() };
            let verb = if played == 1 { "is played" } else { "are played together" };
            let others = if played < self.all.len() { "; the others move what these move" } else { "" };
            format!("of {} animations, {names} {verb}{others}", self.all.len())
        });
    }

    /// The first animations of which something is true, such as `1 "walk"`.
    fn labels(&self, wanted: impl Fn(&ClipInfo) -> bool) -> Vec<String> {
        let label = |(index, info): (usize, &ClipInfo)| match &info.name {
            Some(name) => format!("{index} {}", Quoted::new(name)),
            None => index.to_string(),
        };
        self.all.iter().enumerate().filter(|(_, info)| wanted(info)).take(MOST_NAMES).map(label).collect()
    }
}

/// The properties of nodes that an animation moves.
fn targets(animation: &Animation) -> Vec<(usize, Path)> {
    let known = animation.channels.iter().filter(|channel| channel.target.path != Path::Unknown);
    known.filter_map(|channel| Some((channel.target.node?.value(), channel.target.path))).collect()
}
