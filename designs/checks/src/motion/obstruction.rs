//! Obstacles that keep bodies and tools from their places.

use fabkit_geometry::Vector3;

use super::path::Contact;
use crate::rule::Rule;

/// A piece that cannot reach its place.
pub(crate) struct Obstruction<'a> {
    /// [`Rule::Motion`], or [`Rule::Access`] if there is no room for its tool.
    pub(crate) rule: Rule,
    pub(crate) body: &'a str,
    pub(crate) obstacle: &'a str,
    pub(crate) tool: Option<&'a str>,
    /// Direction towards its place, if the path is straight.
    pub(crate) along: Option<Vector3<f64>>,
    pub(crate) contact: Contact,
}
