//! The bytes of a file: its JSON, its buffers, and the files next to it.
//!
//! glTF 2.0 specification, section 4 (GLB file format) and 3.6.1 (buffers).

use std::borrow::Cow;
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::error::{Item, Problem, Quoted};
use crate::json::{Buffer, List};
use crate::source::Source;
use crate::uri::{self, Target};

/// A file that is split into its chunks, and access to the files that it refers to.
pub(crate) struct Container {
    /// The JSON text.
    pub(crate) json: Vec<u8>,
    /// The binary chunk of a `.glb`.
    binary: Option<Arc<[u8]>>,
    /// Relative paths start here; `None` if there are no other files.
    folder: Option<PathBuf>,
    /// The files next to it that were read so far.
    read: Mutex<Vec<PathBuf>>,
}

impl Container {
    pub(crate) fn open(source: &Source<'_>) -> Result<Self, Problem> {
        match *source {
            Source::Path(path) => {
                let bytes = read(path).map_err(Problem::Unreadable)?;
                Self::split(Cow::Owned(bytes), Some(path.parent().map(Path::to_path_buf).unwrap_or_default()))
            }
            Source::Bytes { bytes, folder, .. } => Self::split(Cow::Borrowed(bytes), folder.map(Path::to_path_buf)),
        }
    }

    fn split(bytes: Cow<'_, [u8]>, folder: Option<PathBuf>) -> Result<Self, Problem> {
        let read = Mutex::default();
        if bytes.starts_with(b"glTF") {
            let (json, binary) = chunks(&bytes).map_err(Problem::Container)?;
            return Ok(Self { json: json.to_vec(), binary: binary.map(Arc::from), folder, read });
        }
        const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
        let json = match bytes.strip_prefix(BYTE_ORDER_MARK) {
            Some(json) => json.to_vec(),
            None => bytes.into_owned(),
        };
        Ok(Self { json, binary: None, folder, read })
    }

    /// The bytes of all buffers, each at least as long as it says. Buffers with the same URI, and
    /// those that come from the same file by different names, share their bytes.
    pub(crate) fn buffers(&self, buffers: &List<Buffer>) -> Result<Vec<Arc<[u8]>>, Problem> {
        let mut known: HashMap<BufferKey<'_>, Arc<[u8]>> = HashMap::new();
        let mut all = Vec::with_capacity(buffers.len());
        for (index, buffer) in buffers.iter().enumerate() {
            let item = Item::named("buffer", index, buffer.name.as_deref());
            let bytes = match &buffer.uri {
                None => {
                    self.binary.clone().ok_or_else(|| item.invalid("has no URI, and the file has no binary chunk"))?
                }
                Some(uri) => match known.entry(self.key(uri)) {
                    Entry::Occupied(bytes) => Arc::clone(bytes.get()),
                    Entry::Vacant(entry) => Arc::clone(entry.insert(self.fetch(uri)?.into())),
                },
            };
            if (bytes.len() as u64) < buffer.byte_length {
                let stated = buffer.byte_length;
                return Err(item.invalid(format!("says that it has {stated} bytes, but has {}", bytes.len())));
            }
            all.push(bytes);
        }
        Ok(all)
    }

    /// How many bytes the file has, with its buffers; those that share a URI count once.
    pub(crate) fn size(&self, buffers: &[Arc<[u8]>]) -> u64 {
        let mut counted = HashSet::new();
        let distinct = buffers.iter().filter(|buffer| counted.insert(buffer.as_ptr()));
        self.json.len() as u64 + distinct.map(|buffer| buffer.len() as u64).sum::<u64>()
    }

    /// The files next to it that were read: buffers and images.
    pub(crate) fn files_read(&self) -> Vec<PathBuf> {
        self.read.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn key<'a>(&self, uri: &'a str) -> BufferKey<'a> {
        // Data is large, and is decoded only once.
        if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
            return BufferKey::Uri(uri);
        }
        match uri::resolve(uri) {
            Ok(Target::File(path)) => {
                let path = self.folder.as_ref().and_then(|folder| folder.join(path).canonicalize().ok());
                path.map_or(BufferKey::Uri(uri), BufferKey::File)
            }
            _ => BufferKey::Uri(uri),
        }
    }

    /// What a URI of this file stands for.
    pub(crate) fn fetch(&self, uri: &str) -> Result<Vec<u8>, Problem> {
        match uri::resolve(uri) {
            Ok(Target::Data(bytes)) => Ok(bytes),
            Ok(Target::File(path)) => {
                let missing = |error| Problem::Missing { uri: Quoted::new(uri), error };
                let no_folder = || missing(io::Error::other("a file in memory has no files next to it"));
                let path = self.folder.as_ref().ok_or_else(no_folder)?.join(path);
                let bytes = read(&path).map_err(missing)?;
                self.read.lock().unwrap_or_else(PoisonError::into_inner).push(path);
                Ok(bytes)
            }
            Err(reason) => Err(Problem::Uri { uri: Quoted::new(uri), reason }),
        }
    }
}

/// Where bytes come from. Equal keys stand for equal bytes.
#[derive(PartialEq, Eq, Hash)]
enum BufferKey<'a> {
    Uri(&'a str),
    /// The canonical path.
    File(PathBuf),
}

/// Reads a whole file, and only a file: a device or a pipe may have no end.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    let length = std::fs::metadata(path)?;
    if !length.is_file() {
        return Err(io::Error::other("it is not a file"));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(length.len()).unwrap_or(0));
    File::open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

type Chunks<'a> = (&'a [u8], Option<&'a [u8]>);

/// The JSON chunk and the binary chunk. Chunks after these are extensions and are skipped, as is
/// what follows the file.
fn chunks(file: &[u8]) -> Result<Chunks<'_>, &'static str> {
    let word = |at: usize| {
        let bytes = file.get(at..at + 4)?;
        Some(u32::from_le_bytes(bytes.try_into().expect("four bytes were taken")))
    };
    let (version, length) = word(4).zip(word(8)).ok_or("it ends within its header")?;
    if version != 2 {
        return Err("its version is not 2");
    }
    let file = file.get(..length as usize).ok_or("it is shorter than its header says")?;
    let chunk = |at: usize| -> Result<(u32, &[u8]), &'static str> {
        let header = file.get(at..at.saturating_add(8)).ok_or("it ends within the header of a chunk")?;
        let size = u32::from_le_bytes([header[0], header[1], header[2], header[3]]) as usize;
        let kind = u32::from_le_bytes([header[4], header[5], header[6], header[7]]);
        let end = (at + 8).checked_add(size).ok_or("a chunk is too long")?;
        Ok((kind, file.get(at + 8..end).ok_or("it ends within a chunk")?))
    };
    const JSON: u32 = u32::from_le_bytes(*b"JSON");
    const BINARY: u32 = u32::from_le_bytes(*b"BIN\0");
    let (kind, json) = chunk(12)?;
    if kind != JSON {
        return Err("its first chunk is not JSON");
    }
    let second = 20 + json.len();
    if second >= file.len() {
        return Ok((json, None));
    }
    let (kind, bytes) = chunk(second)?;
    Ok((json, (kind == BINARY).then_some(bytes)))
}
