//! What gives way to a press: the interface over the box's window, its channels, and the columns that they move.

use fabkit_geometry::{Grip, LiquidChannel, LiquidSkin, Path, PlaneSurface};

use super::channels::{Side, left_channels};
use super::display::shut_in_air_mm3;
use super::layers::channel_liquids;
use super::layout::Layout;
use super::parameters::SheetMold;

/// The interface as it is pressed.
///
/// Channels are numbered as in the display: those of the left side, then those of the right one.
pub fn skin(p: &SheetMold, layout: &Layout) -> LiquidSkin {
    let channels = left_channels(p);
    let channel = |(name, liquid)| LiquidChannel {
        name,
        liquid,
        width_mm: p.channels.width.mm(),
        height_mm: p.channels.height.mm(),
        cover_mm: p.channel_layer.roof.mm(),
        column_mm2: p.display.channel_width.mm() * p.display.sheet.mm(),
        column_mm: p.display.rest_length.mm(),
        air_mm3: shut_in_air_mm3(p),
    };
    let box_outline = Path::rectangle([0.0; 2], [2.0 * layout.wall_outer_mm; 2], 0.0);
    let touch = PlaneSurface {
        outline: Path::rectangle([0.0; 2], [p.channel_layer.side.mm(); 2], 0.0),
        top_z_mm: layout.touch_z_mm,
        foot_z_mm: layout.bond_z_mm,
        soft_mm: layout.touch_z_mm,
        grip: Grip {
            outline: box_outline,
            top_z_mm: layout.ceiling_z_mm,
            bottom_z_mm: layout.bottom_z_mm,
            clear_radius_mm: 0.0,
            key: None,
            threads: Vec::new(),
        },
    };
    LiquidSkin {
        touch: touch.into(),
        window_mm: [p.housing.window.mm(); 2],
        levels_mm: vec![0.0, layout.bond_z_mm, layout.channel_top_z_mm, layout.touch_z_mm],
        channels: Side::BOTH
            .into_iter()
            .flat_map(|side| channel_liquids(p, layout, &channels, side))
            .map(channel)
            .collect(),
    }
}
