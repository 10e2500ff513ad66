//! What a body says to who buys it or slices it.

use crate::{Body, Kind, Order};

impl Body {
    /// What to ask a shop for, where it is bought.
    #[must_use]
    pub fn ordered(self, order: Order) -> Self {
        debug_assert!(self.kind == Kind::Bought, "{} is not bought", self.name);
        Self { order: Some(order), ..self }
    }
}

/// What notes of a part tell the slicer, too.
impl Body {
    /// Printed in layers of this height, mm.
    #[must_use]
    pub fn in_layers(mut self, layer_mm: f64) -> Self {
        self.slicing.layer_mm = Some(layer_mm);
        self
    }

    /// Printed with supports, or on purpose without.
    #[must_use]
    pub fn with_supports(mut self, supports: bool) -> Self {
        self.slicing.supports = Some(supports);
        self
    }

    /// Printed on a brim of this width, mm.
    #[must_use]
    pub fn on_brim(mut self, brim_mm: f64) -> Self {
        self.slicing.brim_mm = Some(brim_mm);
        self
    }
}
