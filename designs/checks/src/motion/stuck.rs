//! What keeps bodies and tools from their places.

use fabkit_geometry::Vector3;

use super::path::Contact;
use crate::rule::Rule;

/// A piece that does not get to its place.
pub(crate) struct Stuck<'a> {
    /// [`Rule::Motion`], or [`Rule::Access`] where there is no room for its tool.
    pub(crate) rule: Rule,
    pub(crate) body: &'a str,
    pub(crate) by: &'a str,
    pub(crate) tool: Option<&'a str>,
    /// Which way it would go, to its place.
    pub(crate) along: Option<Vector3<f64>>,
    pub(crate) contact: Contact,
}
