//! Geometry as it is handed over: positions and triangles, and what may deform them.

use std::fmt;
use std::sync::{Arc, OnceLock};

use super::error::MeshError;
use super::input::{Indices, Positions, check_finite};
use super::skin::{MorphTarget, Skin};
use crate::build::{self, BuildOptions, BuildProgress, Cancelled, Quality};
use crate::geometry::{Precision, Triangles, fingerprint};
use crate::threads::Threads;
use crate::traverse::MeshFrame;
use crate::wide::{MeshBvh, TreeFileError};

/// Triangles that share vertices, in their rest pose. Cheap to clone: clones share everything. That
/// includes the tree of the rest pose, if their first commit finds them at rest, or deformed by a
/// pose.
#[derive(Clone)]
pub struct Mesh {
    data: Arc<MeshData>,
    /// The rest pose with its tree; taken instead of building one.
    tree: Option<Arc<MeshFrame>>,
}

/// In short: how large it is.
impl fmt::Debug for Mesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mesh")
            .field("vertices", &self.positions().len())
            .field("triangles", &self.triangles().len())
            .field("morph_targets", &self.data.morph_targets.len())
            .field("has_skin", &self.data.skin.is_some())
            .finish_non_exhaustive()
    }
}

/// Normals for shading: one per vertex, or none at all.
pub(crate) type VertexNormals = Vec<[f32; 3]>;

#[derive(Debug, Clone, Default)]
pub(crate) struct MeshData {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) triangles: Arc<[[u32; 3]]>,
    pub(crate) normals: Arc<VertexNormals>,
    pub(crate) morph_targets: Vec<MorphTarget>,
    pub(crate) skin: Option<Skin>,
    /// Chosen instead of what the motion suggests.
    pub(crate) quality: Option<Quality>,
    pub(crate) precision: Precision,
    /// The rest pose with its tree, for each quality; built by the first of several clones.
    first_builds: [OnceLock<Arc<MeshFrame>>; Quality::COUNT],
}

