//! Ordering and slicing advice attached to a body.

use crate::{Body, BodyKind, Order};

impl Body {
    /// Sets the order (article, size, manufacturer) of a bought body.
    #[must_use]
    pub fn with_order(self, order: Order) -> Self {
        debug_assert!(self.kind == BodyKind::Bought, "{} is not bought", self.name);
        Self { order: Some(order), ..self }
    }
}

/// Slicer settings that come from the notes on a printed part.
impl Body {
    /// Sets the layer height to print with, mm.
    #[must_use]
    pub fn in_layers(mut self, layer_mm: f64) -> Self {
        self.slicing.layer_mm = Some(layer_mm);
        self
    }

    /// Sets whether to print with supports; `false` means deliberately without.
    #[must_use]
    pub fn with_supports(mut self, supports: bool) -> Self {
        self.slicing.supports = Some(supports);
        self
    }

    /// Sets the width of the brim to print on, mm.
    #[must_use]
    pub fn on_brim(mut self, brim_mm: f64) -> Self {
        self.slicing.brim_mm = Some(brim_mm);
        self
    }
}
