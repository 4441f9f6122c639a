//! A file that has been read, apart from any scene.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use kinetree_world::MaterialSet;

use crate::accessor::Accessors;
use crate::assemble::assemble;
use crate::budget::Budget;
use crate::channels::Animations;
use crate::clip::{ClipInfo, Clips};
use crate::container::Container;
use crate::contents::Contents;
use crate::document::Document;
use crate::error::{LoadError, Problem};
use crate::image::Textures;
use crate::input::Input;
use crate::json::{self, List};
use crate::material::Materials;
use crate::mesh::Meshes;
use crate::nodes::Hierarchy;
use crate::notes::Notes;
use crate::options::Options;
use crate::source::Source;

/// A glTF file that has been read and checked, and belongs to no scene.
///
/// It can be inserted into scenes as often as needed: all copies share the geometry of their meshes
/// and the trees of their rest poses.
pub struct Asset {
    file: PathBuf,
    pub(crate) nodes: List<json::Node>,
    pub(crate) hierarchy: Hierarchy,
    pub(crate) contents: Contents,
    notes: Arc<[String]>,
    files: Vec<PathBuf>,
}

// An asset is read on any thread, and shared between threads.
const _: () = {
    const fn is_send_and_sync<T: Send + Sync>() {}
    is_send_and_sync::<Asset>();
};

/// Reads a file, on any thread, without a scene.
///
/// # Errors
/// A file that cannot be read, is broken, refers to something that is not there, or asks for too
/// much memory; an animation of [`Options::clip`](field@Options::clip) that is not there.
pub fn read<'a>(source: impl Into<Source<'a>>, options: &Options) -> Result<Asset, LoadError> {
    let source = source.into();
    Asset::read(&source, options).map_err(|problem| LoadError::new(source.name(), problem))
}

impl Asset {
    fn read(source: &Source<'_>, options: &Options) -> Result<Self, Problem> {
        let mut notes = Notes::default();
        let container = Container::open(source)?;
        let mut document = Document::parse(&container.json, &mut notes)?;
        let buffers = container.buffers(&document.root.buffers)?;
        let budget = Budget::for_bytes(container.size(&buffers));
        let accessors = Accessors::new(&document, &buffers, &budget);
        let hierarchy = Hierarchy::read(&document, &mut notes)?;
        let mut clips = Clips::choose(&document, options.clip.as_ref(), &mut notes)?;
        let animations = Animations::read(&document, &accessors, &mut clips, &mut notes)?;
        let textures = Textures::new(&document, &container, &accessors, options.max_texture_bytes);
        let materials = Materials::new(&document, textures);
        let meshes = Meshes { document: &document, accessors: &accessors, budget: &budget };
        let (document_read, unanimated) = (&document, options.motion);
        let input = Input { document: document_read, hierarchy: &hierarchy, clips, animations, meshes, unanimated };
        let contents = assemble(input, materials, &mut notes)?;
        Ok(Self {
            file: source.name().to_path_buf(),
            nodes: std::mem::take(&mut document.root.nodes),
            hierarchy,
            contents,
            notes: notes.into_lines().into(),
            files: container.files_read(),
        })
    }

    /// What was ignored or repaired, one line each; a long list ends with how many lines were left
    /// out.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// All animations of the file, in its order.
    pub fn clips(&self) -> &[ClipInfo] {
        &self.contents.rig.clips.all
    }

    /// The files that were read besides: buffers and images.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// The materials and textures of the meshes that are shown, and which triangles have which.
    pub fn material_set(&self) -> &Arc<MaterialSet> {
        &self.contents.material_set
    }

    pub(crate) fn shared_notes(&self) -> &Arc<[String]> {
        &self.notes
    }

    pub(crate) fn error(&self, problem: Problem) -> LoadError {
        LoadError::new(&self.file, problem)
    }

    /// The path of the file, or the name of the bytes.
    pub fn file(&self) -> &Path {
        &self.file
    }
}

/// In short: how much there is of it.
impl std::fmt::Debug for Asset {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Asset")
            .field("file", &self.file)
            .field("nodes", &self.nodes.len())
            .field("meshes", &self.contents.meshes.len())
            .field("instances", &self.contents.instances.len())
            .finish_non_exhaustive()
    }
}
