//! Files beside those of the parts.

use std::any::Any;
use std::sync::Arc;

use crate::Design;

/// A file beside those of the parts, such as a list of landmarks; written with every export.
///
/// Whoever makes one from a document of a type of their own hands that on too. So nobody within the
/// process reads a file again, or finds it by its name, and designs need not know what fixtures have.
#[derive(Clone, Debug)]
pub struct Companion {
    /// File name, for example `pin-dome.landmarks.json`.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
    document: Option<Arc<dyn Any + Send + Sync>>,
}

/// As files: what a file says follows from its bytes.
impl PartialEq for Companion {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.bytes == other.bytes
    }
}

impl Eq for Companion {}

impl Companion {
    /// A file for people and other programs.
    pub fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name: name.into(), bytes: bytes.into(), document: None }
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
