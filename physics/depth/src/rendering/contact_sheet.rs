//! Contact sheets: several images in one.

use super::{RenderError, RenderedImage, shade};

/// Lays images out in a grid, row by row, each centred in a cell of the largest one's size, with `gap_px` between the
/// cells and around them.
///
/// # Errors
/// No images, no columns, or a sheet above [`super::MAX_PIXELS`].
///
/// ```
/// use fabkit_depth::{RenderedImage, contact_sheet};
///
/// // Three images in two columns: cells as large as the largest of them, 4 px between and around them.
/// let image = |width_px, height_px| RenderedImage::filled(width_px, height_px, [0; 3]);
/// let sheet = contact_sheet(&[image(20, 10)?, image(10, 10)?, image(10, 16)?], 2, 4)?;
/// assert_eq!((sheet.width_px, sheet.height_px), (4 + 20 + 4 + 20 + 4, 4 + 16 + 4 + 16 + 4));
/// # Ok::<(), fabkit_depth::RenderError>(())
/// ```
pub fn contact_sheet(
    images: &[RenderedImage],
    columns: usize,
    gap_px: u32,
) -> Result<RenderedImage, RenderError> {
    let columns = columns.min(images.len());
    if columns == 0 {
        return Err(RenderError::NothingToDraw);
    }
    let cell_width = images.iter().map(|p| p.width_px).max().unwrap_or(0);
    let cell_height = images.iter().map(|p| p.height_px).max().unwrap_or(0);
    let side = |cells: usize, cell: u32| {
        // Saturating, so that absurd sizes end as an error below.
        let gaps = (cells as u64 + 1).saturating_mul(u64::from(gap_px));
        (cells as u64).saturating_mul(u64::from(cell)).saturating_add(gaps)
    };
    let width = side(columns, cell_width);
    let height = side(images.len().div_ceil(columns), cell_height);
    let (Ok(width_px), Ok(height_px)) = (u32::try_from(width), u32::try_from(height)) else {
        return Err(RenderError::TooLarge { width_px: width, height_px: height });
    };

    let mut sheet = RenderedImage::blank(width_px, height_px, shade::PAPER)?;
    for (index, image) in images.iter().enumerate() {
        let column = (index % columns) as u32;
        let row = (index / columns) as u32;
        let x_px = gap_px + column * (cell_width + gap_px) + (cell_width - image.width_px) / 2;
        let y_px = gap_px + row * (cell_height + gap_px) + (cell_height - image.height_px) / 2;
        sheet.paste(&image.rgb, image.width_px, x_px, y_px);
    }
    Ok(sheet)
}
