//! Design of a sensor, and the companion files beside those of its parts.

use std::any::Any;
use std::fmt;
use std::sync::{Arc, LazyLock};

use fabkit_geometry::Sensor;
use fabkit_text::Setting;

use crate::articles::Articles;
use crate::materials::Castable;

/// Sensor built from validated parameters.
///
/// ```
/// use fabkit_designs::parameters::SourceKind;
/// let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let design = fabkit_designs::load("rtac0.yaml", yaml, &[], &["fixtures"])?;
/// let radius = design.parameters.iter().find(|one| one.path == "surface.radius").ok_or("none")?;
/// assert_eq!(radius.value, "15 mm");
/// assert_eq!(radius.source.kind, SourceKind::Measured);
/// // Materials in the order of the file: the gel that fills the tube comes first.
/// assert_eq!(design.materials[0].material().name, "Smooth-On Solaris");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Design {
    /// Name of the family that read the files.
    pub family: &'static str,
    /// Parts, layers and components.
    pub sensor: Sensor,
    /// Every parameter in the order of the schema, with value and source.
    pub parameters: Vec<Setting>,
    /// Quantities derived from the parameters, for `fabkit show`: name, and value with unit.
    pub derived: Vec<(String, String)>,
    /// Cast materials, in the order of the parameters that name them.
    pub materials: Vec<Castable>,
    /// Files that belong to the design besides those of its parts.
    pub companions: Vec<Companion>,
    /// Articles that can be bought, from fabkit's lists and the user's files.
    pub articles: Articles,
}

/// File beside those of the parts, such as a list of landmarks; written with every export.
///
/// A companion may also carry the typed document that its bytes were written from. Code in this process then neither
/// parses the file again nor finds it by its name, and this crate need not know the types of other crates.
///
/// ```
/// use fabkit_designs::Companion;
/// let places_mm = [1.5, 2.5];
/// let file = Companion::new("places.json", "[1.5,2.5]").with_document(places_mm);
/// assert_eq!(file.bytes(), b"[1.5,2.5]");
/// assert_eq!(file.document::<[f64; 2]>(), Some(&places_mm));
/// assert_eq!(file.document::<String>(), None);
/// ```
#[derive(Clone)]
pub struct Companion {
    /// File name, for example `pin-dome.landmarks.json`.
    pub name: String,
    bytes: Bytes,
    document: Option<Arc<dyn Any + Send + Sync>>,
}

/// Bytes of a file, computed on first use, once for all clones.
type Bytes = Arc<LazyLock<Vec<u8>, Box<dyn FnOnce() -> Vec<u8> + Send>>>;

impl fmt::Debug for Companion {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("Companion").field("name", &self.name).finish_non_exhaustive()
    }
}

/// Compares as files: names and bytes. The document follows from the bytes.
impl PartialEq for Companion {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.bytes() == other.bytes()
    }
}

impl Eq for Companion {}

impl Companion {
    /// Creates a companion from its bytes.
    pub fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        let bytes = bytes.into();
        Self::lazy(name, move || bytes)
    }

    /// Creates a companion whose bytes are computed on first use, because that takes long and many callers build a
    /// design without writing files. `bytes` runs inside a lock that other threads may wait for, so it must not run in
    /// parallel: its workers could be the threads that wait.
    ///
    /// ```
    /// use fabkit_designs::Companion;
    /// // Nothing is computed for a design that nobody writes to files.
    /// let unused = Companion::lazy("unused.bin", || unreachable!());
    /// assert_eq!(unused.name, "unused.bin");
    /// ```
    pub fn lazy(name: impl Into<String>, bytes: impl FnOnce() -> Vec<u8> + Send + 'static) -> Self {
        let bytes: Box<dyn FnOnce() -> Vec<u8> + Send> = Box::new(bytes);
        Self { name: name.into(), bytes: Arc::new(LazyLock::new(bytes)), document: None }
    }

    /// Returns the content of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Attaches the typed document that the file was written from.
    #[must_use]
    pub fn with_document<T: Any + Send + Sync>(self, document: T) -> Self {
        Self { document: Some(Arc::new(document)), ..self }
    }

    /// Returns the document if it is of type `T`.
    pub fn document<T: Any>(&self) -> Option<&T> {
        self.document.as_deref()?.downcast_ref()
    }
}

impl Design {
    /// Returns the documents of type `T` among the companions, in their order.
    pub fn documents<T: Any>(&self) -> impl Iterator<Item = &T> {
        self.companions.iter().filter_map(Companion::document)
    }
}
