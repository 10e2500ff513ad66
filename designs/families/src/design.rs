//! A sensor as it is built, and the files beside those of its parts.

use std::any::Any;
use std::fmt;
use std::sync::{Arc, LazyLock};

use fabkit_geometry::Sensor;
use fabkit_text::Setting;

use crate::buying::Articles;
use crate::materials::Castable;

/// A sensor built from validated parameters.
#[derive(Clone, Debug)]
pub struct Design {
    /// The family that read the files.
    pub family: &'static str,
    /// The parts, layers and components.
    pub sensor: Sensor,
    /// Every parameter in the order of the schema, with value and source.
    pub parameters: Vec<Setting>,
    /// What follows from the parameters: name, value with unit; for `fabkit show`.
    pub derived: Vec<(String, String)>,
    /// The materials that are cast, in the order of the parameters that name them.
    pub materials: Vec<Castable>,
    /// Files that belong to the design besides those of its parts.
    pub companions: Vec<Companion>,
    /// What may be bought, as fabkit and the user's files list it.
    pub articles: Articles,
}

/// A file beside those of the parts, such as a list of landmarks; written with every export.
///
/// Whoever makes one from a document of a type of their own hands that on too. So nobody within the
/// process reads a file again, or finds it by its name, and designs need not know what fixtures have.
#[derive(Clone)]
pub struct Companion {
    /// File name, for example `pin-dome.landmarks.json`.
    pub name: String,
    bytes: Bytes,
    document: Option<Arc<dyn Any + Send + Sync>>,
}

/// Worked out when somebody wants them, once for all copies.
type Bytes = Arc<LazyLock<Vec<u8>, Box<dyn FnOnce() -> Vec<u8> + Send>>>;

impl fmt::Debug for Companion {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("Companion").field("name", &self.name).finish_non_exhaustive()
    }
}

/// As files: what a file says follows from its bytes.
impl PartialEq for Companion {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.bytes() == other.bytes()
    }
}

impl Eq for Companion {}

impl Companion {
    /// A file for people and other programs.
    pub fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        let bytes = bytes.into();
        Self::later(name, move || bytes)
    }

    /// One whose bytes take long, for those who build a design and write no file. They are worked out while other
    /// threads may wait for them: not in parallel, or these could be the threads that wait.
    pub fn later(
        name: impl Into<String>,
        bytes: impl FnOnce() -> Vec<u8> + Send + 'static,
    ) -> Self {
        let bytes: Box<dyn FnOnce() -> Vec<u8> + Send> = Box::new(bytes);
        Self { name: name.into(), bytes: Arc::new(LazyLock::new(bytes)), document: None }
    }

    /// What is in it.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The same with what it says.
    #[must_use]
    pub fn of<T: Any + Send + Sync>(self, document: T) -> Self {
        Self { document: Some(Arc::new(document)), ..self }
    }

    /// What it says, if that is a document of this type.
    pub fn document<T: Any>(&self) -> Option<&T> {
        self.document.as_deref()?.downcast_ref()
    }
}

impl Design {
    /// The documents of a type among its companions, in their order.
    pub fn documents<T: Any>(&self) -> impl Iterator<Item = &T> {
        self.companions.iter().filter_map(Companion::document)
    }
}
