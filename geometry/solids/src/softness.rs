//! Which bodies give way when a sensor is touched.

use crate::{Body, BodyKind, MaterialClass, Shore};

impl Body {
    /// Returns whether the body has to give way when the sensor is touched: it is cast or marked as deformable, and
    /// neither a liquid nor known to be as hard as plastic.
    pub fn gives_way(&self) -> bool {
        let is_stiff = self.substance.class == Some(MaterialClass::Liquid)
            || matches!(self.substance.shore, Some(Shore::D(_)));
        (self.kind == BodyKind::Cast || self.is_deformable) && !is_stiff
    }
}
