//! kinetree: a flattened scene is one mesh with one instance.

mod built_tree;
mod reference;
mod refitter;
mod scene;
mod settings;

pub(crate) use reference::Reference;
pub(crate) use settings::{FAST_PRECISION_SUFFIX, variants};