impl Mesh {
    /// Positions in metres, object space. Corners run counter-clockwise as seen from the front of a
    /// triangle. Indices may be `u16` or `u32`, flat or in threes. Degenerate and duplicate
    /// triangles are allowed.
    ///
    /// # Errors
    /// Indices out of range or not in threes, positions that are not finite.
    pub fn new<'a>(positions: impl Into<Positions<'a>>, indices: impl Into<Indices<'a>>) -> Result<Self, MeshError> {
        let positions = positions.into().to_vec()?;
        let triangles = indices.into().to_triangles(positions.len())?.into();
        Ok(Self::of(MeshData { positions, triangles, ..MeshData::default() }))
    }

    /// A mesh without triangles, to be replaced later by
    /// [`Scene::set_triangles`](crate::Scene::set_triangles).
    pub fn empty() -> Self {
        Self::of(MeshData::default())
    }

    fn of(data: MeshData) -> Self {
        Self { data: Arc::new(data), tree: None }
    }

    /// Normals for shading, one per vertex, of any length.
    ///
    /// # Errors
    /// Another number of normals than of vertices, or one that is not finite.
    pub fn with_normals(self, normals: &[[f32; 3]]) -> Result<Self, MeshError> {
        self.check_count("normals", normals.len())?;
        check_finite(normals)?;
        Ok(self.changed(|data| data.normals = Arc::new(normals.to_vec())))
    }

    /// Joints that move the vertices.
    ///
    /// # Errors
    /// Another number of entries than of vertices, or a weight that is negative or not finite.
    pub fn with_skin(self, skin: Skin) -> Result<Self, MeshError> {
        self.check_count("joint numbers", skin.joints.len())?;
        self.check_count("joint weights", skin.weights.len())?;
        skin.check()?;
        Ok(self.changed(|data| data.skin = Some(skin)))
    }

    /// Morph targets that a pose can add.
    ///
    /// # Errors
    /// Another number of displacements than of vertices, or one that is not finite.
    pub fn with_morph_targets(self, targets: Vec<MorphTarget>) -> Result<Self, MeshError> {
        for target in &targets {
            self.check_count("morph displacements", target.positions.len())?;
            check_finite(&target.positions)?;
            if !target.normals.is_empty() {
                self.check_count("morph normals", target.normals.len())?;
                check_finite(&target.normals)?;
            }
        }
        Ok(self.changed(|data| data.morph_targets = targets))
    }

    /// How much build time to trade for traversal speed, for this mesh, instead of what its
    /// [`Motion`](crate::Motion) suggests.
    ///
    /// [`Quality::Best`] is for meshes that do not deform: a refit bounds whole triangles where the
    /// build had cut them.
    #[must_use]
    pub fn with_quality(self, quality: Quality) -> Self {
        self.changed(|data| data.quality = Some(quality))
    }

    /// How exactly rays are tested against triangles, instead of [`Precision::Watertight`].
    #[must_use]
    pub fn with_precision(mut self, precision: Precision) -> Self {
        if let Some(tree) = &mut self.tree {
            Arc::make_mut(tree).precision = precision;
        }
        self.changed(|data| {
            data.precision = precision;
            data.first_builds = Default::default();
        })
    }

    /// Hands over a tree that [`Mesh::bake`] built earlier for the same positions and triangles.
    /// The first commit uses it instead of building one, whatever the quality. Later refits and
    /// rebuilds go on as usual.
    ///
    /// # Errors
    /// The bytes are no tree, damaged, or a tree of another mesh.
    pub fn with_tree(mut self, tree: &[u8]) -> Result<Self, TreeFileError> {
        let triangles = self.at_rest();
        let bvh = MeshBvh::from_bytes(tree, &triangles)?;
        self.tree = Some(Arc::new(MeshFrame { bvh, triangles, precision: self.data.precision }));
        Ok(self)
    }

    /// Builds the tree of the rest pose, and returns it as bytes for [`Mesh::with_tree`], so that
    /// it is built once for many runs of a program. [`TreeFile`](crate::TreeFile) keeps the trees
    /// of many meshes in one file.
    ///
    /// The quality is that of the options, whatever [`Mesh::with_quality`] says.
    pub fn bake(&self, options: &BuildOptions) -> Vec<u8> {
        self.bake_with_progress(options, &BuildProgress::new()).expect("a build that no other thread can cancel")
    }

    /// As [`Mesh::bake`]; other threads may read the progress, and cancel the build.
    ///
    /// # Errors
    /// The build was cancelled.
    pub fn bake_with_progress(&self, options: &BuildOptions, progress: &BuildProgress) -> Result<Vec<u8>, Cancelled> {
        let rest = self.at_rest();
        Ok(build::build_with_progress(&rest, options, progress)?.to_bytes(&rest))
    }

    /// A hash of positions and triangles, without normals and skin, which binds a baked tree to its
    /// mesh. See [`Triangles::fingerprint`].
    pub fn fingerprint(&self) -> u64 {
        fingerprint(&self.data.positions, &self.data.triangles)
    }

    /// Metres, object space, rest pose.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.data.positions
    }

    /// Vertex numbers.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.data.triangles
    }

    /// One per vertex, if there are any.
    pub fn normals(&self) -> Option<&[[f32; 3]]> {
        (!self.data.normals.is_empty()).then_some(&self.data.normals)
    }

    pub(crate) fn data(&self) -> &Arc<MeshData> {
        &self.data
    }

    /// The rest pose, in the form that builders take.
    pub(crate) fn at_rest(&self) -> Triangles {
        let rest = Triangles::new(self.data.positions.clone(), self.data.triangles.clone());
        rest.expect("a mesh has only indices in range")
    }

    pub(crate) fn has_tree(&self) -> bool {
        self.tree.is_some()
    }

    /// The tree that came with the mesh; it has none afterwards.
    pub(crate) fn take_tree(&mut self) -> Option<Arc<MeshFrame>> {
        self.tree.take()
    }

    /// The rest pose with a tree of this quality, if one of several clones has built it.
    pub(crate) fn first_build(&self, quality: Quality) -> Option<&Arc<MeshFrame>> {
        self.data.first_builds[quality as usize].get()
    }

    /// Builds it, unless that has been done.
    pub(crate) fn prepare_first_build(&self, quality: Quality, threads: &Threads) {
        if self.first_build(quality).is_none() {
            let triangles = self.at_rest();
            let bvh = grow(&triangles, quality, threads);
            let built = Arc::new(MeshFrame { bvh, triangles, precision: self.data.precision });
            // Another scene may have been faster; the trees are the same.
            let _ = self.data.first_builds[quality as usize].set(built);
        }
    }

    fn changed(mut self, change: impl FnOnce(&mut MeshData)) -> Self {
        change(Arc::make_mut(&mut self.data));
        self
    }

    fn check_count(&self, what: &'static str, found: usize) -> Result<(), MeshError> {
        let expected = self.data.positions.len();
        if found == expected { Ok(()) } else { Err(MeshError::CountDiffers { what, expected, found }) }
    }
}

/// A tree over triangles where they are now.
pub(super) fn grow(triangles: &Triangles, quality: Quality, threads: &Threads) -> MeshBvh {
    let options = BuildOptions::new().quality(quality).threads(threads.clone());
    MeshBvh::new_on(&build::build_triangles(triangles, &options), triangles, threads)
}
